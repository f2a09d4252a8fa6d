"""Scenes with vehicles that reverse, brake, queue, weave, leave the lane or come the wrong way."""

import math

from moves import RIGHT, behind_lead, cruise, drive_off, gone, near, past, settle, slide, wait


def reversing(w):
    """Out of a parking place across the road, into the ego's lane; then off ahead of it."""
    u = w.draw
    a = w.add("car", w.ego.s + 84, w.road.edge - 3.6, psi=RIGHT, solid=False)
    w.wish = min(w.cruise, 9.0)
    yield from near(w, a, u.uniform(27, 29.5))
    w.note("reverses", a)
    w.lag, w.patience = 6.0, 0.2
    a.solid = True
    goal = w.ego.d - u.uniform(0.5, 1.2)

    def back(a, w):
        a.v = max(a.v - 0.12, -1.4) if a.d < goal else min(a.v + 0.2, 0.0)
        a.d += a.v * math.sin(a.psi) * 0.1
    a.move = back
    yield
    while a.v < 0:
        yield
    yield from wait(w, u.uniform(1.5, 3))
    w.lag, w.patience, w.wish = 3.0, 0.7, w.cruise
    # Forward again into its place: it lets the ego by.
    def forth(a, w):
        a.v = min(a.v + 0.12, 1.5) if a.d > w.road.edge - 3.6 else 0.0
        a.d += a.v * math.sin(a.psi) * 0.1
    a.move = forth
    yield
    while a.v > 0:
        yield
    a.solid = False
    yield from past(w, a)
    gone(a)
    yield from settle(w)


def decoy_reversing(w):
    """Reverses in its drive, well off the road."""
    def back(a, w):
        a.v = -1.0 if a.d < w.road.edge - 7 else 0.0
        a.d += a.v * math.sin(a.psi) * 0.1
    a = w.add("car", w.ego.s + 60, w.road.edge - 13, psi=RIGHT, solid=False)
    yield from near(w, a, 28)
    a.move = back
    yield from past(w, a)
    gone(a)


def lead_follow(w):
    """Nothing but following."""
    a = yield from behind_lead(w)
    yield from wait(w, w.draw.uniform(4, 8))
    yield from drive_off(w, a)
    yield from settle(w)


def lead_brakes_hard(w):
    u = w.draw
    a = yield from behind_lead(w)
    low = a.v * u.uniform(0.2, 0.5)
    w.note("brakes_hard", a)
    w.lag = 6.0
    a.memory.update(want=low, brake=u.uniform(4.5, 6.5))
    while a.v > low + 0.05:
        yield
    yield from wait(w, u.uniform(2, 3))
    w.lag = 3.0
    yield from drive_off(w, a)
    yield from settle(w)


def lead_brakes_softly(w):
    """A decoy for hard braking."""
    a = yield from behind_lead(w)
    a.memory.update(want=a.v * 0.5, brake=1.8)
    yield from wait(w, 5)
    yield from drive_off(w, a)
    yield from settle(w)


def lead_stops(w):
    u = w.draw
    a = yield from behind_lead(w)
    w.note("stops", a)
    a.memory.update(want=0.0, brake=u.uniform(1.4, 2.2))
    while a.v > 0 or w.ego.v > 0:
        yield
    yield from wait(w, u.uniform(3, 8))
    w.note("starts", a)
    yield from drive_off(w, a)
    yield from settle(w)


def stop_and_go(w):
    u = w.draw
    a = yield from behind_lead(w, factor=0.55, gap=60)
    w.note("queue_begins", a)
    for _ in range(u.randint(3, 4)):
        a.memory.update(want=0.0, brake=1.6)
        while a.v > 0 or w.ego.v > 0:
            yield
        yield from wait(w, u.uniform(2, 5))
        a.memory.update(want=u.uniform(3, 5), accel=1.2)
        yield from wait(w, u.uniform(5, 8))
    w.note("queue_ends", a)
    yield from drive_off(w, a)
    yield from settle(w)


def queue_cutin(w):
    """In a queue that has stopped and gone for a while, somebody squeezes in from the next lane."""
    u = w.draw
    a = yield from behind_lead(w, factor=0.55, gap=60)
    beside = w.add("car", a.s - 2, w.ego.d + w.road.width, a.v, move=cruise(a.v), solid=False)
    w.note("queue_begins", a)
    def keep(want, **more):
        a.memory.update(want=want, **more)
        beside.memory.update(want=want, **more)
    for _ in range(3):
        keep(0.0, brake=1.6)
        while a.v > 0 or w.ego.v > 0:
            yield
        yield from wait(w, u.uniform(2, 4))
        keep(u.uniform(3, 4.5), accel=1.2)
        yield from wait(w, u.uniform(5, 7))
    # The ego lingers; the other comes level with the gap.
    w.wish = 2.2
    while w.ahead(a) < 12.0 or abs(beside.s - w.ego.s - 7.9) > 0.3:
        beside.memory["want"] = max(0.0, w.ego.v + 0.6 * (w.ego.s + 7.9 - beside.s))
        yield
    beside.memory["want"] = 2.4
    beside.signals = 1
    w.note("cuts_in", beside)
    slide(beside, w, w.ego.d, u.uniform(2.8, 3.4))
    yield from wait(w, 1.0)
    beside.solid = True
    yield from wait(w, 3)
    w.wish = w.cruise
    yield from wait(w, 3)
    keep(0.0, brake=1.6)
    beside.memory["brake"] = 1.9
    while a.v > 0 or w.ego.v > 0:
        yield
    yield from wait(w, 2)
    w.note("queue_ends", a)
    keep(w.cruise * 1.8, accel=2.5)
    beside.memory["accel"] = 2.0
    while beside.s - w.ego.s < 84:
        yield
    gone(a, beside)
    yield from settle(w)


def creep(w):
    u = w.draw
    a = yield from behind_lead(w, factor=0.5, gap=60)
    w.note("crawls", a)
    a.memory.update(want=u.uniform(1.6, 2.4), brake=1.2)
    yield from wait(w, u.uniform(16, 22))
    yield from drive_off(w, a)
    yield from settle(w)


def cutout(w):
    """The lead leaves the lane in front of something that stands there."""
    u = w.draw
    lead = w.add("van", w.ego.s + 40, w.ego.d, w.cruise * 0.85, move=cruise(w.cruise * 0.85))
    yield from wait(w, 9)
    thing = w.add("skip", lead.s + lead.v * 2.5 + 8, w.ego.d)
    thing.memory["behind"] = True
    w.note("lead_leaves", lead, obstacle=thing.id)
    w.blind.add(thing.id)
    w.patience = 0.4
    slide(lead, w, lead.d + w.road.width, 3.4)
    yield from wait(w, 1.6)
    w.blind.discard(thing.id)
    w.lag = 6.0
    lead.solid = False
    while w.ego.v > 0.5 and w.ego.s < thing.s:
        yield
    w.lag, w.patience = 3.0, 0.7
    lead.memory.update(want=w.cruise * 1.5)
    yield from wait(w, 2)
    gone(lead)
    # Somebody clears it away.
    thing.solid = False
    def off(a, w):
        a.d -= 0.15
    thing.move = off
    yield from wait(w, 4)
    thing.move = None
    yield from past(w, thing)
    gone(thing)
    yield from settle(w)


def neighbour_brakes(w):
    """In the next lane somebody ahead brakes hard; the ego eases off."""
    u = w.draw
    a = w.add("car", w.ego.s + 55, w.ego.d + w.road.width, w.cruise * 0.8, move=cruise(w.cruise * 0.8), solid=False)
    yield from near(w, a, u.uniform(22, 32))
    w.note("brakes_hard", a)
    a.memory.update(want=a.v * 0.3, brake=u.uniform(4.5, 6.0))
    yield from wait(w, u.uniform(0.6, 1.0))
    w.forced = -u.uniform(1.8, 2.6)
    yield from wait(w, u.uniform(1.6, 2.2))
    w.forced = None
    yield from wait(w, 3)
    a.memory.update(want=1.0, brake=1.0)
    yield from past(w, a, by=40)
    gone(a)
    yield from settle(w)


def weaving(w):
    """From side to side over the lines, ahead of the ego, which eases off when it has seen enough."""
    u = w.draw
    lane = w.ego.d
    v = w.cruise * u.uniform(0.75, 0.85)
    a = w.add("car", w.ego.s + 75, lane, v, move=cruise(v))
    yield from near(w, a, u.uniform(34, 42))
    period, reach = u.uniform(4.0, 5.0), u.uniform(1.1, 1.4)
    w.note("weaves", a, period=round(period, 2), reach=round(reach, 2))
    t0 = w.t

    def move(a, w):
        d = lane + reach * math.sin(2 * math.pi * (w.t - t0) / period)
        a.psi = math.atan2(d - a.d, a.v * 0.1)
        a.s, a.d = a.s + a.v * 0.1, d
    a.move = move
    yield from wait(w, period * u.uniform(0.9, 1.1))
    w.forced = -u.uniform(1.6, 2.2)
    yield from wait(w, 1.6)
    w.forced = None
    yield from wait(w, 9)
    def leave(a, w):
        a.v = min(a.v + 0.3, w.cruise * 2)
        a.d += (lane - a.d) * 0.05
        a.psi = 0.0
        a.s += a.v * 0.1
    a.move = leave
    while a.s - w.ego.s < 84:
        yield
    gone(a)
    yield from settle(w)


def wrong_way(w):
    """Comes towards the ego in the ego's lane and swings back into its own before it is too late."""
    u = w.draw
    v = u.uniform(6, 8)
    a = w.add("car", w.ego.s + 84, w.ego.d, v, psi=math.pi, move=cruise(v))
    a.memory["face"] = -1
    w.note("wrong_way", a)
    while w.ahead(a) > u.uniform(26, 30):
        yield
    slide(a, w, -w.road.lane(w.road.lanes - 1), 2.2)
    yield from wait(w, 1.4)
    a.solid = False
    yield from past(w, a)
    gone(a)
    yield from settle(w)
