"""Road networks of the thirteenth held group, of a city and the mountains behind it: a boulevard with tram tracks in its
median and cycle lanes on the cross streets; a large roundabout with lights above a motorway, for traffic on the left; a
motorway with express lanes and metered ramps that ends at a city's first light; a pass road with hairpins, works past
which both directions take one lane by turns of a light, and a village whose main road bends.
"""

import math

from networks import document, edge, link, node, smooth, two_way
from networks_outskirts import ahead, between, closed, drawn, lifted


def only(row, *classes):
    """An edge for some classes."""
    return row.replace("<edge ", f'<edge allow="{" ".join(classes)}" ', 1)


def stretch(a, b, line, n=6):
    """Points of a function of x from one station to another, with both."""
    return [(a, line(a)), *between(a, b, line, n), (b, line(b))]


def tramway(work, draw):
    """Two lanes in each direction and two tracks between them, bays for left turns across the tracks; at the last light one
    line turns into a street, which it shares with cars; a crossing for people with lights of its own at a tram stop;
    shops that one enters and leaves by right turns only. Lesser lights have no phase for left turns.
    """
    main, cross, street = "highway.primary", "highway.secondary", "highway.residential"
    y = lambda x: 24 * math.sin(x / 330)
    jolt = lambda: draw.uniform(-9, 9)
    at = {"w": -340, "a": jolt(), "b": 245 + jolt(), "c": 425 + jolt(), "d": 640 + jolt(), "e": 985}
    half = {"w": 0, "a": 13, "b": 16, "c": 3, "d": 13, "e": 0}
    nodes, edges, links = [], [], []
    for n, x in at.items():
        row = node(n, x, y(x), "priority" if n in "we" else "traffic_light")
        # The tracks lie between the carriageways, whose left edges are 6.6 m from the middle, 3.4 m beside a bay.
        nodes.append(drawn(row, x, y(x), (y(x + 5) - y(x - 5)) / 10, half[n], half[n], 17, 17) if half[n] else row)
    names = list(at)
    for a, b in zip(names, names[1:]):
        for start, end, sign in ((a, b, 1), (b, a, -1)):
            bay = 65 if end in "abd" else 0
            off, gap = (3.4 if bay else 6.6), 45
            edges_of = [(at[start] + sign * max(4, half[start] - 3), start), (at[end] - sign * max(4, half[end] - 3), end)]
            (x0, _), (x1, _) = edges_of
            n = max(2, round(abs(x1 - x0) / gap))
            line = [(x, y(x) - sign * off) for x in (x0 + (x1 - x0) * t / n for t in range(n + 1))]
            track = [(x, y(x) - sign * 0.1) for x in (x0 + (x1 - x0) * t / n for t in range(1, n))]
            edges.append(only(edge(f"t{start}{end}", start, end, 1, 13.89, "railway.tram", 8, track), "tram"))
            shop = {"ab": ("g", 0.45), "ed": ("j", 0.5)}.get(start + end)
            if shop:
                name, share = shop
                x = x0 + (x1 - x0) * share
                place = (x, y(x) - sign * off)
                nodes += [node(name, *place), node(f"{name}y", x + 8, place[1] - sign * 80)]
                edges.append(closed(edge(f"{start}{name}", start, name, 2, 15.28, main, 9, [(px, y(px) - sign * 6.6) for px in (*(q for q, _ in line if (q - x) * sign < -12), x - sign * 5)]), "tram"))
                edges.append(closed(edge(f"{name}{end}", name, end, 2, 15.28, main, 9, [p for p in line if (p[0] - x) * sign > 12], bay), "tram"))
                two_way(edges, f"{name}y", name, 1, 8.33, "highway.service", 2)
                links.append(f'<delete from="{name}y{name}" to="{name}{name}y"/>')
            else:
                edges.append(closed(edge(start + end, start, end, 2, 15.28, main, 9, line, bay), "tram"))
    # Cross streets; those at 12.5 m/s get lanes for riders.
    for n, lanes, limit, kind, bay in (("a", 1, 12.5, cross, 40), ("b", 2, 12.5, cross, 45), ("d", 1, 11.11, street, 0)):
        for tag, sign in (("n", 1), ("z", -1)):
            end = n + tag
            nodes.append(node(end, at[n] + jolt() * 2, y(at[n]) + sign * 235))
            edges += [edge(end + n, end, n, lanes, limit, kind, 6, (), bay), edge(n + end, n, end, lanes, limit, kind, 6)]
    # A street behind joins two of them and meets a lane where who comes from the right goes first.
    nodes += [node("k", 118, -262, "right_before_left"), node("kz", 110, -375), node("q", 330, -250, "priority"), node("qz", 345, -370), node("dz2", 645, -370)]
    for a, b in (("az", "k"), ("k", "bz"), ("k", "kz"), ("bz", "q"), ("q", "dz"), ("q", "qz"), ("dz", "dz2")):
        two_way(edges, a, b, 1, 8.33, street, 3)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    for a, n, b in (("w", "a", "b"), ("a", "b", "c"), ("b", "c", "d"), ("c", "d", "e")):
        links += [link(f"t{a}{n}", f"t{n}{b}", 0, 0), link(f"t{b}{n}", f"t{n}{a}", 0, 0)]
    links += [link("tcd", "ddn", 0, 0), link("dnd", "tdc", 0, 0), *(link("dnd", to, 0, lane) for to, lane in (("dc", 0), ("ddz", 0), ("de", 1)))]
    # Nobody turns round at the lights.
    links += [f'<delete from="{a}.-65" to="{b}"/>' for a, b in (("wa", "aw"), ("ba", "ag"), ("gb", "ba"), ("cb", "bc"), ("cd", "dc"), ("jd", "de"))]
    links += ahead("bc", "cd", (0, 0), (1, 1)) + ahead("dc", "cb", (0, 0), (1, 1))
    links.append('<crossing node="c" edges="bc tbc tcb cb" width="5"/>')
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join([
        '<flow id="lineA" type="tram" begin="0" period="70" number="4" from="twa" to="tde"><stop lane="tbc_0" endPos="110" duration="14"/></flow>',
        '<flow id="lineB" type="tram" begin="0" period="75" number="4" from="ted" to="taw"><stop lane="tcb_0" startPos="6" endPos="40" duration="12"/></flow>',
        '<flow id="lineC" type="tram" begin="0" period="80" number="3" from="twa" to="ddn"><stop lane="tbc_0" endPos="110" duration="11"/><stop edge="ddn" endPos="90" duration="12"/></flow>',
        '<flow id="lineD" type="tram" begin="0" period="90" number="3" from="dnd" to="taw"><stop edge="dnd" endPos="130" duration="13"/></flow>',
        *(f'<flow id="turn{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wa", "aan", 41), ("car", "bzb", "aw", 37), ("van", "ej", "ddz", 47), ("truck", "wa", "de", 73), ("car", "bnb", "de", 43), ("car", "gyg", "de", 67)))),
        *(f'<flow id="rider{a}" type="cycle" begin="0" period="{p}" number="{int(230 / p)}" from="{a}" to="{b}"/>' for a, b, p in (("ana", "aaz", 29), ("bnb", "bbz", 27), ("bzb", "bbn", 33), ("aza", "aan", 39))),
        '<personFlow id="tramward" type="walker" begin="0" end="260" period="exp(0.1)"><walk from="bc" to="cb"/></personFlow>',
        '<personFlow id="homeward" type="walker" begin="0" end="260" period="exp(0.1)"><walk from="dc" to="cd"/></personFlow>']))
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 86, "--tls.yellow.time", 3, "--tls.left-green.time", 7, "--sidewalks.guess", "--sidewalks.guess.max-speed", 15.3, "--crossings.guess",
            "--sidewalks.guess.exclude", ",".join(f"t{a}{b}" for p, q in zip(names, names[1:]) for a, b in ((p, q), (q, p))), "--bikelanes.guess", "--bikelanes.guess.min-speed", 12, "--bikelanes.guess.max-speed", 13]


def gyratory(work, draw):
    """Traffic on the left. Above a motorway a roundabout of three lanes with lights at three of its entries, whose outer
    lane ends in an exit and begins again at the next entry; a lane past it for left turns; a road north whose two lanes
    become one by turns. Below, eastwards a lane becomes the exit and comes back with the entry, then an exit without a
    lane; westwards lanes for speeding up and slowing down.
    """
    main, ramp, road = "motorway", "motorway_link", "primary"
    high, fast = 6.5, 31.29
    bow = lambda x: 20 * math.cos(x / 560) - 20
    jolt = lambda: draw.uniform(-15, 15)
    nodes, edges, links = [], [], []
    spot = lambda deg: (64 * math.cos(math.radians(deg)), 47 * math.sin(math.radians(deg)))
    arms = {"ra": 152, "rn": 91, "rb": 29, "rc": 331, "rs": 268, "rd": 207}
    names = list(arms)
    for n, deg in arms.items():
        nodes.append(lifted(n, *spot(deg), high, "traffic_light" if n in ("ra", "rn", "rc") else "priority"))
    for a, b in zip(names, [*names[1:], names[0]]):
        sweep = (arms[a] - arms[b]) % 360
        edges.append(edge(f"O{a[1]}", a, b, 3, 11.18, road, 10, [(*spot(arms[a] - sweep * t / 8), high) for t in range(1, 8)]))
    edges.append(f'<roundabout nodes="{" ".join(names)}" edges="{" ".join("O" + n[1] for n in names)}"/>')

    def along(tag, off, parts):
        for name, x, *_ in parts:
            # Where a slip road leaves or comes, the junction covers the first meters of it.
            row, slope = lifted(name, x, bow(x) + off, 0), (bow(x + 5) - bow(x - 5)) / 10
            right, left = (0.2, 13) if off > 0 else (13, 0.2)
            before, behind = (2, 24) if name in ("e1", "e3", "w5", "w1") else (24, 2)
            nodes.append(drawn(row, x, bow(x) + off, slope, before, behind, right, left) if name in ("e1", "e2", "e3", "w1", "w4", "w5") else row)
        for i, ((a, xa, lanes, limit), (b, xb, *_)) in enumerate(zip(parts, parts[1:])):
            shape = [(*p, 0) for p in between(xa, xb, lambda x: bow(x) + off, max(3, int(abs(xb - xa) / 70)))]
            edges.append(edge(f"{tag}{i}", a, b, lanes, limit, main, 13, shape))

    x = {n: s + jolt() for n, s in (("e1", -560), ("e2", 540), ("e3", 1010), ("w1", 1130), ("w2", 900), ("w3", 680), ("w4", 480), ("w5", -480), ("w6", -720), ("w7", -1050))}
    along("E", 5, (("e0", -1500, 3, fast), ("e1", x["e1"], 2, fast), ("e2", x["e2"], 3, fast), ("e3", x["e3"], 3, fast), ("e4", 1560, 0, 0)))
    along("W", -5, (("w0", 1560, 3, fast), ("w1", x["w1"], 4, fast), ("w2", x["w2"], 3, fast), ("w3", x["w3"], 4, fast), ("w4", x["w4"], 3, fast), ("w5", x["w5"], 4, fast), ("w6", x["w6"], 3, fast), ("w7", -1500, 0, 0)))
    links += ahead("E0", "E1", (1, 0), (2, 1)) + ahead("E1", "E2", (0, 1), (1, 2)) + ahead("E2", "E3", (0, 0), (1, 1), (2, 2))
    links += ahead("W0", "W1", (0, 1), (1, 2), (2, 3)) + ahead("W1", "W2", (1, 0), (2, 1), (3, 2)) + ahead("W2", "W3", (0, 1), (1, 2), (2, 3)) + ahead("W3", "W4", (1, 0), (2, 1), (3, 2))
    links += ahead("W4", "W5", (0, 1), (1, 2), (2, 3)) + ahead("W5", "W6", (1, 0), (2, 1), (3, 2))

    def climb(points):
        """Heights along a slip road, by its length, from the motorway to the roundabout."""
        far = [0.0]
        for (ax, ay), (bx, by) in zip(points, points[1:]):
            far.append(far[-1] + math.hypot(bx - ax, by - ay))
        smooth = lambda s: s * s * (3 - 2 * s)
        return [(px, py, high * smooth(d / far[-1])) for (px, py), d in zip(points, far)]

    def beside(at, way, side, base):
        """The first points of a slip road: along the motorway, then away from it, on the side that is up or down."""
        return [(x[at] + way * d, bow(x[at] + way * d) + side * (5 + base + more)) for d, more in ((0, 0), (12, 0), (36, 0.2), (70, 2), (120, 7), (180, 15))]

    # Off eastwards: one lane, then three at the light and one past the roundabout.
    off_e = climb([*beside("e1", 1, 1, 6.4), (-300, 37), (-225, 44), (-170, 45)])
    nodes.append(lifted("q", *off_e[-1]))
    edges += [edge("offE", "e1", "q", 1, 22.35, ramp, 9, smooth(off_e)), edge("offE2", "q", "ra", 3, 17.88, ramp, 9, [(-120, 41, high), (-85, 33, high)]),
              edge("pass", "q", "nq", 1, 13.41, ramp, 7, [(-130, 51.5, high), (-95, 62, 6), (-60, 80, 5.5), (-30, 105, 5), (-12, 135, 4.5)])]
    on_e = climb([*beside("e2", -1, 1, 6.4), (300, 38), (200, 42), (120, 36), spot(29)])
    edges.append(edge("onE", "rb", "e2", 1, 22.35, ramp, 9, smooth(on_e)[::-1]))
    off_w = climb([*beside("w4", -1, -1, 3.2), (240, -46), (160, -46), (105, -34), spot(331)])
    edges.append(edge("offW", "w4", "rc", 1, 22.35, ramp, 9, smooth(off_w)).replace("></edge>", '><split pos="0" lanes="0"/><split pos="-95" lanes="0 1"/><split pos="-70" lanes="0 1 2"/></edge>').replace('numLanes="1"', 'numLanes="3"'))
    on_w = climb([*beside("w5", 1, -1, 9.6), (-240, -48), (-160, -50), (-105, -38), spot(207)])
    edges.append(edge("onW", "rd", "w5", 1, 22.35, ramp, 9, smooth(on_w)[::-1]))
    links += ahead("E0", "offE", (0, 0)) + ahead("offE", "offE2", (0, 0), (0, 1), (0, 2)) + ahead("offE", "pass", (0, 0)) + ahead("onE", "E2", (0, 0)) + ahead("W3", "offW", (0, 0)) + ahead("onW", "W5", (0, 0))
    # The roundabout: its outer lane is lost at the exits b and d and comes back with the entries after them.
    links += ahead("Od", "Oa", (1, 0), (1, 1), (2, 2)) + ahead("offE2", "Oa", (0, 0), (1, 1), (2, 2))
    links += ahead("Oa", "On", (0, 0), (1, 1), (2, 2)) + ahead("Oa", "rnnq", (0, 0)) + ahead("nrn", "On", (0, 0), (1, 1), (1, 2))
    links += ahead("On", "Ob", (1, 1), (2, 2)) + ahead("On", "onE", (0, 0))
    links += ahead("Ob", "Oc", (1, 0), (1, 1), (2, 2)) + ahead("offW.-70", "Oc", (0, 0), (1, 1), (2, 2))
    links += ahead("Oc", "Os", (0, 0), (1, 1), (2, 2)) + ahead("Oc", "rssx", (0, 0)) + ahead("sxrs", "Os", (0, 0), (0, 1))
    links += ahead("Os", "Od", (1, 1), (2, 2)) + ahead("Os", "onW", (0, 0))
    # The road north: the lane past the roundabout is its left one.
    place = {"nq": (0, 168, 4), "nz": (6, 285, 1), "nx": (14, 400, 0), "nend": (10, 620, 0), "ns": (170, 425, 0), "sx": (-6, -190, 1), "send": (8, -420, 0), "sw": (-190, -205, 0), "se": (180, -175, 0)}
    nodes += [lifted(n, *p, {"sx": "traffic_light"}.get(n, "priority")) for n, p in place.items() if n != "nz"]
    zx, zy, zz = place["nz"]
    nodes.append(lifted("nz", zx, zy, zz, "zipper").replace("/>", f' shape="{zx - 6.8},{zy - 16} {zx + 0.3},{zy - 16} {zx + 0.5},{zy + 16} {zx - 6.6},{zy + 16}"/>'))
    edges += [edge("rnnq", "rn", "nq", 1, 17.88, road, 8), edge("nqnz", "nq", "nz", 2, 17.88, road, 8), edge("nznx", "nz", "nx", 1, 17.88, road, 8), edge("nrn", "nx", "rn", 1, 17.88, road, 8, [(12, 285, 1), (6, 168, 4)]).replace("></edge>", '><split pos="0" lanes="0"/><split pos="-80" lanes="0 1"/></edge>').replace('numLanes="1"', 'numLanes="2"')]
    links[:] = [l.replace('from="nrn"', 'from="nrn.-80"') for l in links]
    links += ahead("rnnq", "nqnz", (0, 1)) + ahead("pass", "nqnz", (0, 0)) + ahead("nqnz", "nznx", (0, 0), (1, 0))
    two_way(edges, "nx", "nend", 1, 17.88, road, 8)
    two_way(edges, "ns", "nx", 1, 13.41, "tertiary", 4)
    for a, b, limit, kind, rank in (("rs", "sx", 17.88, road, 8), ("sx", "send", 17.88, road, 8), ("sw", "sx", 13.41, "tertiary", 4), ("se", "sx", 13.41, "tertiary", 4)):
        two_way(edges, a, b, 1, limit, kind, rank)
    # Further on: an exit without a lane, entries.
    for name, at, way, side, base, enters, over, there in (("out3", "e3", 1, 1, 9.6, False, "E2", 0), ("in2", "w1", 1, -1, 9.6, True, "W1", 0)):
        spots = beside(at, way, side, base)[1:]
        nodes.append(lifted(f"{name}x", x[at] + way * 260, bow(x[at] + way * 260) + side * (5 + base + 32), 0))
        flat = [(*p, 0) for p in spots]
        edges.append(edge(name, *((f"{name}x", at) if enters else (at, f"{name}x")), 1, 20.12, ramp, 8, flat[::-1] if enters else flat))
        links.extend(ahead(name, over, (0, there)) if enters else ahead(over, name, (there, 0)))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join(f'<flow id="haul{i}" type="{kind}" begin="0" period="{p}" number="{int(230 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "E0", "nxnend", 17), ("truck", "E0", "sxsend", 53), ("car", "W0", "nxnend", 19), ("van", "W0", "sxsend", 47), ("car", "nendnx", "E2", 23), ("truck", "nendnx", "W6", 43), ("car", "sendsx", "W6", 29), ("truck", "in2", "W6", 13),
        ("van", "in2", "W6", 15), ("truck", "W0", "W6", 14), ("car", "E0", "out3", 17)))))
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 44, "--tls.yellow.time", 3]


def terminus(work, draw):
    """Towards the city two express lanes left of three others, which meet beside each other on a stretch where one may
    change; a metered entry, an exit by a lane of its own; the five lanes become four by turns, the limit falls in steps,
    and the motorway ends at a light with two lanes for left turns. Out of the city two ramps that join before they enter
    by a lane that stays, a metered entry, an exit that parts in two.
    """
    main, ramp, city = "motorway", "motorway_link", "primary"
    fast, mid, slow, town = 30.56, 25.0, 19.44, 15.28
    bow = lambda x: 55 * math.cos(x / 700) - 55
    nodes, edges, links = [], [], []
    jolt = lambda: draw.uniform(-12, 12)
    tilt = lambda x: (bow(x + 5) - bow(x - 5)) / 10
    x = {n: s + jolt() for n, s in (("m1", -2080), ("l1", -1840), ("l2", -1630), ("j1", -1440), ("m2", -1150), ("l3", -990), ("l4", -780), ("j2", -430), ("g1", -300), ("g2", -140), ("o1", -170), ("o2", -480), ("o3", -740), ("o4", -960), ("o5", -1330), ("o6", -1560))}
    x |= {"m0": -2480, "t": 0, "u": 340, "v": 640, "o7": -2480}
    five = lambda n, before, behind, right=18.2: drawn(node(n, x[n], bow(x[n]) - 6), x[n], bow(x[n]) - 6, tilt(x[n]), before, behind, right, 0.2)

    def along(tag, side, base, parts):
        """Roads along the line between nodes; their left edge is so far from it."""
        way = 1 if side < 0 else -1
        for i, ((a, lanes, limit), (b, *_)) in enumerate(zip(parts, parts[1:])):
            line = lambda s: bow(s) + side * base
            first, last = x[a] + way * 2, x[b] - way * 2
            edges.append(edge(f"{tag}{i}", a, b, lanes, limit, main if limit > 16 else city, 13 if limit > 16 else 9, [(first, line(first)), *between(x[a], x[b], line, max(3, int(abs(x[b] - x[a]) / 50))), (last, line(last))]))

    # Nodes of the local lanes lie at their own left edge, 1.8 m right of the express lanes.
    for n in ("m1", "j1", "m2", "j2"):
        nodes.append(five(n, 20, 20))
    for n in ("l1", "l2", "l3", "l4"):
        nodes.append(node(n, x[n], bow(x[n]) - 14.2))
    nodes += [node("m0", x["m0"], bow(x["m0"]) - 6), drawn(node("g1", x["g1"], bow(x["g1"]) - 6, "zipper"), x["g1"], bow(x["g1"]) - 6, tilt(x["g1"]), 22, 22, 16.2, 0.2), drawn(node("g2", x["g2"], bow(x["g2"]) - 2.8), x["g2"], bow(x["g2"]) - 2.8, tilt(x["g2"]), 8, 8, 16.3, 0.2)]
    nodes += [node(n, x[n], bow(x[n]), "traffic_light") for n in "tu"] + [node("v", x["v"], bow(x["v"]))]
    along("M", -1, 6, (("m0", 5, fast), ("m1", 0, 0)))
    along("N", -1, 6, (("j1", 5, mid), ("m2", 0, 0)))
    along("P", -1, 6, (("j2", 5, 22.22), ("g1", 4, slow), ("g2", 0, 0)))
    along("X", -1, 6, (("m1", 2, fast), ("j1", 0, 0)))
    along("Y", -1, 6, (("m2", 2, 27.78), ("j2", 0, 0)))
    along("L", -1, 14.2, (("m1", 3, 27.78), ("l1", 4, 27.78), ("l2", 3, mid), ("j1", 0, 0)))
    along("K", -1, 14.2, (("m2", 3, mid), ("l3", 4, mid), ("l4", 3, mid), ("j2", 0, 0)))
    links += ahead("M0", "L0", (0, 0), (1, 1), (2, 2)) + ahead("M0", "X0", (3, 0), (4, 1)) + ahead("L0", "L1", (0, 1), (1, 2), (2, 3)) + ahead("L1", "L2", (1, 0), (2, 1), (3, 2))
    links += ahead("L2", "N0", (0, 0), (1, 1), (2, 2)) + ahead("X0", "N0", (0, 3), (1, 4)) + ahead("N0", "K0", (0, 0), (1, 1), (2, 2)) + ahead("N0", "Y0", (3, 0), (4, 1))
    links += ahead("K0", "K1", (0, 1), (1, 2), (2, 3)) + ahead("K1", "K2", (1, 0), (2, 1), (3, 2)) + ahead("K2", "P0", (0, 0), (1, 1), (2, 2)) + ahead("Y0", "P0", (0, 3), (1, 4))
    links += ahead("P0", "P1", (0, 0), (1, 1), (2, 2), (3, 3), (4, 3))
    # The end: four lanes and a fifth, which turns left as the fourth does.
    edges.append(edge("P2", "g2", "t", 4, 16.67, city, 9, stretch(x["g2"] + 2, -10, lambda s: bow(s) - 2.8), 85))
    links += ahead("P1", "P2", (0, 0), (1, 1), (2, 2), (3, 3))
    for a, b, lanes, bay in (("t", "u", 3, 55), ("u", "t", 3, 60), ("u", "v", 3, 0), ("v", "u", 3, 55)):
        sign = 1 if x[b] > x[a] else -1
        edges.append(edge(a + b, a, b, lanes, town, city, 9, stretch(x[a] + sign * 10, x[b] - sign * 10, lambda s: bow(s) - sign * 1.5), bay))
    for n, lanes, limit, kind, bay in (("t", 2, 13.89, "secondary", 60), ("u", 1, 12.5, "tertiary", 40)):
        for tag, sign in (("n", 1), ("z", -1)):
            end = n + tag
            nodes.append(node(end, x[n] + jolt() * 2, bow(x[n]) + sign * 290))
            edges += [edge(end + n, end, n, lanes, limit, kind, 7, (), bay), edge(n + end, n, end, lanes, limit, kind, 7)]
    links += ahead("P2.-85", "ttz", (0, 0)) + ahead("P2.-85", "tu", (0, 0), (1, 1), (2, 2)) + ahead("P2.-85", "ttn", (3, 0), (4, 1))
    # Out of the city.
    for n in ("o1", "o2", "o3", "o4", "o5", "o6", "o7"):
        nodes.append(node(n, x[n], bow(x[n]) + 6))
    edges.append(edge("W0", "t", "o1", 3, 16.67, city, 9, stretch(-10, x["o1"] + 2, lambda s: bow(s) + 1.5 + 4.5 * min(1, max(0, (-s - 20) / 90)))))
    along("O", 1, 6, (("o1", 3, 22.22), ("o2", 4, mid), ("o3", 5, mid), ("o4", 4, fast), ("o5", 5, fast), ("o6", 4, fast), ("o7", 0, 0)))
    links += ahead("W0", "O0", (0, 0), (1, 1), (2, 2)) + ahead("O0", "O1", (0, 1), (1, 2), (2, 3)) + ahead("O1", "O2", (0, 1), (1, 2), (2, 3), (3, 4)) + ahead("O2", "O3", (1, 0), (2, 1), (3, 2), (4, 3))
    links += ahead("O3", "O4", (0, 1), (1, 2), (2, 3), (3, 4)) + ahead("O4", "O5", (1, 0), (2, 1), (3, 2), (4, 3))

    def slip(name, at, side, base, enters, limit=18.06, length=230, meter=False):
        """A ramp on the right of the lanes, `base` from the line; a metered one is two roads with a light between."""
        way = (1 if side < 0 else -1) * (-1 if enters else 1)
        place = lambda d, m: (x[at] + way * d, bow(x[at] + way * d) + side * (base + m))
        spots = [place(d, m) for d, m in ((1, 0), (5, 0), (34, 0.3), (62, 1.6), (95, 5.5), (135, 12))]
        nodes.append(node(f"{name}x", *place(length, 36)))
        if meter:
            nodes.append(node(f"{name}m", *place(158, 17.5), "traffic_light"))
            edges.extend((edge(f"{name}0", f"{name}x", f"{name}m", 1, 16.67, ramp, 8), edge(name, f"{name}m", at, 1, limit, ramp, 8, spots[::-1])))
        else:
            edges.append(edge(name, *((f"{name}x", at) if enters else (at, f"{name}x")), 1, limit, ramp, 8, spots[::-1] if enters else spots))

    slip("in1", "l1", -1, 14.2 + 9.6, True, meter=True, length=300)
    slip("out1", "l4", -1, 14.2 + 9.6, False, 16.67)
    slip("in2", "o2", 1, 6 + 9.6, True)
    slip("in3", "o3", 1, 6 + 12.8, True, meter=True, length=300)
    slip("out2", "o4", 1, 6 + 12.8, False)
    slip("out3", "o6", 1, 6 + 12.8, False)
    links += ahead("in1", "L1", (0, 0)) + ahead("K1", "out1", (0, 0)) + ahead("in2", "O1", (0, 0)) + ahead("in3", "O2", (0, 0)) + ahead("O2", "out2", (0, 0)) + ahead("O4", "out3", (0, 0))
    # Two ramps join by turns before they enter; an exit parts in two.
    px, py = x["o2"] + 230, bow(x["o2"] + 230) + 6 + 9.6 + 36
    nodes[:] = [drawn(node("in2x", px, py, "zipper"), px, py, 0.3, 12, 12, 3.2, 3.2) if n.startswith('<node id="in2x"') else n for n in nodes]
    nodes += [node("in2a", px + 150, py + 62), node("in2b", px + 165, py + 18)]
    edges += [edge("in2l", "in2a", "in2x", 1, 16.67, ramp, 8, [(px + 100, py + 39), (px + 40, py + 14)]), edge("in2r", "in2b", "in2x", 1, 16.67, ramp, 8, [(px + 100, py + 17), (px + 40, py + 10.5)])]
    links += ahead("in2l", "in2", (0, 0)) + ahead("in2r", "in2", (0, 0))
    qx, qy = x["o6"] - 230, bow(x["o6"] - 230) + 6 + 12.8 + 36
    nodes += [node("out3a", qx - 150, qy + 66), node("out3b", qx - 175, qy + 8)]
    edges += [edge("out3l", "out3x", "out3b", 1, 16.67, ramp, 8, [(qx - 60, qy + 13)]), edge("out3r", "out3x", "out3a", 1, 13.89, ramp, 8, [(qx - 60, qy + 22)])]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    # One vehicle goes in each green of a meter.
    rows = [f'<tlLogic id="{n}m" type="static" programID="meter" offset="{o}"><phase duration="2" state="G"/><phase duration="1" state="y"/><phase duration="{r}" state="r"/></tlLogic>' for n, o, r in (("in1", 0, 3), ("in3", 2, 4))]
    document(work / "meter.add.xml", "additional", rows)
    (work / "parked.txt").write_text("\n".join(f'<flow id="haul{i}" type="{kind}" begin="0" period="{p}" number="{int(210 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "M0", "uv", 9), ("truck", "M0", "out1", 15), ("van", "M0", "ttn", 14), ("car", "in10", "uv", 17), ("car", "in10", "out1", 21), ("truck", "vu", "O5", 27), ("car", "vu", "out3l", 23), ("car", "in30", "O5", 13), ("van", "in30", "out3r", 29),
        ("car", "in2l", "O5", 12), ("truck", "in2r", "O5", 13), ("car", "tzt", "ttn", 16), ("car", "tnt", "uuz", 19)))))
    return ["--no-turnarounds", "--tls.cycle.time", 90, "--tls.yellow.time", 4, "--tls.left-green.time", 9, "--junctions.corner-detail", 5]


def upland(work, draw):
    """A village whose main road bends at its crossing, up to which streets come where who comes from the right goes first;
    a pass road of one wide lane in each direction with hairpins at 22 km/h; works past which a light lets one direction at
    a time through; a lot on the summit, an alp's lane, a valley road that the pass road meets at a stop. Coaches, lorries,
    riders.
    """
    main, street = "highway.secondary", "highway.residential"
    nodes, edges, links = [], [], []
    jolt = lambda: draw.uniform(-12, 12)
    places, shapes = {"v": (0.0, 0.0, 0.0)}, []
    at, heading, z = (0.0, 0.0), math.radians(117), 0.0
    # End, length (m), turn (degrees to the left), limit, grade.
    pieces = (("n", 120 + jolt(), -20, 11.11, 0.02), ("h1", 230 + jolt(), 38, 18.06, 0.05), ("i1", 49, -166, 6.1, 0.04), ("f1", 190 + jolt(), 14, 16.67, 0.055), ("f2", 85, 4, 8.33, 0.055), ("h2", 110 + jolt(), -24, 16.67, 0.05),
              ("i2", 51, 168, 6.1, 0.02), ("al", 150 + jolt(), -8, 16.67, 0.05), ("h3", 165 + jolt(), 26, 16.67, 0.05), ("i3", 50, -165, 6.1, 0.03), ("p", 235 + jolt(), 30, 16.67, 0.03), ("h4", 240 + jolt(), -52, 16.67, -0.05),
              ("i4", 54, 160, 6.4, -0.03), ("z", 310 + jolt(), -40, 19.44, -0.05))
    before = "v"
    for name, length, turn, limit, grade in pieces:
        n = max(4, int(length / (5 if abs(turn) > 90 else 22)))
        shape = []
        for _ in range(n):
            heading += math.radians(turn) / n / 2
            at = (at[0] + length / n * math.cos(heading), at[1] + length / n * math.sin(heading))
            heading += math.radians(turn) / n / 2
            z += grade * length / n
            shape.append((*at, z))
        places[name] = shape.pop()
        shapes.append((before, name, limit, shape, heading))
        before = name
    for a, b, limit, shape, _ in shapes:
        rows = [edge(a + b, a, b, 1, limit, main, 7, shape), edge(b + a, b, a, 1, limit, main, 7, shape[::-1])]
        wide = '<edge width="3.7" ' if (a, b) != ("f1", "f2") else '<edge spreadType="center" width="3.3" '
        edges += [closed(r.replace("<edge ", wide, 1), "bicycle", "pedestrian") for r in rows]
    tilts = {b: math.tan(h) for _, b, _, _, h in shapes}
    for n, p in places.items():
        kind = {"z": "priority_stop", "f1": "traffic_light", "f2": "traffic_light"}.get(n, "priority")
        row = lifted(n, *p, kind)
        nodes.append(drawn(row, *p[:2], tilts[n], 9, 9, 4.2, 4.2) if n in ("f1", "f2") else row)
    # The village: the road from the west bends into the pass road; who comes from the east or the south gives way.
    vx = {"x": (-165, -14), "w": (-420, -46), "ve": (150, -38), "k": (255, -30), "ke": (430, -52), "vs": (22, -150), "kn": (270, 95), "ks": (240, -170), "xn": (-185, 120), "xs": (-150, -140), "wn": (-190, 235)}
    nodes += [node(n, px + jolt() / 2, py, {"k": "right_before_left", "ve": "right_before_left", "vs": "right_before_left", "xs": "priority"}.get(n, "priority")) for n, (px, py) in vx.items()]
    for a, b, limit, kind, rank in (("w", "x", 11.11, main, 7), ("x", "v", 11.11, main, 7), ("v", "ve", 8.33, street, 4), ("ve", "k", 8.33, street, 4), ("k", "ke", 11.11, street, 4), ("v", "vs", 8.33, street, 4), ("vs", "ks", 8.33, street, 4),
                                    ("ve", "vs", 8.33, street, 4), ("k", "kn", 8.33, street, 4), ("k", "ks", 8.33, street, 4), ("x", "xn", 8.33, street, 4), ("x", "xs", 8.33, street, 4), ("xs", "vs", 8.33, street, 4), ("xn", "wn", 8.33, street, 4)):
        two_way(edges, a, b, 1, limit, kind, rank)
    # Beyond the pass: the valley road, on which one drives fast; lanes and lots.
    (zx, zy, zz), h = places["z"], shapes[-1][4]
    across = h + math.radians(82)
    for end, d in (("ye", -1), ("yw", 1)):
        reach = 330
        nodes.append(lifted(end, zx + d * reach * math.cos(across), zy + d * reach * math.sin(across), zz))
        two_way(edges, end, "z", 1, 19.44, "highway.primary", 10)
        edges[-2:] = [closed(row, "bicycle", "pedestrian") for row in edges[-2:]]
    side = lambda n, deg, far, name, limit, dz: (nodes.append(lifted(name, places[n][0] + far * math.cos(deg), places[n][1] + far * math.sin(deg), places[n][2] + dz)), two_way(edges, name, n, 1, limit, street, 2))
    heads = {b: hh for _, b, _, _, hh in shapes}
    side("al", heads["al"] + 1.9, 95, "alp", 8.33, 4)
    side("p", heads["p"] - 1.5, 80, "lot", 6.94, 0)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # At the works the light is for who enters.
    free = lambda a, b: link(a, b, 0, 0).replace("/>", ' uncontrolled="true"/>')
    links += [link("i1f1", "f1f2", 0, 0), free("f2f1", "f1i1"), link("h2f2", "f2f1", 0, 0), free("f1f2", "f2h2")]
    document(work / "con.xml", "connections", links)
    # 16 s are enough to drive past the works.
    rows = [f'<tlLogic id="{n}" type="static" programID="works" offset="0">' + "".join(f'<phase duration="{d}" state="{s}"/>' for d, s in phases) + "</tlLogic>" for n, phases in (
        ("f1", ((22, "G"), (3, "y"), (57, "r"))), ("f2", ((41, "r"), (22, "G"), (3, "y"), (16, "r"))))]
    document(work / "works.add.xml", "additional", rows)
    (work / "parked.txt").write_text("\n".join([
        '<flow id="post" type="coach" begin="0" period="105" number="3" from="wx" to="zyw"><stop edge="vn" endPos="80" duration="10"/></flow>', '<flow id="tour" type="coach" begin="0" period="90" number="3" from="yez" to="xw"/>',
        '<flow id="timber" type="van" begin="0" period="80" number="3" from="alpal" to="xw" speedFactor="0.6"/>', '<flow id="milk" type="truck" begin="0" period="95" number="3" from="kek" to="zye" speedFactor="0.55"/>',
        *(f'<flow id="over{i}" type="{kind}" begin="0" period="{p}" number="{int(300 / p)}" from="{a}" to="{b}"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wx", "zye", 83), ("car", "ywz", "xw", 57), ("moto", "yez", "xw", 73), ("moto", "wx", "plot", 97), ("van", "kek", "xw", 47), ("car", "lotp", "kke", 79), ("car", "yez", "zyw", 19), ("truck", "ywz", "zye", 41), ("car", "knk", "xw", 53), ("car", "wx", "kke", 71)))),
        *(f'<flow id="rider{a}" type="cycle" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}"/>' for a, b, p in (("wnxn", "kke", 77), ("knk", "xw", 43)))]))
    return ["--no-turnarounds", "--default.junctions.radius", 8, "--junctions.corner-detail", 5, "--sidewalks.guess", "--sidewalks.guess.max-speed", 12, "--sidewalks.guess.exclude", ",".join(a + b for s, e, *_ in shapes[1:] for a, b in ((s, e), (e, s))), "--crossings.guess"]
