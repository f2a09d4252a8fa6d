"""lane_change.*, merge_interaction.* and cutin.*: who crosses which line, with the simulator's reason."""

import math

from world import bend, off_line

P, C = "proactive.lane_change.", "reactive_agent.cutin."
ALL = ("navigation", "efficiency", "overtake", "escape")


def ramp(w, edge):
    """Ramps by their type; where a network has no types, a road of at most 22.3 m/s that is joined to one above 25
    m/s.
    """
    e = w.net.edges[edge]
    if e.kind:
        return e.kind.endswith("_link")
    limit = lambda x: max((w.net.lanes[l].limit for l in x.lanes), default=0)
    ends = [r for n in (e.a, e.b) for r in (w.net.nodes[n].roads if n in w.net.nodes else ())]
    return limit(e) < 22.3 and any(limit(r) > 25 for r in ends if r is not e)


def edge_of(lane):
    return lane.rsplit("_", 1)[0]


def climbs(w, slip, road):
    """Whether a ramp leads from `road` onto a faster one only: it is an entry of that one, and nobody leaves a main road by
    it.
    """
    ends, seen, left = set(), set(), [slip]
    while left and len(seen) < 12:
        e = left.pop()
        seen.add(e)
        for b in {l.b for x in w.net.edges[e].lanes for l in w.net.out.get(x, [])} - seen:
            (left.append if ramp(w, b) else ends.add)(b)
    limit = lambda e: max(w.net.lanes[x].limit for x in w.net.edges[e].lanes)
    return bool(ends) and min(limit(e) for e in ends) > 1.2 * limit(road)


def from_ramp(w, lane):
    """A mainline lane that only a ramp feeds: acceleration or weaving lane, or one that joins for good."""
    feeds = [l for links in w.net.out.values() for l in links if l.to == lane]
    return w.net.lanes[lane].accel or bool(feeds) and all(ramp(w, l.a) for l in feeds)


def to_ramp(w, lane):
    """A lane beside through lanes that leads to a ramp only; a whole road that ends in ramps has no such lane."""
    leads = lambda x: bool(w.net.out.get(x)) and all(ramp(w, l.b) for l in w.net.out[x])
    return leads(lane) and not ramp(w, edge_of(lane)) and not all(leads(x) for x in w.net.edges[edge_of(lane)].lanes if w.net.lanes[x].cars)


def goes_through(w, lane):
    """A through lane of the road before leads straight into it: whether it is a deceleration lane all along is open."""
    feeds = [l for links in w.net.out.values() for l in links if l.to == lane]
    return any(not ramp(w, l.a) and len({x.to for x in w.net.out[l.lane] if x.b == l.b}) == 1 for l in feeds)


def visits(w, ego):
    out = []
    for k in sorted(w.rows[ego]):
        lane = w.rows[ego][k].lane
        if not out or out[-1][0] != lane:
            out.append([lane, k, k])
        out[-1][2] = k
    return out


def leaves_route(w, ego, c):
    """Meters until the lane that it leaves stops leading where the ego drives, and whether a junction comes before that;
    None if the log does not tell.
    """
    rows, edges = w.rows[ego], [edge_of(c.a)]
    for k in sorted(rows):
        if k > c.k and not rows[k].lane.startswith(":") and edge_of(rows[k].lane) != edges[-1]:
            edges.append(edge_of(rows[k].lane))
    lanes, metres, junctions = {c.a}, w.net.lanes[c.a].length - rows[c.k].pos, 0
    for before, there in zip(edges, edges[1:]):
        lanes = {l.to for lane in lanes for l in w.net.out.get(lane, []) if l.b == there}
        if not lanes:
            return metres, junctions > 0
        junctions += w.net.nodes[w.net.edges[before].b].real
        metres += w.net.lanes[min(lanes)].length
    return None


def changes(w, ego, lead):
    rows, mine = w.rows[ego], [c for c in w.changes[ego] if c.k in w.rows[ego]]
    for n, c in enumerate(mine):
        # Into the oncoming lane and past who drives ahead: nothing but overtaking. Back again is the end of it.
        against = not c.a.startswith(":") and w.net.counter(edge_of(c.a), edge_of(c.b)) and abs(bend(rows[c.k].angle, w.net.heading(c.a))) < 90
        name = next((lead[k][0] for k in range(c.k, c.k - 30, -1) if k in lead and w.rows[lead[k][0]][k].lane == c.a), None) if against else None
        out = name is not None and c.k in w.rows[name] and passed(w, ego, name, c.k)
        if c.a.startswith(":") or edge_of(c.a) != edge_of(c.b) and not out:
            start = c.k - 30
            for leaf in ALL:
                yield w.entry(P + leaf, ego, start, start, c.k + 30, optional=True)
            continue
        old, new = w.net.lanes[c.a], w.net.lanes[c.b]
        shift = lambda k: abs(off_line(old.points, rows[k].x, rows[k].y)[1])
        began = c.k
        while began - 1 in rows and rows[began - 1].lane == c.a and shift(began - 1) > 0.3 and began > c.k - 60:
            began -= 1
        bit = (2 if new.index > old.index or against else 1) if not w.net.left_hand else (1 if new.index > old.index or against else 2)
        start = began - 20
        blink = [k for k in range(began - 200, c.k) if k in rows and rows[k].blink & bit]
        if blink and all(k in blink or k not in rows for k in range(began, c.k)):
            start = began
            # An indicator that was on for a turn before says nothing of this road.
            while start - 1 in blink and edge_of(rows[start - 1].lane) == edge_of(c.a):
                start -= 1
            start = min(start, began)
        end = next((k for k in range(c.k, c.k + 80) if k in rows and off_line(new.points, rows[k].x, rows[k].y)[0] < 0.3), c.k + 20) + 20
        close = any(abs(o.k - c.k) < 70 for o in mine if o is not c)
        node = w.net.nodes.get(w.net.edges[edge_of(c.a)].b)
        at_node = node is not None and node.real and (old.length - rows[c.k].pos < 2.5 * rows[c.k].v or rows[c.k].pos < 2 * rows[c.k].v)
        vague = close or at_node or rows[c.k].v < 3 or start - 20 not in rows or c.k + 30 not in rows or edge_of(c.a) in w.net.ring
        off = leaves_route(w, ego, c)
        leaf, target, sure, plain = None, None, not vague, not vague
        if out:
            leaf, target, plain = "overtake", name, False
            sure = sure and w.kind(name) != "bicycle" and w.rows[name][c.k].v > 3
        elif from_ramp(w, c.a) or to_ramp(w, c.b) or ramp(w, edge_of(c.a)):
            sure = plain = False
        elif c.reason == "strategic" and off is not None and off[0] <= 500:
            # Where its lane leads through the next junction as well, the route does not ask for the change yet.
            leaf, sure = "navigation", sure and not off[1]
        elif c.reason == "speedGain":
            name = lead.get(began, (None, 0))[0]
            its = w.rows.get(name, {}).get(began)
            if its and its.lane == c.a and lead[began][1] < 70 and its.v + 5 / 3.6 < old.limit * 1.05:
                leaf, target = ("overtake", name) if passed(w, ego, name, c.k) else ("efficiency", None)
                queue = min(rows[k].v for k in range(began - 30, c.k + 60) if k in rows) < 2
                later = max((rows[k].v for k in range(c.k, c.k + 120) if k in rows), default=0)
                # Who speeds up ahead as the ego does holds it up for that moment only.
                freed = max((w.rows[name][k].v for k in range(c.k, c.k + 60) if k in w.rows[name]), default=0) > its.v + 5 and its.a > 1
                # A rider is passed, too, but it is a VRU in the lane before.
                # Nor does who drives faster than the ego. Behind who moves over, too, nothing is gained.
                freed |= its.v > rows[began].v + 0.5 or any(w.rows[name][k].lane == c.b for k in range(c.k, c.k + 60) if k in w.rows[name])
                plain = plain and w.kind(name) != "bicycle"
                moving = leaf != "overtake" or c.k in w.rows[name] and w.rows[name][c.k].v > 3
                sure = sure and w.kind(name) != "bicycle" and moving and not queue and (leaf == "overtake" or later > its.v + 2 and not freed)
        if leaf:
            yield w.entry(P + leaf, ego, start, start, end, target, optional=not sure)
        if plain and not (leaf and sure):
            # That it changes lane is plain, why is not: any variant of the L2.
            yield w.entry(P[:-1], ego, start, start, end)
        if not leaf or not sure or leaf != "navigation":
            for each in ALL:
                yield w.entry(P + each, ego, start, start, end, optional=True)


def passed(w, ego, name, k0):
    rows, its = w.rows[ego], w.rows[name]
    for k in range(k0, k0 + 300):
        if k in rows and k in its:
            a = math.radians(rows[k].angle)
            dx, dy = its[k].x - rows[k].x, its[k].y - rows[k].y
            if dx * math.sin(a) + dy * math.cos(a) < -0.5 and math.hypot(dx, dy) < 30:
                return True
    return False


def facilities(w, ego):
    """merge_interaction.*: over the nodes at which the ego changes between ramp and mainline, and zippers."""
    rows, seen = w.rows[ego], visits(w, ego)
    M = "proactive.merge_interaction."
    roads = [v for v in seen if not v[0].startswith(":")]
    for i, (lane, a, b) in enumerate(roads[1:], 1):
        was = roads[i - 1]
        if edge_of(was[0]) == edge_of(lane):
            continue
        if ramp(w, edge_of(was[0])) and not ramp(w, edge_of(lane)):
            stays = [v for v in roads[i:] if v[0] == lane or edge_of(v[0]) == edge_of(lane)]
            off = next((c for c in w.changes[ego] if c.k >= a and c.a == lane), None)
            leaves = any(ramp(w, edge_of(v[0])) for v in roads[i + 1:i + 4])
            if off is not None and from_ramp(w, lane) and off.k - b <= 2:
                came = w.later(ego, a, w.length(ego) / 2)
                yield w.entry(M + "normal_merge", ego, came, came, off.k + 20, optional=min(rows) > a - 20 or not stays or leaves)
            else:
                yield w.entry(M + "normal_merge", ego, a, a, a + 50, optional=True)
        if ramp(w, edge_of(lane)) and not ramp(w, edge_of(was[0])):
            # Into a lane that leads to the ramp only: over its line, or where it begins ahead of the ego's lane.
            n = i - 1
            while n > 0 and to_ramp(w, roads[n - 1][0]):
                n -= 1
            off = w.later(ego, was[2], w.length(ego) / 2)
            # Over the line onto the first of such lanes, or along with it from the road before.
            over = n > 0 and edge_of(roads[n - 1][0]) == edge_of(roads[n][0])
            start = off if not to_ramp(w, roads[n][0]) else roads[n][1] if over else w.later(ego, roads[n][1], w.length(ego) / 2)
            done = w.later(ego, a, w.length(ego) / 2)
            # "From entering the deceleration lane until on the ramp": how long a lane that leads to the ramp only may be
            # to count as one is not said.
            long = start < off and (w.net.lanes[was[0]].length > 500 or not over and goes_through(w, roads[n][0]))
            # From ramp to ramp by the lane that joins them, it was never on the main road.
            long |= start < off and n > 0 and ramp(w, edge_of(roads[n - 1][0]))
            # Where it ends: a surface road that leads into ramps has no main road that goes on.
            ends = all(ramp(w, l.b) for x in w.net.edges[edge_of(was[0])].lanes for l in w.net.out.get(x, []))
            ends |= climbs(w, edge_of(lane), edge_of(was[0]))
            yield w.entry(M + "split_exit", ego, start, start, done, optional=max(rows) < a + 10 or start not in rows or long or ends)
            if start < off - 50 or long or ends:
                yield w.entry(M + "split_exit", ego, off, off, done, optional=True)
    for p in w.passing[ego]:
        if p.node.kind != "zipper":
            continue
        foes = set(p.node.foes.get(p.link.via, ()))
        into = sorted((q.first, q.link.via in foes) for n, qs in w.passing.items() for q in qs if n != ego and q.node.id == p.node.id and q.link.to == p.link.to)
        before, behind = [x for x in into if x[0] < p.first][-1:], [x for x in into if x[0] >= p.first][:1]
        # Taking turns: who goes in right before or right behind it comes from the other lane.
        turns = any(foe and abs(t - p.first) < 25 for t, foe in before + behind)
        if foes:
            start = p.first - 50
            yield w.entry(M + "zipper_merge", ego, start, start, w.later(ego, p.last, w.length(ego)), optional=not turns)


def cut_ins(w, ego):
    rows, own_changes = w.rows[ego], [c.k for c in w.changes[ego]]
    for name, made in list(w.changes.items()):
        its = w.rows.get(name)
        if name == ego or not its or w.kind(name) == "bicycle":
            continue
        for c in made:
            if c.k not in rows or c.k not in its or math.hypot(rows[c.k].x - its[c.k].x, rows[c.k].y - its[c.k].y) > 110:
                continue
            drives = {rows[k].lane for k in range(c.k - 5, c.k + 150) if k in rows}
            if c.b not in drives:
                continue
            new = w.net.lanes[c.b]
            crosses = c.k
            while crosses - 1 in its and crosses > c.k - 40 and off_line(new.points, its[crosses - 1].x, its[crosses - 1].y)[0] - w.width(name) / 2 < new.width / 2:
                crosses -= 1
            k = crosses
            if k not in rows:
                continue
            a = math.radians(rows[k].angle)
            gap = (its[k].x - rows[k].x) * math.sin(a) + (its[k].y - rows[k].y) * math.cos(a) - w.length(name)
            soon = gap < 6 * max(rows[k].v - its[k].v, 0)
            if gap < -w.length(name) or gap > max(55, 2.2 * rows[k].v) and not soon or abs(bend(rows[k].angle, its[k].angle)) > 50:
                continue
            near, after = [], []
            for u in range(k - 30, k + 31):
                if u in rows and u in its:
                    g = (its[u].x - rows[u].x) * math.sin(a) + (its[u].y - rows[u].y) * math.cos(a) - w.length(name)
                    closing = rows[u].v - its[u].v
                    near.append(min(g / closing if closing > 0.1 else 99, 2.5 * g / max(rows[u].v, 0.1)))
                    # While it was beside the ego, or another was between, the gap obliged the ego to nothing.
                    after += near[-1:] if u >= k - 2 else []
            if min(near, default=99) > 6.5:
                continue
            between = [i for i in w.at[k] if i not in (ego, name) and w.rows[i][k].lane in drives and not w.rows[i][k].person and
                       0 < (w.rows[i][k].x - rows[k].x) * math.sin(a) + (w.rows[i][k].y - rows[k].y) * math.cos(a) < gap + w.length(name)]
            closing = rows[k].v - its[k].v
            ttc = gap / closing if closing > 0 else math.inf
            own = any(abs(x - c.k) < 50 for x in own_changes)
            sure = (not own and not between and 1.5 < gap < max(45, 1.8 * rows[k].v) and min(after, default=99) < 4.5 and rows[k].v > 3 and its[k].v > 2 and not c.b.startswith(":")
                    and c.b == rows[k].lane and k - 20 in rows and k + 20 in rows and not any(abs(o.k - c.k) < 60 for o in made if o is not c))
            # Who comes in faster than the ego and 1 s or more ahead goes away from it: whether that obliges it to anything is open.
            sure = sure and not (its[k].v > rows[k].v + 1 and gap > rows[k].v)
            leaf = "urgent" if ttc < 3 else "slow"
            if 2.4 < ttc < 3.7:
                sure = False
            if w.kind(name) in ("truck", "bus"):
                leaf = "large_vehicle"
            if w.kind(name) == "delivery":
                # Whether a van of 6 m is a large vehicle is open.
                yield w.entry(C + "large_vehicle", ego, k - 50, k, k + 30, name, optional=True)
            if from_ramp(w, c.a) and not from_ramp(w, rows[k].lane):
                leaf = "ramp"
            stopped = any(u in its and its[u].v < 0.3 for u in range(k - 120, k))
            slow_stream = max((rows[u].v for u in range(k - 200, k) if u in rows), default=99) < 9.5
            # On a ring, whether that is a cut-in at a junction is open.
            sure = sure and not stopped and not slow_stream and edge_of(c.b) not in w.net.ring
            end = next((u for u in range(k, k + 80) if u in its and off_line(new.points, its[u].x, its[u].y)[0] < 0.5), k + 30)
            if sure:
                yield w.entry(C + leaf, ego, k - (20 if leaf == "urgent" else 50), k, end, name)
            for each in ("urgent", "slow", "large_vehicle", "ramp", "from_stationary", "congestion", "intersection"):
                # The variants exclude each other only by precedence, which the taxonomy leaves to the primary leaf.
                if not sure or each in ("urgent", "slow") and leaf in ("large_vehicle", "ramp") or each == "large_vehicle" and leaf == "ramp" and w.kind(name) in ("truck", "bus"):
                    yield w.entry(C + each, ego, k - 50, k, end, name, optional=True)
    yield from joins(w, ego)


def joins(w, ego):
    """Vehicles that join the ego's lane at a node (ramp without a lane of its own, roundabout, junction): closer than 4.5 s
    ahead, whether that is a cut-in is open; at a zipper, taking turns is not one. "Any wheel of the other vehicle
    crosses the lane line" is the moment, so who waits inside the junction counts from when it comes out into the lane,
    as does who came in later than the ego and is out before it. Who comes in behind the ego, or further ahead, obliges
    it to nothing: no cut-in.
    """
    for p in w.passing[ego]:
        if p.node.kind == "zipper":
            continue
        for name, passages in w.passing.items():
            for q in passages:
                if name == ego or q.node.id != p.node.id or q.link.to != p.link.to or q.link.lane == p.link.lane:
                    continue
                moments = {i for i, ahead in ((q.first, p.first - q.first), (q.last, p.last - q.last)) if 0 < ahead < 45}
                for k in sorted(moments):
                    for leaf in ("slow", "urgent", "ramp", "intersection", "large_vehicle", "from_stationary"):
                        yield w.entry(C + leaf, ego, k - 20, k, q.last + 20, name, optional=True)
