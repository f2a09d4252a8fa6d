"""Road networks of the fifth held group: a ladder of T-junctions with turn bays, a motorway whose lanes part and join
again, an oval ring of two lanes with arms one way, a town with bridges over a river and a junction of five arms.
"""

import math

from networks import document, edge, link, node, two_way


def ladder(work, draw):
    """Two parallel streets for traffic on the left, joined by rungs that do not face each other: T-junctions only, bays for
    the turn across in the wide one.
    """
    nodes, edges = [], []
    top, bottom = lambda x: 118 + 14 * math.sin(x / 130), lambda x: -10 * math.cos(x / 90)
    rungs = [-330 + 128 * i + draw.uniform(-18, 18) for i in range(6)]
    for i, x in enumerate(rungs):
        nodes += [node(f"t{i}", x + 9, top(x + 9), draw.choice(("traffic_light", "priority"))), node(f"b{i}", x - 7, bottom(x - 7), draw.choice(("priority", "priority_stop")))]
        two_way(edges, f"t{i}", f"b{i}", 1, 11.11, "highway.residential", 4, shape=[(x + draw.uniform(-12, 12), 55)])
    ends = (("tw", -520, top), ("te", rungs[-1] + 190, top), ("bw", -500, bottom), ("be", rungs[-1] + 170, bottom))
    nodes += [node(n, x, y(x)) for n, x, y in ends]
    high, low = ["tw", *(f"t{i}" for i in range(6)), "te"], ["bw", *(f"b{i}" for i in range(6)), "be"]
    for i, (a, b) in enumerate(zip(high, high[1:])):
        two_way(edges, a, b, 1 + (i in (2, 3)), 15.28, "highway.secondary", 8, bays=(28 if i < 6 else 0, 28 if i > 0 else 0))
    for a, b in zip(low, low[1:]):
        two_way(edges, a, b, 1, 13.89, "highway.tertiary", 6)
    for i in range(6):
        if draw.random() < 0.5:
            nodes.append(node(f"n{i}", rungs[i] + 62, top(rungs[i]) + 150))
            nodes.append(node(f"j{i}", rungs[i] + 60, top(rungs[i] + 60), "priority"))
            old = [n for n, e in enumerate(edges) if e.startswith((f'<edge id="t{i}{high[i + 2]}"', f'<edge id="{high[i + 2]}t{i}"'))]
            for n in reversed(old):
                del edges[n]
            two_way(edges, f"t{i}", f"j{i}", 1, 15.28, "highway.secondary", 8)
            two_way(edges, f"j{i}", high[i + 2], 1, 15.28, "highway.secondary", 8)
            two_way(edges, f"n{i}", f"j{i}", 1, 8.33, "highway.residential", 3)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--lefthand", "--no-turnarounds.except-deadend", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]


def parting(work, draw):
    """A motorway of four lanes: two part for another motorway, of which one lane may go either way; the left lane leaves as
    a ramp; the other motorway comes back with its lanes beside; the outer lane leaves; an on-ramp on the left.
    """
    s, k, r = 31.94, "highway.motorway", "highway.motorway_link"
    y = lambda x: 36 * math.sin(x / 610)
    xs = {"a": -1150, "b": -640, "c": -330, "d": 40, "e": 330, "f": 720, "g": 1010, "h": 1380}
    nodes = [node(n, x, y(x)) for n, x in xs.items()]
    along = lambda a, b: [(xs[a] + (xs[b] - xs[a]) * t, y(xs[a] + (xs[b] - xs[a]) * t)) for t in (0.2, 0.4, 0.6, 0.8)]
    count = {"ab": 4, "bc": 3, "cd": 3, "de": 2, "ef": 4, "fg": 3, "gh": 4}
    edges = [edge(n, n[0], n[1], lanes, s, k, 13, along(*n)) for n, lanes in count.items()]
    # The other motorway, parting at b and back at e.
    nodes += [node("o", -250, -120), node("p", 120, -130), node("q", 0, -330), node("z", 420, -260)]
    edges += [edge("bo", "b", "o", 2, 27.78, k, 12, [(-540, -45), (-430, -88), (-340, -110)]), edge("op", "o", "p", 2, 27.78, k, 12, [(-60, -134)]), edge("pe", "p", "e", 2, 27.78, k, 12, [(190, -112), (260, -40)]),
              edge("qp", "q", "p", 1, 19.44, r, 7, [(40, -230), (80, -160)]), edge("pz", "p", "z", 1, 16.67, r, 7, [(230, -150), (330, -190)])]
    # The left lane leaves at d, the outer one at f; on the left a ramp joins at g.
    nodes += [node("u", 230, 190), node("v", 900, -110), node("w", 820, 170)]
    edges += [edge("du", "d", "u", 1, 16.67, r, 7, [(120, 34), (190, 90)]), edge("fv", "f", "v", 1, 16.67, r, 7, [(800, 6)]), edge("wg", "w", "g", 1, 22.22, r, 7, [(900, 90), (960, 50)])]
    joined = [("ab", "bo", 0, 0), ("ab", "bo", 1, 1), ("ab", "bc", 1, 0), ("ab", "bc", 2, 1), ("ab", "bc", 3, 2), *(("bc", "cd", i, i) for i in range(3)),
              ("cd", "du", 2, 0), ("cd", "de", 0, 0), ("cd", "de", 1, 1), ("bo", "op", 0, 0), ("bo", "op", 1, 1), ("op", "pe", 0, 0), ("op", "pe", 1, 1), ("qp", "pz", 0, 0), ("op", "pz", 0, 0),
              ("pe", "ef", 0, 0), ("pe", "ef", 1, 1), ("de", "ef", 0, 2), ("de", "ef", 1, 3), ("ef", "fv", 0, 0), *(("ef", "fg", i + 1, i) for i in range(3)),
              *(("fg", "gh", i, i) for i in range(3)), ("wg", "gh", 0, 3)]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", [link(*j) for j in joined])
    return []


def oval(work, draw):
    """A long ring of two lanes with six arms, two of them one way; the arms of two lanes; crossings for people."""
    nodes, edges, angles = [], [], [8, 62, 118, 176, 240, 303]
    place = lambda a, more=0: ((58 + more) * math.cos(math.radians(a)), (27 + more) * math.sin(math.radians(a)))
    nodes += [node(f"r{i}", *place(a)) for i, a in enumerate(angles)]
    for i, a in enumerate(angles):
        sweep = (angles[(i + 1) % 6] - a) % 360
        edges.append(edge(f"ring{i}", f"r{i}", f"r{(i + 1) % 6}", 2, 9.0, "highway.secondary", 9, [place(a + sweep * t / 8) for t in range(9)]))
    for i, a in enumerate(angles):
        nodes.append(node(f"a{i}", *place(a + draw.uniform(-8, 8), 165)))
        lanes = 2 if i % 3 != 1 else 1
        if i not in (2, 5):
            two_way(edges, f"a{i}", f"r{i}", lanes, 13.89, "highway.secondary", 6)
        else:
            ends = (f"a{i}", f"r{i}") if i == 2 else (f"r{i}", f"a{i}")
            edges.append(edge("".join(ends), *ends, 2, 13.89, "highway.secondary", 6))
    nodes += [node("m", 420, 40, "traffic_light"), node("mn", 400, 190), node("ms", 450, -140), node("me", 600, 60)]
    two_way(edges, "a0", "m", 2, 13.89, "highway.secondary", 6)
    two_way(edges, "m", "me", 2, 13.89, "highway.secondary", 6)
    two_way(edges, "mn", "m", 1, 11.11, "highway.residential", 4)
    two_way(edges, "ms", "m", 1, 11.11, "highway.residential", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--roundabouts.guess", "--no-turnarounds", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]


def river_town(work, draw):
    """Quays on both sides of a river, three bridges that rise over it, a junction of five arms with lights, streets that meet
    aslant, and a bypass over one of them.
    """
    nodes, edges = [], []
    at = {"a": (-300, -70), "b": (-90, -62), "c": (130, -75), "d": (-310, 66), "e": (-95, 58), "f": (140, 72), "w1": (-470, -120), "w2": (-480, 110), "x1": (330, -130), "x2": (340, 90),
          "n1": (-210, 230), "n2": (60, 240), "s1": (-190, -240), "s2": (40, -250), "g": (-60, 150)}
    kinds = {"b": "traffic_light", "e": "priority", "f": "traffic_light", "c": "allway_stop", "a": "priority", "d": "right_before_left", "g": "priority_stop"}
    nodes += [node(n, x + draw.uniform(-6, 6), y + draw.uniform(-6, 6), kinds.get(n, "priority")) for n, (x, y) in at.items()]
    for a, b, lanes in (("a", "d", 1), ("b", "e", 2), ("c", "f", 1)):
        (xa, ya), (xb, yb) = at[a], at[b]
        two_way(edges, a, b, lanes, 13.89, "highway.secondary", 8, shape=[(xa + (xb - xa) * t, ya + (yb - ya) * t, 5 * math.sin(math.pi * t)) for t in (0.2, 0.35, 0.5, 0.65, 0.8)])
    for a, b, lanes, limit in (("w1", "a", 1, 13.89), ("a", "b", 1, 13.89), ("b", "c", 2, 13.89), ("c", "x1", 1, 13.89), ("w2", "d", 1, 13.89), ("d", "e", 1, 11.11), ("e", "f", 2, 13.89), ("f", "x2", 2, 13.89)):
        two_way(edges, a, b, lanes, limit, "highway.secondary", 7)
    for a, b, limit in (("b", "s1", 11.11), ("b", "s2", 13.89), ("e", "g", 8.33), ("g", "n1", 8.33), ("g", "n2", 11.11), ("f", "n2", 11.11), ("a", "s1", 8.33)):
        two_way(edges, a, b, 1, limit, "highway.residential", 4)
    # A bypass over the eastern quay roads, without a ramp.
    nodes += [node("y0", 230, -330), node("y1", 260, 330)]
    two_way(edges, "y0", "y1", 2, 22.22, "highway.trunk", 11, shape=[(233, -230, 4), (236, -140, 8), (242, 0, 8), (248, 140, 8), (255, 240, 4)])
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    return ["--junctions.corner-detail", 5, "--no-turnarounds", "--tls.default-type", "actuated", "--sidewalks.guess", "--crossings.guess"]
