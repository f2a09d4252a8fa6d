"""Scenes in which the ego or others change lane, join, move off or pull over."""

import math

from moves import behind_lead, cruise, drive_off, gone, near, past, settle, slide, wait
from stage import approach


def escape(w):
    """A lorry with its hazard lights blocks the lane; the ego waits, then takes the next lane and stays there."""
    u = w.draw
    a = w.add("lorry", w.ego.s + 84, w.ego.d, signals=3)
    w.note("blocks", a)
    w.blind.add(a.id)
    stand = u.uniform(10.5, 12.0)
    w.forced = -w.ego.v**2 / (2 * (w.ahead(a) - stand - 0.4 * w.ego.v))
    while w.ego.v > 0.05:
        yield
    w.forced, w.wish = None, 0.0
    yield from wait(w, u.uniform(4, 7))
    w.note("changes_lane", reason="escape", target=a.id)
    w.ego.signals = 2
    lane = w.ego.d
    yield from wait(w, 0.8)
    w.wish = 3.2
    w.shift(lane + w.road.width, 4.0)
    yield from wait(w, 4.4)
    w.wish, w.ego.signals = w.cruise, 0
    yield from past(w, a, by=30)
    gone(a)
    yield from wait(w, 12)
    w.note("changes_lane", reason="back")
    w.shift(lane, 4.0)
    yield from settle(w)


def gives_up(w):
    """Begins to change lane and goes back."""
    u = w.draw
    lane = w.ego.d
    w.ego.signals = 2
    yield from wait(w, 1.5)
    w.shift(lane + u.uniform(0.9, 1.15), u.uniform(2.2, 2.8))
    yield from wait(w, 3.0 + u.uniform(0, 0.5))
    w.note("gives_up")
    w.ego.signals = 0
    w.shift(lane, u.uniform(2.4, 3.0))
    yield from wait(w, 6)


def overtakes(w):
    """Past a slower one in the next lane, and on."""
    u = w.draw
    a = yield from behind_lead(w, factor=0.6, gap=80)
    w.note("changes_lane", reason="overtake", target=a.id)
    lane = w.ego.d
    w.ego.signals = 2
    w.blind.add(a.id)
    yield from wait(w, 0.8)
    w.shift(lane + w.road.width, u.uniform(3.4, 4.4))
    yield from wait(w, 4)
    w.ego.signals = 0
    yield from past(w, a, by=25)
    w.note("changes_lane", reason="back")
    w.shift(lane, u.uniform(3.4, 4.4))
    yield from wait(w, 6)
    yield from past(w, a, by=60)
    gone(a)


def gains_speed(w):
    """Leaves a slow lead for the next lane, where somebody drives a little faster; passes neither."""
    u = w.draw
    slow = yield from behind_lead(w, factor=0.5, gap=80)
    fast = w.add("car", w.ego.s + 30, w.ego.d + w.road.width, w.cruise * 0.5, move=cruise(w.cruise * 0.5))
    fast.memory.update(want=w.cruise * 0.8, accel=2.0)
    yield from wait(w, 2)
    w.note("changes_lane", reason="speed", target=slow.id)
    lane = w.ego.d
    w.ego.signals = 2
    w.blind.add(slow.id)
    yield from wait(w, 0.8)
    w.shift(lane + w.road.width, u.uniform(3.4, 4.2))
    # The slow one makes up its mind, too, and stays ahead.
    yield from wait(w, 2.5)
    slow.memory.update(want=w.cruise * 0.95, accel=1.8)
    yield from wait(w, 9)
    w.ego.signals = 0
    gone(slow, fast)
    w.note("changes_lane", reason="back")
    w.shift(lane, 4.0)
    yield from wait(w, 7)


def cuts_in(w, type_, closing, gap):
    u = w.draw
    v = w.cruise - closing
    a = w.add(type_, w.ego.s + 84, w.ego.d + w.road.width, v, move=cruise(v), solid=False)
    half = (a.size[0] + w.ego.size[0]) / 2
    limit = w.t + 30
    while a.s - w.ego.s - half > gap + 1.3 * max(closing, 0) and w.t < limit:
        yield
    a.signals = 1
    w.note("cuts_in", a)
    slide(a, w, w.ego.d, u.uniform(2.6, 3.4))
    yield from wait(w, 1.0)
    a.solid = True
    w.lag, w.patience = 6.0, 0.3
    yield from wait(w, 3)
    w.lag, w.patience = 3.0, 0.7
    a.signals = 0
    a.memory.update(want=max(v, w.cruise * 0.6))
    yield from wait(w, 4)
    yield from drive_off(w, a)
    yield from settle(w)


def cutin_urgent(w):
    yield from cuts_in(w, "car", w.draw.uniform(5.0, 6.5), w.draw.uniform(11, 13.5))


def cutin_slow(w):
    yield from cuts_in(w, w.draw.choice(["car", "van"]), w.draw.uniform(1.0, 2.0), w.draw.uniform(14, 20))


def cutin_large(w):
    yield from cuts_in(w, w.draw.choice(["lorry", "coach"]), w.draw.uniform(2, 3), w.draw.uniform(16, 22))


def ramp_begins(w, ahead=150.0):
    w.road.ramps.append(round(w.ego.s + ahead))
    return w.road.ramps[-1]


def on_ramp(w, type_, begins, s, v):
    """Comes down the ramp at v, and keeps to the lane of the ramp from where that begins."""
    def move(a, w):
        m = a.memory
        before = a.d
        approach(a, m["want"], accel=1.8, brake=1.5)
        a.s += a.v * 0.1
        if a.s < begins:
            a.d = w.road.lane(0) - w.road.ASIDE_M * (begins - a.s) / w.road.RAMP_M
        elif m.get("slide"):
            a.d = m["slide"].at(w.t)
        a.psi = math.atan2(a.d - before, a.v * 0.1)
    a = w.add(type_, s, w.road.lane(0) - w.road.ASIDE_M * max(0.0, begins - s) / w.road.RAMP_M, v, move=move, solid=False)
    a.memory["want"] = v
    return a


def joins_ahead(w, type_, slower, gap):
    """Joins from a ramp in front of the ego, `slower` m/s slower than it, with so many meters left."""
    u = w.draw
    begins = ramp_begins(w)
    v = w.ego.v - slower
    # Where it is when it starts to come over, and how far ahead of the ego.
    place = begins + u.uniform(50, 90)
    t = (place - gap - 6 - w.ego.s) / w.ego.v
    a = on_ramp(w, type_, begins, place - v * t, v)
    yield from wait(w, t)
    w.note("joins", a)
    a.signals = 2
    slide(a, w, w.ego.d, u.uniform(3.0, 3.8))
    yield from wait(w, 1.2)
    a.solid = True
    w.lag, w.patience = 6.0, 0.3
    yield from wait(w, 4)
    w.lag, w.patience = 3.0, 0.7
    a.signals = 0
    yield from drive_off(w, a)
    yield from settle(w)
    while w.ego.s < begins + 200:
        yield


def joins_urgent(w):
    yield from joins_ahead(w, "car", w.draw.uniform(6.0, 7.5), w.draw.uniform(15, 18))


def joins_gently(w):
    yield from joins_ahead(w, "car", w.draw.uniform(1.5, 2.5), w.draw.uniform(20, 28))


def lorry_joins(w):
    yield from joins_ahead(w, w.draw.choice(["lorry", "coach"]), w.draw.uniform(3, 4), w.draw.uniform(24, 30))


def decoy_joins_behind(w):
    """Joins behind the ego's back."""
    begins = ramp_begins(w)
    v = w.ego.v - 2
    t = (begins + 60 - w.ego.s) / w.ego.v
    a = on_ramp(w, "car", begins, begins + 60 - 28 - v * t, v)
    yield from wait(w, t)
    slide(a, w, w.ego.d, 3.5)
    while w.ego.s < begins + 240:
        yield
    gone(a)


def decoy_overtaken(w):
    """Slower in the left lane, where it stays."""
    u = w.draw
    a = w.add("car", w.ego.s + 70, w.road.lane(2), w.cruise * 0.85, move=cruise(w.cruise * 0.85), solid=False)
    yield from past(w, a, by=25)
    gone(a)


def from_kerb(w):
    """Moves off from the curb in front of the ego."""
    u = w.draw
    a = w.add("car", w.ego.s + 84, w.road.edge - 1.2, move=cruise(0.0), solid=False)
    yield from near(w, a, u.uniform(2.4, 2.8) * w.ego.v)
    w.note("moves_off", a)
    a.signals = 2
    a.memory.update(want=w.cruise * 0.7, accel=2.2)
    slide(a, w, w.ego.d, u.uniform(3.0, 3.6))
    yield from wait(w, 0.8)
    a.solid = True
    w.lag, w.patience = 6.0, 0.3
    yield from wait(w, 6)
    w.lag, w.patience = 3.0, 0.7
    a.signals = 0
    yield from drive_off(w, a)
    yield from settle(w)


def pulls_over(w):
    """To the curb, a halt, and on."""
    u = w.draw
    lane = w.ego.d
    w.note("pulls_over")
    w.ego.signals = 1
    yield from wait(w, 1.5)
    w.forced = -u.uniform(1.3, 1.8)
    w.shift(w.road.edge + 0.95 + u.uniform(0.25, 0.5), 4.0)
    while w.ego.v > 0:
        if w.ego.v < 0.6:
            w.forced = -0.8
        yield
    w.note("stands")
    w.wish = 0.0
    yield from wait(w, u.uniform(3, 6))
    w.forced, w.ego.signals, w.wish = None, 2, w.cruise
    yield from wait(w, 1.2)
    w.shift(lane, 4.0)
    yield from wait(w, 4)
    w.ego.signals = 0
    yield from settle(w)
