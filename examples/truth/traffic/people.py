"""vru_crossing.crosswalk: people (and riders) who cross the way that the ego then drove, and for whom it slows or waits."""

import math

from log import runs


def crossings(run, ego, all_passages, lead):
    """A person goes from one side of the ego's driven way to the other (their polylines cross), within 50 m ahead of the ego at the time.

    Keyframe: it enters the band of 7 m beside the way. Sure: the ego gets there after the person and came down under 2 m/s within
    20 m of the place meanwhile, on its own account: not behind a leader that stood between, not held by a red light before the place. Others within
    8 s of each other are optional. Signals other than that (arrival 4 s apart) are the taxonomy's. Who comes into the band to a crosswalk, stands
    there (under 0.5 m/s) and lets the ego go by was about to cross (taxonomy, crosswalk against crosswalk_limit): whether the ego slowed for
    that person the simulator does not say, so it is optional.
    """
    rows = run.rows[ego]
    keys = sorted(rows)
    xy = [(rows[k].x, rows[k].y) for k in keys]
    way = [0.0]
    for a, b in zip(xy, xy[1:]):
        way.append(way[-1] + math.dist(a, b))
    at = dict(zip(keys, way))
    x0, x1 = min(x for x, _ in xy) - 20, max(x for x, _ in xy) + 20
    y0, y1 = min(y for _, y in xy) - 20, max(y for _, y in xy) + 20
    coarse = xy[::10]
    stride = [i for i in range(len(keys)) if i == 0 or way[i] - way[max(0, i - 1)] > 0.005]
    for name in sorted(run.rows):
        its = run.rows[name]
        if not (next(iter(its.values())).person or run.kind(name) == "bicycle"):
            continue
        # Whoever is never near the way is not looked at closer.
        if not any(k in at and min((x - o.x) ** 2 + (y - o.y) ** 2 for x, y in coarse) < 400 for k, o in its.items() if k % 20 == 0):
            continue
        place = []
        for k in sorted(its):
            o = its[k]
            if k in at and x0 < o.x < x1 and y0 < o.y < y1:
                # Roughly, then exactly.
                far = lambda i: (xy[i][0] - o.x) ** 2 + (xy[i][1] - o.y) ** 2
                about = min(range(0, len(stride), 12), key=lambda n: far(stride[n]))
                j = min(stride[max(0, about - 12): about + 13], key=far)
                if far(j) > 400:
                    continue
                n = min(j + 8, len(xy) - 1)
                m = max(n - 16, 0)
                dx, dy = xy[n][0] - xy[m][0], xy[n][1] - xy[m][1]
                off = math.hypot(xy[j][0] - o.x, xy[j][1] - o.y)
                side = dx * (o.y - xy[j][1]) - dy * (o.x - xy[j][0])
                place.append((k, math.copysign(off, side), way[j], o))
        # The front is at `at`; up to where its middle has passed, and a meter more than the band.
        band = [(k, off, o) for k, off, s, o in place if abs(off) < 8 and -3 < s - at[k] < 50]
        for first, last in runs([k for k, _, _ in band]):
            here = [(k, off, o) for k, off, o in band if first <= k <= last]
            if any(o.speed < 0.5 and o.lane.startswith(":") and ("_c" in o.lane or "_w" in o.lane) for _, _, o in here):
                enter = next((k for k, off, _ in here if abs(off) < 7), first)
                yield run.entry("reactive_agent.vru_crossing.crosswalk", ego, enter, enter, last, name, optional=True)
        # Beside the last of the way that the log shows: where the ego goes on to, and so who crosses that, is not known.
        ends = [k for k, _, s, o in place if way[-1] - s < 1 and way[-1] - at[k] < 15]
        for first, last in runs(ends, gap=10):
            for leaf in ("crosswalk", "horizontal", "diagonal"):
                yield run.entry(f"reactive_agent.vru_crossing.{leaf}", ego, first, first, last, name, optional=True)
        for u, v in zip(place, place[1:]):
            if v[0] - u[0] != 1 or u[1] * v[1] >= 0 or abs(u[1]) > 1 or abs(v[1]) > 1:
                continue
            k, s = v[0], v[2]
            ego_k = next((q for q in keys if at[q] >= s), None)
            ahead = s - at[k]
            if ego_k is None or not 0.5 < ahead < 50 or ego_k < k:
                continue
            enter = k
            near = {q[0]: q for q in place}
            while enter - 1 in near and abs(near[enter - 1][1]) < 7 and near[enter - 1][2] - at[enter - 1] < 50:
                enter -= 1
            leave = next((q[0] for q in place if q[0] > k and abs(q[1]) > 1.5), k + 30)
            on_crosswalk = v[3].lane.startswith(":") and "_c" in v[3].lane
            window = range(enter, k + 1)
            waited = min((rows[q].speed for q in window if q in rows and s - at[q] < 20), default=99)
            led = any(q in lead and lead[q][1] < s - at[q] - 1 for q in window)
            red = any(p.link.tl and p.first > q and run.light(p.link, q)[0] in "ry" for p in all_passages[ego][:0] for q in window)
            held = any(p.link.tl and enter <= p.first and at.get(p.first, 0) <= s + 15 and any(run.light(p.link, q)[0] in "ru" and at[q] < at[p.first] for q in window if q in at) for p in all_passages[ego])
            sure = waited < 1.5 and not led and not held and on_crosswalk and ego_k - k < 80 and enter in rows and rows[enter].speed > 0.5
            slows = waited < 1.5 or min((rows[q].accel for q in window if q in rows), default=0) < -0.9
            if not sure and ego_k - k > 120 and not slows:
                continue
            leaves = ["crosswalk"] if sure else ["crosswalk", "horizontal", "diagonal"]
            for leaf in leaves:
                yield run.entry(f"reactive_agent.vru_crossing.{leaf}", ego, enter, enter, leave, name, optional=not sure)
            break
