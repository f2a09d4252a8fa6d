"""Scenes with people and animals. `decoy_*` look like something and are nothing."""

import math

from moves import LEFT, RIGHT, cruise, gone, near, past, settle, slide, wait, walk


def crossing(w, psi_deg, type_="walker"):
    """Walks over the road in open view, from the curb or from further back."""
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
