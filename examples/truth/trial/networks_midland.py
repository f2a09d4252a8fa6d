"""Road networks of the sixteenth held group, of a plain between two cities: a large roundabout through whose middle the
main road passes, and a crossing whose left turns go by a road across one corner; a boulevard aslant through a grid of
streets, with crossings of six arms and lanes for cyclists; a fast road for traffic on the left with a wide median, which
one crosses in two stages; a motorway interchange of loops onto the motorway, with lights where its exits end.
"""

import math

from networks import document, edge, link, node, smooth, two_way
from networks_gateway import stations
from networks_newtown import boxed, ease, programs
from networks_outskirts import ahead, closed, lifted


def throughabout(work, draw):
    """A ring of two lanes and five arms. The main road from west to east passes straight through its middle, between two
    lights; a third light is at the ring's south, two arms give way. West of it a crossing at which nobody turns left: a road
    across its south-western corner, with lights at both ends, serves for that. East of it a crossing with bays.
    """
    main, cross, street = "highway.primary", "highway.secondary", "highway.tertiary"
    jolt = lambda: draw.uniform(-9, 9)
    nodes, edges, links = [], [], []
    angles = {"e": 0, "n": 88, "a": 180, "s": 258, "v": 314}
    spot = lambda deg: (50 * math.cos(math.radians(deg)), 50 * math.sin(math.radians(deg)))
    for n, deg in angles.items():
        nodes.append(node(n, *spot(deg), "traffic_light" if n in "eas" else "priority").replace("/>", ' radius="9"/>'))
    around = list(angles)
    for a, b in zip(around, [*around[1:], around[0]]):
        sweep = (angles[b] - angles[a]) % 360
        edges.append(edge(f"o{a}", a, b, 2, 9.72, main, 9, [spot(angles[a] + sweep * t / 8) for t in range(9)]))
    edges.append(f'<roundabout nodes="{" ".join(around)}" edges="{" ".join("o" + n for n in around)}"/>')
    place = {"wa": (-150, 4), "q": (-405 + jolt(), 16), "t1": (-590 + jolt(), 12), "w": (-900, -22), "em": (148, -5), "x": (400 + jolt(), -24), "z": (690, -60),
             "qn": (-392, 270), "t2": (-418, -165 + jolt()), "qz": (-440, -420), "N": (12, 290), "S": (-18, -300), "V": (196, -196), "VV": (330, -330), "xn": (418, 220), "xs": (385, -270)}
    kinds = {"q": "traffic_light", "t1": "traffic_light", "t2": "traffic_light", "x": "traffic_light", "V": "allway_stop"}
    nodes += [node(n, *p, kinds.get(n, "priority")) for n, p in place.items()]
    edges += [edge("ae", "a", "e", 2, 13.89, main, 10), edge("ea", "e", "a", 2, 13.89, main, 10)]
    for n, m in (("a", "wa"), ("e", "em")):
        edges += [edge(m + n, m, n, 3, 13.89, main, 10), edge(n + m, n, m, 2, 13.89, main, 10)]
    for a, b, bays in (("w", "t1", (0, 0)), ("t1", "q", (0, 65)), ("q", "wa", (0, 0)), ("em", "x", (60, 0)), ("x", "z", (0, 60))):
        two_way(edges, a, b, 2, 16.67, main, 10, bays=bays)
    for a, b, lanes, bays in (("qn", "q", 2, (0, 0)), ("q", "t2", 2, (0, 0)), ("qz", "t2", 2, (55, 0)), ("N", "n", 2, (0, 0)), ("S", "s", 2, (0, 0))):
        two_way(edges, a, b, lanes, 13.89, cross, 8, bays=bays)
    corner = smooth([place["t1"], place["t1"], (place["t1"][0] + 4, -45), (-570, -118), (-512, -160), (-465, -166), place["t2"], place["t2"]], 4)
    two_way(edges, "t1", "t2", 1, 11.11, street, 6, shape=corner[1:-1], bays=(40, 40))
    for a, b in (("V", "v"), ("V", "VV"), ("S", "V"), ("xn", "x"), ("xs", "x")):
        two_way(edges, a, b, 1, 11.11, street, 6, bays=(45, 0) if b == "x" else (0, 0))
    for m, n, before, straight in (("wa", "a", "n", "ae"), ("em", "e", "v", "ea")):
        came = "qwa" if n == "a" else "xem"
        links += ahead(came, m + n, (0, 0), (0, 1), (1, 2)) + ahead(m + n, "o" + n, (0, 0)) + ahead(m + n, straight, (1, 0), (2, 1))
        links += ahead("o" + before, n + m, (0, 0)) + ahead("o" + before, "o" + n, (0, 0), (1, 1)) + ahead("ea" if n == "a" else "ae", n + m, (0, 0), (1, 1))
    for arm, n, before in (("N", "n", "e"), ("S", "s", "a"), ("V", "v", "s")):
        lanes = ((0, 0), (1, 1)) if arm != "V" else ((0, 0),)
        links += ahead(arm + n, "o" + n, *lanes) + ahead("o" + before, n + arm, *(((0, 0), (0, 1)) if arm != "V" else lanes)) + ahead("o" + before, "o" + n, (0, 0), (1, 1))
    # Nobody turns left at q.
    for came, on, right in (("t1q", "qwa", "qt2"), ("waq", "qt1", "qqn"), ("qnq", "qt2", "qt1"), ("t2q", "qqn", "qwa")):
        links += ahead(came, on, (0, 0), (1, 1)) + ahead(came, right, (0, 0))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    options = ["--no-turnarounds", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 10, "--tls.cycle.time", 68, "--tls.yellow.time", 3, "--tls.left-green.time", 9]
    ring = lambda n, before, arm: {("o" + before, arm), ("o" + before, "o" + n)}
    programs(work, options, {"links": links, "a": (0, [(34, {("waa", "oa"), ("waa", "ae"), ("ea", "awa")}), (24, ring("a", "n", "awa"))]), "e": (5, [(34, {("eme", "oe"), ("eme", "ea"), ("ae", "eem")}), (24, ring("e", "v", "eem"))]),
                             "s": (12, [(36, ring("s", "a", "sS")), (22, {("Ss", "os")})])})
    (work / "parked.txt").write_text("\n".join(f'<flow id="mid{i}" type="{kind}" begin="0" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "wt1", "xz", 17), ("car", "zx", "t1w", 19), ("truck", "wt1", "xz", 53), ("car", "wt1", "qqn", 37), ("car", "qzt2", "t1w", 41), ("car", "qnq", "xz", 43), ("van", "zx", "t2qz", 47), ("car", "wt1", "nN", 39), ("car", "zx", "sS", 37), ("car", "Nn", "xz", 33), ("car", "Ss", "t1w", 35),
        ("car", "VVV", "nN", 57)))))
    return options


def boulevard(work, draw):
    """Avenues and streets, two of them one way, and a boulevard of two lanes and one for cyclists in each direction that
    passes aslant through three of their crossings, which have six arms and lights. At the others there are lights, or one
    stops, or who comes from the right goes first. People cross at all of them.
    """
    broad, avenue, street = "highway.primary", "highway.secondary", "highway.residential"
    jolt = lambda: draw.uniform(-4, 4)
    nodes, edges, links = [], [], []
    xs, ys = (-262, 0, 268), (-190, 0, 196)
    kinds = {"00": "six", "11": "six", "22": "six", "10": "priority_stop", "20": "right_before_left", "01": "traffic_light", "21": "traffic_light", "02": "right_before_left", "12": "priority_stop"}
    place = {f"{i}{j}": (x + jolt(), y + jolt()) for i, x in enumerate(xs) for j, y in enumerate(ys)}
    for i, x in enumerate(xs):
        place |= {f"z{i}": (x + jolt(), -400), f"t{i}": (x + jolt(), 410)}
    for j, y in enumerate(ys):
        place |= {f"w{j}": (-490, y + jolt()), f"e{j}": (500, y + jolt())}
    place |= {"b0": (-480, -352), "b1": (500, 366)}
    for n, p in place.items():
        kind = kinds.get(n, "priority")
        nodes.append(node(n, *p, "traffic_light").replace("/>", ' radius="9"/>') if kind == "six" else node(n, *p, kind))
    roads = []
    for i in range(3):
        column = [f"z{i}", f"{i}0", f"{i}1", f"{i}2", f"t{i}"]
        for a, b in zip(column, column[1:]):
            ways = ((b, a),) if i == 0 else ((a, b),) if i == 2 else ((a, b), (b, a))
            roads += [(u, v, 2 if i != 1 else 1, 13.89, avenue, 7) for u, v in ways]
    for j in range(3):
        row = [f"w{j}", f"0{j}", f"1{j}", f"2{j}", f"e{j}"]
        for a, b in zip(row, row[1:]):
            roads += [(u, v, 1, 11.11 if j != 1 else 13.89, street if j != 1 else avenue, 5 if j != 1 else 6) for u, v in ((a, b), (b, a))]
    slant = ["b0", "00", "11", "22", "b1"]
    for u, v, lanes, limit, kind, rank in roads:
        bay = 40 if v in ("01", "21") and lanes == 1 and kind == avenue else 0
        edges.append(edge(f"{u}-{v}", u, v, lanes, limit, kind, rank, bay=bay))
    for a, b in zip(slant, slant[1:]):
        for u, v in ((a, b), (b, a)):
            edges.append(edge(f"{u}-{v}", u, v, 3, 13.89, broad, 9).replace("></edge>", '><lane index="0" allow="bicycle" width="1.8"/><lane index="1" disallow="bicycle pedestrian"/><lane index="2" disallow="bicycle pedestrian"/></edge>'))
    # Nobody turns back sharply from or into the boulevard; at a crossing of six arms nobody turns left.
    every = [(u, v) for u, v, *_ in roads] + [p for a, b in zip(slant, slant[1:]) for p in ((a, b), (b, a))]
    aim = lambda u, v: math.atan2(place[v][1] - place[u][1], place[v][0] - place[u][0])
    bays = {(u, v) for u, v, lanes, _, kind, _ in roads if v in ("01", "21") and lanes == 1 and kind == avenue}
    for u, v in every:
        for s, t in every:
            turn = (aim(s, t) - aim(u, v) + math.pi) % (2 * math.pi) - math.pi
            if v == s and t != u and (abs(turn) > math.radians(112) or kinds.get(v) == "six" and turn > math.radians(20)):
                links.append(f'<delete from="{u}-{v}{".-40" if (u, v) in bays else ""}" to="{s}-{t}"/>')
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    flows = (("car", "b0-00", "22-b1", 21), ("car", "b1-22", "00-b0", 23), ("car", "b0-00", "11-21", 43), ("car", "w1-01", "22-b1", 47), ("car", "w1-01", "21-e1", 29), ("car", "e1-21", "01-w1", 31), ("van", "b1-22", "10-z1", 53), ("car", "z2-20", "22-t2", 27), ("car", "t0-02", "00-z0", 29),
             ("cycle", "b0-00", "22-b1", 23), ("cycle", "b1-22", "00-b0", 27), ("truck", "b0-00", "22-b1", 71))
    (work / "parked.txt").write_text("\n".join(f'<flow id="slant{i}" type="{kind}" begin="0" period="{p}" number="{int(240 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate(flows)))
    return ["--no-turnarounds", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 8, "--tls.cycle.time", 84, "--tls.yellow.time", 3, "--tls.left-green.time", 7, "--sidewalks.guess", "--sidewalks.guess.max-speed", 13.95, "--crossings.guess"]


def twostage(work, draw):
    """Traffic on the left, 90 km/h, two lanes in each direction with a median of 36 m. One crosses it, or turns right, in two
    stages: at a crossing where side roads stop, at a road that ends there, at a crossing with lights. Lay-bys in which lorries
    rest, farms' drives, a filling station, an entry by a lane that ends, a village road south of it.
    """
    main, side, lane = "highway.trunk", "highway.secondary", "highway.service"
    fast, slow = 25.0, 16.67
    y = lambda x: 34 * math.sin(x / 420)
    jolt = lambda: draw.uniform(-12, 12)
    nodes, edges, links = [], [], []
    x = {"w": -1180, "l": -900 + jolt(), "m": -800, "c": -470 + jolt(), "f": -200, "d": 90 + jolt(), "p": 330, "r": 470, "k": 760 + jolt(), "g": 960, "h": 1110, "e": 1330}
    x["m"] = x["l"] + 95
    lit = {"k"}
    # North of the median one drives east.
    for n in x:
        for tag, sign in (("n", 1), ("s", -1)):
            at = x[n], y(x[n]) + sign * 19
            kind = "traffic_light" if n in lit else "priority_stop" if n == "c" or n == "d" and tag == "s" else "priority"
            if (n in "prg" and tag == "s") or n == "h" and tag == "s":
                continue
            nodes.append(node(n + tag, *at, kind).replace("/>", ' radius="6"/>') if n in "cdk" else node(n + tag, *at, kind))

    def carriage(tag, sign, names, bays, wide):
        for a, b in zip(names, names[1:]):
            lanes, bay = wide.get(a, 2), bays.get(b, 0)
            reach = lambda n: 13 if n in "cdk" else 3
            way = 1 if x[b] > x[a] else -1
            line = [(s, y(s) + sign * (19 - 3.2 * bool(bay))) for s, _ in stations(x[a] + way * reach(a), x[b] - way * reach(b), lambda s: s)]
            row = edge(f"{a}{b}{tag}", a + tag, b + tag, lanes, fast if "k" not in (a, b) else 22.22, main, 10, line, bay)
            if (a, b) in (("l", "m"), ("m", "l")):
                row = row.replace("></edge>", '><lane index="0" allow="truck"/></edge>')
                nonlocal_links(f"{names[names.index(a) - 1]}{a}{tag}", f"{a}{b}{tag}", f"{b}{names[names.index(b) + 1]}{tag}")
            edges.append(closed(row, "bicycle") if "allow=" not in row else row)

    def nonlocal_links(before, bay, after):
        links.extend(ahead(before, bay, (0, 0), (0, 1), (1, 2)) + ahead(bay, after, (0, 0), (1, 0), (2, 1)))

    carriage("n", 1, "wlmcfdprkghe", {"c": 95, "d": 95, "k": 90}, {"l": 3, "g": 3})
    carriage("s", -1, "ekdfcmlw", {"c": 95, "k": 90}, {"m": 3})
    # The openings of the median.
    for n in "cdk":
        lanes = 1
        two_way(edges, n + "n", n + "s", lanes, 11.11, side, 6)
    ends = {"cN": (x["c"] - 10, 330), "cS": (x["c"] + 14, -255), "cZ": (x["c"] + 30, -430), "dS": (x["d"] - 8, -250), "dZ": (x["d"] + 10, -420), "kN": (x["k"] + 10, 350), "kS": (x["k"] - 15, -215), "kZ": (x["k"] - 10, -400),
            "fn2": (-194, y(-200) + 125), "fs2": (-208, y(-200) - 115), "o": (860, 300)}
    nodes += [node(n, *p, {"cS": "allway_stop", "dS": "left_before_right"}.get(n, "priority")) for n, p in ends.items()]
    for a, b, bays in (("cN", "cn", (40, 0)), ("cS", "cs", (40, 0)), ("dS", "ds", (45, 0)), ("kN", "kn", (60, 0)), ("kS", "ks", (60, 0))):
        two_way(edges, a, b, 1, slow, side, 6, bays=bays)
    for a, b in (("cZ", "cS"), ("dZ", "dS"), ("kZ", "kS")):
        two_way(edges, a, b, 1, 13.89, side, 6)
    two_way(edges, "cS", "dS", 1, 11.11, side, 5, shape=smooth([ends["cS"], ends["cS"], (-300, -275), (-90, -238), ends["dS"], ends["dS"]], 5))
    two_way(edges, "dS", "kS", 1, 13.89, side, 5, shape=smooth([ends["dS"], ends["dS"], (300, -272), (540, -225), ends["kS"], ends["kS"]], 5))
    two_way(edges, "fn2", "fn", 1, 5.56, lane, 2)
    two_way(edges, "fs2", "fs", 1, 5.56, lane, 2)
    # The filling station, and the entry by a lane that ends at h.
    nodes += [node("pa", 372, y(372) + 52), node("pb", 432, y(432) + 52)]
    edges += [closed(edge("ppa", "pn", "pa", 1, 11.11, lane, 3, [(333, y(333) + 24), (342, y(342) + 28), (354, y(354) + 40), (370, y(370) + 51)]), "bicycle"), edge("pab", "pa", "pb", 3, 5.56, lane, 3), edge("pbr", "pb", "rn", 1, 11.11, lane, 3, [(434, y(434) + 51), (450, y(450) + 38), (459, y(459) + 28), (467, y(467) + 24)])]
    ramp = smooth([ends["o"], ends["o"], (846, 210), (850, 140), (874, y(874) + 69), (915, y(915) + 38), (x["g"], y(x["g"]) + 26), (x["g"], y(x["g"]) + 26)], 5)
    edges.append(closed(edge("og", "o", "gn", 1, slow, "highway.trunk_link", 8, ramp), "bicycle"))
    nodes.append(node("oo", 880, 420))
    edges.append(closed(edge("ooo", "oo", "o", 1, slow, "highway.trunk_link", 8), "bicycle"))
    links += ahead("og", "ghn", (0, 0)) + ahead("kgn", "ghn", (0, 1), (1, 2)) + ahead("ghn", "hen", (1, 0), (2, 1))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    rest = lambda road, at, least, most: f'<stop lane="{road}_0" startPos="{at - 20}" endPos="{at}" duration="{draw.randint(least, most)}"/>'
    (work / "parked.txt").write_text("\n".join([
        *(f'<flow id="rest{i}" type="truck" begin="{i * 3}" period="{p}" number="{int(250 / p)}" from="{a}" to="{b}" departSpeed="max">{rest(road, 62, 10, 24)}</flow>' for i, (a, road, b, p) in enumerate((("wln", "lmn", "hen", 41), ("eks", "mls", "lws", 43)))),
        *(f'<flow id="fuel{i}" type="car" begin="0" period="{p}" number="{int(260 / p)}" from="wln" to="hen" departSpeed="max"><stop lane="pab_{i}" startPos="{15 + 12 * i}" endPos="{22 + 12 * i}" duration="{draw.randint(15, 30)}"/></flow>' for i, p in enumerate((67, 71, 83))),
        *(f'<flow id="plain{i}" type="{kind}" begin="0" period="{p}" number="{int(270 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wln", "hen", 9), ("car", "eks", "lws", 8), ("quick", "wln", "hen", 29), ("quick", "eks", "lws", 31), ("truck", "eks", "lws", 53), ("car", "cNcn", "cScZ", 41), ("car", "cZcS", "cncN", 47), ("car", "wln", "dSdZ", 39), ("car", "dZdS", "hen", 37), ("car", "kNkn", "kSkZ", 29), ("car", "eks", "knkN", 33),
            ("car", "wln", "kSkZ", 43), ("van", "fn2fn", "hen", 89), ("car", "ooo", "hen", 17), ("van", "wln", "fnfn2", 97)))) ]))
    return ["as drawn", "--lefthand", "--no-turnarounds", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 8, "--tls.cycle.time", 70, "--tls.yellow.time", 4, "--tls.left-green.time", 8]


def parclo(work, draw):
    """A motorway and a road over it. In each direction there is one exit, which ends at a light on the road, then an entry by
    a loop from who comes over the bridge, then one from who has not crossed it yet. Eastwards: an exit lane, a loop
    whose lane stays, an entry by a lane that ends, a lane that ends by turns. Westwards: an exit without a lane, a loop whose
    lane ends, an entry whose lane stays. A crossing with a light at both ends of the road.
    """
    main, ramp, road = "motorway", "motorway_link", "primary"
    high = 6.5
    jolt = lambda: draw.uniform(-12, 12)
    nodes, edges, links = [], [], []
    lift = lambda v: high * ease((310 - abs(v)) / 210)
    turned = lambda d, u, v, *z: ((1 - d) * u, (1 - d) * v, *z)
    limit = {0: 33.33, 2: 30.56}
    # Stations and the lanes from each to the next.
    parts = {0: (("a", -1450, 3), ("b", -790 + jolt(), 4), ("c", -520 + jolt(), 3), ("e", 5, 4), ("g", 400 + jolt(), 5), ("h", 660, 4), ("i", 930, 3), ("j", 1450, 0)),
             2: (("a", -1450, 3), ("c", -500 + jolt(), 3), ("e", 8, 4), ("f", 215, 3), ("g", 430 + jolt(), 4), ("j", 1450, 0))}

    def slip(name, a, b, speed, points):
        edges.append(edge(name, a, b, 1, speed, ramp, 8, smooth([points[0], *points, points[-1]], 5)))

    for d, stations_ in parts.items():
        at, have = {s: u for s, u, _ in stations_}, {s: n for s, _, n in stations_}
        for s, u in at.items():
            px, py = turned(d, u, -5)
            row = lifted(f"{s}{d}", px, py, 0, "zipper" if s == "i" else "priority")
            reach = {"c": (2, 28), "e": (28, 2), "g": (28, 2)}.get(s)
            most = max(have[s], have[stations_[max(0, [r[0] for r in stations_].index(s) - 1)][0]])
            nodes.append(boxed(row, px, py, d * math.pi / 2, *reach, 3.2 * (most + (s == "c" and d == 2)) + 3.2, 0.2) if reach else row)
        names = list(at)
        for s, t in zip(names, names[1:]):
            lo, hi = at[s] + (28 if s == "c" else 2), at[t] - (28 if t in "eg" else 2)
            edges.append(edge(f"m{d}{s}", f"{s}{d}", f"{t}{d}", have[s], limit[d], main, 13, [turned(d, u, -5, 0) for u, _ in stations(lo, hi, lambda u: u, 50)]))
        for s, t in zip(names, names[1:-1]):
            n, more = have[s], have[t] - have[s]
            pairs = [(k, k + more) for k in range(n) if k + more >= 0]
            links.extend(ahead(f"m{d}{s}", f"m{d}{t}", *pairs, *([(0, 0)] if t == "i" else ())))
        before = names[names.index("c") - 1]
        links.extend(ahead(f"m{d}{before}", f"off{d}", (0, 0)) + ahead(f"loop{d}", f"m{d}e", (0, 0)) + ahead(f"on{d}", f"m{d}g", (0, 0)))
        c, g = at["c"], at["g"]
        v = -5 - 3.2 * 3
        slip(f"off{d}", f"c{d}", f"S{d}", 19.44, [turned(d, *p) for p in ((c + 28, v, 0), (c + 60, v - 1.5, 0), (c + 110, v - 7, 0), (-310, -48, 0.4), (-230, -96, 1.6), (-150, -146, 3.2), (-80, -168, 4), (-20, -172, lift(172)))])
        slip(f"loop{d}", f"L{d}", f"e{d}", 11.11, [turned(d, *p) for p in ((-7, -100, 6.5), (-20, -119, 6.3), (-48, -133, 6), (-85, -132, 5.2), (-117, -110, 4), (-128, -76, 2.8), (-115, -45, 1.6), (-86, -25, 0.8), (-52, -18.3, 0.2), (at["e"] - 28, -14.7, 0))])
        w = -5 - 3.2 * (have["g"] - 1)
        slip(f"on{d}", f"R{d}", f"g{d}", 19.44, [turned(d, *p) for p in ((7, -236, 1.3), (24, -214, 1.3), (60, -176, 1.2), (120, -118, 0.9), (200, -68, 0.4), (290, -38, 0), (340, w - 5, 0), (g - 28, w, 0))])
        for n, u in (("S", 172), ("L", 88), ("R", 252)):
            x, y = turned(d, 0, -u)
            nodes.append(lifted(f"{n}{d}", x, y, lift(u), "traffic_light" if n == "S" else "priority"))
    for n, u in (("p", -455), ("q", 460), ("pz", -680), ("qz", 690)):
        nodes.append(lifted(n, jolt() / 2 if len(n) == 1 else 20, u, 0, "traffic_light" if len(n) == 1 else "priority"))
    spine = [("pz", -680), ("p", -455), ("R0", -252), ("S0", -172), ("L0", -88), ("L2", 88), ("S2", 172), ("R2", 252), ("q", 460), ("qz", 690)]
    for (a, u), (b, v) in zip(spine, spine[1:]):
        line = [(0, s, lift(s)) for s, _ in stations(u + 10, v - 10, lambda s: s, 30)] if a not in ("pz", "q") else []
        bays = (60 if b in "pq" else 0, 60 if a in "pq" else 0)
        for name, start, end, shape, bay in ((a + b, a, b, line, bays[0]), (b + a, b, a, line[::-1], bays[1])):
            if bay and shape:
                # As long as the bay has not begun, the two lanes keep to the middle.
                side, v0 = (-3.2 if end == "q" else 3.2), shape[0][1]
                shape = [(side * (1 - ease((abs(s - v0) - 5) / 85)), s, z) for _, s, z in shape]
            edges.append(edge(name, start, end, 2, 16.67, road, 9, shape, bay))
    for n, arms in (("p", (("pw", -260, -440), ("pe", 250, -470))), ("q", (("qw", -240, 480), ("qe", 270, 445)))):
        for end, ex, ey in arms:
            nodes.append(lifted(end, ex, ey, 0))
            two_way(edges, end, n, 1, 13.89, "secondary", 6, bays=(45, 0))
    for d, (out, up) in {0: (("R0", "S0", "L0"), ("L2", "S2")), 2: (("R2", "S2", "L2"), ("L0", "S0"))}.items():
        r, s, l = out
        came, over = ("p", "L2") if d == 0 else ("q", "L0")
        links.extend(ahead(came + r, r + s, (0, 0), (1, 1)) + ahead(came + r, f"on{d}", (0, 0)))
        links.extend(ahead(r + s, s + l, (0, 0), (1, 1)) + ahead(s + l, l + over, (0, 0), (1, 1)))
        links.extend(ahead(over + l, l + s, (0, 0), (1, 1)) + ahead(over + l, f"loop{d}", (0, 0)))
        links.extend(ahead(l + s, s + r, (0, 0), (1, 1)) + ahead(s + r, r + came, (0, 0), (1, 1)))
        links.extend(ahead(f"off{d}", s + r, (0, 0)) + ahead(f"off{d}", s + l, (0, 1)))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    options = ["as drawn", "--no-turnarounds", "--junctions.corner-detail", 5, "--junctions.internal-link-detail", 12, "--tls.cycle.time", 64, "--tls.yellow.time", 4, "--tls.left-green.time", 8]
    light = lambda d, s, r, l, k: (k, [(32, {(r + s, s + l), (l + s, s + r)}), (22, {(f"off{d}", s + r), (f"off{d}", s + l)})])
    programs(work, options, {"links": links, "S0": light(0, "S0", "R0", "L0", 0), "S2": light(2, "S2", "R2", "L2", 17)}, 4, 1)
    (work / "parked.txt").write_text("\n".join(f'<flow id="far{i}" type="{kind}" begin="0" period="{p}" number="{int(220 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
        ("car", "m0a", "m0i", 9), ("car", "m2a", "m2g", 10), ("truck", "m0a", "m0i", 23), ("truck", "m2a", "m2g", 27), ("car", "m0a", "qqz", 17), ("car", "m2a", "ppz", 19), ("car", "pzp", "m0i", 15), ("car", "qzq", "m0i", 14), ("car", "qzq", "m2g", 17), ("car", "pzp", "m2g", 16), ("van", "m0a", "ppz", 41),
        ("van", "m2a", "qqz", 43)))))
    return options
