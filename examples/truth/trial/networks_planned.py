"""Road networks of the last group: planned towns and roads in carriageways of their own. One-way streets in blocks, an
estate of loops and dead ends around a small roundabout, an arterial whose two directions are apart, a motorway with a
service area and a road beside it that collects its ramps.
"""

import math

from networks import document, edge, link, node, two_way


def one_way_blocks(work, draw):
    """Avenues and streets in turn one way and the other, at drawn distances; lights on the wide ones."""
    xs, ys = [0.0], [0.0]
    for _ in range(3):
        xs.append(xs[-1] + draw.uniform(90, 150))
        ys.append(ys[-1] + draw.uniform(75, 120))
    wide_x, wide_y = [draw.choice((2, 3)) for _ in xs], [draw.choice((1, 2)) for _ in ys]
    name = lambda i, j: f"n{i}{j}"
    lit = lambda i, j: "traffic_light" if wide_x[i] + wide_y[j] >= 4 else draw.choice(("priority", "priority_stop", "right_before_left"))
    nodes = [node(name(i, j), x + 0.08 * y, y, lit(i, j)) for i, x in enumerate(xs) for j, y in enumerate(ys)]
    edges = []

    def along(places, lanes, speed, rank, tag):
        for k, ((a, _), (b, _)) in enumerate(zip(places, places[1:])):
            edges.append(edge(f"{tag}{k}", a, b, lanes, speed, "highway.secondary" if rank > 6 else "highway.residential", rank))

    for i, x in enumerate(xs):
        tail, head = (f"s{i}", x - 10, ys[0] - 150), (f"t{i}", x + 0.08 * ys[-1] + 12, ys[-1] + 150)
        nodes += [node(*tail), node(*head)]
        places = [(tail[0], 0), *((name(i, j), 0) for j in range(len(ys))), (head[0], 0)]
        along(places if i % 2 else places[::-1], wide_x[i], 13.89, 8, f"a{i}_")
    for j, y in enumerate(ys):
        tail, head = (f"u{j}", xs[0] - 150, y), (f"v{j}", xs[-1] + 150 + 0.08 * y, y + 10)
        nodes += [node(*tail), node(*head)]
        places = [(tail[0], 0), *((name(i, j), 0) for i in range(len(xs))), (head[0], 0)]
        along(places if j % 2 else places[::-1], wide_y[j], 11.11, 5, f"c{j}_")
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--junctions.corner-detail", 5, "--tls.cycle.time", 60, "--sidewalks.guess", "--crossings.guess"]


def estate(work, draw):
    """A spine with a small roundabout; loops and dead ends with T-junctions off it, where the right of way is that of
    the right or all stop.
    """
    nodes, edges = [node("w", -330, -20), node("e", 360, 15)], []
    angles = [0, 88, 181, 268]
    place = lambda a: (11 * math.cos(math.radians(a)), 11 * math.sin(math.radians(a)))
    nodes += [node(f"o{i}", *place(a)) for i, a in enumerate(angles)]
    for i, a in enumerate(angles):
        sweep = (angles[(i + 1) % 4] - a) % 360
        edges.append(edge(f"or{i}", f"o{i}", f"o{(i + 1) % 4}", 1, 6.5, "highway.tertiary", 8, [place(a + sweep * k / 6) for k in range(7)]))
    nodes += [node("p", 150, 12, "right_before_left"), node("q", 255, 4, "allway_stop"), node("r", -140, -6, "right_before_left"), node("s", -235, -18, "priority")]
    for a, b in (("o0", "p"), ("p", "q"), ("q", "e"), ("o2", "r"), ("r", "s"), ("s", "w")):
        two_way(edges, a, b, 1, 13.89, "highway.tertiary", 6)
    nodes += [node("n1", 10, 130, "right_before_left"), node("n2", 120, 150, "right_before_left"), node("n3", 165, 95, "right_before_left"), node("n4", 5, 260)]
    for a, b, shape in (("o1", "n1", []), ("n1", "n2", [(40, 160), (85, 165)]), ("n2", "n3", [(155, 135)]), ("n3", "p", []), ("n1", "n4", [(-15, 195)])):
        two_way(edges, a, b, 1, 8.33, "highway.residential", 4, shape=shape)
    nodes += [node("m1", -15, -120, "right_before_left"), node("m2", 110, -150), node("m3", -130, -140, "right_before_left"), node("m4", -260, -150)]
    for a, b, shape in (("o3", "m1", []), ("m1", "m2", [(50, -128)]), ("m1", "m3", [(-70, -150)]), ("m3", "r", [(-150, -70)]), ("m3", "m4", []), ("s", "m4", [(-265, -80)])):
        two_way(edges, a, b, 1, 8.33, "highway.residential", 4, shape=shape)
    nodes += [node("k1", 262, 120), node("k2", 250, -130)]
    for a in ("k1", "k2"):
        two_way(edges, a, "q", 1, 8.33, "highway.residential", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--junctions.corner-detail", 5, "--roundabouts.guess", "--sidewalks.guess", "--crossings.guess"]


def arterial(work, draw):
    """Two carriageways 14 m apart; crossroads and openings for turning round join them; right turns by slip roads before the
    crossing.
    """
    nodes, edges, limit = [], [], 16.67
    xs, x = [], -420.0
    for kind in ("open", "cross", "open", "cross", "tee"):
        x += draw.uniform(130, 170)
        xs.append((x, kind))
    end = x + 190
    bow = lambda x: 18 * math.sin(x / 210)
    east, west = ["ew"], ["we"]
    nodes += [node("ew", -420, bow(-420) - 7), node("we", -420, bow(-420) + 7), node("ee", end, bow(end) - 7), node("ws", end, bow(end) + 7)]
    for i, (x, kind) in enumerate(xs):
        lit = "traffic_light" if kind == "cross" else "priority"
        nodes += [node(f"d{i}", x, bow(x) - 7, lit), node(f"g{i}", x, bow(x) + 7, lit)]
        east.append(f"d{i}")
        west.append(f"g{i}")
        if kind == "open":
            edges.append(edge(f"turn{i}", f"d{i}", f"g{i}", 1, 6.0, "highway.tertiary", 3))
            continue
        two_way(edges, f"d{i}", f"g{i}", 1, 11.11, "highway.tertiary", 5)
        nodes.append(node(f"south{i}", x + draw.uniform(-20, 20), bow(x) - 160))
        two_way(edges, f"south{i}", f"d{i}", draw.choice((1, 2)), 11.11, "highway.tertiary", 5)
        if kind == "cross":
            nodes.append(node(f"north{i}", x + draw.uniform(-20, 20), bow(x) + 160))
            two_way(edges, f"north{i}", f"g{i}", draw.choice((1, 2)), 11.11, "highway.tertiary", 5)
    for tag, places, rank in (("E", [*east, "ee"], 9), ("W", ["ws", *reversed(west[1:]), "we"], 9)):
        for k, (a, b) in enumerate(zip(places, places[1:])):
            edges.append(edge(f"{tag}{k}", a, b, 2 + (k % 2), limit, "highway.primary", rank))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--junctions.corner-detail", 5, "--no-turnarounds", "--tls.join", "--tls.join-dist", 25]


def collector(work, draw):
    """A motorway with a service area (off and on again), then a road beside it that takes two exits and two entries;
    one typed by the words of OpenStreetMap. Ramps are drawn as arcs.
    """
    s, main, ramp = 33.33, "highway.motorway", "highway.motorway_link"
    nodes, edges, links = [], [], []
    xs = [-1100, -800, -560, -260, 0, 300, 620, 900, 1150]
    bow = lambda x: 30 * math.sin(x / 480)
    nodes += [node(f"m{i}", x, bow(x)) for i, x in enumerate(xs)]
    counts = [2, 3, 2, 3, 2, 2, 3, 2]
    for i, count in enumerate(counts):
        a, b = xs[i], xs[i + 1]
        edges.append(edge(f"c{i}", f"m{i}", f"m{i + 1}", count, s, main, 13, [(a + (b - a) * t, bow(a + (b - a) * t)) for t in (0.25, 0.5, 0.75)]))
    up = {(2, 3), (3, 2)}
    for i, (a, b) in enumerate(zip(counts, counts[1:])):
        if a == b:
            links += [link(f"c{i}", f"c{i + 1}", j, j) for j in range(a)]
        elif (a, b) in up and b > a:
            links += [link(f"c{i}", f"c{i + 1}", j, j + 1) for j in range(a)]
        else:
            links += [link(f"c{i}", f"c{i + 1}", j + 1, j) for j in range(b)]
    arc = lambda x0, y0, x1, y1, n=6: [(x0 + (x1 - x0) * k / n, y0 + (y1 - y0) * (1 - math.cos(math.pi * k / n)) / 2) for k in range(1, n)]
    # The service area: off by a lane of its own that begins at m1, on again by one that ends at m4.
    nodes += [node("s1", -440, bow(-440) - 45), node("s2", -370, bow(-370) - 45)]
    edges += [edge("off0", "m2", "s1", 1, 16.67, ramp, 6, arc(-560, bow(-560) - 6, -440, bow(-440) - 45)), edge("area", "s1", "s2", 1, 8.33, "highway.service", 4),
              edge("on0", "s2", "m3", 1, 19.44, ramp, 6, arc(-370, bow(-370) - 45, -260, bow(-260) - 6))]
    links += [link("c0", "c1", 0, 0), link("c1", "off0", 0, 0), link("on0", "c3", 0, 0)]
    # The road beside it: a plain exit onto it at m4, a plain exit and an entry along it, back by a lane that ends.
    nodes += [node("k1", 120, bow(120) - 32), node("k2", 300, bow(300) - 34), node("k3", 500, bow(500) - 32), node("y", 420, bow(300) - 150), node("z", 180, bow(300) - 160)]
    edges += [edge("off1", "m4", "k1", 1, 22.22, ramp, 6, arc(0, bow(0) - 4, 120, bow(120) - 32)), edge("b1", "k1", "k2", 2, 22.22, ramp, 7), edge("b2", "k2", "k3", 1, 22.22, ramp, 7),
              edge("on1", "k3", "m6", 1, 22.22, ramp, 6, arc(500, bow(500) - 32, 620, bow(620) - 6)), edge("out", "k2", "y", 1, 13.89, "highway.tertiary", 5, [(370, bow(300) - 60)]),
              edge("in", "z", "k1", 1, 13.89, "highway.tertiary", 5, [(90, bow(300) - 80)])]
    links += [link("c3", "off1", 0, 0), link("off1", "b1", 0, 1), link("in", "b1", 0, 0), link("b1", "out", 0, 0), link("b1", "b2", 1, 0), link("on1", "c6", 0, 0), link("b2", "on1", 0, 0)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []
