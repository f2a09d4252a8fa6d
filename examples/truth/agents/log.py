"""Reads a drive back from what was written: SUMO's FCD and the script beside it. Places are (s, d) along and left of the road's center
line, found by projecting the FCD positions on the scripted road; nothing here knows Whyroad."""

import bisect
import gzip
import itertools
import json
import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from stage import ON_FOOT, TYPES, Road

DT = 0.1
VRU = {"walker", "bike"}
ANIMAL = {"dog", "cow"}
THING = {"crate", "skip", "bag"}
LARGE = {"lorry", "coach"}


@dataclass
class State:
    """One object at one moment: middle of its box."""
    s: float
    d: float
    v: float      # along its own heading, m/s; negative: backwards
    a: float
    psi: float    # heading against the road's, rad
    signals: int
    x: float
    y: float
    heading: float


class Log:
    def __init__(self, folder):
        self.name = folder.name
        script = json.loads(gzip.open(folder / "script.json.gz").read())
        r = script["road"]
        self.cruise, self.events = r["cruise"], script["events"]
        self.road = Road(r["length"], r["lanes"], r["width"], r["bends"])
        self.ramps = r.get("ramps", [])
        self.crosswalks = r.get("crosswalks", [])
        self.houses = [[self.road.at(s, d)[:2] for s, d in ((a, c), (b, c), (b, e), (a, e))] for a, b, c, e in script["houses"]]
        self.works = script.get("works", [])
        self.aeb = []
        self.tracks, self.types, self.times = {}, {}, []
        guess = {}
        for step in ET.fromstring(gzip.open(folder / "fcd.xml.gz").read()):
            t = round(float(step.get("time")), 1)
            self.times.append(t)
            for o in step:
                i, kind = o.get("id"), o.get("type")
                self.types[i] = kind
                heading = math.radians(90 - float(o.get("angle")))
                x, y = float(o.get("x")), float(o.get("y"))
                if kind not in ON_FOOT:
                    x, y = x - TYPES[kind][1] / 2 * math.cos(heading), y - TYPES[kind][1] / 2 * math.sin(heading)
                s, d, along = self.road.project(x, y, guess.get(i))
                guess[i] = s
                psi = (heading - along + math.pi) % (2 * math.pi) - math.pi
                self.tracks.setdefault(i, {})[t] = State(s, d, float(o.get("speed")), float(o.get("acceleration")), psi,
                                                         int(o.get("signals")), x, y, heading)
                if i == "ego" and o.get("whyroad.aeb") == "1":
                    self.aeb.append(t)
        self.ego = self.tracks.pop("ego")
        self.way = sorted((e.s, e.d) for e in self.ego.values())
        self.way_s = [p[0] for p in self.way]

    def size(self, i):
        return TYPES[self.types.get(i, "ego_car")][1:3]

    def half(self, i, o):
        """Half its reach along and across the road."""
        length, width = self.size(i)
        c, k = abs(math.cos(o.psi)), abs(math.sin(o.psi))
        return (length * c + width * k) / 2, (length * k + width * c) / 2

    def path_d(self, s):
        """Where across the road the ego drives at s."""
        k = min(max(bisect.bisect_left(self.way_s, s), 0), len(self.way) - 1)
        return self.way[k][1]

    def lane_of(self, d):
        """Index of the ego's direction's lane at d, from the right."""
        return min(max(int((d - self.road.edge) // self.road.width), 0), self.road.lanes - 1)

    def gap(self, i, t):
        """Bumper to bumper along the road, m; negative beside or behind."""
        o, e = self.tracks[i][t], self.ego[t]
        return o.s - e.s - self.half(i, o)[0] - self.half("ego", e)[0]

    def off_path(self, i, t):
        """Sideways from the ego's driven way, m, left positive: middle of the box."""
        o = self.tracks[i][t]
        return o.d - self.path_d(o.s)

    def in_path(self, i, t):
        o = self.tracks[i][t]
        return abs(self.off_path(i, t)) < self.half(i, o)[1] + self.size("ego")[1] / 2

    def gap_in_way(self, i, t, margin=0.0):
        """To the nearest part of its box that is in the strip which the ego sweeps (wider by the margin on either side), m: of a box that
        stands at an angle, the corner that is in the way is not the nearest one. Infinite without such a part."""
        o, e = self.tracks[i][t], self.ego[t]
        length, width = self.size(i)
        c, k = math.cos(o.psi), math.sin(o.psi)
        box = [(o.s + a * length / 2 * c - b * width / 2 * k, o.d + a * length / 2 * k + b * width / 2 * c)
               for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
        edge = self.size("ego")[1] / 2 + margin
        off = lambda p: p[1] - self.path_d(p[0])
        inside = [s for s, d in box if abs(off((s, d))) < edge]
        for p, q in zip(box, box[1:] + box[:1]):
            for line in (-edge, edge):
                if (off(p) - line) * (off(q) - line) < 0:
                    inside.append(p[0] + (q[0] - p[0]) * (line - off(p)) / (off(q) - off(p)))
        return min(inside, default=math.inf) - e.s - self.half("ego", e)[0]

    def ttc(self, i, t, margin=0.0, gap=None):
        """Along the path, s; infinite where the two do not close or it is not in the way (by so much, m)."""
        gap = self.gap(i, t) if gap is None else gap
        o, e = self.tracks[i][t], self.ego[t]
        closing = e.v - o.v * math.cos(o.psi)
        reach = self.half(i, o)[1] + self.size("ego")[1] / 2 + margin
        if not (gap > 0 and closing > 0 and abs(self.off_path(i, t)) < reach):
            return math.inf
        ttc = gap / closing
        # Who goes across or comes towards the ego must still be in its way by then.
        if abs(o.psi) > math.radians(45):
            then = o.d + o.v * math.sin(o.psi) * ttc - self.path_d(e.s + e.v * ttc)
            if abs(then) > reach:
                return math.inf
        return ttc

    def drac(self, i, t, margin=0.0, gap=None):
        """What deceleration avoids it, m/s2: the closing speed over twice the TTC; 0 where there is none."""
        o, e = self.tracks[i][t], self.ego[t]
        return max(e.v - o.v * math.cos(o.psi), 0) / (2 * self.ttc(i, t, margin, gap))

    def ttc_course(self, i, t):
        """The same if the ego kept its present place in the lane."""
        o, e = self.tracks[i][t], self.ego[t]
        gap, closing = self.gap(i, t), e.v - o.v * math.cos(o.psi)
        in_way = abs(o.d - e.d) < self.half(i, o)[1] + self.half("ego", e)[1]
        return gap / closing if gap > 0 and closing > 0 and in_way else math.inf

    def lead(self, t):
        """The nearest vehicle ahead on the ego's path that goes its way, or None."""
        near = [(self.gap(i, t), i) for i, tr in self.tracks.items() if t in tr and self.types[i] not in VRU | ANIMAL | THING
                and abs(tr[t].psi) < math.radians(45) and tr[t].s > self.ego[t].s and self.in_path(i, t) and self.gap(i, t) < 80]
        return min(near)[1] if near else None

    def visible(self, i, t, by):
        """Share of nine points across the target's box to which the straight line from the ego's middle is free of the boxes and
        corners in `by` (ids or polygons)."""
        o, e = self.tracks[i][t], self.ego[t]
        length, width = self.size(i)
        aim = math.atan2(o.y - e.y, o.x - e.x)
        reach = (length * abs(math.sin(o.heading - aim)) + width * abs(math.cos(o.heading - aim))) / 2
        walls = [p if isinstance(p, list) else self.corners(p, t) for p in by if isinstance(p, list) or t in self.tracks[p]]
        free = 0
        for k in range(-4, 5):
            x, y = o.x - math.sin(aim) * reach * k / 4.5, o.y + math.cos(aim) * reach * k / 4.5
            free += not any(cuts((e.x, e.y), (x, y), wall) for wall in walls)
        return free / 9

    def corners(self, i, t):
        return self.box(i, self.tracks[i][t])

    def box(self, i, o):
        length, width = self.size(i)
        c, k = math.cos(o.heading), math.sin(o.heading)
        return [(o.x + a * length / 2 * c - b * width / 2 * k, o.y + a * length / 2 * k + b * width / 2 * c)
                for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]

    def contacts(self):
        """Who touches the ego or one another, when first, and in which scene: by boxes. A script that makes that happen is wrong."""
        everybody = self.tracks | {"ego": self.ego}
        out = {}
        for i, j in itertools.combinations(sorted(everybody), 2):
            for t in everybody[i]:
                a, b = everybody[i][t], everybody[j].get(t)
                if b and abs(a.s - b.s) < 13 and overlap(self.box(i, a), self.box(j, b)):
                    out[i, j] = t, [e["name"] for e in self.events if e["what"] == "scene" and e["t"] <= t][-1]
                    break
        return out


def overlap(a, b):
    for p in (a, b):
        for (x0, y0), (x1, y1) in zip(p, p[1:] + p[:1]):
            along = [[(y0 - y1) * x + (x1 - x0) * y for x, y in q] for q in (a, b)]
            if max(along[0]) < min(along[1]) or max(along[1]) < min(along[0]):
                return False
    return True


def cuts(p, q, polygon):
    """Whether the line from p to q meets an edge of the polygon."""
    side = lambda a, b, c: (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return any(side(p, q, a) * side(p, q, b) < 0 and side(a, b, p) * side(a, b, q) < 0
               for a, b in zip(polygon, polygon[1:] + polygon[:1]))


def runs(times, holds, bridge=0.15):
    """Stretches [from, to] of the times for which it holds; breaks up to `bridge` seconds do not end one."""
    out = []
    for t in times:
        if holds(t):
            if out and t - out[-1][1] <= bridge + 1e-6:
                out[-1][1] = t
            else:
                out.append([t, t])
    return out
