"""Road networks of the twelfth held group, of the outskirts of a large city: an expressway on a viaduct with frontage
roads on both sides, which cross streets at lights below it; an avenue of large crossings with bays, waiting room for left
turns and turning round, bus bays and a crossing with lights of its own; a village of offset junctions without lights and
of narrow streets in which one delivers; a motorway whose third lane is led past works beside the oncoming traffic.
"""

import math

from networks import document, edge, link, node, ring, two_way


def lifted(name, x, y, z, kind="priority"):
    return node(name, x, y, kind).replace("/>", f' z="{z:.1f}"/>')


def closed(row, *classes):
    """An edge on which some classes may not drive."""
    return row.replace("<edge ", f'<edge disallow="{" ".join(classes)}" ', 1)


def drawn(row, x, y, slope, before, behind, right, left):
    """A node whose junction is a rectangle along a line of that slope, so far to both ends and sides (m)."""
    far = math.hypot(1, slope)
    ux, uy = 1 / far, slope / far
    corners = ((-before, -right), (behind, -right), (behind, left), (-before, left))
    return row.replace("/>", ' shape="' + " ".join(f"{x + ux * d - uy * s:.2f},{y + uy * d + ux * s:.2f}" for d, s in corners) + '"/>')


def ahead(start, end, *pairs):
    return [link(start, end, a, b) for a, b in pairs]


def between(a, b, line, n=5):
    """Points of a function of x between two stations."""
    return [(x, line(x)) for x in (a + (b - a) * t / n for t in range(1, n))]


def viaduct(work, draw):
    """Eastwards: an exit by a lane of its own, an entry by one that ends, a lane that becomes an exit, an entry by one that
    stays. Westwards: an exit without a lane, a stretch of weaving, three lanes into two by turns, an entry. The ramps come
    down on the left of the frontage roads, which two streets cross, and which have side streets and a bus bay.
    """
    high, low, link_road, main = 5.0, 0.0, "highway.trunk_link", "highway.trunk"
    bow = lambda x: 30 * math.sin(x / 520)
    nodes, edges, links = [], [], []
    jolt = lambda: draw.uniform(-12, 12)

    def along(tag, off, z, kind, parts):
        """One carriageway: stations (m) with node, lanes and limit from there on. Its left edge is a line at `off`."""
        for name, x, _, _, control in parts:
            row = lifted(name, x, bow(x) + off, z, control)
            # By turns, over 40 m.
            nodes.append(drawn(row, x, bow(x) + off, (bow(x + 5) - bow(x - 5)) / 10, 20, 20, 0.2, 9.8) if control == "zipper" else row)
        for i, ((a, xa, lanes, limit, _), (b, xb, *_)) in enumerate(zip(parts, parts[1:])):
            shape = [(x, y, z) for x, y in between(xa, xb, lambda x: bow(x) + off, max(2, int(abs(xb - xa) / 60)))]
            row = edge(f"{tag}{i}", a, b, lanes, limit, kind, 12 if z else 8, shape)
            edges.append(closed(row, "bicycle", "pedestrian", "bus") if z else row)

    v, f, c = 22.22, 13.89, 27.78
    x = {n: s + jolt() for n, s in (("e1", -980), ("e2", -800), ("e3", -95), ("e4", 110), ("e5", 215), ("e6", 850), ("w1", 985), ("w2", 310), ("w3", 60), ("w4", -260), ("w5", -690), ("w6", -900))}
    p = "priority"
    along("E", -5, high, main, (("e0", -1300, 3, c, p), ("e1", x["e1"], 4, v, p), ("e2", x["e2"], 3, v, p), ("e3", x["e3"], 4, v, p), ("e4", x["e4"], 3, v, p), ("e5", x["e5"], 2, v, p), ("e6", x["e6"], 3, c, p), ("e7", 1300, 0, 0, p)))
    along("W", 5, high, main, (("w0", 1300, 3, c, p), ("w1", x["w1"], 3, v, p), ("w2", x["w2"], 4, v, p), ("w3", x["w3"], 3, v, p), ("w4", x["w4"], 2, 19.44, "zipper"), ("w5", x["w5"], 3, v, p), ("w6", x["w6"], 2, c, p), ("w7", -1300, 0, 0, p)))
    fx = {"f1": -645, "as": -400, "f2": -310, "f3": 395, "bs": 565, "f4": 670, "h1": 795, "bn": 565, "h2": 490, "h3": -115, "an": -400, "h4": -510, "t": 60, "u": 190}
    tl = "traffic_light"
    along("F", -29, low, "highway.secondary", (("f0", -1300, 2, f, p), ("f1", fx["f1"], 3, f, p), ("as", fx["as"], 3, f, tl), ("f2", fx["f2"], 2, f, p), ("t1", -60, 3, f, p), ("t2", 30, 2, f, p), ("t", 130, 2, f, p),
                                                  ("f3", fx["f3"], 3, f, p), ("bs", fx["bs"], 3, f, tl), ("f4", fx["f4"], 2, f, p), ("f5", 1300, 0, 0, p)))
    along("H", 29, low, "highway.secondary", (("h0", 1300, 2, f, p), ("h1", fx["h1"], 3, f, p), ("bn", fx["bn"], 3, f, tl), ("h2", fx["h2"], 2, f, p), ("u", 185, 2, f, p), ("h3", fx["h3"], 3, f, p), ("an", fx["an"], 3, f, tl),
                                                  ("h4", fx["h4"], 2, f, p), ("h5", -1300, 0, 0, p)))
    links += ahead("E0", "E1", (0, 1), (1, 2), (2, 3)) + ahead("E1", "E2", (1, 0), (2, 1), (3, 2)) + ahead("E2", "E3", (0, 1), (1, 2), (2, 3)) + ahead("E3", "E4", (1, 0), (2, 1), (3, 2)) + ahead("E4", "E5", (1, 0), (2, 1)) + ahead("E5", "E6", (0, 1), (1, 2))
    links += ahead("W0", "W1", (0, 0), (1, 1), (2, 2)) + ahead("W1", "W2", (0, 1), (1, 2), (2, 3)) + ahead("W2", "W3", (1, 0), (2, 1), (3, 2)) + ahead("W3", "W4", (0, 0), (1, 0), (2, 1)) + ahead("W4", "W5", (0, 1), (1, 2)) + ahead("W5", "W6", (1, 0), (2, 1))
    for ramp, a, b, xa, xb, side, down in (("out1", "e2", "f1", x["e2"], fx["f1"], -1, True), ("in1", "f2", "e3", fx["f2"], x["e3"], -1, False), ("out2", "e5", "f3", x["e5"], fx["f3"], -1, True), ("in2", "f4", "e6", fx["f4"], x["e6"], -1, False),
                                           ("out3", "w1", "h1", x["w1"], fx["h1"], 1, True), ("in3", "h2", "w2", fx["h2"], x["w2"], 1, False), ("out4", "w3", "h3", x["w3"], fx["h3"], 1, True), ("in4", "h4", "w5", fx["h4"], x["w5"], 1, False)):
        # Above, a ramp lies right of three lanes (two where a lane is added); below, left of the frontage road's lanes.
        upper, lower = (11.4 if ramp in ("out2", "in2", "in4") else 14.6), 25.6
        shape = []
        for t in (0.12, 0.25, 0.4, 0.55, 0.7, 0.85, 0.93):
            s = t if down else 1 - t
            smooth = s * s * (3 - 2 * s)
            px = xa + (xb - xa) * t
            shape.append((px, bow(px) + side * (upper + (lower - upper) * smooth), high * (1 - smooth)))
        edges.append(closed(edge(ramp, a, b, 1, 15.28, link_road, 9, shape), "bicycle", "pedestrian", "bus"))
    links += ahead("E1", "out1", (0, 0)) + ahead("out1", "F1", (0, 2)) + ahead("F0", "F1", (0, 0), (1, 1)) + ahead("in1", "E3", (0, 0)) + ahead("F2", "in1", (2, 0)) + ahead("F2", "F3", (0, 0), (1, 1))
    links += ahead("E4", "out2", (0, 0)) + ahead("out2", "F7", (0, 2)) + ahead("F6", "F7", (0, 0), (1, 1)) + ahead("in2", "E6", (0, 0)) + ahead("F8", "in2", (2, 0)) + ahead("F8", "F9", (0, 0), (1, 1))
    links += ahead("W0", "out3", (0, 0)) + ahead("out3", "H1", (0, 2)) + ahead("H0", "H1", (0, 0), (1, 1)) + ahead("in3", "W2", (0, 0)) + ahead("H2", "in3", (2, 0)) + ahead("H2", "H3", (0, 0), (1, 1))
    links += ahead("W2", "out4", (0, 0)) + ahead("out4", "H5", (0, 2)) + ahead("H4", "H5", (0, 0), (1, 1)) + ahead("in4", "W5", (0, 0)) + ahead("H6", "in4", (2, 0)) + ahead("H6", "H7", (0, 0), (1, 1))
    # The bus bay lies right of the two lanes from t1 to t2.
    links += ahead("F3", "F4", (0, 1), (1, 2)) + ahead("F4", "F5", (1, 0), (2, 1))
    edges[:] = [r.replace("></edge>", '><lane index="0" allow="bus"/></edge>') if r.startswith('<edge id="F4"') else r for r in edges]
    # At a the lanes below the viaduct are one for straight on and one for the left; at b each arm has green alone.
    nodes[:] = [r.replace("/>", ' tlLayout="incoming"/>') if r.startswith(('<node id="bs"', '<node id="bn"')) else r for r in nodes]
    for before, on, left in (("anas", "asaz", "F2"), ("asan", "anaq", "H6")):
        links += ahead(before, on, (0, 0), (0, 1)) + ahead(before, left, (1, 1))
    for tag, x0 in (("a", fx["as"]), ("b", fx["bs"])):
        y0 = bow(x0)
        nodes += [node(f"{tag}z", x0 + jolt(), y0 - 260), node(f"{tag}q", x0 + jolt(), y0 + 260)]
        two_way(edges, f"{tag}z", f"{tag}s", 2, 13.89, "highway.tertiary", 7)
        two_way(edges, f"{tag}s", f"{tag}n", 2, 13.89, "highway.tertiary", 7)
        two_way(edges, f"{tag}q", f"{tag}n", 2, 13.89, "highway.tertiary", 7)
    for name, at, end in (("tz", "t", (150, bow(130) - 190)), ("uq", "u", (170, bow(185) + 200))):
        nodes.append(node(name, *end))
        two_way(edges, name, at, 1, 11.11, "highway.residential", 4)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="0" period="38" number="6" from="F0" to="F9" departLane="best"><stop lane="F4_0" startPos="50" endPos="68" duration="11"/></flow>',
        *(f'<flow id="rush{i}" type="{kind}" begin="0" period="{p}" number="{int(240 / p)}" from="{a}" to="{b}" departLane="best" departSpeed="max"/>' for i, (kind, a, b, p) in enumerate((
            ("truck", "W0", "W6", 9), ("car", "W0", "W6", 5), ("car", "E0", "E6", 7), ("truck", "E0", "out2", 31), ("van", "azas", "E6", 41), ("truck", "bqbn", "W6", 43))))]))
    return ["--no-turnarounds", "--tls.cycle.time", 64, "--tls.yellow.time", 4, "--junctions.corner-detail", 5]


def crossings(work, draw):
    """Crossings of avenues of three and four lanes with a phase for left turns and turning round; one whose arms have green
    one by one; one of lesser streets without such phases, in which who turns left waits far inside; a crossing for people
    with lights of its own; a roundabout of two lanes and five arms; bays for buses; vans that deliver on the right lane.
    """
    main, cross, street = "highway.primary", "highway.secondary", "highway.tertiary"
    y = lambda x: 22 * math.cos(x / 260)
    jolt = lambda: draw.uniform(-10, 10)
    at = {"w": -640, "r": -395 + jolt(), "p": 0, "k1": 130, "k2": 240, "s": 315, "q": 475 + jolt(), "c4": 741, "c0": 799}
    kinds = {"r": "traffic_light", "p": "traffic_light", "q": "traffic_light", "s": "traffic_light"}
    nodes, edges, links = [], [], []
    for n in ("w", "r", "p", "k1", "k2", "q"):
        row = node(n, at[n], y(at[n]), kinds.get(n, "priority"))
        nodes.append(row.replace("/>", ' tlLayout="incoming"/>') if n == "q" else row)
    far = at["s"]
    nodes.append(drawn(node("s", far, y(far), "traffic_light"), far, y(far), (y(far + 5) - y(far - 5)) / 10, 3, 3, 11, 11))
    ring(edges, nodes, "c", 770, y(770), 29, 2, [5, 75, 130, 180, 262], 10.0)
    # The ring's nodes by angle: c0 at 5, c1 at 75, c2 at 130, c3 at 180, c4 at 262 degrees.
    at["c3"] = 741
    place = {n: (at[n], y(at[n])) for n in at}

    def road(a, b, lanes, limit, kind, rank, bay=0, shape=()):
        """One way; the last meters have a lane more on the left, and are a road of their own by the name `b`-`a`."""
        (xa, ya), (xb, yb) = place[a], place[b]
        if not bay:
            edges.append(edge(f"{a}{b}", a, b, lanes, limit, kind, rank, shape))
            return
        xm = xb + (xa - xb) * bay / math.hypot(xa - xb, ya - yb)
        mid = f"{b}m{a}"
        nodes.append(node(mid, xm, y(xm) if kind == main else yb + (ya - yb) * bay / math.hypot(xa - xb, ya - yb)))
        edges.extend((edge(f"{a}{b}", a, mid, lanes, limit, kind, rank, [p for p in shape if min(xa, xm) < p[0] < max(xa, xm)]), edge(f"{b}-{a}", mid, b, lanes + 1, limit, kind, rank)))
        links.extend(ahead(f"{a}{b}", f"{b}-{a}", *((i, i) for i in range(lanes)), (lanes - 1, lanes)))

    for a, b, lanes, bays in (("w", "r", 3, (0, 0)), ("r", "p", 3, (75, 0)), ("p", "k1", 3, (0, 65)), ("k2", "s", 3, (0, 0)), ("s", "q", 3, (60, 0)), ("q", "c3", 2, (0, 60))):
        for start, end, bay in ((a, b, bays[0]), (b, a, bays[1])):
            # A filling station on one side only: who comes from the other one turns round at the next crossing.
            stop = {"rp": ("g", 0.42, -1), "c3q": ("j", 0.45, 1)}.get(start + end)
            if stop:
                n, share, side = stop
                x = at[start] + (at[end] - at[start]) * share
                place[n], place[n + "y"] = (x, y(x)), (x + side * 12, y(x) + side * 85)
                nodes.extend(node(spot, *place[spot]) for spot in (n, n + "y"))
                two_way(edges, n + "y", n, 1, 8.33, "highway.service", 2)
                road(start, n, lanes, 16.67, main, 9, 0, between(at[start], x, y, 4))
                links.append(f'<delete from="{n}y{n}" to="{n}{n}y"/>')
                start = n
            shape = between(place[start][0], at[end], y, 5) if abs(at[end] - place[start][0]) > 120 else ()
            road(start, end, lanes, 16.67, main, 9, bay, shape)
    # Bays for buses on both sides between k1 and k2.
    for a, b in (("k1", "k2"), ("k2", "k1")):
        edges.append(edge(a + b, a, b, 4, 16.67, main, 9).replace("></edge>", '><lane index="0" allow="bus"/></edge>'))
    for before, bay, after in (("pk1", "k1k2", "k2s"), ("sk2", "k2k1", "k1p")):
        links += ahead(before, bay, (0, 1), (1, 2), (2, 3)) + ahead(bay, after, (1, 0), (2, 1), (3, 2))
    for n, lanes, limit, kind, bay in (("p", 3, 13.89, cross, 60), ("q", 2, 13.89, cross, 45), ("r", 1, 11.11, street, 60)):
        for tag, sign in (("n", 1), ("z", -1)):
            end = n + tag
            place[end] = (at[n] + jolt() * 2, y(at[n]) + sign * 250)
            nodes.append(node(end, *place[end]))
            road(end, n, lanes, limit, kind, 8 if lanes > 1 else 6, bay)
            road(n, end, lanes, limit, kind, 8 if lanes > 1 else 6)
    for end, arm, dx, dy in (("ce", "c0", 240, 20), ("cn", "c1", 60, 215), ("cm", "c2", -150, 190), ("cz", "c4", -30, -230)):
        nodes.append(node(end, 770 + dx, y(770) + dy))
        two_way(edges, end, arm, 2 if end in ("ce", "cn") else 1, 13.89, cross, 7)
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    # At p and q the leftmost lane turns left and round. At r who comes from the street and turns left waits far inside.
    for before, straight, left, right, back in (("p-g", "pk1", "ppn", "ppz", "pr"), ("p-k1", "pr", "ppz", "ppn", "pk1"), ("p-pn", "ppz", "pk1", "pr", "ppn"), ("p-pz", "ppn", "pr", "pk1", "ppz")):
        links += ahead(before, straight, (0, 0), (1, 1), (2, 2)) + ahead(before, right, (0, 0)) + ahead(before, left, (3, 2)) + ahead(before, back, (3, 2))
    for before, straight, left, right, back, lanes in (("q-s", "qc3", "qqn", "qqz", "qs", 3), ("q-j", "qs", "qqz", "qqn", "qc3", 2), ("q-qn", "qqz", "qc3", "qs", "qqn", 2), ("q-qz", "qqn", "qs", "qc3", "qqz", 2)):
        wide = {"qs": 2, "qc3": 1}.get(straight, 1)
        links += ahead(before, straight, *((i, min(i, wide)) for i in range(lanes) if i <= wide)) + ahead(before, right, (0, 0))
        links += ahead(before, left, (lanes, 2 if left == "qs" else 1)) + ahead(before, back, (lanes, 2 if back == "qs" else 1))
    deep = lambda start, end, a, b: link(start, end, a, b).replace("/>", ' contPos="8"/>')
    for before, straight, left, right in (("r-rn", "rrz", "rg", "rw"), ("r-rz", "rrn", "rw", "rg")):
        links += [link(before, straight, 0, 0), link(before, right, 0, 0), deep(before, left, 1, 2)]
    for before, straight, left, right in (("wr", "rg", "rrn", "rrz"), ("pr", "rw", "rrz", "rrn")):
        links += ahead(before, straight, (0, 0), (1, 1)) + ahead(before, right, (0, 0)) + ahead(before, left, (2, 0)) + ahead(before, "rg" if before == "pr" else "rw", (2, 2))
    links.append('<crossing node="s" edges="k2s sk2" width="5"/>')
    document(work / "con.xml", "connections", links)
    (work / "parked.txt").write_text("\n".join([
        '<flow id="line" type="coach" begin="0" period="100" number="3" from="wr" to="c0ce" departLane="best"><stop lane="k1k2_1" startPos="32" endPos="50" duration="10"/></flow>',
        '<flow id="back" type="coach" begin="0" period="105" number="3" from="cec0" to="rw" departLane="best"><stop lane="k2k1_1" startPos="32" endPos="50" duration="13"/></flow>',
        '<flow id="parcel" type="van" begin="0" period="75" number="3" from="wr" to="ppn"><stop lane="rg_1" startPos="90" endPos="100" duration="26"/></flow>',
        '<flow id="sweep" type="van" begin="0" period="85" number="3" from="cnc1" to="qqz" speedFactor="0.19"/>',
        *(f'<flow id="turn{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}" departLane="best"/>' for i, (kind, a, b, p) in enumerate((
            ("car", "wr", "rw", 33), ("car", "pnp", "ppn", 29), ("van", "pzp", "ppz", 41), ("truck", "wr", "c0ce", 43), ("car", "rnr", "c0ce", 31), ("car", "rzr", "rw", 29)))),
        '<personFlow id="cross" type="walker" begin="0" end="270" period="exp(0.12)"><walk from="k2s" to="sk2"/></personFlow>']))
    return ["--no-turnarounds", "--roundabouts.guess", "--default.junctions.radius", 6, "--junctions.corner-detail", 5, "--tls.cycle.time", 80, "--tls.yellow.time", 3, "--tls.left-green.time", 9, "--sidewalks.guess", "--sidewalks.guess.max-speed", 17]


def hamlet(work, draw):
    """A village street in bends with offset side streets, crossings of four arms at which nobody, who comes from the right,
    or all have to wait, a very small roundabout, crossings for people away from junctions; an old part behind it of narrow
    streets with cars at the kerb and vans that deliver in the lane.
    """
    y = lambda x: 20 * math.sin(x / 95) + 0.05 * x
    jolt = lambda: draw.uniform(-7, 7)
    line = {"w": -620, "m2": -393, "m0": -367, "b1": -285, "b2": -248, "z1": -185, "x": -120, "g": -10, "z2": 62, "d1": 130, "d2": 172, "k": 255, "a": 355, "z3": 430, "e": 640}
    kinds = {"x": "priority", "g": "right_before_left", "k": "priority_stop", "a": "allway_stop"}
    at = {n: x + (jolt() if n in "xgka" else 0) for n, x in line.items()}
    nodes, edges, main, street = [], [], "highway.tertiary", "highway.residential"
    ring(edges, nodes, "m", -380, y(-380), 12, 1, [0, 95, 182, 275], 6.5)
    for n, x in at.items():
        if n in ("m2", "m0"):
            continue
        row = node(n, x, y(x), kinds.get(n, "priority"))
        if n[0] == "z":
            # Nothing but a crossing for people: the junction is drawn so that there is room for it.
            row = drawn(row, x, y(x), (y(x + 3) - y(x - 3)) / 6, 2.5, 2.5, 6.2, 6.2)
        nodes.append(row)
    names = list(line)
    for a, b in zip(names, names[1:]):
        if (a, b) != ("m2", "m0"):
            two_way(edges, a, b, 1, 13.89 if a in ("w", "z3") else 11.11 if a in ("x", "z2", "d2") else 9.72, main, 7, shape=between(at[a], at[b], y, max(2, int((at[b] - at[a]) / 25))) if at[b] - at[a] > 50 else ())
    # Side streets: b1 and d2 to the north, b2 and d1 to the south, four arms at x, g, k and a.
    ends = {"xn": (-140, 135), "xz": (-105, -190), "gn": (5, 128), "gz": (-25, -120), "b1n": (-300, 165), "b2z": (-235, -160), "d1z": (120, -128), "d2n": (190, 140), "kn": (270, 150), "kz": (240, -125), "an": (345, 190), "az": (370, -200), "mn": (-395, 225), "mz": (-365, -225)}
    nodes += [node(n, u + jolt(), v + jolt(), "right_before_left" if n in ("xn", "gn", "gz", "d1z", "d2n", "kn", "kz") else "priority") for n, (u, v) in ends.items()]
    for a, b, limit in (("xn", "x", 8.33), ("xz", "x", 8.33), ("gn", "g", 8.33), ("gz", "g", 8.33), ("b1n", "b1", 11.11), ("b2z", "b2", 11.11), ("d1z", "d1", 8.33), ("d2n", "d2", 8.33), ("kn", "k", 8.33), ("kz", "k", 8.33), ("an", "a", 11.11), ("az", "a", 11.11), ("mn", "m1", 11.11), ("mz", "m3", 11.11)):
        two_way(edges, a, b, 1, limit, street, 4)
    # The old part: narrow streets behind, and ways out of it.
    nodes += [node("o1", 60 + jolt(), -225, "right_before_left"), node("o2", 180 + jolt(), -215, "right_before_left"), node("oend", 45, -330), node("pend", 200, -330), node("u1", 95 + jolt(), 235, "right_before_left"), node("uend", 100, 345), node("xend", -190, 240), node("kend", 300, 270)]
    for a, b, limit in (("xn", "gn", 8.33), ("gn", "d2n", 8.33), ("d2n", "kn", 8.33), ("gz", "o1", 7.5), ("o1", "o2", 7.5), ("o2", "d1z", 7.5), ("d1z", "kz", 8.33), ("gz", "d1z", 7.5), ("o1", "oend", 8.33), ("o2", "pend", 8.33), ("gn", "u1", 8.33), ("u1", "d2n", 8.33), ("u1", "uend", 8.33), ("xn", "xend", 8.33), ("kn", "kend", 8.33)):
        two_way(edges, a, b, 1, limit, street, 3)
    edges[:] = [r.replace("<edge ", '<edge width="2.8" ', 1) if 'priority="3"' in r else r for r in edges]
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    around = [names[names.index(n) - 1] for n in ("z1", "z2", "z3")]
    document(work / "con.xml", "connections", [f'<crossing node="{n}" edges="{b}{n} {n}{b}" priority="true" width="4"/>' for n, b in zip(("z1", "z2", "z3"), around)])
    parks, still = [], []
    for road in ("gzo1", "o1o2", "gnd2n", "gnu1", "d1zkz", "xngn"):
        parks.append(f'<parkingArea id="kerb{road}" lane="{road}_1" startPos="22" endPos="57" roadsideCapacity="5" width="2.0" length="6.5"/>')
        still += [f'<trip id="still{road}{i}" type="{draw.choice(("car", "quick", "van"))}" depart="0.0" from="{road}" to="{road}" departPos="stop" arrivalPos="max"><stop parkingArea="kerb{road}" duration="9999"/></trip>' for i in range(draw.randint(2, 5))]
    document(work / "parked.add.xml", "additional", parks)
    walks = (("b2z1", "xz1", 22), ("z1b2", "z1x", 25), ("gz2", "d1z2", 21), ("z2g", "z2d1", 19), ("az3", "ez3", 24), ("z3a", "z3e", 20))
    (work / "parked.txt").write_text("\n".join([
        *still,
        *(f'<flow id="through{i}" type="{kind}" begin="0" period="{p}" number="{int(260 / p)}" from="{a}" to="{b}"/>' for i, (kind, a, b, p) in enumerate((("car", "wm2", "z3e", 29), ("car", "ez3", "m2w", 31), ("truck", "wm2", "aan", 61), ("van", "ez3", "m1mn", 55)))),
        '<flow id="post" type="van" begin="0" period="70" number="4" from="xendxn" to="z3e"><stop lane="gnd2n_1" startPos="75" endPos="82" duration="22"/></flow>',
        '<flow id="bread" type="van" begin="0" period="80" number="3" from="ez3" to="o1oend"><stop lane="kd2_1" startPos="20" endPos="28" duration="20"/></flow>',
        '<flow id="tractor" type="van" begin="0" period="90" number="3" from="mnm1" to="z3e" speedFactor="0.24"/>',
        *(f'<flow id="rider{a}" type="cycle" begin="0" period="{p}" number="{int(230 / p)}" from="{a}" to="{b}"/>' for a, b, p in (("wm2", "z3e", 33), ("kendkn", "b2b2z", 39), ("aza", "xxn", 41))),
        *(f'<personFlow id="foot{i}" type="walker" begin="0" end="270" period="exp({1 / p:.4f})" departPos="{25 if a[0] != "z" else 5}"><walk from="{a}" to="{b}" arrivalPos="{-20 if b[-1] == "z" else 20}"/></personFlow>' for i, (a, b, p) in enumerate(walks))]))
    return ["--no-turnarounds", "--roundabouts.guess", "--junctions.corner-detail", 5, "--sidewalks.guess", "--crossings.guess"]


def contraflow(work, draw):
    """Eastwards: a rest area, works past which the third lane is led beside the oncoming traffic, an entry by a lane that
    stays, a lane that becomes an exit. Westwards: an exit of two lanes, of which one also goes on, an entry, three lanes
    into two and then one by turns beside the works, two again.
    """
    main, ramp = "motorway", "motorway_link"
    bow = lambda x: 45 * math.sin(x / 640)
    nodes, edges, links = [], [], []
    x = {n: s + draw.uniform(-15, 15) for n, s in (("e1", -1640), ("e2", -1400), ("e3", -1030), ("e4", -780), ("e5", -480), ("e6", 420), ("e7", 700), ("e8", 1180), ("w1", 1520), ("w2", 1240), ("w3", 830), ("w4", 590), ("w5", 455), ("w6", -20), ("wx", -540), ("w7", -1150), ("w8", -1400))}
    x |= {"e0": -2000, "e9": 2000, "w0": 2000, "w9": -2000}
    fast, mid, slow = 33.33, 27.78, 22.22

    def along(tag, off, parts):
        for name, _, _, control in parts:
            row, at = node(name, x[name], bow(x[name]) + off, control), x[name]
            # By turns, over 50 m.
            nodes.append(drawn(row, at, bow(at) + off, (bow(at + 5) - bow(at - 5)) / 10, 25, 25, 0.2, 3.2 * 3 + 0.2) if control == "zipper" else row)
        for i, ((a, lanes, limit, _), (b, *_)) in enumerate(zip(parts, parts[1:])):
            edges.append(edge(f"{tag}{i}", a, b, lanes, limit, main, 13, between(x[a], x[b], lambda s: bow(s) + off, max(3, int(abs(x[b] - x[a]) / 60)))))

    p = "priority"
    along("E", -8, (("e0", 3, fast, p), ("e1", 4, fast, p), ("e2", 3, fast, p), ("e3", 4, fast, p), ("e4", 3, mid, p), ("e5", 2, slow, p), ("e6", 3, mid, p), ("e7", 4, fast, p), ("e8", 3, fast, p), ("e9", 0, 0, p)))
    along("W", 8, (("w0", 3, fast, p), ("w1", 4, fast, p), ("w2", 3, fast, p), ("w3", 4, mid, p), ("w4", 3, mid, p), ("w5", 2, slow, "zipper"), ("w6", 1, 16.67, "zipper"), ("wx", 2, mid, p), ("w7", 3, fast, p), ("w8", 2, fast, p), ("w9", 0, 0, p)))
    over = [(x["e5"] + d, bow(x["e5"] + d) - 8 + m) for d, m in ((45, 1.5), (90, 5), (135, 9), (180, 12.5), (225, 14))]
    back = [(x["e6"] - d, bow(x["e6"] - d) - 8 + m) for d, m in ((225, 14), (180, 12.5), (135, 9), (90, 5), (45, 1.5))]
    edges.append(edge("C0", "e5", "e6", 1, 16.67, main, 12, [*over, *between(over[-1][0], back[0][0], lambda s: bow(s) + 6, 8), *back]))
    links += ahead("E0", "E1", (0, 1), (1, 2), (2, 3)) + ahead("E1", "E2", (1, 0), (2, 1), (3, 2)) + ahead("E2", "E3", (0, 1), (1, 2), (2, 3)) + ahead("E3", "E4", (1, 0), (2, 1), (3, 2))
    links += ahead("E4", "E5", (0, 0), (1, 1)) + ahead("E4", "C0", (2, 0)) + ahead("E5", "E6", (0, 0), (1, 1)) + ahead("C0", "E6", (0, 2)) + ahead("E6", "E7", (0, 1), (1, 2), (2, 3)) + ahead("E7", "E8", (1, 0), (2, 1), (3, 2))
    links += ahead("W0", "W1", (0, 1), (1, 2), (2, 3)) + ahead("W1", "W2", (1, 0), (2, 1), (3, 2)) + ahead("W2", "W3", (0, 1), (1, 2), (2, 3)) + ahead("W3", "W4", (1, 0), (2, 1), (3, 2)) + ahead("W4", "W5", (0, 0), (1, 0), (2, 1))
    links += ahead("W5", "W6", (0, 0), (1, 0)) + ahead("W6", "W7", (0, 0), (0, 1)) + ahead("W7", "W8", (0, 1), (1, 2)) + ahead("W8", "W9", (1, 0), (2, 1))

    def ramped(name, at, off, way, base, lanes, road, enters, pairs, limit=19.44):
        """A ramp that leaves along `way`, or comes from the other side, on the right, `base` meters off the line."""
        side = math.copysign(1, off)
        px = lambda d: x[at] + (-way if enters else way) * d
        spots = [(px(d), bow(px(d)) + off + side * (base + m)) for d, m in ((25, 0.2), (60, 1.8), (100, 6), (140, 13))]
        nodes.append(node(f"{name}x", px(205), bow(px(205)) + off + side * (base + 31)))
        edges.append(edge(name, *((f"{name}x", at, lanes, limit, ramp, 8, spots[::-1]) if enters else (at, f"{name}x", lanes, limit, ramp, 8, spots))))
        links.extend(ahead(name, road, *pairs) if enters else ahead(road, name, *pairs))

    ramped("rest", "e2", -8, 1, 9.6, 1, "E1", False, ((0, 0),), 16.67)
    ramped("rejoin", "e3", -8, 1, 9.6, 1, "E3", True, ((0, 0),))
    nodes.append(node("lot", (x["e2"] + x["e3"]) / 2, bow((x["e2"] + x["e3"]) / 2) - 62))
    edges += [edge("park0", "restx", "lot", 1, 8.33, "service", 4), edge("park1", "lot", "rejoinx", 1, 8.33, "service", 4)]
    links += ahead("rest", "park0", (0, 0)) + ahead("park0", "park1", (0, 0)) + ahead("park1", "rejoin", (0, 0))
    ramped("in2", "e7", -8, 1, 9.6, 1, "E7", True, ((0, 0),))
    ramped("out2", "e8", -8, 1, 9.6, 1, "E7", False, ((0, 0),))
    ramped("out3", "w2", 8, -1, 9.6, 2, "W1", False, ((0, 0), (1, 1)))
    ramped("in3", "w3", 8, -1, 9.6, 1, "W3", True, ((0, 0),))
    ramped("in4", "w7", 8, -1, 6.4, 1, "W8", True, ((0, 0),))
    document(work / "nod.xml", "nodes", nodes)
    document(work / "edg.xml", "edges", edges)
    document(work / "con.xml", "connections", links)
    hauls = (("truck", "E0", "E8", 11, ' via="park0"'), ("van", "E0", "E8", 13, ' via="park0"'), ("van", "E0", "E8", 9, ""), ("truck", "in2", "E8", 8, ""), ("car", "in2", "E8", 8, ""), ("van", "in2", "out2", 21, ""), ("truck", "in3", "W9", 11, ""),
             ("car", "in3", "W9", 11, ""), ("truck", "in4", "W9", 7, ""), ("van", "in4", "W9", 8, ""), ("car", "W0", "W9", 9, ""), ("truck", "W0", "out3", 13, ""))
    (work / "parked.txt").write_text("\n".join(f'<flow id="haul{i}" type="{kind}" begin="0" period="{p}" number="{int(210 / p)}" from="{a}" to="{b}"{via} departLane="best" departSpeed="max"/>' for i, (kind, a, b, p, via) in enumerate(hauls)))
    return ["--no-turnarounds"]
