"""As leaves.py: classes about what the ego sets out to do by the script's orders, and near misses."""

import math
from log import ANIMAL, DT, LARGE, VRU, runs
from leaves import P, after, events


def centred(log, t):
    return abs(log.ego[t].d - log.road.lane(log.lane_of(log.ego[t].d)))


def avoidances(log):
    """Round something that stands and reaches 0.2 m or more into the lane; and back. The keyframe is a deviation of 0.4 m."""
    escapes = [(e["t"] - 2, e["t"] + 30) for e in events(log, "changes_lane")]
    for i, track in log.tracks.items():
        if log.types[i] in VRU | ANIMAL or any(e["id"] == i for e in events(log, "lead_leaves", "reverses", "in_the_way")):
            continue
        times = sorted(track)
        passed = [t for t in times if track[t].s < log.ego[t].s]
        if not passed or any(abs(track[t].v) > 0.5 for t in times if passed[0] - 12 < t <= passed[0]) or abs(math.sin(track[times[0]].psi)) > 0.5:
            continue
        t = passed[0]
        lane = log.road.lane(log.lane_of(track[t].d))
        reach = log.road.width / 2 + log.half(i, track[t])[1] - abs(track[t].d - lane)
        if reach < 0.2 or track[t].d > 0 or any(a < t < b for a, b in escapes):
            continue
        near = [u for u in times if 0 < track[u].s - log.ego[u].s < 50 and u < t and centred(log, u) < 0.4]
        home = log.road.lane(log.lane_of(track[t].d))
        out = [u for u in times if u < t + 0.05 and abs(log.ego[u].d - home) > 0.4 and log.ego[u].v > 0.5]
        back = next((u for u in log.times if u > t and abs(log.ego[u].d - home) < 0.4), None)
        if out and back and back - t < 12:
            while len(out) > 1 and round(out[-1] - out[-2], 1) == DT:
                out.pop()
            over = any(abs(log.ego[u].d - home) + log.half("ego", log.ego[u])[1] > log.road.width / 2 for u in log.times if out[-1] <= u <= back)
            yield P + ("obstacle_avoidance.borrow_lane" if over else "obstacle_avoidance.in_lane"), out[-1] - 4, out[-1], back + 1, i
        elif not out and near and not any(log.ego[u].a < -1 for u in near):
            clear = abs(track[t].d - log.ego[t].d) - log.half(i, track[t])[1] - log.size("ego")[1] / 2
            if clear < 0.5:
                yield P + "obstacle_avoidance.ignore", near[0], near[0], t, i


def steering(log):
    """The order to steer hard; half a meter within the second after it starts to act, with under 2 s to the thing."""
    for e in events(log, "steers_hard"):
        t = e["t"]
        i = e.get("id") or next(f["id"] for f in reversed(events(log, "falls_down")) if f["t"] <= t)
        lane = log.ego[t].d
        moved = [u for u in log.times if u > t and abs(log.ego[u].d - lane) > 0.02][0]
        if any(log.ttc_course(i, u) < 2 for u in log.times if t - 1 <= u <= t and u in log.tracks[i]):
            end = next((u for u in log.times if u > t + 2 and abs(log.ego[u].d - lane) < 0.3), t + 3)
            yield "safety.emergency_maneuver.steering", moved - 2, moved, end, i


def near_misses(log):
    """TTC below 1.5 s at a DRAC over 3 m/s2 (PEERS.md), or PET below 1 s with somebody who crosses; the ego over 2 m/s, no AEB, nothing touched."""
    hard = [e["t"] for e in events(log, "steers_hard")]
    for i, track in log.tracks.items():
        times = sorted(track)
        # What just meets or just misses the definition is left open: 0.1 s of TTC, 0.2 m/s2 of DRAC, 0.3 m beside the way, less than 0.3 s, and what is that
        # near by its box's reach alone, not by the part of it that is in the way.
        loose = lambda t: log.ttc(i, t, 0.3) < 1.6 and log.drac(i, t, 0.3) > 2.8 and log.ego[t].v > 2
        sure = lambda t: (i, t, -0.1, log.gap_in_way(i, t, -0.1))
        critical = lambda t: log.ttc(*sure(t)) < 1.4 and log.drac(*sure(t)) > 3.2 and log.ego[t].v > 2
        for t0, t1 in runs(times, loose, 2.0):
            if any(abs(a - t0) < 4 for a in log.aeb) or any(abs(h - t0) < 2 for h in hard):
                continue
            firm = [t for t in times if t0 <= t <= t1 and critical(t)]
            key = min((t for t in times if t0 <= t <= t1), key=lambda t: log.ttc(i, t, 0.3))
            yield "safety.near_miss.general", t0, key, t1, i, len(firm) < 3
        if log.types[i] in VRU | ANIMAL and (m := pet(log, i)) and not any(critical(u) for u in times):
            yield "safety.near_miss.general", m - 1, m, m + 1, i


def pet(log, i):
    """When it leaves (or enters) the ego's swept strip less than 1 s before the ego's front comes (after its rear has gone)."""
    track = log.tracks[i]
    times = sorted(track)
    strip = log.size("ego")[1] / 2
    inside = [t for t in times if abs(log.off_path(i, t)) - log.half(i, track[t])[1] < strip and track[t].s > log.ego[t].s]
    if not inside or inside[-1] == times[-1] or abs(track[inside[-1]].v) < 0.3 or abs(math.sin(track[inside[-1]].psi)) < 0.5:
        return None
    left = inside[-1]
    place = track[left].s - log.half(i, track[left])[0]
    arrives = next((t for t in log.times if log.ego[t].s + log.size("ego")[0] / 2 > place), None)
    return left if arrives is not None and 0 < arrives - left < 1 and log.ego[arrives].v > 2 else None


def emergency_braking(log):
    """The bus tells; the object of least TTC decides the variant."""
    for t0, _ in runs(log.aeb, lambda t: True, 1.0):
        if not any(log.ego[u].a <= -4 for u in after(log, t0, 1.5)):
            continue
        i = min((i for i, tr in log.tracks.items() if t0 in tr), key=lambda i: log.ttc_course(i, t0))
        kind = "vru" if log.types[i] in VRU else "large_vehicle" if log.types[i] in LARGE else "vehicle"
        yield f"safety.aeb.{kind}", t0, t0, t0 + 2, i


def lane_changes(log):
    """By the script's own reasons. The range begins with the order, when the intention is formed, and ends when stable for 2 s."""
    leaf = {"escape": "escape", "overtake": "overtake", "speed": "efficiency", "route": "navigation"}
    for e in events(log, "changes_lane"):
        if e["reason"] not in leaf:
            continue
        t, d0 = e["t"], log.ego[e["t"]].d
        stable = next((u for u in log.times if u > t + 2 and abs(log.ego[u].d - d0) > 2 and centred(log, u) < 0.3
                       and all(abs(log.ego[w].d - log.ego[u].d) < 0.2 for w in after(log, u, 2))), t + 8)
        yield P + f"lane_change.{leaf[e['reason']]}", t, t, stable + 2, e.get("target")
    for e in events(log, "gives_up"):
        # Starts back: sideways at 0.1 m/s after the order.
        t = next(u for v, u in zip(log.times, log.times[1:]) if u >= e["t"] and abs(log.ego[u].d - log.ego[v].d) > 0.1 * DT)
        end = next((u for u in log.times if u > t + 1 and centred(log, u) < 0.3), t + 3)
        yield P + "lane_change.abort", t - 0.5, t - 0.5, end, None


def pulls_over(log):
    for e in events(log, "pulls_over"):
        stood = next(t for t in log.times if t > e["t"] and log.ego[t].v < 0.3)
        yield P + "pull_over.normal", e["t"], e["t"], stood + 1, None
