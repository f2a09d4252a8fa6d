"""As leaves.py, for a crossroads (crossing.py): who met whom there, from the routes that the script gave and how everybody moved. The
junction's area is the one of SUMO's network."""

import gzip
import json
import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from log import overlap
from stage import ON_FOOT, TYPES

I = "reactive_agent.intersection_interaction."


@dataclass
class Place:
    x: float
    y: float
    heading: float
    v: float
    a: float
    type: str

    def box(self, margin=0.0):
        length, width = TYPES[self.type][1] + 2 * margin, TYPES[self.type][2] + 2 * margin
        c, k = math.cos(self.heading), math.sin(self.heading)
        return [(self.x + a * length / 2 * c - b * width / 2 * k, self.y + a * length / 2 * k + b * width / 2 * c)
                for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]

    def front(self):
        half = TYPES[self.type][1] / 2
        return self.x + half * math.cos(self.heading), self.y + half * math.sin(self.heading)


class CrossingLog:
    def __init__(self, folder):
        self.name = folder.name
        script = json.loads(gzip.open(folder / "script.json.gz").read())
        self.events = script["events"]
        self.routes = {e["id"]: e for e in self.events if e["what"] == "route"}
        self.times, self.at = [], {}
        for step in ET.fromstring(gzip.open(folder / "fcd.xml.gz").read()):
            t = round(float(step.get("time")), 1)
            self.times.append(t)
            for o in step:
                h, kind = math.radians(90 - float(o.get("angle"))), o.get("type")
                back = 0.0 if kind in ON_FOOT else TYPES[kind][1] / 2
                self.at.setdefault(o.get("id"), {})[t] = Place(float(o.get("x")) - back * math.cos(h), float(o.get("y")) - back * math.sin(h), h,
                                                              float(o.get("speed")), float(o.get("acceleration")), kind)
        self.ego = self.at.pop("ego")
        net = ET.fromstring(gzip.open(folder / "net.xml.gz").read())
        shape = next(j.get("shape") for j in net.iter("junction") if j.get("id") == "c")
        self.area = [tuple(map(float, p.split(","))) for p in shape.split()]

    def contacts(self):
        return [(i, t) for i, track in self.at.items() for t in track if overlap(track[t].box(), self.ego[t].box())][:1]


def inside(p, polygon):
    odd = False
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y0 > p[1]) != (y1 > p[1]) and p[0] < x0 + (p[1] - y0) * (x1 - x0) / (y1 - y0):
            odd = not odd
    return odd


def conflict(log, i):
    """When each of the two takes the place that both their boxes cover at some time: (ego from, to, other from, to), or None."""
    mine, its = log.ego, log.at[i]
    ego, other = sorted(mine), sorted(its)
    near = [(t, u) for t in ego[::2] for u in other[::2] if abs(mine[t].x - its[u].x) + abs(mine[t].y - its[u].y) < 14
            and overlap(mine[t].box(), its[u].box())]
    if not near:
        return None
    return min(t for t, _ in near), max(t for t, _ in near), min(u for _, u in near), max(u for _, u in near)


def kind(ego, other):
    """The class by the two routes (taxonomy); None where no class speaks of the two."""
    order = "WSEN"
    side = (order.index(other["arm"]) - order.index(ego["arm"])) % 4  # 0 same arm, 1 from the right, 2 opposite, 3 from the left
    if side == 0:
        return "same_direction_turn" if ego["turn"] == other["turn"] != "s" else None
    if ego["turn"] == "l" and side == 2 and other["turn"] in "sr":
        return "unprotected_left"
    if ego["turn"] == "r" and ((side == 3 and other["turn"] == "s") or (side == 2 and other["turn"] == "l")):
        return "right_vs_straight"
    if ego["turn"] == "s" and side == 1 and other["turn"] == "r":
        return "presses_in"
    return "cross_conflict"


def interactions(log):
    enters = next((t for t in log.times if inside(log.ego[t].front(), log.area)), None)
    if enters is None:
        return
    def in_area(t):
        return any(inside(c, log.area) for c in log.ego[t].box())
    leaves = next(t for t in log.times if t > enters + 1 and not in_area(t))
    for i, track in log.at.items():
        what = kind(log.routes["ego"], log.routes[i])
        slows = any(log.ego[t].a < -1 or log.ego[t].v < 1 for t in log.times if enters - 5 < t < leaves)
        if what == "same_direction_turn":
            both = [t for t in log.times if t in track and inside((track[t].x, track[t].y), log.area) and inside((log.ego[t].x, log.ego[t].y), log.area)]
            beside = [t for t in both if overlap(log.ego[t].box(0.75), track[t].box(0.75))]
            if beside:
                yield I + what, enters, enters, leaves, i
            continue
        found = conflict(log, i)
        if found is None or what is None:
            continue
        e0, e1, o0, o1 = found
        if what == "presses_in":
            # In the junction the border is half a lane beside the ego's way; it stays and is the lead within 2 s or TTC < 5 s.
            way = [log.ego[t].box() for t in log.times]
            key = next((t for t in sorted(track) if any(overlap(track[t].box(0.8), w) for w in way[::3]) and inside((track[t].x, track[t].y), log.area)), None)
            if key is not None:
                ego, other = log.ego[key], track[key]
                gap = math.dist((ego.x, ego.y), (other.x, other.y)) - 4.65
                if gap / max(ego.v, 0.1) < 2 or any(0 < (math.dist((log.ego[u].x, log.ego[u].y), (track[u].x, track[u].y)) - 4.65)
                                                    / max(log.ego[u].v - track[u].v, 0.01) < 5 for u in log.times if key <= u <= key + 3 and u in track):
                    yield "reactive_agent.cutin.intersection", key - 2, key, key + 3, i
            continue
        # They would be there, or really were, within 5 s of each other; one of them adjusts.
        apart = min(abs(e0 - o1), abs(o0 - e1)) if e0 > o1 or o0 > e1 else 0.0
        slowed = any(track[t].a < -1 for t in track if enters - 5 < t < leaves)
        if apart < 5 and (slows or slowed or what == "unprotected_left"):
            yield I + what, enters, enters, leaves, i
