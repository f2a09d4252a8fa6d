"""turn.*, intersection_interaction.* and roundabout.*: passages of junctions by the network's links, and its table
of who crosses whom.
"""

import math

from world import Box, bend, off_line

I = "reactive_agent.intersection_interaction."


def samples(w, link):
    out, done = [], 0.0
    points = [p for lane in w.net.path(link) for p in w.net.lanes[lane].points]
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        length = math.hypot(bx - ax, by - ay)
        n = max(1, int(length / 0.5))
        out += [(done + length * i / n, ax + (bx - ax) * i / n, ay + (by - ay) * i / n) for i in range(n)]
        done += length
    return out + ([(done, *points[-1])] if points else [])


def near_spot(w, own, its):
    """Meters along both links to where their paths come near each other, or None; the same for all who drive there."""
    if (own.via, its.via) not in w.spots:
        mine, theirs = samples(w, own), samples(w, its)
        # Foes whose paths come no nearer join side by side.
        w.spots[own.via, its.via] = next((spot for reach in (1, 2.5) for spot in ((d, e) for d, x, y in mine for e, u, v in theirs if abs(x - u) < reach and abs(y - v) < reach)), None)
    return w.spots[own.via, its.via]


def met(w, ego, p):
    """Vehicles whose link is a foe of the ego's: times at which both get to where their paths come within 1 m of
    each other.
    """
    own_lanes = w.net.path(p.link)
    for name, passages in w.passing.items():
        if name == ego:
            continue
        for q in passages:
            if q.node.id != p.node.id or abs(q.first - p.first) > 600 or q.link.lane == p.link.lane:
                continue
            its = w.net.path(q.link)
            if not any(b in p.node.foes.get(a, ()) for a in own_lanes for b in its):
                continue
            spot = near_spot(w, p.link, q.link)
            if spot is None:
                continue
            a, b = w.later(ego, p.first, spot[0]), w.later(name, q.first, spot[1])
            must = any(t in p.node.yields.get(s, ()) for s in own_lanes for t in its) or w.letter(p.link, p.first) == "g"
            yield Box(name=name, q=q, mine=a, its=b, must=must, apart=abs(a - b) / 10)


def predicted(w, ego, m):
    """Whether at some moment, while the ego brakes or waits near the junction, both would by their speeds reach the place
    within 5 s of each other: the definition takes the arrival that is predicted as well as the one that came.
    """
    rows, way = w.rows[ego], w.way(ego)
    for k in range(m.its - 60, m.its + 1):
        if k in rows and m.mine in way and (rows[k].a < -0.8 or rows[k].v < 1.5) and way[m.mine] - way[k] < 60:
            theirs, own = (m.its - k) / 10, (way[m.mine] - way[k]) / max(rows[k].v, 0.1)
            if abs(own - theirs) < 5.5 or rows[k].v < 1.5:
                return True
    return False


def perhaps(w, ego, name, q):
    """What may be an encounter with `name`, whose passage is `q`: a rider is a road user who crosses."""
    rider = w.kind(name) == "bicycle"
    leaves = [f"reactive_agent.vru_crossing.{v}" for v in ("horizontal", "diagonal", "crosswalk")] if rider else [I + v for v in ("unprotected_left", "right_vs_straight", "cross_conflict")]
    for each in leaves:
        for key in (-40, -20, 0, 20):
            yield w.entry(each, ego, q.first + key - 10, q.first + key, q.last + 20, name, optional=True)


def unfinished(w, ego):
    """A wait before a junction that the ego never enters: which link it wants is not known, so who crosses meanwhile may
    be what it waits for, and may not.
    """
    rows = w.rows[ego]
    last = max(rows)
    lane = w.net.lanes.get(rows[last].lane)
    if lane is None or rows[last].lane.startswith(":"):
        return
    node = w.net.nodes.get(w.net.edges[lane.edge].b)
    if node is None or not node.real:
        return
    near = [k for k in rows if rows[k].lane == rows[last].lane and lane.length - rows[k].pos < 60]
    if not near:
        return
    for name, passages in w.passing.items():
        for q in passages:
            if name != ego and q.node.id == node.id and q.link.lane != rows[last].lane and q.last > near[0] - 20:
                yield from perhaps(w, ego, name, q)


def leaf_of(w, ego, p, m):
    me, it = w.rows[ego][p.first], w.rows[m.name][m.q.first]
    facing = abs(bend(me.angle, it.angle)) > 135
    same_exit = p.link.b == m.q.link.b
    if p.node.on_ring:
        # "A circulating vehicle against an ego entering a roundabout", however sharply the ego turns there.
        return "cross_conflict"
    if p.turned > 45 and facing:
        return "unprotected_left"
    if p.turned < -45 and same_exit:
        # Who turns round into the same road does not come straight on.
        return "right_vs_straight" if abs(m.q.turned) < 135 else None
    return None if same_exit else "cross_conflict"


def comes_out(net, l, p):
    """Another way into the road that the ego goes on along, at 60 degrees or more to it: no ramp, no ring."""
    return l.b == p.link.b and l.a != p.link.a and l.dir in "lrt" and not p.node.on_ring and abs(bend(net.heading(l.lane), net.heading(l.to, False))) > 60


def junctions(w, ego, lead):
    rows, net = w.rows[ego], w.net
    yield from rings(w, ego)
    yield from unfinished(w, ego)
    yield from slips(w, ego)
    for p in w.passing[ego]:
        if not p.node.real:
            # Whether a level crossing is a junction, and who waits there at its light meets the train, is open.
            trains = [m for m in met(w, ego, p) if w.kind(m.name) == "rail" and m.apart < 30] if p.link.tl else []
            for m in trains:
                yield from perhaps(w, ego, m.name, m.q)
            # Whether who drives on past an opening in the median passes a junction is not said, where others turn off into it
            # or come out of it.
            if any(l.a == p.link.a and l.dir in "lrt" or comes_out(net, l, p) for links in net.out.values() for l in links):
                into = w.later(ego, p.first, w.length(ego) / 2)
                yield w.entry("proactive.turn.straight", ego, into - 30, into, w.later(ego, p.last, w.length(ego) / 2) + 20, optional=True)
            continue
        into, out = w.later(ego, p.first, w.length(ego) / 2), w.later(ego, p.last, w.length(ego) / 2)
        near, foes = False, list(met(w, ego, p))
        for m in foes:
            if w.kind(m.name) == "bicycle":
                near |= m.apart < 8
                # For whom it waits in the junction or before it, and for how long, is open.
                if m.its < m.mine and (m.q.last > p.first - 20 or predicted(w, ego, m)):
                    yield from perhaps(w, ego, m.name, m.q)
                continue
            leaf = leaf_of(w, ego, p, m)
            waiting = [k for k in range(m.its - 15, m.its + 1) if k in rows and rows[k].v < 1.5 and (rows[k].lane.startswith(":") or net.lanes[rows[k].lane].length - rows[k].pos < 9
                       and rows[k].lane == p.link.lane) and (rows[k].lane.startswith(":") or w.letter(p.link, k) in (None, "G", "g", "s"))]
            waits = m.must and m.its < m.mine and len(waiting) > 5
            # Behind who came by the same lane and stands first, that one is the nearest cause of the wait.
            queued = [k for k in waiting if k in lead and lead[k][0] != m.name and lead[k][1] < 10 and any(q.link.lane == p.link.lane and q.node is p.node and q.last > k - 20 for q in w.passing.get(lead[k][0], []))]
            # A passage of the ring's other vehicles: each joint of a ring is a crossing of its own.
            # Whether who comes at 105 to 135 degrees towards a left turn is oncoming or crosses is open.
            aslant = p.turned > 45 and 105 < abs(bend(rows[p.first].angle, w.rows[m.name][m.q.first].angle)) <= 140
            sure = waits and leaf and m.apart < 5 and p.whole and p.began and not (net.left_hand and abs(p.turned) > 45) and not aslant and 2 * len(queued) < len(waiting)
            # Of several for which it waits in the junction in turn, since when for this one is open.
            turns = m.its - p.first > 50 and any(o.must and o.name != m.name and p.first < o.its < m.its - 10 for o in foes)
            near |= m.apart < 8 or waits
            # After a wait of 5 s and more before it the encounter may have begun with the approach.
            way = w.way(ego)
            held = [k for k in range(p.first - 900, p.first) if k in rows and rows[k].v < 1.5 and way[p.first] - way[k] < 30 and w.letter(p.link, k) in (None, "G", "g", "s")]
            if sure and not turns:
                yield w.entry(I + leaf, ego, p.first, p.first, out, m.name, optional=len(held) > 50)
            if m.apart < 10 or waits or predicted(w, ego, m):
                # Long waits before it: the range begins with the approach.
                slow = [k for k in range(p.first - 900, p.first) if k in rows and rows[k].v < 1.5]
                if len(slow) > 50:
                    begin = next((k for k in range(slow[0] - 100, slow[0] + 1) if k in rows and way[p.first] - way[k] < 32), slow[0])
                    for each in {leaf} - {None}:
                        yield w.entry(I + each, ego, begin, begin, out, m.name, optional=True)
                # In a ring each joint is a junction of its own; which of them the encounter belongs to is open.
                joints = [q for q in w.passing[ego] if q.node.on_ring and abs(q.first - p.first) < 200] if p.node.on_ring else [p]
                for each in ("unprotected_left", "right_vs_straight", "cross_conflict"):
                    for q in joints:
                        yield w.entry(I + each, ego, q.first, q.first, q.last, m.name, optional=True)
                if p.first - m.q.first > 30 or m.q.first - p.first > 50:
                    # It gives way long before it enters; or it waits inside for one after the other: since when for this one is open.
                    yield from perhaps(w, ego, m.name, m.q)
        # Where a road passes through the middle of a ring, who drives on along it crosses the ring as at any junction.
        if p.node.on_ring and not {p.link.a, p.link.b}.isdisjoint(net.ring) or not p.began:
            continue
        yield from turn(w, ego, p, lead, into, out, near)


def slips(w, ego):
    """Turns by a slip road that passes the junction: whether that is a turn at a junction is open, and so is the
    encounter with those whom it joins.
    """
    rows, net, roads = w.rows[ego], w.net, []
    for k in sorted(rows):
        lane = rows[k].lane
        if lane in net.lanes and not lane.startswith(":"):
            edge = net.edges[net.lanes[lane].edge]
            if not roads or roads[-1][0] is not edge:
                roads.append((edge, k, k))
            roads[-1] = (edge, roads[-1][1], k)
    for (before, *_), (slip, first, last), (after, *_) in zip(roads, roads[1:], roads[2:]):
        ends = [net.nodes.get(n) for n in (slip.a, slip.b)]
        forks = [{l.b for l in net.out[x]} for x in before.lanes]
        if None in ends or any(n.real or n.on_ring for n in ends) or slip.kind.endswith("_link") or len(set().union(*forks)) < 2 or net.lanes[slip.lanes[-1]].length > 100 or len(ends[1].comes) < 2:
            continue
        done = w.later(ego, last, w.length(ego))
        turned = sum(bend(rows[k - 1].angle, rows[k].angle) for k in range(first, done + 1) if k in rows and k - 1 in rows)
        # Towards the edge of the road; the other way it is an opening in the median.
        if turned * (1 if net.left_hand else -1) < 38:
            continue
        for leaf in ("right_normal",) if turned < 0 else ("left_normal", "left_unprotected"):
            for key in (first - 15, first, (first + last) // 2, last):
                yield w.entry(f"proactive.turn.{leaf}", ego, key - 30, key, done + 20, optional=True)
        for p in w.passing[ego]:
            if p.node is ends[1] and last <= p.first <= done + 1:
                for m in met(w, ego, p):
                    yield from perhaps(w, ego, m.name, m.q)


def turn(w, ego, p, lead, into, out, near):
    rows, net = w.rows[ego], w.net
    walkers = any(w.first(i).person and math.hypot(w.rows[i][k].x - rows[k].x, w.rows[i][k].y - rows[k].y) < 14
                  for k in range(p.first - 20, p.last, 5) if k in rows for i in w.at[k] if not i.startswith("ego"))
    short = not p.whole or p.first - min(rows) < 100
    if abs(p.turned) < 45:
        before = [rows[k] for k in range(into - 60, into) if k in rows]
        stood = [k for k in range(into - 80, into) if k in rows and rows[k].v < 0.3]
        if not before or stood and stood[-1] > into - 40:
            return
        # How long ago it may have stood is not said.
        short |= bool(stood)
        adjusted = max(o.v for o in before) - min(o.v for o in before) > 1.0
        held = [k for k in range(into - 80, into) if w.letter(p.link, k) not in (None, "G", "g", "s", "o", "O")] if p.link.tl else []
        # Whether a road with driveways only beside it has an intersection there is open.
        drive = p.node.drives and not any(net.edges[e].kind.endswith("service") for e in (p.link.a, p.link.b))
        yield w.entry("proactive.turn.straight", ego, into - 30, into, out + 20, optional=bool(near or adjusted or held or walkers or short or drive or abs(p.turned) > 38))
        return
    if 38 < abs(p.turned) < 52 or 128 < abs(p.turned) < 142:
        short = True
    mine = rows[p.first].angle
    # Whose traffic crosses a left turn: who comes from ahead, other than from the road that the ego turns into. At
    # 120 degrees that is open.
    comes = [(abs(bend(mine, net.heading(e.lanes[0]))), e.kind.endswith("service")) for e in p.node.roads if e.b == p.node.id and e.id != p.link.a and e.a != net.edges[p.link.b].b
             and any(net.lanes[x].cars for x in e.lanes)]
    from_ahead = [angle for angle, _ in comes]
    oncoming = any(angle > 135 for angle in from_ahead)
    if p.turned > 45 and not oncoming and any(angle > 105 for angle in from_ahead):
        short = True
    # So it is where only a driveway comes from ahead.
    short |= p.turned > 45 and oncoming and all(drive for angle, drive in comes if angle > 135)
    # On the yellow that ends such a green the traffic opposite is still held.
    shown = next((x for k in range(p.first, max(0, p.first - 60), -1) if (x := w.letter(p.link, k)) != "y"), None) if p.link.tl else None
    protected = shown == "G"
    if abs(p.turned) > 135:
        leaf = "uturn"
    elif p.turned < 0:
        leaf = "right_normal"
    else:
        leaf = "left_normal" if not oncoming or protected else "left_unprotected"
    base = rows[max(min(rows), p.first - 1)].angle
    starts = next((k for k in range(p.first, p.last + 1) if k in rows and abs(bend(base, rows[k].angle)) > 1), p.first)
    # On the left, which turn crosses oncoming traffic is mirrored; the leaves' names are not.
    if leaf == "uturn" and p.link.dir != "t":
        # So sharp a turn into another road: whether that is turning round is open.
        for each in ("right_normal",) if p.turned < 0 else ("left_normal", "left_unprotected"):
            yield w.entry(f"proactive.turn.{each}", ego, into - 30, starts - 5, out + 20, optional=True)
        short = True
    leaves = [leaf] if not leaf.startswith("left") or not (net.left_hand or short) else ["left_normal", "left_unprotected"]
    for each in leaves:
        yield w.entry(f"proactive.turn.{each}", ego, into - 30, starts - 5, out + 20, optional=bool(near or walkers or short or len(leaves) > 1 or len(p.node.comes) > 4))


def rings(w, ego):
    rows, net = w.rows[ego], w.net
    on = lambda o: o.lane.rsplit("_", 1)[0] in net.ring or o.lane.startswith(":") and o.lane in net.lanes and net.node_of(o.lane).on_ring
    keys, runs = sorted(rows), []
    for k in keys:
        if on(rows[k]):
            if runs and k - runs[-1][-1] <= 1:
                runs[-1].append(k)
            else:
                runs.append([k])
    for run in runs:
        a, b = run[0], run[-1]
        if not any(rows[k].lane.rsplit("_", 1)[0] in net.ring for k in run):
            continue
        whole_in, whole_out = w.later(ego, a, w.length(ego)), w.later(ego, b, w.length(ego))
        began, left = a - 30 in rows, b + 10 in rows
        way = w.way(ego)
        start = next((k for k in keys if way[a] - way[k] <= 30 - w.length(ego) / 2), a)
        if a - 1 in rows:
            # "No identifiable vehicle makes it yield": behind one that circulates, within 6 s of it or after a wait, that is the
            # interaction, and whether it is an entry besides is open.
            into = next((p for p in w.passing[ego] if p.first >= a and p.node.on_ring), None)
            waits = any(rows[k].v < 1.5 for k in range(start, a) if k in rows)
            before = [m for m in met(w, ego, into) if m.must and m.its < m.mine and w.kind(m.name) != "bicycle"] if into else []
            yield w.entry("proactive.roundabout.entry", ego, start, start, whole_in, optional=not began or waits or any(m.apart < 6 for m in before))
        if b + 1 in rows:
            blink = next((k for k in run if k > b - 80 and all(rows[u].blink & (2 if net.left_hand else 1) for u in range(k, b) if u in rows)), None)
            centre = w.later(ego, b, w.length(ego) / 2)
            key = blink if blink is not None and blink < b else centre - 30
            yield w.entry("proactive.roundabout.exit", ego, max(key, a), max(key, a), whole_out, optional=not left)
        moved = [c for c in w.changes[ego] if a <= c.k <= b and c.a.rsplit("_", 1)[0] in net.ring]
        if moved:
            yield w.entry("proactive.roundabout.lane_in_roundabout", ego, a, a, b, optional=a - 1 not in rows or b + 1 not in rows)
