"""Road networks of the nineteenth held group, of a town by a lake and what surrounds it: a bent ring road with slip lanes
and a priority road that turns off, around streets where riders and people go; a suburban road lined with driveways,
whose middle lane serves left turns of both directions; for traffic on the left a trunk road with climbing lanes, villages
and a dual carriageway behind a roundabout; a motorway whose lanes drop one after the other, with collector lanes on
which loops weave.
"""

import math
import re

from networks import document, edge, link, node, ring, smooth, two_way
from networks_gateway import stations
from networks_newtown import boxed, ease
from networks_outskirts import ahead, lifted


def along(heading, forward, right=0.0):
    """A step so far along a heading (radians) and to its right."""
    return (forward * math.cos(heading) + right * math.sin(heading), forward * math.sin(heading) - right * math.cos(heading))


def curve(a, b, start, end, pull=0.5, n=8):
    """A Bezier curve from a to b that leaves and arrives by headings (radians)."""
    d = math.dist(a, b) * pull
    (px, py), (qx, qy) = along(start, d), along(end, -d)
    c, e = (a[0] + px, a[1] + py), (b[0] + qx, b[1] + qy)
    mix = lambda t: tuple(a[i] * (1 - t) ** 3 + 3 * c[i] * t * (1 - t) ** 2 + 3 * e[i] * t * t * (1 - t) + b[i] * t**3 for i in (0, 1))
    return [mix(k / n) for k in range(n + 1)]


def heading(a, b):
    return math.atan2(b[1] - a[1], b[0] - a[0])


def moved(p, step):
    return (p[0] + step[0], p[1] + step[1])


def flows(rows, seconds, tag):
    """(type, from, to, every so many seconds, further attributes) as flows."""
    return [f'<flow id="{tag}{i}" type="{kind}" begin="{begin}" period="{p}" number="{int(seconds / p)}" from="{a}" to="{b}" departLane="best"{more}/>'
            for i, (kind, a, b, p, more) in enumerate(rows) for begin in [round(i * 1.7 % p, 1)]]


def halts(tag, kind, a, b, period, number, *stops):
    inner = "".join(f'<stop lane="{at}" endPos="{pos}" duration="{seconds}"/>' for at, pos, seconds in stops)
    return f'<flow id="{tag}" type="{kind}" begin="3" period="{period}" number="{number}" from="{a}" to="{b}">{inner}</flow>'


def walkers(rows):
    return [f'<personFlow id="foot{i}" type="walker" begin="0" end="200" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(rows)]


def belt(work, draw):
    """A ring road of two lanes in each direction around an old town. At three crossings, which have lights, slip roads lead right:
    two give way where they end, one has a light there. At one junction the main road turns off outwards, and the
    ring goes on as the lesser road; one is a roundabout, at two the streets give way or stop. Inside, streets of 30
    km/h on which who comes from the right goes first, one main street that bends twice, a crossing at a school.
    """
    main, radial, street, back = "highway.primary", "highway.secondary", "highway.tertiary", "highway.residential"
    jolt = lambda most=9: draw.uniform(-most, most)
    angles = [14 + jolt(5), 63 + jolt(5), 112 + jolt(5), 163 + jolt(5), 213 + jolt(5), 262 + jolt(5), 317 + jolt(5)]
    radii = [318, 282, 330, 292, 322, 276, 312]
    at = lambda deg, r: (1.12 * r * math.cos(math.radians(deg)), r * math.sin(math.radians(deg)))
    hub = [at(a, r) for a, r in zip(angles, radii)]
    nodes, edges, links = [], [], []
    kinds = {0: "traffic_light", 1: "priority", 2: "traffic_light", 3: "priority", 4: "traffic_light", 5: "priority_stop"}
    nodes += [node(f"r{i}", *hub[i], kinds[i]) for i in kinds]
    out = [heading((0, 0), p) for p in hub]
    # The roundabout's nodes by angle: g0 to the outer road, g1 to the next of the ring, g2 inwards, g3 to the one before.
    turned = [math.degrees(out[6]) % 360, math.degrees(out[6] + 1.48) % 360, math.degrees(out[6] + 3.1) % 360, math.degrees(out[6] - 1.62) % 360]
    order = sorted(range(4), key=lambda k: turned[k])
    ring(edges, nodes, "g", *hub[6], 27, 2, turned, 9.72)
    joint = {k: f"g{n}" for n, k in enumerate(order)}
    spot = {f"r{i}": hub[i] for i in kinds} | {joint[k]: (hub[6][0] + 27 * math.cos(math.radians(turned[k])), hub[6][1] + 27 * math.sin(math.radians(turned[k]))) for k in range(4)}
    first, last = lambda i: f"r{i}" if i < 6 else joint[1], lambda i: f"r{i}" if i < 6 else joint[3]

    def arc(i, j):
        """Points of the ring from hub i to the next."""
        a, b = spot[first(i)], spot[last(j)]
        pa, pb = math.atan2(a[1], a[0] / 1.12), math.atan2(b[1], b[0] / 1.12)
        sweep, ra, rb = (pb - pa) % (2 * math.pi), math.hypot(a[0] / 1.12, a[1]), math.hypot(b[0] / 1.12, b[1])
        return [at(math.degrees(pa + sweep * t), ra + (rb - ra) * ease(t)) for t in (n / 14 for n in range(15))]

    def slip(name, a, b, pa, ha, pb, hb, right, lanes=1):
        """From node a to node b in a turn to the right, leaving the lane that begins `right` m right of the line."""
        start, end = moved(pa, along(ha, 5, right)), moved(pb, along(hb, -6, 3.4))
        edges.append(edge(name, a, b, lanes, 8.33, radial, 4, curve(start, end, ha, hb + math.radians(16), 0.42)))

    slips = {0: "priority", 2: "traffic_light", 4: "priority"}
    far = {i: moved(hub[i], along(out[i] + jolt(0.08), 225 + jolt(20))) for i in (0, 1, 2, 3, 4, 5, 6)}
    nodes += [node(f"o{i}", *p) for i, p in far.items()]
    for i in range(7):
        j = (i + 1) % 7
        points, a, b = arc(i, j), first(i), last(j)
        limit, rank = (16.67, 10) if (i, j) != (3, 4) else (13.89, 6)
        # Against the clock's direction the ring's outer lanes reach the slip roads.
        if j in slips:
            cut = len(points) - 4
            nodes.append(node(f"a{j}", *points[cut]))
            edges += [edge(f"{a}a{j}", a, f"a{j}", 2, limit, main, rank, points[:cut + 1]), edge(f"a{j}{b}", f"a{j}", b, 3, limit, main, rank, points[cut:])]
            links += ahead(f"{a}a{j}", f"a{j}{b}", (0, 0), (1, 1), (1, 2)) + ahead(f"{a}a{j}", f"slip{j}", (0, 0))
            beyond = moved(hub[j], along(heading(hub[j], far[j]), 48))
            nodes.append(node(f"b{j}", *beyond, slips[j]))
            slip(f"slip{j}", f"a{j}", f"b{j}", points[cut], heading(points[cut], points[cut + 1]), beyond, heading(hub[j], far[j]), 3.4)
            edges += [edge(f"{b}b{j}", b, f"b{j}", 1, 13.89, radial, 8), edge(f"b{j}o{j}", f"b{j}", f"o{j}", 1, 13.89, radial, 8), edge(f"o{j}{b}", f"o{j}", b, 1, 13.89, radial, 8, bay=50)]
        else:
            edges.append(edge(a + b, a, b, 2, limit, main, rank, points))
        edges.append(edge(b + a, b, a, 2, limit, main, rank, points[::-1], bay=45 if i in (0, 2, 4) else 0))
    two_way(edges, "o1", "r1", 1, 13.89, radial, 6)
    two_way(edges, "o3", "r3", 2, 16.67, main, 10)
    two_way(edges, "o5", "r5", 1, 13.89, radial, 6)
    two_way(edges, "o6", joint[0], 1, 13.89, radial, 6)
    inner = {"q0": (205, 38), "q1": (96, 128), "q2": (-72, 150), "q3": (-176, -6), "q4": (-118, -142), "q5": (8, -128), "q6": (150, -98), "c": (14, 12), "x": (-40, 262), "s": (-30, 82)}
    inner = {n: (x + jolt(8), y + jolt(8)) for n, (x, y) in inner.items()}
    kinds = {"q0": "priority", "q1": "right_before_left", "q2": "priority", "q3": "right_before_left", "q4": "allway_stop", "q5": "priority", "q6": "right_before_left", "c": "priority"}
    nodes += [node(n, *p, kinds[n]) for n, p in inner.items() if n in kinds]
    # The school's crossing between q2 and the middle.
    nodes.append(boxed(node("s", *inner["s"]), *inner["s"], heading(inner["c"], inner["q2"]), 2.2, 2.2, 7, 7))
    for a, b, kind, rank, limit in (("r0", "q0", street, 8, 11.11), ("q0", "q1", street, 8, 11.11), ("q1", "r1", back, 4, 8.33), ("r2", "q2", street, 8, 11.11), ("q2", "s", street, 8, 8.33), ("s", "c", street, 8, 8.33), ("c", "q5", street, 8, 11.11), ("q5", "r5", street, 8, 11.11), ("q5", "q4", back, 4, 8.33),
                                    ("q4", "r4", street, 7, 11.11), ("q4", "q3", back, 4, 8.33), ("q3", "c", back, 4, 8.33), ("q3", "q2", back, 4, 8.33), ("q1", "c", back, 4, 8.33), ("q0", "q6", back, 4, 8.33), ("q6", "q5", back, 4, 8.33), ("q6", joint[2], street, 5, 11.11), ("q1", "q2", back, 4, 8.33)):
        two_way(edges, a, b, 1, limit, kind, rank)
    links.append('<crossing node="s" edges="q2s sq2" priority="true" width="4"/>')
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    ins = {0: "o0r0", 1: "o1r1", 2: "o2r2", 3: "o3r3", 4: "o4r4", 5: "o5r5", 6: "o6" + joint[0]}
    outs = {0: "b0o0", 1: "r1o1", 2: "b2o2", 3: "r3o3", 4: "b4o4", 5: "r5o5", 6: joint[0] + "o6"}
    pairs = ((0, 3, 19), (3, 0, 17), (2, 5, 23), (5, 2, 25), (4, 1, 29), (1, 4, 27), (6, 3, 21), (3, 6, 23), (0, 2, 31), (2, 0, 33), (4, 6, 31), (6, 4, 29), (3, 2, 27), (1, 0, 37), (5, 4, 35), (4, 3, 33), (0, 6, 37))
    rows = [("truck" if n == 6 else "car", ins[a], outs[b], p, "") for n, (a, b, p) in enumerate(pairs)]
    rows += [("quick", ins[3], outs[0], 41, ""), ("car", "r0q0", outs[5], 43, ""), ("car", ins[2], "q4q3", 39, ""), ("car", "q3q2", outs[0], 47, "")]
    ride = [("cycle", a, b, p, "") for a, b, p in (("r2q2", "q5r5", 19), ("r5q5", "q2r2", 21), ("r0q0", "q1q2", 27), ("q4q3", "q2r2", 25), ("q6q0", "q1q2", 33), ("o5r5", "cs", 29))]
    (work / "parked.txt").write_text("\n".join([
        *flows(rows, 190, "way"), *flows(ride, 190, "ride"),
        *(halts(f"line{i}", "coach", a, b, p, 3, *((lane, pos, draw.randint(9, 15)) for lane, pos in stops)) for i, (a, b, p, stops) in enumerate(((ins[3], outs[0], 61, (("r2r1_0", 120),)), (ins[5], outs[2], 67, (("q5c_1", 50),)), (ins[0], outs[4], 71, (("q0q1_1", 60),))))),
        *(halts(f"post{i}", "van", a, b, p, 2, (lane, pos, draw.randint(20, 34))) for i, (a, b, lane, pos, p) in enumerate(((ins[0], outs[1], "q0q1_1", 90, 83), (ins[2], outs[5], "cq5_1", 70, 79), (ins[4], outs[3], "q4q3_1", 60, 89)))),
        *walkers((("q2s", "sq2", 9), ("sq2", "q2s", 10), ("q1c", "cs", 14), ("q5c", "cq3", 15), ("q0q1", "q1q2", 17), ("q4q3", "q3c", 19), ("q6q5", "q5q4", 18), ("q0q6", "q6q5", 23)))]))
    return ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 74, "--tls.yellow.time", 3, "--tls.left-green.time", 7, "--sidewalks.guess", "--sidewalks.guess.max-speed", 11.5, "--crossings.guess", "--crossings.guess.speed-threshold", 11.5]


def strip(work, draw):
    """A suburban road of two lanes in each direction and 72 km/h, with driveways at short distances on both sides; a lane in
    its middle serves those who turn left into them, of either direction by turns. Three crossings with lights, and
    islands beside which one turns right and gives way; between the last two a raised median, so that some turn
    round at the light. A crossing for people, buses and vans that stop in the lane; behind it streets with stop signs
    for all.
    """
    main, cross, drive, back = "highway.primary", "highway.secondary", "highway.service", "highway.residential"
    jolt = lambda most=9: draw.uniform(-most, most)
    y = lambda x: 34 * math.sin(x / 420) + 9 * math.cos(x / 150)
    tilt = lambda x: math.atan2(y(x + 4) - y(x - 4), 8)
    nodes, edges, links = [], [], []
    fast = 20.12
    xs = {"w": -960, "d1": -832 + jolt(), "d2": -742 + jolt(), "d3": -648 + jolt(), "S1": -500, "d4": -386 + jolt(), "d5": -300 + jolt(6), "m": -205, "d6": -112 + jolt(), "S2": 40, "S3": 470, "d7": 588 + jolt(), "d8": 676 + jolt(6), "d9": 768 + jolt(), "e": 930}
    sides = {"d1": (1,), "d2": (-1,), "d3": (1, -1), "d4": (-1,), "d5": (1,), "d6": (-1,), "d7": (1,), "d8": (-1,), "d9": (1, -1)}
    line = lambda a, b, off, n=30: [moved((x, yy), along(tilt(x), 0, -off)) for x, yy in stations(a, b, y, n)]
    for n, x in xs.items():
        if n == "m":
            nodes.append(boxed(node(n, x, y(x), "traffic_light"), x, y(x), tilt(x), 2.6, 2.6, 12, 12))
        else:
            nodes.append(node(n, x, y(x), "traffic_light" if n[0] == "S" else "priority"))
    names = list(xs)
    bayed = lambda n, side: n[0] == "S" or -side in sides.get(n, ())

    def carriage(a, b, xa, xb, bay, count=0):
        """From a to b; the middle lane belongs to it over its last `bay` meters, or all along if `count` is 3."""
        s = 1 if xb > xa else -1
        off = 1.6 * s if bay or count == 3 else -1.6 * s
        edges.append(edge(a + b, a, b, count or 2, fast, main, 10, line(xa, xb, off), bay=bay))

    def slip(name, a, b, pa, ha, pb, hb):
        start, end = moved(pa, along(ha, 5, 5.0)), moved(pb, along(hb, -6, 3.4))
        edges.append(edge(name, a, b, 1, 8.94, cross, 4, curve(start, end, ha, hb + math.radians(17), 0.42)))

    ends = {}
    for n, x in xs.items():
        for s in sides.get(n, ()) if n in sides else ():
            p = moved((x, y(x)), along(tilt(x) + s * math.pi / 2 + jolt(0.08), 74 + jolt(14)))
            ends[n + "ns"[s < 0]] = p
    for k, dx in (("1", 8), ("2", -12), ("3", 10)):
        for t, dy in (("n", 235 + jolt()), ("s", -225 + jolt())):
            ends[f"S{k}{t}"] = (xs["S" + k] + dx + jolt(), y(xs["S" + k]) + dy)
    for a, b in zip(names, names[1:]):
        xa, xb, gap = xs[a], xs[b], xs[b] - xs[a]
        if (a, b) == ("S2", "S3"):
            continue
        most = {True: 70, False: 0.42 * gap}
        for s, u, v in ((1, a, b), (-1, b, a)):
            long = round(most[v[0] == "S"] if v[0] == "S" and gap > 130 else min(45, most[False])) if bayed(v, s) else 0
            if (v == "S1" and s > 0) or (v == "S2" and s < 0) or (v == "S1" and s < 0):
                # Before the island.
                x = xs[v] - 62 * s
                n = f"a{v}{'ew'[s < 0]}"
                nodes.append(node(n, x, y(x)))
                edges.append(edge(u + n, u, n, 2, fast, main, 10, line(xs[u], x, -1.6 * s)))
                edges.append(edge(n + v, n, v, 3, fast, main, 10, line(x, xs[v], 1.6 * s)))
                links += ahead(u + n, n + v, (0, 0), (1, 1), (1, 2)) + ahead(u + n, "slip" + n, (0, 0))
            else:
                carriage(u, v, xs[u], xs[v], long)
    # Between S2 and S3 the directions are apart, and each driveway belongs to one of them.
    east, west = {"f1": 150 + jolt(), "f2": 262 + jolt(), "aS3e": 405}, {"f3": 350 + jolt(), "f4": 214 + jolt(), "aS2w": 104}
    for s, row, u, v in ((1, east, "S2", "S3"), (-1, west, "S3", "S2")):
        chain = [(u, xs[u]), *row.items(), (v, xs[v])]
        for n, x in row.items():
            nodes.append(node(n, x, y(x)))
            if n[0] == "f":
                ends[n + "x"] = moved((x, y(x)), along(tilt(x), 4, s * (80 + jolt())))
        for (a, xa), (b, xb) in zip(chain, chain[1:]):
            last = b == v
            edges.append(edge(a + b, a, b, 3 if last else 2, fast, main, 10, line(xa, xb, 1.6 * s if last else -1.6 * s)))
            if last:
                before = chain[-3][0] + a
                links += ahead(before, a + b, (0, 0), (1, 1), (1, 2)) + ahead(before, "slip" + a, (0, 0))
    nodes += [node(n, *p) for n, p in ends.items() if n[0] in "df"]
    for n in ends:
        if n[0] in "df":
            two_way(edges, n, n[:-1], 1, 6.71, drive, 2)
    # Streets across, with the end of an island's slip road on the way out.
    stops = {"S1n": "allway_stop", "S2n": "allway_stop", "S2s": "priority_stop", "S3n": "priority_stop", "S1s": "priority", "S3s": "priority"}
    nodes += [node(n, *p, stops[n]) for n, p in ends.items() if n in stops]
    islands = {"S1s": "aS1e", "S2n": "aS2w", "S1n": "aS1w", "S3s": "aS3e"}
    for n in stops:
        hub = n[:2]
        px, py = xs[hub], y(xs[hub])
        lanes = 2 if hub == "S2" else 1
        edges.append(edge(n + hub, n, hub, lanes, 15.65, cross, 8, bay=60))
        if n in islands:
            a = islands[n]
            dir_ = heading((px, py), ends[n])
            beyond = moved((px, py), along(dir_, 50))
            nodes.append(node("b" + n, *beyond))
            edges += [edge(hub + "b" + n, hub, "b" + n, lanes, 15.65, cross, 8), edge(f"b{n}{n}", "b" + n, n, lanes, 15.65, cross, 8)]
            x = xs[hub] + (-62 if a[-1] == "e" else 62) if a != "aS3e" and a != "aS2w" else (east | west)[a]
            slip("slip" + a, a, "b" + n, (x, y(x)), tilt(x) + (0 if a[-1] == "e" else math.pi), beyond, dir_)
        else:
            edges.append(edge(hub + n, hub, n, lanes, 15.65, cross, 8))
    rim = {"S1N": (-470, 480), "S2N": (20, 505), "S2S": (60, -470), "S3N": (505, 470), "S3S": (440, -450), "S1S": (-540, -455), "hw": (-760, 262), "he": (800, 270), "h": (-235, 268), "l": (255, -258)}
    rim = {n: (x + jolt(), yy + jolt()) for n, (x, yy) in rim.items()}
    nodes += [node(n, *p, "allway_stop" if n == "h" else "priority") for n, p in rim.items()] + [node("hs", rim["h"][0] + 14, rim["h"][1] + 150)]
    for a, b, limit, kind, rank in (("S1N", "S1n", 13.41, cross, 6), ("S2N", "S2n", 13.41, cross, 6), ("S2S", "S2s", 13.41, cross, 6), ("S3N", "S3n", 13.41, cross, 6), ("S3S", "S3s", 13.41, cross, 6), ("S1S", "S1s", 13.41, cross, 6),
                                    ("hw", "S1n", 11.18, back, 4), ("S1n", "h", 11.18, back, 4), ("h", "S2n", 11.18, back, 4), ("hs", "h", 11.18, back, 4), ("S2n", "S3n", 11.18, back, 4), ("S3n", "he", 11.18, back, 4), ("S2s", "l", 11.18, back, 4), ("l", "S3s", 11.18, back, 4), ("S1s", "S2s", 11.18, back, 4)):
        two_way(edges, a, b, 1, limit, kind, rank, shape=[moved(((ends | rim)[a][0] * (1 - t) + (ends | rim)[b][0] * t, (ends | rim)[a][1] * (1 - t) + (ends | rim)[b][1] * t), (0, 14 * math.sin(2 * math.pi * t))) for t in (k / 8 for k in range(9))] if (a, b) in (("S2n", "S3n"), ("S1s", "S2s")) else ())
    # Who has to turn round does it at S3.
    links.append('<crossing node="m" edges="d5m md5" width="4"/>')
    edges[:] = [r.replace(" numLanes", ' sidewalkWidth="2" numLanes') if re.match(r'<edge id="(d5m|md5|md6|d6m)"', r) else r for r in edges]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    rows = [(kind, a, b, p, ' departSpeed="max"') for kind, a, b, p in (("car", "wd1", "d9e", 9), ("car", "ed9", "d1w", 9), ("quick", "wd1", "d9e", 19), ("quick", "ed9", "d1w", 21), ("van", "wd1", "d9e", 37), ("truck", "ed9", "d1w", 49), ("truck", "wd1", "S2sS2S", 61))]
    rows += [("car", a, b, p, "") for a, b, p in (("wd1", "d3d3n", 33), ("ed9", "d3d3s", 37), ("wd1", "d5d5n", 31), ("ed9", "d6d6s", 27), ("ed9", "d4d4s", 31), ("d5nd5", "d9e", 39), ("d4sd4", "d1w", 37), ("d3nd3", "d9e", 41), ("d6sd6", "d9e", 35), ("f1xf1", "d1w", 31), ("f2xf2", "d1w", 33), ("ed9", "f1f1x", 43), ("wd1", "f3f3x", 41), ("f3xf3", "d9e", 47), ("wd1", "d7d7n", 29), ("wd1", "d9d9n", 35), ("ed9", "d8d8s", 31), ("d7nd7", "d9e", 43), ("d8sd8", "d1w", 45),
                                               ("S1NS1n", "d9e", 31), ("S1SS1s", "S1nS1N", 29), ("S2NS2n", "S2sS2S", 21), ("S2SS2s", "S2nS2N", 21), ("S3NS3n", "d1w", 29), ("S3SS3s", "d1w", 33), ("wd1", "S1sS1S", 27), ("ed9", "S2nS2N", 27), ("wd1", "S2nS2N", 31), ("ed9", "S2sS2S", 33), ("hwS1n", "S3nhe", 27), ("heS3n", "S1nhw", 25), ("hsh", "S1nhw", 31), ("hsh", "S3nhe", 33), ("S2NS2n", "S1nhw", 35), ("wd1", "S3sS3S", 35))]
    feet = (("d5m", "md5", 14), ("md5", "d5m", 15))
    (work / "parked.txt").write_text("\n".join([
        *flows([(kind, a, b, 1.5 * p, more) for kind, a, b, p, more in rows], 200, "way"),
        *(halts(f"line{i}", "coach", a, b, p, 3, *((lane, pos, draw.randint(9, 16)) for lane, pos in stops)) for i, (a, b, p, stops) in enumerate((("wd1", "d9e", 63, (("d2d3_0", 55), ("f1f2_0", 70))), ("ed9", "d1w", 67, (("d7S3_0", 40), ("d2d1_0", 60)))))),
        *(halts(f"post{i}", "van", a, b, p, 2, (lane, pos, draw.randint(28, 45))) for i, (a, b, lane, pos, p) in enumerate((("wd1", "d9e", "S1d4_0", 70, 85), ("ed9", "d1w", "d9d8_0", 50, 91), ("hwS1n", "S3nhe", "S1nh_0", 120, 79)))),
        *walkers(feet)]))
    return ["as drawn", "--no-turnarounds.except-turnlane", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 4, "--tls.left-green.time", 8]


def climb(work, draw):
    """Traffic on the left. A trunk road of one lane in each direction with stop signs and give-way lines at staggered side
    roads, and a village of 48 km/h with a light, a crossing for people and a bus stop; up the hill from either side a
    lane more, of which one ends by turns; lorries and tractors are slow there. Behind a roundabout the road is a dual
    carriageway that one leaves and joins by short slip roads.
    """
    trunk, side, lane, slip = "highway.trunk", "highway.secondary", "highway.tertiary", "highway.trunk_link"
    jolt = lambda most=9: draw.uniform(-most, most)
    y = lambda x: 62 * math.sin(x / 420) + 21 * math.cos(x / 171)
    z = lambda x: 34 * math.exp(-(((x - 260) / 520) ** 2))
    nodes, edges, links = [], [], []
    fast, slow = 26.82, 13.41
    xs = {"w": -1750, "k": -1390 + jolt(), "v1": -1085 + jolt(), "v2": -985 + jolt(), "v3": -880 + jolt(), "c0": -640, "c1": 60, "t1": 165 + jolt(), "t2": 235 + jolt(), "g1": 330, "g0": 940, "n0": 1085 + jolt(6)}
    kinds = {"k": "priority_stop", "v2": "traffic_light", "c1": "zipper"}
    nodes += [lifted(n, x, y(x), z(x), kinds.get(n, "priority")) for n, x in xs.items()]
    points = lambda a, b: [(x, yy, z(x)) for x, yy in stations(a, b, y, 40)]
    # The roundabout in front of the dual carriageway: its nodes by angle.
    centre, turned = (1295, y(1295)), [4, 96, 184, 262]
    for i, deg in enumerate(turned):
        nodes.append(node(f"h{i}", centre[0] + 30 * math.cos(math.radians(deg)), centre[1] + 30 * math.sin(math.radians(deg))))
    spot = lambda i: (centre[0] + 30 * math.cos(math.radians(turned[i])), centre[1] + 30 * math.sin(math.radians(turned[i])))
    for i in range(4):
        a, b = turned[i], turned[i - 1]
        sweep = (a - b) % 360
        edges.append(edge(f"hr{i}", f"h{i}", f"h{(i - 1) % 4}", 2, 11.18, side, 10, [(centre[0] + 30 * math.cos(math.radians(a - sweep * t / 8)), centre[1] + 30 * math.sin(math.radians(a - sweep * t / 8))) for t in range(9)]))
    edges.append(f'<roundabout nodes="{" ".join(f"h{i}" for i in range(4))}" edges="{" ".join(f"hr{i}" for i in range(4))}"/>')
    names = list(xs)
    for a, b in zip(names, names[1:]):
        village = {a, b} & {"v1", "v2", "v3"}
        limit = slow if len(village) == 2 else 20.12 if "n0" in (a, b) else fast
        more, back = a + b == "c0c1", a + b == "g1g0"
        bays = {"wk": (45, 0), "v1v2": (30, 0), "v2v3": (0, 30), "t1t2": (30, 30), "g0n0": (0, 0)}.get(a + b, (0, 0))
        two_way(edges, a, b, 1 + more, limit, trunk, 10, back=1 + back, shape=points(xs[a], xs[b]), bays=bays)
    links += [link("v3c0", "c0c1", 0, 0), link("v3c0", "c0c1", 0, 1), link("c0c1", "c1t1", 0, 0), link("c0c1", "c1t1", 1, 0)]
    # Up from the east the lane for overtaking ends without a joint: only the one on the left goes on.
    links += [link("n0g0", "g0g1", 0, 0), link("n0g0", "g0g1", 0, 1), link("g0g1", "g1t2", 0, 0)]
    two_way(edges, "n0", "h2", 1, 20.12, trunk, 10, shape=[(xs["n0"], y(xs["n0"]), z(xs["n0"])), (1180, y(1180), z(1180) / 2), (*spot(2), 0)])
    ends = {"kn": ("k", 1, 250), "ks": ("k", -1, 240), "v1s": ("v1", -1, 170), "v2n": ("v2", 1, 190), "v2s": ("v2", -1, 185), "v3n": ("v3", 1, 175), "t1n": ("t1", 1, 260), "t2s": ("t2", -1, 250), "n0s": ("n0", -1, 240)}
    place = {}
    for n, (at, sign, far) in ends.items():
        place[n] = (xs[at] + 20 * sign + jolt(25), y(xs[at]) + sign * far)
        nodes.append(lifted(n, *place[n], z(xs[at])))
        town = at[0] == "v"
        two_way(edges, n, at, 1, slow if town else 20.12, lane if town else side, 5, bays=(25, 0) if at in ("v2", "k", "t1") else (0, 0))
    # A lane behind the village; and who comes from the left, or the right, goes first by signs alone.
    two_way(edges, "v2n", "v3n", 1, slow, lane, 3)
    two_way(edges, "v1s", "v2s", 1, slow, lane, 3, shape=[place["v1s"], (place["v1s"][0] + 40, place["v1s"][1] - 25), (place["v2s"][0] - 30, place["v2s"][1] - 20), place["v2s"]])
    for n, p, at in (("vn", (place["v2n"][0] - 40, place["v2n"][1] + 210), "v2n"), ("vs", (place["v2s"][0] + 30, place["v2s"][1] - 220), "v2s"), ("hn", (centre[0] - 20, centre[1] + 290), "h1"), ("hs", (centre[0] + 25, centre[1] - 280), "h3")):
        nodes.append(node(n, *p))
        two_way(edges, n, at, 2 if at[0] == "h" else 1, 17.88, side, 6, shape=[p, spot(int(at[1]))] if at[0] == "h" else ())
    # The dual carriageway: eastwards on the north side.
    yd = lambda x: y(1295) + (x - 1330) * 0.05 + 40 * ease((x - 1400) / 900)
    td = lambda x: math.atan2(yd(x + 5) - yd(x - 5), 10)
    side_of = lambda x, s, more=4.0: moved((x, yd(x)), along(td(x), 0, -s * more))
    way = lambda a, b, s: [side_of(x, s) for x, _ in stations(a, b, yd, 40)]
    east = (("i1", 1690 + jolt()), ("i2", 1930 + jolt()), ("i3", 2110 + jolt()), ("ie", 2550))
    west = (("jw", 2550), ("j1", 2080 + jolt()), ("j0", 1950 + jolt()), ("j2", 1760 + jolt()), ("j3", 1600 + jolt()))
    for s, row in ((1, east), (-1, west)):
        nodes += [node(n, *side_of(x, s)) for n, x in row]
    dual = lambda name, a, b, lanes, shape, rank=11, limit=31.29: edges.append(edge(name, a, b, lanes, limit, trunk, rank, shape))
    at = dict(east + west)
    dual("h0i1", "h0", "i1", 2, [spot(0), *way(1360, at["i1"], 1)])
    dual("i1i2", "i1", "i2", 2, way(at["i1"], at["i2"], 1))
    dual("i2i3", "i2", "i3", 3, way(at["i2"], at["i3"], 1))
    dual("i3ie", "i3", "ie", 2, way(at["i3"], at["ie"], 1))
    dual("jwj1", "jw", "j1", 2, way(at["jw"], at["j1"], -1))
    dual("j1j0", "j1", "j0", 3, way(at["j1"], at["j0"], -1))
    dual("j0j2", "j0", "j2", 2, way(at["j0"], at["j2"], -1))
    dual("j2j3", "j2", "j3", 3, way(at["j2"], at["j3"], -1))
    dual("j3h0", "j3", "h0", 2, [*way(at["j3"], 1370, -1), spot(0)], 11, 20.12)
    links += ahead("h0i1", "i1i2", (0, 0), (1, 1)) + ahead("i1i2", "i2i3", (0, 1), (1, 2)) + ahead("i2i3", "i3ie", (1, 0), (2, 1))
    links += ahead("jwj1", "j1j0", (0, 1), (1, 2)) + ahead("jwj1", "j1j0", (0, 0)) + ahead("j1j0", "j0j2", (1, 0), (2, 1)) + ahead("j0j2", "j2j3", (0, 1), (1, 2)) + ahead("j2j3", "j3h0", (1, 0), (2, 1))
    # Slip roads to a lesser road that passes over the dual carriageway.
    bridge = {"b1": (1815, 190), "b2": (1835, -150)}
    for n, (x, dy) in bridge.items():
        bridge[n] = (x + jolt(5), yd(x) + dy)
        nodes.append(lifted(n, *bridge[n], 6.5))
    for n, far in (("b1", (30, 260)), ("b2", (-45, -250))):
        p = moved(bridge[n], far)
        nodes.append(lifted(n + "x", *p, 1))
        two_way(edges, n + "x", n, 1, 20.12, side, 8)
    two_way(edges, "b2", "b1", 1, 17.88, side, 8)

    def ramp(name, a, b, start, hs, end, he, rises):
        track = curve(start, end, hs, he, 0.5, 10)
        heights = [6.5 * (t if rises else 1 - t) for t in (ease(k / 10) for k in range(11))]
        edges.append(edge(name, a, b, 1, 15.65, slip, 6, [(*p, h) for p, h in zip(track, heights)]))

    ramp("off1", "i1", "b1", side_of(at["i1"] + 6, 1, 7.4), td(at["i1"]) + 0.06, moved(bridge["b1"], (-7, -3)), 0.6, True)
    ramp("on1", "b1", "i2", moved(bridge["b1"], (7, -3)), -0.7, side_of(at["i2"] - 6, 1, 7.4), td(at["i2"]) - 0.06, False)
    ramp("off2", "j0", "b2", side_of(at["j0"] - 6, -1, 7.4), td(at["j0"]) + math.pi + 0.06, moved(bridge["b2"], (7, 3)), math.pi + 0.6, True)
    ramp("on2", "b2", "j2", moved(bridge["b2"], (-7, 3)), math.pi - 0.7, side_of(at["j2"] + 6, -1, 7.4), td(at["j2"]) + math.pi - 0.06, False)
    links += ahead("h0i1", "off1", (0, 0)) + ahead("on1", "i2i3", (0, 0)) + ahead("j1j0", "off2", (0, 0)) + ahead("on2", "j2j3", (0, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    rows = [(kind, a, b, p, ' departSpeed="max"') for kind, a, b, p in (("car", "wk", "i3ie", 15), ("car", "jwj1", "kw", 14), ("car", "wk", "h1hn", 33), ("quick", "wk", "i3ie", 29), ("quick", "jwj1", "kw", 27), ("car", "jwj1", "h3hs", 23), ("car", "hnh1", "i3ie", 21), ("car", "hsh3", "kw", 25), ("car", "hsh3", "i3ie", 27), ("car", "hnh1", "kw", 31), ("van", "jwj1", "kw", 43),
                                                                         ("car", "jwj1", "b2b2x", 31), ("car", "hsh3", "b1b1x", 29), ("car", "b1xb1", "i3ie", 27), ("car", "b2xb2", "h1hn", 33), ("car", "b1xb1", "b2b2x", 37))]
    rows += [(kind, a, b, p, f' speedFactor="{f}"') for kind, a, b, p, f in (("truck", "wk", "i3ie", 47, 0.62), ("truck", "jwj1", "kw", 43, 0.58), ("van", "ksk", "n0n0s", 71, 0.42), ("van", "n0sn0", "kks", 73, 0.45), ("truck", "jwj1", "h1hn", 53, 0.75))]
    rows += [("car", a, b, p, "") for a, b, p in (("knk", "kks", 41), ("ksk", "v3c0", 37), ("knk", "i3ie", 39), ("t1nt1", "t2t2s", 33), ("t2st2", "t1t1n", 35), ("t1nt1", "h1hn", 41), ("t2st2", "kw", 43), ("vnv2n", "v2svs", 27), ("vsv2s", "v2nvn", 29), ("vnv2n", "kw", 31), ("vsv2s", "h1hn", 35), ("jwj1", "v2svs", 37), ("wk", "v2nvn", 39), ("n0sn0", "kw", 47), ("wk", "n0n0s", 49), ("wk", "t1t1n", 53), ("jwj1", "t2t2s", 51))]
    (work / "parked.txt").write_text("\n".join([
        *flows(rows, 200, "way"),
        *(halts(f"line{i}", "coach", a, b, p, 3, (stop, pos, draw.randint(10, 17))) for i, (a, b, p, stop, pos) in enumerate((("wk", "i3ie", 72, "v1v2_1", 60), ("jwj1", "kw", 77, "v2v1_1", 55)))),
        *walkers((("v1v2", "v2v3", 13), ("v2v3", "v3v2", 12), ("v2nv2", "v2v3", 19), ("v2sv2", "v2nv2", 17)))]))
    return ["as drawn", "--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 3, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.5, "--crossings.guess", "--crossings.guess.speed-threshold", 12]


def drops(work, draw):
    """A motorway of 130 km/h. Eastwards four lanes part into three and a collector road of two, which one ramp leaves, which
    a loop joins 220 m before another leaves it, and which a second ramp joins; meanwhile the left lane of the three
    ends; then both join as four lanes, of which the right one ends, and of the three left two become one by turns.
    Westwards three lanes with a plain exit, entries of short and long lanes, an exit by two lanes, and the right lane
    ending behind it. A fast road crosses on a bridge, with lanes on which the loops' ends weave.
    """
    main, link_, fast_road, high = "motorway", "motorway_link", "highway.trunk", 6.5
    jolt = lambda most=14: draw.uniform(-most, most)
    bow = lambda x: 46 * math.sin(x / 900) - 9 * math.cos(x / 260)
    tilt = lambda x: math.atan2(bow(x + 5) - bow(x - 5), 10)
    side_of = lambda x, off: moved((x, bow(x)), along(tilt(x), 0, -off))
    way = lambda a, b, off: [side_of(x, off) for x, _ in stations(a, b, bow, 60)]
    nodes, edges, links = [], [], []
    fast = 36.11
    east = (("e0", -2150, 4), ("e1", -1080 + jolt(), 3), ("e2", -160 + jolt(), 2), ("e3", 820 + jolt(), 4), ("e4", 1250 + jolt(), 3), ("e5", 1700 + jolt(), 2), ("e6", 2250, 0))
    west = (("w0", 2250, 3), ("w1", 1390 + jolt(), 3), ("w2", 980 + jolt(), 4), ("w3", 700 + jolt(), 3), ("w4", -330 + jolt(), 4), ("w5", -640 + jolt(), 3), ("w6", -1010 + jolt(), 4), ("w7", -1290 + jolt(), 2), ("w8", -1640 + jolt(), 3), ("w9", -1790 + jolt(), 2), ("wx", -2150, 0))
    at = {}
    for s, row in ((-1, east), (1, west)):
        off = 5.5 * s
        for n, x, _ in row:
            at[n] = x
            nodes.append(lifted(n, *side_of(x, off), 0, "zipper" if n == "e5" else "priority"))
        for (a, xa, lanes), (b, xb, _) in zip(row, row[1:]):
            edges.append(edge(a + b, a, b, lanes, fast, main, 13, way(xa, xb, off)))
    one = lambda a, b, n, more=0: ahead(a, b, *[(k, k + more) for k in range(n) if k + more >= 0])
    links += one("e0e1", "e1e2", 4, -1) + ahead("e1e2", "e2e3", (0, 0), (1, 1)) + one("e2e3", "e3e4", 2, 2) + one("e3e4", "e4e5", 4, -1) + ahead("e4e5", "e5e6", (0, 0), (1, 0), (2, 1))
    # The collector road leaves at e1 and joins at e3.
    cx = {"k0": at["e1"], "k1": -620 + jolt(), "k2": -118, "k3": 122, "k4": 380 + jolt(), "k5": 610 + jolt(), "k6": at["e3"]}
    beside = lambda x: -5.5 - 9.7 - 12 * ease((x - cx["k0"]) / 260) * ease((cx["k6"] - x) / 260)
    track = lambda a, b: [side_of(x, beside(x)) for x, _ in stations(a, b, bow, 30)]
    nodes += [lifted(n, *side_of(x, beside(x)), 0) for n, x in cx.items() if n not in ("k0", "k6")]
    chain = [("e1", "k0", 2), ("k1", "k1", 2), ("k2", "k2", 3), ("k3", "k3", 2), ("k4", "k4", 3), ("k5", "k5", 2), ("e3", "k6", 0)]
    for (a, xa, lanes), (b, xb, _) in zip(chain, chain[1:]):
        edges.append(edge(a + b, a, b, lanes, 25.0, link_, 9, track(cx[xa], cx[xb])))
    links += ahead("e0e1", "e1k1", (0, 0), (1, 1)) + one("e1k1", "k1k2", 2) + one("k1k2", "k2k3", 2, 1) + one("k2k3", "k3k4", 3, -1) + one("k3k4", "k4k5", 2, 1) + one("k4k5", "k5e3", 3, -1) + ahead("k5e3", "e3e4", (0, 0), (1, 1))
    # The road that crosses: both directions, from south (north) to north (south).
    ry = {"n": (("n0", -620), ("n1", -340), ("n2", -62), ("n3", 190), ("n4", 330), ("n5", 660)), "s": (("s0", 660), ("s1", 240), ("s2", 30), ("s3", -180), ("s4", -330), ("s5", -470), ("s6", -620))}
    cxs = lambda yy: 12 * math.sin(yy / 300)
    up = lambda yy: high * ease((320 - abs(yy)) / 170)
    for tag, row in ry.items():
        s = 1 if tag == "n" else -1
        place = lambda yy: (cxs(yy) + 4.5 * s, yy + bow(0), up(yy))
        nodes += [lifted(n, *place(yy)) for n, yy in row]
        for (a, ya), (b, yb) in zip(row, row[1:]):
            lanes = 3 if a + b in ("n2n3", "n3n4", "s1s2", "s3s4") else 2
            edges.append(edge(a + b, a, b, lanes, 22.22, fast_road, 9, [place(ya + (yb - ya) * t / 5) for t in range(6)]))
    links += one("n0n1", "n1n2", 2) + one("n1n2", "n2n3", 2, 1) + one("n2n3", "n3n4", 3) + one("n3n4", "n4n5", 3, -1)
    links += ahead("s0s1", "s1s2", (0, 0), (0, 1), (1, 2)) + one("s1s2", "s2s3", 3, -1) + one("s2s3", "s3s4", 2, 1) + one("s3s4", "s4s5", 3, -1) + one("s4s5", "s5s6", 2)
    spot = lambda n: next((cxs(yy) + 4.5 * (1 if n[0] == "n" else -1), yy + bow(0)) for m, yy in ry["n"] + ry["s"] if m == n)

    def ramp(name, a, b, speed, points, lift):
        """`lift`: heights of the first and the last point."""
        lo, hi = lift
        n = len(points) - 1
        edges.append(edge(name, a, b, 1, speed, link_, 7, [(*p, lo + (hi - lo) * ease(k / n)) for k, p in enumerate(points)]))

    down, north = -math.pi / 2, math.pi / 2
    cd = lambda x, more=3.2: side_of(x, beside(x) - more)
    # From the collector south; from the south onto it; both loops.
    ramp("ra", "k1", "s4", 16.67, curve(cd(cx["k1"] + 6), moved(spot("s4"), (-6.8, 8)), tilt(cx["k1"]) - 0.05, down, 0.33, 12), (0, up(-330)))
    ramp("rb", "n1", "k4", 16.67, curve(moved(spot("n1"), (6.8, 6)), cd(cx["k4"] - 6), north - 0.35, tilt(cx["k4"]) + 0.02, 0.33, 12), (up(-340), 0))
    x0, x1 = spot("s2")[0] - 10, spot("n2")[0] + 10
    ax, bx = cx["k2"] - 6, cx["k3"] + 6
    base = bow(0)
    west_loop = [(x0, base + 22), (x0 - 2, base - 30), (x0 - 14, base - 92), (x0 - 62, base - 138), (x0 - 130, base - 132), (x0 - 172, base - 88), (x0 - 160, base - 50), cd(ax - 18), cd(ax)]
    east_loop = [cd(bx), cd(bx + 18), (x1 + 165, base - 56), (x1 + 172, base - 100), (x1 + 128, base - 146), (x1 + 60, base - 150), (x1 + 14, base - 118), (x1 + 1, base - 88), (x1, base - 70)]
    ramp("lw", "s2", "k2", 12.5, smooth([west_loop[0], *west_loop, west_loop[-1]], 4), (up(30), 0))
    ramp("le", "k3", "n2", 12.5, smooth([east_loop[0], *east_loop, east_loop[-1]], 4), (0, up(-62)))
    links += ahead("e1k1", "ra", (0, 0)) + ahead("ra", "s4s5", (0, 0)) + ahead("n0n1", "rb", (0, 0)) + ahead("rb", "k4k5", (0, 0)) + ahead("s1s2", "lw", (0, 0)) + ahead("lw", "k2k3", (0, 0)) + ahead("k2k3", "le", (0, 0)) + ahead("le", "n2n3", (0, 0))
    # Westwards: a plain exit to the north at w3, an entry from the north at w4.
    nw = lambda x, more: side_of(x, 5.5 + more)
    ramp("rc", "w3", "n4", 18.06, curve(nw(at["w3"] - 6, 9.7), moved(spot("n4"), (6.8, -6)), tilt(at["w3"]) + math.pi - 0.04, north + 0.05, 0.6, 12), (0, up(330)))
    ramp("rd", "s1", "w4", 18.06, curve(moved(spot("s1"), (-6.8, 8)), nw(at["w4"] + 6, 9.7), down - 0.1, tilt(at["w4"]) + math.pi - 0.02, 0.6, 12), (up(240), 0))
    links += one("w0w1", "w1w2", 3) + one("w1w2", "w2w3", 3, 1) + one("w2w3", "w3w4", 4, -1) + one("w3w4", "w4w5", 3, 1) + one("w4w5", "w5w6", 4, -1) + one("w5w6", "w6w7", 3, 1) + ahead("w6w7", "w7w8", (2, 0), (3, 1)) + one("w7w8", "w8w9", 2, 1) + one("w8w9", "w9wx", 3, -1)
    links += ahead("w2w3", "rc", (0, 0)) + ahead("s0s1", "rd", (0, 0)) + ahead("rd", "w4w5", (0, 0))
    # Further ramps to and from roads that are not drawn: a plain exit, a short entry lane, an exit of two lanes.
    for name, a, b, x, lanes, sign, far in (("p1", "w1", "p1x", at["w1"], 1, -1, 330), ("p2", "p2x", "w2", at["w2"], 1, 1, 340), ("p6", "p6x", "w6", at["w6"], 1, 1, 360), ("p7", "w7", "p7x", at["w7"], 2, -1, 330), ("p8", "p8x", "w8", at["w8"], 1, 1, 300)):
        beyond = {"p1": 9.7, "p2": 9.7, "p6": 9.7, "p7": 6.5, "p8": 6.5}[name]
        outer = moved((x + sign * far, bow(x + sign * far)), (0, 120 + jolt(20)))
        nodes.append(lifted(a if sign > 0 else b, *outer, 14 if sign < 0 else 0))
        back = tilt(x) + math.pi
        if sign < 0:
            points = curve(nw(x - 6, beyond), outer, back - 0.05, back - 0.45, 0.45, 10)
        else:
            points = curve(outer, nw(x + 6, beyond), back + 0.45, back + 0.05, 0.45, 10)
        # What leaves passes over what joins.
        lift = 14 if sign < 0 else 0
        edges.append(edge(name, a, b, lanes, 22.22, link_, 7, [(*p, lift * ease(k / 10)) for k, p in enumerate(points)]))
    links += ahead("w0w1", "p1", (0, 0)) + ahead("p2", "w2w3", (0, 0)) + ahead("p6", "w6w7", (0, 0)) + ahead("w6w7", "p7", (0, 0), (1, 1)) + ahead("p8", "w8w9", (0, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    rows = (("truck", "e0e1", "e5e6", 13), ("truck", "w0w1", "w9wx", 12), ("car", "e0e1", "s5s6", 19), ("car", "e0e1", "n4n5", 13), ("car", "s0s1", "e5e6", 14), ("car", "n0n1", "e5e6", 21), ("car", "n0n1", "n4n5", 13), ("car", "s0s1", "s5s6", 12), ("car", "w0w1", "n4n5", 15), ("car", "s0s1", "w9wx", 17), ("car", "w0w1", "p1", 23), ("car", "p2", "w9wx", 23), ("car", "p6", "w9wx", 21), ("car", "w0w1", "p7", 15),
            ("car", "p2", "n4n5", 29), ("car", "p6", "p7", 33), ("car", "p8", "w9wx", 17), ("quick", "e0e1", "e5e6", 8), ("quick", "w0w1", "w9wx", 8), ("car", "e0e1", "e5e6", 5.1), ("car", "w0w1", "w9wx", 5.3), ("coach", "w0w1", "w9wx", 57), ("truck", "n0n1", "e5e6", 61), ("truck", "s0s1", "w9wx", 67), ("van", "s0s1", "e5e6", 41))
    (work / "parked.txt").write_text("\n".join(
        f'<flow id="flow{i}" type="{kind}" begin="0" period="{p}" number="{int(140 / p)}" from="{a}" to="{b}" departLane="{"best" if a[0] in "nsp" else 0 if kind in ("truck", "coach") else "random"}" departSpeed="max"/>'
        for i, (kind, a, b, p) in enumerate(rows)))
    return ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5]
