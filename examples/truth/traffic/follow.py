"""reactive_agent.following.*, vru_invasion.same_direction and safety.near_miss, from the simulator's leader and surrogate measures.

The leader that SUMO tells may be a vehicle that will cross or join (a link leader); here only one counts that is on a lane which the ego
itself then drives, or in its lane.
"""

import math
from collections import defaultdict

from log import Way, runs, turn_deg


def leads(run, ego):
    """By time: (leader, gap) of the one in the ego's own way."""
    rows, out = run.rows[ego], {}
    keys = sorted(rows)
    lanes_ahead, j = {}, 0
    visits = []
    for k in keys:
        if not visits or visits[-1][0] != rows[k].lane:
            visits.append((rows[k].lane, k))
    for k in keys:
        o = rows[k]
        its = run.rows.get(o.leader, {}).get(k) if o.leader else None
        if its is None:
            continue
        own = {lane for lane, since in visits if since >= k and since < k + 300} | {o.lane}
        # Who has just left the ego's lane over the line into the junction and is near still is the head of its queue.
        if o.gap < 15 and its.lane.startswith(":") and came_from(run, o.leader, k) == o.lane:
            own.add(its.lane)
        same_way = abs(turn_deg(o.angle, its.angle)) < 60 or o.gap < 15
        if its.lane in own and same_way:
            out[k] = (o.leader, o.gap)
    return out


def lane_leads(run, ego):
    """By time: the nearest vehicle within 60 m in the ego's lane and the lanes into which it leads, wherever the ego goes."""
    on = defaultdict(lambda: defaultdict(list))
    for k in run.rows[ego]:
        for i, o in run.by_time[k]:
            if i != ego and not o.person and run.kind(i) != "bicycle":
                on[k][o.lane].append((o.pos, i))
    out = {}
    for k, o in run.rows[ego].items():
        ways, best = [(o.lane, -o.pos)], (60, "")
        while ways:
            lane, start = ways.pop()
            best = min([best] + [(start + pos, i) for pos, i in on[k][lane] if start + pos > 0])
            end = start + run.road.lanes[lane].length if lane in run.road.lanes else 99
            if end < 60:
                after = run.road.after.get(lane)
                ways += [(l.via or l.to_lane, end) for l in ([after] if after else run.road.out.get(lane, []))]
        if best[1]:
            out[k] = best[1]
    return out


def came_from(run, name, k):
    """The lane outside of junctions on which a vehicle was last."""
    rows = run.rows[name]
    while k in rows and rows[k].lane.startswith(":"):
        k -= 1
    return rows[k].lane if k in rows else None


def following(run, ego, lead):
    """Thresholds are the taxonomy's. steady: THW < 3 s, both over 3.5 m/s, within 1 m/s2 and 2 m/s, for 3 s (2.5 to 3.5 s: optional).
    follow_stop: the lead comes to a stand (0.3 m/s) within 15 m, the ego after it. follow_start: the standing lead starts, the ego after it within
    5 s. Twice and more within 60 s under 30 km/h, each time behind the lead: stop_and_go from the first stop to the last start, and its stops and starts are none.
    lead_sudden_brake: the lead slows at 3 m/s2 for 0.5 s while followed; creeping: 0.3 to 3.5 m/s for 5 s without a stand."""
    rows = run.rows[ego]
    changing = {k for c in run.changes if c.id == ego for k in range(c.k - 15, c.k + 16)}
    lead = {k: v for k, v in lead.items() if run.kind(v[0]) != "bicycle"}
    steady = {}
    for k, (name, gap) in lead.items():
        o, its = rows[k], run.rows[name][k]
        if gap < 3 * o.speed and o.speed > 3.5 and its.speed > 3.5 and abs(o.accel) < 1 and abs(o.speed - its.speed) < 2:
            steady.setdefault(name, []).append(k)
    for name, keys in steady.items():
        for a, b in runs(keys, gap=10):
            if b - a >= 22:
                part = [k for k in range(a, b + 1) if k in changing]
                yield run.entry("reactive_agent.following.steady", ego, a, a, b + 1, name, optional=b - a < 40 or len(part) > 0)
    # Who drives ahead in the lane as it goes on, though the ego turns or changes off it later: a driver behind does not know that.
    beyond = {}
    for k, name in lane_leads(run, ego).items():
        o, its = rows[k], run.rows[name][k]
        if k not in lead and o.speed > 3.5 and its.speed > 3.5 and abs(o.accel) < 1 and abs(o.speed - its.speed) < 2:
            beyond.setdefault(name, []).append(k)
    for name, keys in beyond.items():
        for a, b in runs(keys + steady.get(name, []), gap=10):
            if b - a >= 22:
                yield run.entry("reactive_agent.following.steady", ego, a, a, b + 1, name, optional=True)
    stands = [(a, b) for a, b in runs([k for k, o in rows.items() if o.speed < 0.3], gap=3)]
    queued = lambda k: k in lead and lead[k][1] < 30 and rows[k].speed < 30 / 3.6
    behind = lambda k: any(lead.get(u, (None, 99))[1] < 15 for u in (k, k + 5))
    stretch = []
    for a, b in stands:
        if stretch and behind(a) and behind(stretch[-1][0]) and all(queued(k) or queued(k - 15) for k in range(stretch[-1][1], a) if k in rows) and a - stretch[-1][1] <= 600:
            stretch[-1][1] = b
            stretch[-1][2] += 1
        else:
            stretch.append([a, b, 1])
    in_stretch = set()
    for a, b, n in stretch:
        if n >= 2:
            in_stretch |= set(range(a - 80, b + 10))
            moved = max((rows[k].speed for k in range(a, b) if k in rows), default=0)
            yield run.entry("reactive_agent.following.stop_and_go", ego, a, a, b, optional=n == 2 or moved < 1.0)
    for a, b in stands:
        name, gap = lead.get(a) or lead.get(a + 1) or (None, None)
        blurred = a in in_stretch or b - a < 3 or any(a - 30 < k < b + 30 for k in changing)
        if name and gap < 14 and a - 20 in rows:
            its = run.rows[name]
            # From the last stop of the lead before the ego's.
            u = a
            while u in its and its[u].speed < 0.3 and a - u < 100:
                u -= 1
            stopped = u + 1
            moving = any(w in its and its[w].speed > 2 for w in range(stopped - 150, stopped))
            hard = brakes_hard(its, stopped - 60, stopped)
            followed = lead.get(max(stopped - 10, min(rows)), (None,))[0] == name
            if stopped <= a and a - stopped <= 60 and stopped - 1 in its:
                if hard is None:
                    yield run.entry("reactive_agent.following.follow_stop", ego, stopped - 20, stopped, a + 10, name, optional=blurred or not moving or not followed or a - stopped > 50)
                else:
                    yield run.entry("reactive_agent.following.follow_stop", ego, stopped - 20, stopped, a + 10, name, optional=True)
            elif stopped <= a and moving:
                yield run.entry("reactive_agent.following.follow_stop", ego, stopped - 20, stopped, a + 10, name, optional=True)
        for name in sorted({c.id for c in run.changes if a - 30 < c.k < b + 30 and c.id != ego and c.id in {lead[k][0] for k in range(a - 30, b) if k in lead}}):
            yield run.entry("reactive_agent.following.follow_start", ego, b - 20, b, b + 30, name, optional=True)
        # The start that ends this stand.
        name, gap = lead.get(b - 5) or lead.get(b) or (None, None)
        if name and gap < 30:
            its = run.rows[name]
            starts = next((u for u in range(b + 5, max(a - 100, b - 80), -1) if u in its and u - 1 in its and its[u].speed >= 0.3 and its[u - 1].speed < 0.3), None)
            if starts is not None:
                stood = all(its[w].speed < 0.3 for w in range(starts - 12, starts) if w in its) and b - a >= 12 and starts - a >= 12
                away = any(w in rows and rows[w].speed > 1.2 for w in range(b, b + 70))
                at = lead.get(starts, (None, 99))
                # SUMO lets who stands slide into another lane: whom the ego then follows nobody can tell.
                slid = any(c.id == name and a - 30 < c.k < b + 30 for c in run.changes)
                sure = stood and away and b - starts < 45 and at[0] == name and at[1] < 14 and not blurred and not slid and b not in in_stretch
                yield run.entry("reactive_agent.following.follow_start", ego, starts - 20, starts, starts + 30, name, optional=not sure)
    for name in sorted({n for n, _ in lead.values()}):
        its = run.rows[name]
        keys = [k for k, (n, g) in lead.items() if n == name and (g < 3 * rows[k].speed or g < 15)]
        for a, b in runs(keys, gap=3):
            k, before = a + 10, -99
            while k <= b:
                if k in its and its[k].accel <= -2.7:
                    end = k
                    while end in its and its[end].accel <= -2.7:
                        end += 1
                    core = [u for u in range(k, end) if its[u].accel <= -3.0]
                    sure = len(core) >= 7 and min(its[u].accel for u in core) < -3.3 and its[core[0]].speed > 4 and rows[k].speed > 1.5 and k - a >= 12
                    # Braking again within 2 s is the same event.
                    again, before = core and core[0] - before < 20, end
                    if len(core) >= 2:
                        yield run.entry("reactive_agent.following.lead_sudden_brake", ego, core[0] - 20, core[0], core[0] + 30, name, optional=not sure or again)
                    k = end + 10
                k += 1
        # SUMO names the leader on the route that it has planned; whom else the ego was behind at another time, and who brakes near it now, it
        # leaves open.
        near = [k for k, o in its.items() if k in rows and k not in keys and o.accel <= -2.9 and math.hypot(o.x - rows[k].x, o.y - rows[k].y) < 45]
        for a, b in runs(near, gap=10):
            yield run.entry("reactive_agent.following.lead_sudden_brake", ego, a - 20, a, a + 30, name, optional=True)
        slow = [k for k, (n, g) in lead.items() if n == name and g < 15 and 0.3 <= rows[k].speed <= 3.5 and its[k].speed <= 4.5]
        for a, b in runs(slow, gap=4):
            near_stand = [k for k in range(a, b) if any(s - 40 <= k <= e + 40 for s, e in stands)]
            free = [k for k in range(a, b) if k not in set(near_stand)]
            for u, v in runs(free):
                if v - u >= 30:
                    yield run.entry("reactive_agent.following.creeping", ego, u, u, v, name, optional=v - u < 65 or len(runs(free)) > 1)


def brakes_hard(its, a, b):
    """First time between at which it has slowed at 3 m/s2 or more for 0.5 s; near that (2.7) counts too, so that the rest is plain."""
    for k in range(a, b):
        if all(u in its and its[u].accel <= -2.7 for u in range(k, k + 5)):
            return k
    return None


def near_misses(run, ego):
    """safety.near_miss: SUMO's own minimum TTC under 1.5 s behind a lead, at a DRAC over 3 m/s2 (PEERS.md), or PET under 1 s; only thresholds passed
    by 0.2 s, and 0.2 m/s2, are sure."""
    rows = run.rows[ego]
    for c in run.conflicts:
        if c.get("ego") != ego:
            continue
        for tag, sure, most in (("minTTC", 1.3, 1.5), ("PET", 0.8, 1.0)):
            m = c.find(tag)
            if m is None or m.get("value") in (None, "NA"):
                continue
            k, value = round(float(m.get("time")) * 10), float(m.get("value"))
            if k not in rows or value > most:
                continue
            follower = tag == "minTTC" and m.get("type") in ("2", "FOLLOWING_FOLLOWER")
            foe = run.rows.get(c.get("foe"), {}).get(k)
            # DRAC is the closing speed over twice the TTC.
            brakes_hard = follower and foe is not None and rows[k].speed - foe.speed > 2 * 3.2 * value
            yield run.entry("safety.near_miss.general", ego, k - 20, k, k + 20, c.get("foe"), optional=not (brakes_hard and value < sure and rows[k].speed > 3))


def riders_ahead(run, ego, lead):
    """vru_invasion.same_direction: SUMO's leader is a bicycle in the ego's own way, near enough to concern it (TTC < 5 s), and moving (over
    0.5 m/s: who stands, at a red light say, does not travel along the lane). Optional: one that moved into the lane within 5 s before (a cut-in as
    well); its setting off again, or the ego's, after a stop; another that rides on the ego's way without being the one that SUMO names."""
    rows = run.rows[ego]
    leaf = "reactive_agent.vru_invasion.same_direction"
    way = Way(run, ego)
    for name in sorted(i for i in run.rows if run.vehicle(i) and run.kind(i) == "bicycle"):
        its = run.rows[name]
        keys = [k for k, (n, g) in lead.items() if n == name and g < 40]
        for a, b in runs(keys, gap=5):
            concerns = [k for k in range(a, b) if k in lead and lead[k][0] == name and its[k].speed > 0.5 and ((rows[k].speed - its[k].speed) * 5 > lead[k][1] or lead[k][1] < 17)]
            first = concerns[0] if concerns else a
            came = any(c.id == name and first - 50 < c.k < first + 10 for c in run.changes)
            sure = concerns and b - a > 30 and not any(c.id == ego and abs(c.k - first) < 30 for c in run.changes) and rows[first].speed > 2 and not came
            yield run.entry(leaf, ego, first, first, b, name, optional=not sure)
            for who, least in ((rows, 0.3), (its, 0.5)):
                for _, start in runs([k for k in range(a, b) if k in who and who[k].speed < least], gap=5):
                    yield run.entry(leaf, ego, start, start, b, name, optional=True)
        near = [k for k in its if k in rows and k not in keys and its[k].speed > 0.5 and math.hypot(its[k].x - rows[k].x, its[k].y - rows[k].y) < 50]
        near = [k for k in near if 0 < way.ahead(run, name, k) < 50]
        for a, b in runs(near, gap=10):
            if b - a >= 10:
                yield run.entry(leaf, ego, a, a, b, name, optional=True)
