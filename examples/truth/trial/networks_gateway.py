"""Road networks of the fourteenth held group, of the ways into a city: an artery whose left turns are made by turning
round behind the crossing, by a loop off the right side before it, or into a lane that joins from the left; an
interchange whose crossing road changes sides between two lights; the forecourts of an airport on two levels, for
traffic on the left; a valley road beside a railway, with level crossings close to it.
"""

import math

from networks import document, edge, link, node, ring, smooth, two_way
from networks_outskirts import ahead, closed, drawn, lifted
from networks_regional import only


def stations(start, end, line, gap=45):
    """Points of a function from one station to another, with both, about so far apart."""
    n = max(2, round(abs(end - start) / gap))
    return [(s, line(s)) for s in (start + (end - start) * t / n for t in range(n + 1))]


def indirect(work, draw):
    """Two carriageways 10 to 14 m apart. At one crossing nobody turns left: one turns round at an opening with a light behind it,
    where a yard's drive comes out as well. At another left and right turns begin by a road off the right side, which
    meets the cross street before the crossing. At a third, of three arms, who goes west drives on past the light, and
    who comes from the side street to the left joins them from the left. A back street with stops for all.
    """
    main, cross, back, slip = "highway.primary", "highway.secondary", "highway.tertiary", "highway.primary_link"
    fast, town = 19.44, 13.89
    y = lambda x: 20 * math.sin(x / 340)
    tilt = lambda x: (y(x + 5) - y(x - 5)) / 10
    jolt = lambda: draw.uniform(-9, 9)
    # Half of the median.
    apart = lambda s: 5 + 2 * (lambda t: t * t * (3 - 2 * t))(min(1, max(0, (-280 - s) / 120)))
    x = {"w": -1060, "m2": -860, "m": -690 + jolt(), "t": -600 + jolt(), "d": -500, "u1": -225 + jolt(), "a": jolt(), "u2": 235 + jolt(), "je": 385, "j": 555 + jolt(), "jw": 720, "e": 1040}
    nodes, edges, links = [], [], []
    half = {"u1": 12, "a": 14, "u2": 12, "j": 12}
    for n in ("w", "u1", "a", "u2", "j", "e"):
        row = node(n, x[n], y(x[n]), "traffic_light" if n in half else "priority")
        row = row.replace("/>", ' tlLayout="incoming"/>') if n in ("u1", "u2") else row
        nodes.append(drawn(row, x[n], y(x[n]), tilt(x[n]), half[n], half[n], 16, 16) if n in half else row)
    for n, off in (("je", -5), ("jw", 5), ("d", 7), ("m", 3.8), ("m2", 7)):
        nodes.append(node(n, x[n], y(x[n]) + off))
    nodes.append(drawn(node("t", x["t"], y(x["t"]) - 5, "traffic_light"), x["t"], y(x["t"]) - 5, tilt(x["t"]), 11, 11, 11, 10.5))

    def way(a, b, side, lanes=2, bay=0, limit=fast, kind=main, less=0.0):
        """`less`: so much nearer to the middle; a bay takes its width from the median."""
        less += 3.2 * bool(bay)
        sign = 1 if x[b] > x[a] else -1
        reach = lambda n: max(3, half.get(n, 11 if n == "t" else 3) - 3)
        line = stations(x[a] + sign * reach(a), x[b] - sign * reach(b), lambda s: y(s) + side * (apart(s) - less))
        edges.append(closed(edge(a + b, a, b, lanes, limit, kind, 9, line, bay), "bicycle"))

    for a, b, bay in (("w", "t", 0), ("t", "u1", 0), ("u1", "a", 0), ("a", "u2", 110), ("u2", "je", 0), ("je", "j", 0), ("j", "e", 0)):
        way(a, b, -1, 2, bay)
    for a, b, bay in (("e", "jw", 0), ("jw", "j", 0), ("j", "u2", 0), ("u2", "a", 0), ("a", "u1", 110), ("u1", "d", 75), ("d", "m", 0), ("m2", "w", 0)):
        way(a, b, 1, 2, bay)
    # West of the third crossing the lane that joins is the left one of three.
    way("m", "m2", 1, 3, less=3.2)
    span = lambda a, b, *offs: [(x[a] + (x[b] - x[a]) * (i + 1) / (len(offs) + 1), y(x[a] + (x[b] - x[a]) * (i + 1) / (len(offs) + 1)) + off) for i, off in enumerate(offs)]
    edges.append(closed(edge("dt", "d", "t", 1, 16.67, main, 9, [(x["d"] - 2, y(x["d"] - 2) + 3.8), *span("d", "t", 3.4, 2.4, 2), (x["t"] + 8, y(x["t"] + 8) + 2)]), "bicycle"))
    edges.append(closed(edge("tm", "t", "m", 1, fast, slip, 6, [(x["t"] - 8, y(x["t"] - 8) + 2), *span("t", "m", 2, 2.6, 3.4), (x["m"] + 2, y(x["m"] + 2) + 3.8)]), "bicycle"))
    links += ahead("u1d.-75", "dm", (0, 0), (1, 1)) + ahead("u1d.-75", "dt", (2, 0)) + ahead("dm", "mm2", (0, 0), (1, 1)) + ahead("tm", "mm2", (0, 2)) + ahead("mm2", "m2w", (0, 0), (1, 1))
    # Cross streets; the yards at the openings.
    place = {"an": (x["a"] + jolt(), 275), "az": (x["a"] + jolt(), -290), "az2": (x["a"] + 15, -430), "jn": (x["j"] + 4, y(x["j"]) + 92), "js": (x["j"] - 4, y(x["j"]) - 92), "jnn": (x["j"] + 25, 330), "jz": (x["j"] - 20, -300), "jzz": (x["j"] - 10, -430),
             "tz": (x["t"] - 10, -275), "tzz": (x["t"] - 20, -420), "y1": (x["u1"] + 8, y(x["u1"]) - 105), "y2": (x["u2"] - 6, y(x["u2"]) + 110), "bq": (285, -315), "bqz": (290, -420)}
    nodes += [node(n, *p, {"az": "allway_stop", "bq": "allway_stop", "js": "priority_stop", "jn": "priority_stop"}.get(n, "priority")) for n, p in place.items()]
    two_way(edges, "an", "a", 2, town, cross, 7)
    two_way(edges, "az", "a", 2, town, cross, 7)
    two_way(edges, "az", "az2", 1, town, back, 5)
    two_way(edges, "tz", "t", 1, town, cross, 6, bays=(45, 0))
    two_way(edges, "tz", "tzz", 1, town, back, 6)
    for a, b in (("js", "j"), ("jn", "j")):
        two_way(edges, a, b, 1, town, cross, 7, bays=(55, 0))
    for a, b in (("js", "jz"), ("jz", "jzz"), ("jn", "jnn")):
        two_way(edges, a, b, 1, town, cross, 7)
    for a, b in (("tz", "az"), ("az", "bq"), ("bq", "jz"), ("bq", "bqz")):
        two_way(edges, a, b, 1, 11.11, back, 4)
    for n, u in (("y1", "u1"), ("y2", "u2")):
        two_way(edges, n, u, 1, 8.33, "highway.service", 2)
    hook = lambda n, end, side: [(x[n] + side * d, y(x[n] + side * d) - side * (5 + m)) for d, m in ((2, 0), (20, 3.5), (50, 9), (85, 22), (112, 44))] + [(place[end][0] - side * 26, place[end][1] + side * 12)]
    for n, end, side in (("je", "js", 1), ("jw", "jn", -1)):
        edges.append(closed(edge(n + end, n, end, 1, 13.89, slip, 5, smooth([(x[n], y(x[n]) - side * 5), *hook(n, end, side), place[end], place[end]])[1:-1]), "bicycle"))
    links += ahead("u2je", "jejs", (0, 0)) + ahead("u2je", "jej", (0, 0), (1, 1)) + ahead("ejw", "jwjn", (0, 0)) + ahead("ejw", "jwj", (0, 0), (1, 1))
    # At a and j one drives straight on, or turns right where no loop serves for that.
    links += ahead("u1a", "au2", (0, 0), (1, 1)) + ahead("u1a", "aaz", (0, 0)) + ahead("u2a", "au1", (0, 0), (1, 1)) + ahead("u2a", "aan", (0, 0))
    links += ahead("ana", "aaz", (0, 0), (1, 1)) + ahead("ana", "au1", (0, 0)) + ahead("aza", "aan", (0, 0), (1, 1)) + ahead("aza", "au2", (0, 0))
    links += ahead("jej", "je", (0, 0), (1, 1)) + ahead("jwj", "ju2", (0, 0), (1, 1))
    # At the openings there is a light for who turns round and for those whom he meets.
    free = lambda a, b, *pairs: [link(a, b, *p).replace("/>", ' uncontrolled="true"/>') for p in pairs]
    links += free("au2.-110", "u2je", (0, 0), (1, 1)) + ahead("au2.-110", "u2a", (2, 0)) + ahead("au2.-110", "u2y2", (2, 0)) + ahead("ju2", "u2a", (0, 0), (1, 1)) + ahead("ju2", "u2y2", (0, 0)) + free("y2u2", "u2a", (0, 0))
    links += free("au1.-110", "u1d", (0, 0), (1, 1)) + ahead("au1.-110", "u1a", (2, 0)) + ahead("au1.-110", "u1y1", (2, 0)) + ahead("tu1", "u1a", (0, 0), (1, 1)) + ahead("tu1", "u1y1", (0, 0)) + free("y1u1", "u1a", (0, 0))
    links += ahead("wt", "tu1", (0, 0), (1, 1)) + ahead("wt", "ttz", (0, 0)) + ahead("dt", "ttz", (0, 0)) + ahead("tzt.-45", "tu1", (0, 0)) + ahead("tzt.-45", "tm", (1, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join(
        f'<flow id="way{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wt", "aan", 31), ("car", "ejw", "aaz", 33), ("van", "wt", "jnjnn", 43), ("car", "ejw", "jsjz", 37), ("car", "tzztz", "m2w", 23), ("truck", "ejw", "m2w", 41), ("car", "ejw", "tztzz", 29), ("truck", "wt", "je", 47),
            ("car", "ana", "je", 39), ("car", "az2az", "m2w", 53), ("car", "y2u2", "je", 71)))))
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 66, "--tls.yellow.time", 4, "--tls.left-green.time", 8, "--junctions.internal-link-detail", 12]


def diamond(work, draw):
    """Above a motorway a road whose two directions change sides at a light and back at the next, so that who turns left
    onto the motorway crosses nobody. Eastwards an exit that parts in two; then the ramp onto the motorway passes over
    the next exit before it enters by a lane that ends. Westwards an exit of two lanes, of which one also goes on, and an
    entry of two lanes, which end one after the other. South of it a crossing with a light, north of it a side road with one.
    """
    main, ramp, road = "motorway", "motorway_link", "primary"
    fast, high = 30.56, 6.5
    bow = lambda x: 30 * math.cos(x / 650) - 30
    jolt = lambda: draw.uniform(-14, 14)
    nodes, edges, links = [], [], []
    s = -122 + jolt() / 4
    # The road runs north: `f` says how far its directions have changed sides.
    ease = lambda t: (lambda u: u * u * (3 - 2 * u))(min(1, max(0, t)))
    f = lambda v: ease((v - s + 38) / 76) * ease((-s + 38 - v) / 76)
    left = lambda v, sign: sign * (3.5 - 14.3 * f(v))
    lift = lambda v: high * ease((v + 350) / 135) * ease((350 - v) / 135)
    place = {"z": -395, "sr": s - 78, "nd": s - 78, "S": s, "sl": s + 46, "se": s + 46, "N": -s, "nl": -s - 46, "nw": -s - 46, "sd": -s + 78, "nr": -s + 78, "m": 400, "zz": -680, "mm": 650}
    # By node: which direction's left edge it lies on, and lanes there beyond two on the left.
    sides = {"sr": -1, "nd": 1, "sl": 1, "se": -1, "nl": 1, "nw": -1, "sd": -1, "nr": 1}
    for n, v in place.items():
        kind = "traffic_light" if n in "SNzm" else "priority"
        if n in sides:
            # Drawn as wide as the lanes of both pieces.
            row = lifted(n, left(v, sides[n]), v, lift(v))
            west, east = {"sl": (3.4, 6.6), "nl": (3.4, 6.6), "se": (6.6, 3.4), "nw": (6.6, 3.4), "sr": (9.8, 0.2), "nr": (0.2, 9.8), "nd": (0.2, 6.6), "sd": (6.6, 0.2)}[n]
            nodes.append(drawn(row, left(v, sides[n]), v, 1e6, 6, 6, east, west))
        else:
            row = lifted(n, 0, v, lift(v), kind)
            if n in "SN":
                # Each direction has green alone; the crossing is shorter towards the middle.
                out, mid = (18, 13) if n == "S" else (13, 18)
                row = drawn(row.replace("/>", ' tlLayout="incoming"/>'), 0, v, 1e6, out, mid, 11.5, 11.5)
            nodes.append(row)

    def arterial(name, a, b, lanes, limit, bay=0, wide=0):
        """A piece of the road; `wide`: lanes that it has left of the others."""
        sign = 1 if place[b] > place[a] else -1
        inset = lambda n, away: {"S": 13.4 if away < 0 else 18.4, "N": 18.4 if away < 0 else 13.4}.get(n) if n in "SN" else 9 if n == "z" else 6.3 if n in sides else 2
        first, last = place[a] + sign * inset(a, -sign), place[b] - sign * inset(b, sign)
        line = [(left(v, sign) - sign * 3.2 * wide, v, lift(v)) for v, _ in stations(first, last, lambda v: v, 8)]
        edges.append(edge(name, a, b, lanes, limit, road, 9, line, bay))

    slow, out = 13.89, 16.67
    # Northwards, then southwards.
    for row in (("n0", "zz", "z", 2, out, 55), ("n1", "z", "nd", 2, out), ("n2", "nd", "S", 2, slow), ("n3", "S", "sl", 2, slow), ("n4", "sl", "nl", 3, slow, 0, 1), ("n5", "nl", "N", 2, slow), ("n6", "N", "nr", 2, slow), ("n7", "nr", "m", 3, out), ("n8", "m", "mm", 2, out),
                ("s0", "mm", "m", 2, out), ("s1", "m", "sd", 2, out), ("s2", "sd", "N", 2, slow), ("s3", "N", "nw", 2, slow), ("s4", "nw", "se", 3, slow, 0, 1), ("s5", "se", "S", 2, slow), ("s6", "S", "sr", 2, slow), ("s7", "sr", "z", 3, out), ("s8", "z", "zz", 2, out)):
        arterial(*row)
    x = {n: p + jolt() for n, p in (("e1", -800), ("e2", -560), ("e3", 95), ("e4", 300), ("e5", 960), ("e6", 1190), ("w1", 880), ("w2", 575), ("w3", -560), ("w4", -800), ("w5", -1020))}
    x |= {"e0": -1450, "e7": 1550, "w0": 1550, "w6": -1450}

    def along(tag, off, parts):
        for n, _ in parts:
            row, at = lifted(n, x[n], bow(x[n]) + off, 0), x[n]
            # Where a ramp leaves or joins, the junction covers the first meters of it.
            west, east = {"e2": (2, 24), "e4": (2, 24), "e5": (24, 2), "w2": (24, 2), "w3": (2, 24)}.get(n, (0, 0))
            wide = 16.2 if n == "w3" else 13
            nodes.append(drawn(row, at, bow(at) + off, (bow(at + 5) - bow(at - 5)) / 10, west, east, *((wide, 0.2) if off < 0 else (0.2, wide))) if west else row)
        for i, ((a, lanes), (b, _)) in enumerate(zip(parts, parts[1:])):
            way = 1 if x[b] > x[a] else -1
            edges.append(edge(f"{tag}{i}", a, b, lanes, fast, main, 13, [(px, py, 0) for px, py in stations(x[a] + way * 2, x[b] - way * 2, lambda v: bow(v) + off, 60)]))

    along("E", -6, (("e0", 3), ("e1", 4), ("e2", 3), ("e3", 4), ("e4", 3), ("e5", 4), ("e6", 3), ("e7", 0)))
    along("W", 6, (("w0", 3), ("w1", 4), ("w2", 3), ("w3", 5), ("w4", 4), ("w5", 3), ("w6", 0)))
    links += ahead("E0", "E1", (0, 1), (1, 2), (2, 3)) + ahead("E1", "E2", (1, 0), (2, 1), (3, 2)) + ahead("E2", "E3", (0, 1), (1, 2), (2, 3)) + ahead("E3", "E4", (1, 0), (2, 1), (3, 2)) + ahead("E4", "E5", (0, 1), (1, 2), (2, 3)) + ahead("E5", "E6", (1, 0), (2, 1), (3, 2))
    links += ahead("W0", "W1", (0, 1), (1, 2), (2, 3)) + ahead("W1", "W2", (1, 0), (2, 1), (3, 2)) + ahead("W2", "W3", (0, 2), (1, 3), (2, 4)) + ahead("W3", "W4", (1, 0), (2, 1), (3, 2), (4, 3)) + ahead("W4", "W5", (1, 0), (2, 1), (3, 2))

    def beside(n, way, side, base, rise=0.0):
        """The first points of a slip road: along the motorway, then away from it."""
        return [(x[n] + way * d, bow(x[n] + way * d) + side * (6 + base + more), rise * d / 115) for d, more in ((0, 0), (24.3, 0), (45, 0.4), (75, 2), (115, 6.5))]

    def slip(name, a, b, lanes, limit, points, back=False):
        line = smooth([points[0], *points, points[-1]], 6)
        edges.append(edge(name, a, b, lanes, limit, ramp, 8, line[::-1] if back else line))

    h = high
    # Off eastwards, and on: the ramps part at q and join at p.
    nodes += [lifted("q", -165, s + 22, h), lifted("p", 175, s + 27, h), lifted("q2", 165, -s - 22, h), lifted("p2", -175, -s - 27, h), drawn(lifted("p3", 340, s + 34, h, "zipper"), 340, s + 34, 0.02, 20, 20, 6.6, 0.2)]
    slip("offE", "e2", "q", 1, 20.12, [*beside("e2", 1, -1, 9.6, 1.2), (-380, -45, 2.8), (-300, s + 48, 4.8), (-232, s + 28, 6.2), (-167, s + 22, h)])
    slip("offEl", "q", "sl", 1, 11.11, [(-162, s + 22, h), (-110, s + 19, h), (-65, s + 20, h), (-36, s + 23, h), (-21.5, s + 30, h), (left(s + 39, 1) - 3.4, s + 39, h)])
    slip("offEr", "q", "sr", 1, 12.5, [(-162, s + 20, h), (-110, s + 9, h), (-62, s - 12, h), (-36, s - 32, h), (-19, s - 54, h), (-10.6, s - 71.8, h)])
    slip("onEr", "nd", "p", 1, 12.5, [(7.4, s - 71, lift(s - 76)), (14, s - 54, h), (34, s - 32, h), (66, s - 4, h), (115, s + 14, h), (167, s + 23.6, h)])
    slip("onEl", "se", "p", 1, 11.11, [(left(s + 39, -1) + 3.4, s + 39, h), (21.5, s + 31, h), (36, s + 25, h), (65, s + 24, h), (115, s + 24.5, h), (172, s + 27, h)])
    slip("onE", "p", "p3", 2, 16.67, [(178, s + 27.2, h), (230, s + 30, h), (290, s + 33, h), (319, s + 33.8, h)])
    over = [(x["e5"] - d, bow(x["e5"] - d) - 6 - 9.6 - m, v) for d, m, v in ((265, 43, h), (205, 25, 6), (150, 11, 4), (100, 3.5, 1.8), (55, 0.7, 0.4), (24.3, 0, 0), (0, 0, 0))]
    slip("onE2", "p3", "e5", 1, 20.12, [(361, s + 34.2, h), (430, s + 32.5, h), (530, s + 28, h), (600, s + 27, h), *over])
    # The next exit passes below that ramp.
    nodes.append(lifted("bx", 1000, bow(1000) - 118, 0))
    slip("outB", "e4", "bx", 1, 20.12, [*beside("e4", 1, -1, 9.6), (520, bow(520) - 42, 0), (640, bow(640) - 66, 0), (760, bow(760) - 88, 0), (880, bow(880) - 105, 0), (997, bow(1000) - 118, 0)])
    # Off westwards by two lanes, and on.
    slip("offW", "w2", "q2", 2, 20.12, [*beside("w2", -1, 1, 9.6, 1.2), (385, 36, 2.8), (302, -s - 52, 4.8), (232, -s - 29, 6.2), (167, -s - 22, h)])
    slip("offWl", "q2", "nw", 1, 11.11, [(162, -s - 22, h), (110, -s - 19, h), (65, -s - 20, h), (36, -s - 23, h), (21.5, -s - 30, h), (left(-s - 39, -1) + 3.4, -s - 39, h)])
    slip("offWr", "q2", "nr", 1, 12.5, [(162, -s - 18, h), (110, -s - 7, h), (62, -s + 12, h), (36, -s + 32, h), (19, -s + 54, h), (10.6, -s + 71.8, h)])
    slip("onWr", "sd", "p2", 1, 12.5, [(-7.4, -s + 71, lift(-s + 76)), (-14, -s + 54, h), (-34, -s + 32, h), (-66, -s + 4, h), (-115, -s - 14, h), (-167, -s - 23.6, h)])
    slip("onWl", "nl", "p2", 1, 11.11, [(left(-s - 39, 1) - 3.4, -s - 39, h), (-21.5, -s - 31, h), (-36, -s - 25, h), (-65, -s - 24, h), (-115, -s - 24.5, h), (-172, -s - 27, h)])
    slip("onW", "w3", "p2", 2, 20.12, [*beside("w3", 1, 1, 9.6, 1.2), (-385, 36, 2.8), (-305, -s - 54, 4.8), (-240, -s - 33, 6.2), (-178, -s - 27.2, h)])
    edges[-1] = edges[-1].replace('from="w3" to="p2"', 'from="p2" to="w3"')
    points = edges[-1].split(' shape="')[1].split('"')[0]
    edges[-1] = edges[-1].replace(points, " ".join(points.split(" ")[::-1]))
    links += ahead("E1", "offE", (0, 0)) + ahead("offE", "offEl", (0, 0)) + ahead("offE", "offEr", (0, 0)) + ahead("onEr", "onE", (0, 0)) + ahead("onEl", "onE", (0, 1)) + ahead("onE", "onE2", (0, 0), (1, 0)) + ahead("onE2", "E5", (0, 0)) + ahead("E3", "outB", (0, 0))
    links += ahead("W1", "offW", (0, 0), (1, 1)) + ahead("offW", "offWr", (0, 0)) + ahead("offW", "offWl", (1, 0)) + ahead("onWr", "onW", (0, 0)) + ahead("onWl", "onW", (0, 1)) + ahead("onW", "W3", (0, 0), (1, 1))
    # The road: lanes of the ramps are added on the left between the lights, on the right outside them.
    for a, b, c, away in (("n1", "n2", "n3", "onEr"), ("s1", "s2", "s3", "onWr")):
        links += ahead(a, b, (0, 0), (1, 1)) + ahead(a, away, (0, 0)) + ahead(b, c, (0, 0), (1, 1))
    for b, c, d, e, side, away, last, late in (("n3", "n4", "n5", "n6", "offEl", "onWl", "n7", "offWr"), ("s3", "s4", "s5", "s6", "offWl", "onEl", "s7", "offEr")):
        links += ahead(b, c, (0, 0), (1, 1)) + ahead(side, c, (0, 2)) + ahead(c, d, (0, 0), (1, 1)) + ahead(c, away, (2, 0)) + ahead(d, e, (0, 0), (1, 1)) + ahead(e, last, (0, 1), (1, 2)) + ahead(late, last, (0, 0))
    for n, arms in (("z", (("ze", 300, -25, 2, 50), ("zw", -290, 20, 2, 50))), ("m", (("me", 260, 40, 1, 0),))):
        for end, dx, dy, lanes, bay in arms:
            nodes.append(node(end, dx + jolt(), place[n] + dy))
            two_way(edges, end, n, lanes, 13.89, "secondary", 6, bays=(bay, 0))
    links += ahead("n0.-55", "n1", (0, 0), (1, 1)) + ahead("n0.-55", "zze", (0, 0)) + ahead("n0.-55", "zzw", (2, 1))
    links += ahead("s7", "s8", (0, 0), (1, 1)) + ahead("s7", "zzw", (0, 0)) + ahead("s7", "zze", (2, 1))
    links += ahead("n7", "n8", (1, 0), (2, 1)) + ahead("n7", "mme", (0, 0)) + ahead("s0", "s1", (0, 0), (1, 1)) + ahead("s0", "mme", (1, 0)) + ahead("mem", "n8", (0, 0)) + ahead("mem", "s1", (0, 1))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join(f'<flow id="haul{i}" type="{kind}" begin="0" period="{p}" number="{int(220 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "E0", "n8", 15), ("truck", "E0", "s8", 43), ("car", "W0", "s8", 17), ("van", "W0", "n8", 27), ("car", "n0", "W5", 33), ("car", "s0", "E6", 31), ("truck", "s0", "W5", 41), ("truck", "zez", "E6", 37), ("car", "n0", "E6", 35),
        ("car", "n0", "n8", 31), ("car", "s0", "s8", 29), ("truck", "W0", "W5", 17), ("van", "E0", "outB", 21), ("car", "E0", "E6", 13)))))
    return ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 72, "--tls.yellow.time", 3, "--tls.left-green.time", 12]


def airport(work, draw):
    """Traffic on the left. A dual carriageway leads past a light to a terminal with two forecourts above each other, each
    with a lane at the kerb where one lets people out and a crossing for people on the lower one; ways to a car park
    and round again to the start; two forks, of which one lane leads to either side; who leaves goes back past the
    light or by a road east. South of the light a small roundabout.
    """
    main, way, ramp, lane = "highway.primary", "highway.secondary", "highway.primary_link", "highway.service"
    up = 7.0
    nodes, edges, links = [], [], []
    jolt = lambda: draw.uniform(-8, 8)
    hx, f2 = -800 + jolt(), -250 + jolt()
    place = {"w": (-1220, 8, 0), "h": (hx, 0, 0), "j1": (-425, -1.2, 0), "f2": (f2, -1.2, 0), "f3": (f2 + 105, 5, 0), "a1": (-35, 8, 0), "c1": (45, 8, 0), "c2": (138, 8, 0), "a2": (225, 8, 0), "d1": (-25, 46, up), "d2": (215, 46, up),
             "d3": (333, -14, 2.2), "x": (640, -55, 0), "x2": (900, -70, 0), "mz": (232, -92, 0), "p1": (150, -94, 0), "r1": (-385, -96, 0), "g": (-62, -20, 0), "pa": (-40, -30, 0), "pb": (118, -30, 0), "pc": (118, -60, 0), "pd": (-40, -60, 0), "pk": (-112, -62, 0), "k1": (45, -14, 0), "k2": (138, -14, 0),
             "hn": (hx + 12, 150, 0), "hnn": (hx + 20, 300, 0), "hne": (hx + 165, 175, 0), "o0": (hx + 18, -180, 0), "o1": (hx, -162, 0), "o2": (hx - 18, -180, 0), "o3": (hx, -198, 0), "oe": (hx + 190, -200, 0), "ow": (hx - 200, -170, 0), "oz": (hx + 12, -360, 0)}
    kinds = {"h": "traffic_light", "pa": "right_before_left", "pc": "right_before_left", "pd": "right_before_left", "mz": "priority", "p1": "priority_stop"}
    for n, (px, py, pz) in place.items():
        row = lifted(n, px, py, pz, kinds.get(n, "priority"))
        if n in ("c1", "c2", "j1"):
            row = drawn(row, px, py, 0, *((8, 8, 0.2, 9.8) if n == "j1" else (2.5, 2.5, 1.5, 12.5)))
        nodes.append(row)

    def road(name, a, b, lanes, limit, kind, rank, shape=(), bay=0, bikes=False):
        row = edge(name, a, b, lanes, limit, kind, rank, shape, bay)
        edges.append(row if bikes else closed(row, "bicycle"))

    # In; out of the city one drives north of those who go back.
    curve = lambda *points: smooth([points[0], *points, points[-1]], 5)[1:-1]
    line = lambda s: 8 * (s + 800) / -420 if s < -800 else 0.0
    road("in0", "w", "h", 3, 19.44, main, 9, [(px, py + 2) for px, py in stations(-1216, hx - 12, line, 60)], 65, True)
    road("out0", "h", "w", 2, 19.44, main, 9, [(px, py - 2) for px, py in stations(hx - 12, -1216, line, 60)], 0, True)
    road("in1", "h", "j1", 2, 19.44, main, 9, [(hx + 12, 2), (-600, 2), (-433.3, 2)])
    road("in2", "j1", "f2", 3, 16.67, main, 9, [(-416.7, -1.2), (-330, -1.2)])
    road("up", "f2", "d1", 2, 13.89, way, 7, curve((f2 + 8, 2.4, 0), (f2 + 40, 9, 0.1), (f2 + 90, 30, 2.5), (f2 + 145, 43, 5.2), (-70, 46, up), (-25, 46, up)))
    road("low", "f2", "f3", 2, 13.89, way, 8)
    road("low2", "f3", "a1", 2, 11.11, way, 8)
    # Forecourts: above, then below, where people cross.
    road("dep", "d1", "d2", 4, 8.33, way, 8)
    for n, a, b in (("arr0", "a1", "c1"), ("arr1", "c1", "c2"), ("arr2", "c2", "a2")):
        road(n, a, b, 3, 8.33, way, 8)
    road("down", "d2", "d3", 2, 11.11, way, 7, curve((215, 46, up), (262, 45, 6.4), (305, 33, 5), (330, 8, 3.2), (333, -14, 2.2)))
    road("down2", "d3", "mz", 1, 11.11, way, 6, curve((333, -14, 2.2), (331, -42, 1.8), (312, -72, 0.7), (278, -88, 0), (232, -92, 0)))
    road("east", "d3", "x", 1, 13.89, way, 6, curve((333, -14, 2.2), (343, -38, 1.8), (372, -56, 0.8), (440, -60, 0), (640, -55, 0)))
    edges.append(edge("xx2", "x", "x2", 1, 16.67, way, 8))
    road("low3", "a2", "mz", 2, 9.72, way, 7, curve((225, 8, 0), (258, 5, 0), (284, -12, 0), (292, -38, 0), (282, -66, 0), (258, -84, 0), (232, -88.8, 0)))
    road("back0", "mz", "p1", 3, 13.89, main, 9)
    road("back1", "p1", "r1", 3, 13.89, main, 9, [(60, -96), (-150, -99)])
    road("back2", "r1", "h", 2, 16.67, main, 9, curve((-385, -97, 0), (-450, -90, 0), (-530, -62, 0), (-600, -28, 0), (-660, -6, 0), (-720, -2, 0), (hx + 12, -2, 0)), 65)
    road("round", "r1", "j1", 1, 9.72, ramp, 6, [(-385 - 14, -93), *((-425 + 46 * math.cos(math.radians(a)), -47.2 + 46 * math.sin(math.radians(a))) for a in range(255, 104, -15)), (-433.3, -1.2)])
    # The car park, in whose aisles one drives slowly, and where people walk.
    road("park0", "f3", "g", 1, 8.33, lane, 5, curve((f2 + 105, 5, 0), (f2 + 135, 1, 0), (-88, -13, 0), (-62, -20, 0)))
    road("park1", "g", "pa", 1, 5.56, lane, 4)
    for n, a, b in (("aisle0", "pa", "pb"), ("aisle1", "pb", "pc"), ("aisle2", "pa", "pd"), ("aisle3", "pd", "pc"), ("leave", "pc", "p1")):
        road(n, a, b, 1, 5.56, lane, 3)
    two_way(edges, "pk", "pd", 1, 5.56, lane, 3)
    for k in "12":
        edges += [only(edge(f"path{k}", f"c{k}", f"k{k}", 1, 2.8, "highway.footway", 1), "pedestrian"), only(edge(f"htap{k}", f"k{k}", f"c{k}", 1, 2.8, "highway.footway", 1), "pedestrian")]
    # The streets at the light; the roundabout runs clockwise.
    two_way(edges, "hn", "h", 2, 13.89, way, 6, bays=(40, 0))
    two_way(edges, "hnn", "hn", 1, 11.11, "highway.residential", 4)
    two_way(edges, "hne", "hn", 1, 11.11, "highway.residential", 3)
    two_way(edges, "o1", "h", 2, 13.89, way, 6, bays=(40, 0))
    for n, a in (("oe", "o0"), ("ow", "o2"), ("oz", "o3")):
        two_way(edges, n, a, 1, 13.89, "highway.tertiary", 5)
    angle = {"o0": 0, "o1": 90, "o2": 180, "o3": 270}
    spin = ["o0", "o3", "o2", "o1"]
    for a, b in zip(spin, [*spin[1:], spin[0]]):
        edges.append(edge(f"spin{a}", a, b, 1, 7.5, way, 9, [(hx + 18 * math.cos(math.radians(angle[a] - 15 * t)), -180 + 18 * math.sin(math.radians(angle[a] - 15 * t))) for t in range(1, 6)]))
    edges.append(f'<roundabout nodes="{" ".join(spin)}" edges="{" ".join("spin" + n for n in spin)}"/>')
    links += ahead("in1", "in2", (0, 0), (1, 1)) + ahead("round", "in2", (0, 2)) + ahead("in2", "up", (0, 0), (1, 1)) + ahead("in2", "low", (1, 0), (2, 1)) + ahead("low", "low2", (0, 0), (1, 1)) + ahead("low", "park0", (1, 0)) + ahead("park0", "park1", (0, 0))
    links += ahead("up", "dep", (0, 0), (0, 1), (1, 2), (1, 3)) + ahead("dep", "down", (1, 0), (2, 1), (3, 1)) + ahead("low2", "arr0", (0, 0), (0, 1), (1, 2)) + ahead("arr0", "arr1", (0, 0), (1, 1), (2, 2)) + ahead("arr1", "arr2", (0, 0), (1, 1), (2, 2)) + ahead("arr2", "low3", (1, 0), (2, 1))
    links += ahead("down", "east", (0, 0)) + ahead("down", "down2", (1, 0)) + ahead("down2", "back0", (0, 0)) + ahead("low3", "back0", (0, 1), (1, 2)) + ahead("back0", "back1", (0, 0), (1, 1), (2, 2)) + ahead("leave", "back1", (0, 2))
    links += ahead("back1", "back2", (0, 0), (1, 1)) + ahead("back1", "round", (2, 0))
    links += [f'<crossing node="c{k}" edges="arr{int(k) - 1}" priority="true" width="4"/>' for k in "12"]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    halt = lambda road, a: f'<stop lane="{road}" startPos="{a}" endPos="{a + 9}" duration="{draw.randint(14, 34)}"/>'
    # People are let out at the kerb, and some in the lane beside it.
    spots = [("dep_0", 40), ("dep_0", 84), ("dep_0", 128), ("dep_0", 172), ("dep_1", 150), ("arr0_1", 26), ("arr0_1", 52), ("arr1_1", 12), ("arr1_1", 36), ("arr2_1", 14), ("arr2_1", 38)]
    rows = [f'<flow id="taxi{i}" type="{draw.choice(("car", "car", "quick", "van"))}" begin="0" end="260" period="exp({1 / draw.randint(60, 95):.4f})" from="{draw.choice(("in0", "in0", "hnnhn"))}" to="{draw.choice(("out0", "xx2") if spot == "dep_0" else ("out0", "hhn"))}" departLane="best">{halt(spot, at)}</flow>'
            for i, (spot, at) in enumerate(spots)]
    (work / "parked.txt").write_text("\n".join([
        *rows,
        '<flow id="shuttle" type="coach" begin="0" period="58" number="4" from="in0" to="out0" departLane="best"><stop lane="arr1_1" startPos="60" endPos="80" duration="16"/></flow>',
        *(f'<flow id="go{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}"{via} departLane="best"/>' for i, (kind, a, b, p, via) in enumerate((
            ("car", "in0", "pdpk", 33, ""), ("car", "pkpd", "out0", 29, ""), ("car", "pkpd", "east", 61, ' via="round"'), ("car", "in0", "out0", 27, ""), ("quick", "in0", "hhn", 47, ' via="arr0"'), ("truck", "in0", "o3oz", 61, ""), ("van", "oeo0", "o3oz", 57, "")))),
        *(f'<personFlow id="bags{i}" type="walker" begin="0" end="260" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate((("arr0", "path1", 13), ("htap1", "arr1", 15), ("arr1", "path2", 14), ("htap2", "arr2", 12))))]))
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 84, "--tls.yellow.time", 3, "--tls.left-green.time", 10, "--sidewalks.guess", "--sidewalks.guess.max-speed", 8.4, "--sidewalks.guess.exclude", "dep,park0," + ",".join(f"spin{n}" for n in spin)]


def railside(work, draw):
    """A railway of two tracks; beside it, 64 m off, a road of one lane in each direction, from which three roads lead over
    level crossings: to a town from a junction with a bay, to its station from a light, to a farm. A branch that meets
    the road by a triangle of three junctions, a roundabout of one lane with a way past it for right turns, trades'
    streets; in the town a market with a light, one way past the station, where cars stop, and streets where who comes
    from the right goes first. Tractors.
    """
    main, street, back = "highway.primary", "highway.tertiary", "highway.residential"
    rail = lambda s: 14 * math.sin(s / 420)
    y = lambda s: rail(s) - 64
    jolt = lambda: draw.uniform(-8, 8)
    x = {"mw": -1200, "da": -838 + jolt(), "db": -708 + jolt(), "m1": -265 + jolt(), "m2": 165 + jolt(), "m3": 560 + jolt(), "cs": 800, "me": 1280}
    nodes, edges, links = [], [], []
    lit = {"m2": "traffic_light"}
    nodes += [node(n, v, y(v), lit.get(n, "priority")).replace("/>", ' radius="9"/>' if n == "m3" else "/>") for n, v in x.items()]
    cx, cy = 890, y(890) - 4
    ring(edges, nodes, "c", cx, cy, 21, 1, [4, 180, 262, 316], 8.33)
    # Rails, and the nodes at which roads cross them.
    over = {"l1": x["m1"] + 2, "l2": x["m2"] - 2, "l3": x["m3"] + 1}
    nodes += [node(n, v, rail(v), "traffic_light") for n, v in over.items()] + [node("rw", -1250, rail(-1250)), node("re", 1250, rail(1250))]
    ends = [("rw", -1250), *over.items(), ("re", 1250)]
    for (a, xa), (b, xb) in zip(ends, ends[1:]):
        for start, end, sign in ((a, b, 1), (b, a, -1)):
            line = [(px, py - sign * 0.6) for px, py in stations(xa + 9, xb - 9, rail, 60)]
            edges.append(only(edge(f"t{start}{end}", start, end, 1, 22.22, "railway.rail", 12, line[::sign]), "rail"))
    # The road beside it.
    for a, b, limit, bays in (("mw", "da", 25.0, (0, 0)), ("da", "db", 22.22, (0, 0)), ("db", "m1", 25.0, (50, 0)), ("m1", "m2", 19.44, (45, 0)), ("m2", "m3", 22.22, (0, 45)), ("m3", "cs", 22.22, (0, 0))):
        for start, end, bay in ((a, b, bays[0]), (b, a, bays[1])):
            # Before a bay the lane moves over by its width.
            sign, far = (1 if start == a else -1), abs(x[b] - x[a])
            moved = lambda s: 3.2 * min(1, max(0, (far - bay - 20 - abs(s - x[start])) / 70)) if bay else 0.0
            line = stations(x[start] + sign * 12, x[end] - sign * 12, lambda s: y(s) + sign * moved(s), 30)
            edges.append(edge(start + end, start, end, 1, limit, main, 9, line, bay))
    two_way(edges, "cs", "c1", 1, 16.67, main, 9, shape=[(845, y(850) - 2)])
    two_way(edges, "c0", "me", 1, 22.22, main, 9, shape=[(950, y(950)), (1100, y(1100))])
    # The triangle: who turns sharply at one of its corners uses another.
    tx, ty = (x["da"] + x["db"]) / 2, y(-773) - 96
    spots = {"dc": (tx, ty), "dz": (tx + 15, -330), "dzz": (tx + 45, -520), "i1": (172, -195), "iz": (185, -400), "iw": (-180, -275), "fn": (x["m3"] + 14, 150), "fs": (x["m3"] - 12, -250), "cz": (cx - 14, cy - 110), "czz": (cx - 40, -390), "ce": (1090, -240),
             "t1": (-258, 96), "s1": (-132, 106), "mk": (-12, 98), "s2": (78, 104), "t2": (166, 96), "tw": (-560, 150), "te": (450, 150), "n1": (-138, 205), "n2": (-20, 198), "n3": (82, 207), "nn": (-28, 350), "nw": (-300, 205), "ne": (215, 222), "k2": (-10, 44), "k1": (70, 44)}
    kinds = {"mk": "traffic_light", "n1": "right_before_left", "n2": "right_before_left", "n3": "right_before_left", "s1": "right_before_left", "i1": "priority_stop", "t2": "priority"}
    nodes += [node(n, px, py, kinds.get(n, "priority")) for n, (px, py) in spots.items()]
    two_way(edges, "dc", "da", 1, 13.89, street, 6, shape=[(tx - 30, ty + 38), (x["da"] + 14, y(-838) - 30)])
    two_way(edges, "dc", "db", 1, 13.89, street, 6, shape=[(tx + 30, ty + 38), (x["db"] - 14, y(-708) - 30)])
    for a, b, limit, kind, rank in (("dz", "dc", 19.44, street, 7), ("dzz", "dz", 19.44, street, 7), ("iw", "dz", 13.89, street, 4), ("m1", "l1", 13.89, street, 6), ("l1", "t1", 13.89, street, 6), ("m2", "l2", 13.89, street, 6), ("l2", "t2", 13.89, street, 6), ("m3", "l3", 8.33, back, 3), ("l3", "fn", 8.33, back, 3),
                                    ("m3", "fs", 8.33, back, 3), ("m2", "i1", 13.89, street, 6), ("i1", "iz", 13.89, street, 6), ("iw", "i1", 13.89, street, 4), ("c2", "cz", 16.67, street, 7), ("cz", "czz", 16.67, street, 7), ("c3", "ce", 13.89, street, 5)):
        two_way(edges, a, b, 1, limit, kind, rank)
    # Nobody walks over the rails.
    edges[:] = [closed(row, "pedestrian") if any(f'"{n}"' in row for n in over) and "allow=" not in row else row for row in edges]
    edges.append(edge("past", "cs", "cz", 1, 11.11, street, 5, [(826, y(815) - 5), (846, cy - 25), (862, cy - 55), (871, cy - 85)]))
    # The town.
    for a, b, limit, rank in (("tw", "t1", 13.89, 6), ("t1", "s1", 11.11, 6), ("s1", "mk", 11.11, 6), ("mk", "s2", 11.11, 6), ("s2", "t2", 11.11, 6), ("t2", "te", 13.89, 6), ("s1", "n1", 8.33, 4), ("mk", "n2", 8.33, 4), ("s2", "n3", 8.33, 4), ("n1", "n2", 8.33, 3), ("n2", "n3", 8.33, 3),
                              ("n2", "nn", 8.33, 3), ("n1", "nw", 8.33, 3), ("nw", "t1", 8.33, 3), ("n3", "ne", 8.33, 3), ("ne", "t2", 8.33, 3)):
        two_way(edges, a, b, 1, limit, street if rank > 4 else back, rank)
    edges += [edge("mkk2", "mk", "k2", 1, 8.33, back, 3), edge("k2k1", "k2", "k1", 2, 6.94, back, 3), edge("k1s2", "k1", "s2", 1, 8.33, back, 3)]
    links += [f'<delete from="{a}" to="{b}"/>' for a, b in (("dbda", "dadc"), ("dcda", "dadb"), ("dadb", "dbdc"), ("dcdb", "dbda"), ("dadc", "dcdb"), ("dbdc", "dcda"))]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    free = lambda a, b: link(a, b, 0, 0).replace("/>", ' uncontrolled="true"/>')
    for (a, _), (n, _), (b, _) in zip(ends, ends[1:], ends[2:]):
        links += [free(f"t{a}{n}", f"t{n}{b}"), free(f"t{b}{n}", f"t{n}{a}")]
    for a, n, b in (("m1", "l1", "t1"), ("m2", "l2", "t2"), ("m3", "l3", "fn")):
        links += [link(a + n, n + b, 0, 0), link(b + n, n + a, 0, 0)]
    document(work / "con.xml", "connections", links)
    # Trains run to time; the lights at the crossings are red from 14 s before they come until they are past.
    programs, pace, length, cycle = [], 22.0, 64, 100
    for n, v in over.items():
        shut = sorted((t - 14, t + length / pace + 3) for t in ((v + 1250 - length) / pace, (1250 - v - length) / pace))
        if shut[1][0] - shut[0][1] < 9:
            shut = [(shut[0][0], max(c[1] for c in shut))]
        phases, now = [], 0
        for a, b in ((round(a), round(b)) for a, b in shut):
            phases += [(a - 3 - now, "GG"), (3, "yy"), (b - a, "rr")]
            now = b
        rows = "".join(f'<phase duration="{d}" state="{s}"/>' for d, s in [*phases, (cycle - now, "GG")])
        programs.append(f'<tlLogic id="{n}" type="static" programID="trains" offset="0">{rows}</tlLogic>')
    document(work / "trains.add.xml", "additional", programs)
    rows = [f'<flow id="fetch{i}" type="{draw.choice(("car", "quick", "van"))}" begin="0" end="290" period="exp({1 / draw.randint(55, 80):.4f})" from="{a}" to="{b}"><stop lane="k2k1_1" startPos="{14 + i * 14}" endPos="{23 + i * 14}" duration="{draw.randint(14, 36)}"/></flow>' for i, (a, b) in enumerate((("twt1", "t2te"), ("l1t1", "n2nn"), ("tet2", "t1tw"), ("l2t2", "t2l2")))]
    feet = (("s1mk", "mkn2", 15), ("n2mk", "mks2", 17), ("mkk2", "s2mk", 13), ("s2n3", "k1s2", 19), ("t1s1", "s1n1", 21), ("n3s2", "s2t2", 18), ("n1n2", "n2mk", 16), ("s1mk", "mks2", 12))
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="train{a}" type="train" begin="0" period="{cycle}" number="4" from="{a}" to="{b}" departSpeed="{pace}"/>' for a, b in (("trwl1", "tl3re"), ("trel3", "tl1rw"))),
        *rows,
        '<flow id="line" type="coach" begin="0" period="85" number="3" from="twt1" to="t2te"><stop lane="s1mk_1" startPos="70" endPos="84" duration="14"/></flow>',
        *(f'<flow id="tractor{i}" type="van" begin="0" period="{p}" number="3" from="{a}" to="{b}" speedFactor="{f}"/>' for i, (a, b, p, f) in enumerate((("mwda", "m3fs", 105, 0.34), ("fsm3", "damw", 98, 0.32), ("fnl3", "c0me", 110, 0.5)))),
        *(f'<flow id="day{i}" type="{kind}" begin="0" period="{p}" number="{int(290 / p)}" from="{a}" to="{b}"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "mwda", "t2te", 37), ("car", "mec0", "t1tw", 33), ("truck", "mec0", "i1iz", 61), ("car", "izi1", "t1tw", 41), ("car", "dzzdz", "l1t1", 43), ("car", "twt1", "c0me", 39), ("van", "fnl3", "damw", 73), ("car", "mwda", "dzdzz", 51), ("car", "mec0", "dzdzz", 59),
            ("car", "czzcz", "c0me", 47), ("car", "mwda", "czczz", 49), ("truck", "mwda", "c0me", 57), ("car", "tet2", "damw", 45)))),
        *(f'<personFlow id="foot{i}" type="walker" begin="0" end="300" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(feet))]))
    skip = ("m1l1", "l1m1", "l1t1", "t1l1", "m2l2", "l2m2", "l2t2", "t2l2", "m3l3", "l3m3", "l3fn", "fnl3", "m3fs", "fsm3", "m2i1", "i1m2", "i1iz", "izi1", "iwi1", "i1iw", "dcda", "dadc", "dcdb", "dbdc", "iwdz", "dziw", "past", "c3ce", "cec3", *(f"cr{i}" for i in range(4)))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--tls.cycle.time", 60, "--tls.yellow.time", 3, "--tls.left-green.time", 7, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--sidewalks.guess.exclude", ",".join(skip), "--crossings.guess"]
