"""Changes of lane: the ego's own by the simulator's reason, other vehicles' into its lane as cut-ins, ramps, the bus lane.

The simulator logs a change at its middle; a change takes 3 s (`--lanechange.duration`), so the motion began 1.5 s before.
"""

import math

from log import Way, nearest_on, runs, turn_deg

HALF = 15


def intends(run, ego, c, mine):
    """When the ego formed the intention to change lane (LABELING.md 4, row lane_change): its indicator to that side went on and stayed on until it
    moved over. SUMO switches it on with the wish to change, before it can. Not longer ago than a clip lasts, nor before the end of the last of
    its changes (`mine`) or of a junction; at the latest where the motion begins. Where no indicator goes on before half of the way, the default
    of its L1: 2 s before it has moved 0.3 m.
    """
    rows, first = run.rows[ego], c.k - HALF
    old, new = run.road.lanes[c.start], run.road.lanes[c.to]
    bit = 2 if new.index > old.index else 1
    def crosses(o):
        # Roads that are only joined have an inner lane there, too.
        return o.lane.startswith(":") and ((j := run.road.junction_of(o.lane)).real or j.in_ring)
    earliest = max([first - 200, min(rows)] + [o.k + HALF for o in mine if o.k < c.k]
                   + [k + 1 for k in range(first - 200, first) if k in rows and crosses(rows[k])])
    on = next((k for k in range(first, c.k) if k in rows and rows[k].signals & bit), None)
    if on is None:
        moved = first + math.ceil(2 * HALF * 0.3 / ((old.width + new.width) / 2))
        return max(min(moved - 20, first), earliest)
    while on > earliest and on - 1 in rows and rows[on - 1].signals & bit:
        on -= 1
    return min(on, first)


def leads_off_in(run, ego, c):
    """How far ahead of the ego the lane that it leaves stops leading where it then drives, m; infinite where it never does before its trip ends,
    None where the log ends before that shows."""
    rows = run.rows[ego]
    edges = [c.start.rsplit("_", 1)[0]]
    for k in sorted(rows):
        edge = rows[k].lane.rsplit("_", 1)[0]
        if k > c.k and not edge.startswith(":") and edge != edges[-1]:
            edges.append(edge)
    lanes, distance = {c.start}, run.road.lanes[c.start].length - rows[c.k].pos
    for there in edges[1:]:
        lanes = {l.to_lane for lane in lanes for l in run.road.out[lane] if l.to == there}
        if not lanes:
            return distance
        distance += run.road.lanes[min(lanes)].length
    return math.inf if max(rows) < run.last else None


def own_changes(run, ego):
    """proactive.lane_change.*, special_lane.bus_lane and, over ramps, merge_interaction.*

    `strategic` is for the route: navigation, when the lane that it leaves leads away from the route within 500 m (`leads_off_in`), which is where
    the last sign before an exit or a lane's end stands; the simulator plans kilometers ahead, which nobody sees: optional, as is a reason that lies
    beyond the log's end. Onto or off an acceleration or deceleration lane it is a merge or an exit. `speedGain` is overtake when the vehicle
    that was ahead in the old lane is behind 30 s later at most, escape when the ego had stood behind a standing vehicle, else efficiency. `keepRight` and `cooperative` are no reason that a leaf names: the L2. What a second change within 4 s makes of the
    first, or a change at a standstill, nobody can see: optional.
    """
    rows = run.rows[ego]
    mine = [c for c in run.changes if c.id == ego and c.k in rows]
    for i, c in enumerate(mine):
        start, end = c.k - HALF, c.k + HALF
        intent = intends(run, ego, c, mine)
        edge = run.road.edges[c.start.rsplit("_", 1)[0]]
        if edge.function != "normal":
            # Inside a junction: two lanes side by side through it; whether that is a change is not defined.
            for leaf in ("", ".navigation", ".efficiency", ".overtake"):
                yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
            continue
        if rows[c.k].speed < 2:
            # A car that stands slides sideways in SUMO; a log sees the change when it moves off.
            moves = next((k for k in range(c.k, max(rows)) if k in rows and rows[k].speed > 1), c.k)
            for leaf in ("proactive.lane_change", "proactive.lane_change.escape", "proactive.lane_change.efficiency", "reactive_rule.special_lane.bus_lane"):
                yield run.entry(leaf, ego, moves - 20, moves - 5, moves + 20, optional=True)
        if edge.id in run.road.ring:
            # A change in a ring is lane_in_roundabout; what else it is stays secondary.
            for leaf in ("", ".navigation", ".efficiency", ".overtake"):
                yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
            continue
        blurred = any(abs(o.k - c.k) < 40 for o in mine if o is not c) or rows[c.k].speed < 2 or start not in rows or end not in rows
        # Into the shorter queue at a light: passing or gaining, as one likes.
        queues = any(rows[k].speed < 1 for k in range(c.k, c.k + 60) if k in rows)
        near_end = run.road.lanes[c.start].length - rows[c.k].pos < 1.7 * rows[c.k].speed or rows[c.k].pos < 1.5 * rows[c.k].speed
        blurred |= near_end and run.road.junctions[edge.end].real
        old, new = run.road.lanes[c.start], run.road.lanes[c.to]
        if old.acceleration or is_exit_lane(run, new):
            # Joining and leaving are merge_interaction; the change itself stays secondary.
            for leaf in ("", ".navigation", ".efficiency", ".overtake"):
                yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
            continue
        if "bus" in old.allow or "bus" in new.allow:
            # Out of the bus lane or into it: its rule, keyframe 0.5 s before the ego moves across (the L1 default's fallback).
            yield run.entry("reactive_rule.special_lane.bus_lane", ego, start - 30, start - 5, start + 20, optional=blurred)
        reason = c.reason.split("|")[0]
        off = leads_off_in(run, ego, c)
        if blurred or reason == "strategic" and (off is None or off > 500):
            # That it changes lane is plain, why is not.
            for leaf in ("", ".navigation", ".efficiency", ".overtake", ".escape"):
                yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
        elif reason == "strategic" and any(l.to in run.road.ring for l in run.road.out[c.start] + run.road.out[c.to]):
            # Both lanes lead into the ring and round it: that one of them suits the route better is the simulator's own wish.
            for leaf in ("", ".navigation", ".efficiency", ".overtake"):
                yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
        elif reason == "strategic":
            yield run.entry("proactive.lane_change.navigation", ego, intent, intent, end + 10, optional=blurred)
        elif reason == "speedGain":
            before = rows.get(start - 5) or rows[c.k]
            lead = before.leader if before.leader in run.rows and before.gap < 60 and run.rows[before.leader].get(c.k) else None
            lead_in_lane = lead and run.rows[lead].get(start - 5) and run.rows[lead][start - 5].lane == c.start
            stood = all(rows[k].speed < 1 for k in range(start - 30, start) if k in rows)
            if queues:
                for leaf in ("", ".efficiency", ".overtake", ".escape"):
                    yield run.entry(f"proactive.lane_change{leaf}", ego, intent, intent, end + 10, optional=True)
            elif lead_in_lane and passes(run, ego, lead, c.k):
                yield run.entry("proactive.lane_change.overtake", ego, intent, intent, end + 10, lead, optional=blurred)
            elif lead_in_lane and not stood:
                gains = any(rows[k].speed > run.rows[lead][start - 5].speed + 5 / 3.6 for k in range(c.k, c.k + 150) if k in rows)
                yield run.entry("proactive.lane_change.efficiency", ego, intent, intent, end + 10, optional=blurred or not gains)
                if not gains:
                    yield run.entry("proactive.lane_change", ego, intent, intent, end + 10, optional=True)
            else:
                # What it gains on is not in view: the change is plain, its reason is not.
                yield run.entry("proactive.lane_change", ego, intent, intent, end + 10, optional=True)
                for leaf in ("efficiency", "overtake", "escape"):
                    yield run.entry(f"proactive.lane_change.{leaf}", ego, intent, intent, end + 10, optional=True)
        else:
            yield run.entry("proactive.lane_change", ego, intent, intent, end + 10, optional=blurred)


def passes(run, ego, lead, k0):
    """Whether the ego's front gets past the front of `lead` within 30 s, along the road (by the ego's heading)."""
    rows, its = run.rows[ego], run.rows[lead]
    for k in range(k0, k0 + 300):
        if k in rows and k in its:
            a = math.radians(rows[k].angle)
            if (its[k].x - rows[k].x) * math.sin(a) + (its[k].y - rows[k].y) * math.cos(a) < 0 and math.hypot(its[k].x - rows[k].x, its[k].y - rows[k].y) < 25:
                return True
    return False


def is_exit_lane(run, lane):
    """A lane beside through lanes that leads to a ramp only."""
    links = run.road.out[lane.id]
    return bool(links) and all(run.road.edges[l.to].kind.endswith("_link") for l in links)


def ramps(run, ego):
    """merge_interaction: normal_merge from the acceleration lane's first meter until the change off it is done; split_exit from the
    change into the deceleration lane (over the line) until the ego is on the ramp."""
    rows = run.rows[ego]
    on = lambda test: runs([k for k, o in rows.items() if not o.lane.startswith(":") and test(run.road.lanes[o.lane])])
    for first, last in on(lambda l: l.acceleration):
        off = next((c.k for c in run.changes if c.id == ego and c.k >= last), None)
        if off is None or first - 1 not in rows:
            continue
        yield run.entry("proactive.merge_interaction.normal_merge", ego, run.centre_k(ego, first), run.centre_k(ego, first), off + HALF)
    for first, last in on(lambda l: is_exit_lane(run, l)):
        came = next((c.k for c in run.changes if c.id == ego and abs(c.k - first) <= 1), None)
        if came is not None:
            yield run.entry("proactive.merge_interaction.split_exit", ego, came, came, run.centre_k(ego, last + 1))


def side_gap(run, lane, o, width):
    """How far the vehicle's nearer side is from the lane's edge, m; negative when over it."""
    d, _ = nearest_on(lane.shape, o.x, o.y)
    return d - width / 2 - lane.width / 2


def cut_ins(run, ego):
    """reactive_agent.cutin.*: another vehicle's change into the lane that the ego drives or, unless it changes lane itself, drives next, ahead of it.

    Keyframe: its side passes the line of that lane. Its heading is then within 45 degrees of the ego's (taxonomy, L2), its rear ahead of the ego's
    front by up to 50 m along the way that the ego drives, nobody between. It concerns the ego when TTC < 5 s or THW < 2 s within 3 s after. urgent
    or slow by TTC at the keyframe; large_vehicle by its class; ramp when it comes from the acceleration lane and the ego is not on one. Figures
    near a threshold, who stands, who was in that lane within 3 s before (the taxonomy does not say how long it has to be out) or in a junction
    within 1 s, or a crossing in the log's first second make the entry optional.
    """
    rows = run.rows[ego]
    way = Way(run, ego)
    gap_to = lambda name, k: way.ahead(run, name, k) - run.length(name) if k in run.rows[name] and k in rows else math.nan
    for c in run.changes:
        its = run.rows.get(c.id)
        if c.id == ego or c.k not in rows or its is None or c.k not in its or c.to.startswith(":") or run.kind(c.id) == "bicycle":
            continue
        me = rows[c.k]
        if math.hypot(me.x - its[c.k].x, me.y - its[c.k].y) > 90:
            continue
        own = [o.k for o in run.changes if o.id == ego]
        own_change = any(abs(k - c.k) < 40 for k in own)
        until = min([k for k in own if k > c.k], default=c.k + 100)
        drives = {rows[k].lane for k in range(c.k, min(until, c.k + 100)) if k in rows}
        if c.to not in drives and not own_change:
            continue
        lane = run.road.lanes[c.to]
        over = [k for k in range(c.k - 20, c.k + 16) if k in its and k in rows and side_gap(run, lane, its[k], run.width(c.id)) < 0]
        if not over:
            continue
        k = over[0]
        gap = gap_to(c.id, k)
        across = abs(turn_deg(rows[k].angle, its[k].angle))
        if not -run.length(c.id) < gap < 60 or across > 50:
            continue
        closing = rows[k].speed - its[k].speed
        ttc = gap / closing if closing > 0 else math.inf
        near = []
        for u in range(k, k + 31):
            g = gap_to(c.id, u)
            if g == g:
                v = rows[u].speed - its[u].speed
                near.append(min(g / v if v > 0.1 else 99, 2.5 * g / max(rows[u].speed, 0.1)))
        # In units in which 5 is the threshold of both.
        concerns = min(near, default=99)
        between = any(0 < gap_to(i, k) < gap for i, o in run.by_time[k] if o.lane in drives and not o.person and i not in (ego, c.id))
        if concerns > 6 and rows[k].speed > 1 or between:
            continue
        was_there = any(u in its and (its[u].lane in drives or its[u].lane.startswith(":") and u > k - 10) for u in range(k - 30, k - 2))
        sure = not own_change and concerns < 4.6 and 1 < gap < 46 and me.speed > 1.5 and its[k].speed > 1.0 and its[k].speed < 40
        sure = sure and across < 40 and not was_there and k - 10 in rows
        end = next((u for u in range(k, k + 80) if u in its and nearest_on(lane.shape, its[u].x, its[u].y)[0] < 0.5), k + 30)
        leafs = []
        if ttc < 3.6:
            leafs.append(("urgent", sure and ttc < 2.6))
        if ttc > 2.4:
            leafs.append(("slow", sure and ttc > 3.4))
        if run.kind(c.id) in ("truck", "bus"):
            leafs.append(("large_vehicle", sure))
        if run.road.lanes[c.start].acceleration and not run.road.lanes[me.lane].acceleration:
            leafs.append(("ramp", sure))
        if any(u in its and its[u].speed < 0.3 for u in range(k - 100, k)):
            leafs.append(("from_stationary", False))
        if sum(1 for u in rows if k - 600 < u < k and rows[u].speed < 0.3 and u - 1 in rows and rows[u - 1].speed >= 0.3) >= 1:
            leafs.append(("congestion", False))
        for leaf, required in leafs:
            yield run.entry(f"reactive_agent.cutin.{leaf}", ego, k - (20 if leaf == "urgent" else 50), k, end, c.id, optional=not required)
