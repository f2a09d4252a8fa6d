"""Drives over junctions without lights: stop and give-way signs, junctions that nobody can see into, lane arrows, turn-only lanes."""

from along import Layout
from network import ARM_M, Cross, Net

SIGN, SPOT, LANE = "reactive_rule.traffic_sign", "reactive_road.blind_spot_slowdown", "reactive_rule.special_lane"
# What a scene needs of the road is laid first; its orders need the stations of the finished network.


class Junctions(Layout):
    def junction(self):
        self.road.cross(Cross())
        i = len(self.road.pieces)
        self.straight(self.draw.uniform(150, 190))
        return i

    def line(self, i):
        """Station at which the junction begins."""
        x, y, _ = self.net.line(self.net.lanes[f"e{i - 1}_0"])[-1]
        nx, ny, *_ = self.road.at(self.road.starts[i])
        return self.road.starts[i] - ((x - nx) ** 2 + (y - ny) ** 2) ** 0.5


def stop(b, i, answers):
    line = b.line(i)
    b.sign("stop", line - 0.5)
    if answers:
        order = b.order(line - b.draw.uniform(0.5, 2), line, 0, wait=b.draw.uniform(0.5, 2.5), decel=b.draw.uniform(1.4, 2.0))
        b.note("control60", f"{SIGN}.stop_sign", line, line, order)


def give_way(b, i, answers):
    line = b.line(i)
    b.sign("yield", line - 0.5)
    if answers:
        order = b.order(line - 3, line + 2, b.draw.uniform(4, 7.5), decel=b.draw.uniform(1.3, 1.9))
        b.note("control60", f"{SIGN}.yield_sign", line, line, order)


def blind(b, i, answers):
    line = b.line(i)
    middle = b.road.starts[i]
    near = b.draw.uniform(3.2, 4.5)
    for left in (-1, 1):
        outer = left * (near + b.draw.uniform(12, 25))
        sides = sorted((left * near, outer))
        b.area("building", line - b.draw.uniform(25, 40), middle - b.draw.uniform(5.5, 7), *sides)
    if answers:
        order = b.order(line - 6, line + 2, b.slower(4, 6.5), decel=b.draw.uniform(1.2, 1.6))
        b.note("junction", f"{SPOT}.unsignalized", line, line, order)


def clear(b, i, answers):
    """Nothing stands there and nothing asks for anything."""
    line = b.line(i)
    b.note("passage", "proactive.turn.straight", line, line + 2 * (b.road.starts[i] - line))


SCENES = [(stop, True)] * 3 + [(stop, False)] + [(give_way, True)] * 3 + [(give_way, False)] + [(blind, True)] * 4 + [(blind, False)] * 2 + [(clear, True)]


def drives(draw):
    todo = list(SCENES)
    draw.shuffle(todo)
    per = 5
    for i in range(0, len(todo), per):
        yield f"junction{i // per:02}", todo[i:i + per]
    for i, (turn, scene) in enumerate([("right", "arrow"), ("left", "arrow"), ("right", "bound"), ("left", "bound"), ("right", "arrow"), ("left", "bound"),
                                       ("left", "arrow"), ("right", "bound")]):
        yield f"approach{i:02}", (turn, scene)


def build(name, todo, draw, work):
    if isinstance(todo, tuple):
        return approach(name, *todo, draw, work)
    b = Junctions(name, draw)
    crossings = [b.junction() for _ in todo]
    drive = b.finish(work)
    b.net = Net(work)
    drive.mode = 7
    for (scene, answers), i in zip(todo, crossings):
        scene(b, i, answers)
    return drive


def approach(name, side, scene, draw, work):
    """Two lanes before a junction, one of which is for turning only.

    `arrow`: the car goes straight on, starts in the lane for turning and leaves it on the word of the arrow board; the navigation says
    nothing but straight on. `bound`: the car turns, and moves into the lane that is for turning only although its own would do.
    """
    b = Junctions(name, draw, lanes=2)
    b.straight(draw.uniform(60, 110))
    right = side == "right"
    only, other = ("r", "s" if scene == "arrow" else "rs") if right else ("l", "s" if scene == "arrow" else "ls")
    b.road.cross(Cross(lanes=(only, other) if right else (other, only)))
    i = len(b.road.pieces)
    b.straight(draw.uniform(190, 240))
    turn_lane, through = (0, 1) if right else (1, 0)
    b.drive.lane = turn_lane if scene == "arrow" else through
    drive = b.finish(work)
    b.net = Net(work)
    line = b.line(i)
    if scene == "arrow":
        at = line - draw.uniform(15, 25)
        b.sign("lane_arrow", at, left=6 if not right else -6)
        move = at - draw.uniform(38, 52)
        drive.changes = [(move, through, "arrow")]
        drive.route_command = lambda s: "straight"
        b.note("arrow", f"{SIGN}.lane_arrow", at, at, move=move)
        return drive
    move = line - draw.uniform(85, 110)
    drive.changes = [(move, turn_lane, "bound")]
    drive.route_command = lambda s: side if s < line + 12 else "none"
    b.note("across", f"{LANE}.turn_only_{side}", move, move)
    b.order(line - 4, line + 14, 4.5, decel=1.5)
    k = 0 if side == "left" else 1
    drive.route = [f"e{n}" for n in range(i)] + [f"out{i}_{k}"]
    drive.until = line + ARM_M - 20
    drive.mode = 7
    return drive
