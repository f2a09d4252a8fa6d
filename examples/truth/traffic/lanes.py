"""Changes of lane: the ego's own by the simulator's reason, other vehicles' into its lane as cut-ins, ramps, the bus lane.

The simulator logs a change at its middle; a change takes 3 s (`--lanechange.duration`), so the motion began 1.5 s before.
"""

import math

from log import nearest_on, runs

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
    earliest = max([first - 200, min(rows)] + [o.k + HALF for o in mine if o.k < c.k]
                   + [k + 1 for k in range(first - 200, first) if k in rows and rows[k].lane.startswith(":")])
    on = next((k for k in range(first, c.k) if k in rows and rows[k].signals & bit), None)
    if on is None:
        moved = first + math.ceil(2 * HALF * 0.3 / ((old.width + new.width) / 2))
        return max(min(moved - 20, first), earliest)
    while on > earliest and on - 1 in rows and rows[on - 1].signals & bit:
        on -= 1
    return min(on, first)


def own_changes(run, ego):
    """proactive.lane_change.*, special_lane.bus_lane and, over ramps, merge_interaction.*

    `strategic` is for the route: navigation; onto or off an acceleration or deceleration lane it is a merge or an exit. `speedGain` is
    overtake when the vehicle that was ahead in the old lane is behind 30 s later at most, escape when the ego had stood behind a standing
    vehicle, else efficiency. `keepRight` and `cooperative` are no reason that a leaf names: the L2. What a second change within 4 s makes of the
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
        if reason == "strategic" and any(l.to in run.road.ring for l in run.road.out[c.start] + run.road.out[c.to]):
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
    """merge_interaction: normal_merge from the acceleration lane's first metre until the change off it is done; split_exit from the
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
    """reactive_agent.cutin.*: another vehicle's change into the ego's lane ahead of it, on the same edge.

    Keyframe: its side passes the line of the ego's lane. It concerns the ego when TTC < 5 s or THW < 2 s within 3 s after (bumper to
    bumper along the lane); within 50 m. urgent or slow by TTC at the keyframe; large_vehicle by its class; ramp when it comes from
    the acceleration lane and the ego is not on one. Figures near a threshold, or who stands, make the entry optional.
    """
    rows = run.rows[ego]
    for c in run.changes:
        its = run.rows.get(c.id)
        if c.id == ego or c.k not in rows or its is None or c.k not in its:
            continue
        me = rows[c.k]
        if me.lane.startswith(":") or run.road.lanes[me.lane].edge != run.road.lanes[c.to].edge or run.kind(c.id) == "bicycle":
            continue
        own_change = any(o.id == ego and abs(o.k - c.k) < 40 for o in run.changes)
        if me.lane != c.to and not own_change:
            continue
        lane = run.road.lanes[c.to]
        over = [k for k in range(c.k - 20, c.k + 16) if k in its and k in rows and side_gap(run, lane, its[k], run.width(c.id)) < 0]
        if not over:
            continue
        k = over[0]
        gap = its[k].pos - run.length(c.id) - rows[k].pos if its[k].lane.rsplit("_", 1)[0] == rows[k].lane.rsplit("_", 1)[0] else math.nan
        if not gap == gap or gap < -run.length(c.id) or gap > 60:
            continue
        closing = rows[k].speed - its[k].speed
        ttc = gap / closing if closing > 0 else math.inf
        near, nearest = [], [0]
        for u in range(k, k + 31):
            if u in rows and u in its and its[u].lane.rsplit("_", 1)[0] == rows[u].lane.rsplit("_", 1)[0]:
                g, v = its[u].pos - run.length(c.id) - rows[u].pos, rows[u].speed - its[u].speed
                near.append(min(g / v if v > 0.1 else 99, 2.5 * g / max(rows[u].speed, 0.1)))
        # In units in which 5 is the threshold of both.
        concerns = min(near, default=99)
        between = any(o.lane == c.to and rows[k].pos < o.pos < its[k].pos and i not in (ego, c.id) for i, o in run.by_time[k])
        sure = not own_change and concerns < 4.6 and 1 < gap < 46 and me.speed > 1.5 and its[k].speed > 1.0 and not between and its[k].speed < 40
        if concerns > 6 or between:
            continue
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
