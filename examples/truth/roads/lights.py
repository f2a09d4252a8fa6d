"""Drives over crossroads with lights that the script switches: stops, starts, greens that come in time, flashing lights, waiting areas.

A scene is a generator: each step it is told time, station and speed, sets lights through the simulator and gives or lifts orders. When
it set which light is written down for truth.py. Other than in `along`, the simulator's driver leaves the lights to the script.
"""

from along import Layout
from drive import Order, traci
from network import Cross, Net

LIGHT = "reactive_rule.traffic_light"


def show(node, letter):
    """The road gets `letter`, the crossing road red (all the same where the lights flash)."""
    state = list(traci.trafficlight.getRedYellowGreenState(node))
    for i, links in enumerate(traci.trafficlight.getControlledLinks(node)):
        along = links and links[0][0].startswith("e")
        state[i] = letter if along or letter in "oO" else "r"
    traci.trafficlight.setRedYellowGreenState(node, "".join(state))


class Crossroads(Layout):
    def crossroads(self, wide=1):
        """Lays a crossroads; scenes get its node and the piece before it."""
        self.road.cross(Cross(lights=True, wide=wide))
        self.drive.lit, self.drive.mode = True, 7
        i = len(self.road.pieces)
        self.straight(self.draw.uniform(150, 190))
        return i

    def line(self, i):
        """Station of the stop line: where the lane before the node ends."""
        x, y, _ = self.net.line(self.net.lanes[f"e{i - 1}_0"])[-1]
        nx, ny, *_ = self.road.at(self.road.starts[i])
        return self.road.starts[i] - ((x - nx) ** 2 + (y - ny) ** 2) ** 0.5


def halt(b, at, decel):
    """An order to stand at a station until it is lifted."""
    b.count += 1
    order = Order(f"o{b.count}", at, at + 1, 0.0, decel, wait=1e9)
    b.drive.orders.append(order)
    return order


def red(b, i):
    line, draw = b.line(i), b.draw
    back, decel, hold, late = draw.uniform(0.5, 2), draw.uniform(1.4, 2.2), draw.uniform(2.5, 8), draw.uniform(0.2, 1.0)
    yield
    show(f"n{i}", "r")
    order = halt(b, line - back, decel)
    b.note("stops", f"{LIGHT}.red_stop", line, line, order.name, turned=0.0)
    yield from released(b, i, order, line, hold, late)


def released(b, i, order, line, hold, late):
    """Stands for a while; the light turns green, and a moment later the car moves off."""
    while order.stood < hold:
        t, *_ = yield
    show(f"n{i}", "G")
    b.note("resumes", f"{LIGHT}.resume_first", line, line, order.name, turned=t)
    while (yield)[0] < t + late:
        pass
    order.stood = -1
    yield True


def yellow(b, i):
    line, draw = b.line(i), b.draw
    decel, hold, late, think = draw.uniform(1.9, 2.4), draw.uniform(3, 8), draw.uniform(0.2, 1.0), draw.uniform(0.4, 0.9)
    room = b.drive.v0**2 / 2 / decel + think * b.drive.v0 + draw.uniform(2, 8)
    yield
    show(f"n{i}", "G")
    while True:
        t, s, _ = yield
        if s > line - room:
            break
    show(f"n{i}", "y")
    while (yield)[0] < t + think:
        pass
    order = halt(b, line - draw.uniform(0.5, 2), decel)
    b.note("stops", f"{LIGHT}.yellow_stop", line, line, order.name, turned=t)
    while (yield)[0] < t + 3.5:
        pass
    show(f"n{i}", "r")
    yield from released(b, i, order, line, hold, late)


def green(b, i):
    """Rolls up to a red light that turns green in time."""
    line, draw = b.line(i), b.draw
    slow, turns = draw.uniform(5.5, 7.5), draw.uniform(22, 45)
    yield
    show(f"n{i}", "r")
    b.count += 1
    order = Order(f"o{b.count}", line - 30, line + 5, slow, draw.uniform(1.0, 1.5))
    b.drive.orders.append(order)
    while True:
        t, s, v = yield
        if s > line - turns and v < b.drive.v0 - 3:
            break
    show(f"n{i}", "G")
    b.note("turned", f"{LIGHT}.green_pass", line, line, order.name, turned=t)
    while (yield)[0] < t + 0.5:
        pass
    order.s1 = -1
    yield True


def steady(b, i):
    """A green that has been there all along asks nothing."""
    line = b.line(i)
    yield
    show(f"n{i}", "G")
    b.note("passage", "proactive.turn.straight", line, line + 2 * (b.road.starts[i] - line))
    yield True


def early(b, i):
    """Red far off, green before it concerns the car."""
    line, turns = b.line(i), b.draw.uniform(95, 120)
    yield
    show(f"n{i}", "r")
    while (yield)[1] < line - turns:
        pass
    show(f"n{i}", "G")
    b.note("passage", "proactive.turn.straight", line, line + 2 * (b.road.starts[i] - line))
    yield True


def warned(answers):
    def scene(b, i):
        line = b.line(i)
        yield
        show(f"n{i}", "o")
        if answers:
            order = b.order(line - b.draw.uniform(5, 12), line + 4, b.slower(4, 6), decel=b.draw.uniform(1.2, 1.6))
            b.note("control80", f"{LIGHT}.warning_light", line, line + 4, order)
        yield True
    return scene


def area(b, i):
    """A waiting area behind the line: the car crosses the line on red and stands in it."""
    line, draw = b.line(i), b.draw
    hold, late = draw.uniform(4, 8), draw.uniform(0.2, 1.0)
    begins, ends = line + 1, line + 10
    b.drive.areas.append(("waiting_area", b.road.box(begins, ends, -1.7, 1.7)))
    yield
    show(f"n{i}", "r")
    order = halt(b, ends - draw.uniform(0.5, 2), draw.uniform(1.0, 1.4))
    b.note("enters", f"{LIGHT}.wait_area_entry", begins, ends, order.name)
    while order.stood < hold:
        t, *_ = yield
    show(f"n{i}", "G")
    while (yield)[0] < t + late:
        pass
    order.stood = -1
    yield True


def cars(b, i):
    """Cars that stand before the light from the beginning."""
    end = b.net.length(f"e{i - 1}_0")
    route = " ".join(f"e{k}" for k in range(i - 1, len(b.road.pieces)))
    return f'<route id="on{i}" edges="{route}"/>' + "".join(
        f'<vehicle id="queued{i}_{k}" type="car" route="on{i}" depart="0" departLane="0" departSpeed="0" departPos="{end - 1 - 7.2 * k:.1f}"/>'
        for k in reversed(range(b.draw.choice([1, 2, 3]))))


def queue(b, i):
    """Cars that stand at the red light go first."""
    line, hold = b.line(i), b.draw.uniform(3, 7)
    yield
    show(f"n{i}", "r")
    stood = 0.0
    while stood < hold:
        t, s, v = yield
        stood += 0.1 if v < 0.1 and s > line - 40 else 0.0
    show(f"n{i}", "G")
    b.note("resumes", f"{LIGHT}.resume_follow", line, line, turned=t)
    yield True


SCENES = {"red": (red, 3), "yellow": (yellow, 3), "green": (green, 3), "steady": (steady, 1), "early": (early, 1), "warned": (warned(True), 3),
          "unwarned": (warned(False), 1), "area": (area, 3)}


def drives(draw):
    """Each scene some times in drawn order, and at the end of each drive a queue, whose cars then drive ahead of the ego."""
    todo = [name for name, (_, times) in SCENES.items() for _ in range(times)]
    draw.shuffle(todo)
    per = 6
    for i in range(0, len(todo), per):
        yield f"light{i // per:02}", [*todo[i:i + per], "queue"]


def build(name, todo, draw, work):
    b = Crossroads(name, draw)
    crossings = [(scene, b.crossroads(wide=4 if scene == "area" else 1)) for scene in todo]
    drive = b.finish(work)
    b.net = Net(work)
    drive.scenes = [(queue if name == "queue" else SCENES[name][0])(b, i) for name, i in crossings]
    drive.demand = "".join(cars(b, i) for name, i in crossings if name == "queue")
    return drive
