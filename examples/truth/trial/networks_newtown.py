"""Road networks of the fifteenth held group, of a city that grew fast: a main road with a side road beyond a strip of trees
on each side, at grade; two motorways whose left turns swing around the middle; an interchange all of whose left turns
meet at one light, and a crossing whose left turns change sides before it; a park of shops behind a pair of very small
roundabouts, for traffic on the left.
"""

import math
import xml.etree.ElementTree as ET

from networks import document, edge, link, node, ring, smooth, tool, two_way
from networks_gateway import stations
from networks_outskirts import ahead, closed, lifted
from networks_regional import only


def boxed(row, x, y, heading, before, behind, right, left):
    """A node whose junction is a rectangle along a heading (radians), so far to both ends and sides (m)."""
    ux, uy = math.cos(heading), math.sin(heading)
    corners = ((-before, -right), (behind, -right), (behind, left), (-before, left))
    return row.replace("/>", ' shape="' + " ".join(f"{x + ux * d - uy * s:.2f},{y + uy * d + ux * s:.2f}" for d, s in corners) + '"/>')


def programs(work, options, plans, yellow=3, clear=1):
    """Programs of lights by what has green: `plans` has for a node its offset and phases of (seconds, pairs of roads). Of two
    that cross and have green together, the one that gives way has the lesser green.
    """
    document(work / "con.xml", "connections", plans.pop("links"))
    tool("netconvert", "--node-files", work / "nod.xml", "--edge-files", work / "edg.xml", "--connection-files", work / "con.xml", "--output-file", work / "draft.xml",
         "--offset.disable-normalization", *(o for o in options if o != "as drawn"))
    net, rows = ET.parse(work / "draft.xml").getroot(), []
    after = {f'{c.get("from")}_{c.get("fromLane")}': c.get("via") for c in net.iter("connection") if c.get("from").startswith(":") and c.get("via")}
    for n, (offset, phases) in plans.items():
        links = {int(c.get("linkIndex")): c for c in net.iter("connection") if c.get("tl") == n}
        inside = next(j for j in net.iter("junction") if j.get("id") == n)
        place = {lane: i for i, lane in enumerate(inside.get("intLanes").split())}
        gives = {int(r.get("index")): {i for i, bit in enumerate(reversed(r.get("response"))) if bit == "1"} for r in inside.iter("request")}
        # A junction's table names the last inner lane of a link.
        at = {i: place[last_lane(after, c.get("via"))] for i, c in links.items()}
        opened = [(seconds, {i for i, c in links.items() if (c.get("from").split(".")[0], c.get("to")) in pairs}) for seconds, pairs in phases]
        unused = set(links) - set().union(*(those for _, those in opened))
        assert not unused, (n, [(links[i].get("from"), links[i].get("to")) for i in unused])
        states = []
        for (seconds, those), (_, later) in zip(opened, opened[1:] + opened[:1]):
            weak = {i for i in those if any(at[j] in gives[at[i]] for j in those)}
            show = lambda last: "".join("r" if i not in those else last if last and i not in later else "g" if i in weak else "G" for i in range(max(links) + 1))
            states += [(seconds, show("")), (yellow, show("y")), (clear, show("r"))]
        rows.append(f'<tlLogic id="{n}" type="static" programID="plan" offset="{offset}">' + "".join(f'<phase duration="{d}" state="{s}"/>' for d, s in states) + "</tlLogic>")
    document(work / "plans.add.xml", "additional", rows)


def last_lane(after, lane):
    while lane in after:
        lane = after[lane]
    return lane


def ease(t):
    t = min(1, max(0, t))
    return t * t * (3 - 2 * t)


def sideroads(work, draw):
    """A main road of three lanes in each direction with a median, and right of it, beyond a strip of trees, a side road of
    two, which buses use, and into which streets lead where one only turns right. Openings lead from one to the other.
    At two lights the main road turns left and round, the side road right; cross streets turn left into the main road
    and right into the side road.
    """
    main, side, opening, cross, back = "highway.primary", "highway.secondary", "highway.primary_link", "highway.secondary", "highway.residential"
    fast, town = 19.44, 13.89
    y = lambda x: 16 * math.sin(x / 310)
    jolt = lambda: draw.uniform(-10, 10)
    cx = {"a": -330 + jolt(), "b": 325 + jolt()}
    nodes, edges, links = [], [], []
    for n, s in cx.items():
        nodes.append(boxed(node(n, s, y(s), "traffic_light"), s, y(s), math.atan((y(s + 5) - y(s - 5)) / 10), 17, 17, 32, 32))
    plans = {n: (k, [(28, set()), (12, set()), (17, set()), (10, set())]) for n, k in (("a", 0), ("b", 31))}
    green = lambda n, phase, *pairs: plans[n][1][phase][1].update(pairs)
    arms = {n: {} for n in cx}

    def carriage(m, s, sign, first, second):
        """Both roads of one direction; places are meters along it, and to the right of the middle."""
        at = lambda d, off: (sign * d, y(sign * d) - sign * off)
        f, g = sign * cx[first], sign * cx[second]
        places = {first: f, second: g, m + "w": -1000, m + "d": f - 285, m + "o": f - 205, m + "i": f + 135, m + "k": f + 225, m + "p": g - 215, m + "j": g + 130, m + "z": 1000,
                  s + "w": -1000, s + "o": f - 130, s + "i": f + 62, s + "t": (f + g) / 2 + jolt() + 10, s + "p": g - 138, s + "j": g + 62, s + "z": 1000}
        reach = {first: (17, 17), second: (17, 17), m + "o": (2, 22), m + "p": (2, 22), m + "i": (22, 2), m + "j": (22, 2), s + "o": (22, 2), s + "p": (22, 2), s + "i": (2, 22), s + "j": (2, 22), s + "t": (9, 9)}
        wide = {m + "o": (13, 0.2), m + "p": (13, 0.2), m + "i": (13, 0.2), m + "j": (13, 0.2), s + "o": (6.6, 3.4), s + "p": (6.6, 3.4), s + "i": (6.6, 3.4), s + "j": (6.6, 3.4)}
        for n, d in places.items():
            if n in cx:
                continue
            off = 3 if n[0] == m else 22
            (px, py), heading = at(d, off), math.atan((y(sign * d + 5) - y(sign * d - 5)) / 10) + (math.pi if sign < 0 else 0)
            row = node(n, px, py)
            nodes.append(boxed(row, px, py, heading, *reach[n], *wide[n]) if n in wide else row)

        def piece(a, b, lanes, limit, kind, off, bay=0):
            line = [at(d, o) for d, o in stations(places[a] + reach.get(a, (0, 2))[1], places[b] - reach.get(b, (2, 0))[0], lambda _: off - 3.2 * bool(bay))]
            row = edge(a + b, a, b, lanes, limit, kind, 9 if kind == main else 7, line, bay)
            edges.append(closed(row, "bicycle") if kind == main else row)

        for a, b, lanes, bay in (("w", "d", 3, 0), ("d", "o", 4, 0), ("o", first, 3, 85), (first, "i", 3, 0), ("i", "k", 4, 0), ("k", "p", 3, 0), ("p", second, 3, 85), (second, "j", 3, 0), ("j", "z", 4, 0)):
            piece(a if a in cx else m + a, b if b in cx else m + b, lanes, fast, main, 3, bay)
        # The third lane of a side road lies left of the others.
        for a, b, lanes in (("w", "o", 2), ("o", first, 3), (first, "i", 2), ("i", "t", 2), ("t", "p", 2), ("p", second, 3), (second, "j", 2), ("j", "z", 2)):
            piece(a if a in cx else s + a, b if b in cx else s + b, lanes, town, side, 22 - 3.2 * (lanes - 2))
        for a, b, down in ((m + "o", s + "o", True), (s + "i", m + "i", False), (m + "p", s + "p", True), (s + "j", m + "j", False)):
            lo, hi = places[a] + 22, places[b] - 22
            between = lambda t: 12.6 + 6.2 * ease(t if down else 1 - t)
            edges.append(closed(edge(a + b, a, b, 1, 13.89, opening, 6, [at(lo + (hi - lo) * t / 6, between(t / 6)) for t in range(7)]), "bicycle"))
        bays = lambda x: x + ".-85"
        links.extend(ahead(m + "w" + m + "d", m + "d" + m + "o", (0, 1), (1, 2), (2, 3)) + ahead(m + "d" + m + "o", m + "o" + first, (1, 0), (2, 1), (3, 2)) + ahead(m + "d" + m + "o", m + "o" + s + "o", (0, 0)))
        links.extend(ahead(first + m + "i", m + "i" + m + "k", (0, 1), (1, 2), (2, 3)) + ahead(s + "i" + m + "i", m + "i" + m + "k", (0, 0)) + ahead(m + "i" + m + "k", m + "k" + m + "p", (1, 0), (2, 1), (3, 2)))
        links.extend(ahead(m + "k" + m + "p", m + "p" + second, (0, 0), (1, 1), (2, 2)) + ahead(m + "k" + m + "p", m + "p" + s + "p", (0, 0)) + ahead(second + m + "j", m + "j" + m + "z", (0, 1), (1, 2), (2, 3)) + ahead(s + "j" + m + "j", m + "j" + m + "z", (0, 0)))
        for before, on, out, n in (("w", "o", "i", first), ("t", "p", "j", second)):
            links.extend(ahead(s + before + s + on, s + on + n, (0, 0), (1, 1)) + ahead(m + ("o" if on == "o" else "p") + s + on, s + on + n, (0, 2)))
            links.extend(ahead(s + on + n, n + s + out, (1, 0), (2, 1)))
            links.extend(ahead(n + s + out, s + out + (s + "t" if out == "i" else s + "z"), (0, 0), (1, 1)) + ahead(n + s + out, s + out + m + out, (1, 0)))
            came = m + on + n
            links.extend(ahead(bays(came), n + m + out, (0, 0), (1, 1), (2, 2)))
            green(n, 0, (came, n + m + out), (s + on + n, n + s + out))
            arms[n][sign] = (came, s + on + n, n + m + out, n + s + out)

    carriage("m", "s", 1, "a", "b")
    carriage("n", "t", -1, "b", "a")
    for n, x in cx.items():
        nodes += [node(f"{n}q", x + jolt(), y(x) + 245), node(f"{n}z", x + jolt(), y(x) - 240, "allway_stop" if n == "b" else "priority"), node(f"{n}r", x + 15, 400), node(f"{n}y", x - 10, -395)]
        two_way(edges, f"{n}q", n, 2, town, cross, 7, bays=(70, 0))
        two_way(edges, f"{n}z", n, 2, town, cross, 7, bays=(70, 0))
        two_way(edges, f"{n}r", f"{n}q", 1, town, cross, 6)
        two_way(edges, f"{n}y", f"{n}z", 1, town, cross, 6)
        for end, other, to_right, to_left in (("q", "z", -1, 1), ("z", "q", 1, -1)):
            came, on = f"{n}{end}{n}", f"{n}{n}{other}"
            links += ahead(came + ".-70", on, (0, 0), (1, 1)) + ahead(came + ".-70", arms[n][to_right][3], (0, 0)) + ahead(came + ".-70", arms[n][to_left][2], (2, 2))
            green(n, 2, (came, on), (came, arms[n][to_right][3]))
            green(n, 1, (came, arms[n][to_right][3]))
            green(n, 3, (came, arms[n][to_left][2]))
        for sign, (came, beside, _, _) in arms[n].items():
            left, right, round_ = (f"{n}{n}q", f"{n}{n}z", arms[n][-sign][2]) if sign > 0 else (f"{n}{n}z", f"{n}{n}q", arms[n][-sign][2])
            links += ahead(came + ".-85", left, (3, 1)) + ahead(came + ".-85", round_, (3, 1)) + ahead(beside, right, (0, 0))
            green(n, 1, (came, left), (came, round_))
            green(n, 0, (beside, right))
            green(n, 3, (beside, right))
    for at, end, x, py, ways in (("st", "sv", 15 + jolt(), -228, ("az", "bz")), ("tt", "tv", -20 + jolt(), 232, ("bq",))):
        nodes.append(node(end, x, py, "right_before_left"))
        two_way(edges, end, at, 1, 11.11, back, 4)
        for w in ways:
            two_way(edges, w, end, 1, 11.11, back, 4)
    nodes.append(node("tvv", -60, 385))
    two_way(edges, "tvv", "tv", 1, 11.11, back, 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    options = ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 10]
    programs(work, options, {"links": links, **plans}, 3, 2)
    halt = lambda road, a: f'<stop lane="{road}_0" startPos="{a}" endPos="{a + 16}" duration="{draw.randint(9, 16)}"/>'
    (work / "parked.txt").write_text("\n".join([
        f'<flow id="east" type="coach" begin="0" period="62" number="4" from="swso" to="sjsz" departLane="best">{halt("sist", 40)}{halt("sjsz", 60)}</flow>', f'<flow id="west" type="coach" begin="0" period="68" number="4" from="twto" to="tjtz" departLane="best">{halt("twto", 300)}{halt("titt", 50)}</flow>',
        *(f'<flow id="day{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "mwmd", "mjmz", 11), ("car", "nwnd", "njnz", 12), ("car", "mwmd", "azay", 37), ("car", "mwmd", "bqbr", 31), ("van", "nwnd", "azay", 41), ("car", "swso", "mjmz", 23), ("car", "twto", "njnz", 27), ("truck", "mwmd", "mjmz", 43), ("car", "mwmd", "njnz", 47), ("car", "araq", "njnz", 33),
            ("car", "bybz", "mjmz", 39), ("car", "araq", "azay", 35), ("truck", "nwnd", "bzby", 59), ("car", "nwnd", "mjmz", 53))))]))
    return options


def turbine(work, draw):
    """Two motorways. Who turns left leaves on the right and swings around the middle, over one motorway and under the
    other; in each quadrant right turns have a ramp of their own. Exits with a lane of their own, of two lanes of which one
    also goes on, by which a lane is lost, and without a lane; entries by a lane that ends, by two of which one ends, and by one
    that stays; ramps that join by turns, or give way.
    """
    main, ramp, width = "motorway", "motorway_link", 3.2
    jolt = lambda: draw.uniform(-14, 14)
    nodes, edges, links = [], [], []
    limits = {0: 33.33, 1: 27.78, 2: 33.33, 3: 27.78}
    # Lanes from station to station, and of the ramps.
    lanes = {0: (3, 4, 3, 4, 3), 1: (2, 3, 2, 4, 3), 2: (3, 4, 2, 3, 3), 3: (2, 2, 2, 3, 2)}
    off, on = {0: 1, 1: 2, 2: 2, 3: 1}, {0: 1, 1: 2, 2: 1, 3: 1}
    level = lambda d, u: 7 * ease((430 - abs(u)) / 230) if d % 2 else 0.0
    turned = lambda d, u, v, z=None: (u * (c := (1, 0, -1, 0)[d]) - v * (s := (0, 1, 0, -1)[d]), u * s + v * c, *(() if z is None else (z,)))
    heading = lambda d: d * math.pi / 2
    spots = {d: {"a": -1350, "b": -840 + jolt(), "c": -610 + jolt(), "e": 590 + jolt(), "g": 850 + jolt(), "h": 1350} for d in range(4)}

    def slip(name, a, b, count, limit, points):
        edges.append(edge(name, a, b, count, limit, ramp, 8, smooth([points[0], *points, points[-1]], 5)))

    for d in range(4):
        at = spots[d]
        for s, u in at.items():
            px, py, z = turned(d, u, -4, level(d, u))
            row = lifted(f"{s}{d}", px, py, z)
            reach = {"c": (2, 26), "e": (26, 2)}.get(s)
            nodes.append(boxed(row, px, py, heading(d), *reach, 3.2 * max(lanes[d]) + 3.6, 0.2) if reach else row)
        for i, (s, t) in enumerate(zip("abceg", "bcegh")):
            lo, hi = at[s] + (26 if s == "c" else 2), at[t] - (26 if t == "e" else 2)
            edges.append(edge(f"m{d}{s}", f"{s}{d}", f"{t}{d}", lanes[d][i], limits[d], main, 13, [turned(d, u, -4, level(d, u)) for u, _ in stations(lo, hi, lambda u: u, 40)]))
        m = lambda s: f"m{d}{s}"
        for i, (s, t) in enumerate((("a", "b"), ("b", "c"), ("c", "e"), ("e", "g"))):
            have, next_ = lanes[d][i], lanes[d][i + 1]
            links.extend(ahead(m(s), m(t), *((k, k + next_ - have) for k in range(have) if k + next_ - have >= 0)))
        # The exit: `off` lanes on the right; of the last one may go on, too.
        links.extend(ahead(m("b"), f"off{d}", *((k, k) for k in range(off[d]))))
        links.extend(ahead(f"on{d}", m("e"), *((k, k) for k in range(on[d]))))
        v = -4 - width * lanes[d][2]
        w = -4 - width * (lanes[d][3] - on[d])
        c, e = at["c"], at["e"]
        rise = 2.6 if d % 2 else 0.0
        nodes.append(lifted(f"f{d}", *turned(d, -400, -44), rise))
        slip(f"off{d}", f"c{d}", f"f{d}", off[d], 22.22, [turned(d, *p) for p in ((c + 26, v, 0.0), (c + 55, v - 1.2, 0.0), (c + 100, v - 7, 0.0), (c + 150, v - 18, rise * 0.6), (-402, -44, rise))])
        row = lifted(f"j{d}", *turned(d, 400, -44), 0.5, "priority" if d == 1 else "zipper")
        # By turns, over 40 m.
        nodes.append(row if d == 1 else boxed(row, *turned(d, 400, -44), heading(d), 20, 20, 6.8, 0.4))
        begin = 402 if d == 1 else 420
        slip(f"on{d}", f"j{d}", f"e{d}", on[d], 22.22, [turned(d, begin + (e - 26 - begin) * k / 6, -44 + (w + 44) * ease(k / 6), 0.5 - k / 12) for k in range(7)])
        links.extend(ahead(f"off{d}", f"left{d}", (off[d] - 1, 0)) + ahead(f"off{d}", f"right{d}", (0, 0)))
        # Those from west and east pass below the other motorway first, those from south and north above it.
        heights = (1.2, 2, 5.2, 7.2, 8, 7.4, 4.6, 1.2, 0.6, 0.5, 0.5, 0.5, 0.5) if d % 2 else (0, 0, 0, 0, 0, 0.4, 2.8, 6.8, 6.8, 4.4, 1.6, 0.6, 0.5)
        way = ((-398, -44), (-300, -50), (-200, -80), (-100, -130), (0, -158), (90, -140), (160, -85), (196, 0), (192, 90), (130, 200), (72, 300), (49, 360), (44, 398 if d == 0 else 381))
        slip(f"left{d}", f"f{d}", f"j{(d + 1) % 4}", 1, 18.06, [turned(d, *p, max(h, rise) if i < 2 else h) for i, (p, h) in enumerate(zip(way, heights))])
        bend = ((-398, -47.2), (-340, -64), (-270, -126), (-205, -205), (-126, -270), (-64, -340), (-47.2, -398 if d == 2 else -379))
        slip(f"right{d}", f"f{d}", f"j{(d - 1) % 4}", 1, 15.28, [turned(d, *p, rise + (0.5 - rise) * i / 6) for i, p in enumerate(bend)])
        links.extend(ahead(f"left{(d - 1) % 4}", f"on{d}", (0, on[d] - 1)) + ahead(f"right{(d + 1) % 4}", f"on{d}", (0, 0)))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join(f'<flow id="haul{i}" type="{kind}" begin="0" period="{p}" number="{int(220 / p)}" from="m{a}a" to="m{b}g" departLane="random" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("truck", 0, 0, 23), ("truck", 2, 2, 19), ("truck", 1, 1, 29), ("car", 0, 1, 27), ("car", 2, 1, 17), ("car", 1, 0, 19), ("car", 3, 0, 15), ("truck", 0, 3, 43), ("car", 1, 2, 21), ("car", 2, 3, 23), ("truck", 3, 2, 47), ("car", 3, 3, 9), ("car", 1, 1, 11)))))
    return ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5]


def singlepoint(work, draw):
    """A road north over a motorway: all who turn left between the two meet at one large light on the bridge, right turns
    have ramps of their own. South of it a crossing before which who turns left from the road changes sides at a light,
    and then turns left beside the oncoming traffic together with who drives straight on. North of it a
    roundabout of two lanes.
    """
    main, ramp, road, cross, street = "motorway", "motorway_link", "primary", "secondary", "tertiary"
    fast, limit, high = 30.56, 18.06, 6.5
    jolt = lambda: draw.uniform(-12, 12)
    lift = lambda v: high * ease((330 - abs(v)) / 190)
    half, bay = 4, 3.2
    d = -585 + jolt()
    nodes, edges, links = [], [], []
    north = math.pi / 2
    place = {"z": -1080, "k1": d - 180, "x1": d - 122, "d": d, "x2": d + 122, "k2": d + 180, "r1": -255, "r2": -150, "l1": 150, "l2": 255, "ra": -140, "la": 140, "p": 0, "o3": 404}
    # Which direction's left edge a node lies on.
    way = {"k1": 1, "k2": -1, "r1": -1, "r2": -1, "l1": 1, "l2": 1, "ra": 1, "la": -1}
    slope = 0.38
    for n, v in place.items():
        if n == "o3":
            continue
        row = lifted(n, half * way.get(n, 0), v, lift(v), "traffic_light" if n in ("d", "p", "x1", "x2") else "priority")
        size = {"p": (25, 25, 33, 33), "d": (17, 17, 31, 31), "ra": (2, 22, 11, 0.2), "la": (22, 2, 0.2, 11), "r2": (2, 22, 0.2, 11), "l1": (22, 2, 11, 0.2)}.get(n)
        if n in ("x1", "x2"):
            # As long as the lane needs to cross the two of the other direction.
            side = -1 if n == "x1" else 1
            size = (15, 15, 3.6 if side < 0 else 12.6 + 3.2, 12.6 + 3.2 if side < 0 else 3.6)
            nodes.append(boxed(row, 0, v, north, *size))
        else:
            nodes.append(boxed(row, half * way.get(n, 0), v, north, *size) if size else row)
    trim = {"p": (25, 25), "d": (17, 17), "x1": (15, 15), "x2": (15, 15), "ra": (2, 22), "la": (22, 2), "r2": (2, 22), "l1": (22, 2), "z": (0, 0), "o3": (4, 4)}

    def along(name, a, b, lanes, bays=0, speed=limit):
        """A piece of the road; `trim` is southwards and northwards of a node."""
        sign = 1 if place[b] > place[a] else -1
        cut = lambda n, to: trim.get(n, (2, 2))[1 if to > 0 else 0]
        first, last = place[a] + sign * cut(a, sign), place[b] - sign * cut(b, -sign)
        edges.append(closed(edge(name, a, b, lanes, speed, road, 9, [(sign * (half - bay * bool(bays)), v, lift(v)) for v, _ in stations(first, last, lambda v: v, 12)], bays), "bicycle"))

    for name, a, b, lanes, bays in (("n0", "z", "k1", 2, 75), ("n1", "k1", "d", 2, 0), ("n2", "d", "x2", 2, 0), ("n3", "x2", "ra", 2, 0), ("n4", "ra", "p", 2, 80), ("n5", "p", "l1", 2, 0), ("n6", "l1", "l2", 3, 0), ("n7", "l2", "o3", 2, 0),
                                    ("s0", "o3", "la", 2, 0), ("s1", "la", "p", 2, 80), ("s2", "p", "r2", 2, 0), ("s3", "r2", "r1", 3, 0), ("s4", "r1", "k2", 2, 75), ("s5", "k2", "d", 2, 0), ("s6", "d", "x1", 2, 0), ("s7", "x1", "z", 2, 0)):
        along(name, a, b, lanes, bays)
    for tag, n, k, sign in (("1", "x1", "k1", 1), ("2", "x2", "k2", -1)):
        v = place[n]
        # Left edges seen in the direction of travel.
        line = lambda *points: [(sign * off, v + sign * along_, lift(v)) for off, along_ in points]
        edges.append(closed(edge("t" + tag, k, n, 1, 13.89, road, 8, smooth(line((0.8, -70), (0.8, -56), (0.8, -44), (0.3, -33), (-1.3, -23), (-8.8 + 15 * slope, -15), (-8.8 + 7 * slope, -7)), 3)), "bicycle"))
        edges.append(closed(edge("u" + tag, n, "d", 1, 13.89, road, 8, [*smooth(line((-8.8 - 7 * slope, 7), (-8.8 - 15 * slope, 15), (-16.4, 23), (-17.9, 32), (-18.4, 42), (-18.4, 52), (-18.4, 62)), 3), *line((-18.4, 105))]), "bicycle"))
    # The motorway.
    x = {"e1": -640 + jolt(), "e2": -430, "e3": 430, "e4": 660 + jolt(), "w1": 640 + jolt(), "w2": 430, "w3": -430, "w4": -670 + jolt(), "e0": -1250, "e5": 1250, "w0": 1250, "w5": -1250}
    bow = lambda s: 34 * math.cos(s / 900) - 34
    for tag, sign, parts in (("E", 1, (("e0", 3), ("e1", 4), ("e2", 3), ("e3", 4), ("e4", 3), ("e5", 0))), ("W", -1, (("w0", 3), ("w1", 5), ("w2", 3), ("w3", 4), ("w4", 3), ("w5", 0)))):
        for n, _ in parts:
            row, px, py = lifted(n, x[n], bow(x[n]) - sign * 4, 0), x[n], bow(x[n]) - sign * 4
            reach = {"2": (2, 26), "3": (26, 2)}.get(n[1])
            nodes.append(boxed(row, px, py, math.atan(-34 / 900 * math.sin(px / 900)) + (math.pi if sign < 0 else 0), *reach, 16.6, 0.2) if reach else row)
        for i, ((a, lanes), (b, _)) in enumerate(zip(parts, parts[1:])):
            lo, hi = x[a] + sign * (26 if a[1] == "2" else 2), x[b] - sign * (26 if b[1] == "3" else 2)
            edges.append(edge(f"{tag}{i}", a, b, lanes, fast, main, 13, [(px, bow(px) - sign * 4, 0) for px, _ in stations(lo, hi, lambda v: v, 50)]))
        wide = parts[1][1]
        links += ahead(f"{tag}0", f"{tag}1", *((k, k + wide - 3) for k in range(3))) + ahead(f"{tag}1", f"{tag}2", *((k + wide - 3, k) for k in range(3))) + ahead(f"{tag}2", f"{tag}3", (0, 1), (1, 2), (2, 3)) + ahead(f"{tag}3", f"{tag}4", (1, 0), (2, 1), (3, 2))
    # Ramps: eastwards as drawn, westwards turned round.
    h = high
    for tag, sign, lefts in (("E", 1, 1), ("W", -1, 2)):
        base = lambda px, more, z: (sign * px, bow(px) - sign * (13.6 + more), z)

        def slip(name, a, b, lanes, speed, points):
            edges.append(edge(name, a, b, lanes, speed, ramp, 8, smooth([points[0], *points, points[-1]], 5)))

        fork, join = f"f{tag}", f"j{tag}"
        nodes.append(lifted(fork, sign * -165, sign * -31, 5.2))
        nodes.append(lifted(join, sign * 165, sign * -31, 5.2))
        slip(f"off{tag}", f"{tag.lower()}2", fork, lefts, 22.22, [base(-404, 0, 0), base(-370, 1.4, 0.3), base(-320, 7, 1.2), (sign * -250, sign * -29, 3), (sign * -167, sign * -31, 5.2)])
        # To the light, and before it off to the right.
        slip(f"mid{tag}", fork, "p", lefts, 13.89, [(sign * px, sign * py, z) for px, py, z in ((-162, -31, 5.3), (-120, -27, 6.2), (-80, -20, h), (-55, -15.4, h), (-33, -13, h))])
        slip(f"right{tag}", fork, "r2" if sign > 0 else "l1", 1, 12.5, [(sign * px, sign * py, lift(py) if px > -40 else z) for px, py, z in ((-162, -31 - 3.2 * lefts, 5.3), (-115, -40, 5.8), (-74, -55, 6), (-43, -77, 6.2), (-23, -100, 6), (-13, -117, 6), (-10.4, -128, 6))])
        # Behind the light, and from the road off to the right.
        slip(f"go{tag}", "p", join, 1, 13.89, [(sign * px, sign * py, z) for px, py, z in ((33, -13, h), (55, -15.4, h), (80, -20, h), (120, -27, 6.2), (162, -31, 5.3))])
        slip(f"turn{tag}", "ra" if sign > 0 else "la", join, 1, 12.5, [(sign * px, sign * py, lift(py) if px < 20 else z) for px, py, z in ((10.4, -118, 6), (12.4, -108, 6), (22, -88, 6.2), (44, -62, 6), (78, -45, 5.8), (118, -37, 5.6), (162, -34.2, 5.3))])
        ends = [(sign * 168, sign * -31, 5.1), (sign * 250, sign * -28, 3), base(320, 7, 1.2), base(370, 1.4, 0.3), base(404, 0, 0)]
        slip(f"on{tag}", join, f"{tag.lower()}3", 1, 22.22, ends)
        links += ahead(f"{tag}1", f"off{tag}", *((k, k) for k in range(lefts))) + ahead(f"off{tag}", f"right{tag}", (0, 0)) + ahead(f"off{tag}", f"mid{tag}", *((k, k) for k in range(lefts)))
        links += ahead(f"go{tag}", f"on{tag}", (0, 0)) + ahead(f"turn{tag}", f"on{tag}", (0, 0)) + ahead(f"on{tag}", f"{tag}3", (0, 0))
    # Along the road.
    links += ahead("n0.-75", "n1", (0, 0), (1, 1)) + ahead("n0.-75", "t1", (2, 0)) + ahead("s4.-75", "s5", (0, 0), (1, 1)) + ahead("s4.-75", "t2", (2, 0)) + ahead("t1", "u1", (0, 0)) + ahead("t2", "u2", (0, 0)) + ahead("n2", "n3", (0, 0), (1, 1)) + ahead("s6", "s7", (0, 0), (1, 1))
    links += ahead("n3", "n4", (0, 0), (1, 1)) + ahead("n3", "turnE", (0, 0)) + ahead("s0", "s1", (0, 0), (1, 1)) + ahead("s0", "turnW", (0, 0))
    links += ahead("n4.-80", "n5", (0, 0), (1, 1)) + ahead("n4.-80", "goW", (2, 0)) + ahead("s1.-80", "s2", (0, 0), (1, 1)) + ahead("s1.-80", "goE", (2, 0)) + ahead("midE", "n5", (0, 1)) + ahead("midW", "s2", (0, 0), (1, 1))
    links += ahead("n5", "n6", (0, 1), (1, 2)) + ahead("rightW", "n6", (0, 0)) + ahead("n6", "n7", (1, 0), (2, 1)) + ahead("s2", "s3", (0, 1), (1, 2)) + ahead("rightE", "s3", (0, 0)) + ahead("s3", "s4", (1, 0), (2, 1))
    # The crossing.
    spots = {"dw": (-225, d + 6), "dww": (-470, d + 20), "de": (215, d - 8), "dee": (480, d - 25), "vw": (-240, d - 190), "ve": (205, d + 170)}
    nodes += [node(n, *p, {"de": "allway_stop", "dw": "priority"}.get(n, "priority")) for n, p in spots.items()]
    two_way(edges, "dw", "d", 2, 13.89, cross, 7, bays=(60, 0))
    two_way(edges, "de", "d", 2, 13.89, cross, 7, bays=(60, 0))
    for a, b in (("dww", "dw"), ("dee", "de")):
        two_way(edges, a, b, 1, 13.89, cross, 6)
    for a, b in (("vw", "dw"), ("ve", "de")):
        two_way(edges, a, b, 1, 11.11, street, 4)
    links += ahead("n1", "n2", (0, 0), (1, 1)) + ahead("n1", "dde", (0, 0)) + ahead("s5", "s6", (0, 0), (1, 1)) + ahead("s5", "ddw", (0, 0)) + ahead("u1", "ddw", (0, 1)) + ahead("u2", "dde", (0, 1))
    for a, on, right, left in (("dwd", "dde", "s6", "n2"), ("ded", "ddw", "n2", "s6")):
        links += ahead(a + ".-60", on, (0, 0), (1, 1)) + ahead(a + ".-60", right, (0, 0)) + ahead(a + ".-60", left, (2, 1))
    # The roundabout.
    ring(edges, nodes, "o", 0, 430, 26, 2, [0, 92, 184, 270], 9.5)
    rim = {"oe": (270, 445), "on": (-12, 690), "ow": (-265, 415), "or": (150, 610)}
    nodes += [node(n, *p) for n, p in rim.items()]
    for n, o, lanes in (("oe", "o0", 2), ("on", "o1", 1), ("ow", "o2", 1)):
        two_way(edges, n, o, lanes, 13.89, cross, 6)
    two_way(edges, "or", "oe", 1, 11.11, street, 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    options = ["as drawn", "--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 12]
    through, ew, lefts = {("n1", "n2"), ("n1", "dde"), ("s5", "s6"), ("s5", "ddw"), ("u1", "ddw"), ("u2", "dde")}, {("dwd", "dde"), ("dwd", "s6"), ("ded", "ddw"), ("ded", "n2")}, {("dwd", "n2"), ("ded", "s6")}
    programs(work, options, {"links": links, "d": (0, [(30, through), (16, ew), (10, lefts)]), "x1": (6, [(32, {("s6", "s7")}), (28, {("t1", "u1")})]), "x2": (6, [(32, {("n2", "n3")}), (28, {("t2", "u2")})]),
                             "p": (20, [(26, {("n4", "n5"), ("s1", "s2")}), (12, {("n4", "goW"), ("s1", "goE")}), (16, {("midE", "n5"), ("midW", "s2")})])}, 4, 1)
    (work / "parked.txt").write_text("\n".join(f'<flow id="way{i}" type="{kind}" begin="0" period="{p}" number="{int(240 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "E0", "n7", 17), ("car", "E0", "s7", 23), ("car", "W0", "s7", 17), ("van", "W0", "o0oe", 29), ("car", "n0", "W4", 25), ("car", "n0", "ddw", 21), ("car", "n0", "E4", 31), ("car", "ono1", "E4", 27), ("truck", "owo2", "W4", 53), ("car", "oeo0", "s7", 23), ("car", "oeo0", "dde", 37),
        ("car", "dwwdw", "dedee", 29), ("car", "deede", "n7", 31), ("car", "dwwdw", "s7", 43), ("truck", "E0", "E4", 19), ("truck", "W0", "W4", 21), ("car", "E0", "E4", 11), ("car", "W0", "W4", 12), ("van", "n0", "o1on", 33)))))
    return options


def retail(work, draw):
    """Traffic on the left, 20 to 50 km/h. A street with two very small roundabouts 40 m apart, a crossing for people, two
    lights and a filling station; from one of the roundabouts and one of the lights one drives to a park of shops: a road around
    car parks with aisles in both directions or one, crossings in front of the shops, a corner at which all stop, courts
    and a yard, a way past a window at which one is served, an exit by which one only turns left. North of the street a
    quarter where who comes from the right goes first.
    """
    main, lane, street = "highway.secondary", "highway.service", "highway.residential"
    jolt = lambda: draw.uniform(-5, 5)
    nodes, edges, links = [], [], []
    ax, bx = -330 + jolt(), 318 + jolt()
    place = {"w": (-620, 12), "a": (ax, 4), "v": (-195, 1), "o": (92, -5), "b": (bx, -4), "g2": (430, -2), "g1": (505, 0), "e": (690, 8), "ga": (492, -32), "gb": (436, -33),
             "r1": (-40, -95), "n1": (5 + jolt(), -97), "n2": (46, -98), "r2": (92, -99), "n3": (138 + jolt(), -101), "n4": (184, -102), "r3": (240, -104), "r4": (246, -208), "s4": (190, -211), "c2": (164, -212), "s3": (136, -213), "r5": (98, -214), "c1": (72, -214), "s2": (46, -213), "s1": (3, -212), "r6": (-46, -210),
             "k1": (-142, -220), "k2": (340, -222), "k3": (-132, -108), "k4": (108, -312), "d1": (-62, -262), "d2": (-28, -274), "h0": (-338, 128), "h1": (-66, 130), "h2": (312, 138), "h3": (120, 122), "ho": (-350, 290), "hp": (-52, 285), "hq": (330, 300), "hr": (128, 288), "z0": (-322, -130), "z1": (-318, -290), "hw": (-540, 150)}
    # For traffic on the left netconvert turns the name around: who comes from the right goes first.
    kinds = {"a": "traffic_light", "b": "traffic_light", "r5": "allway_stop", "r2": "allway_stop", "h0": "left_before_right", "h1": "left_before_right", "h2": "left_before_right", "h3": "left_before_right"}
    nodes += [node(n, *xy, kinds.get(n, "priority")) for n, xy in place.items()]
    # The roundabouts run clockwise; a row is an arm's end and angle.
    for n, cx, cy, angles in (("p", -76, 2, (180, 84, -9)), ("q", -34, -5, (171, 3, -96))):
        spot = lambda deg: (cx + 9 * math.cos(math.radians(deg)), cy + 9 * math.sin(math.radians(deg)))
        for i, deg in enumerate(angles):
            nodes.append(node(f"{n}{i}", *spot(deg)).replace("/>", ' radius="4"/>'))
            sweep = (deg - angles[(i + 1) % 3]) % 360
            edges.append(edge(f"{n}r{i}", f"{n}{i}", f"{n}{(i + 1) % 3}", 1, 6.5, main, 9, [spot(deg - sweep * t / 6) for t in range(7)]))
        edges.append(f'<roundabout nodes="{n}0 {n}1 {n}2" edges="{n}r0 {n}r1 {n}r2"/>')
    for a, b, limit, bays in (("w", "a", 13.89, (50, 0)), ("a", "v", 13.89, (0, 45)), ("v", "p0", 13.89, (0, 0)), ("p2", "q0", 8.33, (0, 0)), ("q1", "o", 13.89, (0, 0)), ("o", "b", 13.89, (45, 0)), ("b", "g2", 13.89, (0, 50)), ("g2", "g1", 13.89, (0, 0)), ("g1", "e", 13.89, (0, 0))):
        two_way(edges, a, b, 1, limit, main, 7, bays=bays)
    for a, b, limit in (("h0", "a", 11.11), ("z0", "a", 11.11), ("z1", "z0", 11.11), ("h1", "p1", 8.33), ("h2", "b", 11.11), ("h0", "h1", 8.33), ("h1", "h3", 8.33), ("h3", "h2", 8.33), ("ho", "h0", 8.33), ("hp", "h1", 8.33), ("hq", "h2", 8.33), ("hr", "h3", 8.33), ("hw", "h0", 8.33)):
        two_way(edges, a, b, 1, limit, street, 4)
    # The park of shops.
    two_way(edges, "q2", "r1", 1, 8.33, lane, 5, shape=[(-37, -40)])
    two_way(edges, "r3", "b", 1, 8.33, lane, 5, shape=smooth([place["r3"], (270, -102), (292, -95), (307, -80), (bx - 4, -60), place["b"]], 4))
    edges.append(edge("r2o", "r2", "o", 1, 8.33, lane, 4))
    links += ahead("r2o", "oq1", (0, 0))
    around = ["r1", "n1", "n2", "r2", "n3", "n4", "r3", "r4", "s4", "c2", "s3", "r5", "c1", "s2", "s1", "r6", "r1"]
    for a, b in zip(around, around[1:]):
        two_way(edges, a, b, 1, 8.33, lane, 4)
    for a, b in (("n1", "s1"), ("n3", "s3")):
        two_way(edges, a, b, 1, 5.56, lane, 2)
    for a, b in (("n2", "s2"), ("s4", "n4")):
        edges.append(edge(a + b, a, b, 1, 5.56, lane, 2))
    for a, b in (("k1", "r6"), ("k2", "r4"), ("k3", "r1"), ("k4", "r5")):
        two_way(edges, a, b, 1, 5.56, lane, 2)
    for a, b in (("r6", "d1"), ("d1", "d2"), ("d2", "s1")):
        edges.append(edge(a + b, a, b, 1, 5.56, lane, 1))
    for a, b, lanes in (("g1", "ga", 1), ("ga", "gb", 3), ("gb", "g2", 1)):
        edges.append(edge(a + b, a, b, lanes, 5.56, lane, 2))
    for k, x in (("1", 72), ("2", 164)):
        nodes += [node(f"u{k}", x, -180), node(f"y{k}", x, -246)]
        edges += [only(edge(f"u{k}c{k}", f"u{k}", f"c{k}", 1, 2.8, "highway.footway", 1), "pedestrian"), only(edge(f"c{k}y{k}", f"c{k}", f"y{k}", 1, 2.8, "highway.footway", 1), "pedestrian")]
    links += [f'<crossing node="{n}" edges="{a} {b}" priority="true" width="4"/>' for n, a, b in (("c1", "r5c1", "c1r5"), ("c2", "s3c2", "c2s3"), ("v", "av", "va"))]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    stop = lambda road, at, least, most: f'<stop lane="{road}" startPos="{at}" endPos="{at + 7}" duration="{draw.randint(least, most)}"/>'
    served = [f'<flow id="served{i}" type="{kind}" begin="0" end="270" period="exp({1 / p:.4f})" from="{a}" to="{b}" via="d1d2">{stop("d1d2_0", 18, 9, 22)}</flow>' for i, (kind, a, b, p) in enumerate((("car", "wa", "va", 64), ("quick", "eg1", "g1e", 70), ("car", "z1z0", "z0z1", 66)))]
    filled = [f'<flow id="fuel{i}" type="{kind}" begin="0" end="260" period="exp({1 / p:.4f})" from="{a}" to="{b}">{stop(f"gagb_{i}", 20 + 8 * i, 20, 45)}</flow>' for i, (kind, a, b, p) in enumerate((("car", "eg1", "aw", 80), ("van", "wa", "aw", 95), ("car", "hqh2", "h2hq", 90)))]
    feet = (("u1c1", "c1y1", 8), ("u2c2", "c2y2", 9), ("c1y1", "u1c1", 10), ("c2y2", "u2c2", 9), ("av", "va", 27), ("va", "av", 31), ("h1h3", "h2b", 40))
    (work / "parked.txt").write_text("\n".join([
        *served, *filled,
        *(f'<flow id="shop{i}" type="{kind}" begin="0" period="{p}" number="{int(280 / p)}" from="{a}" to="{b}"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wa", "r6k1", 31), ("car", "eg1", "r4k2", 33), ("car", "k1r6", "aw", 35), ("car", "k2r4", "g1e", 37), ("car", "hph1", "r1k3", 43), ("car", "k3r1", "h1hp", 47), ("truck", "eg1", "r5k4", 83), ("van", "k4r5", "aw", 71), ("car", "wa", "g1e", 29), ("car", "eg1", "aw", 31), ("car", "k2r4", "aw", 41)))),
        *(f'<personFlow id="foot{i}" type="walker" begin="0" end="300" period="exp({1 / p:.4f})"><walk from="{a}" to="{b}"/></personFlow>' for i, (a, b, p) in enumerate(feet))]))
    return ["--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--tls.cycle.time", 70, "--tls.yellow.time", 3, "--tls.left-green.time", 8, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--sidewalks.guess.exclude", "r6d1,d1d2,d2s1,g1ga,gagb,gbg2,r2o,h1p1,p1h1,p2q0,q0p2,q1o,oq1,q2r1,r1q2,pr0,pr1,pr2,qr0,qr1,qr2", "--crossings.guess"]
