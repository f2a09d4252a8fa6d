"""Road networks of the eleventh held group, of a region by the sea: a small town whose market square is driven around
clockwise by one-way streets, with crossings away from junctions; an expressway with a collector road, an exit and an
entry on the left; a boulevard of docks on which one turns round at lights, and an estate of halls behind it; a coast
road with a third lane here and there and roundabouts of odd shape, for traffic on the left.
"""

import math

from networks import document, edge, link, node, ring, two_way


def market(work, draw):
    """The square is no roundabout: one drives around it clockwise. Streets come to it where who comes from the right
    goes first or the square gives way; three lights without phases of their own for left turns; a small roundabout.
    """
    jolt = lambda: draw.uniform(-6, 6)
    places = {"nw": (-52, 44), "ne": (58, 52), "se": (62, -48), "sw": (-46, -54), "g": (-345, 14), "z": (-195, 30), "y": (168, -30), "k": (425, -22),
              "wend": (-500, 30), "eend": (580, -4), "gx": (-318, 205), "h": (78, 190), "nx": (268, 178), "hend": (95, 330), "gend": (-330, 345), "s": (-60, -205), "gs": (-352, -190), "gsend": (-365, -330), "send": (-85, -345),
              "zs": (-50, -130), "kend": (450, 150), "nend": (292, 320), "v": (150, -215)}
    kinds = {"g": "traffic_light", "s": "traffic_light", "nx": "traffic_light", "k": "priority_stop", "h": "right_before_left", "sw": "right_before_left", "ne": "right_before_left"}
    places = {n: (x + jolt(), y + jolt()) for n, (x, y) in places.items()}
    nodes = [node(n, x, y, kinds.get(n, "priority")) for n, (x, y) in places.items() if n not in ("z", "y", "zs")]
    for n, before, after in (("z", "g", "nw"), ("y", "se", "o"), ("zs", "sw", "s")):
        # Where nothing but a crossing is, the junction has to be drawn for there to be room for it.
        (x, y), (xa, ya), (xb, yb) = places[n], places[before], places.get(after, (262, -32))
        far = math.hypot(xb - xa, yb - ya)
        ux, uy = (xb - xa) / far, (yb - ya) / far
        corners = " ".join(f"{x + ux * d - uy * side:.2f},{y + uy * d + ux * side:.2f}" for d, side in ((-2.4, -6), (2.4, -6), (2.4, 6), (-2.4, 6)))
        nodes.append(node(n, x, y).replace("/>", f' shape="{corners}"/>'))
    edges = []
    ring(edges, nodes, "o", 275, -32, 13, 1, [0, 85, 175, 265], 6.5)
    for a, b in (("nw", "ne"), ("ne", "se"), ("se", "sw"), ("sw", "nw")):
        edges.append(edge(a + b, a, b, 2 if a == "nw" else 1, 8.33, "highway.tertiary", 4))
    main, street = "highway.secondary", "highway.residential"
    for a, b, limit, kind, rank, bays in (
            ("wend", "g", 13.89, main, 8, (40, 0)), ("g", "z", 11.11, main, 8, (0, 0)), ("z", "nw", 8.33, main, 6, (0, 0)), ("se", "y", 8.33, main, 6, (0, 0)), ("y", "o2", 11.11, main, 8, (0, 0)),
            ("o0", "k", 13.89, main, 8, (0, 0)), ("k", "eend", 13.89, main, 8, (0, 0)), ("ne", "h", 8.33, street, 4, (0, 0)), ("h", "hend", 8.33, street, 4, (0, 0)), ("g", "gx", 13.89, main, 7, (0, 0)),
            ("gx", "h", 8.33, street, 4, (0, 0)), ("h", "nx", 8.33, street, 4, (0, 0)), ("gx", "gend", 13.89, main, 7, (0, 0)), ("nx", "nend", 13.89, main, 7, (0, 0)), ("o1", "nx", 13.89, main, 7, (0, 0)),
            ("g", "gs", 13.89, main, 7, (0, 0)), ("gs", "gsend", 13.89, main, 7, (0, 0)), ("sw", "zs", 8.33, street, 5, (0, 0)), ("zs", "s", 11.11, street, 5, (0, 0)), ("s", "send", 11.11, street, 5, (0, 0)),
            ("gs", "s", 13.89, main, 7, (0, 0)), ("s", "v", 13.89, main, 7, (0, 0)), ("v", "o3", 11.11, main, 7, (0, 0)), ("k", "kend", 8.33, street, 3, (0, 0))):
        two_way(edges, a, b, 1, limit, kind, rank, bays=bays)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    zebras = [f'<crossing node="{n}" edges="{a}{n} {n}{a}" priority="true" width="4"/>' for a, n in (("g", "z"), ("se", "y"), ("sw", "zs"))]
    document(work / "con.xml", "connections", zebras)
    # People come to market in groups; the buses stop in the lane, at the square and before the small roundabout.
    walks = (("gz", "nwz", 9), ("zg", "znw", 8), ("sey", "o2y", 9), ("yse", "yo2", 8), ("swzs", "szs", 11), ("zssw", "zss", 10), ("znw", "nwne", 12), ("nese", "sey", 13), ("sesw", "zssw", 12), ("kendk", "eendk", 21))
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="0" period="55" number="4" from="wendg" to="keend"><stop edge="nwne" endPos="70" duration="12"/><stop edge="yo2" endPos="60" duration="9"/></flow>',
        '<flow id="back" type="coach" begin="0" period="62" number="4" from="eendk" to="gwend"><stop edge="sesw" endPos="60" duration="11"/></flow>',
        *(f'<flow id="rider{a}" type="cycle" begin="0" period="{p}" number="{int(220 / p)}" from="{a}" to="{b}"/>' for a, b, p in (("wendg", "keend", 27), ("hendh", "ssend", 31), ("nendnx", "gsgsend", 37), ("eendk", "gwend", 29))),
        *(f'<personFlow id="shop{i}" type="walker" begin="0" end="270" period="exp({0.8 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(walks))]))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--tls.layout", "opposites", "--tls.left-green.time", 0, "--tls.cycle.time", 42, "--tls.yellow.time", 3, "--sidewalks.guess", "--crossings.guess"]


def expressway(work, draw):
    """Eastwards three lanes and a shoulder on the left, which is a lane of its own at an exit and an entry on that side;
    a collector road, to which the second lane leads as well, and its return. Westwards lanes that come and go, a plain
    exit, weaving, three lanes into two in turns.
    """
    s, main, ramp = 29.17, "motorway", "motorway_link"
    nodes, edges, links = [], [], []
    bow = lambda x: 60 * math.cos(x / 900)
    same = lambda n: [(i, i) for i in range(n)]
    more, less = lambda n: [(i, i + 1) for i in range(n)], lambda n: [(i + 1, i) for i in range(n)]

    def carriageway(tag, off, parts, shoulder):
        """`parts`: station (m), lanes from there on, limit, kind of the node, and which lane leads into which. Their left
        edge is a line, so lanes come and go on the right. `shoulder`: the parts beside which only emergency vehicles drive.
        """
        xs = [x + (draw.uniform(-15, 15) if 0 < i < len(parts) - 1 else 0) for i, (x, *_) in enumerate(parts)]
        for i, (x, (_, lanes, limit, kind, pairs)) in enumerate(zip(xs, parts)):
            nodes.append(node(f"{tag}{i}", x, bow(x) + off, kind))
            along = [(parts[i - 1][1], lanes)] if i and i in shoulder and i - 1 in shoulder else []
            links.extend(link(f"{tag}m{i - 1}", f"{tag}m{i}", p, q) for p, q in (*pairs, *along))
            if lanes:
                shape = [(x + (xs[i + 1] - x) * t / 6, bow(x + (xs[i + 1] - x) * t / 6) + off) for t in range(1, 6)]
                row = edge(f"{tag}m{i}", f"{tag}{i}", f"{tag}{i + 1}", lanes + (i in shoulder), limit, main, 13, shape)
                edges.append(row.replace("></edge>", f'><lane index="{lanes}" allow="emergency"/></edge>') if i in shoulder else row)
        return xs

    def ramped(name, station, x, off, ahead, base, road, pairs):
        """A ramp that leaves (`ahead` along x) or comes from behind, `base` meters beside the line, on the side of its sign."""
        enters = (ahead > 0) != (off < 0)
        at = lambda d, more: (x + ahead * d, bow(x + ahead * d) + off + base + math.copysign(more, base))
        shape = [at(d, m) for d, m in ((20, 0.2), (50, 2), (85, 7), (115, 15))]
        nodes.append(node(f"{name}x", *at(165, 34)))
        edges.append(edge(name, *((f"{name}x", station) if enters else (station, f"{name}x")), 1, 18.06, ramp, 8, shape[::-1] if enters else shape))
        links.extend(link(name, road, i, j) if enters else link(road, name, i, j) for i, j in pairs)

    east = carriageway("e", -35, (
        (-2000, 3, s, "priority", ()), (-1620, 4, s, "priority", more(3)), (-1370, 3, s, "priority", less(3)), (-1030, 4, s, "priority", [*same(3), (2, 3)]), (-760, 3, s, "priority", same(3)),
        (-400, 4, s, "priority", [(0, 0), *more(3)]), (-180, 3, s, "priority", less(3)), (330, 2, 22.22, "zipper", [(0, 0), (1, 0), (2, 1)]), (760, 3, 25.0, "priority", more(2)),
        (1160, 4, s, "priority", same(3)), (1390, 3, s, "priority", same(3)), (1900, 0, 0, "priority", ())), (0, 1, 2, 4, 5, 6, 7, 8, 10))
    ramped("in1", "e1", east[1], -35, -1, -12.8, "em1", [(0, 0)])
    ramped("leftout", "e4", east[4], -35, 1, 0.01, "em3", [(3, 0)])
    ramped("leftin", "e9", east[9], -35, -1, 0.01, "em9", [(0, 3)])
    # The collector: an entry and an exit of its own, then one lane comes back.
    at = lambda x, off: (x, bow(x) - 35 - off)
    nodes.extend(node(n, *at(x, off)) for n, x, off in (("c1", 60, 34), ("c2", 260, 36), ("c3", 480, 34)))
    for name, a, b, lanes, shape in (
            ("col0", "e6", "c1", 2, [at(east[6] + d, m) for d, m in ((20, 11.5), (50, 13.5), (90, 18), (140, 25), (190, 31))]), ("col1", "c1", "c2", 3, [at(160, 36)]), ("col2", "c2", "c3", 2, [at(370, 36)]),
            ("col3", "c3", "e8", 1, [at(east[8] - d, 9.6 + m) for d, m in ((220, 20), (160, 13), (110, 6.5), (65, 2.2), (25, 0.2))])):
        edges.append(edge(name, a, b, lanes, 22.22, ramp, 9, shape))
    links += [link(*each) for each in (("em5", "col0", 0, 0), ("em5", "col0", 1, 1), ("col0", "col1", 0, 1), ("col0", "col1", 1, 2), ("col1", "col2", 1, 0), ("col1", "col2", 2, 1), ("col2", "col3", 0, 0), ("col2", "col3", 1, 0),
                                       ("col3", "em8", 0, 0))]
    for name, x, off, ahead in (("colin", 60, 34, -1), ("colout", 260, 36, 1)):
        nodes.append(node(f"{name}x", *at(x + ahead * 155, off + 40)))
        shape = [at(x + ahead * d, off + 6.4 + m) for d, m in ((20, 0.3), (50, 2.5), (85, 8), (115, 16))]
        edges.append(edge(name, *((f"{name}x", "c1") if ahead < 0 else ("c2", f"{name}x")), 1, 16.67, ramp, 7, shape[::-1] if ahead < 0 else shape))
        links.append(link(name, "col1", 0, 0) if ahead < 0 else link("col1", name, 0, 0))
    west = carriageway("w", 35, (
        (1900, 3, s, "priority", ()), (1560, 3, s, "priority", same(3)), (1220, 4, s, "priority", more(3)), (860, 3, s, "priority", less(3)), (420, 2, 25.0, "zipper", [(0, 0), (1, 0), (2, 1)]),
        (-120, 3, s, "priority", [(0, 0), *more(2)]), (-360, 2, s, "priority", less(2)), (-760, 3, s, "priority", more(2)), (-1010, 2, s, "priority", less(2)), (-1330, 3, s, "priority", [(0, 0), *more(2)]),
        (-2000, 0, 0, "priority", ())), ())
    for name, i, ahead, base, road in (("out1", 1, -1, 9.6, "wm0"), ("in2", 2, 1, 9.6, "wm2"), ("out2", 3, -1, 9.6, "wm2"), ("out3", 6, -1, 6.4, "wm5"), ("in3", 7, 1, 6.4, "wm7")):
        ramped(name, f"w{i}", west[i], 35, ahead, base, road, [(0, 0)])
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    # Lorries of the port and late shoppers come by the ramps.
    (work / "parked.txt").write_text("\n".join(f'<flow id="{kind}{a}" type="{kind}" begin="0" period="{p}" number="{int(180 / p)}" from="{a}" to="{b}" departSpeed="max"/>' for kind, a, b, p in (
        ("truck", "in1", "leftout", 14), ("van", "in1", "leftout", 16), ("car", "in2", "wm9", 9), ("truck", "in3", "wm9", 13), ("van", "in3", "wm9", 10), ("truck", "leftin", "em10", 11), ("truck", "wm0", "out3", 17))))
    return ["--no-turnarounds"]


def docks(work, draw):
    """Three lanes in each direction, the third for left turns and for turning round at the lights, because the gates of
    depots are on one side each; behind it, streets of an estate with wide corners for lorries; a sweeper and a straddle carrier.
    """
    main, yard = "highway.primary", "highway.unclassified"
    y = lambda x: -16 * math.sin(x / 310)
    xs = [0.0]
    for gap in (310, 275, 330):
        xs.append(xs[-1] + gap + draw.uniform(-18, 18))
    at = {"w": -290, "e": xs[-1] + 290} | {f"d{i}": x for i, x in enumerate(xs)}
    nodes = [node(n, x, y(x), "traffic_light" if n[0] == "d" else "priority") for n, x in at.items()]
    edges, links, order = [], [], ["w", "d0", "d1", "d2", "d3", "e"]
    for sign, names in ((1, order), (-1, order[::-1])):
        for k, (a, b) in enumerate(zip(names, names[1:])):
            bend = lambda p, q: [(p + (q - p) * t, y(p + (q - p) * t)) for t in (0.35, 0.7)]
            last = a + b
            if b in "we" or a in "we":
                edges.append(edge(last, a, b, 3, 16.67, main, 9, bend(at[a], at[b])))
            else:
                # Two depots: in and out on this side only.
                x, before = at[a], a
                for gate, share in ((f"{a}g{b}", 0.32), (f"{a}j{b}", 0.6)):
                    far = at[a] + (at[b] - at[a]) * (share + draw.uniform(-0.04, 0.04))
                    depot = gate.replace("g", "h").replace("j", "k")
                    nodes += [node(gate, far, y(far)), node(depot, far + sign * 14, y(far) - sign * 95)]
                    edges.append(edge(before + gate, before, gate, 3, 16.67, main, 9, bend(x, far)))
                    two_way(edges, depot, gate, 1, 5.56, yard, 2)
                    x, before = far, gate
                last = before + b
                edges.append(edge(last, before, b, 3, 16.67, main, 9, bend(x, at[b])))
            if b in "we":
                continue
            # The third lane turns left or round; it begins again behind the light.
            on = lambda c, d: c + d if d in "we" else f"{c}{c}g{d}"
            north, south = (b + kind + b[1] for kind in "nq")
            left, right = (north, south) if sign > 0 else (south, north)
            links += [link(last, on(b, names[k + 2]), i, j) for i, j in ((0, 0), (1, 1), (1, 2))] + [link(last, right, 0, 0), link(last, left, 2, int(left == "d2n2")), link(last, on(b, a), 2, 1)]
    # The estate to the north: two streets along, whose cross streets stop, give way, or stop from all sides.
    kinds = {"n0": "priority", "n1": "allway_stop", "n2": "priority", "n3": "priority_stop", "m1": "priority", "m2": "right_before_left"}
    for i, x in enumerate(xs):
        nodes += [node(f"n{i}", x + draw.uniform(-25, 25), y(x) + 215, kinds[f"n{i}"]), node(f"q{i}", x + draw.uniform(-35, 35), y(x) - 185)]
        two_way(edges, f"d{i}", f"n{i}", 1 + (i == 2), 13.89, yard, 6, bays=(0, 45 if i % 2 else 0))
        two_way(edges, f"q{i}", f"d{i}", 1, 13.89, yard, 6, bays=(65 if i == 1 else 0, 0))
    for i, x in ((1, xs[1] + 20), (2, xs[2] - 25)):
        nodes.append(node(f"m{i}", x, y(x) + 370, kinds[f"m{i}"]))
        two_way(edges, f"n{i}", f"m{i}", 1, 11.11, yard, 4)
    for a, b, limit in (("nw", "n0", 13.89), ("n0", "n1", 13.89), ("n1", "n2", 13.89), ("n2", "n3", 13.89), ("n3", "ne", 13.89), ("mw", "m1", 11.11), ("m1", "m2", 11.11), ("m2", "me", 11.11), ("n3", "mn", 11.11)):
        two_way(edges, a, b, 1, limit, yard, 6 if limit > 12 else 4)
    nodes += [node("nw", xs[0] - 190, 235), node("ne", xs[3] + 190, 200), node("mw", xs[1] - 160, 380), node("me", xs[2] + 170, 360), node("mn", xs[3] + 30, 400)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    # A walking pace: who comes behind it and cannot pass creeps.
    (work / "parked.txt").write_text("\n".join([
        '<flow id="sweep" type="van" begin="0" period="95" number="3" from="nwn0" to="n3ne" speedFactor="0.17"/>', '<flow id="carry" type="truck" begin="0" period="110" number="2" from="nen3" to="n0nw" speedFactor="0.18"/>',
        *(f'<flow id="through{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate((
            ("truck", "wd0", "d3e", 57), ("car", "wd0", "d3e", 23), ("truck", "ed3", "d0w", 61), ("car", "ed3", "d0w", 25))))]))
    return ["--no-turnarounds", "--default.junctions.radius", 10, "--junctions.corner-detail", 5, "--tls.cycle.time", 54, "--tls.yellow.time", 4, "--tls.left-green.time", 8]


def bean(edges, nodes, name, x, y, lanes, arms, radius, speed):
    """A roundabout for traffic on the left whose radius is a function of the angle (radians)."""
    spot = lambda a: (x + radius(math.radians(a)) * math.cos(math.radians(a)), y + radius(math.radians(a)) * math.sin(math.radians(a)))
    turns = sorted(arms, reverse=True)
    for i, a in enumerate(turns):
        b = turns[(i + 1) % len(turns)]
        sweep = (a - b) % 360 or 360
        nodes.append(node(f"{name}{i}", *spot(a)))
        edges.append(edge(f"{name}r{i}", f"{name}{i}", f"{name}{(i + 1) % len(turns)}", lanes, speed, "highway.secondary", 9, [spot(a - sweep * t / 10) for t in range(11)]))


def coast(work, draw):
    """Traffic on the left. One lane in each direction and here and there a second, which ends by taking turns; slow
    campers; an oval roundabout of two lanes, one like a bean, a fishing village with two lights between them.
    """
    y = lambda x: 70 * math.sin(x / 410) + 16 * math.sin(x / 128)
    nodes, edges = [], []
    bean(edges, nodes, "p", -300, y(-300), 2, [2, 72, 182, 255], lambda a: 31 + 9 * math.cos(2 * a), 9.0)
    bean(edges, nodes, "q", 430, y(430), 1, [5, 100, 178, 290], lambda a: 19 + 3.5 * math.cos(a - 0.6) + 3 * math.cos(2 * a), 7.5)
    # p0 and q0 lie at 255 and 290 degrees, p1 and q1 at 180, p2 and q2 to the north, p3 and q3 to the east.
    at = {"wx": -1900, "w": -1700, "a": -1330, "b": -900, "c": -560, "p1": -340, "p3": -260, "f": -60, "l": 70, "g": 230, "q1": 408, "q3": 455, "h": 700, "i": 1130, "e": 1560, "ex": 1750}
    kinds = {"a": "zipper", "b": "zipper", "h": "zipper", "i": "zipper", "l": "traffic_light", "f": "traffic_light"}
    nodes += [node(n, x, y(x), kinds.get(n, "priority")) for n, x in at.items() if n[0] not in "pq"]

    def along(x1, x2):
        n = max(2, int(abs(x2 - x1) / 40))
        return [(x, y(x)) for x in (x1 + (x2 - x1) * t / n for t in range(1, n))]

    for a, b, lanes, back, limit in (("wx", "w", 1, 1, 22.22), ("e", "ex", 1, 1, 22.22), ("w", "a", 1, 2, 25.0), ("a", "b", 2, 1, 25.0), ("b", "c", 1, 1, 22.22), ("c", "p1", 2, 2, 16.67), ("p3", "f", 2, 1, 13.89), ("f", "l", 1, 1, 11.11), ("l", "g", 1, 1, 11.11),
                                     ("g", "q1", 1, 1, 13.89), ("q3", "h", 1, 1, 22.22), ("h", "i", 1, 2, 25.0), ("i", "e", 2, 1, 25.0)):
        two_way(edges, a, b, lanes, limit, "highway.primary" if limit > 14 else "highway.secondary", 9, back=back, shape=along(at[a], at[b]) if at[b] - at[a] > 150 else ())
    for end, n, x, up, limit in (("ps", "p0", -330, -230, 13.89), ("pn", "p2", -270, 230, 13.89), ("qs", "q0", 455, -190, 11.11), ("qn", "q2", 410, 220, 11.11), ("ln", "l", 85, 180, 11.11), ("ls", "l", 50, -150, 8.33),
                                 ("fn", "f", -45, 160, 8.33), ("ws", "w", -1730, -190, 16.67), ("en", "e", 1570, 190, 16.67)):
        nodes.append(node(end, x, y(x) + up))
        two_way(edges, end, n, 1, limit, "highway.tertiary", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # Where a lane is added, all go on in the one near the edge; who overtakes changes over.
    document(work / "con.xml", "connections", [link(a, b, 0, 0) for a, b in (("wa", "ab"), ("ba", "aw"), ("hi", "ie"), ("ei", "ih"))])
    # Campers and old tractors, which the others overtake.
    slow = (("wxw", "gq1", "van", 43, 0.5), ("exe", "hq3", "van", 39, 0.5), ("wsw", "ie", "van", 46, 0.55), ("ene", "aw", "truck", 52, 0.6), ("pnp2", "aw", "van", 50, 0.5), ("qnq2", "ie", "van", 44, 0.52))
    (work / "parked.txt").write_text("\n".join(f'<flow id="slow{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" speedFactor="{f}"/>' for i, (a, b, kind, p, f) in enumerate(slow)))
    return ["--lefthand", "--no-turnarounds", "--roundabouts.guess", "--opposites.guess", "--junctions.corner-detail", 5, "--tls.yellow.time", 3, "--tls.cycle.time", 40, "--sidewalks.guess", "--crossings.guess"]
