"""Road networks of the sixth held group: a ring of one lane with five spokes that are crossed and joined by lesser
streets, a grid with lights whose left turns are let through first and then give way, a motorway of short weaving
stretches, a street with cars parked on both sides.
"""

import math

from networks import document, edge, link, node, two_way


def spokes(work, draw):
    """A ring of one lane; each spoke meets a crossroads or a T-junction 90 to 140 m out; crossings for people on all."""
    nodes, edges, angles = [], [], [20, 95, 160, 232, 305]
    place = lambda a, r: (r * math.cos(math.radians(a)), r * math.sin(math.radians(a)))
    nodes += [node(f"r{i}", *place(a, 17)) for i, a in enumerate(angles)]
    for i, a in enumerate(angles):
        sweep = (angles[(i + 1) % 5] - a) % 360
        edges.append(edge(f"ring{i}", f"r{i}", f"r{(i + 1) % 5}", 1, 8.0, "highway.tertiary", 9, [place(a + sweep * t / 6, 17) for t in range(7)]))
    for i, a in enumerate(angles):
        out = 90 + draw.uniform(0, 50)
        nodes += [node(f"m{i}", *place(a, out), draw.choice(("priority", "traffic_light", "allway_stop"))), node(f"a{i}", *place(a + draw.uniform(-6, 6), out + 150))]
        limit = draw.choice((11.11, 13.89))
        two_way(edges, f"m{i}", f"r{i}", 1, limit, "highway.tertiary", 7)
        two_way(edges, f"a{i}", f"m{i}", 1, limit, "highway.tertiary", 7)
        for side in ((1, -1) if i % 2 else (1,)):
            x, y = place(a, out)
            u, v = place(a + side * draw.uniform(75, 100), 120)
            nodes.append(node(f"c{i}{'n' if side > 0 else 's'}", x + u, y + v))
            two_way(edges, f"c{i}{'n' if side > 0 else 's'}", f"m{i}", 1, 8.33, "highway.residential", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]


def lit_grid(work, draw):
    """Three avenues by three streets, all with lights; bays for left turns, which have a green of their own after the
    common one on the avenues.
    """
    nodes, edges = [], []
    xs, ys = [0, 185 + draw.uniform(-15, 15), 390 + draw.uniform(-15, 15)], [0, 165 + draw.uniform(-15, 15), 320 + draw.uniform(-15, 15)]
    nodes += [node(f"g{i}{j}", x + 0.12 * y, y - 0.05 * x, "traffic_light") for i, x in enumerate(xs) for j, y in enumerate(ys)]
    for i, x in enumerate(xs):
        for j, end in ((0, -170), (2, ys[2] + 170)):
            nodes.append(node(f"v{i}{j}", x + 0.12 * end, end - 0.05 * x))
            two_way(edges, f"v{i}{j}", f"g{i}{j}", 2, 15.28, "highway.primary", 9, bays=(40, 0))
        for j in (0, 1):
            two_way(edges, f"g{i}{j}", f"g{i}{j + 1}", 2, 15.28, "highway.primary", 9, bays=(40, 40))
    for j, y in enumerate(ys):
        for i, end in ((0, -180), (2, xs[2] + 180)):
            nodes.append(node(f"h{i}{j}", end + 0.12 * y, y - 0.05 * end))
            two_way(edges, f"h{i}{j}", f"g{i}{j}", 1, 13.89, "highway.secondary", 7, bays=(30 if j == 1 else 0, 0))
        for i in (0, 1):
            two_way(edges, f"g{i}{j}", f"g{i + 1}{j}", 1, 13.89, "highway.secondary", 7, bays=(30, 30) if j == 1 else (0, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 70, "--tls.left-green.time", 7, "--tls.yellow.time", 4, "--tls.allred.time", 1,
            "--sidewalks.guess", "--crossings.guess"]


def weaving(work, draw):
    """Five interchanges in a row without room between them: each entry's lane becomes an exit's after 140 to 260 m."""
    s, main, ramp = 30.56, "highway.motorway", "highway.motorway_link"
    nodes, edges, links, x = [], [], [], -1000.0
    bow = lambda x: 28 * math.sin(x / 390)
    places = [("m0", x)]
    for i in range(5):
        x += draw.uniform(190, 280)
        places.append((f"e{i}", x))
        x += draw.uniform(140, 260)
        places.append((f"x{i}", x))
    places.append(("m1", x + 260))
    nodes += [node(n, x, bow(x)) for n, x in places]
    for k, ((a, xa), (b, xb)) in enumerate(zip(places, places[1:])):
        edges.append(edge(f"w{k}", a, b, 2 + (a[0] == "e"), s, main, 13, [(xa + (xb - xa) * t, bow(xa + (xb - xa) * t)) for t in (0.25, 0.5, 0.75)]))
    for k, ((_, _), (b, xb)) in enumerate(zip(places, places[1:-1])):
        i = int(b[1])
        if b[0] == "e":
            nodes.append(node(f"on{i}", xb - 210, bow(xb) - 95))
            edges.append(edge(f"on{i}", f"on{i}", b, 1, 20.83, ramp, 6, [(xb - 140, bow(xb) - 70), (xb - 80, bow(xb) - 28), (xb - 30, bow(xb) - 9)]))
            links += [link(f"w{k}", f"w{k + 1}", 0, 1), link(f"w{k}", f"w{k + 1}", 1, 2), link(f"on{i}", f"w{k + 1}", 0, 0)]
        else:
            nodes.append(node(f"off{i}", xb + 200, bow(xb) - 100))
            edges.append(edge(f"off{i}", b, f"off{i}", 1, 16.67, ramp, 6, [(xb + 40, bow(xb) - 9), (xb + 90, bow(xb) - 30), (xb + 150, bow(xb) - 72)]))
            links += [link(f"w{k}", f"w{k + 1}", 1, 0), link(f"w{k}", f"w{k + 1}", 2, 1), link(f"w{k}", f"off{i}", 0, 0)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []


def parked(work, draw):
    """A shopping street in bends with side streets and cars parked beside it, which never drive; people cross."""
    nodes, edges, parks, still, x = [node("w", -430, 0)], [], [], [], -430.0
    bow = lambda x: 16 * math.sin(x / 120)
    names = ["w"]
    for i in range(6):
        x += draw.uniform(110, 150)
        nodes.append(node(f"s{i}", x, bow(x), draw.choice(("priority", "right_before_left", "priority", "traffic_light"))))
        names.append(f"s{i}")
        for side in (1, -1):
            if draw.random() < 0.7:
                name = f"{'n' if side > 0 else 'z'}{i}"
                nodes.append(node(name, x + draw.uniform(-25, 25), bow(x) + side * 130))
                two_way(edges, name, f"s{i}", 1, 8.33, "highway.residential", 3)
    nodes.append(node("e", x + 170, bow(x + 170)))
    names.append("e")
    for a, b in zip(names, names[1:]):
        two_way(edges, a, b, 1, 13.89, "highway.tertiary", 6)
        for road in (f"{a}{b}", f"{b}{a}"):
            room = draw.randint(3, 6)
            parks.append(f'<parkingArea id="park{road}" lane="{road}_1" startPos="18" endPos="{18 + 7 * room}" roadsideCapacity="{room}" width="2.2" length="6.5"/>')
            for _ in range(draw.randint(1, room)):
                still.append(f'<trip id="still{len(still)}" type="{draw.choice(("car", "car", "van"))}" depart="0.0" from="{road}" to="{road}" departPos="stop" arrivalPos="max">'
                             f'<stop parkingArea="park{road}" duration="9999"/></trip>')
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "parked.add.xml", "additional", parks)
    (work / "parked.txt").write_text("\n".join(still))
    return ["--no-turnarounds.except-deadend", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]
