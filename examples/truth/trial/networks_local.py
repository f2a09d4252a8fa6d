"""Road networks of the tenth held group, of roads that people drive every day: a suburban road with double left turns
and driveways in which one only turns right; a school quarter of staggered and skewed crossings; a ring motorway with
many trucks and short ramps; a town on two banks whose bridge has one lane in each direction.
"""

import math

from networks import document, edge, link, node, ring, two_way


def suburb(work, draw):
    """Two lanes in each direction with a closed median; at each of four lights two lanes for left turns over the last
    70 m. Between the lights driveways of shops, right in and right out.
    """
    limit, main, minor = 17.88, "highway.primary", "highway.tertiary"
    y = lambda x: 18 * math.cos(x / 240)
    xs = [draw.uniform(-12, 12) + 290 * i for i in range(4)]
    at = {"w": -260, "e": xs[-1] + 260} | {f"a{i}": x for i, x in enumerate(xs)}
    nodes = [node(n, x, y(x), "traffic_light" if n[0] == "a" else "priority") for n, x in at.items()]
    edges, links, order = [], [], ["w", "a0", "a1", "a2", "a3", "e"]
    for sign, names in ((1, order), (-1, order[::-1])):
        for k, (a, b) in enumerate(zip(names, names[1:])):
            if b in "we":
                edges.append(edge(a + b, a, b, 2, limit, main, 9))
                continue
            near, drive = at[b] - sign * 82, at[b] - sign * draw.uniform(135, 165)
            p, d, s = f"{a}p{b}", f"{a}d{b}", f"{a}s{b}"
            # Both lanes part from the median before the two of the left turns begin beside it.
            out = lambda x, sign=sign: (x, y(x) - sign * 6.4)
            nodes += [node(p, *out(near)), node(d, *out(drive)), node(s, drive + sign * 6, y(drive) - sign * 90)]
            edges += [edge(a + b, a, d, 2, limit, main, 9), edge(d + p, d, p, 2, limit, main, 9),
                      edge(p + b, p, b, 4, limit, main, 9, [out(at[b] - sign * t) for t in (40, 12)]).replace(" numLanes", ' spreadType="center" numLanes')]
            two_way(edges, s, d, 1, 6.94, "highway.service", 2)
            links += [link(d + p, p + b, i, j) for i, j in ((0, 0), (1, 1), (1, 2), (1, 3))]
            # Lane 0 ahead and right, 1 ahead, 2 and 3 left, as the arms' names are: n to the north, s to the south.
            left, right, ahead = (f"{b}{b}n", f"{b}{b}s", b + names[k + 2]) if sign > 0 else (f"{b}{b}s", f"{b}{b}n", b + names[k + 2])
            links += [link(p + b, right, 0, 0), link(p + b, ahead, 0, 0), link(p + b, ahead, 1, 1), link(p + b, left, 2, 0), link(p + b, left, 3, 1)]
    for i, x in enumerate(xs):
        for tag, sign in (("n", 1), ("s", -1)):
            nodes.append(node(f"a{i}{tag}", x + draw.uniform(-30, 30), y(x) + sign * 190))
            edges += [edge(f"a{i}a{i}{tag}", f"a{i}", f"a{i}{tag}", 2, 13.41, minor, 6), edge(f"a{i}{tag}a{i}", f"a{i}{tag}", f"a{i}", 2, 13.41, minor, 6, bay=45 if (i + sign) % 3 else 0)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return ["--no-turnarounds", "--tls.cycle.time", 70, "--tls.yellow.time", 4, "--tls.left-green.time", 9, "--junctions.corner-detail", 5]


def school(work, draw):
    """30 km/h: two streets beside each other, joined by aslant streets; side streets of the two meet them staggered; at
    some junctions all stop, at others who comes from the right goes first. Many people walk.
    """
    kinds = ("right_before_left", "allway_stop", "right_before_left", "priority", "priority_stop", "right_before_left")
    nodes, edges = [], []
    for row, (base, tilt) in enumerate(((0, 0.06), (165, -0.05))):
        names, x = [f"r{row}w"], 0.0
        nodes += [node(f"r{row}w", -130, base - 130 * tilt)]
        for i in range(6):
            x = 105 * i + 55 * row + draw.uniform(-9, 9)
            nodes.append(node(f"r{row}n{i}", x, base + tilt * x, kinds[(i + 2 * row) % 6]))
            names.append(f"r{row}n{i}")
            if (i + row) % 2:
                # Staggered: the street on the other side goes on 42 m further.
                out = f"r{row}s{i}"
                nodes.append(node(out, x + draw.uniform(-20, 20), base + (1 if row else -1) * 125 + tilt * x))
                two_way(edges, out, f"r{row}n{i}", 1, 8.33, "highway.residential", 3)
        nodes.append(node(f"r{row}e", x + 140, base + tilt * (x + 140)))
        for a, b in zip(names, [*names[1:], f"r{row}e"]):
            two_way(edges, a, b, 1, 8.33 if row else 11.11, "highway.residential", 3 + 2 * (row == 0))
    for i in (0, 2, 3, 5):
        two_way(edges, f"r0n{i}", f"r1n{i}", 1, 8.33, "highway.residential", 3)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]


def ring_motorway(work, draw):
    """An arc of a ring motorway, both carriageways: entries whose lanes end after 95 m, exits whose lanes are as short, a
    plain exit, a third lane that ends by taking turns and comes back.
    """
    limit, nodes, edges, links = 27.78, [], [], []
    spot = lambda s, off: ((880 + off) * math.cos(3.3 - s / 880), (880 + off) * math.sin(3.3 - s / 880))
    for tag, off, steps in (("i", -14, ((0, 2, ""), (340, 3, "in"), (450, 2, "ends"), (760, 3, ""), (865, 2, "out"), (1150, 3, "in"), (1560, 2, "zip"), (1900, 2, "plain"), (2180, 3, "in"), (2300, 2, "ends"), (2750, 0, ""))),
                            ("o", 14, ((0, 3, ""), (310, 4, "in"), (420, 3, "ends"), (800, 2, "zip"), (1120, 3, ""), (1215, 2, "out"), (1530, 3, "in"), (1880, 2, "out"), (2200, 3, "in"), (2310, 2, "ends"), (2750, 0, "")))):
        # The outer carriageway runs the other way round; on both the ramps are on the right.
        way = lambda s, more, tag=tag, off=off: spot(s if tag == "i" else 2750 - s, off + (-more if tag == "i" else more))
        for i, (s, count, kind) in enumerate(steps):
            nodes.append(node(f"{tag}{i}", *way(s, 0), "zipper" if kind == "zip" else "priority"))
            if count:
                far = steps[i + 1][0]
                edges.append(edge(f"{tag}m{i}", f"{tag}{i}", f"{tag}{i + 1}", count, limit, "highway.motorway", 13, [way(s + (far - s) * t / 8, 0) for t in range(1, 8)]))
            if not 0 < i < len(steps) - 1:
                continue
            n, a, b = steps[i - 1][1], f"{tag}m{i - 1}", f"{tag}m{i}"
            ramp, shift = f"{tag}ramp{i}", 3.2 * min(n, count)
            if kind in ("in", "out", "plain"):
                sign = -1 if kind == "in" else 1
                shape = [way(s + sign * d, shift + more) for d, more in ((15, 0.2), (40, 2), (70, 7), (100, 16))]
                nodes.append(node(ramp, *way(s + sign * 136, 31)))
                edges.append(edge(ramp, *((ramp, f"{tag}{i}") if sign < 0 else (f"{tag}{i}", ramp)), 1, 18.06, "highway.motorway_link", 7, shape[::-1] if sign < 0 else shape))
                links.append(link(ramp, b, 0, 0) if sign < 0 else link(a, ramp, 0, 0))
            if kind == "zip":
                links += [link(a, b, j, min(j, count - 1)) for j in range(n)]
            elif count > n:
                links += [link(a, b, j, j + 1) for j in range(n)] + ([link(a, b, 0, 0)] if kind == "" else [])
            else:
                links += [link(a, b, j + n - count, j) for j in range(count)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return ["--no-turnarounds"]


def two_banks(work, draw):
    """A town on two banks: before the bridge two lanes become one by taking turns; a light on one bank, a small
    roundabout on the other, a chain of side roads that stop or give way, buses that stop in the lane, many riders.
    """
    nodes, edges = [], []
    ring(edges, nodes, "o", 240, 8, 15, 1, [0, 95, 180, 270], 7.0)
    places = {"w": (-700, 30), "t1": (-560, 22), "t2": (-450, 14), "l": (-290, 4), "bw": (-110, 0), "be": (110, 0), "t3": (360, 16), "t4": (455, 24), "e": (610, 30), "ln": (-270, 180), "ls": (-310, -170),
              "s1": (-585, -120), "s2": (-430, 140), "s3": (380, 150), "s4": (430, -110), "on": (225, 170), "os": (250, -165)}
    kinds = {"t1": "priority_stop", "t3": "priority_stop", "l": "traffic_light", "bw": "zipper", "be": "zipper"}
    nodes += [node(n, x + draw.uniform(-4, 4), y, kinds.get(n, "priority")) for n, (x, y) in places.items()]
    for a, b, lanes, back in (("w", "t1", 1, 1), ("t1", "t2", 1, 1), ("t2", "l", 1, 1), ("l", "bw", 2, 2), ("bw", "be", 1, 1), ("be", "o2", 2, 2), ("o0", "t3", 1, 1), ("t3", "t4", 1, 1), ("t4", "e", 1, 1)):
        two_way(edges, a, b, lanes, 13.89, "highway.secondary", 8, back=back, bays=(40, 0) if b == "l" else (0, 35) if a == "l" else (0, 0))
    for a, b in (("ln", "l"), ("ls", "l"), ("s1", "t1"), ("s2", "t2"), ("s3", "t3"), ("s4", "t4"), ("on", "o1"), ("os", "o3")):
        two_way(edges, a, b, 1, 11.11, "highway.tertiary", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # All begin at once: what is listed later must not depart earlier.
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="0" period="48" number="4" from="wt1" to="t4e"><stop edge="t2l" endPos="70" duration="11"/><stop edge="o0t3" endPos="60" duration="9"/></flow>',
        *(f'<flow id="rider{a}" type="cycle" begin="0" period="{p}" number="{int(200 / p)}" from="{a}" to="{b}"/>' for a, b, p in (
            ("wt1", "t4e", 19), ("et4", "t1w", 23), ("lnl", "lls", 27), ("ono1", "o3os", 29), ("s3t3", "t1s1", 31)))]))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]
