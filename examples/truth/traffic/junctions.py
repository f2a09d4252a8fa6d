"""Passages of junctions: turns, conflicts between vehicles (by the network's own table of foes), roundabouts.

A passage is a vehicle's run of internal lanes of one junction. Which way it goes is the network's `dir`, told apart again by the
simulator's headings, because the classes are defined by the heading added up.
"""

import math
from types import SimpleNamespace

from log import nearest_on, runs, turn_deg


def passages(run, name):
    """In order: junction, link (connection), first and last time in it (front bumper), and the heading gained."""
    rows, out, now = run.rows[name], [], None
    for k in sorted(rows):
        lane = rows[k].lane
        inside = lane.startswith(":") and not lane.rsplit("_", 1)[0].split("_")[-1].startswith(("w", "c"))
        junction = run.road.junction_of(lane) if inside else None
        if now and (junction is None or junction.id != now.junction.id):
            now.complete = True
            out.append(now)
            now = None
        if junction is not None:
            if now is None:
                link = run.road.via.get(lane)
                now = SimpleNamespace(junction=junction, link=link, first=k, last=k, complete=False, began=k - 1 in rows)
            now.last = k
    if now:
        out.append(now)
    for p in out:
        before, after = rows.get(p.first - 1, rows[p.first]), rows.get(p.last + 1, rows[p.last])
        p.turned = turn_deg(before.angle, after.angle)
    return [p for p in out if p.link is not None]


def way_points(run, name, k0, k1):
    rows = run.rows[name]
    return [(rows[k].x, rows[k].y) for k in range(k0, k1 + 1) if k in rows]


def inner_shape(run, link):
    """The way through the junction of a connection."""
    lane, points = link.via, []
    while lane and lane.startswith(":"):
        points += run.road.lanes[lane].shape
        after = run.road.after.get(lane)
        lane = after.via if after and after.via else None
    return points


def last_inner(run, link):
    """The last lane of a way through a junction: the one by which the junction's table names it."""
    lane = link.via
    while run.road.after.get(lane) and run.road.after[lane].via:
        lane = run.road.after[lane].via
    return lane


def meeting(run, a, b):
    """Distances along both ways to where they cross or join, m; None where they do not."""
    pa, pb = inner_shape(run, a), inner_shape(run, b)
    done_a = 0.0
    for (x1, y1, *_), (x2, y2, *_) in zip(pa, pa[1:]):
        done_b, la = 0.0, math.hypot(x2 - x1, y2 - y1)
        for (x3, y3, *_), (x4, y4, *_) in zip(pb, pb[1:]):
            lb = math.hypot(x4 - x3, y4 - y3)
            det = (x2 - x1) * (y4 - y3) - (y2 - y1) * (x4 - x3)
            if abs(det) > 1e-9:
                t = ((x3 - x1) * (y4 - y3) - (y3 - y1) * (x4 - x3)) / det
                u = ((x3 - x1) * (y2 - y1) - (y3 - y1) * (x2 - x1)) / det
                if 0 <= t <= 1 and 0 <= u <= 1:
                    return done_a + t * la, done_b + u * lb
            done_b += lb
        done_a += la
    if a.to == b.to:
        length = lambda p: sum(math.hypot(q[0] - o[0], q[1] - o[1]) for o, q in zip(p, p[1:]))
        return length(pa), length(pb)
    return None


def arrival(run, name, p, distance):
    """When the front is so far into the junction, in tenths (with fractions lost); None when that is beyond the log."""
    way = run.travelled(name)
    later = [k for k in way if k >= p.first and way[k] - way[p.first] >= distance]
    return min(later, default=None)


def conflicts(run, ego, p, others):
    """Vehicles whose way through the junction crosses or joins the ego's: (name, its passage, arrivals of both)."""
    own = last_inner(run, p.link)
    for name, q in others:
        if name == ego or q.junction.id != p.junction.id or abs(q.first - p.first) > 600:
            continue
        its = last_inner(run, q.link)
        if its not in p.junction.foes.get(own, ()):
            continue
        where = meeting(run, p.link, q.link)
        if where is None:
            continue
        a, b = arrival(run, ego, p, where[0]), arrival(run, name, q, where[1])
        if a is not None and b is not None:
            yield SimpleNamespace(name=name, passage=q, ego_k=a, other_k=b, apart=abs(a - b) / 10, must_yield=its in p.junction.yields.get(own, ()),
                                  other_yields=own in p.junction.yields.get(its, ()))


def kind_of_conflict(run, ego, p, c):
    """Which leaf: the two directions at the entries, and whether the ways lead to the same road."""
    rows, its = run.rows[ego], run.rows[c.name]
    facing = abs(turn_deg(rows[p.first].angle, its[c.passage.first].angle))
    same_exit = p.link.to == c.passage.link.to
    if p.junction.in_ring:
        # Taxonomy, cross_conflict: a circulating vehicle against an ego that enters a roundabout.
        return "cross_conflict" if c.passage.link.start in run.road.ring and p.link.start not in run.road.ring else "joins"
    from_beside = p.link.start == c.passage.link.start
    if from_beside:
        return None
    if p.turned > 45 and facing > 135 and c.passage.turned < 45:
        return "unprotected_left"
    if p.turned < -45 and same_exit and c.passage.turned > -45:
        return "right_vs_straight"
    if not same_exit:
        return "cross_conflict"
    return "joins"


def adjusts(run, name, k0, k1):
    """Slowing by more than 1 m/s2 (the definition's threshold) or standing, at some time between."""
    rows = run.rows[name]
    least = min((rows[k].accel for k in range(k0, k1) if k in rows), default=0.0)
    slowest = min((rows[k].speed for k in range(k0, k1) if k in rows), default=99.0)
    return least, slowest


def turns_and_conflicts(run, ego, all_passages):
    """proactive.turn.* and reactive_agent.intersection_interaction.* of the junctions proper; a roundabout's are its own.

    - A turn with nobody in conflict (arrivals more than 7 s apart, no person within 5 s on the ego's way) is the turn; with somebody
      whom the ego waits for it is not; between the two it may be told or not (optional).
    - A left turn is optional while anybody who comes from opposite goes through within 7 s: that its lanes do not meet the ego's is the simulator's
      knowledge, a driver sees it come.
    - In the first 11 s of a log the light that it came from may not have been seen: optional.
    - left: protected where the link's light is `G` or no road comes from opposite; else unprotected.
    - straight: no entry when the ego stood within 3.5 s before, optional up to 8 s; optional where a leader within 3 s, a change of light or a slowing by
      1 m/s or more within 5 s before made it adjust.
    - An interaction is sure where the ego has to yield (the network's table of right of way) and stands for the other, on green where
      there is a light, at the line or inside, while it goes through, and arrives less than 4 s after it (a left turn: at any time). Without
      that, up to 12 s, it is optional: that somebody slowed before turning says nothing of why.
    """
    rows = run.rows[ego]
    for p in all_passages[ego]:
        if not p.junction.real:
            continue
        entry, out = run.centre_k(ego, p.first), run.centre_k(ego, p.last)
        met = list(conflicts(run, ego, p, [(n, q) for n, ps in all_passages.items() for q in ps]))
        sure = False
        for c in met:
            leaf = kind_of_conflict(run, ego, p, c)
            # Waiting for it: standing, not for its own red light, while the other goes through.
            at = rows.get(c.other_k - 5)
            free_to_go = at is not None and (at.lane.startswith(":") or not p.link.tl or run.light(p.link, at.k)[0] in "Gg")
            waits = c.must_yield and c.other_k <= c.ego_k and at is not None and at.speed < 1 and p.first - 400 < at.k and free_to_go
            waits = waits and (at.lane.startswith(":") or run.road.lanes[p.link.lane].length - at.pos < 8 and at.lane == p.link.lane)
            if leaf is None or run.kind(c.name) == "bicycle" or c.apart > 12 and not waits:
                continue
            first = min(p.first, c.ego_k - 60)
            own_least, own_slow = adjusts(run, ego, first, c.ego_k)
            its_least, its_slow = adjusts(run, c.name, min(c.passage.first, c.other_k - 60), c.other_k)
            required = waits and (c.apart < 4 or leaf == "unprotected_left") and leaf != "joins" and p.complete and p.began
            sure |= required or c.apart < 5
            options = [leaf] if required else ["unprotected_left", "right_vs_straight", "cross_conflict"]
            for each in options:
                yield run.entry(f"reactive_agent.intersection_interaction.{each}", ego, p.first, p.first, out, c.name, optional=not required)
        if p.junction.in_ring:
            continue
        near = sure or any(c.apart < 7 for c in met) or oncoming(run, ego, p, all_passages)
        if abs(p.turned) < 45:
            leaf = "straight"
            before = [rows[k] for k in range(entry - 50, entry) if k in rows]
            if not before:
                continue
            stood = max((k for k in range(entry - 80, entry) if k in rows and rows[k].speed < 0.3), default=None)
            if stood is not None:
                # 5 s is about the limit.
                if entry - stood > 35:
                    yield run.entry("proactive.turn.straight", ego, entry - 30, entry, out + 20, optional=True)
                continue
            led = any(o.leader and o.gap < 3 * o.speed for o in before)
            state = run.light(p.link, entry)
            fresh = state is not None and (state[0] not in "Gg" or entry - state[1] < 80)
            slowed = max(o.speed for o in before) - before[-1].speed >= 1 or max(o.speed for o in before) - min(o.speed for o in before) >= 2
            yield run.entry("proactive.turn.straight", ego, entry - 30, entry, out + 20, optional=led or fresh or slowed or near)
            continue
        if abs(p.turned) > 135:
            leaf = "uturn"
        elif p.turned < 0:
            leaf = "right_normal"
        else:
            opposite = any(abs(turn_deg(rows[p.first].angle, q_angle(run, l))) > 135 for l in p.junction.incoming if not l.startswith(p.link.start))
            state = run.light(p.link, p.first)
            leaf = "left_normal" if not opposite or (state and state[0] == "G") else "left_unprotected"
        base = rows[max(min(rows), p.first - 1)].angle
        starts = next((k for k in range(p.first, p.last + 1) if k in rows and abs(turn_deg(base, rows[k].angle)) > 1), p.first)
        people = any(o.person and math.hypot(o.x - rows[k].x, o.y - rows[k].y) < 12 for k in range(p.first, p.last, 5) for _, o in run.by_time[k] if k in rows)
        yield run.entry(f"proactive.turn.{leaf}", ego, entry - 30, starts - 5, out + 20, optional=near or people or not p.complete or not p.began or p.first - min(rows) < 110)


def oncoming(run, ego, p, all_passages):
    """Whether somebody from opposite is in the junction within 7 s of a left turn of the ego's through it."""
    if p.turned < 45:
        return False
    facing = lambda n, q: abs(turn_deg(run.rows[ego][p.first].angle, run.rows[n][q.first].angle)) > 135
    return any(n != ego and q.junction.id == p.junction.id and q.first - 70 < p.last and q.last + 70 > p.first and facing(n, q)
               for n, ps in all_passages.items() for q in ps)


def q_angle(run, lane):
    """Heading at the end of an incoming lane, as SUMO's angle."""
    (ax, ay, *_), (bx, by, *_) = run.road.lanes[lane].shape[-2:]
    return math.degrees(math.atan2(bx - ax, by - ay)) % 360


def roundabouts(run, ego, all_passages):
    """proactive.roundabout.*: entry from 30 m before the ring until all of the ego is in it; exit from its right indicator inside (else
    3 s before it leaves) until all of it is out; a change of lane inside makes lane_in_roundabout from entry to exit."""
    rows, way = run.rows[ego], run.travelled(ego)
    inside = lambda o: o.lane.rsplit("_", 1)[0] in run.road.ring or (o.lane.startswith(":") and run.road.junction_of(o.lane).in_ring)
    for first, last in runs([k for k, o in rows.items() if inside(o)]):
        # The ring proper, without the joints at both ends.
        proper = [k for k in range(first, last + 1) if rows[k].lane.rsplit("_", 1)[0] in run.road.ring]
        if not proper:
            continue
        began, complete = first - 1 in rows, last + 1 in rows
        full = lambda k: min((u for u in way if u >= k and way[u] - way[k] >= run.length(ego)), default=max(way))
        into, leaving = run.centre_k(ego, first), run.centre_k(ego, last)
        if began:
            start = next((k for k in sorted(way) if way[first] + run.length(ego) / 2 - way[k] <= 30), first)
            yield run.entry("proactive.roundabout.entry", ego, start, start, full(first))
        if complete:
            out = leaving
            signalled = [k for k in range(proper[-1] - 60, last + 1) if k in rows and k >= first and rows[k].signals & 1]
            start = max(out - 30, signalled[0]) if signalled else out - 30
            yield run.entry("proactive.roundabout.exit", ego, start, start, full(last))
        shifts = [c for c in run.changes if c.id == ego and first <= c.k <= last and c.start.rsplit("_", 1)[0] in run.road.ring]
        if shifts and began:
            yield run.entry("proactive.roundabout.lane_in_roundabout", ego, into, into, leaving if complete else last)
