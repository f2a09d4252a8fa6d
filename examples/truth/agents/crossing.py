"""A crossroads without lights, as stage.py: everybody drives along a path of their own through it. One scene is one drive."""

import math
import os
import subprocess

import sumo
from stage import DT, Road, World, approach

ARM_M = 150
RADIUS_M = {"l": 10.5, "r": 6.5}
HEADING = {"W": 0.0, "S": 90.0, "E": 180.0, "N": 270.0}  # of who comes from there, degrees


def path(theta, lanes, width, come_from, turn, lane=0):
    """The way from an arm over the crossing; `lane` is counted from the right. Its s is 0 at the far end of the arm."""
    h = math.radians(HEADING[come_from]) + theta
    off = -(lanes - lane - 0.5) * width  # left of the middle line
    x, y = -ARM_M * math.cos(h) - off * math.sin(h), -ARM_M * math.sin(h) + off * math.cos(h)
    if turn == "s":
        return Road(2 * ARM_M, 1, width, [], (x, y, h))
    # The exit lane is as far from its road's middle as the lane of entry.
    sign = 1 if turn == "l" else -1
    radius = RADIUS_M[turn] + ((lanes - 1 - lane) if turn == "l" else lane) * width
    begin = ARM_M - radius - sign * off
    return Road(2 * ARM_M - 5, 1, width, [(begin, begin + radius * math.pi / 2, sign / radius)], (x, y, h))


class Crossing(World):
    def __init__(self, lanes, width, theta, draw):
        super().__init__(Road(10, 1, width, []), 10.0, draw)
        self.lanes, self.width, self.theta = lanes, width, theta
        self.paths = {}
        self.brake, self.pull = 2.0, 1.6

    def route(self, actor, come_from, turn, lane=0):
        self.paths[actor.id] = path(self.theta, self.lanes, self.width, come_from, turn, lane)
        self.note("route", actor, arm=come_from, turn=turn, lane=lane)

    def enters(self, type_, come_from, turn, to_middle, v, lane=0):
        """Somebody so many meters (of his path) before the middle of the crossing."""
        a = self.add(type_, ARM_M - to_middle, 0.0, v, move=along)
        a.memory["want"] = v
        self.route(a, come_from, turn, lane)
        return a

    def drive(self):
        ego = self.ego
        v = ego.v
        approach(ego, self.wish, accel=self.pull, brake=self.brake)
        ego.a = (ego.v - v) / DT
        ego.s += ego.v * DT

    def step(self):
        for a in self.actors:
            v = a.v
            a.move(a, self)
            a.a = (a.v - v) / DT
        self.drive()
        self.t = round(self.t + DT, 1)
        everybody = [self.ego, *(a for a in self.actors if 3 < a.s < 2 * ARM_M - 12)]
        self.rows.append((self.t, [self.row(a) for a in everybody]))

    def row(self, a):
        self.road = self.paths[a.id]
        return super().row(a)

    def write_net(self, folder):
        ends = {arm: (-ARM_M * math.cos(math.radians(h) + self.theta), -ARM_M * math.sin(math.radians(h) + self.theta)) for arm, h in HEADING.items()}
        nodes = '<node id="c" x="0" y="0" type="priority"/>' + "".join(f'<node id="{a}" x="{x:.2f}" y="{y:.2f}"/>' for a, (x, y) in ends.items())
        edges = "".join(f'<edge id="{a}in" from="{a}" to="c" numLanes="{self.lanes}" speed="13.89" width="{self.width}"/>'
                        f'<edge id="{a}out" from="c" to="{a}" numLanes="{self.lanes}" speed="13.89" width="{self.width}"/>' for a in ends)
        (folder / "n.nod.xml").write_text(f"<nodes>{nodes}</nodes>")
        (folder / "e.edg.xml").write_text(f"<edges>{edges}</edges>")
        order = "WSEN"
        links = []
        for k, a in enumerate(order):
            exits = {"r": order[(k + 1) % 4], "s": order[(k + 2) % 4], "l": order[(k + 3) % 4]}
            for turn, b in exits.items():
                links += [f'<connection from="{a}in" to="{b}out" fromLane="{i}" toLane="{i}"/>' for i in range(self.lanes)]
        (folder / "c.con.xml").write_text("<connections>" + "".join(links) + "</connections>")
        subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", "netconvert"), "-n", folder / "n.nod.xml", "-e", folder / "e.edg.xml", "-x",
                        folder / "c.con.xml", "-o", folder / "net.xml", "--offset.disable-normalization", "--no-turnarounds",
                        "--default.junctions.radius", "6"], check=True, stdout=subprocess.DEVNULL)


def along(a, w):
    approach(a, a.memory["want"], accel=a.memory.get("accel", 1.6), brake=a.memory.get("brake", 2.0))
    a.s += a.v * DT


# ---- scenes: each sets the ego on its way from W and yields until it is over


def begin(w, turn, v, lane=0):
    w.ego.s, w.ego.d, w.ego.v, w.wish = ARM_M - 85.0, 0.0, v, v
    w.route(w.ego, "W", turn, lane)


def until(w, s):
    while w.ego.s < s:
        yield


def clear(w, a, s):
    while a.s < s:
        yield


def leaves(w, v):
    w.wish = v
    yield from until(w, ARM_M + 70)


def stop_at(w, s):
    """Brakes so as to stand there."""
    w.brake, w.wish = w.ego.v**2 / (2 * max(s - w.ego.s, 0.5)), 0.0


def left_waits(w):
    u = w.draw
    v = u.uniform(8, 10)
    begin(w, "l", v)
    a = w.enters("car", "E", "s", 85 + u.uniform(-5, 12), u.uniform(9, 11))
    yield from until(w, ARM_M - 32)
    stop_at(w, ARM_M - u.uniform(8, 11))
    yield from clear(w, a, ARM_M + 4)
    yield from leaves(w, 6.0)


def left_takes_gap(w):
    """Goes before the other, who then is 3 to 4 s away."""
    u = w.draw
    begin(w, "l", u.uniform(8, 9))
    speed = u.uniform(9, 10)
    a = w.enters("car", "E", "s", 120, speed)
    a.memory.update(brake=0.8, accel=0.8)
    left = u.uniform(4.2, 4.6) * speed

    def pace():
        """So that it has that far to go when the ego begins to turn."""
        time = max((ARM_M - 10 - w.ego.s) / max(w.ego.v, 4.0), 0.5)
        a.memory["want"] = min(max((ARM_M - left - a.s) / time, 6.0), 13.0)
    while w.ego.s < ARM_M - 10:
        if w.ego.s > ARM_M - 40:
            w.brake, w.wish = 1.6, 5.0
        pace()
        yield
    a.memory["want"] = speed
    w.note("gap")
    yield from leaves(w, 6.5)


def right_lets_by(w):
    u = w.draw
    begin(w, "r", u.uniform(8, 10))
    a = w.enters(u.choice(["car", "van"]), "N", "s", 80 + u.uniform(-4, 8), u.uniform(9, 11))
    yield from until(w, ARM_M - 34)
    stop_at(w, ARM_M - u.uniform(9.5, 12))
    while a.s < ARM_M + 9:
        yield
    w.pull = 1.2
    yield from leaves(w, 7.0)


def turn_abreast(w):
    """Two lanes turn left together."""
    u = w.draw
    inner = u.random() < 0.5
    turn = u.choice(["l", "r"])
    v = u.uniform(5.5, 7)
    begin(w, turn, v, 1 if inner else 0)
    a = w.enters("car", "W", turn, 85 + u.uniform(-1.0, 1.0), v, 0 if inner else 1)
    yield from until(w, ARM_M - 12)
    # The outer one has the longer way, and drives the faster for it.
    yield from leaves(w, v)


def crossed(w):
    u = w.draw
    begin(w, "s", u.uniform(9, 11))
    arm = u.choice(["N", "S"])
    a = w.enters(u.choice(["car", "lorry"]), arm, "s", 88 + u.uniform(-4, 6), u.uniform(9, 11))
    yield from until(w, ARM_M - 36)
    if u.random() < 0.5:
        stop_at(w, ARM_M - u.uniform(11, 13))
    else:
        w.brake, w.wish = u.uniform(2.4, 2.8), 2.5
    yield from clear(w, a, ARM_M + 11)
    yield from leaves(w, 9.0)


def oncoming_turns(w):
    u = w.draw
    begin(w, "s", u.uniform(9, 11))
    a = w.enters("car", "E", "l", 82 + u.uniform(-4, 2), u.uniform(8, 9))
    yield from until(w, ARM_M - 36)
    w.brake, w.wish = u.uniform(2.4, 3.0), 2.0
    yield from clear(w, a, ARM_M + 14)
    yield from leaves(w, 9.0)


def presses_in(w):
    """Turns right out of the side road, right in front of the ego."""
    u = w.draw
    v = u.uniform(9, 10.5)
    begin(w, "s", v)
    # It is in the ego's lane when the ego has this far to go.
    ahead = u.uniform(1.9, 2.4) * v
    seconds = (85 - ahead) / v
    a = w.enters(u.choice(["car", "van"]), "S", "r", 2 + 4.5 * seconds, 4.5)
    for _ in range(round(seconds / DT) - 4):
        yield
    w.brake, w.wish = 3.2, 4.0
    a.memory.update(want=8.0, accel=1.5)
    yield from until(w, ARM_M - 2)
    yield from leaves(w, 8.0)


def decoy_alone(w):
    u = w.draw
    begin(w, u.choice("lsr"), u.uniform(7, 9))
    w.brake = 1.5
    yield from until(w, ARM_M - 30)
    yield from leaves(w, 5.5)


def decoy_long_gone(w):
    """Crosses seven seconds and more before the ego comes."""
    u = w.draw
    begin(w, "s", u.uniform(7, 8))
    w.enters("car", u.choice(["N", "S"]), "s", 20, 10.0)
    yield from leaves(w, 8.0)


def decoy_oncoming(w):
    """Straight on, past somebody who does the same the other way."""
    u = w.draw
    begin(w, "s", u.uniform(9, 11))
    w.enters(u.choice(["car", "van"]), "E", "s", 85, 10.0)
    yield from leaves(w, 10.0)


SCENES = [left_waits, left_takes_gap, right_lets_by, turn_abreast, crossed, oncoming_turns, presses_in, decoy_alone, decoy_long_gone, decoy_oncoming]
