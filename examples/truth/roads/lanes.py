"""Drives on roads of several lanes: lanes with a rule of their own, lines that forbid changing, the plaza before toll channels."""

from along import Layout

LANE = "reactive_rule.special_lane"


def special(kind, leaf, right):
    """A lane of another kind beside the ordinary ones, into which the car goes, or which it leaves."""
    def lay(b, answers):
        into = b.draw.random() < 0.5
        last = b.lanes - 1
        kinds = ["vehicle"] * b.lanes
        own, ordinary = (0, 1) if right else (last, last - 1)
        kinds[own] = kind
        if not answers:
            # It is there, and the car drives past it.
            b.go(ordinary)
            b.straight(b.draw.uniform(140, 180), kinds=tuple(kinds))
            return
        if into:
            b.go(ordinary)
        else:
            b.go(own)
        s0 = b.straight(b.draw.uniform(170, 220), kinds=tuple(kinds))
        at = s0 + b.draw.uniform(50, 80)
        b.change(at, own if into else ordinary)
        b.note("across", leaf, at, at)
    return lay


def shut(b, answers):
    """The driver indicates while the line is solid and changes once it is broken; without an answer he stays."""
    b.straight(40)
    at = b.where
    to = at + 1 if at + 1 < b.lanes else at - 1
    s0 = b.straight(b.draw.uniform(90, 130), inner="solid")
    e = b.road.length
    b.straight(90)
    if answers:
        move = e + b.draw.uniform(3, 9)
        b.change(move, to, indicate=(move - e) / b.drive.v0 + b.draw.uniform(2.2, 4))
        b.note("line", "reactive_rule.lane_rule.laneline_normal", e, e)


def plaza(b, answers):
    """Before the toll the car moves over to a channel and drives through it."""
    b.straight(60)
    s0 = b.straight(b.draw.uniform(150, 180))
    end = b.road.length
    b.area("toll_plaza", s0, end - 40, -b.lanes * 1.7, b.lanes * 1.7)
    to = b.draw.choice([k for k in (b.where - 1, b.where + 1) if 0 <= k < b.lanes])
    at = s0 + b.draw.uniform(20, 45)
    b.straight(30)
    lane = lambda k: (k - (b.lanes - 1) / 2) * 3.4
    for k in range(b.lanes):
        b.area("toll_etc", end, end + 14, lane(b.lanes - 1 - k) - 1.6, lane(b.lanes - 1 - k) + 1.6)
    order = b.order(end - 4, end + 14, b.draw.uniform(4.8, 6.5), decel=1.3)
    b.change(at, to)
    b.note("across", "reactive_rule.special_facility.toll_plaza", at, at)
    b.note("control100", "reactive_rule.special_facility.toll_etc", end, end + 14, order)


FEATURES = {
    "bus": special("bus", f"{LANE}.bus_lane", True),
    "tidal": special("tidal", f"{LANE}.tidal_lane", False),
    "variable": special("variable", f"{LANE}.variable_lane", False),
    "shut": shut,
    "plaza": plaza,
}


class Lanes(Layout):
    def __init__(self, name, draw):
        super().__init__(name, draw, lanes=3)
        self.where = self.drive.lane = 1
        self.drive.signal = True

    def go(self, lane):
        """An ordinary change before the scene, where the car is in another lane than the scene wants."""
        self.straight(110)
        if lane != self.where:
            self.change(self.road.length - 100, lane)

    def change(self, at, lane, indicate=1.0):
        self.drive.changes.append((at, lane, indicate))
        self.where = lane


def drives(draw):
    todo = [(name, k < (4 if name != "plaza" else 3)) for name in FEATURES for k in range(5 if name != "plaza" else 3)]
    draw.shuffle(todo)
    per = 6
    for i in range(0, len(todo), per):
        yield f"lane{i // per:02}", todo[i:i + per]


def build(name, todo, draw, work):
    b = Lanes(name, draw)
    for feature, answers in todo:
        FEATURES[feature](b, answers)
        b.straight(draw.uniform(60, 90))
    return b.finish(work)
