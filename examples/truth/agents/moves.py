"""How actors move on the stage, and what scenes wait for. A scene is a generator that is resumed at every step and ends when it is over."""

import math

from stage import Slide, approach

RIGHT, LEFT = math.radians(-90), math.radians(90)


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
