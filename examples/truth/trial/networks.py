"""Road networks of the trial: of other shapes than those in `traffic/` or `roads/`.

Each function writes plain node, edge and connection files into a folder and returns the options for netconvert. Towns
of netgenerate get mixed kinds of junctions, lanes and limits from a seed, because netgenerate itself gives one kind
to all.
"""

import math
import os
import re
import subprocess
import xml.etree.ElementTree as ET

import sumo


def tool(name, *args):
    subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", name), *map(str, args)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def document(path, tag, rows):
    path.write_text(f"<{tag}>\n" + "\n".join(rows) + f"\n</{tag}>\n")


def node(name, x, y, kind="priority"):
    return f'<node id="{name}" x="{x:.2f}" y="{y:.2f}" type="{kind}"/>'


def edge(name, start, end, lanes, speed, kind="", priority=5, shape=(), bay=0):
    """A road one way; with `bay`, one more lane on the far side over its last meters."""
    points = f' shape="{" ".join(",".join(f"{c:.2f}" for c in p) for p in shape)}"' if shape else ""
    more = (f' type="{kind}"' if kind else "") + points
    return f'<edge id="{name}" from="{start}" to="{end}" numLanes="{lanes + bool(bay)}" speed="{speed}" priority="{priority}"{more}>{widening(lanes, bay)}</edge>'


def widening(lanes, bay):
    names = lambda n: " ".join(map(str, range(n)))
    return f'<split pos="0" lanes="{names(lanes)}"/><split pos="{-bay}" lanes="{names(lanes + 1)}"/>' if bay else ""


def smooth(points, steps=8):
    """The same way in bends instead of corners (Catmull-Rom), heights as well; the ends stay."""
    out = []
    for i in range(1, len(points) - 2):
        a, b, c, d = points[i - 1:i + 3]
        for t in (n / steps for n in range(steps)):
            out.append(tuple(0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t**2 + (3 * q - p - 3 * r + s) * t**3) for p, q, r, s in zip(a, b, c, d)))
    return [*out, points[-2]]


def link(start, end, a, b):
    return f'<connection from="{start}" to="{end}" fromLane="{a}" toLane="{b}"/>'


def generated(work, draw, kinds, limits, lanes, *options, bay=0):
    """A town of netgenerate whose junctions and roads are mixed: `kinds`, `limits` (m/s) and `lanes` are drawn
    from, per junction and road.
    """
    tool("netgenerate", *options, "--seed", draw.randrange(10**6), "--plain-output-prefix", work / "raw")
    nodes = ET.parse(work / "raw.nod.xml").getroot()
    edges = ET.parse(work / "raw.edg.xml").getroot()
    arms = {}
    for e in edges.iter("edge"):
        arms.setdefault(e.get("to"), set()).add(e.get("from"))
    for n in nodes.iter("node"):
        n.attrib.pop("tl", None)
        for name in ("tlType", "tlLayout", "shape"):
            n.attrib.pop(name, None)
        n.set("type", draw.choice(kinds) if len(arms.get(n.get("id"), ())) >= 3 else "priority")
    roads = {}
    for e in edges.iter("edge"):
        key = tuple(sorted((e.get("from"), e.get("to"))))
        if key not in roads:
            roads[key] = (draw.choice(lanes), draw.choice(limits))
        count, limit = roads[key]
        for lane in list(e):
            e.remove(lane)
        wide = bay and count < 3 and len(arms.get(e.get("to"), ())) >= 3
        e.set("numLanes", str(count + bool(wide)))
        for pos, n in ((0, count), (-bay, count + 1)) if wide else ():
            ET.SubElement(e, "split", pos=str(pos), lanes=" ".join(map(str, range(n))))
        e.set("speed", str(limit))
        e.set("priority", str(3 + count * 2 + (limit > 14)))
        e.attrib.pop("type", None)
    ET.ElementTree(nodes).write(work / "nod.xml")
    ET.ElementTree(edges).write(work / "edg.xml")
    return []


def two_way(rows, a, b, lanes, speed, kind="", priority=5, back=None, shape=(), bays=(0, 0)):
    rows.append(edge(f"{a}{b}", a, b, lanes, speed, kind, priority, shape, bays[0]))
    rows.append(edge(f"{b}{a}", b, a, back or lanes, speed, kind, priority, list(reversed(shape)), bays[1]))


def random_town(work, draw):
    return generated(work, draw, ["priority", "traffic_light", "allway_stop", "right_before_left", "priority"], [8.33, 13.89, 16.67], [1, 1, 2, 3],
                     "--rand", "--rand.iterations", 45, "--rand.min-distance", 90, "--rand.max-distance", 210, "--rand.min-angle", 40,
                     "--rand.neighbor-dist4", 12, "--rand.neighbor-dist3", 6) + ["--tls.default-type", "actuated", "--junctions.corner-detail", 5]


def web_town(work, draw):
    return generated(work, draw, ["priority", "priority", "traffic_light"], [13.89, 11.11], [1, 2],
                     "--spider", "--spider.arm-number", 7, "--spider.circle-number", 3, "--spider.space-radius", 110) + ["--junctions.corner-detail", 5]


def left_grid(work, draw):
    return generated(work, draw, ["traffic_light", "priority", "allway_stop"], [13.89, 13.89, 8.33], [1, 2],
                     "--grid", "--grid.x-number", 3, "--grid.y-number", 3, "--grid.x-length", 150, "--grid.y-length", 120, "--grid.attach-length", 130,
                     "--perturb-x", "norm(0,14)", "--perturb-y", "norm(0,10)", bay=35) + [
        "--lefthand", "--sidewalks.guess", "--crossings.guess", "--no-turnarounds"]


def avenue(work, draw):
    """A main road with bays, sharp turn lanes and lanes that shift sideways where it widens and narrows; acute
    side roads; a U-turn place.
    """
    s = 16.67
    nodes = [node("w", -420, 10), node("a", -180, 0, "traffic_light"), node("b", 60, 15, "traffic_light"), node("c", 290, -10), node("e", 520, -30),
             node("an", -120, 190), node("as", -240, -150), node("bn", 160, 170), node("bs", -10, -160), node("cn", 380, 130), node("cs", 330, -190)]
    edges = []
    two_way(edges, "w", "a", 2, s, "highway.primary", 9, back=2, bays=(60, 0))
    two_way(edges, "a", "b", 3, s, "highway.primary", 9, back=2, shape=[(-100, 14), (-20, -4)], bays=(0, 50))
    two_way(edges, "b", "c", 2, s, "highway.primary", 9, back=3, shape=[(150, 22), (220, -6)], bays=(40, 0))
    two_way(edges, "c", "e", 3, s, "highway.primary", 9, back=2)
    for a, b, lanes in (("an", "a", 2), ("as", "a", 1), ("bn", "b", 1), ("bs", "b", 2), ("cn", "c", 1), ("cs", "c", 1)):
        two_way(edges, a, b, lanes, 13.89, "highway.tertiary", 5)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--junctions.corner-detail", 5, "--tls.left-green.time", 6]


def ring(edges, nodes, name, x, y, radius, lanes, arms, speed=8.33):
    """A roundabout anti-clockwise around (x, y), with a node at each arm's angle (degrees)."""
    angles = sorted(arms)
    for i, a in enumerate(angles):
        nodes.append(node(f"{name}{i}", x + radius * math.cos(math.radians(a)), y + radius * math.sin(math.radians(a))))
    for i, a in enumerate(angles):
        b = angles[(i + 1) % len(angles)]
        sweep = (b - a) % 360
        shape = [(x + radius * math.cos(math.radians(a + sweep * k / 8)), y + radius * math.sin(math.radians(a + sweep * k / 8))) for k in range(9)]
        edges.append(edge(f"{name}r{i}", f"{name}{i}", f"{name}{(i + 1) % len(angles)}", lanes, speed, "highway.secondary", 9, shape))


def ring_town(work, draw):
    """Two roundabouts, one of two lanes and one small, joined by streets with a bend, and a priority junction
    between.
    """
    nodes, edges = [], []
    ring(edges, nodes, "p", 0, 0, 26, 2, [10, 95, 180, 260])
    ring(edges, nodes, "q", 320, 40, 15, 1, [5, 120, 190, 280], 7.0)
    ends = {"P1": (40, 210), "P2": (-230, 10), "P3": (-60, -210), "Q0": (560, 60), "Q1": (240, 230), "Q3": (360, -190), "M": (165, 90), "N": (150, 240)}
    nodes += [node(n, *xy) for n, xy in ends.items()]
    for a, b, lanes in (("P1", "p1", 2), ("P2", "p2", 2), ("P3", "p3", 1), ("Q0", "q0", 1), ("Q1", "q1", 1), ("Q3", "q3", 1), ("N", "M", 1)):
        two_way(edges, a, b, lanes, 13.89, "highway.secondary", 5)
    two_way(edges, "p0", "M", 1, 13.89, "highway.secondary", 5, shape=[(80, 30), (120, 75)])
    two_way(edges, "M", "q2", 1, 13.89, "highway.secondary", 5, shape=[(220, 95), (270, 60)])
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--roundabouts.guess", "--junctions.corner-detail", 5, "--no-turnarounds"]


def weave_motorway(work, draw):
    """On-ramp and exit joined by one auxiliary lane (weaving), a lane that ends (zipper), a sideways shift of all
    lanes, a plain exit.
    """
    s = 33.33
    nodes = [node("a", -900, 0), node("b", -300, 5), node("c", 20, 0), node("d", 420, -30), node("z", 800, -20, "zipper"), node("f", 1150, 30), node("g", 1500, 40),
             node("r", -520, -90), node("x", 260, -110), node("y", 1380, -80)]
    edges = [edge("ab", "a", "b", 3, s, "highway.motorway", 13), edge("bc", "b", "c", 4, s, "highway.motorway", 13),
             edge("cd", "c", "d", 3, s, "highway.motorway", 13, [(140, 0), (220, -14), (320, -28)]), edge("dz", "d", "z", 3, s, "highway.motorway", 13),
             edge("zf", "z", "f", 2, s, "highway.motorway", 13, [(900, -12), (1000, 26)]), edge("fg", "f", "g", 2, s, "highway.motorway", 13),
             edge("rb", "r", "b", 1, 22.22, "highway.motorway_link", 9, [(-420, -40), (-340, -8)]),
             edge("cx", "c", "x", 1, 16.67, "highway.motorway_link", 9, [(110, -25)]), edge("fy", "f", "y", 1, 16.67, "highway.motorway_link", 9, [(1260, 0)])]
    links = [link("rb", "bc", 0, 0), *(link("ab", "bc", i, i + 1) for i in range(3)), link("bc", "cx", 0, 0), *(link("bc", "cd", i + 1, i) for i in range(3)),
             link("dz", "zf", 0, 0), link("dz", "zf", 1, 1), link("dz", "zf", 2, 1), link("zf", "fg", 0, 0), link("zf", "fg", 1, 1), link("zf", "fy", 0, 0)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []


def osm_motorway(work, draw):
    """Typed like an import from OpenStreetMap: two carriageways, acceleration and deceleration lanes guessed by
    netconvert, a bridge across.
    """
    s = 36.11
    nodes, edges = [], []
    for side, y, way in (("n", 14, -1), ("s", -14, 1)):
        for i, x in enumerate((-1100, -420, -120, 260, 560, 1100)):
            bend = 40 * math.sin(x / 520)
            nodes.append(node(f"{side}{i}", x, y + bend))
        order = range(5) if way > 0 else range(4, -1, -1)
        for i in order:
            a, b = (i, i + 1) if way > 0 else (i + 1, i)
            edges.append(edge(f"{side}{a}{b}", f"{side}{a}", f"{side}{b}", 2 if side == "n" else 3, s, "highway.motorway", 13))
    nodes += [node("u", -200, -130), node("v", 480, -130), node("o", -140, 160), node("t", 420, 170)]
    edges += [edge("exs", "s1", "u", 1, 13.89, "highway.motorway_link", 9, [(-330, -60)]), edge("ens", "v", "s4", 1, 19.44, "highway.motorway_link", 9, [(500, -60)]),
              edge("exn", "n3", "o", 1, 13.89, "highway.motorway_link", 9, [(120, 80)]), edge("enn", "t", "n2", 1, 19.44, "highway.motorway_link", 9, [(120, 90), (20, 40)])]
    # Where the exit leaves before the entry's node, the ramps of netconvert do not overlap.
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--ramps.guess", "--ramps.ramp-length", 170, "--ramps.min-highway-speed", 25]


def city_grid(work, draw):
    return generated(work, draw, ["traffic_light", "traffic_light", "priority"], [13.89, 16.67], [2, 2, 1, 3],
                     "--grid", "--grid.x-number", 3, "--grid.y-number", 2, "--grid.x-length", 190, "--grid.y-length", 140, "--grid.attach-length", 160,
                     "--perturb-x", "norm(0,20)", "--perturb-y", "norm(0,16)", bay=45) + [
        "--sidewalks.guess", "--crossings.guess", "--tls.default-type", "static", "--junctions.corner-detail", 5]


def old_town(work, draw):
    return generated(work, draw, ["right_before_left", "priority", "allway_stop", "traffic_light"], [8.33, 11.11, 13.89], [1, 1, 2],
                     "--rand", "--rand.iterations", 60, "--rand.min-distance", 70, "--rand.max-distance", 160, "--rand.min-angle", 30,
                     "--rand.neighbor-dist3", 8, "--rand.neighbor-dist5", 2) + ["--no-turnarounds"]


def left_rings(work, draw):
    """Left-hand traffic: netconvert mirrors the driving side, so a ring runs clockwise; four small roundabouts on
    a square and a signaled middle.
    """
    nodes, edges = [], []
    for name, x, y in (("p", 0, 0), ("q", 260, 0)):
        angles = [0, 90, 180, 270]
        for i, a in enumerate(angles):
            nodes.append(node(f"{name}{i}", x + 20 * math.cos(math.radians(a)), y + 20 * math.sin(math.radians(a))))
        for i, a in enumerate(angles):
            shape = [(x + 20 * math.cos(math.radians(a - 90 * k / 6)), y + 20 * math.sin(math.radians(a - 90 * k / 6))) for k in range(7)]
            edges.append(edge(f"{name}r{i}", f"{name}{i}", f"{name}{(i - 1) % 4}", 1, 8.33, "highway.tertiary", 9, shape))
    ends = {"A": (-220, 10), "B": (10, 220), "C": (-20, -220), "D": (500, -10), "E": (250, 210), "F": (280, -230)}
    nodes += [node(n, *xy) for n, xy in ends.items()] + [node("m", 130, 6, "traffic_light"), node("mn", 140, 150), node("ms", 120, -150)]
    for a, b in (("A", "p2"), ("B", "p1"), ("C", "p3"), ("D", "q0"), ("E", "q1"), ("F", "q3"), ("p0", "m"), ("m", "q2"), ("mn", "m"), ("ms", "m")):
        two_way(edges, a, b, 1, 13.89, "highway.tertiary", 5)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--lefthand", "--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5]


def clover_motorway(work, draw):
    """Half a cloverleaf: loops join and leave through one weaving lane and pass over the main road; a lane joins for
    good after a long ramp; the left lane ends.
    """
    s = 30.56
    nodes = [node("a", -800, 0), node("b", -120, 0), node("c", 130, 0), node("d", 520, 20), node("e", 900, 20), node("f", 1300, -10),
             node("la", -30, 190), node("lb", 60, 190), node("r", 200, -160)]
    edges = [edge("ab", "a", "b", 2, s, "highway.trunk", 12), edge("bc", "b", "c", 3, s, "highway.trunk", 12), edge("cd", "c", "d", 2, s, "highway.trunk", 12, [(260, 0), (380, 16)]),
             edge("de", "d", "e", 3, s, "highway.trunk", 12), edge("ef", "e", "f", 2, s, "highway.trunk", 12, [(1050, 22), (1180, -6)]),
             edge("lb1", "la", "b", 1, 11.11, "highway.trunk_link", 8, smooth([(-30, 190, 0), (-60, 150, 3), (-190, 120, 6), (-280, 40, 6), (-250, -22, 4.5), (-190, -20, 1.5), (-120, 0, 0)])),
             edge("cl", "c", "lb", 1, 11.11, "highway.trunk_link", 8, smooth([(130, 0, 0), (200, -20, 1.5), (270, -22, 4.5), (320, 40, 6), (260, 110, 6), (130, 150, 3), (60, 190, 0)])),
             edge("rd", "r", "d", 1, 22.22, "highway.trunk_link", 8, [(330, -70), (450, 0)])]
    links = [link("lb1", "bc", 0, 0), link("ab", "bc", 0, 1), link("ab", "bc", 1, 2), link("bc", "cl", 0, 0), link("bc", "cd", 1, 0), link("bc", "cd", 2, 1),
             link("rd", "de", 0, 0), link("cd", "de", 0, 1), link("cd", "de", 1, 2), link("de", "ef", 0, 0), link("de", "ef", 1, 1)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []


def hill_motorway(work, draw):
    """Four lanes in S-bends, a plain exit without a lane of its own, a two-lane exit, an on-ramp whose lane ends,
    without any typed edge.
    """
    s = 27.78
    nodes = [node("a", -900, 0), node("b", -350, 60), node("c", 100, 0), node("d", 420, 30), node("e", 800, 0), node("f", 1200, 80),
             node("x", -150, -60), node("y", 640, -90), node("r", 80, -150)]
    edges = [edge("ab", "a", "b", 4, s, "", 12, [(-760, 10), (-560, 70)]), edge("bc", "b", "c", 4, s, "", 12, [(-200, 40), (-60, -4)]), edge("cd", "c", "d", 4, s, "", 12),
             edge("de", "d", "e", 3, s, "", 12, [(560, 34), (680, 0)]), edge("ef", "e", "f", 3, s, "", 12, [(930, 0), (1080, 70)]),
             edge("bx", "b", "x", 1, 16.67, "", 6, [(-260, 30)]), edge("dy", "d", "y", 2, 19.44, "", 6, [(500, 10), (590, -50)]), edge("re", "r", "c", 1, 19.44, "", 6, [(20, -70), (60, -20)])]
    links = [*(link("ab", "bc", i, i) for i in range(4)), link("ab", "bx", 0, 0), *(link("bc", "cd", i, i) for i in range(1, 4)), link("bc", "cd", 0, 0), link("re", "cd", 0, 0),
             link("cd", "dy", 0, 0), link("cd", "dy", 1, 1), *(link("cd", "de", i + 1, i) for i in range(3)), *(link("de", "ef", i, i) for i in range(3))]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", [l for l in links if l])
    return []


def star_town(work, draw):
    return generated(work, draw, ["allway_stop", "priority", "traffic_light", "priority_stop"], [13.89], [1, 2],
                     "--spider", "--spider.arm-number", 5, "--spider.circle-number", 3, "--spider.space-radius", 140, "--spider.omit-center") + [
        "--tls.default-type", "actuated"]


def loop_interchange(work, draw):
    """Two motorways that cross, joined by four loops through weaving lanes and by four direct ramps; exits by a lane of
    their own and plain ones, alternating. Loops and carriageways are drawn with corners, as by hand; one motorway is on
    a bridge over the other.
    """
    nodes, edges, links = [], [], []
    turned = lambda x, y, d: [(x, y), (-y, x), (-x, -y), (y, -x)][d]
    at = {"s": -950, "a": -420, "w": -110, "x": 110, "b": 420, "m": 690, "e": 980}
    for d in range(4):
        nodes += [node(f"{n}{d}", *turned(x, -14 + draw.uniform(-1.5, 1.5), d)) for n, x in at.items()]
    for d in range(4):
        s, right, k = 29.17, (d - 1) % 4, "highway.motorway"
        own = d % 2 == 0
        bow = lambda a, b, by: [turned(a, -14, d), turned((a + b) / 2, -14 + by, d), turned(b, -14, d)]
        edges += [edge(f"sa{d}", f"s{d}", f"a{d}", 3 if own else 2, s, k, 13, bow(-800, -520, 4)), edge(f"aw{d}", f"a{d}", f"w{d}", 2, s, k, 13),
                  edge(f"wx{d}", f"w{d}", f"x{d}", 3, s, k, 13, [(*turned(x, -14, d), 6.5) for x in (-30, 30)] if d % 2 else ()), edge(f"xb{d}", f"x{d}", f"b{d}", 2, s, k, 13, bow(190, 340, 3)),
                  edge(f"bm{d}", f"b{d}", f"m{d}", 3, s, k, 13), edge(f"me{d}", f"m{d}", f"e{d}", 2, s, k, 13)]
        # To the right at once; and by the loop, three quarters round to the right, onto the road that comes from there.
        edges.append(edge(f"ab{d}", f"a{d}", f"b{right}", 1, 16.67, f"{k}_link", 9, [turned(x, y, d) for x, y in ((-330, -24), (-190, -70), (-70, -190), (-24, -330))]))
        loop = ((170, -22), (215, -50), (225, -105), (190, -165), (130, -195), (70, -190), (34, -165))
        edges.append(edge(f"xw{d}", f"x{d}", f"w{(d + 1) % 4}", 1, 11.11, f"{k}_link", 9, [turned(x, y, d) for x, y in loop]))
        main = [("sa", "aw", 1 if own else 0, 0), ("sa", "aw", 2 if own else 1, 1), ("aw", "wx", 0, 1), ("aw", "wx", 1, 2), ("wx", "xb", 1, 0), ("wx", "xb", 2, 1),
                ("xb", "bm", 0, 1), ("xb", "bm", 1, 2), ("bm", "me", 1, 0), ("bm", "me", 2, 1)]
        links += [link(f"{a}{d}", f"{b}{d}", i, j) for a, b, i, j in main]
        links += [link(f"sa{d}", f"ab{d}", 0, 0), link(f"wx{d}", f"xw{d}", 0, 0), link(f"ab{d}", f"bm{right}", 0, 0), link(f"xw{d}", f"wx{(d + 1) % 4}", 0, 0)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    return []


def trumpet(work, draw):
    """A trumpet: a road ends at a motorway; one loop and one wide curve on a bridge, two direct ramps; an exit by a lane
    of its own, a plain one, an entry whose lane ends, one whose lane stays.
    """
    s, k = 30.56, "highway.motorway"
    places = {"a": (-950, -13), "b": (-330, -12), "c": (330, -12), "m": (640, -14), "d": (980, -18), "p": (980, 8), "o": (340, 14), "q": (-60, 14), "r": (-430, 14), "t": (-950, 12),
              "n": (-8, -330), "u": (10, -330), "z": (0, -720)}
    loop = [(-120, 24, 0), (-165, 60, 1), (-170, 105, 2), (-135, 140, 4), (-85, 145, 6), (-40, 115, 7), (-14, 60, 7.5), (-9, -30, 7.5), (-8, -200, 2)]
    curve = [(9, -200, 2), (9, -30, 7.5), (12, 80, 7.5), (-10, 160, 6), (-90, 205, 4), (-210, 180, 2), (-320, 80, 0.5), (-380, 26, 0)]
    edges = [edge("ab", "a", "b", 2, s, k, 13, [(-780, -9), (-520, -14)]), edge("bc", "b", "c", 2, s, k, 13), edge("cm", "c", "m", 3, s, k, 13), edge("md", "m", "d", 2, s, k, 13),
             edge("po", "p", "o", 2, s, k, 13, [(760, 12)]), edge("oq", "o", "q", 3, s, k, 13), edge("qr", "q", "r", 2, s, k, 13), edge("rt", "r", "t", 3, s, k, 13),
             edge("bn", "b", "n", 1, 16.67, f"{k}_link", 9, [(-230, -30), (-110, -110), (-40, -220)]), edge("uc", "u", "c", 1, 19.44, f"{k}_link", 9, [(40, -220), (110, -110), (230, -34)]),
             edge("qn", "q", "n", 1, 11.11, f"{k}_link", 9, loop), edge("ur", "u", "r", 1, 16.67, f"{k}_link", 9, curve),
             edge("nz", "n", "z", 2, 19.44, "highway.primary", 9, [(-6, -480)]), edge("zu", "z", "u", 2, 19.44, "highway.primary", 9, [(8, -480)])]
    joined = [("ab", "bc", 0, 0), ("ab", "bc", 1, 1), ("ab", "bn", 0, 0), ("bc", "cm", 0, 1), ("bc", "cm", 1, 2), ("uc", "cm", 0, 0), ("cm", "md", 1, 0), ("cm", "md", 2, 1),
              ("po", "oq", 0, 1), ("po", "oq", 1, 2), ("po", "oq", 0, 0), ("oq", "qr", 1, 0), ("oq", "qr", 2, 1), ("oq", "qn", 0, 0), ("qr", "rt", 0, 1), ("qr", "rt", 1, 2),
              ("ur", "rt", 0, 0), ("bn", "nz", 0, 0), ("qn", "nz", 0, 1), ("zu", "uc", 0, 0), ("zu", "ur", 1, 0)]
    document(work / "nod.xml", "nodes", [node(n, *xy) for n, xy in places.items()])
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", [link(*j) for j in joined])
    return []


def left_spider(work, draw):
    return generated(work, draw, ["traffic_light", "priority", "priority", "right_before_left"], [11.11, 13.89, 16.67], [1, 2],
                     "--spider", "--spider.arm-number", 6, "--spider.circle-number", 3, "--spider.space-radius", 125, bay=30) + [
        "--lefthand", "--no-turnarounds", "--tls.default-type", "actuated"]


def ring_street(work, draw):
    """A roundabout of two lanes with five arms, at the end of a street with a crossroads that has lights and a skew
    crossing with a priority road.
    """
    nodes, edges = [], []
    ring(edges, nodes, "g", 0, 0, 30, 2, [0, 70, 140, 215, 290], 9.72)
    places = {"y": (400, -15), "e": (640, -40), "xn": (205, 190), "xs": (170, -180), "yn": (470, 150), "ys": (380, -200), "A": (75, 220), "B": (-190, 160), "C": (-180, -130), "D": (70, -215)}
    nodes += [node(n, *xy) for n, xy in places.items()] + [node("x", 190, 10, "traffic_light")]
    for a, b, lanes in (("g0", "x", 2), ("x", "y", 2), ("y", "e", 2), ("A", "g1", 1), ("B", "g2", 2), ("C", "g3", 1), ("D", "g4", 1), ("xn", "x", 1), ("xs", "x", 2), ("yn", "y", 1), ("ys", "y", 1)):
        main = a in ("g0", "x", "y") and lanes == 2
        two_way(edges, a, b, lanes, 13.89, "highway.secondary" if main else "highway.residential", 7 if main else 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]
