"""Roads as SUMO networks, and SUMO networks as the lane tables of Whyroad's table layout.

A road is a chain of pieces (straight or bent, level or steep), an edge each. Its geometry is laid out here, the network is built by
netconvert, and lanes, links and junctions are read back from the network that netconvert made.
"""

import math
import os
import subprocess
import xml.etree.ElementTree as xml
from dataclasses import dataclass

import sumo

STEP_M = 4.0
ARM_M = 90.0  # length of a crossing road's arm


@dataclass
class Piece:
    """A stretch of road. `bend` is the radius in m and the angle in degrees, left positive; `grade` rise over run."""
    length: float
    bend: tuple = None
    grade: float = 0.0
    lanes: int = 1
    width: float = 3.4
    limit: float = 13.89
    kinds: tuple = ()      # of each lane from the right: vehicle, bus, tidal, variable
    inner: str = "dashed"  # the marks between its lanes


@dataclass
class Cross:
    """A crossing road: directions of its arms against the road's own, and what the road's lanes lead to there, from the right."""
    arms: tuple = (90, -90)
    lights: bool = False
    wide: int = 1           # lanes of an arm in each direction
    into: int = None        # lane of an arm that a left turn leads into; None: the leftmost
    lanes: tuple = None     # "s", "l", "r" and combinations; None: straight on only


class Road:
    """Pieces one after the other from the origin, and what has been put beside them."""

    def __init__(self, heading_deg=0.0):
        self.pieces, self.starts, self.points = [], [], [(0.0, 0.0, 0.0, math.radians(heading_deg))]
        self.stations = [0.0]
        self.crosses = {}  # by the index of the piece that begins there

    @property
    def length(self):
        return self.stations[-1]

    def add(self, piece):
        self.pieces.append(piece)
        self.starts.append(self.length)
        if piece.bend:
            piece.length = piece.bend[0] * math.radians(abs(piece.bend[1]))
        n = max(1, round(piece.length / STEP_M)) if piece.bend else 1
        d = piece.length / n
        turn = math.copysign(d / piece.bend[0], piece.bend[1]) if piece.bend else 0.0
        for _ in range(n):
            x, y, z, h = self.points[-1]
            m = h + turn / 2
            self.points.append((x + d * math.cos(m), y + d * math.sin(m), z + d * piece.grade, h + turn))
            self.stations.append(self.stations[-1] + d)
        return self.starts[-1]

    def at(self, s, left=0.0):
        """Place and heading `left` m beside the middle of the road at station `s`."""
        i = max(0, min(len(self.stations) - 2, next((k for k, v in enumerate(self.stations) if v > s), 10**9) - 1))
        share = (s - self.stations[i]) / (self.stations[i + 1] - self.stations[i])
        (ax, ay, az, ah), (bx, by, bz, bh) = self.points[i], self.points[i + 1]
        x, y, z, h = ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az), ah + share * (bh - ah)
        return x - left * math.sin(h), y + left * math.cos(h), z, h

    def box(self, s0, s1, right, left):
        """Outline between two stations and two offsets to the left, along the bend."""
        n = max(1, round((s1 - s0) / STEP_M))
        along = [s0 + (s1 - s0) * k / n for k in range(n + 1)]
        return [self.at(s, right)[:3] for s in along] + [self.at(s, left)[:3] for s in reversed(along)]

    def cross(self, cross):
        """A crossing road where the next piece begins."""
        self.crosses[len(self.pieces)] = cross
        return self.length

    def write(self, folder):
        ends = [*self.starts, self.length]
        kind = {i: "traffic_light" if c.lights else "priority" for i, c in self.crosses.items()}
        nodes = "".join(f'<node id="n{i}" x="{x:.3f}" y="{y:.3f}" z="{z:.3f}" type="{kind.get(i, "priority")}"/>\n'
                        for i, (x, y, z, _) in enumerate(self.at(s) for s in ends))
        edges, links = "", ""
        for i, p in enumerate(self.pieces):
            shape = " ".join(f"{x:.3f},{y:.3f},{z:.3f}" for s, (x, y, z, _) in zip(self.stations, self.points) if ends[i] - 1e-6 <= s <= ends[i + 1] + 1e-6)
            edges += (f'<edge id="e{i}" from="n{i}" to="n{i + 1}" priority="9" numLanes="{p.lanes}" speed="{p.limit}" width="{p.width}" '
                      f'spreadType="center" shape="{shape}"/>\n')
            if i:
                cross = self.crosses.get(i)
                for k in range(min(self.pieces[i - 1].lanes, p.lanes)):
                    if not cross or cross.lanes is None or "s" in cross.lanes[k]:
                        links += f'<connection from="e{i - 1}" to="e{i}" fromLane="{k}" toLane="{k}"/>\n'
        for i, cross in self.crosses.items():
            x, y, z, h = self.at(ends[i])
            for k, degrees in enumerate(cross.arms):
                a = h + math.radians(degrees)
                nodes += f'<node id="m{i}_{k}" x="{x + ARM_M * math.cos(a):.3f}" y="{y + ARM_M * math.sin(a):.3f}" z="{z:.3f}" type="priority"/>\n'
                for name, ends_at in ((f"in{i}_{k}", (f"m{i}_{k}", f"n{i}")), (f"out{i}_{k}", (f"n{i}", f"m{i}_{k}"))):
                    edges += f'<edge id="{name}" from="{ends_at[0]}" to="{ends_at[1]}" numLanes="{cross.wide}" speed="13.89" priority="1" width="3.4"/>\n'
                for lane, ways in enumerate(cross.lanes or []):
                    if ("l" in ways and degrees > 0) or ("r" in ways and degrees < 0):
                        to = 0 if degrees < 0 else cross.wide - 1 if cross.into is None else cross.into
                        links += f'<connection from="e{i - 1}" to="out{i}_{k}" fromLane="{lane}" toLane="{to}"/>\n'
        (folder / "x.nod.xml").write_text(f"<nodes>{nodes}</nodes>")
        (folder / "x.edg.xml").write_text(f"<edges>{edges}</edges>")
        (folder / "x.con.xml").write_text(f"<connections>{links}</connections>")
        netconvert(folder)


def netconvert(folder, *more):
    subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", "netconvert"), "--node-files", folder / "x.nod.xml", "--edge-files", folder / "x.edg.xml",
                    "--connection-files", folder / "x.con.xml", "--output-file", folder / "net.xml", "--no-turnarounds",
                    "--offset.disable-normalization", "--geometry.max-grade", "20", "--junctions.limit-turn-speed", "5.5",
                    "--junctions.internal-link-detail", "20", *more],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def beside(line, d, before=None, behind=None):
    """A line `d` m to the left. `before` and `behind` are points of the lanes that it joins, so that the edges of both meet."""
    out = []
    whole = [before or line[0], *line, behind or line[-1]]
    for i, (x, y, z) in enumerate(line):
        (ax, ay, _), (bx, by, _) = whole[i], whole[i + 2]
        n = math.hypot(bx - ax, by - ay) or 1.0
        out.append((x - d * (by - ay) / n, y + d * (bx - ax) / n, z))
    return out


def cell(line):
    return ";".join(f"{x:.2f} {y:.2f} {z:.2f}" for x, y, z in line)


class Net:
    """What netconvert made."""

    def __init__(self, folder):
        root = xml.parse(folder / "net.xml").getroot()
        self.edges = {e.get("id"): e for e in root.iter("edge") if e.get("function") in (None, "internal")}
        self.lanes, self.edge_of = {}, {}
        for name, e in self.edges.items():
            for l in e.iter("lane"):
                self.lanes[l.get("id")] = l
                self.edge_of[l.get("id")] = name
        self.crossings = [l for e in root.iter("edge") if e.get("function") == "crossing" for l in e.iter("lane")]
        self.links = [c for c in root.iter("connection") if f"{c.get('from')}_{c.get('fromLane')}" in self.lanes]
        others = {}
        for e in self.edges.values():
            if not e.get("function"):
                others.setdefault(e.get("from"), set()).add(e.get("to"))
                others.setdefault(e.get("to"), set()).add(e.get("from"))
        self.real = {n for n, o in others.items() if len(o) >= 3}
        self.junctions = {j.get("id"): j for j in root.iter("junction")}

    def line(self, lane):
        out = []
        for p in lane.get("shape").split():
            v = [float(c) for c in p.split(",")]
            out.append((v[0], v[1], v[2] if len(v) > 2 else 0.0))
        return out

    def length(self, lane):
        return float(self.lanes[lane].get("length"))

    def node(self, edge):
        return edge[1:].rsplit("_", 1)[0] if edge.startswith(":") else self.edges[edge].get("to")

    def joining(self, name, others, end):
        if len(others) != 1 or name.startswith(":") or others[0].startswith(":"):
            return None
        return self.line(self.lanes[others[0]])[end]

    def rows(self, kinds=None, inner=None, guided=()):
        """Rows of `lanes.csv`. `kinds` and `inner` by edge: what each lane is for, the marks between lanes. `guided`: junctions whose
        turns have guidance lines."""
        kinds, inner = kinds or {}, inner or {}
        succ, pred, turn = {}, {}, {}
        # Where a road's pieces join, netconvert puts lanes without length: here one piece leads to the next.
        joint = {n for n in self.edges if n.startswith(":") and self.node(n) not in self.real}
        for c in self.links:
            a, b, via = f"{c.get('from')}_{c.get('fromLane')}", f"{c.get('to')}_{c.get('toLane')}", c.get("via")
            if c.get("from") in joint:
                continue
            first = b if via and self.edge_of[via] in joint else via or b
            via = via if first == via else None
            succ.setdefault(a, []).append(first)
            pred.setdefault(first, []).append(a)
            if via:
                turn[via] = {"s": "straight", "l": "left", "L": "left", "r": "right", "R": "right", "t": "uturn"}.get(c.get("dir"), "")
        for edge, e in self.edges.items():
            row = list(e.iter("lane"))
            internal = edge.startswith(":")
            if edge in joint:
                continue
            for k, lane in enumerate(row):
                name, line = lane.get("id"), self.line(lane)
                # Edges of lanes that join outside junctions meet.
                before, behind = (self.joining(name, other.get(name, []), end) for other, end in ((pred, -2), (succ, 1)))
                width = float(lane.get("width", 3.2))
                kind = (kinds.get(edge) or ("vehicle",) * len(row))[k]
                tag = kind if kind in ("tidal", "variable", "waiting_area") else ""
                mark = inner.get(edge, "dashed")
                outer = "none" if internal else "solid"
                if internal and self.node(edge) in guided and turn.get(name) in ("left", "right"):
                    outer = mark = "dashed"
                limit = "" if internal else lane.get("speed")
                yield {
                    "lane_id": name, "centre_xyz_m": cell(line), "left_xyz_m": cell(beside(line, width / 2, before, behind)),
                    "right_xyz_m": cell(beside(line, -width / 2, before, behind)), "width_m": f"{width:.2f}",
                    "left_mark": outer if k == len(row) - 1 else mark, "right_mark": outer if k == 0 else mark,
                    "left_neighbour": row[k + 1].get("id") if k + 1 < len(row) else "", "right_neighbour": row[k - 1].get("id") if k else "",
                    "successors": ";".join(dict.fromkeys(succ.get(name, []))), "predecessors": ";".join(dict.fromkeys(pred.get(name, []))),
                    "kind": "bus" if kind == "bus" else "vehicle", "in_junction": str(internal).lower(),
                    "junction_id": self.node(edge) if internal else "", "speed_limit_mps": limit,
                    "turn": turn.get(name, "") if internal else "", "tags": tag,
                }
