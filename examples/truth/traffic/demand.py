"""Who drives and walks where, drawn from a seed. Each function yields route elements by departure; egos are the vehicles whose id begins with `ego`."""


def vehicle(name, kind, depart, start, end, via="", **more):
    extra = "".join(f' {k}="{w}"' for k, w in more.items())
    return depart, f'<trip id="{name}" type="{kind}" depart="{depart:.1f}" from="{start}" to="{end}"{extra}>{via}</trip>'


def walker(name, depart, start, end):
    return depart, f'<person id="{name}" type="walker" depart="{depart:.1f}"><walk from="{start}" to="{end}"/></person>'


def city(draw, seconds):
    ends = ["sA", "sB", "nA", "nB", "w0", "w1", "e0", "e1"]
    joint = {"sA": "A0", "sB": "B0", "nA": "A1", "nB": "B1", "w0": "A0", "w1": "A1", "e0": "B0", "e1": "B1"}
    egos = 0
    for i in range(int(seconds * 0.62)):
        t = i / 0.62
        a, b = draw.sample(ends, 2)
        kind = draw.choices(["brisk", "calm", "hasty", "lorry"], [5, 3, 2, 1])[0]
        ego = 12 < t < seconds - 60 and i % 6 == 3
        egos += ego
        yield vehicle(f"ego{egos}" if ego else f"c{i}", "brisk" if ego else kind, t, a + joint[a], joint[b] + b, departLane="best", departSpeed="desired")
    for i in range(int(seconds / 22)):
        a, b = draw.sample(["w0", "e0"], 2)
        yield vehicle(f"egobus{i}" if i == 1 else f"b{i}", "bus", i * 22 + 3, a + joint[a], joint[b] + b, departLane="random", departSpeed="desired")
    for i in range(int(seconds / 9)):
        a, b = draw.sample(ends, 2)
        yield vehicle(f"k{i}", "bicycle", i * 9 + 1, a + joint[a], joint[b] + b, departLane="best")
    inner = ["A0A1", "B0B1", "A0B0", "A1B1", "A1A0", "B1B0", "B0A0", "B1A1"]
    for i in range(int(seconds / 3)):
        a = draw.choice(ends)
        yield walker(f"p{i}", max(0.0, i * 3 - 40), a + joint[a], draw.choice(inner + [joint[b] + b for b in ends if b != a]))


def quarter(draw, seconds):
    ends = {"pw": "P", "ps": "P", "rs": "R", "re": "R", "se": "S", "sn": "S", "tn": "T"}
    egos = 0
    for i in range(int(seconds * 0.42)):
        t = i / 0.42
        a, b = draw.sample(list(ends), 2)
        kind = draw.choices(["brisk", "calm", "hasty", "lorry"], [5, 4, 2, 1])[0]
        ego = 8 < t < seconds - 45 and i % 4 == 2
        egos += ego
        yield vehicle(f"ego{egos}" if ego else f"c{i}", "brisk" if ego else kind, t, a + ends[a], ends[b] + b, departSpeed="desired")
    for i in range(int(seconds / 14)):
        a, b = draw.sample(list(ends), 2)
        yield vehicle(f"k{i}", "bicycle", i * 14 + 1, a + ends[a], ends[b] + b)
    for i in range(int(seconds / 4)):
        a, b = draw.sample(list(ends), 2)
        yield walker(f"p{i}", max(0.0, i * 4 - 60), a + ends[a], ends[b] + b)


def ring(draw, seconds):
    arms = "ENWS"
    egos = 0
    for i in range(int(seconds * 0.5)):
        t = i / 0.5
        a, b = draw.sample(arms, 2)
        kind = draw.choices(["brisk", "calm", "hasty", "lorry"], [5, 3, 2, 1])[0]
        ego = 8 < t < seconds - 45 and i % 5 == 2
        egos += ego
        yield vehicle(f"ego{egos}" if ego else f"c{i}", "brisk" if ego else kind, t, f"o{a}r{a}", f"r{b}o{b}", departLane="random", departSpeed="desired")


def motorway(draw, seconds):
    egos = 0
    for i in range(int(seconds * 0.8)):
        t = i / 0.8
        start = "q0_q1" if i % 4 == 1 else "m0_on"
        end = "f1_f9" if draw.random() < 0.22 else "drop_m9"
        kind = draw.choices(["brisk", "calm", "hasty", "lorry"], [5, 3, 2, 2])[0]
        ego = 5 < t < seconds - 60 and i % 9 == 5
        egos += ego
        yield vehicle(f"ego{egos}" if ego else f"c{i}", ("brisk" if egos % 3 else "hasty") if ego else kind, t, start, end, departLane="random" if start == "m0_on" else "0", departSpeed="desired" if start == "m0_on" else "18")


def hills(draw, seconds):
    egos = 0
    routes = [("h0h1", "h8h9"), ("h9h8", "h1h0"), ("s5h5", "h8h9"), ("n5h5", "h1h0"), ("h0h1", "h5n5"), ("h9h8", "h5s5")]
    for i in range(int(seconds * 0.11)):
        t = i / 0.11
        a, b = draw.choices(routes, [5, 5, 2, 2, 2, 2])[0]
        kind = draw.choices(["brisk", "calm", "lorry"], [5, 4, 2])[0]
        ego = t < seconds - 120 and i % 2 == 0
        egos += ego
        yield vehicle(f"ego{egos}" if ego else f"c{i}", "brisk" if ego else kind, t, a, b, departSpeed="desired")


DEMANDS = {"city": city, "quarter": quarter, "ring": ring, "motorway": motorway, "hills": hills}
SECONDS = {"city": 170, "quarter": 130, "ring": 130, "motorway": 150, "hills": 230}
