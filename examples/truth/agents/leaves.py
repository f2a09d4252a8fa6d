"""When each class holds in a drive, by the words of TAXONOMY.md, LABELING.md and the definitions in schema/scenario_taxonomy.yaml, from
what the script ordered and how everybody moved. A function yields (leaf, start, keyframe, end, target), times in s. Where several
classes are true of one moment, all are yielded: the evaluation takes secondary episodes for found, and so does this list."""

import math
from log import ANIMAL, DT, LARGE, THING, VRU, runs

R = "reactive_agent."
P = "proactive."


def after(log, t, seconds):
    return [u for u in log.times if t - 1e-6 <= u <= t + seconds + 1e-6]


def responds(log, t, within, brake=1.0, aside=0.3, waits=1.0):
    """The ego slows by more than `brake`, stands, or shifts by more than `aside` within so many seconds."""
    d0 = log.ego[t].d
    return any(log.ego[u].a < -brake or log.ego[u].v < waits or abs(log.ego[u].d - d0) > aside for u in after(log, t, within))


def events(log, *what):
    return [e for e in log.events if e["what"] in what]


# ---- other vehicles come into the lane


def cutins(log):
    """A wheel over the line of the ego's lane, from outside, ahead, moving in; then the lead (taxonomy, L2 cutin)."""
    half = log.road.width / 2
    congested = [(e["t"], f["t"]) for e, f in zip(events(log, "queue_begins"), events(log, "queue_ends"))]
    for i, track in log.tracks.items():
        if log.types[i] in VRU | ANIMAL | THING:
            continue
        over = lambda t: half - (abs(track[t].d - log.road.lane(log.lane_of(log.ego[t].d))) - log.half(i, track[t])[1])
        times = sorted(track)
        for t0, t in zip(times, times[1:]):
            mine = log.lane_of(log.ego[t].d)
            if not over(t0) <= 0 < over(t) or log.lane_of(log.ego[t0].d) != mine or abs(track[t].psi) > math.radians(45):
                continue
            if track[t].v < 0.5 or log.gap(i, t) < 0 or log.gap(i, t) > 50 or not any(log.lead(u) == i for u in after(log, t, 6) if u in track):
                continue
            if any(over(u) > 0 for u in times if t - 3 < u < t - 0.05):
                continue
            ego = log.ego
            near = [u for u in log.times if abs(u - t) <= 3 and u in track]
            if not any(log.ttc(i, u) < 5 or 0 <= log.gap(i, u) < 2 * ego[u].v for u in near):
                continue
            closing = ego[t].v - track[t].v * math.cos(track[t].psi)
            ttc = log.gap(i, t) / closing if closing > 0 else math.inf
            lane = log.road.lane(mine)
            end = next((u for u in times if u > t and abs(track[u].d - lane) < 0.5), t + 3)
            signal = [u for u in times if u <= t and track[u].signals & 3]
            early = min(signal[0], t - 5) if signal else t - 2
            urgent = ttc < 3
            yield R + ("cutin.urgent" if urgent else "cutin.slow"), t - 2 if urgent else min([t - 5, *signal[:1]]), t, end, i
            if log.types[i] in LARGE:
                yield R + "cutin.large_vehicle", early, t, end, i
            stood = [u for u in times if t - 10 <= u <= t and track[u].v < 0.3]
            if len(stood) >= 10:
                yield R + "cutin.from_stationary", stood[-1] + DT, t, end, i
            # From the lane of a ramp onto the main road.
            if any(a <= track[t].s <= a + 180 for a in log.ramps) and track[t].d < lane and mine > 0:
                yield R + "cutin.ramp", early, t, end, i
            if any(a < t - 30 and t < b for a, b in congested):
                yield R + "cutin.congestion", early, t, end, i


# ---- people and animals


def band_entry(log, i, t):
    """Since when, without a break, it has been within 7 m of the path and 50 m ahead, at t."""
    times = [u for u in sorted(log.tracks[i]) if u <= t]
    inside = lambda u: abs(log.off_path(i, u)) < 7 and 0 < log.tracks[i][u].s - log.ego[u].s < 50
    while len(times) > 1 and inside(times[-2]):
        times.pop()
    return times[-1]


def moves_across(log, i):
    """Stretches in which it moves at 20 degrees or more across the road, at over 0.5 m/s."""
    track = log.tracks[i]
    return runs(sorted(track), lambda t: abs(track[t].v) > 0.5 and abs(math.sin(track[t].psi)) > math.sin(math.radians(20)))


def crossings(log):
    """People and animals that cross the ego's path ahead of it, and to whom it responds."""
    for i, track in log.tracks.items():
        animal = log.types[i] in ANIMAL
        if not animal and log.types[i] not in VRU:
            continue
        for t0, t1 in moves_across(log, i):
            times = [t for t in sorted(track) if t0 <= t <= t1]
            on = [t for t in times if abs(log.off_path(i, t)) < 1.5 and 0 < track[t].s - log.ego[t].s < 50]
            if not on:
                continue
            lane = [log.road.lane(log.lane_of(log.path_d(track[t].s))) for t in times]
            stays = [t for t in sorted(track) if t > t1 and abs(track[t].d - lane[-1]) < log.road.width / 2 and t < t1 + 3]
            # It comes from beside the path, and does not stay in the lane or stand there (vru_invasion, animal.on_road).
            if abs(log.off_path(i, t0)) < 1.5 or len(stays) > 20:
                continue
            # Enters the band; or was within it before it stepped off, which then is the external event.
            inside = [t for t in times if abs(log.off_path(i, t)) < 7 and 0 < track[t].s - log.ego[t].s < 50 and t <= on[-1]]
            key = inside[0]
            hidden = emergence(log, i)
            if hidden:
                key = max(key, hidden[0])
            if not any(log.ego[u].a < -1 or log.ego[u].v < 5 / 3.6 for u in log.times if key <= u <= on[-1] + 0.5):
                continue
            angle = math.degrees(math.asin(min(1, abs(math.sin(track[on[0]].psi)))))
            end = next((t for t in times if t > on[-1]), on[-1])
            at = [c for c in log.crosswalks if abs(track[on[0]].s - c) < 3]
            if animal:
                if angle >= 30:
                    yield R + "animal.crossing", key, key, end, i
            else:
                kind = "crosswalk" if at else "horizontal" if angle >= 60 else "diagonal"
                yield R + f"vru_crossing.{kind}", key, key, end, i


def emergence(log, i):
    """(first sight, static or dynamic) where it was hidden for a second before, near the path, with less than 4 s for the ego."""
    for e in events(log, "steps_out"):
        if e["id"] != i:
            continue
        track = log.tracks[i]
        times = sorted(track)
        boxes = [o for o in log.tracks if o != i and log.types[o] not in VRU | ANIMAL]
        hidden = 0
        for t in times:
            near = [o for o in boxes if t in log.tracks[o] and abs(log.tracks[o][t].s - track[t].s) < 30]
            if log.visible(i, t, near + log.houses) < 0.1:
                hidden += 1
                continue
            if hidden >= 10 and t >= e["t"]:
                ego = log.ego[t]
                ahead = track[t].s - ego.s
                if abs(log.off_path(i, t)) < 7 and ahead < 33 and ahead / max(ego.v, 0.1) < 4 and responds(log, t, 2, 2.0):
                    # Just beyond the 30 m of the definition: left open.
                    return t, e["of"], ahead > 30
                return None
            hidden = 0
    return None


def emergences(log):
    for e in events(log, "steps_out"):
        i = e["id"]
        if found := emergence(log, i):
            t, of, open_ = found
            track = log.tracks[i]
            off = next((u for u in sorted(track) if u > t + 0.5 and (abs(log.off_path(i, u)) > 1.5 and track[u].d > log.path_d(track[u].s)) == (track[u].psi > 0)
                        and abs(log.off_path(i, u)) > 1.5), t + 3)
            yield R + f"vru_emergence.{of}_occlusion", t, t, off, i, open_


def invasions(log):
    """VRUs that take up the ego's lane lengthwise, by more than 0.3 m for a second or more (taxonomy, vru_invasion)."""
    for i, track in log.tracks.items():
        if log.types[i] not in VRU:
            continue
        line = log.road.width / 2
        def inside(t):
            return line - abs(track[t].d - log.road.lane(log.lane_of(log.path_d(track[t].s)))) + log.half(i, track[t])[1]
        holds = lambda t: (inside(t) > 0.3 and abs(math.sin(track[t].psi)) < 0.5 and abs(track[t].v) > 0.5
                           and 0 < track[t].s - log.ego[t].s < 50)
        for t0, t1 in runs(sorted(track), holds):
            if t1 - t0 < 1:
                continue
            near = [t for t in after(log, t0, t1 - t0) if t in track and (min(log.ttc(i, t), log.ttc_course(i, t)) < 5 or (abs(log.off_path(i, t)) - log.half(i, track[t])[1]
                    - log.size("ego")[1] / 2 < 1.5 and log.gap(i, t) < 15))]
            if not near:
                continue
            entered = [t for t in sorted(track) if t <= t0 and inside(t) <= 0 and track[t].s - log.ego[t].s < 50]
            if math.cos(track[t0].psi) < 0:
                yield R + "vru_invasion.opposite_direction", near[0], near[0], t1, i
            elif entered:
                key = entered[-1] + DT
                yield R + "vru_invasion.vru_cutin", key, key, t1, i
            else:
                yield R + "vru_invasion.same_direction", near[0], near[0], t1, i


def animals_on_road(log):
    """Stays on the carriageway in the ego's lane; the keyframe is the first moment of TTC < 5 s (L1 default) within 50 m."""
    for e in events(log, "in_the_way"):
        i, track = e["id"], log.tracks[e["id"]]
        near = [t for t in sorted(track) if log.ttc(i, t) < 5 and track[t].s - log.ego[t].s < 50]
        gone = next((f["t"] for f in events(log, "clears_off") if f["id"] == i), None)
        if near and responds(log, near[0], 3):
            yield R + "animal.on_road", near[0], near[0], gone or near[-1], i
