"""What SUMO's drivers do at times although no model of theirs is made for it, from positions: wandering over lines and
back, leads that clear the view, close encounters, meetings in narrow room. Why they do so, and what could be seen, the
simulator does not say: all entries are optional.
"""

import math
from collections import defaultdict

from world import bend, off_line, spans

A = "reactive_agent.vehicle_abnormal."


def across(w, name):
    """By time: the position across the road (m, left positive within one edge), the edge, and whether a side is over
    the edge of its lane.
    """
    out = {}
    for k, o in w.rows[name].items():
        lane = w.net.lanes.get(o.lane)
        if lane is None or o.lane.startswith(":"):
            continue
        side = off_line(lane.points, o.x, o.y)[1] * (-1 if w.net.left_hand else 1)
        out[k] = (lane.index * lane.width + side, lane.edge, abs(side) + w.width(name) / 2 > lane.width / 2)
    return out


def wandering(w, name):
    """Times over a line: for 4 s and more, or to and fro within 10 s."""
    places = across(w, name)
    runs = [(a, b) for a, b in spans([k for k, p in places.items() if p[2]], gap=3) if b > a]
    moved = lambda a, b: places[b][0] - places[a][0] if places[a][1] == places[b][1] else 0.0
    turns = [(a, b, round(moved(a, b) / 1.5)) for a, b in runs]
    for n, (a, b, to) in enumerate(turns):
        if b - a >= 40:
            yield a, b
        if n and a - turns[n - 1][1] < 100 and not (to and turns[n - 1][2] and (to > 0) == (turns[n - 1][2] > 0)):
            yield turns[n - 1][0], b


def encounters(w, ego):
    """By other: when it is within 55 m, and how far off."""
    found = defaultdict(dict)
    for k, o in w.rows[ego].items():
        for i in w.at[k]:
            p = w.rows[i][k]
            if i != ego and abs(p.x - o.x) < 55 and abs(p.y - o.y) < 55:
                found[i][k] = math.hypot(p.x - o.x, p.y - o.y)
    return found


def others(w, ego, lead):
    met = encounters(w, ego)
    yield from abnormal(w, ego, met)
    yield from reveals(w, ego, lead)
    yield from close_calls(w, ego, lead, met)
    yield from meetings(w, ego, met)
    yield from waits_for_people(w, ego, met)


def abnormal(w, ego, met):
    for name, near in met.items():
        if name not in w.passing:
            continue
        if name not in w.wandered:
            w.wandered[name] = list(wandering(w, name))
        for a, b in w.wandered[name]:
            seen = [k for k in range(a, b + 20) if k in near]
            if seen:
                for key in {seen[0], min(max(seen[0], (a + b) // 2), seen[-1]), seen[-1]}:
                    yield w.entry(A + "abnormal_motion", ego, seen[0], key, seen[-1], name, optional=True)
        # Who overtakes another comes towards the ego in a lane of its direction, or goes the wrong way before it.
        wrong = [k for k in near if (lane := w.net.lanes.get(w.rows[name][k].lane)) and not lane.id.startswith(":") and abs(bend(w.rows[name][k].angle, w.net.heading(lane.id))) > 120]
        for a, b in spans(wrong, gap=5):
            for key in {a, (a + b) // 2, b}:
                yield w.entry(A + "abnormal_motion", ego, a, key, b, name, optional=True)


def reveals(w, ego, lead):
    """A lead of a second or more leaves for another lane, and beyond it somebody stands or crawls in the ego's lane."""
    rows = w.rows[ego]
    for name in {n for n, _ in lead.values()}:
        led = [k for k, (n, _) in lead.items() if n == name]
        for c in w.changes[name]:
            before = [k for k in led if c.k - 60 <= k <= c.k]
            if len(before) < 10 or c.k not in rows:
                continue
            drives = {rows[k].lane for k in range(c.k, c.k + 150) if k in rows} | {c.a}
            around = [k for k in range(c.k - 30, c.k + 31, 10) if k in rows]
            slow = any(i not in (ego, name) and w.rows[i][k].lane in drives and w.rows[i][k].v < 3 and math.hypot(w.rows[i][k].x - rows[k].x, w.rows[i][k].y - rows[k].y) < 120
                       for k in around for i in w.at[k])
            if slow:
                for back in (0, 15, 30, 45):
                    yield w.entry(A + "cutout_reveal", ego, c.k - back - 10, c.k - back, c.k + 30, name, optional=True)


def points(w, name, o):
    """Front, middle and rear; a person's own place."""
    a, length = math.radians(o.angle), 0 if o.person else w.length(name)
    return [(o.x - math.sin(a) * length * f, o.y - math.cos(a) * length * f) for f in ((0,) if o.person else (0, 0.5, 1))]


def close_calls(w, ego, lead, met):
    """TTC to the leader under 2.2 s; and who comes to within 2.2 m of a place of the ego's, less than 2.1 s before or
    after it. The simulator's measures give one value for the whole of a long encounter, and none for people.
    """
    rows, N = w.rows[ego], "safety.near_miss.general"
    tight = [k for k, (n, gap) in lead.items() if n in w.rows and k in w.rows[n] and rows[k].v - w.rows[n][k].v > 0.3 and gap / (rows[k].v - w.rows[n][k].v) < 2.2]
    for a, b in spans(tight, gap=5):
        for key in {a, (a + b) // 2, b}:
            if key in lead:
                yield w.entry(N, ego, a, key, b, lead[key][0], optional=True)
    # Who stands beside its lane, aslant.
    for name, at in met.items():
        its = w.rows[name]
        close = []
        for k, d in at.items():
            o, q, a = rows[k], its[k], math.radians(rows[k].angle)
            if q.v < 1 and o.v > 1.5 and d < 30 and name in w.passing:
                ahead = (q.x - o.x) * math.sin(a) + (q.y - o.y) * math.cos(a) - w.length(name)
                beside = abs((q.x - o.x) * math.cos(a) - (q.y - o.y) * math.sin(a))
                if abs(bend(o.angle, q.angle)) > 8 and beside < 4 and ahead < 2.5 * o.v:
                    close.append(k)
        for a, b in spans(close, gap=5):
            for key in {a, (a + b) // 2, b}:
                yield w.entry(N, ego, a, key, b, name, optional=True)
    for name, at in met.items():
        its, near, hits = w.rows[name], [k for k, d in at.items() if d < 25], []
        for k in near[::2]:
            own = points(w, ego, rows[k])
            for u in range(k - 21, k + 22, 3):
                q = its.get(u)
                if q is None or not q.person and abs(bend(rows[k].angle, q.angle)) < 20 or rows[k].v < 0.3 and q.v < 0.3:
                    continue
                if any(abs(x - x2) < 2.2 and abs(y - y2) < 2.2 for x, y in own for x2, y2 in points(w, name, q)):
                    hits.append(k)
                    break
        for a, b in spans(hits, gap=6):
            for key in {a - 10, a, (a + b) // 2, b}:
                yield w.entry(N, ego, a - 10, key, b, name, optional=True)


def meetings(w, ego, met):
    """Oncoming, level with the ego at less than 2.5 m, while the ego brakes, stands or moves aside."""
    rows = w.rows[ego]
    own = across(w, ego)
    for name, at in met.items():
        its = w.rows[name]
        level = [k for k, d in at.items() if d < 9 and name in w.passing and abs(bend(rows[k].angle, its[k].angle)) > 135]
        for a, b in spans(level, gap=10):
            before = [k for k in range(a - 80, b + 1) if k in rows]
            slows = any(rows[k].a < -0.9 or rows[k].v < 1.2 for k in before)
            aside = any(k in own and k - 10 in own and own[k][1] == own[k - 10][1] and abs(own[k][0] - own[k - 10][0]) > 0.15 for k in before)
            if slows or aside:
                for leaf in ("narrow_road", "large_vehicle"):
                    for back in (0, 15, 30, 50):
                        yield w.entry("reactive_agent.passing." + leaf, ego, a - back - 10, a - back, b, name, optional=True)


def waits_for_people(w, ego, met):
    """People and riders who go across ahead while the ego brakes or waits: whether it does so for them, nobody says."""
    rows = w.rows[ego]
    for name, at in met.items():
        its = w.rows[name]
        if not (w.first(name).person or w.kind(name) == "bicycle"):
            continue
        hits = []
        for k, d in at.items():
            o, q = rows[k], its[k]
            a = math.radians(o.angle)
            ahead = (q.x - o.x) * math.sin(a) + (q.y - o.y) * math.cos(a)
            slow = o.v < 2 or any(rows[u].a < -0.9 for u in range(k - 20, k + 40, 5) if u in rows)
            # At the end of a crossing that they take soon people turn towards it, and wait for who drives there.
            across = w.net.on_crossing(q.lane) or 20 < abs(bend(o.angle, q.angle)) < 160
            if d < 35 and ahead > -4 and slow and (across and q.v > 0.2 or q.person and w.net.at_crossing(q.lane) and any(u in its and w.net.on_crossing(its[u].lane) for u in range(k, k + 100, 3))):
                hits.append(k)
        for a, b in spans(hits, gap=10):
            for key in range(a - 20, b + 1, 20):
                for leaf in ("crosswalk", "horizontal", "diagonal"):
                    yield w.entry(f"reactive_agent.vru_crossing.{leaf}", ego, key, key, b, name, optional=True)
