"""Road networks of the ninth held group, of the kinds that test drives and other people's scenarios have: a city artery
with bus lanes, slip roads and coordinated lights; a hilly road on which slow vehicles are overtaken in the oncoming
lane; a motorway with works and a toll plaza; a quarter where who comes from the right goes first.
"""

import math
import xml.etree.ElementTree as ET

from networks import document, edge, link, node, ring, tool, two_way


def artery(work, draw):
    """Three lanes in each direction, the right one for buses until 95 m before a light; bays for left turns, two slip
    roads for right turns, one of which gives way; lights that are actuated within a common cycle, yellow for 5 s.
    """
    limit, main = 15.28, "highway.primary"
    y = lambda x: 24 * math.sin(x / 270)
    xs = [0.0]
    for gap in (255, 225, 330, 245):
        xs.append(xs[-1] + gap + draw.uniform(-15, 15))
    cross = xs[2] + 150
    nodes = [node("w", -190, y(-190)), node("e", xs[-1] + 190, y(xs[-1] + 190)), node("t", cross, y(cross)), node("tn", cross + 20, y(cross) + 150)]
    nodes += [node(f"a{i}", x, y(x), "traffic_light") for i, x in enumerate(xs)]
    edges, links = [], []
    for a, b, at in (("w", "a0", xs[0] - 85), ("e", "a4", xs[-1] + 85)):
        nodes.append(node(f"{a}p", at, y(at)))
        edges += [edge(a, a, f"{a}p", 3, limit, main, 9), edge(f"{a}{b}", f"{a}p", b, 3, limit, main, 9, bay=60), edge(f"{b}{a}", b, a, 3, limit, main, 9)]
    # From light to light: a lane for buses, then all lanes for all; a slip road leaves 45 m before the light.
    for i, k, slip in ((0, 1, True), (1, 2, False), (3, 4, False), (4, 3, True), (2, 1, False), (1, 0, False)):
        sign = 1 if k > i else -1
        a, b, far, near = f"a{i}", f"a{k}", xs[k] - sign * 95, xs[k] - sign * 45
        nodes.append(node(f"{a}m{b}", far, y(far)))
        bend = [(x, y(x)) for x in (xs[i] + (far - xs[i]) * t for t in (0.33, 0.67))]
        edges.append(edge(f"{a}{b}", a, f"{a}m{b}", 3, limit, main, 9, bend).replace("></edge>", '><lane index="0" allow="bus"/></edge>'))
        if not slip:
            edges.append(edge(f"{a}{b}o", f"{a}m{b}", b, 3, limit, main, 9, bay=60))
            continue
        nodes.append(node(f"{a}q{b}", near, y(near)))
        edges.append(edge(f"{a}{b}o", f"{a}m{b}", f"{a}q{b}", 3, limit, main, 9))
        edges.append(edge(f"{a}{b}l", f"{a}q{b}", b, 3, limit, main, 9))
        side, yc = -sign * 48, y(xs[k]) - sign * 48
        nodes.append(node(f"{b}n", xs[k] - sign * 4, yc))
        edges.append(edge(f"{a}{b}s", f"{a}q{b}", f"{b}n", 1, 8.33, main, 3, [(near + sign * 18, y(near) - sign * 12), (near + sign * 33, y(near) - sign * 23), (xs[k] - sign * 7.5, y(xs[k]) + side * 0.78)]))
        links += [link(f"{a}{b}o", f"{a}{b}s", 0, 0), link(f"{a}{b}o", f"{a}{b}l", 1, 0), link(f"{a}{b}o", f"{a}{b}l", 2, 1), link(f"{a}{b}o", f"{a}{b}l", 2, 2), f'<delete from="{a}{b}l" to="{b}{b}n"/>']
    two_way(edges, "a2", "t", 2, limit, main, 9, bays=(0, 45))
    two_way(edges, "t", "a3", 2, limit, main, 9, bays=(50, 0))
    two_way(edges, "tn", "t", 1, 11.11, "highway.tertiary", 4)
    for i, x in enumerate(xs):
        for tag, sign in (("s", -1), ("n", 1)):
            out, lanes = f"{tag}{i}", 1 + ((i + (sign > 0)) % 2)
            (xa, ya), (xb, yb) = (x, y(x)), (x + draw.uniform(-25, 25), y(x) + sign * 190)
            nodes += [node(out, xb, yb), node(f"{out}p", xa + (xb - xa) * 0.3, ya + (yb - ya) * 0.3)]
            edges.append(edge(out, out, f"{out}p", lanes, 12.5, "highway.secondary", 6))
            edges.append(edge(f"{out}a{i}", f"{out}p", f"a{i}", lanes, 12.5, "highway.secondary", 6, bay=35 if i != 2 else 0))
            # Where a slip road joins: it gives way, or has a lane of its own from there on.
            if (tag, i) in (("s", 1), ("n", 3)):
                edges.append(edge(f"a{i}a{i}n", f"a{i}", f"a{i}n", 1, 12.5, "highway.secondary", 6))
                edges.append(edge(f"a{i}{out}", f"a{i}n", out, 1 + (i == 3), 12.5, "highway.secondary", 6))
                slip = f"a{0 if i == 1 else 4}a{i}s"
                links += [link(slip, f"a{i}{out}", 0, 0), link(f"a{i}a{i}n", f"a{i}{out}", 0, int(i == 3))]
            else:
                edges.append(edge(f"a{i}{out}", f"a{i}", out, lanes, 12.5, "highway.secondary", 6))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # One may turn round at a light, but not where the map ends.
    links += [f'<delete from="{a}{b}" to="{b}"/>' for a, b in (("a0", "w"), ("a4", "e"), *((f"a{i}", f"{tag}{i}") for i in range(5) for tag in "sn"))]
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="5" period="42" number="5" from="w" to="a4e"><stop lane="a0a1_0" startPos="60" endPos="80" duration="12"/><stop lane="a3a4_0" startPos="50" endPos="70" duration="10"/></flow>',
        '<flow id="back" type="coach" begin="20" period="50" number="4" from="e" to="a0w"><stop lane="a2a1_0" startPos="50" endPos="70" duration="14"/></flow>']))
    options = ["--no-turnarounds.geometry", "--junctions.corner-detail", 5, "--tls.default-type", "actuated", "--tls.yellow.time", 5, "--tls.left-green.time", 7, "--tls.cycle.time", 76, "--sidewalks.guess", "--crossings.guess"]
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml", "--connection-files", work / "con.xml", "--output-file", work / "first.xml", *options)
    document(work / "wave.add.xml", "additional", wave(ET.parse(work / "first.xml").getroot(), limit))
    return options


def wave(net, speed):
    """The programs of the lights, in a common cycle that begins later the further east a light is."""
    at, rows = {j.get("id"): float(j.get("x")) for j in net.iter("junction")}, []
    for logic in net.iter("tlLogic"):
        phases = "".join(f'<phase duration="{p.get("duration")}" state="{p.get("state")}"' + (f' minDur="{p.get("minDur")}" maxDur="{p.get("maxDur")}"' if p.get("minDur") else "") + "/>" for p in logic.iter("phase"))
        cycle = sum(int(float(p.get("duration"))) for p in logic.iter("phase"))
        rows.append(f'<tlLogic id="{logic.get("id")}" type="actuated" programID="wave" offset="{round(at[logic.get("id")] / speed) % cycle}"><param key="coordinated" value="true"/><param key="cycleTime" value="{cycle}"/>{phases}</tlLogic>')
    return rows


def hill_road(work, draw):
    """One lane in each direction up and down, with farm traffic that is overtaken in the oncoming lane; between the
    hills a village with a roundabout of two lanes and a light.
    """
    y = lambda x: 55 * math.sin(x / 330) + 9 * math.sin(x / 77)
    high = lambda x: 14 * (1 - math.cos(max(0, abs(x) - 400) / 170))
    raised = lambda name, x, more=0.0, kind="priority": node(name, x, y(x) + more, kind).replace("/>", f' z="{high(x):.2f}"/>')
    nodes, edges = [], []
    ring(edges, nodes, "o", -170, y(-170), 24, 2, [8, 95, 190, 280], 9.0)
    places = {"w": -1500, "p": -980 + draw.uniform(-30, 30), "k": -330, "v": 60, "u": 210, "q": 330, "g": 760 + draw.uniform(-30, 30), "e": 1420}
    kinds = {"v": "traffic_light", "u": "priority", "g": "priority_stop"}
    nodes += [raised(n, x, 0, kinds.get(n, "priority")) for n, x in places.items()]
    at = places | {"o2": -194, "o0": -146}
    for a, b, lanes, limit, bays in (("w", "p", 1, 25.0, (0, 0)), ("p", "k", 1, 25.0, (0, 0)), ("k", "o2", 2, 16.67, (0, 0)), ("o0", "v", 1, 13.89, (35, 0)), ("v", "u", 1, 13.89, (0, 30)),
                                     ("u", "q", 1, 13.89, (0, 35)), ("q", "g", 1, 25.0, (50, 0)), ("g", "e", 1, 25.0, (0, 45))):
        xa, xb = at[a], at[b]
        n = max(2, int((xb - xa) / 45))
        shape = [(x, y(x), high(x)) for x in (xa + (xb - xa) * t / n for t in range(1, n))] if xb - xa > 160 else []
        two_way(edges, a, b, lanes, limit, "highway.primary" if limit > 14 else "highway.secondary", 8, shape=shape, bays=bays)
    for end, a, x, up, lanes, limit in (("ps", "p", -930, -170, 1, 16.67), ("on", "o1", -190, 190, 2, 13.89), ("os", "o3", -140, -190, 1, 13.89), ("vn", "v", 40, 160, 1, 11.11), ("vs", "v", 90, -160, 1, 11.11),
                                        ("un", "u", 230, 140, 1, 8.33), ("us", "u", 200, -150, 1, 8.33), ("gn", "g", 800, 180, 1, 16.67), ("gs", "g", 740, -170, 1, 16.67)):
        nodes.append(raised(end, x, up))
        two_way(edges, end, a, lanes, limit, "highway.tertiary", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # Farm vehicles at a third of the limit, lorries at half.
    (work / "parked.txt").write_text("\n".join([
        '<flow id="farm" type="van" begin="0" period="46" number="5" from="wp" to="ge" speedFactor="0.33"/>', '<flow id="field" type="van" begin="12" period="52" number="4" from="eg" to="pw" speedFactor="0.36"/>',
        '<flow id="load" type="truck" begin="25" period="70" number="3" from="gng" to="pw" speedFactor="0.55"/>']))
    return ["--opposites.guess", "--no-turnarounds.except-deadend", "--roundabouts.guess", "--junctions.corner-detail", 5, "--tls.yellow.time", 3, "--sidewalks.guess", "--crossings.guess",
            "--crossings.guess.speed-threshold", 14, "--sidewalks.guess.max-speed", 14]


def works(work, draw):
    """Traffic on the left. One carriageway: an entry, an exit, works that close one lane and then a second, limits in
    steps, an entry by a lane that stays, a toll plaza of seven lanes. The other: three exits, two entries, a lane less.
    """
    s, main, ramp = 31.94, "motorway", "motorway_link"
    nodes, edges, links = [], [], []
    bow = lambda x: 40 * math.sin(x / 610)
    straight, up = lambda n: [(i, i) for i in range(n)], lambda n: [(i, i + 1) for i in range(n)]
    down = lambda n: [(i + 1, i) for i in range(n)]

    def carriageway(tag, stations, counts, speeds, off, kinds=()):
        xs = [x + (draw.uniform(-20, 20) if 0 < i < len(stations) - 1 else 0) for i, x in enumerate(stations)]
        nodes.extend(node(f"{tag}{i}", x, bow(x) + off, dict(kinds).get(i, "priority")) for i, x in enumerate(xs))
        for i, (count, limit, a, b) in enumerate(zip(counts, speeds, xs, xs[1:])):
            shape = [(a + (b - a) * t, bow(a + (b - a) * t) + off) for t in (0.25, 0.5, 0.75)]
            edges.append(edge(f"{tag.upper()}{i}", f"{tag}{i}", f"{tag}{i + 1}", count, limit, main, 13, shape))
        return xs

    def joined(a, b, *pairs):
        links.extend(link(a, b, i, j) for i, j in pairs)

    # Eastwards; lane 0 is the left one.
    east = carriageway("e", (-1700, -1330, -1060, -760, -520, -280, 60, 330, 600, 820, 930, 985, 1080, 1500), (3, 4, 3, 4, 3, 2, 1, 2, 3, 7, 7, 5, 3),
                       (s, s, s, s, 22.22, 16.67, 13.89, 25.0, 25.0, 13.89, 6.94, 13.89, s), 14, {5: "zipper", 6: "zipper", 11: "zipper", 12: "zipper"}.items())
    joined("E0", "E1", *up(3))
    joined("E1", "E2", *down(3))
    joined("E2", "E3", *up(3))
    joined("E3", "E4", *down(3))
    joined("E4", "E5", (0, 0), (1, 1), (2, 1))
    joined("E5", "E6", (0, 0), (1, 0))
    joined("E6", "E7", (0, 0), (0, 1))
    joined("E7", "E8", *up(2))
    joined("E8", "E9", (0, 0), (0, 1), (0, 2), (1, 3), (2, 4), (2, 5), (2, 6))
    joined("E9", "E10", *straight(7))
    joined("E10", "E11", (0, 0), (1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (6, 4))
    joined("E11", "E12", (0, 0), (1, 0), (2, 1), (3, 2), (4, 2))
    # Westwards.
    west = carriageway("w", (1500, 1090, 830, 620, 150, -170, -420, -700, -1000, -1700), (3, 4, 3, 3, 4, 3, 2, 3, 2), (s, s, s, s, s, s, 27.78, 27.78, s), -14)
    joined("W0", "W1", *up(3))
    joined("W1", "W2", *down(3))
    joined("W2", "W3", *straight(3))
    joined("W3", "W4", *up(3))
    joined("W4", "W5", *down(3))
    joined("W5", "W6", (0, 0), (1, 1))
    joined("W6", "W7", *up(2))
    joined("W7", "W8", *down(2))
    def beside(x, off, way, through):
        """Along the road, then away from it, outside of so many lanes."""
        side = math.copysign(1, off)
        return [(x + way * d, bow(x + way * d) + off + side * (3.2 * through + more)) for d, more in ((25, 0.4), (60, 2), (105, 6), (160, 15))]

    for name, station, far, there, lane, limit, off, way, through in (
            ("ramp1", ("e1", east[1]), (-1560, 75), "E1", 0, 19.44, 14, -1, 3), ("ramp2", ("e4", east[4]), (-290, 125), "E3", 0, 16.67, 14, 1, 3),
            ("ramp3", ("e8", east[8]), (370, 140), "E8", 0, 19.44, 14, -1, 2), ("ramp4", ("w2", west[2]), (600, -130), "W1", 0, 16.67, -14, -1, 3),
            ("ramp5", ("w3", west[3]), (410, -140), "W2", 0, 19.44, -14, -1, 2), ("ramp6", ("w4", west[4]), (370, -150), "W4", 0, 19.44, -14, 1, 3),
            ("ramp7", ("w7", west[7]), (-470, -150), "W7", 0, 19.44, -14, 1, 2), ("ramp8", ("w8", west[8]), (-1230, -150), "W7", 0, 16.67, -14, -1, 2)):
        shape, enters = beside(station[1], off, way, through), name in ("ramp1", "ramp3", "ramp6", "ramp7")
        nodes.append(node(f"{name}x", *far))
        a, b = (f"{name}x", station[0]) if enters else (station[0], f"{name}x")
        edges.append(edge(name, a, b, 1, limit, ramp, 6, shape[::-1] if enters else shape))
        links.append(link(name, there, 0, lane) if enters else link(there, name, lane, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return ["--lefthand", "--no-turnarounds"]


def quarter(work, draw):
    """Short streets where who comes from the right goes first, some junctions at which all stop, a small roundabout,
    people and riders; one through street with lights at which one may turn right on red.
    """
    xs, ys = [0.0], [0.0]
    for _ in range(4):
        xs.append(xs[-1] + draw.uniform(64, 88))
    for _ in range(3):
        ys.append(ys[-1] + draw.uniform(62, 80))
    place = lambda x, y: (x + 0.12 * y, y - 0.05 * x)
    nodes, edges = [], []
    kinds = {(1, 3): "traffic_light_right_on_red", (3, 3): "traffic_light_right_on_red", (0, 3): "priority", (2, 3): "priority", (4, 3): "priority_stop"}
    for i, x in enumerate(xs):
        for j, y in enumerate(ys):
            kind = kinds.get((i, j)) or draw.choice(("right_before_left", "right_before_left", "right_before_left", "allway_stop"))
            if (i, j) != (2, 1):
                nodes.append(node(f"n{i}{j}", *place(x, y), kind))
    ring(edges, nodes, "m", *place(xs[2], ys[1]), 12, 1, [0, 90, 180, 270], 6.0)

    def along(names, limit, kind, rank):
        for (a, b) in zip(names, names[1:]):
            two_way(edges, a, b, 1, limit, kind, rank)

    def through(line, there, into, out):
        """The names of a line of the grid, in two parts where it comes to the roundabout."""
        return [line] if there is None else [[*line[:there], into], [out, *line[there + 1:]]]

    for j, y in enumerate(ys):
        ends = [(f"u{j}", -105), (f"v{j}", xs[-1] + 105)]
        nodes += [node(n, *place(x, y)) for n, x in ends]
        line = [ends[0][0], *(f"n{i}{j}" for i in range(5)), ends[1][0]]
        if j == 3:
            for a, b in zip(line, line[1:]):
                for c, d in ((a, b), (b, a)):
                    edges.append(edge(c + d, c, d, 1, 13.89, "highway.secondary", 8))
            continue
        for part in through(line, 3 if j == 1 else None, "m2", "m0"):
            along(part, 8.33, "highway.residential", 4)
    for i, x in enumerate(xs):
        ends = [(f"s{i}", -100), (f"t{i}", ys[-1] + 100)]
        nodes += [node(n, *place(x, y)) for n, y in ends]
        for part in through([ends[0][0], *(f"n{i}{j}" for j in range(4)), ends[1][0]], 2 if i == 2 else None, "m3", "m1"):
            along(part, 8.33, "highway.residential", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    (work / "parked.txt").write_text("\n".join(f'<flow id="rider{a}" type="cycle" begin="{t}" period="{p}" number="{int(200 / p)}" from="{a}" to="{b}"/>' for a, b, t, p in (
        ("u3n03", "n43v3", 3, 17), ("v3n43", "n03u3", 9, 21), ("s1n10", "n13t1", 5, 26), ("t3n33", "n30s3", 8, 29), ("u1n01", "n41v1", 14, 33))))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--tls.yellow.time", 3, "--sidewalks.guess", "--crossings.guess"]
