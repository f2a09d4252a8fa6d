"""Road networks of the eighth held group, on which lanes are bound to where they lead: a turbo roundabout with a school
street, a motorway junction with a collector road on each side, a country road whose third lane changes sides, a dense
town of one-way pairs whose arms have green one by one.
"""

import math
import re
import xml.etree.ElementTree as ET

from networks import document, edge, link, node, ring, tool, two_way


def turbo(work, draw):
    """A roundabout of two lanes that spiral outwards: on the arms east and west a lane begins inside, and the outer one only
    leaves. East of it a school street with crossings of its own, west a crossroads with lights.
    """
    nodes, edges, links = [], [], []
    ring(edges, nodes, "t", 0, 0, 27, 2, [0, 90, 180, 270], 9.5)
    for i, (arm, wide) in enumerate((("s0", 2), ("n", 1), ("l", 2), ("z", 1))):
        # Two lanes in everywhere, one out to north and south.
        two_way(edges, arm, f"t{i}", 2, 13.89, "highway.secondary", 6, back=wide)
        into, before, after, out = f"{arm}t{i}", f"tr{(i - 1) % 4}", f"tr{i}", f"t{i}{arm}"
        links += [link(into, after, 0, 0), link(into, after, 1, 1), link(before, out, 0, 0)]
        links += [link(before, out, 1, 1), link(before, after, 1, 0)] if wide == 2 else [link(before, after, 0, 0), link(before, after, 1, 1)]
    street = {"s0": (105, 4, "priority"), "s1": (175, 9, "priority"), "s2": (245, 10, "priority"), "s3": (330, 2, "allway_stop"), "s4": (395, -6, "priority"), "s5": (520, -10, "priority"), "s6": (660, -2, "priority")}
    nodes += [node(n, x + draw.uniform(-6, 6), y, kind) for n, (x, y, kind) in street.items()]
    places = {"l": (-165, -8), "lw": (-340, -20), "ln": (-150, 160), "ls": (-185, -165), "n": (14, 165), "nn": (40, 330), "ne": (150, 190), "z": (-6, -150), "zz": (-30, -310), "k": (320, -140), "sn": (190, 140), "kn": (345, 150)}
    kinds = {"l": "traffic_light", "n": "priority_stop", "z": "priority", "k": "right_before_left", "ne": "right_before_left"}
    nodes += [node(n, x, y, kinds.get(n, "priority")) for n, (x, y) in places.items()]
    for a, b in zip(list(street), list(street)[1:]):
        two_way(edges, a, b, 1, 8.33 if a != "s4" else 13.89, "highway.tertiary", 6)
    for a, b, lanes, bay in (("lw", "l", 2, 35), ("ln", "l", 1, 30), ("ls", "l", 1, 30)):
        two_way(edges, a, b, lanes, 13.89, "highway.secondary", 6, bays=(bay, 0))
    for a, b, limit, shape in (("nn", "n", 13.89, []), ("n", "ne", 8.33, []), ("sn", "s1", 8.33, []), ("ne", "sn", 8.33, [(178, 172)]), ("zz", "z", 13.89, []),
                               ("z", "k", 11.11, [(90, -170), (210, -165)]), ("k", "s3", 8.33, []), ("kn", "s3", 8.33, []), ("k", "s5", 11.11, [(430, -125), (500, -70)])):
        two_way(edges, a, b, 1, limit, "highway.residential" if limit < 13 else "highway.secondary", 5 if limit > 13 else 4, shape=shape)
    zebras = [f'<crossing node="{b}" edges="{a}{b} {b}{a}" priority="true" width="4"/>' for a, b in (("s1", "s2"), ("s3", "s4"))]
    zebras.append('<crossing node="s0" edges="s0s1 s1s0" priority="true" width="4"/>')
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links + zebras)
    return ["--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.left-green.time", 8, "--sidewalks.guess", "--crossings.guess"]


def distributors(work, draw):
    """Both carriageways of a motorway, each with a road beside it that takes the ramps of a crossing road: lanes that end on
    the right and on the left, one that may go either way, one that becomes the exit, a plain exit, a lane that begins.
    """
    s, main, ramp = 33.33, "motorway", "motorway_link"
    nodes, edges, links = [], [], []
    bow = lambda x: 30 * math.sin(x / 520)

    def carriageway(tag, stations, counts, off):
        xs = [x + (draw.uniform(-25, 25) if 0 < i < len(stations) - 1 else 0) for i, x in enumerate(stations)]
        nodes.extend(node(f"{tag}{i}", x, bow(x) + off) for i, x in enumerate(xs))
        for i, (count, a, b) in enumerate(zip(counts, xs, xs[1:])):
            shape = [(a + (b - a) * t, bow(a + (b - a) * t) + off) for t in (0.2, 0.4, 0.6, 0.8)]
            edges.append(edge(f"{tag.upper()}{i}", f"{tag}{i}", f"{tag}{i + 1}", count, s, main, 13, shape))
        return [(f"{tag}{i}", x, bow(x) + off) for i, x in enumerate(xs)]

    def beside(tag, places, counts, off, ends, through):
        """The road beside: from and to the carriageway's nodes `ends` (name, x, y), by `places` (along, meters apart). It begins and
        ends outside of so many lanes of the carriageway as `through` says.
        """
        names = [f"{tag}{i}" for i in range(len(places))]
        at = [(x, bow(x) + off + apart) for x, apart in places]
        nodes.extend(node(n, *xy) for n, xy in zip(names, at))
        way = 1 if ends[1][1] > ends[0][1] else -1
        whole = [(ends[0][1] + 15 * way, ends[0][2] - 3.2 * through[0] * way), *at, (ends[1][1] - 15 * way, ends[1][2] - 3.2 * through[1] * way)]
        for i, (count, a, b) in enumerate(zip(counts, [ends[0][0], *names], [*names, ends[1][0]])):
            (xa, ya), (xb, yb) = whole[i], whole[i + 1]
            shape = [(xa + (xb - xa) * t, ya + (yb - ya) * (1 - math.cos(math.pi * t)) / 2) for t in (0, 0.2, 0.4, 0.6, 0.8, 1)[i > 0:6 - (i + 1 < len(counts))]]
            edges.append(edge(f"{tag.upper()}{i}", a, b, count, 22.22, ramp, 9, shape))

    def joined(a, b, *pairs):
        links.extend(link(a, b, i, j) for i, j in pairs)

    up, straight = lambda n, m: [(i, i + m) for i in range(n)], lambda n: [(i, i) for i in range(n)]
    # Eastwards.
    east = carriageway("e", (-1400, -1050, -780, -500, 640, 960, 1350), (4, 3, 4, 3, 4, 3), -8)
    joined("E0", "E1", (1, 0), (2, 1), (3, 2))
    joined("E1", "E2", *up(3, 1))
    joined("E2", "E3", (1, 0), (2, 1), (3, 2))
    joined("E3", "E4", *up(3, 1))
    joined("E4", "E5", *straight(3))
    beside("f", ((-340, -46), (190, -46), (420, -44)), (2, 1, 2, 1), -8, (east[3], east[4]), (2, 3))
    joined("E2", "F0", (0, 0), (1, 1))
    joined("F0", "F1", (1, 0))
    joined("F1", "F2", (0, 1))
    joined("F2", "F3", (1, 0))
    joined("F3", "E4", (0, 0))
    # Westwards.
    west = carriageway("w", (1350, 1010, 720, 450, 300, -560, -830, -1080, -1400), (3, 3, 4, 3, 2, 3, 2, 3), 8)
    joined("W0", "W1", *straight(3))
    joined("W1", "W2", *up(3, 1))
    joined("W2", "W3", (1, 0), (2, 1), (3, 2))
    joined("W3", "W4", (1, 0), (2, 1))
    joined("W4", "W5", *up(2, 1))
    joined("W5", "W6", (1, 0), (2, 1))
    joined("W6", "W7", (0, 0), (1, 1), (1, 2))
    beside("g", ((140, 44), (-130, 46), (-400, 40)), (1, 1, 2, 1), 8, (west[4], west[5]), (2, 2))
    joined("W3", "G0", (0, 0))
    joined("G0", "G1", (0, 0))
    joined("G1", "G2", (0, 1))
    joined("G2", "G3", (1, 0))
    joined("G3", "W5", (0, 0))
    # The road across, on a bridge, and the ramps; two more exits and an entry.
    nodes += [node("a", 12, -430), node("s", 0, -165, "traffic_light"), node("n", 0, 170, "traffic_light"), node("b", -14, 430), node("x", 590, -190), node("y", 880, 205), node("v", 850, 195), node("vv", 870, 330), node("i", -1010, -200), node("ii", -1130, -310)]
    two_way(edges, "a", "s", 1, 16.67, "secondary", 7)
    two_way(edges, "s", "n", 1, 16.67, "secondary", 7, shape=[(0, -110, 3), (0, -60, 7), (0, 60, 7), (0, 110, 3)], bays=(70, 70))
    two_way(edges, "n", "b", 1, 16.67, "secondary", 7)
    edges += [edge("iii", "ii", "i", 2, 19.44, ramp, 6), edge("vvv", "vv", "v", 2, 19.44, ramp, 6)]
    for name, a, b, limit, shape in (("fs", "f0", "s", 16.67, [(-250, -86), (-140, -135), (-50, -162)]), ("sf", "s", "f1", 19.44, [(50, -158), (100, -118), (125, -75), (150, -54)]),
                                     ("fx", "f2", "x", 16.67, [(480, -58), (540, -110)]), ("gn", "g0", "n", 16.67, [(110, 72), (85, 130), (40, 166)]),
                                     ("ng", "n", "g1", 19.44, [(-35, 160), (-62, 115), (-74, 75), (-92, 56)]), ("wy", "w1", "y", 16.67, [(west[1][1] - 15, west[1][2] + 9.6), (950, 68), (905, 125)]), ("ie", "i", "e2", 19.44, [(-960, -150), (-890, -92), (-830, -58), (east[2][1] - 15, east[2][2] - 9.6)]), ("vw", "v", "w2", 19.44, [(840, 130), (815, 84), (790, 62), (762, 53), (west[2][1] + 15, west[2][2] + 9.6)])):
        edges.append(edge(name, a, b, 1, limit, ramp, 6, shape, 60 if b in "sn" else 0))
    for a, b, i, j in (("F0", "fs", 0, 0), ("sf", "F2", 0, 0), ("F2", "fx", 0, 0), ("G0", "gn", 0, 0), ("ng", "G2", 0, 0), ("W0", "wy", 0, 0), ("vw", "W2", 0, 0), ("ie", "E2", 0, 0)):
        links.append(link(a, b, i, j))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return ["--no-turnarounds", "--tls.cycle.time", 64]


def third_lane(work, draw):
    """Traffic on the left: a country road with a lane for overtaking, first one way, then the other; side roads that meet it
    staggered or aslant, bays for who turns across, a bay for buses.
    """
    nodes, edges, links = [], [], []
    y = lambda x: 46 * math.sin(x / 240) + 12 * math.cos(x / 83)
    stations = {"w": -1000, "m": -730, "a": -560 + draw.uniform(-20, 20), "b": -505, "p": -430, "q": -150, "c": 10, "u": 90, "v": 165, "r": 260, "t": 540, "d": 630, "f": 680, "g": 820, "e": 1090}
    nodes += [node(n, x, y(x)) for n, x in stations.items()]
    names = list(stations)
    for a, b in zip(names, names[1:]):
        xa, xb = stations[a], stations[b]
        shape = [(x, y(x)) for x in (xa + (xb - xa) * t / 6 for t in range(1, 6))] if xb - xa > 100 else []
        ahead, back = 1 + (a + b in ("wm", "pq")), 1 + (a + b in ("rt", "ge"))
        bays = {"ab": (30, 30), "qc": (60, 0), "cu": (0, 45), "td": (70, 0), "fg": (0, 60)}.get(a + b, (0, 0))
        two_way(edges, a, b, ahead, 25.0 if xb - xa > 150 else 19.44, "highway.primary", 9, back=back, shape=shape, bays=bays)
    # The third lane begins in the middle and ends there.
    for before, there, after in (("bp", "pq", "qc"), ("dt", "tr", "rv")):
        links += [link(before, there, 0, 0), link(before, there, 0, 1), link(there, after, 0, 0)]
    links += [link("wm", "ma", 0, 0), link("eg", "gf", 0, 0)]
    # Buses stop in a bay on the left, which they leave when there is room.
    edges = [e for e in edges if not e.startswith('<edge id="uv"')]
    edges.append(edge("uv", "u", "v", 2, 19.44, "highway.primary", 9).replace("></edge>", '><lane index="0" allow="bus"/></edge>'))
    links += [link("cu", "uv", 0, 0), link("cu", "uv", 0, 1), link("uv", "vr", 0, 0), link("uv", "vr", 1, 0)]
    for end, at, along, limit in (("an", "a", 55, 13.89), ("bs", "b", -110, 16.67), ("cn", "c", 150, 16.67), ("cs", "c", -150, 13.89), ("ds", "d", -70, 13.89), ("fn", "f", -95, 16.67)):
        sign = 1 if end[1] == "n" else -1
        nodes.append(node(end, stations[at] + along, y(stations[at]) + sign * (110 if end == "fn" else 150)))
        two_way(edges, end, at, 1, limit, "highway.tertiary", 4, bays=(25 if end in ("an", "bs", "cn", "cs") else 0, 0))
    # A lane behind joins two of them.
    nodes += [node("h", 260, y(10) + 175, "priority"), node("hn", 330, y(10) + 330)]
    two_way(edges, "cn", "h", 1, 13.89, "highway.tertiary", 4, shape=[(205, y(10) + 170)])
    two_way(edges, "h", "fn", 1, 13.89, "highway.tertiary", 4, shape=[(400, y(10) + 165), (490, y(10) + 152), (550, y(10) + 134)])
    two_way(edges, "hn", "h", 1, 13.89, "highway.tertiary", 3)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    # A bus every 34 s, which stops in the bay; heavy vehicles at half of the limit.
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="0" period="34" number="6" from="wm" to="ge"><stop lane="uv_0" startPos="25" endPos="50" duration="11"/></flow>',
        '<flow id="heavy" type="truck" begin="0" period="58" number="4" from="wm" to="ge" speedFactor="0.5"/>', '<flow id="load" type="truck" begin="0" period="47" number="5" from="eg" to="mw" speedFactor="0.55"/>']))
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5]


def pairs(work, draw):
    """Short blocks: two avenues and two streets that are pairs of one way each, between two-way ones; a diagonal; at every
    light one arm after the other has green and then the people, so that nobody who turns has to give way.
    """
    xs, ys = [0.0], [0.0]
    for _ in range(4):
        xs.append(xs[-1] + draw.uniform(66, 92))
    for _ in range(3):
        ys.append(ys[-1] + draw.uniform(60, 84))
    # Lanes one way and the other.
    avenues, streets = [(2, 1), (3, 0), (0, 3), (1, 1), (1, 1)], [(1, 1), (2, 0), (0, 2), (2, 2)]
    name = lambda i, j: f"n{i}{j}"
    nodes, edges = [], []
    for i, x in enumerate(xs):
        for j, y in enumerate(ys):
            lit = sum(avenues[i]) + sum(streets[j]) > 5 or sum(avenues[i]) + sum(streets[j]) == 5 and ((i, j) in ((0, 1), (1, 2)) or draw.random() < 0.4)
            nodes.append(node(name(i, j), x - 0.1 * y, y + 0.06 * x, "traffic_light" if lit else draw.choice(("priority", "allway_stop", "priority_stop"))))

    def along(places, lanes, limit, rank):
        for a, b in zip(places, places[1:]):
            for n, (start, end) in zip(lanes, ((a, b), (b, a))):
                if n:
                    edges.append(edge(start + end, start, end, n, limit, "highway.primary" if rank > 7 else "highway.tertiary", rank))

    for i, x in enumerate(xs):
        low, high = (f"s{i}", -140), (f"t{i}", ys[-1] + 140)
        nodes += [node(n, x - 0.1 * y, y + 0.06 * x) for n, y in (low, high)]
        along([low[0], *(name(i, j) for j in range(len(ys))), high[0]], avenues[i], 13.89 if sum(avenues[i]) > 2 else 9.72, 5 + sum(avenues[i]))
    for j, y in enumerate(ys):
        low, high = (f"u{j}", -140), (f"v{j}", xs[-1] + 140)
        nodes += [node(n, x - 0.1 * y, y + 0.06 * x) for n, x in (low, high)]
        along([low[0], *(name(i, j) for i in range(len(xs))), high[0]], streets[j], 11.11, 4 + sum(streets[j]))
    two_way(edges, name(0, 1), name(1, 2), 1, 11.11, "highway.tertiary", 5)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    options = ["--no-turnarounds", "--junctions.corner-detail", 5, "--tls.layout", "incoming", "--tls.yellow.time", 3, "--sidewalks.guess", "--crossings.guess"]
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml", "--output-file", work / "first.xml", *options)
    document(work / "scramble.add.xml", "additional", scrambles(ET.parse(work / "first.xml").getroot()))
    return options


def scrambles(net):
    """Programs in which the arms have green for 9 s each, then the people on all crossings at once."""
    walks, rows = {}, []
    for c in net.iter("connection"):
        if c.get("tl") and re.match(r":.*_w\d+$", c.get("from")):
            walks.setdefault(c.get("tl"), set()).add(int(c.get("linkIndex")))
    for logic in net.iter("tlLogic"):
        on_foot = walks.get(logic.get("id"), set())
        states = ["".join("r" if i in on_foot else letter for i, letter in enumerate(p.get("state"))) for p in logic.iter("phase")]
        arms = sorted({tuple(i for i, letter in enumerate(state) if letter in "Gg") for state in states} - {()})
        size = len(states[0])
        show = lambda letter, of: "".join(letter if i in of else "r" for i in range(size))
        phases = [phase for arm in arms for phase in ((9, show("G", arm)), (3, show("y", arm)), (1, "r" * size))] + ([(8, show("G", on_foot)), (6, "r" * size)] if on_foot else [])
        rows.append(f'<tlLogic id="{logic.get("id")}" type="static" programID="scramble" offset="0">' + "".join(f'<phase duration="{d}" state="{state}"/>' for d, state in phases) + "</tlLogic>")
    return rows
