"""Road networks of the eighteenth held group, of a state in the plains and a new town: a motorway through a city, with
plain exits, exits of two lanes of which one goes on, weaving, and diamonds of lights or stop signs; the middle of that
city at rush hour, with split phases, lanes for buses and riders and vans that stop in the lane; for traffic on the
left a grid of fast roads with a roundabout at each crossing; a small town amid roads a mile apart, with stop signs.
"""

import math
import xml.etree.ElementTree as ET

from networks import document, edge, node, smooth, tool, two_way
from networks_gateway import stations
from networks_newtown import boxed, ease
from networks_outskirts import ahead, lifted


def freeway(work, draw):
    """Three to four lanes of 105 km/h in each direction, no lorries on the left one. Eastwards: a plain exit, an entry whose
    lane becomes that of an exit of two lanes after 380 m, an entry by a lane that ends, a plain exit, an entry by a lane
    that stays. Westwards: an exit by a lane that only exits and one that also goes on, an entry whose lane exits after
    530 m, an entry by a lane that ends, a plain exit, an entry after which two lanes become one by turns. Three streets
    cross: with lights at the ramps, with stop signs, with lights that answer to traffic; they are joined by others.
    """
    main, ramp, street, high = "motorway", "motorway_link", "highway.secondary", 6.2
    jolt = lambda most=14: draw.uniform(-most, most)
    nodes, edges, links = [], [], []
    bow = lambda x: 30 * math.cos(x / 820) - 30
    tilt = lambda x: math.atan2(bow(x + 5) - bow(x - 5), 10)
    fast = 29.06
    east = (("e0", -2000, 3), ("e1", -1330 + jolt(), 3), ("e2", -790, 4), ("e3", -410, 3), ("e4", 110, 4), ("e5", 350 + jolt(), 3), ("e6", 640 + jolt(), 3), ("e7", 1180, 4), ("e8", 1950, 0))
    west = (("w0", 1950, 4), ("w1", 1180 + jolt(), 3), ("w2", 640, 4), ("w3", 110, 3), ("w4", -410, 4), ("w5", -640 + jolt(), 3), ("w6", -800 + jolt(), 3), ("w7", -1330, 4), ("w8", -1640 + jolt(), 3), ("w9", -2000, 0))
    exits, entries = {"e1", "e3", "e6", "w1", "w3", "w6"}, {"e2", "e4", "e7", "w2", "w4", "w7"}
    at, beside = {}, {}
    for sign, row in ((1, east), (-1, west)):
        for i, (n, x, lanes) in enumerate(row):
            before = row[i - 1][2] if i else lanes
            at[n], beside[n] = x, lanes if n in exits else before
            kind = lifted(n, x, bow(x) - 6 * sign, 0, "zipper" if n == "w8" else "priority")
            if n in exits | entries:
                lo, hi = (2, 27) if n in exits else (27, 2)
                kind = boxed(kind, x, bow(x) - 6 * sign, tilt(x) + (0 if sign > 0 else math.pi), lo, hi, 3.2 * max(lanes + (lanes == before), before) + 0.6, 0.2)
            nodes.append(kind)
        for (a, xa, lanes), (b, xb, _) in zip(row, row[1:]):
            lo, hi = xa + sign * (27 if a in exits else 2), xb - sign * (27 if b in entries else 2)
            made = edge(a + b, a, b, lanes, fast, main, 13, [(x, y, 0) for x, y in stations(lo, hi, lambda x: bow(x) - 6 * sign, 60)])
            edges.append(made.replace("></edge>", f'><lane index="{lanes - 1}" disallow="truck bus trailer"/></edge>'))
    same = lambda a, b, n, more=0: ahead(a, b, *[(k, k + more) for k in range(n) if k + more >= 0])
    links += same("e0e1", "e1e2", 3) + same("e1e2", "e2e3", 3, 1) + ahead("e2e3", "e3e4", (1, 0), (2, 1), (3, 2)) + same("e3e4", "e4e5", 3, 1) + same("e4e5", "e5e6", 4, -1) + same("e5e6", "e6e7", 3) + same("e6e7", "e7e8", 3, 1)
    links += ahead("w0w1", "w1w2", (1, 0), (2, 1), (3, 2)) + same("w1w2", "w2w3", 3, 1) + same("w2w3", "w3w4", 4, -1) + same("w3w4", "w4w5", 3, 1) + same("w4w5", "w5w6", 4, -1) + same("w5w6", "w6w7", 3) + same("w6w7", "w7w8", 3, 1) + ahead("w7w8", "w8w9", (0, 0), (1, 0), (2, 1), (3, 2))
    place = {}
    for k, x, control in (("1", -1055, "traffic_light"), ("2", -155, "priority_stop"), ("3", 905, "traffic_light")):
        for n, dx, y, z, kind in (("n", 4, 84, high, control), ("s", -4, -84, high, control), ("u", 10 + jolt(), 260, 1, "allway_stop" if k == "2" else "priority"), ("v", jolt(), -330, 1, "priority_stop" if k == "2" else "traffic_light"), ("x", jolt(), 480, 0, "priority"), ("y", jolt(), -560, 0, "priority")):
            place[n + k] = (x + dx, y + bow(x) * (n in "ns"))
            nodes.append(lifted(n + k, *place[n + k], z, kind))
        lanes = 1 if k == "2" else 2
        raised = [(place["n" + k][0], place["n" + k][1] - 50, high), (place["s" + k][0], place["s" + k][1] + 50, high)]
        two_way(edges, "n" + k, "s" + k, lanes, 15.65, street, 8, shape=raised, bays=(55, 55))
        for a, b in (("u", "n"), ("v", "s"), ("x", "u"), ("y", "v")):
            two_way(edges, a + k, b + k, lanes, 15.65, street, 8, bays=(40, 0) if a in "xy" else (0, 40))
    for a, b in (("u1", "u2"), ("u2", "u3"), ("v1", "v2"), ("v2", "v3")):
        two_way(edges, a, b, 1, 17.88, "highway.tertiary", 6, shape=[(sum(place[n][0] for n in (a, b)) / 2 + jolt(60), place[a][1] + jolt(35))])
    for n, dx, dy in (("u1", -380, 30), ("v3", 380, 25)):
        nodes.append(lifted("z" + n, place[n][0] + dx, place[n][1] + dy, 0))
        two_way(edges, "z" + n, n, 1, 15.65, "highway.tertiary", 6, bays=(40, 0))

    def curve(s, x, most, end):
        """From beside the motorway at station `x` in an S to a place before (behind) `end`, up to the street's height."""
        gore, far = (x, bow(x) - s * (6 + most)), end
        mid = [(gore[0] + (far[0] - gore[0]) * t, gore[1] + (far[1] - gore[1]) * ease(t), high * min(1, t / 0.8)) for t in (n / 6 for n in range(1, 6))]
        return [(*gore, 0), *mid, (*far, high)]

    def off(name, a, b, lanes, bay):
        """From the motorway at `a` to the street at `b`."""
        s, x, end = 1 if a[0] == "e" else -1, at[a], place[b]
        beyond = 3.2 * beside[a]
        points = [(x + 27 * s, bow(x + 27 * s) - s * (6.2 + beyond), 0), *curve(s, x + 42 * s, beyond + 0.5, (end[0] - 26 * s, end[1])), (end[0] - 14 * s, end[1], high)]
        edges.append(edge(name, a, b, lanes, 20.12, ramp, 8, smooth([points[0], *points, points[-1]], 4), bay=bay))

    def on(name, a, b):
        s, x, start = 1 if b[0] == "e" else -1, at[b], place[a]
        beyond = 3.2 * beside[b]
        points = [(start[0] + 14 * s, start[1], high), *curve(s, x - 42 * s, beyond + 0.5, (start[0] + 26 * s, start[1]))[::-1], (x - 27 * s, bow(x - 27 * s) - s * (6.2 + beyond), 0)]
        edges.append(edge(name, a, b, 1, 22.35, ramp, 8, smooth([points[0], *points, points[-1]], 4)))

    for a, b, road, lanes in (("e1", "s1", "e0e1", 1), ("e3", "s2", "e2e3", 2), ("e6", "s3", "e5e6", 1), ("w1", "n3", "w0w1", 2), ("w3", "n2", "w2w3", 1), ("w6", "n1", "w5w6", 1)):
        off("off" + a, a, b, lanes, 0 if lanes > 1 else 70)
        links += same(road, "off" + a, lanes)
    for a, b, road in (("s1", "e2", "e2e3"), ("s2", "e4", "e4e5"), ("s3", "e7", "e7e8"), ("n3", "w2", "w2w3"), ("n2", "w4", "w4w5"), ("n1", "w7", "w7w8")):
        on("on" + b, a, b)
        links += ahead("on" + b, road, (0, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    rows = (("truck", "e0e1", "e7e8", 13), ("truck", "w0w1", "w8w9", 12), ("truck", "e0e1", "s1v1", 47), ("truck", "w0w1", "n3u3", 53), ("car", "x1u1", "e7e8", 13), ("car", "y1v1", "e7e8", 17), ("car", "y1v1", "w8w9", 19), ("car", "x3u3", "w8w9", 12), ("car", "y3v3", "w8w9", 19),
            ("car", "e0e1", "v2y2", 11), ("car", "e0e1", "u3x3", 13), ("car", "w0w1", "u2x2", 12), ("car", "w0w1", "v3y3", 13), ("quick", "w0w1", "v1y1", 19), ("car", "zu1u1", "s2v2", 17), ("car", "x2u2", "e7e8", 21), ("car", "y2v2", "w8w9", 20), ("car", "x3u3", "s2v2", 23), ("quick", "e0e1", "e7e8", 7), ("quick", "w0w1", "w8w9", 7), ("car", "e0e1", "e7e8", 3.4), ("car", "w0w1", "w8w9", 3.1),
            ("coach", "e0e1", "e7e8", 71), ("van", "y3v3", "v2y2", 31), ("car", "zv3v3", "v2v1", 27))
    (work / "parked.txt").write_text("\n".join(
        f'<flow id="flow{i}" type="{kind}" begin="0" period="{p}" number="{int(220 / p)}" from="{a}" to="{b}" departLane="{"best" if a[0] in "xyz" else 0 if kind in ("truck", "coach") else "random"}" departSpeed="max"/>'
        for i, (kind, a, b, p) in enumerate(rows)))
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 4, "--tls.left-green.time", 7]


def downtown(work, draw):
    """Four streets cross five: one-way ones of three and two lanes, a main one each way with lanes for buses, one with a lane
    for riders. Most crossings have lights of one cycle, green one after the other along the one-way streets; at two
    each approach has its green alone; some have stop signs. Buses stop in their lanes, vans in the lane of all; riders
    and people everywhere, with a crossing that has lights of its own.
    """
    big, mid, small = "highway.primary", "highway.secondary", "highway.tertiary"
    jolt = lambda most=6: draw.uniform(-most, most)
    xs = {c: x + jolt() for c, x in zip("abcde", (0, 138, 262, 410, 548))}
    ys = {r: y + jolt(4) for r, y in zip("0123", (0, 112, 228, 346))}
    kinds = {"a0": "right_before_left", "e0": "allway_stop", "b0": "priority_stop", "d0": "priority_stop", "a1": "priority_stop", "e1": "traffic_light", "a3": "priority", "e3": "allway_stop", "a2": "traffic_light", "e2": "traffic_light"}
    nodes, edges, links = [], [], []
    spot = {c + r: (x + 0.05 * (y - 170) + jolt(3), y - 0.04 * (x - 270) + jolt(3)) for c, x in xs.items() for r, y in ys.items()}
    for n, p in spot.items():
        kind = kinds.get(n, "traffic_light")
        nodes.append(node(n, *p, kind).replace("/>", f' tlLayout="{"incoming" if n in ("c2", "c1") else "opposites"}"/>' if kind == "traffic_light" else "/>"))
    for c in "abcde":
        for r, dy, tag in (("0", -150, "s"), ("3", 150, "n")):
            spot[c + tag] = (spot[c + r][0] + 0.05 * dy + jolt(), spot[c + r][1] + dy)
    for r in "0123":
        for c, dx, tag in (("a", -165, "w"), ("e", 165, "x")):
            spot[tag + r] = (spot[c + r][0] + dx, spot[c + r][1] - 0.04 * dx + jolt())
    nodes += [node(n, *p) for n, p in spot.items() if n[0] in "wx" or n[1] in "ns"]
    # In the middle of the main street's block a crossing for people.
    spot["m"] = tuple((p + q) / 2 for p, q in zip(spot["b2"], spot["c2"]))
    nodes.append(boxed(node("m", *spot["m"], "traffic_light"), *spot["m"], -0.04, 2.6, 2.6, 13, 13))
    for n, a, b in (("f", "c0", "d0"), ("v", "e1", "e2")):
        spot[n] = tuple((p + q) / 2 for p, q in zip(spot[a], spot[b]))
        nodes.append(boxed(node(n, *spot[n]), *spot[n], -0.04 if n == "f" else 1.52, 2.2, 2.2, 8, 8))
    lane = lambda row, who: row.replace("></edge>", f'><lane index="0" allow="{who}"{" width=" + chr(34) + "1.8" + chr(34) if who == "bicycle" else ""}/></edge>')
    line = lambda ids: list(zip(ids, ids[1:]))
    column = lambda c: [c + t for t in "s0123n"]
    row = lambda r: ["w" + r, *(c + r for c in "abcde"), "x" + r]
    for a, b in line(column("b"))[::-1]:
        edges.append(edge(b + a, b, a, 3, 13.41, mid, 8))
    for a, b in line(column("d")):
        made = edge(a + b, a, b, 3, 13.41, mid, 8)
        edges.append(lane(made, "bicycle") if b in ("d1", "d2") else made)
    right = column("e")
    right.insert(right.index("e2"), "v")
    for c in (column("a"), right):
        for a, b in line(c):
            two_way(edges, a, b, 1, 11.18, small, 5)
    for a, b in line(column("c")):
        for u, v in ((a, b), (b, a)):
            edges.append(edge(u + v, u, v, 2, 13.41, big, 9, bay=35 if v in ("c1", "c2") else 0))
    low = row("0")
    low.insert(low.index("d0"), "f")
    for a, b in line(low):
        two_way(edges, a, b, 1, 11.18, small, 4)
    for a, b in line(row("1")):
        edges.append(edge(a + b, a, b, 3, 13.41, mid, 8))
    for a, b in line(row("3"))[::-1]:
        edges.append(edge(b + a, b, a, 2, 13.41, mid, 7))
    two = row("2")
    two.insert(two.index("c2"), "m")
    for a, b in line(two):
        for u, v in ((a, b), (b, a)):
            made = edge(u + v, u, v, 3, 13.41, big, 9)
            # The lane ends where the block before the crossing does.
            edges.append(lane(made, "bus bicycle") if v in ("m", "x2", "w2") else made)
    links.append('<crossing node="m" edges="b2m mb2" width="5"/>')
    # And two where people go first.
    links += ['<crossing node="f" edges="c0f fc0" priority="true" width="4"/>', '<crossing node="v" edges="e1v ve1" priority="true" width="4"/>']
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    options = ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 80, "--tls.yellow.time", 3, "--tls.allred.time", 1, "--tls.left-green.time", 7, "--tls.crossing-min.time", 5, "--tls.crossing-clearance.time", 8, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--crossings.guess"]
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml", "--connection-files", work / "con.xml", "--output-file", work / "draft.xml", "--offset.disable-normalization", "--plain.extend-edge-shape", *options)
    plans = []
    for logic in ET.parse(work / "draft.xml").getroot().iter("tlLogic"):
        n = logic.get("id")
        begin = round((spot[n][0] - spot[n][1]) / 11) % 80
        plans.append(f'<tlLogic id="{n}" type="static" programID="rush" offset="{begin}">' + "".join(f'<phase duration="{p.get("duration")}" state="{p.get("state")}"/>' for p in logic.iter("phase")) + "</tlLogic>")
    document(work / "rush.add.xml", "additional", plans)
    stop = lambda at, pos, seconds: f'<stop lane="{at}" endPos="{pos}" duration="{seconds}"/>'
    buses = (("w2a2", "e2x2", 34, (("b2m_1", 45), ("d2e2_1", 60))), ("x2e2", "a2w2", 38, (("c2m_1", 45), ("b2a2_1", 70))), ("cnc3", "c0cs", 43, (("c3c2_1", 55), ("c1c0_1", 60))), ("csc0", "c3cn", 47, (("c1c2_1", 60),)), ("bnb3", "b0bs", 61, (("b2b1_1", 55),)), ("w1a1", "e1x1", 57, (("c1d1_1", 80),)))
    vans = (("w1a1", "e1x1", "b1c1_1", 60, 77), ("dsd0", "d3dn", "d2d3_1", 45, 71), ("bnb3", "b0bs", "b3b2_1", 50, 83), ("x3e3", "a3w3", "d3c3_1", 70, 79), ("ana3", "a0as", "a2a1_1", 40, 97))
    ride = (("w2a2", "e2x2", 17), ("x2e2", "a2w2", 19), ("dsd0", "d3dn", 15), ("w1a1", "d3dn", 29), ("cnc3", "c0cs", 31), ("ese0", "e3en", 41), ("w0a0", "e0x0", 37))
    cars = (("w1a1", "e1x1", 12), ("w1a1", "d3dn", 27), ("w1a1", "b0bs", 31), ("bnb3", "b0bs", 11), ("bnb3", "e1x1", 29), ("dsd0", "d3dn", 13), ("x3e3", "a3w3", 15), ("x3e3", "b0bs", 31), ("w2a2", "e2x2", 17), ("x2e2", "a2w2", 17), ("cnc3", "c0cs", 23), ("csc0", "c3cn", 23), ("csc0", "a2w2", 43), ("cnc3", "e2x2", 47), ("dsd0", "a2w2", 41), ("ana3", "e1x1", 53), ("ese0", "a3w3", 49))
    feet = (("b2m", "mb2", 21), ("mc2", "c2m", 9), ("c1c2", "c2c3", 10), ("d1d2", "d2e2", 11), ("b1c1", "c1d1", 12), ("c2c1", "b1c1", 13), ("d2d3", "d3c3", 15), ("c0f", "fc0", 9), ("fc0", "c0f", 8), ("e1v", "ve1", 9), ("ve1", "e1v", 8), ("a0b0", "b0c0", 16), ("d0e0", "e0e1", 17), ("a1b1", "a1a2", 15), ("e3e2", "d3c3", 19), ("c3b3", "b3b2", 14))
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="rush{i}" type="{"quick" if i % 5 == 3 else "car"}" begin="0" period="{p}" number="{int(270 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (a, b, p) in enumerate(cars)),
        *(f'<flow id="line{i}" type="coach" begin="0" period="{p}" number="{int(240 / p)}" from="{a}" to="{b}">{"".join(stop(*at, draw.randint(9, 16)) for at in stops)}</flow>' for i, (a, b, p, stops) in enumerate(buses)),
        *(f'<flow id="post{i}" type="van" begin="0" period="{p}" number="3" from="{a}" to="{b}">{stop(at, pos, draw.randint(18, 35))}</flow>' for i, (a, b, at, pos, p) in enumerate(vans)),
        *(f'<flow id="ride{i}" type="cycle" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}"/>' for i, (a, b, p) in enumerate(ride)),
        *(f'<personFlow id="foot{i}" type="walker" begin="0" end="280" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(feet))]))
    return options


def gridroads(work, draw):
    """Traffic on the left. Six roundabouts of two lanes and one, 400 m apart, joined by roads of 80 to 97 km/h with two lanes
    in each direction or one; between them entrances by which one only turns left, a junction with lights to a
    hospital, a crossing with lights, an estate in which who comes from the right goes first, a give-way crossing.
    """
    fast, road, street = "highway.primary", "highway.secondary", "highway.residential"
    jolt = lambda most=9: draw.uniform(-most, most)
    nodes, edges = [], []
    at = {"a": (0, 0), "b": (455 + jolt(), 25), "c": (905 + jolt(), -12), "d": (14, -430), "f": (462, -405 + jolt()), "g": (915, -440)}
    arms = {"a": (4, 94, 183, 271), "b": (-4, 88, 180, 272), "c": (-3, 92, 178, 270), "d": (3, 90, 186, 268), "f": (-5, 89, 177, 275), "g": (2, 91, 182, 266)}
    ends = {}
    for n, (cx, cy) in at.items():
        lanes, r = (1, 21) if n == "d" else (2, 31 if n in "bf" else 28)
        for i, deg in enumerate(arms[n]):
            ends[f"{n}{i}"] = (cx + r * math.cos(math.radians(deg)), cy + r * math.sin(math.radians(deg)))
            nodes.append(node(f"{n}{i}", *ends[f"{n}{i}"]))
        for i in range(4):
            a, b = arms[n][i], arms[n][i - 1]
            sweep = (a - b) % 360
            edges.append(edge(f"{n}r{i}", f"{n}{i}", f"{n}{(i - 1) % 4}", lanes, 11.18 if r > 25 else 8.94, road, 10, [(cx + r * math.cos(math.radians(a - sweep * t / 8)), cy + r * math.sin(math.radians(a - sweep * t / 8))) for t in range(1, 8)]))
        edges.append(f'<roundabout nodes="{" ".join(f"{n}{i}" for i in range(4))}" edges="{" ".join(f"{n}r{i}" for i in range(4))}"/>')
    place = {"h": (235, 14), "k": (690, 2), "t": (460, -190 + jolt()), "y": (240, -424), "z": (690, -418), "q": (2, -215 + jolt()), "wa": (-460, -20), "wd": (-430, -450), "ec": (1370, -30), "eg": (1350, -455), "na": (-30, 400), "nb": (470, 430), "nc": (925, 390), "sd": (8, -830), "sf": (455, -820), "sg": (925, -850), "hosp": (720, -205), "yn": (250, -250), "ys": (228, -620), "hn": (228, 150), "kn": (700, 165), "qw": (-330, -230), "qe": (150, -222), "zs": (700, -600), "i1": (150, 160), "i2": (150, 265), "i3": (240, 262), "i4": (320, 255)}
    kinds = {"t": "traffic_light", "y": "traffic_light", "q": "priority", "qe": "priority", "hn": "left_before_right", "i1": "left_before_right", "i2": "left_before_right", "i3": "left_before_right"}
    nodes += [node(n, *p, kinds.get(n, "priority")) for n, p in place.items()]
    for a, b, lanes, limit, kind, rank, bays in (
            ("c2", "b0", 2, 26.82, fast, 9, (0, 0)), ("b3", "t", 2, 22.35, fast, 9, (60, 0)), ("t", "f1", 2, 22.35, fast, 9, (0, 55)), ("d0", "y", 1, 22.35, road, 8, (60, 0)), ("y", "f2", 1, 22.35, road, 8, (0, 60)), ("z", "g2", 2, 22.35, road, 8, (0, 0)), ("f0", "z", 2, 22.35, road, 8, (50, 0)),
            ("a3", "q", 1, 22.35, road, 8, (45, 0)), ("q", "d1", 1, 22.35, road, 8, (0, 45)), ("c3", "g1", 1, 26.82, road, 8, (0, 0)), ("wa", "a2", 2, 26.82, fast, 9, (0, 0)), ("wd", "d2", 1, 22.35, road, 8, (0, 0)), ("c0", "ec", 2, 26.82, fast, 9, (0, 0)), ("g0", "eg", 2, 22.35, road, 8, (0, 0)),
            ("na", "a1", 1, 22.35, road, 8, (0, 0)), ("nb", "b1", 2, 22.35, fast, 9, (0, 0)), ("nc", "c1", 1, 17.88, road, 8, (0, 0)), ("sd", "d3", 1, 17.88, road, 8, (0, 0)), ("sf", "f3", 2, 22.35, fast, 9, (0, 0)), ("sg", "g3", 1, 22.35, road, 8, (0, 0)),
            ("hosp", "t", 1, 13.41, road, 7, (45, 0)), ("yn", "y", 1, 13.41, street, 6, (40, 0)), ("ys", "y", 1, 13.41, street, 6, (40, 0)), ("yn", "qe", 1, 13.41, street, 5, (0, 0)), ("qe", "q", 1, 13.41, street, 5, (0, 0)), ("qw", "q", 1, 13.41, street, 5, (0, 0)), ("zs", "z", 1, 13.41, street, 5, (0, 0)),
            ("hn", "i1", 1, 8.94, street, 3, (0, 0)), ("i1", "i2", 1, 8.94, street, 3, (0, 0)), ("i2", "i3", 1, 8.94, street, 3, (0, 0)), ("hn", "i3", 1, 8.94, street, 3, (0, 0)), ("i3", "i4", 1, 8.94, street, 3, (0, 0))):
        two_way(edges, a, b, lanes, limit, kind, rank, bays=bays)
    # Carriageways that side streets join from their left only.
    edges += [edge("a0h", "a0", "h", 2, 26.82, fast, 9), edge("hb2", "h", "b2", 2, 26.82, fast, 9), edge("b2a0", "b2", "a0", 2, 26.82, fast, 9)]
    edges.append(edge("b0k", "b0", "k", 2, 26.82, fast, 9))
    edges[:] = [r for r in edges if not r.startswith('<edge id="b0c2"')]
    edges.append(edge("kc2", "k", "c2", 2, 26.82, fast, 9))
    two_way(edges, "hn", "h", 1, 8.94, street, 3)
    two_way(edges, "kn", "k", 1, 13.41, street, 3)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    flows = (("car", "waa2", "c0ec", 10), ("car", "ecc0", "a2wa", 10), ("car", "nbb1", "f3sf", 11), ("car", "sff3", "b1nb", 12), ("car", "naa1", "d3sd", 21), ("car", "sdd3", "a1na", 23), ("car", "wdd2", "g0eg", 15), ("car", "egg0", "d2wd", 16), ("car", "ncc1", "g3sg", 25), ("car", "sgg3", "c1nc", 27),
             ("car", "hospt", "b1nb", 31), ("car", "hospt", "f3sf", 33), ("car", "nbb1", "thosp", 25), ("car", "sff3", "thosp", 29), ("car", "ysy", "yyn", 33), ("car", "ysy", "yd0", 35), ("car", "qwq", "qqe", 41), ("car", "i4i3", "b1nb", 37), ("car", "waa2", "i3i4", 33), ("car", "knk", "c0ec", 39), ("quick", "ecc0", "f3sf", 23), ("quick", "waa2", "f3sf", 25),
             ("truck", "waa2", "c0ec", 37), ("truck", "ecc0", "a2wa", 41), ("truck", "nbb1", "f3sf", 47), ("van", "egg0", "a2wa", 31), ("truck", "wdd2", "g0eg", 53), ("car", "zsz", "g0eg", 45), ("coach", "nbb1", "thosp", 67))
    (work / "parked.txt").write_text("\n".join(f'<flow id="run{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="{"max" if i < 8 else "desired"}"/>' for i, (kind, a, b, p) in enumerate(flows)))
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 3, "--tls.left-green.time", 8]


def township(work, draw):
    """Roads of one lane in each direction and 89 km/h, along the sides of squares, with stop signs for two or for all, two
    openings set off by 75 m, a road that comes in aslant; farm vehicles that are overtaken in the oncoming lane; in the
    middle a small town of 40 km/h with stop signs, one light and a street without signs. A school bus halts in its
    lane. Few people.
    """
    high, section, town, back = "highway.primary", "highway.secondary", "highway.tertiary", "highway.residential"
    jolt = lambda most=12: draw.uniform(-most, most)
    nodes, edges = [], []
    place = {"w": (-1750, 20), "k1": (-905 + jolt(), 12), "k3": (-830 + jolt(), 10), "c1": (-345, 4), "c2": (-190, 0), "c3": (-52, -2), "d": (330 + jolt(), -10), "k2": (790, -24), "e": (1650, -5),
             "n1": (-910, 690), "n2": (-182, 700), "n3": (800, 680), "s1": (-826, -700), "s2": (-176, -690), "s3": (806, -705), "m1": (-188, 150), "m2": (-186, -146), "p1": (-343, 152), "p2": (-340, -150), "p3": (-48, 148), "p4": (-46, -144), "r1": (-500, 155), "r3": (110, 150), "r4": (100, -140),
             "nn": (-180, 1150), "nw": (-1420, 700), "ne": (1300, 690), "sw": (-1380, -690), "se": (1350, -700), "ss": (-170, -1150), "nk": (-912, 1080), "ks": (-820, -1080), "n3n": (806, 1080), "s3s": (812, -1080), "x": (-640, 330)}
    kinds = {"k1": "priority_stop", "k3": "priority_stop", "k2": "priority_stop", "c2": "traffic_light", "c1": "priority_stop", "c3": "priority_stop", "d": "priority", "n1": "priority_stop", "n2": "allway_stop", "n3": "priority_stop", "s1": "allway_stop", "s2": "priority_stop", "s3": "allway_stop", "m1": "allway_stop", "m2": "allway_stop",
             "p1": "right_before_left", "p3": "priority_stop", "p2": "right_before_left", "p4": "allway_stop"}
    nodes += [node(n, *p, kinds.get(n, "priority")) for n, p in place.items()]
    rural, slow = 24.59, 11.18
    span = lambda a, b, bend=0: [(place[a][0] + (place[b][0] - place[a][0]) * t - (place[b][1] - place[a][1]) * bend * math.sin(math.pi * t), place[a][1] + (place[b][1] - place[a][1]) * t + (place[b][0] - place[a][0]) * bend * math.sin(math.pi * t)) for t in (n / 8 for n in range(1, 8))]
    for a, b, limit, kind, rank, bays, bend in (
            ("w", "k1", rural, high, 9, (0, 0), 0.012), ("k1", "k3", rural, high, 9, (0, 0), 0), ("k3", "c1", rural, high, 9, (0, 0), 0.01), ("c1", "c2", 13.41, high, 9, (45, 0), 0), ("c2", "c3", 13.41, high, 9, (0, 45), 0), ("c3", "d", rural, high, 9, (0, 0), -0.01), ("d", "k2", rural, high, 9, (50, 0), 0.015), ("k2", "e", rural, high, 9, (0, 50), 0.01),
            ("nw", "n1", 20.12, section, 7, (0, 0), 0), ("n1", "n2", rural, section, 7, (0, 0), 0.03), ("n2", "n3", rural, section, 7, (0, 0), 0), ("n3", "ne", rural, section, 7, (0, 0), 0), ("sw", "s1", rural, section, 7, (0, 0), 0), ("s1", "s2", rural, section, 7, (0, 0), 0), ("s2", "s3", rural, section, 7, (0, 0), -0.02), ("s3", "se", 20.12, section, 7, (0, 0), 0),
            ("nk", "n1", rural, section, 5, (0, 0), 0), ("n1", "k1", rural, section, 5, (0, 0), 0), ("k3", "s1", rural, section, 6, (0, 0), 0), ("s1", "ks", rural, section, 6, (0, 0), 0), ("n3n", "n3", rural, section, 5, (0, 0), 0), ("n3", "k2", rural, section, 5, (0, 0), 0.02), ("k2", "s3", rural, section, 5, (0, 0), 0), ("s3", "s3s", rural, section, 5, (0, 0), 0),
            ("nn", "n2", rural, section, 6, (0, 0), 0), ("n2", "m1", 20.12, section, 6, (0, 0), 0), ("m1", "c2", slow, town, 7, (40, 0), 0), ("c2", "m2", slow, town, 7, (0, 40), 0), ("m2", "s2", 20.12, section, 5, (0, 0), 0), ("s2", "ss", rural, section, 5, (0, 0), 0),
            ("p1", "c1", slow, back, 3, (0, 0), 0), ("c1", "p2", slow, back, 3, (0, 0), 0), ("p3", "c3", slow, back, 3, (0, 0), 0), ("c3", "p4", slow, back, 3, (0, 0), 0), ("r1", "p1", slow, back, 3, (0, 0), 0), ("p1", "m1", slow, back, 3, (0, 0), 0), ("m1", "p3", slow, town, 4, (0, 0), 0), ("p3", "r3", slow, town, 4, (0, 0), 0), ("p2", "m2", slow, back, 3, (0, 0), 0), ("m2", "p4", slow, back, 3, (0, 0), 0), ("p4", "r4", slow, back, 3, (0, 0), 0), ("r1", "x", 13.41, back, 3, (0, 0), 0)):
        two_way(edges, a, b, 1, limit, kind, rank, shape=span(a, b, bend) if bend else (), bays=bays)
    # Aslant.
    two_way(edges, "s2", "d", 1, 20.12, section, 4, shape=smooth([place["s2"], place["s2"], (-20, -420), (170, -170), place["d"], place["d"]], 5)[1:-1])
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    rows = (("car", "wk1", "k2e", 15), ("car", "ek2", "k1w", 16), ("van", "wk1", "k2e", 49), ("van", "ek2", "k1w", 47), ("truck", "wk1", "k2e", 67), ("truck", "ek2", "k1w", 71), ("car", "nnn2", "s2ss", 25), ("car", "sss2", "n2nn", 27), ("car", "wk1", "m1n2", 33), ("car", "ek2", "m2s2", 35), ("car", "nkn1", "s1ks", 35), ("car", "kss1", "n1nk", 37), ("car", "n3nn3", "s3s3s", 37), ("car", "s3ss3", "n3n3n", 39), ("car", "nwn1", "n3ne", 31), ("car", "nen3", "n1nw", 33), ("car", "sws1", "s3se", 31), ("car", "ses3", "s1sw", 35),
            ("car", "r1p1", "p3r3", 33), ("car", "r3p3", "p1r1", 37), ("car", "r4p4", "c2c1", 41), ("quick", "xr1", "c3d", 43), ("car", "sss2", "dk2", 41), ("car", "ek2", "ds2", 43), ("quick", "wk1", "k2e", 31), ("quick", "ek2", "k1w", 35), ("truck", "sws1", "n2nn", 79))
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="farm{i}" type="van" begin="0" period="{p}" number="4" from="{a}" to="{z}" speedFactor="{f}"/>' for i, (a, z, p, f) in enumerate((("wk1", "k2e", 55, 0.36), ("ek2", "k1w", 58, 0.4), ("nwn1", "n3ne", 62, 0.38), ("sws1", "s3se", 66, 0.42)))),
        *(f'<flow id="way{i}" type="{kind}" begin="0" period="{p}" number="{int(270 / p)}" from="{a}" to="{b}" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate(rows)),
        *(f'<flow id="school{i}" type="coach" begin="0" period="{67 + 5 * i}" number="4" from="{a}" to="{b}"><stop lane="{at}" endPos="{pos}" duration="{draw.randint(14, 22)}"/></flow>' for i, (a, b, at, pos) in enumerate((("wk1", "m2s2", "k3c1_0", 200), ("n2m1", "p4r4", "m1p3_1", 60), ("ek2", "m1n2", "dc3_0", 150)))),
        *(f'<personFlow id="foot{i}" type="walker" begin="0" end="280" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate((("p1m1", "m1p3", 17), ("m1c2", "c2m2", 19), ("p2m2", "m2p4", 21), ("p3r3", "p3c3", 27))))]))
    return ["--opposites.guess", "--no-turnarounds.except-deadend", "--junctions.corner-detail", 5, "--tls.yellow.time", 4, "--tls.default-type", "actuated", "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.5, "--crossings.guess", "--crossings.guess.speed-threshold", 14]
