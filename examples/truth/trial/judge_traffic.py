"""following.*, crossings of people and riders, and near misses."""

import math
from itertools import accumulate

from world import bend, spans

F = "reactive_agent.following."


def leads(w, ego):
    """By time (leader, gap): the simulator's leader where it is on a lane that the ego itself drives within the
    next 30 s.
    """
    rows, out, visits = w.rows[ego], {}, []
    for k in sorted(rows):
        if not visits or visits[-1][0] != rows[k].lane:
            visits.append((rows[k].lane, k))
    for k, o in rows.items():
        its = w.rows.get(o.leader, {}).get(k) if o.leader else None
        # Who overtakes in the oncoming lane is led by nobody who comes towards it.
        if its is None or not o.gap < 100 or its.lane == o.lane and abs(bend(o.angle, its.angle)) > 150:
            continue
        own = {lane for lane, since in visits if k <= since < k + 300} | {o.lane}
        if its.lane in own or o.gap < 12 and abs(bend(o.angle, its.angle)) < 45:
            out[k] = (o.leader, o.gap)
    return out


def stood(rows, least=5):
    return [(a, b) for a, b in spans([k for k, o in rows.items() if o.v < 0.3], gap=5) if b - a >= least]


def beside(w, ego, name, k):
    """Whether who stands before the ego is on a lane beside the one by which the ego goes on along the same road: its rear
    is still in the ego's way, and the ego follows it nowhere.
    """
    edge = lambda lane: lane.rsplit("_", 1)[0]
    its, own = w.rows[name].get(k), {w.rows[ego][u].lane for u in range(k, k + 600) if u in w.rows[ego]}
    return its is not None and its.lane not in own and edge(its.lane) in {edge(lane) for lane in own}


def following(w, ego, lead):
    rows = w.rows[ego]
    motor = {k: v for k, v in lead.items() if w.kind(v[0]) != "bicycle"}
    own_change = {k for c in w.changes[ego] for k in range(c.k - 20, c.k + 21)}
    yield from steady(w, ego, motor, own_change)
    yield from parting(w, ego)
    yield from creeping(w, ego, motor)
    yield from brief(w, ego, motor)
    halts = stood(rows)
    behind = lambda k, reach=15: next((motor[u] for u in range(k, k + 8) if u in motor and motor[u][1] < reach), None)
    # Some drivers' models never come quite to rest: whether they stand is open.
    rests = lambda a, b: min(rows[k].v for k in range(a, b + 1) if k in rows) < 0.1
    stretches = congested(rows, halts, behind)
    loosely = congested(rows, [s for s in spans([k for k, o in rows.items() if o.v < 0.6], gap=5) if s[1] > s[0]], lambda k: behind(k, 22))
    for a, b, n in loosely:
        # By a looser reading of standing and of the gap: which of the halts is the first is open, too.
        for first, _ in [(a, b), *(h for h in halts if a < h[0] < b)]:
            yield w.entry(F + "stop_and_go", ego, first, first, b, optional=True)
    for a, b, n in stretches:
        # The limit between stops is 30 km/h (8.33 m/s); close to it the entry is open.
        fastest = max(rows[k].v for k in range(a, b) if k in rows)
        yield w.entry(F + "stop_and_go", ego, a, a, b, optional=n < 3 or not all(rests(*h) for h in halts if a <= h[0] <= b) or not 1.5 <= fastest < 8.2)
    # In such a stretch, by either reading, single stops and starts are open.
    inside = lambda k: any(a - 100 <= k <= b + 60 for a, b, n in stretches) or any(a - 20 <= k <= b + 20 for a, b, n in loosely)
    for a, b in halts:
        at = behind(a, 18)
        if at is None or a - 30 not in rows:
            continue
        name, gap = at
        its, aside = w.rows[name], beside(w, ego, name, a)
        halted = next((s for s in stood(its, 3) if s[0] <= a + 40 and s[1] >= a), None)
        fast = max(rows[k].v for k in range(a - 100, a) if k in rows)
        if halted and fast > 1.5:
            h = halted[0]
            if h > a:
                h = next((k for k in sorted(its) if h - 100 < k <= h and all(its[u].v < 2 for u in range(k, h) if u in its)), h)
            elif h in rows or h < min(rows):
                h = max(h, min(rows))
                # Already standing before the ego comes near: the first moment with TTC < 5 s.
                ttc = lambda k: motor[k][1] / rows[k].v if k in motor and motor[k][0] == name and rows[k].v > 0.1 else math.inf
                # A lead for a moment while others are between does not count: the last approach.
                near = [s for s in spans([k for k in range(h, a) if k in rows and ttc(k) < 5], gap=10)]
                if near and (not ttc(h) < 5 or near[-1][0] > h):
                    h = near[-1][0]
            hard = min((its[k].a for k in range(halted[0] - 60, halted[0]) if k in its), default=0)
            changed = any(c.k > a - 50 and c.k < a + 10 for c in w.changes[name] + w.changes[ego])
            # Who goes on while the other stands goes round it: whether that was a stop behind traffic or before an obstacle is open.
            around = its[b + 10].v < 0.3 if b + 10 in its and b + 20 in rows else False
            yield w.entry(F + "follow_stop", ego, h - 20, h, a + 10, name, optional=aside or around or gap > 13 or hard < -2.7 or inside(a) or fast < 4 or changed or b - a < 10 or not rests(a, b))
        elif min((its[k].v for k in range(a - 40, a + 41) if k in its), default=9) < 1 and max(rows[k].v for k in range(a - 300, a + 1) if k in rows) > 1.5:
            # Drivers that crawl up to a lead and never come quite to rest, or behind one that does not: when it stops is open.
            for least in (2, 0.3):
                slow = next((k for k in range(a - 300, a + 41) if k in its and its[k].v < least and all(its[u].v < least for u in range(k, a) if u in its)), None)
                if slow is not None:
                    for key in range(slow, a + 1, 40):
                        yield w.entry(F + "follow_stop", ego, key - 20, key, a + 10, name, optional=True)
        # Of several twitches of the lead the last one is followed; who has left the lane by then leads nobody.
        starts = next((k for k in range(b + 39, a - 1, -1) if k in its and its[k].v >= 0.3 and all(its[u].v < 0.3 for u in range(k - 10, k) if u in its)), None)
        gone = starts is not None and starts in rows and motor.get(starts, (name,))[0] != name
        other = next((motor[k][0] for k in range(b, b + 20) if k in motor and motor[k][0] != name), None)
        moves = next((k for k in range(b + 39, a - 1, -1) if other and k in w.rows[other] and w.rows[other][k].v >= 0.3 and all(w.rows[other][u].v < 0.3 for u in range(k - 10, k) if u in w.rows[other])), None)
        if moves is not None:
            yield w.entry(F + "follow_start", ego, moves, moves, b + 30, other, optional=True)
        fastest = max((rows[k].v for k in range(b, b + 60) if k in rows), default=0)
        if starts is not None and b - a >= 8 and 0.8 < fastest <= 2:
            # Whether who only moves up at a walking pace starts is open.
            yield w.entry(F + "follow_start", ego, starts, starts, b + 30, name, optional=True)
        if starts is not None and b - a >= 8 and fastest > 2:
            yield w.entry(F + "follow_start", ego, starts, starts, b + 30, name,
                          optional=aside or gone or gap > 13 or inside(a) or b - starts > 45 or b < starts or b - a < 13 or released(w, ego, starts) or starts - 10 < a or not rests(a, b))


def brief(w, ego, motor):
    """Halts of less than half a second behind a lead, by the ego's speed or nearly: whether it stands is open."""
    rows = w.rows[ego]
    for a, b in spans([k for k, o in rows.items() if o.v < 0.6], gap=5):
        if a not in motor or motor[a][1] > 18 or a - 30 not in rows or any(h[0] <= b and h[1] >= a for h in stood(rows)):
            continue
        name, its = motor[a][0], w.rows[motor[a][0]]
        slow = next((k for k in range(a - 200, a + 1) if k in its and its[k].v < 2 and all(its[u].v < 2 for u in range(k, a) if u in its)), a)
        close = next((k for k in range(slow, a + 1) if k in motor and motor[k][0] == name and motor[k][1] < 5 * rows[k].v), a)
        for key in {slow, close, (close + a) // 2}:
            yield w.entry(F + "follow_stop", ego, key - 20, key, a + 10, name, optional=True)


def released(w, ego, k):
    """Whether a light at the end of its lane lets the ego's queue go: then its leaf is resume_follow."""
    # Where the road only widens it is the same approach.
    p = next((p for p in w.passing[ego] if p.first >= k and (p.node.real or p.link.tl)), None)
    return bool(p.link.tl) if p is not None else leads_to_light(w, w.rows[ego][k].lane)


def leads_to_light(w, lane):
    """Whether the next junction ahead of a lane has lights: for who never enters it within the log."""
    lanes = [lane]
    for _ in range(8):
        lanes = [w.net.after[x].via or w.net.after[x].to if x in w.net.after else x for x in lanes]
        if any(x.startswith(":") for x in lanes):
            continue
        links = [l for x in lanes for l in w.net.out.get(x, [])]
        if any(l.tl for l in links):
            return True
        if any(w.net.nodes[w.net.edges[l.a].b].real for l in links):
            return False
        lanes = list({l.to for l in links})
    return False


def steady(w, ego, motor, own_change):
    rows = w.rows[ego]

    def test(k, f):
        """The thresholds, made `f` times as wide."""
        name, gap = motor[k]
        o, its = rows[k], w.rows[name][k]
        return (gap < 3 * f * o.v or gap < 15) and o.v > 3.5 / f and abs(o.a) < 1 * f and abs(o.v - its.v) < 2 * f and its.v > 2

    names = {name for name, _ in motor.values()}
    for name in names:
        mine = [k for k in motor if motor[k][0] == name]
        # A moment beyond the thresholds is bridged; braking hard ends it.
        held = lambda keys, gap: [s for a, b in spans([k for k in mine if test(k, 1.5)]) for s in spans([k for k in keys if a <= k <= b], gap=gap)]
        exact = held([k for k in mine if test(k, 1)], 5)
        strict = held([k for k in mine if test(k, 0.85)], 3)
        loose = spans([k for k in mine if test(k, 1.15)], gap=10)
        done = []
        for a, b in strict:
            if b - a < 40 or own_change & set(range(a, b)):
                continue
            whole = next((s for s in exact if s[0] <= a and s[1] >= b), (a, b))
            around = next((s for s in loose if s[0] <= a and s[1] >= b), (a, b))
            if around in done:
                continue
            done.append(around)
            yield w.entry(F + "steady", ego, whole[0], whole[0], whole[1] + 1, name)
        for a, b in loose:
            if b - a >= 20:
                # Where the long relation is broken by a moment of harder braking, two episodes are as right as one.
                yield w.entry(F + "steady", ego, a, a, b + 1, name, optional=True)
                for s in exact:
                    if a <= s[0] and s[1] <= b and s[1] - s[0] >= 20:
                        yield w.entry(F + "steady", ego, s[0], s[0], s[1] + 1, name, optional=True)


def parting(w, ego):
    """Steady behind somebody who turns off where the ego does not: how long the ego follows is open."""
    rows = w.rows[ego]
    near = lambda o, its: (o.gap < 3.4 * o.v or o.gap < 17) and o.v > 3 and abs(o.v - its.v) < 2.3
    for name in {o.leader for o in rows.values() if o.leader in w.passing}:
        if w.kind(name) != "bicycle":
            for a, b in spans([k for k, o in rows.items() if o.leader == name and k in w.rows[name] and abs(o.a) < 3 and near(o, w.rows[name][k])], gap=10):
                if b - a >= 20 and not {w.rows[name][b].lane, w.rows[name][min(b + 20, max(w.rows[name]))].lane} & {rows[k].lane for k in range(a, b + 300) if k in rows}:
                    yield w.entry(F + "steady", ego, a, a, b + 1, name, optional=True)


def creeping(w, ego, motor):
    rows = w.rows[ego]
    near = lambda k: motor[k][1] < 15 or motor[k][1] < 3 * rows[k].v
    loose = spans([k for k in motor if 0.25 < rows[k].v < 4 and near(k)], gap=3)
    for a, b in loose:
        if b - a < 40:
            continue
        sure = [s for s in spans([k for k in range(a, b + 1) if k in motor and 0.4 < rows[k].v < 3.3 and near(k)]) if s[1] - s[0] >= 58]
        # "A stretch beginning from or ending in standstill is a start or stop."
        halts = any(rows[k].v < 0.5 for k in (*range(a - 20, a), *range(b + 1, b + 21)) if k in rows) or b + 40 > max(rows)
        # By a looser reading of standing it stops and starts within it.
        halts |= any(rows[k].v < 0.6 for k in range(a, b + 1) if k in rows)
        yield w.entry(F + "creeping", ego, a, (sure or [(a, b)])[0][0], b, motor[a][0] if len({motor[k][0] for k in range(a, b) if k in motor}) == 1 else None,
                      optional=not sure or halts)
    # The simulator's vehicles change lane sideways while their speed is near zero: whether they creep then is open.
    moved = lambda k: 5 * math.hypot(rows[k + 1].x - rows[k - 1].x, rows[k + 1].y - rows[k - 1].y) if k - 1 in rows and k + 1 in rows else rows[k].v
    for a, b in spans([k for k in motor if near(k) and 0.25 < moved(k) < 4], gap=3):
        if b - a >= 40 and any(moved(k) > rows[k].v + 0.3 for k in range(a, b + 1) if k in rows):
            yield w.entry(F + "creeping", ego, a, a, b, optional=True)


def congested(rows, halts, behind):
    """Stretches with two or more stops behind a lead within 60 s of each other, never above 30 km/h between."""
    out = []
    for a, b in halts:
        if behind(a) is None:
            continue
        if out and a - out[-1][1] < 600 and all(rows[k].v < 8.6 for k in range(out[-1][1], a) if k in rows):
            out[-1][1], out[-1][2] = b, out[-1][2] + 1
        else:
            out.append([a, b, 1])
    return [tuple(s) for s in out if s[2] >= 2]


def braking(w, ego, lead):
    for name in {n for n, _ in lead.values()}:
        if w.kind(name) == "bicycle":
            continue
        its = w.rows[name]
        hard = spans([k for k in its if its[k].a < -2.7])
        for n, (a, b) in enumerate(hard):
            strict = [k for k in range(a, b + 1) if its[k].a < -3.3]
            exact = next((k for k in range(a, b + 1) if its[k].a <= -3), a)
            followed = all(lead.get(k, (None,))[0] == name for k in range(exact - 10, exact))
            if b - a >= 3 and exact in lead and lead[exact][0] == name:
                # "Followed for 1 s or more": by time or by distance, all along.
                near = followed and all(lead[k][1] < 2.85 * w.rows[ego][k].v or lead[k][1] < 14 for k in range(exact - 10, exact))
                # "One that has just moved in and is not yet followed": until 3 s after it crossed the line.
                joined = any(exact - 30 < c.k <= exact for c in w.changes[name])
                # Who is 1 s or more ahead and hardly slower than the ego after it need not oblige it to anything.
                eased = lead[exact][1] > w.rows[ego][exact].v and min(its[k].v for k in range(exact, b + 11) if k in its) > w.rows[ego][exact].v - 2
                yield w.entry(F + "lead_sudden_brake", ego, exact - 10, exact, b + 10, name, optional=len(strict) < 7 or not near or joined or eased or n and a - hard[n - 1][1] < 20)
                continue
            if b - a >= 3 and exact in w.rows[ego] and w.rows[ego][exact].leader == name:
                # Ahead in its lane still, into one beside the ego's way: whether the ego follows it is open.
                yield w.entry(F + "lead_sudden_brake", ego, exact - 10, exact, b + 10, name, optional=True)


def track(w, name, a, b):
    return [(k, w.rows[name][k]) for k in range(a, b + 1) if k in w.rows[name]]


def people(w, ego):
    """vru_crossing: the track of a person (or rider) crosses the ego's own within 4 s, or the ego stands for it.
    Required only for people on a crossing, when the ego plainly slowed for them and no light held it.
    """
    lead = leads(w, ego)
    yield from braking(w, ego, lead)
    rows = w.rows[ego]
    mine = sorted(rows)
    for name in w.rows:
        person = w.first(name).person
        if name == ego or not person and w.kind(name) != "bicycle":
            continue
        its = w.rows[name]
        shared = [k for k in mine if k in its]
        if not shared or min(math.hypot(rows[k].x - its[k].x, rows[k].y - its[k].y) for k in shared) > 30:
            continue
        for p in w.passing[ego]:
            lo, hi = p.first - 200, p.last + 60
            place = None
            for k in range(max(lo, mine[0]), min(hi, mine[-1]), 2):
                o = rows[k]
                for u in range(k - 150, k + 80, 2):
                    q = its.get(u)
                    if q and abs(q.x - o.x) + abs(q.y - o.y) < 2.5 and 30 < abs(bend(o.angle, q.angle)) < 150 and q.v > 0.3:
                        if place is None or abs(u - k) < abs(place[1] - place[0]):
                            place = (k, u)
            if place is None:
                continue
            k, u = place
            band = next((t for t in range(u - 150, u + 1) if t in its and t in rows and math.hypot(its[t].x - its[u].x, its[t].y - its[u].y) < 7
                         and math.hypot(rows[t].x - rows[k].x, rows[t].y - rows[k].y) < 50), None)
            if band is None or k < band:
                continue
            before = [rows[t].v for t in range(u - 60, k + 1) if t in rows]
            # From a speed that it had before: who starts from standstill has not slowed.
            slowed = any(fast - v > 2.5 for fast, v in zip(accumulate(before, max), before))
            # No light held it while it slowed, either.
            green = all(w.letter(p.link, t) in (None, "G", "g") for t in range(u - 40, u + 1))
            # Behind who waits for them first, that one is the nearest cause of the stop.
            queued = u in lead and lead[u][1] + w.length(lead[u][0]) < math.hypot(rows[u].x - its[u].x, rows[u].y - its[u].y) if u in rows else False
            sure = person and w.net.on_crossing(its[u].lane) and 8 < k - u < 35 and slowed and green and not queued
            for leaf in ("crosswalk",) if sure else ("crosswalk", "horizontal", "diagonal"):
                yield w.entry(f"reactive_agent.vru_crossing.{leaf}", ego, band, band, u + 30, name, optional=not sure)
            break


def near_misses(w, ego):
    """The simulator's surrogate measures: every encounter near the thresholds leaves room, all else is no near miss."""
    for c in w.ssm:
        if ego not in (c.get("ego"), c.get("foe")):
            continue
        other = c.get("foe") if c.get("ego") == ego else c.get("ego")
        for part in ("minTTC", "PET"):
            m = c.find(part)
            if m is not None and m.get("time") not in (None, "NA"):
                k = round(float(m.get("time")) * 10)
                yield w.entry("safety.near_miss.general", ego, k - 20, k, k + 20, other, optional=True)
