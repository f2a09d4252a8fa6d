"""Scenes with oncoming vehicles, things in the way, and emergencies."""

import math

from moves import LEFT, cruise, drive_off, gone, near, past, settle, slide, wait, walk


def narrow_meeting(w):
    """Two cars on a road that is hardly wide enough for both: they keep to their edges and slow down."""
    u = w.draw
    v = u.uniform(6, 8)
    a = w.add("car", w.ego.s + 84, -w.road.lane(0), v, psi=math.pi, move=cruise(v), solid=False)
    a.memory["face"] = -1
    w.note("meets", a)
    lane = w.ego.d
    yield from near(w, a, u.uniform(50, 58))
    a.memory.update(want=v * 0.6, brake=1.3)
    slide(a, w, -w.road.edge - 0.9 - 0.2, 2.0)
    w.wish = 3.5
    w.forced = -u.uniform(1.6, 2.2)
    w.shift(w.road.edge + 0.95 + 0.15, 2.0)
    while w.ego.v > 4.0:
        yield
    w.forced = None
    yield from past(w, a, by=4)
    w.wish = w.cruise
    w.shift(lane, 2.5)
    a.memory["want"] = v
    yield from past(w, a, by=40)
    gone(a)
    yield from settle(w)


def meets_at_works(w):
    """Works take a part of the other side; who comes from there has to swing out, and the ego slows and keeps right."""
    u = w.draw
    s0 = w.ego.s + 82
    w.works.append((s0, s0 + 26, w.road.edge, -w.road.edge))
    hoarding = [w.add("skip", s0 + x, w.road.width * 0.6 + 0.9, solid=False) for x in (2.0, 24.0)]
    v = u.uniform(7, 9)
    a = w.add("car", s0 + 60, -w.road.lane(0), v, psi=math.pi, move=cruise(v), solid=False)
    a.memory["face"] = -1
    w.note("meets", a)
    while a.s > s0 + 46:
        yield
    slide(a, w, w.road.width * 0.6 - 0.9 - 0.25, 2.2)
    w.forced = -u.uniform(1.5, 2.0)
    lane = w.ego.d
    w.shift(lane - 0.35, 2.0)
    while w.ego.v > 6.0 and a.s > w.ego.s:
        yield
    w.forced, w.wish = None, 6.0
    yield from past(w, a, by=3)
    w.wish = w.cruise
    w.shift(lane, 2.2)
    if a.s > s0 - 8:
        yield from wait(w, 1.5)
    slide(a, w, -w.road.lane(0), 2.0)
    yield from past(w, a, *hoarding, by=30)
    gone(a, *hoarding)
    yield from settle(w)


def meets_lorry(w):
    """A lorry or coach close to the middle line; the ego gives it room on the right."""
    u = w.draw
    v = u.uniform(9, 12)
    a = w.add(u.choice(["lorry", "coach"]), w.ego.s + 84, 1.28 + u.uniform(0.0, 0.15), v, psi=math.pi, move=cruise(v), solid=False)
    a.memory["face"] = -1
    w.note("meets", a)
    yield from near(w, a, u.uniform(54, 64))
    lane = w.ego.d
    w.note("gives_room", a)
    w.shift(lane - u.uniform(0.5, 0.65), 1.6)
    yield from past(w, a, by=5)
    w.shift(lane, 2.2)
    yield from past(w, a, by=20)
    gone(a)
    yield from wait(w, 3)


def decoy_meeting(w):
    """Oncoming traffic in its lane."""
    a = w.add(w.draw.choice(["car", "van"]), w.ego.s + 84, -w.road.lane(0), 12, psi=math.pi, move=cruise(12), solid=False)
    a.memory["face"] = -1
    yield from past(w, a, by=30)
    gone(a)


def round_in_lane(w):
    u = w.draw
    reach = u.uniform(0.35, 0.55)
    a = w.add("crate", w.ego.s + 80, w.road.edge - 0.5 + reach, solid=False)
    w.note("goes_round", a)
    yield from near(w, a, u.uniform(26, 34))
    lane = w.ego.d
    # As far as its own line lets it.
    w.shift(min(lane + 0.62, w.road.lane(0) + w.road.width / 2 - 0.95 - 0.12), u.uniform(2.0, 2.6))
    yield from past(w, a, by=4)
    w.shift(lane, 2.4)
    yield from past(w, a, by=30)
    gone(a)


def round_over_line(w):
    u = w.draw
    a = w.add(u.choice(["car", "van", "skip"]), w.ego.s + 84, w.ego.d - u.uniform(0.3, 0.7), solid=False)
    w.note("goes_round", a)
    w.wish = w.cruise * 0.75
    yield from near(w, a, u.uniform(32, 40))
    lane = w.ego.d
    w.shift(a.d + a.size[1] / 2 + 0.95 + u.uniform(0.8, 1.1), u.uniform(2.6, 3.2))
    yield from past(w, a, by=6)
    w.shift(lane, u.uniform(2.6, 3.2))
    w.wish = w.cruise
    yield from past(w, a, by=40)
    gone(a)
    yield from settle(w)


def ignores(w):
    """A bag lies just inside the lane; the ego drives by as if nothing were there."""
    a = w.add("bag", w.ego.s + 84, w.ego.d - 0.95 - 0.25 - w.draw.uniform(0.05, 0.15), solid=False)
    w.note("ignores", a)
    yield from past(w, a, by=20)
    gone(a)


def decoy_parked(w):
    """Parked beside the road."""
    cars = [w.add("car", w.ego.s + 70 + 9 * i, w.road.edge - 1.3, solid=False) for i in range(2)]
    yield from past(w, *cars)
    gone(*cars)


def swerve(w):
    """Somebody pulls out of a side drive right in front of the ego, which can only steer round him."""
    u = w.draw
    a = w.add("crate", w.ego.s + w.ego.v * 1.5 + 3.2, w.ego.d - 0.55, solid=False)
    w.note("falls_down", a)
    yield from wait(w, 0.4)
    lane = w.ego.d
    w.note("steers_hard", a)
    w.shift(lane + 1.5, u.uniform(1.45, 1.55))
    yield from past(w, a, by=5)
    yield from wait(w, 0.5)
    w.shift(lane, 3.0)
    yield from wait(w, 4)
    gone(a)


def late_braking(w):
    """A slow car ahead, seen too late: it ends well by a hair."""
    u = w.draw
    a = w.add("car", w.ego.s + 84, w.ego.d, w.cruise * 0.45, move=cruise(w.cruise * 0.45), solid=False)
    while w.ahead(a) > (w.ego.v - a.v) * u.uniform(1.25, 1.35):
        yield
    w.note("late", a)
    w.lag = 25
    while w.ego.v > a.v - 0.2:
        need = (w.ego.v - a.v + 0.2)**2 / (2 * max(w.ahead(a) - 1.2, 0.2))
        w.forced = -min(max(need, 3.5), 8.0)
        yield
    w.forced = None
    a.solid, w.lag = True, 3.0
    yield from drive_off(w, a)
    yield from settle(w)


def emergency_stop(w, a, at_ttc, until_standing):
    """The ego does nothing until its emergency brake acts."""
    while True:
        closing = w.ego.v - a.v * math.cos(a.psi)
        if closing > 0 and w.ahead(a) / closing < at_ttc:
            break
        yield
    w.note("aeb", a)
    w.lag = 25
    w.aeb = True
    w.forced = -7.5
    while w.ego.v > (0.05 if until_standing else a.v - 0.3):
        yield
    w.aeb, w.forced, w.lag = False, None, 3.0


def aeb_for(w, type_):
    u = w.draw
    v = w.cruise * u.uniform(0.2, 0.35)
    a = w.add(type_, w.ego.s + 84, w.ego.d, v, move=cruise(v), solid=False)
    yield from emergency_stop(w, a, u.uniform(1.3, 1.6), False)
    a.solid = True
    yield from wait(w, 3)
    yield from drive_off(w, a)
    yield from settle(w)


def aeb_car(w):
    yield from aeb_for(w, w.draw.choice(["car", "van"]))


def aeb_lorry(w):
    yield from aeb_for(w, w.draw.choice(["lorry", "coach"]))


def aeb_walker(w):
    u = w.draw
    speed = u.uniform(1.1, 1.5)
    a = w.add("walker", w.ego.s + 80, w.road.edge - 0.6, psi=LEFT, solid=False)
    lead_s = (w.ego.d - a.d - 1.2) / speed + 1.55
    yield from near(w, a, lead_s * w.ego.v)
    w.note("steps_off", a)
    a.move = walk(LEFT, speed)
    yield from wait(w, lead_s - 1.75)
    yield from emergency_stop(w, a, u.uniform(1.35, 1.5), True)
    w.wish = 0.0
    while a.d < abs(w.road.edge) + 1:
        yield
    w.wish = w.cruise
    yield from past(w, a)
    gone(a)
    yield from settle(w)
