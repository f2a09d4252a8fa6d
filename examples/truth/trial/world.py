"""What SUMO wrote of one run, with times in whole tenths of a second (`k`). Nothing of Whyroad's is read.

Steps of 0.05 s are thinned, steps of 0.2 s filled in halfway, so that every derivation sees tenths. A position is the
front bumper's.
"""

import bisect
import math
import re
import xml.etree.ElementTree as ET
from collections import defaultdict
from types import SimpleNamespace as Box

START_NS = 1_767_225_600 * 10**9


def bend(a, b):
    """Degrees from SUMO's angle a to b; left is positive."""
    return -((b - a + 180) % 360 - 180)


def spans(keys, gap=1):
    out = []
    for k in sorted(keys):
        if out and k - out[-1][1] <= gap:
            out[-1][1] = k
        else:
            out.append([k, k])
    return [tuple(s) for s in out]


def off_line(points, x, y):
    """(distance, signed offset left positive, distance along) of a point to a polyline."""
    best, done = (math.inf, 0.0, 0.0), 0.0
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        length = math.hypot(bx - ax, by - ay)
        if not length:
            continue
        t = max(0.0, min(1.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2))
        px, py = ax + t * (bx - ax), ay + t * (by - ay)
        d = math.hypot(x - px, y - py)
        if d < best[0]:
            side = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length
            best = (d, side, done + t * length)
        done += length
    return best


class Net:
    def __init__(self, path):
        root = ET.parse(path).getroot()
        self.left_hand = root.get("lefthand") in ("true", "1")
        self.lanes, self.edges = {}, {}
        for e in root.iter("edge"):
            edge = Box(id=e.get("id"), inner=e.get("function") == "internal", walk=e.get("function") in ("crossing", "walkingarea"), crosses=(e.get("crossingEdges") or "").split(),
                       a=e.get("from"), b=e.get("to"), kind=e.get("type") or "", lanes=[], crossing=e.get("function") == "crossing")
            self.edges[edge.id] = edge
            for lane in e.iter("lane"):
                points = [tuple(map(float, p.split(",")[:2])) for p in lane.get("shape").split()]
                cars = "passenger" not in (lane.get("disallow") or "").split() and (not lane.get("allow") or bool({"passenger", "all"} & set(lane.get("allow").split())))
                edge.lanes.append(lane.get("id"))
                self.lanes[lane.get("id")] = Box(id=lane.get("id"), edge=edge.id, index=int(lane.get("index")), length=float(lane.get("length")), limit=float(lane.get("speed")),
                                                 width=float(lane.get("width") or 3.2), points=points, cars=cars, accel=lane.get("acceleration") == "1")
        self.out, self.by_via, self.after = defaultdict(list), {}, {}
        for c in root.iter("connection"):
            link = Box(a=c.get("from"), lane=f'{c.get("from")}_{c.get("fromLane")}', b=c.get("to"), to=f'{c.get("to")}_{c.get("toLane")}', via=c.get("via"), dir=c.get("dir"),
                       tl=c.get("tl"), index=int(c.get("linkIndex") or -1), state=c.get("state"))
            if link.a.startswith(":"):
                self.after[link.lane] = link
            elif not self.edges[link.a].walk:
                self.out[link.lane].append(link)
                self.by_via[link.via] = link
        self.ring = {e for r in root.iter("roundabout") for e in r.get("edges").split()}
        self.nodes = {}
        for j in root.iter("junction"):
            if j.get("type") == "internal":
                continue
            inside = (j.get("intLanes") or "").split()
            table = {int(r.get("index")): r for r in j.iter("request")}
            bits = lambda r, what: {inside[i] for i, b in enumerate(reversed(r.get(what))) if b == "1" and i < len(inside)}
            roads = [e for e in self.edges.values() if not e.inner and not e.walk and j.get("id") in (e.a, e.b) and any(self.lanes[x].cars for x in e.lanes)]
            comes, goes = self.arms(j.get("id"), roads)
            oneway = comes.isdisjoint(goes) and min(len(comes), len(goes)) == 1
            self.nodes[j.get("id")] = Box(id=j.get("id"), kind=j.get("type"), comes=comes, roads=roads, drives=self.drives(j.get("id"), roads), real=len(comes | goes) >= 3 and not oneway,
                                          foes={inside[i]: bits(r, "foes") for i, r in table.items() if i < len(inside)},
                                          yields={inside[i]: bits(r, "response") for i, r in table.items() if i < len(inside)}, on_ring=any(e.id in self.ring for e in roads))

    def arms(self, node, roads):
        """The nodes from which `roads` come to a node, and to which they go. Where a bay begins netconvert divides one direction
        of a road: the node there is not another arm.
        """
        cars = [e for e in self.edges.values() if not e.inner and not e.walk and any(self.lanes[x].cars for x in e.lanes)]
        into, out = defaultdict(list), defaultdict(list)
        for e in cars:
            into[e.b].append(e)
            out[e.a].append(e)
        joint = lambda n: len(into[n]) == len(out[n]) == 1
        comes, goes = {e.a for e in roads if e.b == node}, {e.b for e in roads if e.a == node}
        whole = lambda n, others, step: step(n) if n not in others and joint(n) and step(n) in others else n
        return ({whole(n, goes, lambda n: into[n][0].a) for n in comes}, {whole(n, comes, lambda n: out[n][0].b) for n in goes})

    def drives(self, node, roads):
        """Whether driveways alone make a junction of a node: the other roads come from two directions or fewer."""
        streets = [e for e in roads if not e.kind.endswith("service")]
        ways = [self.heading(e.lanes[0], False) if e.a == node else self.heading(e.lanes[0]) + 180 for e in streets]
        apart = [a for n, a in enumerate(ways) if all(abs(bend(a, b)) > 40 for b in ways[:n])]
        return len(streets) < len(roads) and len(apart) < 3

    def node_of(self, lane):
        return self.nodes[re.fullmatch(r":(.+)_[cw]?\d+_\d+", lane).group(1)]

    def counter(self, a, b):
        """Whether edge b is edge a the other way."""
        a, b = self.edges[a], self.edges[b]
        return a is not b and (a.a, a.b) == (b.b, b.a)

    def on_crossing(self, place):
        """For people SUMO writes an edge or a lane."""
        edge = self.edges.get(place) or self.edges.get(place.rsplit("_", 1)[0])
        return edge is not None and edge.crossing

    def at_crossing(self, place):
        """On a crossing or at its end."""
        edge = self.edges.get(place) or self.edges.get(place.rsplit("_", 1)[0])
        return edge is not None and edge.walk

    def heading(self, lane, end=True):
        (ax, ay), (bx, by) = self.lanes[lane].points[-2:] if end else self.lanes[lane].points[:2]
        return math.degrees(math.atan2(bx - ax, by - ay)) % 360

    def path(self, link):
        """Inner lanes of a connection, in order."""
        lane, out = link.via, []
        while lane and lane.startswith(":"):
            out.append(lane)
            nxt = self.after.get(lane)
            lane = nxt.via if nxt else None
        return out


class World:
    def __init__(self, work, name):
        self.name, self.net = name, Net(work / "net.xml")
        self.rows = defaultdict(dict)
        self.last = 0
        for _, step in ET.iterparse(work / "fcd.xml"):
            if step.tag != "timestep":
                continue
            tenths = float(step.get("time")) * 10
            if abs(tenths - round(tenths)) < 0.01:
                k = self.last = round(tenths)
                for o in step:
                    get = lambda n: float(o.get(n) or "nan")
                    self.rows[o.get("id")][k] = Box(x=get("x"), y=get("y"), angle=get("angle"), v=get("speed"), a=get("acceleration"), pos=get("pos"), lane="" if o.get("id").startswith("still") else o.get("lane") or o.get("edge") or "",
                                                    blink=int(o.get("signals") or 0) & 3, type=o.get("type"), person=o.tag == "person", leader=o.get("leaderID") or None, gap=get("leaderGap"))
            step.clear()
        for rows in self.rows.values():
            for k in sorted(rows):
                if k + 1 not in rows and k + 2 in rows:
                    a, b = rows[k], rows[k + 2]
                    half = lambda n: (getattr(a, n) + getattr(b, n)) / 2
                    rows[k + 1] = Box(**{**a.__dict__, "x": half("x"), "y": half("y"), "v": half("v"), "a": half("a"), "angle": a.angle - bend(a.angle, b.angle) / 2,
                                         "pos": half("pos") if a.lane == b.lane else a.pos, "gap": half("gap") if a.leader == b.leader else a.gap})
        self.size = {v.get("id"): Box(length=float(v.get("length")), width=float(v.get("width")), kind=v.get("vClass")) for v in ET.parse(work / "trips.xml").getroot().iter("vType")}
        self.lights = defaultdict(list)
        if (work / "tls.xml").exists():
            for s in ET.parse(work / "tls.xml").getroot():
                seen = self.lights[s.get("id")]
                if not seen or seen[-1][1] != s.get("state"):
                    seen.append((round(float(s.get("time")) * 10), s.get("state")))
        self.changes = defaultdict(list)
        for c in ET.parse(work / "lanechange.xml").getroot():
            self.changes[c.get("id")].append(Box(id=c.get("id"), k=round(float(c.get("time")) * 10), a=c.get("from"), b=c.get("to"), reason=(c.get("reason") or "").split("|")[0]))
        self.ssm = list(ET.parse(work / "ssm.xml").getroot().iter("conflict"))
        self.at = defaultdict(list)
        for i, rows in self.rows.items():
            for k in rows:
                self.at[k].append(i)
        self.odo, self.steps, self.wandered, self.spots = {}, {}, {}, {}
        self.passing = {i: self.passages(i) for i in self.rows if not self.first(i).person}

    def first(self, i):
        return next(iter(self.rows[i].values()))

    def kind(self, i):
        return self.size[self.first(i).type].kind

    def length(self, i):
        return self.size[self.first(i).type].length

    def width(self, i):
        return self.size[self.first(i).type].width

    def way(self, i):
        if i not in self.odo:
            total, out = 0.0, {}
            for k in sorted(self.rows[i]):
                total += self.rows[i][k].v * 0.1
                out[k] = total
            self.odo[i] = out
        return self.odo[i]

    def later(self, i, k, metres):
        """When the vehicle has come so many meters further."""
        way = self.way(i)
        if i not in self.steps:
            self.steps[i] = (list(way), list(way.values()))
        keys, done = self.steps[i]
        n = bisect.bisect_left(keys, k)
        if n == len(keys):
            return keys[-1]
        n = max(n, bisect.bisect_left(done, way[k] + metres - 1e-6))
        return next((keys[m] for m in range(n, len(keys)) if done[m] - way[k] >= metres), keys[-1])

    def letter(self, link, k):
        states = self.lights.get(link.tl) if link.tl else None
        if not states:
            return None
        i = max(0, bisect.bisect_right(states, (k, "~")) - 1)
        return states[i][1][link.index]

    def turned_to(self, link, k, letters):
        """Since when the link shows one of `letters` (it does at k)."""
        while k > 0 and (self.letter(link, k - 1) or "") in letters:
            k -= 1
        return k

    def passages(self, i):
        rows, out, now = self.rows[i], [], None
        for k in sorted(rows):
            lane = rows[k].lane
            node = self.net.node_of(lane) if lane.startswith(":") and lane in self.net.lanes and not self.net.edges[self.net.lanes[lane].edge].walk else None
            if now and (node is None or node.id != now.node.id):
                now.whole = True
                out.append(now)
                now = None
            if node is not None:
                if now is None:
                    now = Box(node=node, first=k, last=k, whole=False, began=k - 1 in rows, link=self.net.by_via.get(lane))
                now.last = k
        if now:
            out.append(now)
        for p in out:
            # Its own heading follows its front: the turn is over when its rear is out, too.
            way, done = self.way(i), p.last
            while done + 1 in rows and way[done] - way[p.last] < self.length(i):
                done += 1
            before = rows.get(p.first - 1, rows[p.first]).angle
            p.turned = sum(bend(rows[k - 1].angle if k - 1 in rows else before, rows[k].angle) for k in range(p.first, done + 1) if k in rows)
        return [p for p in out if p.link is not None]

    def ns(self, k):
        return START_NS + round(max(0, min(k, self.last))) * 10**8

    def entry(self, leaf, ego, start, key, end, target=None, optional=False, reason=""):
        lo, hi = min(self.rows[ego]), max(self.rows[ego])
        key = max(lo, min(hi, key))
        out = {"scenario_id": leaf, "drive_id": f"{self.name}-{ego}"}
        if target:
            out["target_id"] = target
        out |= {"start_ns": self.ns(max(lo, min(start, key))), "keyframe_ns": self.ns(key), "end_ns": self.ns(min(hi, max(end, key + 1)))}
        return out | ({"optional": True} if optional else {}) | ({"reason": reason} if reason else {})
