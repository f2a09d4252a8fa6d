"""What SUMO wrote of one run, in the form the derivations use. Reads nothing of Whyroad's.

Times are whole tenths of a second since the start (`k`). A vehicle's place is its front bumper's; `centre_k` tells when its middle gets
to where its front was, because recordings and their truth speak of box centers.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections import defaultdict
from types import SimpleNamespace

START_NS = 1_767_225_600 * 10**9  # 2026-01-01T00:00:00Z, where `ingest sumo` puts zero
TYPES = {}


def shape(text):
    """Points with height; SUMO leaves a height of 0 out."""
    return [(*map(float, p.split(",")), 0.0)[:3] for p in text.split()]


class Road:
    """The network: lanes, edges, connections with their direction, light and right of way."""

    def __init__(self, path):
        net = ET.parse(path).getroot()
        self.lanes, self.edges = {}, {}
        for e in net.iter("edge"):
            self.edges[e.get("id")] = SimpleNamespace(id=e.get("id"), function=e.get("function") or "normal", start=e.get("from"), end=e.get("to"),
                                                      kind=e.get("type") or "", crosses=(e.get("crossingEdges") or "").split(), lanes=[])
            for l in e.iter("lane"):
                lane = SimpleNamespace(id=l.get("id"), edge=e.get("id"), index=int(l.get("index")), length=float(l.get("length")), speed=float(l.get("speed")),
                                       width=float(l.get("width") or 3.2), shape=shape(l.get("shape")), allow=(l.get("allow") or "").split(),
                                       acceleration=l.get("acceleration") == "1")
                self.lanes[lane.id] = lane
                self.edges[e.get("id")].lanes.append(lane)
        self.via, self.after, self.out = {}, {}, defaultdict(list)
        for c in net.iter("connection"):
            link = SimpleNamespace(start=c.get("from"), lane=f'{c.get("from")}_{c.get("fromLane")}', to=c.get("to"), to_lane=f'{c.get("to")}_{c.get("toLane")}',
                                   via=c.get("via"), dir=c.get("dir"), tl=c.get("tl"), index=int(c.get("linkIndex") or -1))
            if c.get("from").startswith(":"):
                self.after[link.lane] = link
            else:
                self.out[link.lane].append(link)
                self.via[c.get("via")] = link
        self.junctions = {}
        for j in net.iter("junction"):
            if j.get("type") == "internal":
                continue
            requests = {int(r.get("index")): r for r in j.iter("request")}
            inside = (j.get("intLanes") or "").split()
            self.junctions[j.get("id")] = SimpleNamespace(
                id=j.get("id"), kind=j.get("type"), x=float(j.get("x")), y=float(j.get("y")), incoming=[l for l in (j.get("incLanes") or "").split() if not l.startswith(":")],
                # By internal lane: with which others its way crosses or joins, and to which it has to give way.
                foes={inside[i]: {inside[k] for k, b in enumerate(reversed(r.get("foes"))) if b == "1" and k < len(inside)} for i, r in requests.items() if i < len(inside)},
                yields={inside[i]: {inside[k] for k, b in enumerate(reversed(r.get("response"))) if b == "1" and k < len(inside)} for i, r in requests.items() if i < len(inside)})
        self.ring = set()
        for r in net.iter("roundabout"):
            self.ring |= set(r.get("edges").split())
        ring_nodes = {self.edges[e].end for e in self.ring}
        for j in self.junctions.values():
            roads = [e for e in self.edges.values() if e.function == "normal" and j.id in (e.start, e.end) and any(not l.allow or set(l.allow) & {"passenger", "bus"} for l in e.lanes)]
            comes, leaves = {e.start for e in roads if e.end == j.id}, {e.end for e in roads if e.start == j.id}
            j.in_ring = j.id in ring_nodes
            # Three or more roads, and not only one-way roads that merge or part.
            j.real = len(comes | leaves) >= 3 and not (comes.isdisjoint(leaves) and min(len(comes), len(leaves)) == 1)

    def junction_of(self, lane):
        """The junction inside which a lane runs."""
        return self.junctions[re.fullmatch(r":(.+)_\d+_\d+", lane).group(1)]


class Run:
    def __init__(self, work, name):
        self.name, self.road = name, Road(work / "net.xml")
        self.rows, self.ways = defaultdict(dict), {}
        last = 0
        for _, step in ET.iterparse(work / "fcd.xml"):
            if step.tag != "timestep":
                continue
            last = k = round(float(step.get("time")) * 10)
            for o in step:
                get = lambda n: float(o.get(n) or "nan")
                self.rows[o.get("id")][k] = SimpleNamespace(
                    k=k, x=get("x"), y=get("y"), z=get("z"), angle=get("angle"), speed=get("speed"), accel=get("acceleration"), pos=get("pos"),
                    lane=o.get("lane") or o.get("edge"), signals=int(o.get("signals") or 0), type=o.get("type"), person=o.tag == "person",
                    leader=o.get("leaderID") or None, gap=get("leaderGap"), lead_speed=get("leaderSpeed"))
            step.clear()
        self.last = last
        types = ET.parse(__file__.replace("log.py", "types.rou.xml")).getroot()
        self.size = {v.get("id"): (float(v.get("length")), float(v.get("width")), v.get("vClass")) for v in types}
        self.lights = defaultdict(list)
        if (work / "tls.xml").exists():
            for s in ET.parse(work / "tls.xml").getroot():
                k, state, seen = round(float(s.get("time")) * 10), s.get("state"), self.lights[s.get("id")]
                if not seen or seen[-1][1] != state:
                    seen.append((k, state))
        self.changes = [SimpleNamespace(id=c.get("id"), k=round(float(c.get("time")) * 10), start=c.get("from"), to=c.get("to"), reason=c.get("reason"))
                        for c in ET.parse(work / "lanechange.xml").getroot()]
        self.conflicts = list(ET.parse(work / "ssm.xml").getroot().iter("conflict"))
        self.by_time = defaultdict(list)
        for i, rows in self.rows.items():
            for k, o in rows.items():
                self.by_time[k].append((i, o))

    def vehicle(self, name):
        return not next(iter(self.rows[name].values())).person

    def length(self, name):
        return self.size[next(iter(self.rows[name].values())).type][0]

    def width(self, name):
        return self.size[next(iter(self.rows[name].values())).type][1]

    def kind(self, name):
        return self.size[next(iter(self.rows[name].values())).type][2]

    def light(self, link, k):
        """The link's letter at a time, and since when; None without a light."""
        if not link.tl:
            return None
        states = [(u, s[link.index]) for u, s in self.lights[link.tl] if u <= k]
        now, since = states[-1][1], states[-1][0]
        for u, letter in reversed(states):
            if letter != now:
                break
            since = u
        return now, since

    def travelled(self, name):
        """Odometer by time, m, from the simulator's speeds."""
        if name in self.ways:
            return self.ways[name]
        rows, total, out = self.rows[name], 0.0, {}
        for k in sorted(rows):
            total += rows[k].speed * 0.1
            out[k] = total
        self.ways[name] = out
        return out

    def centre_k(self, name, k):
        """When the middle of the vehicle is where its front is at `k`."""
        way = self.travelled(name)
        later = [u for u in way if u >= k and way[u] - way[k] >= self.length(name) / 2]
        return min(later, default=max(way))

    def ns(self, k):
        return START_NS + round(max(0, min(k, self.last))) * 10**8

    def entry(self, leaf, ego, start, keyframe, end, target=None, optional=False, reason=None):
        rows = self.rows[ego]
        clamp = lambda k: max(min(rows), min(max(rows), k))
        out = {"scenario_id": leaf, "drive_id": f"{self.name}-{ego}"}
        if target:
            out["target_id"] = target
        keyframe = clamp(keyframe)
        out |= {"start_ns": self.ns(min(clamp(start), keyframe)), "keyframe_ns": self.ns(keyframe), "end_ns": self.ns(max(clamp(end), keyframe))}
        if optional:
            out["optional"] = True
        return out | ({"reason": reason} if reason else {})


def turn_deg(a, b):
    """From heading a to b, degrees, left positive; SUMO's angles go clockwise."""
    return -((b - a + 180) % 360 - 180)


def runs(keys, gap=1):
    """Unbroken runs of ascending times as (first, last); `gap` tenths may be missing."""
    out = []
    for k in sorted(keys):
        if out and k - out[-1][1] <= gap:
            out[-1][1] = k
        else:
            out.append([k, k])
    return [tuple(r) for r in out]


def nearest_on(points, x, y):
    """Distance from a polyline, and how far along it the nearest point is."""
    best = (math.inf, 0.0)
    done = 0.0
    for (ax, ay, *_), (bx, by, *_) in zip(points, points[1:]):
        length = math.hypot(bx - ax, by - ay)
        if length:
            t = max(0.0, min(1.0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2))
            d = math.hypot(x - ax - t * (bx - ax), y - ay - t * (by - ay))
            best = min(best, (d, done + t * length))
            done += length
    return best


class Way:
    """The way that a vehicle's front drives in a run, for distances along it."""

    def __init__(self, run, name):
        rows = run.rows[name]
        self.points, self.index, done = [], {}, []
        for k in sorted(rows):
            here = (rows[k].x, rows[k].y)
            if not self.points or math.dist(here, self.points[-1]) > 0.5:
                done.append(done[-1] + math.dist(here, self.points[-1]) if done else 0.0)
                self.points.append(here)
            self.index[k] = (len(self.points) - 1, done[-1] + math.dist(here, self.points[-1]))
        self.done = done

    def ahead(self, run, name, k, reach=250):
        """How far along this way the front of `name` is ahead of the front of the way's owner, m; NaN where it is more than 6 m beside it."""
        if k not in self.index:
            return math.nan
        at, own = self.index[k]
        o = run.rows[name][k]
        first = max(0, at - 20)
        off, along = nearest_on(self.points[first:at + reach], o.x, o.y)
        return self.done[first] + along - own if off < 6 else math.nan
