"""As leaves.py: classes about other vehicles that the ego follows, meets, or does not expect to do what they do."""

import math
from log import ANIMAL, DT, LARGE, THING, VRU, runs
from leaves import R, after, events, responds


def hard_braking(log):
    """3 m/s2 or more for 0.5 s or more: by the followed lead, or by another whose place bears on the ego (taxonomy)."""
    for i, track in log.tracks.items():
        if log.types[i] in VRU | ANIMAL | THING:
            continue
        for t0, t1 in runs(sorted(track), lambda t: track[t].a <= -3 and track[t].v * math.cos(track[t].psi) > 0):
            before = round(t0 - 0.5, 1)
            if t1 - t0 < 0.45 or before not in track or track[before].v < 3 or not 0 < log.gap(i, t0) < 50:
                continue
            if log.lead(t0) == i:
                followed = all(log.lead(u) == i for u in log.times if t0 - 1 <= u <= t0)
                if followed and (log.gap(i, t0) < 3 * log.ego[t0].v or log.gap(i, t0) < 15):
                    yield R + "following.lead_sudden_brake", t0, t0, t1, i
                    continue
            lanes = abs(log.lane_of(track[t0].d) - log.lane_of(log.ego[t0].d))
            if track[t0].d < 0 and lanes <= 1 and responds(log, t0, 3):
                yield R + "vehicle_abnormal.sudden_brake", t0, t0, t1, i


def reversing(log):
    for e in events(log, "reverses"):
        i, track = e["id"], log.tracks[e["id"]]
        back = [t for t in sorted(track) if track[t].v < 0 and t >= e["t"]]
        if back and math.hypot(track[back[0]].x - log.ego[back[0]].x, track[back[0]].y - log.ego[back[0]].y) < 30 and responds(log, back[0], 4):
            yield R + "vehicle_abnormal.reversing", back[0], back[0], back[-1], i


def cutouts(log):
    """The lead starts to leave the lane (sideways at over 0.1 m/s after the order) and what stood there comes into sight."""
    for e in events(log, "lead_leaves"):
        i, track = e["id"], log.tracks[e["id"]]
        times = sorted(track)
        key = next(t for t0, t in zip(times, times[1:]) if t >= e["t"] and (track[t].d - track[t0].d) / DT > 0.1)
        thing = e["obstacle"]
        seen = next((t for t in sorted(log.tracks[thing]) if t >= key and log.visible(thing, t, [i]) >= 0.2), None)
        if seen and responds(log, key, 5):
            yield R + "vehicle_abnormal.cutout_reveal", key, key, seen + 2, i


def abnormal(log):
    """Weaving: lines crossed to and fro twice in 10 s. The wrong way: towards the ego in a lane of its direction, within 50 m."""
    for e in events(log, "weaves"):
        i, track = e["id"], log.tracks[e["id"]]
        lane, half = log.road.lane(log.lane_of(log.ego[e["t"]].d)), log.road.width / 2
        side = lambda t: (track[t].d - lane) if abs(track[t].d - lane) + log.half(i, track[t])[1] > half else 0
        over = runs([t for t in sorted(track) if t >= e["t"]], lambda t: side(t) != 0 and log.gap(i, t) < 50)
        if len(over) >= 2 and responds(log, over[1][0], 3):
            yield R + "vehicle_abnormal.abnormal_motion", over[0][0], over[1][0], over[-1][1], i
    for e in events(log, "wrong_way"):
        i, track = e["id"], log.tracks[e["id"]]
        near = [t for t in sorted(track) if 0 < track[t].s - log.ego[t].s < 50 and track[t].d < 0 and log.ttc(i, t) < 5]
        if near and responds(log, near[0], 3):
            yield R + "vehicle_abnormal.abnormal_motion", near[0], near[0], near[-1], i


# ---- following


def steady(log):
    """Both speeds steady for 3 s or more: within 2 m/s of each other, ego within 1 m/s2, both over 3.5 m/s, THW under 3 s."""
    for i, track in log.tracks.items():
        def holds(t):
            e, o = log.ego[t], track[t]
            return (e.v > 3.5 and o.v > 3.5 and abs(e.v - o.v) < 2 and abs(e.a) < 1 and log.gap(i, t) < 3 * e.v and log.lead(t) == i)
        # A state seen in a frame lasts until the next. Whether 3 s are met within two frames, and whether a break of about 1 s parts two
        # stretches, is left open.
        parted, joined = runs(sorted(track), holds, 1.0 - DT), runs(sorted(track), holds, 1.0 + 2 * DT)
        for t0, t1 in parted + [r for r in joined if r not in parted]:
            lasts = t1 - t0 + DT
            if lasts >= 3 - 2.5 * DT:
                left_open = [t0, t1] not in parted or [t0, t1] not in joined or lasts < 3 + 2.5 * DT
                yield R + "following.steady", t0, t0, t1, i, left_open


def creeping(log):
    """0.3 to 3.5 m/s behind a lead for 5 s or more, without a halt."""
    for i, track in log.tracks.items():
        for t0, t1 in runs(sorted(track), lambda t: 0.3 <= log.ego[t].v <= 3.5 and track[t].v <= 4.5 and log.lead(t) == i and log.gap(i, t) < 15):
            halts = any(log.ego[u].v < 0.3 for u in log.times if t0 - 4 <= u <= t1 + 4)
            if t1 - t0 >= 5 and not halts:
                yield R + "following.creeping", t0, t0, t1, i


def queues(log):
    """Single stops and starts behind a lead; two and more within 60 s under 30 km/h are one stretch."""
    times = log.times
    stops = runs(times, lambda t: log.ego[t].v < 0.3, 0.35)
    stops = [(a, b) for a, b in stops if b - a >= 0.5]
    stretches, used = [], set()
    for k, (a, b) in enumerate(stops):
        lead = log.lead(a)
        if stretches and stretches[-1][-1] == k - 1 and a - stops[k - 1][1] < 60 and lead and all(
                log.ego[u].v < 30 / 3.6 and log.lead(u) for u in times if stops[k - 1][1] <= u <= a):
            stretches[-1].append(k)
        else:
            stretches.append([k])
    for ks in stretches:
        if len(ks) < 2 or not log.lead(stops[ks[0]][0]):
            continue
        used.update(ks)
        yield R + "following.stop_and_go", stops[ks[0]][0], stops[ks[0]][0], stops[ks[-1]][1], None
    for k, (a, b) in enumerate(stops):
        i = log.lead(a)
        if k in used or not i or log.gap(i, a) > 15:
            continue
        track = log.tracks[i]
        moved = [t for t in sorted(track) if a - 15 < t <= a + 0.05 and track[t].v > 2]
        hard = runs(sorted(track), lambda t: a - 8 < t < a and track[t].a <= -3)
        if moved and not any(q - p >= 0.45 for p, q in hard):
            stood = next((t for t in sorted(track) if t > moved[-1] and track[t].v < 0.3), None)
            slow = next(t for t in sorted(track) if t > moved[-1])
            if stood is not None:
                key = stood if stood <= a else slow
                yield R + "following.follow_stop", key, key, a + 1, i
        starts = [t for t in sorted(track) if a < t <= b + 0.05 and track[t].v >= 0.3 and all(track[u].v < 0.3 for u in after(log, t - 1, 0.95) if u in track)]
        if starts and b - starts[-1] < 5 and b - a > 1 and b < times[-1] - 1:
            yield R + "following.follow_start", starts[-1], starts[-1], b, i


# ---- meeting


def meetings(log):
    """Oncoming, close by when level, and the ego slows or moves out for it, as ordered (who else comes, the ego pays no heed to). The keyframe is the L1 default's fallback: less than 5 s
    until the two meet, by their speeds at that moment."""
    for i in (e["id"] for e in events(log, "meets")):
        track = log.tracks[i]
        times = sorted(track)
        level = [t for t0, t in zip(times, times[1:]) if track[t0].s > log.ego[t0].s >= 0 and track[t].s <= log.ego[t].s]
        if not level or math.cos(track[level[0]].psi) > -0.7 or track[level[0]].v < 0.5:
            continue
        t = level[0]
        clear = abs(track[t].d - log.ego[t].d) - log.half(i, track[t])[1] - log.size("ego")[1] / 2
        eta = lambda u: (track[u].s - log.ego[u].s) / (log.ego[u].v + track[u].v)
        key = next(u for u in times if eta(u) < 5 and track[u].s - log.ego[u].s < 80)
        d0 = log.ego[key].d
        out = [u for u in times if key <= u <= t and log.ego[u].d - d0 < -0.3]
        slow = [u for u in times if key <= u <= t and log.ego[u].a < -1]
        if not (out or slow) or clear > 2.5:
            continue
        where = [w for w in log.works if w[0] - 30 < track[t].s < w[1] + 30]
        parked = [o for o in log.tracks if o != i and t in log.tracks[o] and abs(log.tracks[o][t].v) < 0.1 and log.types[o] not in VRU
                  and abs(log.tracks[o][t].s - track[t].s) < 30]
        right = max([log.tracks[o][t].d + log.half(o, log.tracks[o][t])[1] for o in parked if log.tracks[o][t].d < log.ego[t].d], default=log.road.edge)
        left = min([log.tracks[o][t].d - log.half(o, log.tracks[o][t])[1] for o in parked if log.tracks[o][t].d > track[t].d], default=-log.road.edge)
        room = min(left, -log.road.edge) - max(right, log.road.edge)
        narrow = room < log.size(i)[1] + log.size("ego")[1] + 1.5
        if where:
            yield R + "passing.construction", key, key, t, i
        elif narrow and clear < 1.5:
            yield R + "passing.narrow_road", key, key, t, i
        elif log.types[i] in LARGE:
            yield R + "passing.large_vehicle", key, key, t, i
