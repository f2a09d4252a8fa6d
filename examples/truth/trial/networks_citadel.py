"""Road networks of the seventeenth held group, of a city that grew around a walled town: the town's lanes, in which who
comes from the right goes first, inside a boulevard that one drives around in one direction; a junction on two levels at
which one motorway ends at another, with works that hold up its traffic; a high street for traffic on the left with bus
lanes and staggered side roads; roads at night, with lights that answer to traffic and lights that only blink.
"""

import math

from networks import document, edge, link, node, ring, smooth, two_way
from networks_gateway import stations
from networks_newtown import boxed, ease
from networks_outskirts import ahead, lifted


def walls(work, draw):
    """Ten joints of a boulevard of two lanes, driven around anti-clockwise: five gates with lights, where roads come
    from outside, and five openings that give way. Inside, crooked streets of 20 and 30 km/h, two of them one way,
    in which things are delivered; many riders and people.
    """
    around, street, lane = "highway.secondary", "highway.tertiary", "highway.living_street"
    jolt = lambda most=6: draw.uniform(-most, most)
    nodes, edges, place = [], [], {}
    spot = lambda deg, rx, ry: (rx * math.cos(math.radians(deg)), ry * math.sin(math.radians(deg)))
    angle = {i: 36 * i + jolt(4) for i in range(10)}
    for i, deg in angle.items():
        place[f"g{i}"] = spot(deg, 265, 205)
    for i in range(7):
        place[f"m{i}"] = spot(360 / 7 * i + 14 + jolt(5), 150 + jolt(10), 112 + jolt(8))
    place |= {"c0": (52 + jolt(), 18 + jolt()), "c1": (-44 + jolt(), 40 + jolt()), "c2": (-12 + jolt(), -46 + jolt())}
    outer = {n: spot(angle[int(n[1])], 455 + jolt(14), 395 + jolt(14)) for n in ("o0", "o2", "o4", "o6", "o8")}
    place |= outer
    for n, p in place.items():
        nodes.append(node(n, *p, {"m": "right_before_left", "c": "right_before_left"}.get(n[0], "traffic_light" if n in ("g0", "g2", "g4", "g6", "g8") else "priority")))
    for i in range(10):
        a, b = angle[i], angle[i] + (angle[(i + 1) % 10] - angle[i]) % 360
        edges.append(edge(f"b{i}", f"g{i}", f"g{(i + 1) % 10}", 2, 13.89, around, 9, [spot(a + (b - a) * t / 5, 265, 205) for t in range(1, 5)], bay=38 if (i + 1) % 2 == 0 else 0))
    for n in outer:
        i = n[1]
        two_way(edges, n, f"g{i}", 1, 13.89, street, 6, back=1, bays=(42, 0))
    bent = lambda a, b: [tuple((p + q) / 2 + jolt(9) for p, q in zip(place[a], place[b]))]
    narrow = lambda rows: [r.replace("<edge ", '<edge width="2.9" ') for r in rows]
    inside = []
    # From the boulevard to the nearest streets.
    for g, m in (("g0", "m0"), ("g1", "m0"), ("g2", "m1"), ("g3", "m2"), ("g4", "m3"), ("g5", "m3"), ("g6", "m4"), ("g7", "m5"), ("g8", "m5"), ("g9", "m6")):
        two_way(inside, g, m, 1, 8.33, street if int(g[1]) % 2 == 0 else lane, 4 if int(g[1]) % 2 == 0 else 2)
    for i in range(7):
        two_way(inside, f"m{i}", f"m{(i + 1) % 7}", 1, 8.33, lane, 3, shape=bent(f"m{i}", f"m{(i + 1) % 7}"))
    for a, b, limit in (("m0", "c0", 8.33), ("m1", "c0", 5.56), ("m2", "c1", 8.33), ("m3", "c1", 5.56), ("m4", "c2", 5.56), ("m5", "c2", 8.33)):
        two_way(inside, a, b, 1, limit, lane, 3)
    inside += [edge("c0c1", "c0", "c1", 1, 5.56, lane, 3, bent("c0", "c1")), edge("c1c2", "c1", "c2", 1, 5.56, lane, 3, bent("c1", "c2")), edge("c2c0", "c2", "c0", 1, 5.56, lane, 3)]
    edges += narrow(inside)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    ride = (("o0g0", "g4o4", 31), ("o2g2", "g6o6", 37), ("o6g6", "g0o0", 33), ("o4g4", "g8o8", 41), ("o8g8", "g2o2", 43), ("g1m0", "m3g5", 47), ("g7m5", "m2g3", 53))
    drive = (("car", "o0g0", "g4o4", 23), ("car", "o2g2", "g6o6", 27), ("car", "o4g4", "g0o0", 25), ("car", "o6g6", "g2o2", 29), ("moto", "o8g8", "g4o4", 61), ("car", "o8g8", "g6o6", 31), ("car", "o2g2", "m2c1", 59), ("car", "o6g6", "m5c2", 57), ("van", "o4g4", "m0c0", 71))
    deliver = [f'<flow id="parcel{i}" type="van" begin="0" period="{p}" number="{int(230 / p)}" from="{a}" to="{b}"><stop lane="{at}" endPos="38" duration="{draw.randint(11, 19)}"/></flow>'
               for i, (a, at, b, p) in enumerate((("o0g0", "m0m1_1", "g2o2", 83), ("o4g4", "m3m4_1", "g6o6", 91), ("o6g6", "m4m5_1", "g8o8", 79)))]
    rows = [f'<flow id="ride{i}" type="cycle" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}"/>' for i, (a, b, p) in enumerate(ride)]
    rows += [f'<flow id="drive{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate(drive)]
    # People cross the boulevard at the openings, and streets inside.
    feet = (("b0", "g1m0", 11), ("g3m2", "b3", 12), ("b4", "g5m3", 12), ("g7m5", "b7", 13), ("b8", "g9m6", 11), ("m0m1", "m2m1", 14), ("m4m5", "m6m5", 13), ("b2", "g3m2", 15))
    walk = [f'<personFlow id="foot{i}" type="walker" begin="0" end="270" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(feet)]
    (work / "parked.txt").write_text("\n".join([*rows, *deliver, *walk]))
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 62, "--tls.yellow.time", 3, "--tls.left-green.time", 6, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--crossings.guess"]


def tee(work, draw):
    """A motorway from the south ends at one from west to east, whose left turns pass over it and over each other's
    road. Eastwards: an exit of two lanes, an entry of two, then lanes end one after the other, by turns and on the
    right, and a stretch of 45 km/h at whose start three lanes become two. Westwards: an exit without a lane, an
    entry by a lane that ends, a left lane that ends, a place to rest.
    """
    main, ramp, high = "motorway", "motorway_link", 6.5
    jolt = lambda: draw.uniform(-12, 12)
    nodes, edges, links = [], [], []
    bow = lambda x: 24 * math.cos(x / 700) - 24
    tilt = lambda x: math.atan2(bow(x + 5) - bow(x - 5), 10)
    # Stations, lanes and limits from there on.
    east = (("e0", -1500, 3, 33.33), ("e1", -760 + jolt(), 4, 33.33), ("e2", -400, 3, 30.56), ("e3", 390, 5, 30.56), ("e4", 640 + jolt(), 4, 27.78), ("e5", 900 + jolt(), 3, 19.44), ("e6", 1300 + jolt(), 2, 12.5), ("e7", 1750, 2, 27.78), ("e8", 2200, 0, 0))
    west = (("w0", 2200, 3, 33.33), ("w1", 1320 + jolt(), 4, 33.33), ("w2", 1080, 3, 33.33), ("w3", 760, 4, 33.33), ("w4", 560 + jolt(), 3, 33.33), ("w5", 330, 3, 30.56), ("w6", -420, 4, 30.56), ("w7", -690 + jolt(), 3, 33.33), ("w8", -1010 + jolt(), 2, 33.33), ("w9", -1600, 0, 0))
    # How much of the carriageway beyond its station a junction covers, where a ramp leaves or comes.
    after, before = {"e2", "w2", "w5"}, {"e3", "w3", "w6"}
    at = {}
    for sign, row in ((1, east), (-1, west)):
        for i, (n, x, lanes, _) in enumerate(row):
            at[n] = x
            most = max(lanes, row[i - 1][2] if i else 0)
            plain = lifted(n, x, bow(x) - 5 * sign, 0, "zipper" if n == "e5" else "priority")
            if n in after | before:
                lo, hi = (2, 28) if n in after else (28, 2)
                plain = boxed(plain, x, bow(x) - 5 * sign, tilt(x) + (0 if sign > 0 else math.pi), lo, hi, 3.2 * (most + (n in ("w5",))) + 0.6, 0.2)
            nodes.append(plain)
        for (a, xa, lanes, limit), (b, xb, *_) in zip(row, row[1:]):
            lo, hi = xa + sign * (28 if a in after else 2), xb - sign * (28 if b in before else 2)
            edges.append(edge(a + b, a, b, lanes, limit, main, 13, [(x, y, 0) for x, y in stations(lo, hi, lambda x: bow(x) - 5 * sign, 55)]))
    same = lambda a, b, n, more: ahead(a, b, *[(k, k + more) for k in range(n) if k + more >= 0])
    links += same("e0e1", "e1e2", 3, 1) + ahead("e1e2", "e2e3", (1, 0), (2, 1), (3, 2)) + ahead("e1e2", "es", (0, 0), (1, 1)) + same("e2e3", "e3e4", 3, 2) + ahead("ne", "e3e4", (0, 0), (1, 1))
    links += same("e3e4", "e4e5", 5, -1) + ahead("e4e5", "e5e6", (0, 0), (1, 0), (2, 1), (3, 2)) + same("e5e6", "e6e7", 3, -1) + same("e6e7", "e7e8", 2, 0)
    links += same("w0w1", "w1w2", 3, 1) + ahead("w1w2", "w2w3", (1, 0), (2, 1), (3, 2)) + ahead("w1w2", "rest0", (0, 0)) + same("w2w3", "w3w4", 3, 1) + ahead("rest2", "w3w4", (0, 0)) + same("w3w4", "w4w5", 4, -1)
    links += same("w4w5", "w5w6", 3, 0) + ahead("w4w5", "ws", (0, 0)) + same("w5w6", "w6w7", 3, 1) + ahead("nw", "w6w7", (0, 0)) + same("w6w7", "w7w8", 4, -1) + ahead("w7w8", "w8w9", (0, 0), (1, 1))

    def slip(name, a, b, count, limit, points):
        edges.append(edge(name, a, b, count, limit, ramp, 8, smooth([points[0], *points, points[-1]], 6)))

    # The motorway from the south: north-bound it parts at n1, south-bound its ramps join at s0.
    nodes += [lifted("n0", 6, -1150, 0), boxed(lifted("n1", 6, -520, 0), 6, -520, math.pi / 2, 2, 24, 10.4, 0.2), boxed(lifted("s0", -6, -600, 0), -6, -600, -math.pi / 2, 24, 2, 10.4, 0.2), lifted("s1", -6, -880 + jolt(), 0), lifted("s2", -6, -1300, 0)]
    edges += [edge("n0n1", "n0", "n1", 3, 27.78, main, 13, [(6, -1140, 0), (6, -522, 0)]), edge("s0s1", "s0", "s1", 3, 27.78, main, 13, [(-6, -602, 0), (-6, -840, 0)]), edge("s1s2", "s1", "s2", 2, 30.56, main, 13)]
    links += ahead("n0n1", "ne", (0, 0), (1, 1)) + ahead("n0n1", "nw", (2, 0)) + ahead("es", "s0s1", (0, 0), (1, 1)) + ahead("ws", "s0s1", (0, 2)) + same("s0s1", "s1s2", 3, -1)
    off, on = at["e2"], at["e3"]
    y = lambda x, sign, more=0.0: bow(x) - sign * 5 - more
    slip("ne", "n1", "e3", 2, 22.22, [(9.2, -496, 0), (11, -440, 0), (26, -350, 0), (62, -240, 0), (125, -135, 0), (205, -62, 0), (290, y(290, 1, 18), 0), (on - 28, y(on - 28, 1, 9.8), 0)])
    slip("es", "e2", "s0", 2, 22.22, [(off + 28, y(off + 28, 1, 6.6), 0), (off + 90, y(off + 90, 1, 14), 0), (-225, -78, 0), (-140, -160, 0), (-78, -270, 0), (-38, -390, 0), (-16, -500, 0), (-9.4, -576, 0)])
    slip("nw", "n1", "w6", 1, 19.44, [(6, -496, 0.2), (5, -440, 1.8), (0, -370, 4.4), (-14, -290, 6.2), (-40, -200, high), (-80, -105, high), (-130, -25, high), (-200, 26, 5.4), (-280, y(-280, -1, -20), 2.4), (-350, y(-350, -1, -12.5), 0.4), (at["w6"] + 28, y(at["w6"] + 28, -1, -9.8), 0)])
    off = at["w5"]
    slip("ws", "w5", "s0", 1, 16.67, [(off - 28, y(off - 28, -1, -9.8), 0), (off - 75, y(off - 75, -1, -13), 0.8), (190, 44, 2.8), (120, 54, 5.2), (62, 38, high), (26, -4, high), (8, -70, 5.8), (0, -150, 3), (-4, -230, 0.5), (-6, -330, 0), (-6, -480, 0), (-6, -576, 0)])
    # A place to rest, where lorries stand.
    lead, back, calm = at["w2"], at["w3"], y(920, -1, -32)
    nodes += [lifted("r0", lead - 125, calm, 0), lifted("r1", back + 125, calm, 0)]
    slip("rest0", "w2", "r0", 1, 16.67, [(lead - 28, y(lead - 28, -1, -9.8), 0), (lead - 55, y(lead - 55, -1, -12.5), 0), (lead - 85, y(lead - 85, -1, -24), 0), (lead - 110, calm, 0), (lead - 123, calm, 0)])
    edges.append(edge("rest1", "r0", "r1", 2, 8.33, ramp, 7))
    slip("rest2", "r1", "w3", 1, 16.67, [(back + 123, calm, 0), (back + 110, calm, 0), (back + 85, y(back + 85, -1, -24), 0), (back + 55, y(back + 55, -1, -12.5), 0), (back + 28, y(back + 28, -1, -9.8), 0)])
    links += ahead("rest0", "rest1", (0, 0), (0, 1)) + ahead("rest1", "rest2", (0, 0), (1, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="haul{i}" type="truck" begin="0" period="{p}" number="{int(210 / p)}" from="{a}" to="{b}" departLane="0" departSpeed="max"{via}/>' for i, (a, b, p, via) in enumerate((
            ("e0e1", "e7e8", 11, ""), ("w0w1", "w8w9", 15, ""), ("n0n1", "e7e8", 17, ""), ("w0w1", "s1s2", 29, ""), ("n0n1", "w8w9", 31, ""), ("e0e1", "s1s2", 23, "")))),
        *(f'<flow id="rest{i}" type="{kind}" begin="0" period="{p}" number="{int(200 / p)}" from="w0w1" to="w8w9" via="rest1" departLane="0" departSpeed="max">{stop}</flow>' for i, (kind, p, stop) in enumerate((
            ("car", 41, ""), ("quick", 53, ""), ("truck", 67, '<stop lane="rest1_1" endPos="60" duration="40"/>'))))]))
    return ["--no-turnarounds"]


def highstreet(work, draw):
    """Traffic on the left. Crossings with lights and bays for right turns, between them lanes for buses and riders
    that end 50 m before the lights, stops on them, two crossings with lights of their own for people, two side
    roads 46 m apart on both sides. At the east end a roundabout of two lanes, clockwise; behind the shops a street.
    """
    high, side, back = "highway.primary", "highway.tertiary", "highway.residential"
    jolt = lambda most=8: draw.uniform(-most, most)
    y = lambda x: 16 * math.sin(x / 210)
    x = {"w": -760, "p1": -560 + jolt(), "qa": -372, "a": -310 + jolt(5), "qb": -248, "s1": -72, "s2": -26, "p2": 72 + jolt(), "qc": 208, "c": 270 + jolt(5), "qd": 332}
    nodes, edges, links = [], [], []
    for n, v in x.items():
        row = node(n, v, y(v), "traffic_light" if n in ("a", "c", "p1", "p2") else "priority")
        nodes.append(boxed(row, v, y(v), math.atan2(y(v + 5) - y(v - 5), 10), 2.6, 2.6, 10.5, 10.5) if n in ("p1", "p2") else row)
    cx, cy = 520, y(520)
    spin = {"o0": 8, "o1": 96, "o2": 180, "o3": 262}
    nodes += [node(n, cx + 27 * math.cos(math.radians(d)), cy + 27 * math.sin(math.radians(d))) for n, d in spin.items()]
    turn = ["o0", "o3", "o2", "o1"]
    for a, b in zip(turn, [*turn[1:], turn[0]]):
        sweep = (spin[a] - spin[b]) % 360
        edges.append(edge(f"spin{a}", a, b, 2, 9.72, high, 10, [(cx + 27 * math.cos(math.radians(spin[a] - sweep * t / 8)), cy + 27 * math.sin(math.radians(spin[a] - sweep * t / 8))) for t in range(1, 8)]))
    edges.append(f'<roundabout nodes="{" ".join(turn)}" edges="{" ".join("spin" + n for n in turn)}"/>')
    bus = lambda row: row.replace("></edge>", '><lane index="0" allow="bus bicycle"/></edge>')
    for a, b in (("w", "p1"), ("p1", "qa"), ("qa", "a"), ("a", "qb"), ("qb", "s1"), ("s1", "s2"), ("s2", "p2"), ("p2", "qc"), ("qc", "c"), ("c", "qd"), ("qd", "o2")):
        for u, v in ((a, b), (b, a)):
            row = edge(u + v, u, v, 2, 13.41, high, 9, bay=44 if v in ("a", "c") else 0)
            edges.append(bus(row) if {u, v} in ({"p1", "qa"}, {"p2", "qc"}, {"w", "p1"}) and v in ("qa", "qc", "p1", "w") else row)
    place = {"an": (-330, 210), "as": (-296, -215), "cn": (284, 205), "cs": (262, -190), "n1": (-84, 150), "n2": (-30, -160), "e": (760, -8), "on": (505, 240), "oz": (540, -260), "t1": (-318, -120), "t2": (-28, -96), "t3": (272, -118)}
    nodes += [node(n, *p, "priority_stop" if n in ("t1",) else "priority") for n, p in place.items()]
    for u, v, lanes, limit, kind, rank, bays in (("an", "a", 1, 13.41, side, 7, (40, 0)), ("cn", "c", 1, 13.41, side, 7, (40, 0)), ("t1", "a", 1, 13.41, side, 7, (40, 0)), ("as", "t1", 1, 13.41, side, 7, (0, 0)), ("t3", "c", 1, 13.41, side, 7, (40, 0)), ("cs", "t3", 1, 13.41, side, 7, (0, 0)),
                                                 ("n1", "s1", 1, 8.94, back, 4, (0, 0)), ("t2", "s2", 1, 8.94, back, 4, (0, 0)), ("n2", "t2", 1, 8.94, back, 4, (0, 0)), ("t1", "t2", 1, 8.94, back, 3, (0, 0)), ("t2", "t3", 1, 8.94, back, 3, (0, 0)),
                                                 ("e", "o0", 2, 17.88, high, 8, (0, 0)), ("on", "o1", 2, 13.41, side, 7, (0, 0)), ("oz", "o3", 1, 13.41, side, 7, (0, 0))):
        two_way(edges, u, v, lanes, limit, kind, rank, bays=bays)
    links += [f'<crossing node="{n}" edges="{b}{n} {n}{b}" width="5"/>' for n, b in (("p1", "qa"), ("p2", "qc"))]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    flows = (("car", "wp1", "o0e", 13), ("car", "eo0", "p1w", 14), ("car", "wp1", "aan", 47), ("car", "eo0", "ct3", 43), ("car", "ana", "o0e", 41), ("car", "cnc", "p1w", 45), ("car", "n1s1", "s2t2", 39), ("car", "n2t2", "s1n1", 37), ("car", "ono1", "o3oz", 33), ("car", "ozo3", "p1w", 35), ("van", "eo0", "s2t2", 49),
             ("quick", "ono1", "o0e", 51), ("truck", "eo0", "o1on", 61), ("car", "ozo3", "o1on", 57))
    ride = (("wp1", "o0e", 23), ("eo0", "p1w", 27), ("ana", "at1", 51), ("n1s1", "s2t2", 47))
    stops = lambda *spots: "".join(f'<stop lane="{lane}" endPos="{at}" duration="{draw.randint(9, 17)}"/>' for lane, at in spots)
    walk = (("wp1", "p1w", 13), ("p1qa", "qap1", 11), ("p2qc", "qcp2", 10), ("qcp2", "p2s2", 14), ("s2t2", "p2qc", 17))
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="day{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate(flows)),
        *(f'<flow id="ride{i}" type="cycle" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}"/>' for i, (a, b, p) in enumerate(ride)),
        f'<flow id="red" type="coach" begin="0" period="37" number="7" from="wp1" to="o0e">{stops(("p1qa_1", 100), ("p2qc_1", 80))}</flow>',
        f'<flow id="green" type="coach" begin="5" period="41" number="6" from="eo0" to="p1w">{stops(("qdc_1", 20), ("p1w_1", 60))}</flow>',
        *(f'<personFlow id="shop{i}" type="walker" begin="0" end="260" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(walk))]))
    skip = ",".join(f"spin{n}" for n in turn)
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 72, "--tls.yellow.time", 3, "--tls.left-green.time", 8, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--sidewalks.guess.exclude", skip, "--crossings.guess"]


def nightshift(work, draw):
    """A bypass of 80 km/h with a lane more for 350 m, two lights on it that answer to traffic, two crossings whose
    lights blink, a divided road to halls, on which one turns round at a light, a roundabout of one lane at which
    lorries meet, a lane across the fields whose crossings have stop signs. Few vehicles, many of them lorries.
    """
    bypass, town, yard, field = "highway.primary", "highway.secondary", "highway.unclassified", "highway.residential"
    jolt = lambda: draw.uniform(-9, 9)
    nodes, edges, links = [], [], []
    y = lambda x: 34 * math.sin(x / 420)
    x = {"w": -1150, "k1": -820 + jolt(), "k2": -470 + jolt(), "a": -120 + jolt(), "b": 300 + jolt(), "e0": 620}
    lit = {"a": "traffic_light", "b": "traffic_light", "k2": "zipper"}
    nodes += [node(n, v, y(v), lit.get(n, "priority")) for n, v in x.items()]
    ring(edges, nodes, "r", 660, y(660), 24, 1, [12, 92, 176, 270], 8.33)
    nodes = [n for n in nodes if 'id="e0"' not in n]
    place = {"e": (1150, 52), "an": (-128, 205), "ad": (-132, 400), "bn": (292, 190), "bd": (286, 400), "az": (-118, -210), "bz": (305, -225), "zz": (310, -480), "aw": (-120, -470), "f": (-520, -260), "ff": (-840, -280), "h1": (640, 250), "h2": (628, 480), "h3": (820, 478), "h4": (430, 470), "rz": (655, -260), "ns": (80, 205), "nw": (-420, 230)}
    kinds = {"an": "traffic_light", "bn": "traffic_light", "h1": "traffic_light", "f": "priority_stop", "az": "priority_stop", "bz": "allway_stop", "h2": "right_before_left", "ns": "priority"}
    nodes += [node(n, *p, kinds.get(n, "priority")) for n, p in place.items()]
    span = lambda a, b: [(v, y(v)) for v, _ in stations(x[a], x[b], lambda v: 0, 45)][1:-1]
    # East-bound two lanes from k1 to k2, which become one by turns.
    edges += [edge("wk1", "w", "k1", 1, 22.22, bypass, 9, span("w", "k1")), edge("k1k2", "k1", "k2", 2, 22.22, bypass, 9, span("k1", "k2")), edge("k2a", "k2", "a", 1, 22.22, bypass, 9, span("k2", "a"), bay=60)]
    edges += [edge("k1w", "k1", "w", 1, 22.22, bypass, 9, span("w", "k1")[::-1]), edge("k2k1", "k2", "k1", 1, 22.22, bypass, 9, span("k1", "k2")[::-1]), edge("ak2", "a", "k2", 1, 22.22, bypass, 9, span("k2", "a")[::-1])]
    two_way(edges, "a", "b", 1, 19.44, bypass, 9, shape=span("a", "b"), bays=(60, 60))
    two_way(edges, "b", "r2", 1, 19.44, bypass, 9, shape=[(450, y(450)), (560, y(560))], bays=(0, 60))
    two_way(edges, "r0", "e", 1, 22.22, bypass, 9, shape=[(760, y(760)), (950, y(950))])
    for u, v, limit, kind, rank, bays in (("an", "a", 13.89, town, 7, (45, 0)), ("ad", "an", 13.89, town, 6, (0, 0)), ("bn", "b", 13.89, town, 7, (45, 0)), ("bd", "bn", 13.89, town, 6, (0, 0)), ("an", "ns", 13.89, town, 7, (0, 0)), ("ns", "bn", 13.89, town, 7, (0, 0)), ("an", "nw", 13.89, town, 7, (0, 0)),
                                          ("az", "a", 13.89, town, 7, (45, 0)), ("aw", "az", 13.89, town, 5, (0, 0)), ("bz", "b", 13.89, town, 7, (45, 0)), ("zz", "bz", 13.89, town, 6, (0, 0)), ("az", "bz", 16.67, field, 7, (0, 0)), ("f", "az", 16.67, field, 7, (0, 0)), ("ff", "f", 16.67, field, 6, (0, 0)),
                                          ("f", "k2", 13.89, field, 4, (0, 0)), ("rz", "r3", 13.89, yard, 5, (0, 0)), ("rz", "bz", 13.89, field, 4, (0, 0)), ("h2", "h3", 8.33, yard, 3, (0, 0)), ("h2", "h4", 8.33, yard, 3, (0, 0)), ("h4", "bd", 13.89, yard, 4, (0, 0))):
        two_way(edges, u, v, 1, limit, kind, rank, bays=bays)
    edges[:] = [r for r in edges if not r.startswith(('<edge id="fk2"', '<edge id="k2f"'))]
    # The road to the halls: two carriageways 9 m apart; at its light one turns round.
    nodes += [node("hn", 900, 262), node("hw", 420, 245)]
    edges += [edge("r1h1", "r1", "h1", 2, 13.89, yard, 8, [(660, 95), (652, 170)]), edge("h1r1", "h1", "r1", 1, 13.89, yard, 8, [(648, 170), (656, 95)])]
    two_way(edges, "h1", "h2", 2, 13.89, yard, 8)
    two_way(edges, "h1", "hn", 1, 11.11, yard, 6, bays=(0, 40))
    two_way(edges, "h1", "hw", 1, 11.11, yard, 6, bays=(0, 40))
    links += ahead("k1k2", "k2a", (0, 0), (1, 0)) + ahead("r1h1", "h1h2", (0, 0), (1, 1)) + ahead("r1h1", "h1hn", (0, 0)) + ahead("r1h1", "h1hw", (1, 0)) + ahead("r1h1", "h1r1", (1, 0))
    links += ahead("h2h1", "h1r1", (0, 0)) + ahead("h2h1", "h1hw", (0, 0)) + ahead("h2h1", "h1hn", (1, 0)) + ahead("h2h1", "h1h2", (1, 1))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    # At night the lights at these two only blink.
    document(work / "night.add.xml", "additional", [f'<tlLogic id="{n}" type="static" programID="off"/>' for n in ("an", "bn")])
    rows = (("truck", "wk1", "h2h3", 37), ("truck", "er0", "h2h4", 41), ("truck", "h3h2", "k1w", 53), ("car", "wk1", "r0e", 19), ("car", "er0", "k1w", 21), ("quick", "wk1", "r0e", 33), ("car", "adan", "bnbd", 31), ("car", "bdbn", "annw", 29), ("car", "nwan", "bbz", 43), ("car", "zzbz", "k1w", 39),
            ("car", "awaz", "r0e", 41), ("car", "fff", "bzrz", 37), ("car", "hwh1", "r0e", 47), ("car", "adan", "r0e", 45), ("car", "er0", "anad", 49), ("moto", "er0", "k1w", 79))
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="shift{i}" type="{kind}" begin="0" period="{p}" number="{int(270 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate(rows)),
        '<flow id="back" type="car" begin="0" period="29" number="9" from="er0" to="r0e" via="h1r1" departLane="best"/>',
        '<flow id="round" type="van" begin="0" period="47" number="5" from="h3h2" to="h2h4" via="h1h2" departLane="best"/>']))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 3, "--tls.left-green.time", 6]
