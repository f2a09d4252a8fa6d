"""The road networks of the traffic sets, as SUMO's plain node, edge and connection files.

Each function gives (nodes, edges, connections, extra netconvert options) as XML texts. `v` is the number of the set (0 to 3): lengths, angles,
speeds, limits and grades differ, so that nothing fits one drawing of a road only.
"""

import math

SIDEWALK = '<lane index="0" allow="pedestrian" width="2.0" speed="5.56"/>'


def document(tag, rows):
    return f"<{tag}>\n" + "\n".join(rows) + f"\n</{tag}>\n"


def node(name, x, y, kind="priority", z=None, **more):
    extra = "".join(f' {k}="{w}"' for k, w in more.items())
    height = "" if z is None else f' z="{z}"'
    return f'<node id="{name}" x="{x}" y="{y}"{height} type="{kind}"{extra}/>'


def both_ways(a, b, lanes, speed, sidewalk=True, bus=False, width=3.3, priority=1, **more):
    """Two edges; lane 0 is the pavement where there is one, then the bus lane where there is one."""
    for i, j in ((a, b), (b, a)):
        rows, first = [], 0
        if sidewalk:
            rows.append(SIDEWALK)
            first = 1
        for k in range(first, first + lanes + int(bus)):
            allow = ' allow="bus bicycle"' if bus and k == first else ' disallow="pedestrian"'
            rows.append(f'<lane index="{k}"{allow} width="{width}"/>')
        total = first + lanes + int(bus)
        extra = "".join(f' {k}="{w}"' for k, w in more.items())
        yield f'<edge id="{i}{j}" from="{i}" to="{j}" numLanes="{total}" speed="{speed}" priority="{priority}"{extra}>' + "".join(rows) + "</edge>"


def city(v):
    """Four crossroads with lights and crosswalks; two lanes a direction, a bus lane along the southern avenue."""
    a, arm, speed = ((190, 170, 13.89), (225, 150, 12.5), (175, 160, 15.28), (240, 185, 13.89))[v]
    # From the third set on the blocks are not square: streets meet at a slant.
    dx, dy = ((0, 0), (0, 0), (28, -18), (-35, 22))[v]
    nodes = [node(f"{c}{r}", x * a + x * y * dx, y * a + x * y * dy, "traffic_light") for x, c in enumerate("AB") for y, r in enumerate("01")]
    ends = {"sA": (0, -arm, "A0"), "sB": (a, -arm, "B0"), "nA": (0, a + arm, "A1"), "nB": (a + dx, a + dy + arm, "B1"),
            "w0": (-arm, 0, "A0"), "w1": (-arm, a, "A1"), "e0": (a + arm, 0, "B0"), "e1": (a + dx + arm, a + dy, "B1")}
    nodes += [node(n, x, y) for n, (x, y, _) in ends.items()]
    streets = [(n, j) for n, (_, _, j) in ends.items()] + [("A0", "A1"), ("B0", "B1"), ("A0", "B0"), ("A1", "B1")]
    edges = []
    for i, j in streets:
        south = {i, j} in ({"w0", "A0"}, {"A0", "B0"}, {"e0", "B0"})
        edges += both_ways(i, j, 2, speed, bus=south)
    return nodes, edges, [], ["--crossings.guess", "--walkingareas", "--tls.cycle.time", ("64", "76", "58", "90")[v], "--tls.left-green.time", ("7", "7", "6", "9")[v]]


def quarter(v):
    """Streets without lights: priority road, right before left, all-way stop, a T; one lane a direction, crosswalks at two of them."""
    a, arm = ((150, 130), (175, 120), (135, 140), (190, 125))[v]
    kinds = {"P": "priority", "R": "right_before_left", "S": "allway_stop", "T": "priority"}
    dx, dy = ((0, 0), (0, 0), (-22, 15), (30, 25))[v]
    place = {"P": (0, 0), "R": (a, 0), "S": (a + dx, a + dy), "T": (0, a)}
    nodes = [node(n, x, y, kinds[n]) for n, (x, y) in place.items()]
    ends = {"pw": (-arm, 0, "P"), "ps": (0, -arm, "P"), "rs": (a, -arm, "R"), "re": (a + arm, 0, "R"), "se": (a + dx + arm, a + dy, "S"), "sn": (a + dx, a + dy + arm, "S"), "tn": (0, a + arm, "T")}
    nodes += [node(n, x, y) for n, (x, y, _) in ends.items()]
    edges = []
    for i, j in [(n, j) for n, (_, _, j) in ends.items()] + [("P", "R"), ("R", "S"), ("S", "T"), ("T", "P")]:
        # The street through P from south to north and on over T has the right of way.
        main = {i, j} in ({"ps", "P"}, {"T", "P"}, {"tn", "T"})
        edges += both_ways(i, j, 1, 13.89 if main else 11.11, priority=3 if main else 1, width=3.2)
    return nodes, edges, [], ["--crossings.guess", "--walkingareas"]


def ring(v):
    """A roundabout of two lanes with four arms."""
    radius, arm, lanes = ((24, 200, 2), (20, 180, 2), (28, 190, 2), (22, 210, 2))[v]
    nodes, edges = [], []
    names = "ESWN" if v else "ENWS"
    angle = {n: {"E": 0, "N": 90, "W": 180, "S": 270}[n] + (0, 12, -20, 33)[v] for n in names}
    for n, deg in angle.items():
        c, s = math.cos(math.radians(deg)), math.sin(math.radians(deg))
        nodes += [node("r" + n, round(radius * c, 2), round(radius * s, 2)), node("o" + n, round((radius + arm) * c, 2), round((radius + arm) * s, 2))]
        edges += both_ways("o" + n, "r" + n, lanes, 13.89, sidewalk=False, priority=1)
    order = sorted(angle, key=lambda n: angle[n])
    for i, n in enumerate(order):
        m = order[(i + 1) % 4]
        start, end = angle[n], angle[n] + 90
        shape = " ".join(f"{radius * math.cos(math.radians(d)):.2f},{radius * math.sin(math.radians(d)):.2f}" for d in range(start, end + 1, 10))
        edges.append(f'<edge id="ring{n}" from="r{n}" to="r{m}" numLanes="{lanes}" speed="8.33" priority="3" shape="{shape}"/>')
    edges.append(f'<roundabout nodes="{" ".join("r" + n for n in order)}" edges="{" ".join("ring" + n for n in order)}"/>')
    return nodes, edges, [], []


def motorway(v):
    """Three lanes; an on-ramp with an acceleration lane, an off-ramp from a deceleration lane, then the left... the right lane ends."""
    speed, lane = ((33.33, 240), (30.56, 200), (36.11, 260), (27.78, 220))[v]
    on, off, mid, drop, end = ((500, 1250, 2000, 2500, 3000), (450, 1100, 1750, 2200, 2700), (550, 1350, 2100, 2550, 3050), (400, 1050, 1700, 2250, 2700))[v]
    x = [0, on, on + lane, off, off + lane, mid, drop, end]
    names = ["m0", "on", "onEnd", "off", "offEnd", "mid", "drop", "m9"]
    nodes = [node(n, at, 0) for n, at in zip(names, x)]
    nodes += [node("q0", x[1] - 350, -70), node("q1", x[1] - 90, -12), node("f1", x[4] + 110, -16), node("f9", x[4] + 380, -80)]
    def main(i, j, lanes, extra=""):
        return f'<edge id="{i}_{j}" from="{i}" to="{j}" numLanes="{lanes}" speed="{speed}" priority="5">{extra}</edge>'
    edges = [main("m0", "on", 3),
             main("on", "onEnd", 4, '<lane index="0" acceleration="1"/>'),
             main("onEnd", "off", 3), main("off", "offEnd", 4), main("offEnd", "mid", 3), main("mid", "drop", 3), main("drop", "m9", 2),
             '<edge id="q0_q1" from="q0" to="q1" numLanes="1" speed="22.22" priority="2" type="highway.motorway_link"/>',
             '<edge id="q1_on" from="q1" to="on" numLanes="1" speed="25" priority="2" type="highway.motorway_link"/>',
             '<edge id="offEnd_f1" from="offEnd" to="f1" numLanes="1" speed="22.22" priority="2" type="highway.motorway_link"/>',
             '<edge id="f1_f9" from="f1" to="f9" numLanes="1" speed="16.67" priority="2" type="highway.motorway_link"/>']
    def join(a, b, pairs):
        return [f'<connection from="{a}" to="{b}" fromLane="{i}" toLane="{j}"/>' for i, j in pairs]
    links = [*join("m0_on", "on_onEnd", [(0, 1), (1, 2), (2, 3)]), *join("q1_on", "on_onEnd", [(0, 0)]),
             *join("on_onEnd", "onEnd_off", [(1, 0), (2, 1), (3, 2)]),
             *join("onEnd_off", "off_offEnd", [(0, 1), (1, 2), (2, 3)]),
             *join("off_offEnd", "offEnd_mid", [(1, 0), (2, 1), (3, 2)]), *join("off_offEnd", "offEnd_f1", [(0, 0)]),
             *join("offEnd_mid", "mid_drop", [(0, 0), (1, 1), (2, 2)]), *join("mid_drop", "drop_m9", [(1, 0), (2, 1)])]
    return nodes, edges, links, []


def hills(v):
    """A country road, one lane a direction, over hills and round bends, with a crossroads where a side road waits."""
    grade = (0.06, 0.075, 0.05, 0.068)[v]
    y = (110, 150, 120, 140)[v]
    nodes = [node("h0", 0, 0, z=0), node("h1", 250, 0, z=0), node("h2", 450, 0, z=200 * grade), node("h3", 620, 0, z=200 * grade),
             node("h4", 820, 0, z=0), node("h5", 960, 0, z=0), node("h6", 1200, y, z=0), node("h7", 1420, y, z=0),
             node("h8", 1640, y, z=-220 * grade), node("h9", 1900, y, z=-220 * grade),
             node("s5", 960, -180, z=0), node("n5", 960, 160, z=0)]
    def bend(y):
        r = (35, 28, 32, 30)[v]
        # Two bends of radius r: left by 90 degrees, straight up, right by 90 degrees.
        x0, points = 1080, []
        points += [(x0 + r * math.sin(math.radians(d)), r - r * math.cos(math.radians(d))) for d in range(0, 91, 10)]
        points += [(x0 + r + r - r * math.cos(math.radians(d)), y - r + r * math.sin(math.radians(d))) for d in range(0, 91, 10)]
        return [(960.0, 0.0)] + points + [(1200.0, float(y))]
    points = bend(y)
    there = " ".join(f"{a:.2f},{b:.2f},0" for a, b in points)
    back = " ".join(f"{a:.2f},{b:.2f},0" for a, b in reversed(points))
    edges = []
    for i, j, speed in (("h0", "h1", 22.2), ("h1", "h2", 22.2), ("h2", "h3", 22.2), ("h3", "h4", 16.7), ("h4", "h5", 22.2), ("h6", "h7", 22.2), ("h7", "h8", 13.9), ("h8", "h9", 22.2)):
        edges += both_ways(i, j, 1, speed, sidewalk=False, priority=3, width=3.5)
    edges += [f'<edge id="h5h6" from="h5" to="h6" numLanes="1" speed="9.7" priority="3" width="3.5" shape="{there}"/>',
              f'<edge id="h6h5" from="h6" to="h5" numLanes="1" speed="9.7" priority="3" width="3.5" shape="{back}"/>']
    edges += both_ways("s5", "h5", 1, 13.9, sidewalk=False, priority=1, width=3.3)
    edges += both_ways("n5", "h5", 1, 13.9, sidewalk=False, priority=1, width=3.3)
    return nodes, edges, [], []


NETWORKS = {"city": city, "quarter": quarter, "ring": ring, "motorway": motorway, "hills": hills}
