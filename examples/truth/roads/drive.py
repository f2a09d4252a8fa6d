"""One simulated drive: a network, a driver told what to answer and what not, and the table layout written from the simulator's log.

The driver is SUMO's car with its safe gaps; the script says how fast it may go where, and what lights show when (`scenes`). For each
step the log keeps which order the car brakes for.
"""

import csv
import math
import os
import sys
import tempfile
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import sumo

from network import Net, cell

sys.path.insert(0, os.path.join(sumo.SUMO_HOME, "tools"))
import traci  # noqa: E402  (comes with SUMO)

STEP_S = 0.1
CAR = (4.8, 1.9, 1.5)
TYPES = f"""<vType id="ego" length="{CAR[0]}" width="{CAR[1]}" height="{CAR[2]}" accel="1.8" decel="4.5" speedFactor="3" speedDev="0" sigma="0" maxSpeed="40" tau="1.2"/>
<vType id="car" length="4.5" width="1.8" height="1.5" accel="1.8" decel="4.0" speedFactor="0.95" speedDev="0" sigma="0.2" tau="1.4"/>
<vType id="truck" vClass="truck" length="10" width="2.5" height="3.4" accel="1.1" decel="3.5" speedFactor="0.85" speedDev="0" sigma="0.2" tau="1.6"/>"""


@dataclass
class Order:
    """Between two stations at most `v`, or a halt of `wait` s at the first; slowing with `decel` on the way to it."""
    name: str
    s0: float
    s1: float
    v: float
    decel: float = 1.6
    wait: float = None
    stood: float = 0.0


@dataclass
class Drive:
    name: str
    folder: Path = None                            # with the network
    route: list = None                             # edges
    demand: str = ""                               # other traffic
    v0: float = 13.0
    lane: int = 0
    duration: float = 200.0
    orders: list = field(default_factory=list)
    changes: list = field(default_factory=list)    # (station, lane index, s of indicating before it)
    contexts: list = field(default_factory=list)   # (kind, value outside, [(s0, s1, value)])
    timed: list = field(default_factory=list)      # (time s, kind, value)
    gates: list = field(default_factory=list)      # (order name, station): opens after the halt, or while rolling up
    features: list = field(default_factory=list)   # what truth.py reads
    areas: list = field(default_factory=list)      # (kind, outline)
    signs: list = field(default_factory=list)      # (kind, x, y, value)
    objects: list = field(default_factory=list)    # (class, x, y, heading, length, width, height)
    kinds: dict = None
    inner: dict = None
    guided: tuple = ()                             # junctions with guidance lines
    undrawn: tuple = ()                            # edges that the map does not have: there are no lanes
    rails: bool = False                            # the car's middle keeps to the lanes' middles; SUMO lets its front do so
    route_command: object = None                   # function of station, or None: no route is logged
    until: float = None                            # the drive ends at this station
    signal: object = None                          # the indicator is set by the script
    lit: bool = False                              # lights are part of the network
    scenes: list = field(default_factory=list)     # generators: told (t, s, v) each step, they give orders and set lights
    mode: int = 31                                 # what SUMO's driver minds by himself (its speed mode)

    def run(self, out):
        with tempfile.TemporaryDirectory() as t:
            work = Path(t)
            self.simulate(work)
            self.write(work, out / self.name)

    def simulate(self, work):
        route = " ".join(self.route)
        (work / "r.rou.xml").write_text(f'<routes>{TYPES}<route id="way" edges="{route}"/>'
                                        f'<vehicle id="ego" type="ego" route="way" depart="0" departSpeed="{self.v0}" departPos="5" departLane="{self.lane}"/>'
                                        f"{self.demand}</routes>")
        traci.start([os.path.join(sumo.SUMO_HOME, "bin", "sumo"), "--net-file", str(self.folder / "net.xml"), "--route-files", str(work / "r.rou.xml"),
                     "--step-length", str(STEP_S), "--seed", "20260105", "--lanechange.duration", "3", "--fcd-output", str(work / "fcd.xml"),
                     "--fcd-output.attributes", "id,x,y,z,angle,type,speed,acceleration,lane,pos,signals,odometer", "--time-to-teleport", "-1",
                     "--collision-output", str(work / "collisions.xml"), "--collision.action", "warn", "--no-step-log", "--no-warnings",
                     "--duration-log.disable", "--device.fcd.explicit", "ego", "--device.fcd.radius", "90"])
        self.log, self.programme, changes, gates = [], [], list(self.changes), dict(self.gates)
        self.states = [(0.0, k, v) for k, v, _ in self.contexts] + list(self.timed)
        shown = {k: v for k, v, _ in self.contexts}
        if gates:
            self.states.append((0.0, "gate", "closed"))
        opens, passed = {}, []
        try:
            for step in range(int(self.duration / STEP_S)):
                t = round(step * STEP_S, 1)
                traci.simulationStep()
                if "ego" not in traci.vehicle.getIDList():
                    if t > 2:
                        break
                    continue
                if step == 0:
                    traci.vehicle.setLaneChangeMode("ego", 0)
                    traci.vehicle.setSpeedMode("ego", self.mode)
                    for scene in self.scenes:
                        next(scene)
                v, s = traci.vehicle.getSpeed("ego"), traci.vehicle.getDistance("ego") + 5.0
                if self.until and s > self.until:
                    break
                self.scenes = [x for x in self.scenes if not x.send((t, s, v))]
                want, why, over = self.v0, "", False
                for o in self.orders:
                    if o.wait is not None:
                        if o.stood < 0 or s > o.s0 + 1:
                            continue
                        if v < 0.05 and o.s0 - s < 4:
                            o.stood += STEP_S
                            over = over or (o.wait >= 1e9 and o.stood > 8 and not self.scenes)
                            if o.stood > o.wait:
                                o.stood = -1
                            may = 0.0
                        else:
                            may = math.sqrt(max(0.0, 2 * o.decel * (o.s0 - 0.8 - s)))
                            may = max(may, 0.4) if s < o.s0 - 1.0 else 0.0
                    elif s > o.s1:
                        continue
                    else:
                        may = o.v if s >= o.s0 else math.sqrt(o.v**2 + 2 * o.decel * (o.s0 - s))
                    if may < want:
                        want, why = may, o.name
                if over:
                    break  # it has arrived
                nextv = max(v - 3.0 * STEP_S, min(v + 1.3 * STEP_S, want))
                traci.vehicle.setSpeed("ego", nextv)
                braking = why if nextv < v - 1e-3 else ""
                if changes and s >= changes[0][0]:
                    traci.vehicle.changeLane("ego", changes[0][1], 60)
                    changes.pop(0)
                for name, at in list(gates.items()):
                    order = next(o for o in self.orders if o.name == name)
                    if (order.wait is not None and order.stood > order.wait - 2.0) or (order.wait is None and at - s < 22):
                        self.states += [(t, "gate", "opening"), (round(t + 2.0, 1), "gate", "open")]
                        opens[name] = t
                        passed.append(at + 15)
                        del gates[name]
                if passed and s > passed[0]:
                    passed.pop(0)
                    self.states.append((t, "gate", "closed"))
                for kind, base, stretches in self.contexts:
                    value = next((w for a, b, w in stretches if a <= s <= b), base)
                    if shown[kind] != value:
                        shown[kind] = value
                        self.states.append((t, kind, value))
                self.log.append((t, round(s, 2), round(v, 2), traci.vehicle.getLaneID("ego"), braking))
                if self.lit:
                    for i in traci.trafficlight.getIDList():
                        state = traci.trafficlight.getRedYellowGreenState(i)
                        if not any(p[1] == i for p in self.programme[-8:]) or next(p[2] for p in reversed(self.programme) if p[1] == i) != state:
                            self.programme.append((t, i, state))
        finally:
            traci.close()
        self.opens = opens
        if "<collision " in (work / "collisions.xml").read_text():
            print(f"{self.name}: a collision", file=sys.stderr)

    def write(self, work, to):
        to.mkdir(parents=True, exist_ok=True)
        ego, others, types = [], [], {"ego": CAR, "car": (4.5, 1.8, 1.5), "truck": (10.0, 2.5, 3.4)}
        known = {row[0]: row for row in self.log}
        for step in xml.parse(work / "fcd.xml").getroot():
            t = round(float(step.get("time")), 1)
            for o in step:
                x, y, z, v = (float(o.get(k, 0)) for k in ("x", "y", "z", "speed"))
                heading = (math.pi / 2 - math.radians(float(o.get("angle"))) + math.pi) % (2 * math.pi) - math.pi
                if o.get("id") == "ego":
                    if t not in known:
                        continue
                    signals = int(o.get("signals") or 0)
                    ego.append((t, x, y, z, heading, v, "right" if signals & 1 else "left" if signals & 2 else "off",
                                self.route_command(known[t][1]) if self.route_command else None))
                elif t in known:
                    l, w, h = types[o.get("type")]
                    others.append((t, o.get("id"), o.get("type"), x - l / 2 * math.cos(heading), y - l / 2 * math.sin(heading), z, heading, v, l, w, h))
        if self.signal:
            ego = self.indicated(ego)
        if self.rails:
            ego = self.railed(ego, known)
        place = {row[0]: (row[1], row[2]) for row in ego}
        for i, (kind, x, y, heading, l, w, h) in enumerate(self.objects):
            others += [(t, f"thing{i}", kind, x, y, 0.0, heading, 0.0, l, w, h) for t, (ex, ey) in place.items() if math.hypot(ex - x, ey - y) < 90]
        names = "time_s x_m y_m z_m heading_rad speed_mps turn_signal route_command".split()
        store(to / "ego.parquet", names if self.route_command else names[:-1], ego)
        columns = "time_s track_id class x_m y_m z_m heading_rad speed_mps length_m width_m height_m".split()
        if others:
            others.sort(key=lambda r: (r[0], r[1]))
            store(to / "objects.parquet", columns, others)
        else:
            # An empty table says that there is nobody; without one that would be unknown.
            table(to / "objects.csv", columns, [])
        net = Net(self.folder)
        rows = list(net.rows(self.kinds, self.inner, self.guided))
        gone = {r["lane_id"] for r in rows if r["lane_id"].rsplit("_", 1)[0] in self.undrawn}
        rows = [r for r in rows if r["lane_id"] not in gone]
        for r in rows:
            for k in ("successors", "predecessors"):
                r[k] = ";".join(l for l in r[k].split(";") if l not in gone)
        kept = [k for k in rows[0] if any(r[k] for r in rows)]
        table(to / "lanes.csv", kept, [tuple(r[k] for k in kept) for r in rows])
        areas = [(f"{k}{i}", k, cell(b), "") for i, (k, b) in enumerate(self.areas)]
        areas += [(c.get("id"), "crosswalk", cell(crossing_outline(net, c)), "") for c in net.crossings]
        areas += [(f"j_{j}", "junction", cell([(*map(float, p.split(",")[:2]), 0.0) for p in net.junctions[j].get("shape").split()]), "") for j in sorted(net.real)]
        table(to / "areas.csv", ["area_id", "kind", "boundary_xyz_m", "lane_ids"], areas)
        table(to / "signs.csv", ["sign_id", "kind", "x_m", "y_m", "value"], [(f"sign{i}", k, f"{x:.2f}", f"{y:.2f}", v) for i, (k, x, y, v) in enumerate(self.signs)])
        if self.states:
            table(to / "context.csv", ["time_s", "kind", "value", "source"], [(t, k, v, "log") for t, k, v in sorted(self.states)])
        self.write_lights(net, to)
        (to / "drive.yaml").write_text(
            f"drive_id: {self.name}\nsource: simulation\nlicence: CC0-1.0\nstart_time: 2026-01-01T00:00:00.000Z\n"
            f"ego: {{ length_m: {CAR[0]}, width_m: {CAR[1]}, height_m: {CAR[2]}, reference_to_centre_m: {-CAR[0] / 2} }}\n"
            "map_complete_for: [speed_bump, toll_etc, toll_manual, toll_plaza, gate, tunnel, roundabout, construction, building, barrier_gap, waiting_area, accident, bridge, "
            "parking, driveway, stop, yield, speed_limit, lane_arrow, prohibition, warning, ramp, acceleration, deceleration, tidal, variable, unpaved]\n")

    def indicated(self, ego):
        """The indicator as the script sets it: from some time before the car leaves its lane until it is in the other."""
        out = list(ego)
        lanes = [r[3] for r in self.log]
        times = [r[0] for r in self.log]
        for at, index, lead in self.changes:
            k = next(i for i, r in enumerate(self.log) if r[1] >= at)
            side = "left" if index > int(lanes[k].rsplit("_", 1)[1]) else "right"
            for i, row in enumerate(out):
                if times[k] - lead <= row[0] <= times[k] + 2.5:
                    out[i] = (*row[:6], side, row[7])
        return out

    def railed(self, ego, known):
        """The log with the car's middle on the middle of the lanes that it took, as far along as SUMO says."""
        net, line = Net(self.folder), []
        for lane in dict.fromkeys(r[3] for r in self.log):
            line += [p for p in net.line(net.lanes[lane]) if not line or math.dist(p, line[-1]) > 0.01]
        at = [0.0]
        for a, b in zip(line, line[1:]):
            at.append(at[-1] + math.dist(a[:2], b[:2]))
        out = []
        for row in ego:
            s = known[row[0]][1] - CAR[0] / 2
            k = max(0, min(len(at) - 2, next((i for i, v in enumerate(at) if v > s), len(at)) - 1))
            (ax, ay, _), (bx, by, _) = line[k], line[k + 1]
            share, heading = (s - at[k]) / (at[k + 1] - at[k]), math.atan2(by - ay, bx - ax)
            x, y = ax + share * (bx - ax), ay + share * (by - ay)
            out.append((row[0], x + CAR[0] / 2 * math.cos(heading), y + CAR[0] / 2 * math.sin(heading), row[3], heading, *row[5:]))
        return out

    def write_lights(self, net, to):
        rows = []
        if self.lit:
            colours = {"r": "red", "y": "yellow", "G": "green", "g": "green_yield", "o": "flashing_yellow", "O": "off", "u": "red_yellow"}
            links = [(c.get("tl"), int(c.get("linkIndex")), f"{c.get('from')}_{c.get('fromLane')}", c.get("via") or f"{c.get('to')}_{c.get('toLane')}") for c in net.links if c.get("tl")]
            last = {}
            for t, tls, state in self.programme:
                for i, n, lane, onward in links:
                    if i == tls and last.get((lane, onward)) != state[n]:
                        last[lane, onward] = state[n]
                        rows.append((t, lane, onward, colours[state[n]]))
        table(to / "lights.csv", ["time_s", "lane_id", "to_lane_id", "colour"], rows)


def crossing_outline(net, lane):
    from network import beside
    line, half = net.line(lane), float(lane.get("width", 4)) / 2
    return beside(line, half) + list(reversed(beside(line, -half)))


# Digits behind the point of a column. Numbers are written as decimals in steps (delta-encoded), which is a tenth of the bytes of floats.
DIGITS = {"time_s": 1, "x_m": 2, "y_m": 2, "z_m": 2, "heading_rad": 4, "speed_mps": 2, "length_m": 2, "width_m": 2, "height_m": 2}


def store(path, names, rows):
    columns = {n: c for n, c in zip(names, zip(*rows))}
    arrays = [pa.array([Decimal(f"{v:.{DIGITS[n]}f}") for v in c], pa.decimal128(9, DIGITS[n])) if n in DIGITS else pa.array(c, pa.string())
              for n, c in columns.items()]
    numbers = [n for n in names if n in DIGITS]
    pq.write_table(pa.table(arrays, names=names), path, compression="snappy", store_decimal_as_integer=True, write_statistics=False,
                   use_dictionary=[n for n in names if n not in DIGITS], column_encoding={n: "DELTA_BINARY_PACKED" for n in numbers})


def table(path, header, rows):
    with open(path, "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(header)
        w.writerows(rows)
