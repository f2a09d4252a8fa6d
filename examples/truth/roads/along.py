"""Drives along one road: bends, hills, surfaces, weather, limits, facilities, one after the other with ordinary road between.

Each feature is a function that lays its stretch of road, says what the driver is to do there (or that he does nothing), and writes
down for truth.py what was laid and told. `answers` false is the negative: the same thing on the road, and no answer to it.
"""

import math

from drive import Drive, Order
from network import Piece, Road


class Layout:
    def __init__(self, name, draw, lanes=1):
        self.draw, self.road = draw, Road(draw.uniform(0, 360))
        self.drive = Drive(name, v0=round(draw.uniform(*draw.speeds), 1))
        self.limit, self.count = draw.limit, 0
        self.states = {}
        self.lanes, self.kinds, self.inner = lanes, {}, {}
        self.straight(draw.uniform(150, 190))

    def straight(self, length, **more):
        kinds, inner = more.pop("kinds", None), more.get("inner")
        start = self.road.add(Piece(length, **{"limit": self.limit, "lanes": self.lanes, **more}))
        if kinds:
            self.kinds[f"e{len(self.road.pieces) - 1}"] = kinds
        if inner:
            self.inner[f"e{len(self.road.pieces) - 1}"] = inner
        return start

    def order(self, s0, s1, v, **more):
        self.count += 1
        name = f"o{self.count}"
        self.drive.orders.append(Order(name, s0, s1, v, **more))
        return name

    def eased(self, s0, s1, v, decel, delay):
        """An order whose slowing begins only `delay` m behind `s0`."""
        return self.order(s0 + delay + (self.drive.v0**2 - v**2) / (2 * decel), s1, v, decel=decel)

    def note(self, kind, leaf, s0, s1, order="", **more):
        self.drive.features.append({"kind": kind, "leaf": leaf, "s0": round(s0, 2), "s1": round(s1, 2), "order": order, **more})

    def area(self, kind, s0, s1, right, left):
        self.drive.areas.append((kind, self.road.box(s0, s1, right, left)))

    def line(self, kind, s, half=2.0):
        self.drive.areas.append((kind, [self.road.at(s, half)[:3], self.road.at(s, -half)[:3]]))

    def sign(self, kind, s, value="", left=-2.6):
        x, y, *_ = self.road.at(s, left)
        self.drive.signs.append((kind, x, y, value))

    def thing(self, kind, s, left, size):
        x, y, _, h = self.road.at(s, left)
        self.drive.objects.append((kind, x, y, h, *size))

    def state(self, kind, base, s0, s1, value):
        self.states.setdefault((kind, base), []).append((s0, s1, value))

    def slower(self, least, most):
        return round(self.drive.v0 - self.draw.uniform(least, most), 1)

    def finish(self, work, tail=260):
        self.straight(tail)
        self.drive.until = self.drive.until or self.road.length - 120
        self.drive.contexts = [(k, b, v) for (k, b), v in self.states.items()]
        self.road.write(work)
        self.drive.folder = work
        self.drive.route = [f"e{i}" for i in range(len(self.road.pieces))]
        self.drive.kinds, self.drive.inner = self.kinds, self.inner
        self.drive.duration = self.road.length / 5 + 60
        return self.drive


def bend(b, answers):
    radius = b.draw.uniform(32, 78) if answers else b.draw.uniform(280, 400)
    angle = b.draw.choice([-1, 1]) * (b.draw.uniform(50, 95) if answers else b.draw.uniform(12, 20))
    s0 = b.straight(1, bend=(radius, angle))
    order = b.order(s0, b.road.length, min(math.sqrt(1.7 * radius), b.drive.v0 - 1.8)) if answers else ""
    b.note("acts", "reactive_road.geometry_adaptation.high_curvature" if answers else "", s0, b.road.length, order)


def slope(sign, leaf):
    def lay(b, answers):
        grade = sign * (b.draw.uniform(0.05, 0.08) if answers else b.draw.uniform(0.01, 0.025))
        s0 = b.straight(b.draw.uniform(80, 120), grade=grade)
        order = b.eased(s0, b.road.length - 10, b.slower(2, 3), 0.7, b.draw.uniform(3, 12)) if answers else ""
        b.note("inside", leaf if answers else "", s0, b.road.length, order)
    return lay


def narrow(b, answers):
    s0 = b.straight(b.draw.uniform(40, 60), width=b.draw.uniform(2.4, 2.65))
    order = b.order(s0, b.road.length, b.slower(3, 5)) if answers else ""
    b.note("seen", "reactive_road.geometry_adaptation.narrow" if answers else "", s0, b.road.length, order)


def tunnel(b, answers):
    s0 = b.straight(b.draw.uniform(70, 110))
    b.area("tunnel", s0, b.road.length, -4, 4)
    order = b.order(s0, b.road.length, b.slower(2, 4)) if answers else ""
    b.note("seen", "reactive_road.geometry_adaptation.tunnel" if answers else "", s0, b.road.length, order)


def stretch(leaf, channel, base, value, length, lost, kind="holds", needs_answer=True):
    """A stretch on which a state of the log's context holds and the driver keeps a lower speed."""
    def lay(b, answers):
        s0 = b.straight(b.draw.uniform(*length))
        word = b.draw.choice(value) if isinstance(value, list) else value
        b.state(channel, base, s0, b.road.length, word)
        order = b.eased(s0, b.road.length - 4, b.slower(*lost), 1.0, b.draw.uniform(6, 16)) if answers and lost else ""
        b.note(kind, leaf if answers or not needs_answer else "", s0, b.road.length, order)
    return lay


def night(b, answers):
    s0 = b.straight(b.draw.uniform(330, 380))
    s1 = b.road.length
    b.state("lighting", "day", s0, s0 + 75, "dusk")
    b.state("lighting", "day", s0 + 75.01, s1 - 75, "night")
    b.state("lighting", "day", s1 - 74.99, s1, "dusk")
    order = b.eased(s0 + 75, s1 - 80, b.slower(2.5, 4), 1.0, b.draw.uniform(6, 16)) if answers else ""
    b.note("during", "reactive_road.lighting_adaptation.low_light" if answers else "", s0 + 75, s1 - 75, order)


def dark_entry(b, answers):
    s0 = b.straight(45)
    b.state("lighting", "day", s0, b.road.length, "tunnel")
    order = b.eased(s0, s0 + 32, b.slower(1.8, 2.5), 1.2, b.draw.uniform(1, 5)) if answers else ""
    b.note("change", "reactive_road.lighting_adaptation.transition" if answers else "", s0, s0 + 40, order)


def spot(leaf, value):
    """A hole or a pool of some meters."""
    def lay(b, answers):
        s0 = b.straight(b.draw.uniform(14, 20))
        b.state("surface", "dry", s0, b.road.length, value)
        order = b.order(s0 - 3, b.road.length, b.slower(4, 7), decel=1.8) if answers else ""
        b.note("seen", leaf if answers else "", s0, b.road.length, order)
    return lay


def bump(b, answers):
    s0 = b.straight(10) + 5
    b.line("speed_bump", s0)
    order = b.order(s0 - 2, s0 + 4, b.draw.uniform(4, 6), decel=1.8) if answers else ""
    b.note("seen", "reactive_road.surface_adaptation.speed_bump" if answers else "", s0, s0 + 1, order)


def bump_limit(b, answers):
    s0 = b.straight(b.draw.uniform(45, 60), limit=8.33)
    at = b.road.length - 15
    b.line("speed_bump", at)
    order = b.order(s0, b.road.length, 8.33, decel=1.5) if answers else ""
    if answers:
        b.note("lower", "reactive_rule.speed_limit.nav_limit", s0, s0, order, optional="the map's limit, which belongs to the bump")
    b.note("control60", "reactive_rule.speed_limit.bump_limit" if answers else "", at, at + 1, order)
    b.note("higher", "reactive_rule.speed_limit.nav_limit" if answers else "", b.road.length, b.road.length, "")


def limit(signed, leaf):
    def lay(b, answers):
        low = b.draw.choice([8.33, 9.72, 11.11]) if answers else None
        if not answers:
            # A higher limit of which the driver makes no use.
            s0 = b.straight(b.draw.uniform(120, 150), limit=19.44)
            if signed:
                b.sign("speed_limit", s0, 19.44)
                b.sign("speed_limit", b.road.length, b.limit)
            return b.note("limit", "", s0, b.road.length, "")
        s0 = b.straight(b.draw.uniform(130, 170), limit=low)
        order = b.order(s0, b.road.length, min(low, b.drive.v0 - 1), decel=1.3)
        b.note("lower", leaf, s0, b.road.length, order)
        b.note("higher", leaf, b.road.length, b.road.length, order)
        if signed:
            b.sign("speed_limit", s0, low)
            b.sign("speed_limit", b.road.length, b.limit)
    return lay


def crosswalk(b, answers):
    s0 = b.straight(20) + 8
    b.area("crosswalk", s0, s0 + 4, -4, 4)
    order = b.order(s0 - 3, s0 + 4, b.slower(4, 6), decel=1.5) if answers else ""
    b.note("control60", "reactive_rule.speed_limit.crosswalk_limit" if answers else "", s0, s0 + 4, order)


def board(kind, leaf):
    """A sign that the driver answers as soon as he can read it."""
    def lay(b, answers):
        s0 = b.straight(90) + 65
        b.sign(kind, s0)
        order = b.order(s0 - b.draw.uniform(18, 24), s0 + 25, b.slower(3, 4), decel=1.2) if answers else ""
        b.note("control60", leaf if answers else "", s0, s0, order)
    return lay


def blind_curve(b, answers):
    side = b.draw.choice([-1, 1])
    s0 = b.straight(1, bend=(b.draw.uniform(88, 97), side * b.draw.uniform(50, 60)))
    s1 = b.road.length
    near, far = (2.5, 12) if side > 0 else (-12, -2.5)
    b.area("building", s0 + 8, s1 - 8, near, far)
    order = b.order(s0 + 22, s1 - 16, b.slower(4, 5), decel=1.6) if answers else ""
    if answers:
        b.note("acts", "reactive_road.geometry_adaptation.high_curvature", s0, s1, order, optional="tight enough to be a bend, and taken slower for want of sight")
    b.note("sight", "reactive_road.blind_spot_slowdown.curve" if answers else "", s0, s1, order, road=b.road, wall=[p[:2] for p in b.road.box(s0 + 8, s1 - 8, near, far)])


def crest(b, answers):
    steep = b.draw.uniform(0.075, 0.09)
    s0 = b.straight(38, grade=steep)
    top = b.straight(38, grade=-steep)
    order = b.order(top - 12, top + 3, b.slower(3, 5), decel=1.5) if answers else ""
    b.note("crest", "reactive_road.blind_spot_slowdown.slope" if answers else "", s0, b.road.length, order, road=b.road)


def gap(b, answers):
    s0 = b.straight(30) + 12
    b.area("barrier_gap", s0, s0 + 6, 2.0, 3.0)
    order = b.order(s0 - 4, s0 + 6, b.slower(2.5, 4), decel=1.3) if answers else ""
    b.note("reach", "reactive_road.blind_spot_slowdown.gap" if answers else "", s0, s0 + 6, order)


def hoarding(b, answers):
    s0 = b.straight(b.draw.uniform(40, 55))
    b.area("construction", s0, b.road.length, -8, -2.4)
    b.area("building", s0, b.road.length, -6, -3.2)
    order = b.order(s0 + 4, b.road.length, b.slower(1.4, 1.7), decel=0.8) if answers else ""
    b.note("reach", "reactive_road.blind_spot_slowdown.construction" if answers else "", s0, b.road.length, order)


def lorries(b, answers):
    s0 = b.straight(40)
    for k in range(2):
        b.thing("truck", s0 + 10 + k * 13, -3.8, (10, 2.5, 3.4))
    order = b.order(s0, s0 + 30, b.slower(3, 5), decel=1.4) if answers else ""
    b.note("reach", "reactive_road.blind_spot_slowdown.vehicle" if answers else "", s0 + 5, s0 + 28, order)


def site(kind, leaf):
    """Something set up in a part of the lane, for which the driver slows."""
    def lay(b, answers):
        s0 = b.straight(b.draw.uniform(40, 55), width=4.2)
        if kind == "cone":
            for k in range(6):
                b.thing("cone", s0 + 3 + 6 * k, -1.45, (0.3, 0.3, 0.7))
        else:
            b.area(kind, s0, b.road.length, -3.2, -1.4)
        order = b.order(s0, b.road.length, b.slower(4.5, 6.5), decel=1.6) if answers else ""
        b.note("control100", leaf if answers else "", s0, b.road.length, order)
    return lay


def gate(b, answers):
    s0 = b.straight(60) + 30
    b.line("gate", s0, 3)
    order = b.order(s0 - 1, s0 + 2, 2.5, wait=4.0, decel=1.5) if answers else b.order(s0 - 10, s0 + 2, 4.0, decel=1.6)
    b.drive.gates.append((order, s0))
    b.note("gate", "reactive_rule.special_facility.gate", s0, s0, order)
    if answers:
        b.note("waits", "proactive.pull_over.gate_stop", s0, s0, order)


def etc(b, answers):
    s0 = b.straight(60) + 20
    b.area("toll_etc", s0, s0 + 14, -2.2, 2.2)
    order = b.order(s0 - 4, s0 + 14, b.draw.uniform(4.8, 6.5), decel=1.4) if answers else ""
    b.note("control100", "reactive_rule.special_facility.toll_etc" if answers else "", s0, s0 + 14, order)


def booth(b, answers):
    s0 = b.straight(60) + 20
    b.area("toll_manual", s0, s0 + 14, -2.2, 2.2)
    order = b.order(s0 + 7, s0 + 14, 0, wait=b.draw.uniform(3, 6), decel=1.4)
    b.note("control100", "reactive_rule.special_facility.toll_manual", s0, s0 + 14, order)


def dead_end(b, answers):
    end = b.road.length + 150
    b.straight(150)
    order = b.order(end - 4, end, 0, wait=1e9, decel=1.9)
    b.drive.until = 1e9
    b.note("end", "reactive_road.geometry_adaptation.dead_end", end, end, order)


ROAD, RULE = "reactive_road", "reactive_rule"
FEATURES = {
    "bend": bend,
    "climb": slope(1, f"{ROAD}.geometry_adaptation.slope_up"),
    "descent": slope(-1, f"{ROAD}.geometry_adaptation.slope_down"),
    "narrow": narrow,
    "tunnel": tunnel,
    "rural": stretch(f"{ROAD}.geometry_adaptation.rural", "pavement", "paved", "unpaved", (130, 180), (3, 5)),
    "mountain": stretch(f"{ROAD}.geometry_adaptation.mountain", "road_type", "urban", "mountain", (220, 280), (2, 3)),
    "marks": stretch(f"{ROAD}.geometry_adaptation.laneline_abnormal", "lane_marks", "normal", ["missing", "faded", "wrong"], (60, 110), None, needs_answer=False),
    "wet": stretch(f"{ROAD}.surface_adaptation.wet", "surface", "dry", "wet", (170, 220), (2.5, 4), "during"),
    "ice": stretch(f"{ROAD}.surface_adaptation.snow_ice", "surface", "dry", ["snow", "ice"], (170, 220), (3, 6), "during"),
    "rain": stretch(f"{ROAD}.weather_adaptation.rain", "weather", "clear", "rain", (170, 220), (2.5, 4), "during"),
    "fog": stretch(f"{ROAD}.weather_adaptation.fog", "weather", "clear", "fog", (170, 220), (3, 5), "during"),
    "snowfall": stretch(f"{ROAD}.weather_adaptation.snow", "weather", "clear", "snow", (170, 220), (3, 5), "during"),
    "glare": stretch(f"{ROAD}.lighting_adaptation.glare", "lighting", "day", "glare", (90, 120), (2, 3.5), "holds"),
    "night": night,
    "dark_entry": dark_entry,
    "pothole": spot(f"{ROAD}.surface_adaptation.pothole", "rough"),
    "puddle": spot(f"{ROAD}.surface_adaptation.puddle", "puddle"),
    "bump": bump,
    "bump_limit": bump_limit,
    "sign_limit": limit(True, f"{RULE}.speed_limit.sign_limit"),
    "map_limit": limit(False, f"{RULE}.speed_limit.nav_limit"),
    "crosswalk": crosswalk,
    "warning": board("warning", f"{RULE}.traffic_sign.warning"),
    "prohibition": board("prohibition", f"{RULE}.traffic_sign.prohibition"),
    "blind_curve": blind_curve,
    "crest": crest,
    "gap": gap,
    "hoarding": hoarding,
    "lorries": lorries,
    "works": site("construction", f"{RULE}.road_change.construction"),
    "cones": site("cone", f"{RULE}.road_change.cone"),
    "crash": site("accident", f"{RULE}.road_change.accident"),
    "gate": gate,
    "etc": etc,
    "booth": booth,
}


def drives(draw):
    """Every feature four times, one of them without an answer, in drawn order; a dead end closes each fourth drive."""
    todo = [(name, k < 3) for name in FEATURES for k in range(4)]
    draw.shuffle(todo)
    per = 9
    for i in range(0, len(todo), per):
        yield f"road{i // per:02}", todo[i:i + per], (i // per) % 4 == 0


def build(name, todo, ends, draw, work):
    b = Layout(name, draw)
    for feature, answers in todo:
        FEATURES[feature](b, answers)
        b.straight(draw.uniform(150, 180))
    if ends:
        dead_end(b, True)
        b.drive.contexts = [(k, base, v) for (k, base), v in b.states.items()]
        b.road.write(work)
        b.drive.folder, b.drive.route = work, [f"e{i}" for i in range(len(b.road.pieces))]
        b.drive.duration = b.road.length / 6 + 60
        return b.drive
    return b.finish(work)
