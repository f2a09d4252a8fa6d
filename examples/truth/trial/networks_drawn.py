"""Road networks whose shape is drawn from a seed: a street with what a town puts along it, a road between towns, a
motorway out of pieces, roundabouts of several lanes. `left` builds them for traffic on the left.
"""

import math

from networks import document, edge, generated, link, node, two_way

OPTIONS = ["--junctions.corner-detail", 5, "--junctions.scurve-stretch", 1]


def sided(options, left):
    return options + (["--lefthand"] if left else [])


def street(work, draw, left=False, limit=13.89, lanes=(1, 2, 2, 3), controls=("traffic_light", "priority", "priority"), walks=True, gap=(70, 150), count=6, slots=False):
    """A curved main street with crossroads, T-junctions and staggered pairs of side roads at drawn places, bays before
    some, a slot for U-turns, side roads with bends.
    """
    nodes, edges, xs = [], [], [-420.0]
    line = lambda x: 26 * math.sin(x / draw_phase) + 0.02 * x
    draw_phase = draw.uniform(110, 190)
    names = ["w"]
    kinds = ["priority"]
    sides = [""]
    x = -420.0
    for i in range(count):
        x += draw.uniform(*gap)
        shape = draw.choice(("cross", "tee", "stagger", "tee"))
        names.append(f"m{i}")
        xs.append(x)
        sides.append("ns" if shape == "cross" else draw.choice("ns"))
        kinds.append(draw.choice(controls))
        if shape == "stagger":
            x += draw.uniform(22, 40)
            names.append(f"h{i}")
            xs.append(x)
            sides.append("s" if sides[-1] == "n" else "n")
            kinds.append("priority")
    names.append("e")
    xs.append(x + draw.uniform(*gap))
    sides.append("")
    kinds.append("priority")
    nodes = [node(n, x, line(x), k) for n, x, k in zip(names, xs, kinds)]
    for (a, xa), (b, xb) in zip(zip(names, xs), list(zip(names, xs))[1:]):
        count_here = draw.choice(lanes)
        mid = [((xa + xb) / 2 + t * 0.2 * (xb - xa), line((xa + xb) / 2 + t * 0.2 * (xb - xa))) for t in (-1, 0, 1)] if xb - xa > 60 else []
        bay = 35 if xb - xa > 90 and count_here < 3 and draw.random() < 0.5 else 0
        two_way(edges, a, b, count_here, limit, "highway.secondary", 8, shape=mid, bays=(bay, 0) if kinds[names.index(b)] != "priority" else (0, 0))
    for n, x, side in zip(names, xs, sides):
        for s in side:
            sign = 1 if s == "n" else -1
            skew, length = draw.uniform(-45, 45), draw.uniform(120, 190)
            nodes.append(node(f"{n}{s}", x + skew, line(x) + sign * length))
            bend = [(x + skew * 0.15 + draw.uniform(-10, 10), line(x) + sign * length * 0.45)] if draw.random() < 0.5 else []
            two_way(edges, f"{n}{s}", n, draw.choice((1, 1, 2)), draw.choice((8.33, 13.89)), "highway.residential", 4, shape=bend)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return sided(OPTIONS + (["--sidewalks.guess", "--crossings.guess"] if walks else []) + ([] if slots else ["--no-turnarounds.except-deadend"]), left)


def country(work, draw, left=False):
    """A winding road of one lane each way between towns, fast, with side roads at acute angles, and a small roundabout."""
    nodes, edges, xs = [], [], []
    phase = draw.uniform(90, 150)
    line = lambda x: 60 * math.sin(x / phase) + 25 * math.sin(x / 61)
    xs = [-700 + i * 280 + draw.uniform(-40, 40) for i in range(6)]
    nodes = [node(f"r{i}", x, line(x), "priority") for i, x in enumerate(xs)]
    for i in range(5):
        a, b = xs[i], xs[i + 1]
        mid = [(a + (b - a) * t / 8, line(a + (b - a) * t / 8)) for t in range(1, 8)]
        two_way(edges, f"r{i}", f"r{i + 1}", 1, 22.22, "highway.secondary", 9, shape=mid)
    for i in range(1, 5):
        for sign in (1, -1) if i % 2 else (draw.choice((1, -1)),):
            nodes.append(node(f"s{i}{'n' if sign > 0 else 's'}", xs[i] + draw.uniform(-110, 110), line(xs[i]) + sign * 170))
            two_way(edges, f"s{i}{'n' if sign > 0 else 's'}", f"r{i}", 1, 13.89, "highway.tertiary", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return sided(OPTIONS, left)


def motorway(work, draw, left=False, pieces=("plain_exit", "entry", "drop", "exit", "added", "weave"), lanes=3, limit=30.56, typed=True):
    """One carriageway out of pieces: an exit without and with a lane of its own, an entry whose lane ends, one whose
    lane stays, a lane that ends, weaving. Bends between.
    """
    nodes, edges, links = [], [], []
    kind, ramp = ("highway.motorway", "highway.motorway_link") if typed else ("", "")
    x, n, y = -200.0 * len(pieces), 0, 0.0
    here = "k0"
    nodes.append(node(here, x, 0))
    outside = 1 if left else -1

    def go(metres, count, feeds):
        """One road further; `feeds` are links from the road before: (from lane, to lane)."""
        nonlocal x, n, y, here
        a, xa, ya = here, x, y
        x, y, n = x + metres, y + draw.uniform(-14, 14), n + 1
        here = f"k{n}"
        nodes.append(node(here, x, y))
        bow = draw.uniform(-10, 10)
        shape = [(xa + metres * t, ya + (y - ya) * t + bow * math.sin(math.pi * t)) for t in (0.25, 0.5, 0.75)] if metres > 180 else []
        edges.append(edge(f"c{n}", a, here, count, limit, kind, 13, shape))
        links.extend(link(f"c{n - 1}", f"c{n}", i, j) for i, j in feeds)
        return f"c{n}"

    def off(name, at, speed=16.67):
        nodes.append(node(name, x + 170, y + outside * 110))
        edges.append(edge(f"x{name}", at, name, 1, speed, ramp, 6, [(x + 70, y + outside * 14)]))
        return f"x{name}"

    def on(name, speed=19.44):
        nodes.append(node(name, x - 190, y + outside * 120))
        edges.append(edge(f"e{name}", name, here, 1, speed, ramp, 6, [(x - 70, y + outside * 16)]))
        return f"e{name}"

    straight = lambda count, up=0: [(i, i + up) for i in range(count)]
    go(320, lanes, [])
    for i, piece in enumerate(pieces):
        road = f"c{n}"
        if piece == "plain_exit":
            links.append(link(road, off(f"o{i}", here), 0, 0))
            go(260, lanes, straight(lanes))
        elif piece == "exit":
            lane = go(230, lanes + 1, straight(lanes, 1) + [(0, 0)])
            links.append(link(lane, off(f"o{i}", here), 0, 0))
            go(240, lanes, [(j + 1, j) for j in range(lanes)])
        elif piece == "entry":
            name = on(f"i{i}")
            lane = go(240, lanes + 1, straight(lanes, 1))
            links.append(link(name, lane, 0, 0))
            go(240, lanes, [(j + 1, j) for j in range(lanes)])
        elif piece == "added":
            name = on(f"i{i}")
            lane = go(300, lanes + 1, straight(lanes, 1))
            links.append(link(name, lane, 0, 0))
            lanes += 1
        elif piece == "drop":
            go(260, lanes - 1, [(j + 1, j) for j in range(lanes - 1)] if draw.random() < 0.5 else straight(lanes - 1))
            lanes -= 1
        elif piece == "weave":
            name = on(f"i{i}")
            lane = go(280, lanes + 1, straight(lanes, 1))
            links.append(link(name, lane, 0, 0))
            links.append(link(lane, off(f"o{i}", here), 0, 0))
            go(240, lanes, [(j + 1, j) for j in range(lanes)])
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return sided([], left)


def circles(work, draw, left=False, count=2, walks=False):
    """Roundabouts in a row, of one to three lanes and three to six arms, joined by roads with bends."""
    nodes, edges, x = [], [], 0.0
    turn = -1 if left else 1
    before = None
    for c in range(count):
        radius, lanes, arms = draw.uniform(14, 36), draw.choice((1, 2, 2, 3)), draw.choice((3, 4, 4, 5, 6))
        radius = max(radius, 9 * lanes + 6)
        angles = sorted((360 / arms * i + draw.uniform(-14, 14) + 180) % 360 for i in range(arms))
        place = lambda a, r=radius: (x + r * math.cos(math.radians(a)), r * math.sin(math.radians(a)))
        nodes += [node(f"q{c}_{i}", *place(a)) for i, a in enumerate(angles)]
        for i, a in enumerate(angles):
            j = (i + turn) % arms
            sweep = (angles[j] - a) * turn % 360
            shape = [place(a + turn * sweep * k / 9) for k in range(10)]
            edges.append(edge(f"q{c}r{i}", f"q{c}_{i}", f"q{c}_{j}", lanes, 8.33 + 1.4 * (lanes > 1), "highway.secondary", 9, shape))
        west = min(range(arms), key=lambda i: abs(angles[i] - 180))
        east = min(range(arms), key=lambda i: min(angles[i], 360 - angles[i]))
        for i, a in enumerate(angles):
            if i == west and before or i == east and c + 1 < count:
                continue
            nodes.append(node(f"z{c}_{i}", *place(a, radius + draw.uniform(130, 190))))
            two_way(edges, f"z{c}_{i}", f"q{c}_{i}", min(lanes, draw.choice((1, 2))), 13.89, "highway.tertiary", 5)
        if before:
            two_way(edges, before, f"q{c}_{west}", draw.choice((1, 2)), 13.89, "highway.secondary", 6)
        before = f"q{c}_{east}"
        x += radius + draw.uniform(190, 260)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return sided(["--roundabouts.guess", "--no-turnarounds"] + OPTIONS[:2] + (["--sidewalks.guess", "--crossings.guess"] if walks else []), left)


def knotted(work, draw, left=False):
    """A town of netgenerate whose near junctions netconvert joins into larger ones."""
    options = generated(work, draw, ["priority", "traffic_light", "right_before_left", "priority_stop"], [8.33, 11.11, 13.89], [1, 1, 2],
                        "--rand", "--rand.iterations", 55, "--rand.min-distance", 45, "--rand.max-distance", 170, "--rand.min-angle", 35,
                        "--rand.neighbor-dist3", 6, "--rand.neighbor-dist4", 8)
    return sided(options + ["--junctions.join", "--junctions.join-dist", 25, "--no-turnarounds.except-deadend"], left)
