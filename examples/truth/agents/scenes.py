"""What happens on the stage: each scene puts its people in front of the ego and says, as it goes, what it has told them to do.

A scene is a generator that is resumed at every step and ends when it is over. Numbers are drawn anew each time. Next to scenes that are
of a class stand some that look like it and are not (`decoy_*`): people on the pavement, cars that reverse in their drive, and so on.
"""

import math
from stage import Slide, approach

RIGHT, LEFT = math.radians(-90), math.radians(90)


# ---- how actors move


def walk(path_psi, speed, until=lambda a, w: False):
    def move(a, w):
        a.psi, a.v = path_psi, (0.0 if until(a, w) else speed)
        a.s += a.v * math.cos(a.psi) * 0.1
        a.d += a.v * math.sin(a.psi) * 0.1
    return move


def cruise(speed, brake=2.5, accel=1.6):
    """Along the road at `a.memory["want"]`, sideways as `a.memory["slide"]` says."""
    def move(a, w):
        m = a.memory
        want = m.setdefault("want", speed)
        approach(a, want, accel=m.get("accel", accel), brake=m.get("brake", brake))
        face = m.get("face", 1)
        before = a.d
        a.s += face * a.v * 0.1
        if slide := m.get("slide"):
            a.d = slide.at(w.t)
            if slide.done(w.t):
                m["slide"] = None
        sideways = math.atan2((a.d - before) * face, abs(a.v) * 0.1) if abs(a.v) > 0.2 else 0.0
        a.psi = (0.0 if face > 0 else math.pi) + (sideways if a.v >= 0 else -sideways)
    return move


def slide(a, w, d, over):
    a.memory["slide"] = Slide(w.t, a.d, d, over)


def wait(w, seconds):
    end = w.t + seconds
    while w.t < end - 1e-6:
        yield


def past(w, *actors, by=12.0):
    """Until the ego is past them all."""
    while any(a.there and a.s > w.ego.s - by for a in actors):
        yield


def near(w, actor, metres):
    while actor.s - w.ego.s > metres:
        yield


def settle(w, share=0.93, limit=25):
    """Until the ego drives freely again."""
    end = w.t + limit
    while w.t < end and (w.ego.v < share * w.wish or w.slide):
        yield


def gone(*actors):
    for a in actors:
        a.there = False


# ---- people


def crossing(w, psi_deg, type_="walker"):
    """Walks over the road in open view, from the kerb or from further back."""
    u = w.draw
    speed = u.uniform(1.1, 1.7) if type_ == "walker" else u.uniform(2.5, 3.5)
    from_right = u.random() < 0.5
    edge = w.road.edge if from_right else -w.road.edge
    back = u.choice([0.6, 6.0])
    psi = math.radians(psi_deg if from_right else -psi_deg)
    start_d = edge - math.copysign(back, -edge)
    across = abs(start_d - w.ego.d) / (speed * abs(math.sin(psi)))
    lead_m = max(across + u.uniform(-0.5, 0.8), 2.6) * w.ego.v
    a = w.add(type_, w.ego.s + lead_m + 25 - (start_d and abs(start_d - w.ego.d) / math.tan(abs(psi))), start_d, psi=psi)
    place = a.s + abs(start_d - w.ego.d) / math.tan(abs(psi))
    yield from near(w, a, lead_m)
    w.note("steps_off", a)
    far = -math.copysign(abs(w.road.edge) + 3, edge)
    a.move = walk(psi, speed, lambda a, w: (a.d - far) * math.copysign(1, far) > 0)
    while (a.d - far) * math.copysign(1, far) <= 0:
        yield
    a.solid = False
    yield from past(w, a)
    gone(a)
    return round(place, 1)


def at_crosswalk(w):
    """As `crossing`, on a crosswalk."""
    place = yield from crossing(w, w.draw.uniform(80, 100))
    w.road.crosswalks.append(place)


def crossing_square(w):
    yield from crossing(w, w.draw.uniform(75, 105))


def crossing_slant(w):
    yield from crossing(w, w.draw.choice([w.draw.uniform(36, 50), w.draw.uniform(130, 144)]))


def crossing_bike(w):
    yield from crossing(w, w.draw.uniform(80, 100), "bike")


def emerge_static(w):
    """Steps out from behind a parked van or lorry, or from behind a corner of a house."""
    u = w.draw
    edge = w.road.edge
    s0 = w.ego.s + 85
    if u.random() < 0.6:
        van = w.add(u.choice(["van", "lorry"]), s0, edge - 1.35, solid=False)
        corner = s0 + van.size[0] / 2
    else:
        van = None
        w.buildings.append((s0 - 8, s0, edge - 9, edge - 1.2))
        corner = s0
    speed = u.uniform(1.5, 2.2)
    a = w.add("walker", corner + u.uniform(0.6, 1.0), edge - 3.2 if van else edge - 4.0, psi=LEFT)
    a.solid = False
    # So much time is left to the ego when the walker comes out at the near side.
    hidden = abs((edge - 0.3) - a.d) / speed
    yield from near(w, a, min(u.uniform(1.75, 2.15) * w.ego.v, 24.0) + hidden * w.ego.v)
    w.note("steps_out", a, of="static")
    a.move = walk(LEFT, speed)
    w.lag, w.patience = 6.0, 0.2
    while a.d < edge - 0.7:
        yield
    a.solid = True
    while a.d < abs(edge) + 2:
        yield
    w.lag, w.patience = 3.0, 0.7
    gone(a)
    if van:
        yield from past(w, van)
        gone(van)
    yield from settle(w)


def emerge_dynamic(w):
    """Runs over the road behind a lorry that comes the other way, out of a gate in a wall."""
    u = w.draw
    speed, v = u.uniform(2.0, 2.8), u.uniform(8, 11)
    lane, far = -w.road.lane(w.road.lanes - 1), -w.road.edge
    place = w.ego.s + 78
    w.buildings.append((place - 24, place - 1.0, far + 0.5, far + 6))
    a = w.add("walker", place, far + 2.6, psi=RIGHT, solid=False)
    # Off the wall when the tail has gone by; out of the lorry's cover about a second later, two seconds before the ego.
    meet = (78 - min(u.uniform(1.7, 2.1) * w.ego.v, 25.0) - 1.1 * w.ego.v) / w.ego.v
    lorry = w.add(u.choice(["lorry", "coach"]), 0.0, lane, v, psi=math.pi, move=cruise(v), solid=False)
    lorry.s = place - 0.7 - lorry.size[0] / 2 + v * meet
    lorry.memory["face"] = -1
    yield from wait(w, meet - 2.1 / speed)
    w.note("steps_out", a, of="dynamic")
    a.move = walk(RIGHT, speed)
    while a.d > w.road.width * 0.45:
        yield
    a.solid = True
    w.lag, w.patience = 6.0, 0.2
    while a.d > w.road.edge - 2:
        yield
    w.lag, w.patience = 3.0, 0.7
    gone(a)
    yield from past(w, lorry)
    gone(lorry)
    yield from settle(w)


def pass_round(w, actor, clearance=1.2):
    """The ego goes round somebody who moves along the lane, over the line if need be, and back."""
    lane = w.ego.d
    w.blind.add(actor.id)
    w.shift(actor.d + actor.size[1] / 2 + clearance + 0.95, w.draw.uniform(2.6, 3.4))
    yield from past(w, actor, by=9)
    w.shift(lane, w.draw.uniform(2.6, 3.4))
    yield from wait(w, 4)


def cyclist_ahead(w):
    u = w.draw
    v = u.uniform(3.5, 5.0)
    a = w.add("bike", w.ego.s + 80, w.ego.d - u.uniform(0.2, 0.9), v, move=cruise(v))
    w.note("rides_along", a)
    yield from near(w, a, 12 + 1.5 * v)
    yield from wait(w, u.uniform(1.5, 4))
    yield from pass_round(w, a)
    gone(a)
    yield from settle(w)


def cyclist_comes_in(w):
    u = w.draw
    v = u.uniform(3.5, 5.0)
    a = w.add("bike", w.ego.s + 75, w.road.edge - 0.75, v, move=cruise(v), solid=False)
    yield from near(w, a, u.uniform(2.0, 2.7) * w.ego.v)
    w.note("comes_in", a)
    a.solid = True
    slide(a, w, w.ego.d - u.uniform(0.2, 0.7), u.uniform(1.6, 2.4))
    yield from wait(w, 5)
    yield from pass_round(w, a)
    gone(a)
    yield from settle(w)


def against_in_lane(w):
    u = w.draw
    type_ = u.choice(["bike", "walker"])
    v = u.uniform(3, 4.5) if type_ == "bike" else u.uniform(1.2, 1.6)
    a = w.add(type_, w.ego.s + 84, w.ego.d - u.uniform(0.7, 1.0), v, psi=math.pi, move=cruise(v))
    a.memory["face"] = -1
    w.note("comes_against", a)
    w.wish = w.cruise * 0.7
    yield from near(w, a, 40)
    yield from pass_round(w, a)
    w.wish = w.cruise
    gone(a)
    yield from settle(w)


def decoy_pavement(w):
    """On the pavement, one each way, and one who crosses behind the ego."""
    u = w.draw
    a = w.add("walker", w.ego.s + 60, w.road.edge - u.uniform(1.2, 2.5), psi=0.0, move=walk(0.0, 1.4))
    b = w.add("walker", w.ego.s + 70, -w.road.edge + u.uniform(1.2, 2.5), psi=math.pi, move=walk(math.pi, 1.3))
    yield from past(w, a, by=4)
    a.move = walk(LEFT, 1.5)
    yield from past(w, a, b, by=30)
    gone(a, b)


def decoy_far_crossing(w):
    """Crosses far ahead; the ego need not care."""
    a = w.add("walker", w.ego.s + 84, w.road.edge - 0.3, psi=LEFT, move=walk(LEFT, 2.8), solid=False)
    while a.d < abs(w.road.edge) + 9:
        yield
    yield from past(w, a)
    gone(a)


# ---- animals


def animal_crosses(w):
    u = w.draw
    from_right = u.random() < 0.5
    edge = w.road.edge if from_right else -w.road.edge
    psi = (LEFT if from_right else RIGHT) + math.radians(u.uniform(-25, 25))
    v = u.uniform(2, 3.5)
    start = edge - math.copysign(u.choice([1.0, 8.0]), -edge)
    lead_m = max(abs(start - w.ego.d) / v / abs(math.sin(psi)) + u.uniform(-0.3, 0.8), 2.5) * w.ego.v
    a = w.add("dog", w.ego.s + lead_m + 22, start, psi=psi)
    yield from near(w, a, lead_m)
    w.note("steps_off", a)
    far = -math.copysign(abs(edge) + 3, edge)
    a.move = walk(psi, v, lambda a, w: (a.d - far) * math.copysign(1, far) > 0)
    while (a.d - far) * math.copysign(1, far) <= 0:
        yield
    a.solid = False
    yield from past(w, a)
    gone(a)
    yield from settle(w)


def animal_stands(w):
    u = w.draw
    along = u.random() < 0.5
    a = w.add("cow", w.ego.s + 84, w.ego.d + u.uniform(-0.5, 0.5), psi=0.0, move=walk(0.0, 0.4 if along else 0.0))
    w.note("in_the_way", a)
    while w.ego.v > 0.6:
        yield
    a.move = walk(0.0, 0.0)
    yield from wait(w, u.uniform(2, 5))
    w.note("clears_off", a)
    a.move = walk(RIGHT, 1.2)
    while a.d > w.road.edge - 3:
        yield
    a.solid = False
    a.move = None
    a.v = 0.0
    yield from past(w, a)
    gone(a)
    yield from settle(w)


def decoy_animal(w):
    """On the meadow."""
    a = w.add("cow", w.ego.s + 75, w.road.edge - w.draw.uniform(9, 14), psi=0.5, move=walk(0.5, 0.2))
    yield from past(w, a)
    gone(a)


# ---- vehicles that do what nobody expects


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


def behind_lead(w, type_="car", factor=0.85, gap=70):
    """A lead that the ego catches up with."""
    v = w.cruise * factor
    a = w.add(type_, w.ego.s + gap, w.ego.d, v, move=cruise(v))
    end = w.t + 22
    while w.t < end and (w.ego.v - a.v > 0.3 or w.ahead(a) > 2.2 * a.v):
        yield
    yield from wait(w, w.draw.uniform(4, 7))
    return a


def drive_off(w, a):
    """The lead speeds away."""
    w.note("drives_off", a)
    a.memory.update(want=w.cruise * 1.8, accel=3.0)
    while a.s - w.ego.s < 84:
        yield
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


# ---- meeting


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


# ---- things in the way


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


# ---- lanes


def keeps_clear(w):
    return w.road.lane(1)


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
    """Joins from a ramp in front of the ego, `slower` m/s slower than it, with so many metres left."""
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
    """Moves off from the kerb in front of the ego."""
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
    """To the kerb, a halt, and on."""
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


STREET = [crossing_square, crossing_slant, crossing_bike, emerge_static, emerge_dynamic, cyclist_ahead, cyclist_comes_in, against_in_lane,
          animal_crosses, animal_stands, reversing, wrong_way, weaving, lead_brakes_hard, lead_stops, round_in_lane, round_over_line,
          ignores, swerve, late_braking, aeb_car, aeb_lorry, aeb_walker, at_crosswalk, meets_at_works, pulls_over, meets_lorry, from_kerb, lead_follow, decoy_pavement, decoy_far_crossing, decoy_animal,
          decoy_reversing, decoy_meeting, decoy_parked, lead_brakes_softly]
AVENUE = [cutin_urgent, cutin_slow, cutin_large, from_kerb, cutout, neighbour_brakes, escape, gives_up, overtakes, gains_speed, stop_and_go, queue_cutin,
          creep, lead_stops, lead_brakes_hard, lead_follow, lead_brakes_softly, weaving, decoy_parked]
MOTORWAY = [joins_urgent, joins_gently, lorry_joins, decoy_joins_behind, decoy_overtaken, lead_follow, lead_brakes_hard]
LANE = [narrow_meeting, crossing_square, against_in_lane, decoy_pavement, creep, animal_crosses, emerge_static, cyclist_ahead]
