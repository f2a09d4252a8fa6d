"""Road networks of the seventh held group: streets in a herringbone that meet at acute angles, a motorway without types
and with plain exits only, two roundabouts on either side of a trunk road that they join, a town of hexagons.
"""

import math

from networks import document, edge, link, node, two_way


def herringbone(work, draw):
    """A wide street with a bend; side streets leave it at 50 to 70 degrees, alternately and face to face, and meet a lane
    behind; lights that follow the traffic.
    """
    nodes, edges, spine = [], [], ["w"]
    y = lambda x: 0.00055 * x * x
    place = lambda x: (x, y(x))
    nodes.append(node("w", *place(-520)))
    for i in range(6):
        x = -360 + 135 * i + draw.uniform(-20, 20)
        nodes.append(node(f"p{i}", *place(x), ("traffic_light", "priority_stop", "priority")[i % 3]))
        spine.append(f"p{i}")
        for side in ((1, -1) if i in (0, 3) else (1,) if i % 2 else (-1,)):
            name, slope = f"{'n' if side > 0 else 's'}{i}", math.radians(draw.uniform(50, 70))
            nodes.append(node(name, x + 140 * math.cos(slope), y(x) + side * 140 * math.sin(slope), "right_before_left"))
            two_way(edges, name, f"p{i}", 1, draw.choice((8.33, 11.11)), "highway.residential", 4)
    nodes.append(node("e", *place(480)))
    spine.append("e")
    for i, (a, b) in enumerate(zip(spine, spine[1:])):
        two_way(edges, a, b, 2, 15.28, "highway.primary", 9, bays=(30 if i in (0, 3) else 0, 30 if i in (1, 4) else 0))
    # The lane behind joins the ends of the northern side streets.
    behind = [e for e in ("n0", "n1", "n3", "n5") if any(n.startswith(f'<node id="{e}"') for n in nodes)]
    for a, b in zip(behind, behind[1:]):
        two_way(edges, a, b, 1, 8.33, "highway.residential", 3)
    nodes += [node("nw", -460, 260), node("ne", 560, 330)]
    two_way(edges, "nw", behind[0], 1, 11.11, "highway.residential", 5)
    two_way(edges, behind[-1], "ne", 1, 11.11, "highway.residential", 5)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--no-turnarounds.except-deadend", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--sidewalks.guess", "--crossings.guess"]


def plain_exits(work, draw):
    """Three lanes in long bends, roads without types: four exits that part from the right lane with no lane of their own,
    two entries with lanes that end, and one lane that becomes an exit.
    """
    nodes, edges, links, x = [], [], [], -1300.0
    y = lambda x: 85 * math.cos(x / 520)
    nodes.append(node("k0", x, y(x)))
    count, last = 3, None

    def go(n, metres, lanes, up=0, through=None):
        """The next road; lane i of the one before leads to lane i + up."""
        nonlocal x, count
        a, b = x, x + metres
        nodes.append(node(f"k{n}", b, y(b)))
        edges.append(edge(f"c{n}", f"k{n - 1}", f"k{n}", lanes, 33.33, "", 13, [(a + metres * t, y(a + metres * t)) for t in (0.2, 0.4, 0.6, 0.8)]))
        if n > 1:
            links.extend(link(f"c{n - 1}", f"c{n}", i, i + up) for i in range(count) if 0 <= i + up < lanes)
        x, count = b, lanes

    def ramp(name, n, out, speed):
        there = (x + (150 if out else -170), y(x) - 100)
        nodes.append(node(name, *there))
        ends = (f"k{n}", name) if out else (name, f"k{n}")
        edges.append(edge(f"r{name}", *ends, 1, speed, "", 5, [((x + there[0]) / 2, y(x) - 28)]))

    n = 1
    go(n, 300, 3)
    for i, piece in enumerate(("out", "in", "out", "own", "in", "out", "out")):
        if piece == "out":
            ramp(f"o{i}", n, True, draw.choice((13.89, 16.67, 19.44)))
            links.append(link(f"c{n}", f"ro{i}", 0, 0))
            n += 1
            go(n, draw.uniform(270, 360), 3)
        elif piece == "in":
            ramp(f"i{i}", n, False, 19.44)
            n += 1
            links.append(link(f"ri{i}", f"c{n}", 0, 0))
            go(n, draw.uniform(200, 280), 4, 1)
            n += 1
            go(n, draw.uniform(180, 240), 3, -1)
        else:
            n += 1
            go(n, draw.uniform(180, 260), 4, 1)
            links.append(link(f"c{n - 1}", f"c{n}", 0, 0))
            ramp(f"o{i}", n, True, 16.67)
            links.append(link(f"c{n}", f"ro{i}", 0, 0))
            n += 1
            go(n, draw.uniform(240, 300), 3, -1)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []


def dumbbell(work, draw):
    """Traffic on the left: a trunk road, its ramps to two roundabouts of two lanes north and south of it, a bridge between
    them, and a crossroads with lights behind one.
    """
    nodes, edges = [], []
    for c, (cx, cy, angles) in enumerate(((0, 105, (35, 90, 145, 205, 270, 335)), (10, -105, (25, 90, 155, 215, 270, 325)))):
        place = lambda a, r=24: (cx + r * math.cos(math.radians(a)), cy + r * math.sin(math.radians(a)))
        nodes += [node(f"q{c}_{i}", *place(a)) for i, a in enumerate(angles)]
        for i, a in enumerate(angles):
            j = (i - 1) % 6
            sweep = (a - angles[j]) % 360
            edges.append(edge(f"q{c}r{i}", f"q{c}_{i}", f"q{c}_{j}", 2, 9.0, "highway.secondary", 9, [place(a - sweep * t / 7) for t in range(8)]))
    # Who joins the trunk road, who leaves it: north for the way west, south for the way east.
    nodes += [node(n, px, py) for n, px, py in (("te0", -620, -9), ("te1", -190, -9), ("te2", 230, -9), ("te3", 640, -9), ("tw0", 640, 9), ("tw1", 220, 9), ("tw2", -210, 9), ("tw3", -620, 9))]
    trunk, ramps = "highway.trunk", "highway.trunk_link"
    edges += [edge(f"{t}{i}", f"{t}{i}", f"{t}{i + 1}", 2, 25.0, trunk, 12) for t in ("te", "tw") for i in range(3)]
    edges += [edge("xw", "tw1", "q0_5", 1, 16.67, ramps, 7, [(130, 45)]), edge("jw", "q0_3", "tw2", 1, 16.67, ramps, 7, [(-120, 42)]),
              edge("xe", "te1", "q1_2", 1, 16.67, ramps, 7, [(-110, -45)]), edge("je", "q1_0", "te2", 1, 16.67, ramps, 7, [(130, -45)])]
    two_way(edges, "q0_4", "q1_1", 1, 11.11, "highway.secondary", 7, shape=[(2, 40, 5), (4, 12, 7), (6, -12, 7), (8, -40, 5)])
    nodes += [node("a", -10, 300, "traffic_light"), node("an", -20, 450), node("aw", -190, 310), node("ae", 170, 290), node("s", 20, -290), node("sw", -180, -190), node("d", -190, 220), node("f", 190, 230), node("g", 170, -220)]
    two_way(edges, "a", "q0_1", 2, 13.89, "highway.secondary", 7)
    for end in ("an", "aw", "ae"):
        two_way(edges, end, "a", 1, 13.89, "highway.tertiary", 6)
    for end, at in (("d", "q0_2"), ("f", "q0_0"), ("s", "q1_4"), ("sw", "q1_3"), ("g", "q1_5")):
        two_way(edges, end, at, draw.choice((1, 2)), 13.89, "highway.tertiary", 5)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--lefthand", "--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5]


def hexagons(work, draw):
    """Blocks of six sides: junctions of three arms at about 120 degrees, with every kind of control; some roads of two lanes
    and some at 30 km/h.
    """
    nodes, edges, places, kinds = [], [], {}, ("priority", "traffic_light", "right_before_left", "priority_stop", "priority", "allway_stop")
    side = 105.0
    for row in range(4):
        for col in range(5):
            x = col * side * math.sqrt(3) / 2
            y = row * 1.5 * side + (side / 2 if (col + row) % 2 else 0)
            places[col, row] = (x + draw.uniform(-8, 8), y + draw.uniform(-8, 8))
    joined = [((c, r), (c + 1, r)) for c, r in places if (c + 1, r) in places] + [((c, r), (c, r + 1)) for c, r in places if (c, r + 1) in places and (c + r) % 2]
    arms = {p: sum(p in j for j in joined) for p in places}
    name = lambda p: f"h{p[0]}{p[1]}"
    nodes += [node(name(p), x, y, draw.choice(kinds) if arms[p] >= 2 else "priority") for p, (x, y) in places.items()]
    for n, (a, b) in enumerate(joined):
        lanes, limit = draw.choice((1, 1, 2)), draw.choice((8.33, 13.89, 13.89))
        two_way(edges, name(a), name(b), lanes, limit, "highway.tertiary", 4 + 2 * lanes + n % 2)
    rim = [p for p in places if arms[p] == 2]
    middle = (2 * side * math.sqrt(3) / 2, 2.5 * side)
    for p in rim:
        x, y = places[p]
        far = math.hypot(x - middle[0], y - middle[1])
        nodes.append(node(f"z{name(p)}", x + (x - middle[0]) / far * 130, y + (y - middle[1]) / far * 130))
        two_way(edges, f"z{name(p)}", name(p), 1, 13.89, "highway.tertiary", 6)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 60, "--sidewalks.guess", "--crossings.guess"]
