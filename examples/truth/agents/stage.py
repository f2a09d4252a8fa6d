"""A stretch of road on which everybody moves by script, the ego included: what SUMO cannot be made to do (people who step out,
cars that reverse, weave or come the wrong way, swerves within the lane). Places are (s, d): meters along the road's center line and
to the left of it. The log is SUMO's FCD format; the network is netconvert's. Nothing here knows Whyroad.
"""

import gzip
import math
import os
import subprocess
from dataclasses import dataclass, field

import sumo

DT = 0.1
# Who is farther from the ego than this is not in the log, m.
RANGE_M = 85

# type: (vClass, length, width, height, class that SUMO has no word for)
TYPES = {
    "ego_car": ("passenger", 4.8, 1.9, 1.5, None), "car": ("passenger", 4.5, 1.8, 1.5, None), "van": ("passenger", 5.4, 2.0, 2.3, None),
    "lorry": ("truck", 9.0, 2.5, 3.4, None), "coach": ("bus", 12.0, 2.5, 3.2, None), "bike": ("bicycle", 1.8, 0.65, 1.7, None),
    "walker": ("pedestrian", 0.5, 0.6, 1.75, None), "dog": ("pedestrian", 0.9, 0.35, 0.6, "animal"), "cow": ("pedestrian", 2.2, 0.8, 1.4, "animal"),
    "crate": ("container", 1.0, 1.0, 0.8, None), "skip": ("container", 3.4, 1.8, 1.5, None), "bag": ("container", 0.5, 0.5, 0.3, None),
}
ON_FOOT = {"walker", "dog", "cow"}


class Road:
    """A two-way road. `bends`: (from s, to s, curvature 1/m)."""

    def __init__(self, length, lanes, width, bends, start=(0.0, 0.0, 0.0)):
        self.length, self.lanes, self.width, self.bends = length, lanes, width, bends
        self.crosswalks = []  # s of their middle lines
        x, y, h = start
        self.points = []
        for s in range(int(length) + 1):
            self.points.append((x, y, h))
            k = next((k for a, b, k in bends if a <= s < b), 0.0)
            x, y, h = x + math.cos(h + k / 2), y + math.sin(h + k / 2), h + k

    def at(self, s, d=0.0):
        i = min(max(int(s), 0), len(self.points) - 2)
        (x0, y0, h0), (x1, y1, h1) = self.points[i], self.points[i + 1]
        f = s - i
        h = h0 + (h1 - h0) * f
        return x0 + (x1 - x0) * f - d * math.sin(h), y0 + (y1 - y0) * f + d * math.cos(h), h

    def project(self, x, y, guess=None):
        """(s, d, the road's heading there) of a place; `guess` is an s near it."""
        low, high = (0, len(self.points) - 1) if guess is None else (int(guess) - 30, int(guess) + 31)
        near = range(max(low, 0), min(high, len(self.points) - 1) + 1)
        i = min(near, key=lambda i: (self.points[i][0] - x)**2 + (self.points[i][1] - y)**2)
        px, py, h = self.points[i]
        s = i + (x - px) * math.cos(h) + (y - py) * math.sin(h)
        px, py, h = self.at(s)
        return s, (y - py) * math.cos(h) - (x - px) * math.sin(h), h

    def lane(self, k):
        """Middle of the ego's direction's lane k, counted from the right."""
        return -(self.lanes - 1 - k + 0.5) * self.width

    @property
    def edge(self):
        return -self.lanes * self.width

    def write(self, folder, speed):
        line = [self.at(s)[:2] for s in range(0, int(self.length) + 1, 10)]
        shape = lambda pts: " ".join(f"{x:.2f},{y:.2f}" for x, y in pts)
        (ax, ay), (bx, by) = line[0], line[-1]
        (folder / "n.nod.xml").write_text(f'<nodes><node id="a" x="{ax:.2f}" y="{ay:.2f}"/><node id="b" x="{bx:.2f}" y="{by:.2f}"/></nodes>')
        edge = '<edge id="{}" from="{}" to="{}" numLanes="{}" speed="{}" width="{}" shape="{}"/>'
        (folder / "e.edg.xml").write_text("<edges>" + edge.format("out", "a", "b", self.lanes, speed, self.width, shape(line))
                                          + edge.format("back", "b", "a", self.lanes, speed, self.width, shape(line[::-1])) + "</edges>")
        subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", "netconvert"), "-n", folder / "n.nod.xml", "-e", folder / "e.edg.xml", "-o",
                        folder / "net.xml", "--offset.disable-normalization", "--no-turnarounds"], check=True, stdout=subprocess.DEVNULL)

    def marks(self):
        """Crosswalks in the network's words: netconvert makes them only at nodes with pavements."""
        for k, s in enumerate(self.crosswalks):
            ends = " ".join(f"{x:.2f},{y:.2f}" for x, y, _ in (self.at(s, self.edge), self.at(s, -self.edge)))
            yield (f'    <edge id=":zebra{k}_c0" function="crossing" crossingEdges="out back">\n        <lane id=":zebra{k}_c0_0" index="0" '
                   f'allow="pedestrian" speed="1.00" length="{-2 * self.edge:.2f}" width="4.00" shape="{ends}"/>\n    </edge>\n')


class Motorway(Road):
    """One way, two lanes, and a third on the right where a ramp joins: `ramps` are the places at which its lane begins, `ACCELERATION_M`
    long. Lane 0 is that lane, as if it were there all along; the ramp leads to it from `ASIDE_M` further right over `RAMP_M`."""

    ACCELERATION_M, RAMP_M, ASIDE_M = 180, 150, 10

    def __init__(self, length, width, bends):
        super().__init__(length, 3, width, bends)
        self.ramps = []

    def write(self, folder, speed):
        cuts = sorted({0, self.length, *self.ramps, *(s + self.ACCELERATION_M for s in self.ramps)})
        shape = lambda pts: " ".join(f"{x:.2f},{y:.2f}" for x, y in pts)
        line = lambda a, b, d=0.0: [self.at(s, d)[:2] for s in [*range(int(a), int(b), 10), b]]
        nodes, edges, links = [], [], []
        for k, s in enumerate(cuts):
            x, y, _ = self.at(s)
            nodes.append(f'<node id="n{k}" x="{x:.2f}" y="{y:.2f}"/>')
        for k, (a, b) in enumerate(zip(cuts, cuts[1:])):
            wide = a in self.ramps
            edges.append(f'<edge id="m{k}" from="n{k}" to="n{k + 1}" numLanes="{3 if wide else 2}" speed="{speed}" width="{self.width}" '
                         f'shape="{shape(line(a, b))}"/>')
            if k + 2 < len(cuts):
                # Lanes are counted from the right: the lane of the ramp ends.
                here, there = (1, 0) if wide else (0, 1) if b in self.ramps else (0, 0)
                links += [f'<connection from="m{k}" to="m{k + 1}" fromLane="{here + i}" toLane="{there + i}"/>' for i in (0, 1)]
            if wide:
                d = self.edge + self.width
                start = self.at(a - self.RAMP_M, d - self.ASIDE_M)
                nodes.append(f'<node id="r{k}" x="{start[0]:.2f}" y="{start[1]:.2f}"/>')
                ramp = [self.at(a - self.RAMP_M * (1 - f), d - self.ASIDE_M * (1 - f))[:2] for f in (0.0, 0.25, 0.5, 0.75, 1.0)]
                edges.append(f'<edge id="r{k}" type="ramp_link" from="r{k}" to="n{k}" numLanes="1" speed="{speed}" width="{self.width}" shape="{shape(ramp)}"/>')
                links.append(f'<connection from="r{k}" to="m{k}" fromLane="0" toLane="0"/>')
        (folder / "n.nod.xml").write_text("<nodes>" + "".join(nodes) + "</nodes>")
        (folder / "e.edg.xml").write_text("<edges>" + "".join(edges) + "</edges>")
        (folder / "c.con.xml").write_text("<connections>" + "".join(links) + "</connections>")
        subprocess.run([os.path.join(sumo.SUMO_HOME, "bin", "netconvert"), "-n", folder / "n.nod.xml", "-e", folder / "e.edg.xml", "-x",
                        folder / "c.con.xml", "-o", folder / "net.xml", "--offset.disable-normalization", "--no-turnarounds"], check=True,
                       stdout=subprocess.DEVNULL)


@dataclass
class Actor:
    id: str
    type: str
    s: float
    d: float
    v: float = 0.0      # along its own heading, m/s; negative: backwards
    psi: float = 0.0    # heading against the road's, rad
    signals: int = 0
    move: object = None # called every step with (actor, world)
    solid: bool = True  # whether the ego minds it
    there: bool = True
    a: float = 0.0
    born: float = 0.0
    memory: dict = field(default_factory=dict)

    @property
    def size(self):
        return TYPES[self.type][1], TYPES[self.type][2]


def smooth(f):
    """From 0 to 1 without a jerk at the ends."""
    f = min(max(f, 0.0), 1.0)
    return f**3 * (10 - 15 * f + 6 * f * f)


class Slide:
    """Sideways from one d to another within `over` seconds."""

    def __init__(self, t, d0, d1, over):
        self.t, self.d0, self.d1, self.over = t, d0, d1, over

    def at(self, t):
        return self.d0 + (self.d1 - self.d0) * smooth((t - self.t) / self.over)

    def done(self, t):
        return t >= self.t + self.over


def approach(actor, want, dt=DT, accel=1.6, brake=2.5):
    """Towards a speed, no faster than these accelerations."""
    change = min(max(want - actor.v, -brake * dt), accel * dt)
    actor.a, actor.v = change / dt, actor.v + change


class World:
    def __init__(self, road, cruise, draw):
        self.road, self.draw, self.t = road, draw, 0.0
        self.ego = Actor("ego", "ego_car", 30.0, road.lane(0), cruise)
        self.cruise = self.wish = cruise
        self.slide, self.swing = None, None
        self.forced = None         # acceleration that the script demands of the ego
        self.blind = set()         # ids that the ego pays no heed to
        self.patience = 0.7        # s until the ego reacts to what has come into its way
        self.known = {}
        self.aeb = False           # the emergency brake of the ego acts
        self.lag = 3.0             # jerk of the ego's braking, m/s3
        self.actors, self.events, self.rows, self.buildings = [], [], [], []
        self.works = []            # (from s, to s, from d, to d)
        self.count = 0

    def add(self, type_, s, d, v=0.0, **more):
        self.count += 1
        a = Actor(f"{type_}{self.count}", type_, s, d, v, born=self.t, **more)
        self.actors.append(a)
        return a

    def note(self, what, actor=None, **more):
        self.events.append({"t": round(self.t, 1), "what": what, **({"id": actor.id} if actor else {}), **more})

    def shift(self, d, over):
        self.slide = Slide(self.t, self.ego.d, d, over)

    def ahead(self, actor):
        """Bumper to bumper, m."""
        return actor.s - self.ego.s - (actor.size[0] * abs(math.cos(actor.psi)) + actor.size[1] * abs(math.sin(actor.psi)) + self.ego.size[0]) / 2

    def hindrance(self):
        """Acceleration that who is in the way, or soon will be, leaves to the ego (Intelligent Driver Model)."""
        ego, least = self.ego, math.inf
        for a in self.actors:
            gap = self.ahead(a)
            if not a.there or not a.solid or a.id in self.blind or a.s < ego.s or gap > 90:
                continue
            side = a.v * math.sin(a.psi)
            half = (a.size[1] * abs(math.cos(a.psi)) + a.size[0] * abs(math.sin(a.psi)) + ego.size[1]) / 2 + 0.35
            to = self.slide.d1 if self.slide else ego.d
            # In its way now, or within the time that it takes to get there.
            horizon = min(4.0, gap / max(ego.v, 2.0) + 1.0)
            low, high = sorted((a.d, a.d + side * horizon))
            if low > to + half or high < to - half or (abs(a.d - to) > half and side * (to - a.d) <= 0):
                self.known.pop(a.id, None)
                continue
            if self.t - self.known.setdefault(a.id, self.t) < self.patience:
                continue
            along = a.v * math.cos(a.psi)
            closing = ego.v - along
            wanted = 2.5 + max(0.0, ego.v * 1.3 + ego.v * closing / (2 * math.sqrt(1.6 * 2.4)))
            least = min(least, 1.6 * (1 - (ego.v / max(self.wish, 0.1))**4 - (wanted / max(gap, 0.3))**2))
            if gap < 2.0:
                least = min(least, -ego.v / 0.6)
        return least

    def drive(self):
        ego = self.ego
        free = 1.6 * (1 - (ego.v / self.wish)**4) if self.wish > 0.1 else -2.0
        want = self.forced if self.forced is not None else max(-7.5, min(free, self.hindrance(), 1.6))
        if self.forced is None:
            want = max(want, -2.0) if want == free else want
        ego.a += min(max(want - ego.a, -self.lag * 3 * DT), self.lag * DT * 3)
        if ego.v + ego.a * DT <= 0.02 and ego.a <= 0:
            ego.a, ego.v = 0.0, 0.0
        ego.v = max(0.0, ego.v + ego.a * DT)
        ego.s += ego.v * DT
        before = ego.d
        if self.slide:
            ego.d = self.slide.at(self.t)
            if self.slide.done(self.t):
                self.slide = None
        ego.psi = math.atan2(ego.d - before, ego.v * DT) if ego.v > 0.2 else ego.psi * 0.5

    def step(self):
        for a in self.actors:
            if a.there:
                v = a.v
                if a.move:
                    a.move(a, self)
                a.a = (a.v - v) / DT
        self.drive()
        self.t = round(self.t + DT, 1)
        self.rows.append((self.t, [self.row(a) for a in [self.ego, *(a for a in self.actors if a.there)] if abs(a.s - self.ego.s) < RANGE_M]))

    def row(self, a):
        x, y, h = self.road.at(a.s, a.d)
        h += a.psi
        if a.type not in ON_FOOT:
            # FCD has the middle of the front bumper.
            x, y = x + a.size[0] / 2 * math.cos(h), y + a.size[0] / 2 * math.sin(h)
        angle = (90 - math.degrees(h)) % 360
        brake = f' whyroad.aeb="{int(self.aeb)}"' if a is self.ego else ""
        tag = "person" if a.type in ON_FOOT else "vehicle"
        # A container is freight to SUMO; one that lies on the road is a vehicle of that class.
        return f'<{tag} id="{a.id}" x="{x:.2f}" y="{y:.2f}" angle="{angle:.2f}" type="{a.type}" speed="{a.v:.2f}" acceleration="{a.a:.2f}" signals="{a.signals}"{brake}/>'

    def write(self, folder):
        steps = (f'<timestep time="{t:.2f}">' + "".join(rows) + "</timestep>\n" for t, rows in self.rows)
        pack(folder / "fcd.xml.gz", "<fcd-export>\n" + "".join(steps) + "</fcd-export>\n")
        areas = [("building", *b) for b in self.buildings] + [("construction", *b) for b in self.works]
        if areas:
            polys = []
            for i, (kind, s0, s1, d0, d1) in enumerate(areas):
                corners = [self.road.at(s, d)[:2] for s, d in ((s0, d0), (s1, d0), (s1, d1), (s0, d1))]
                polys.append(f'<poly id="{kind}{i}" type="{kind}" shape="{" ".join(f"{x:.2f},{y:.2f}" for x, y in corners)}"/>')
            (folder / "areas.poly.xml").write_text("<additional>\n" + "\n".join(polys) + "\n</additional>\n")


def pack(target, text):
    with open(target, "wb") as raw, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0, compresslevel=9) as packed:
        packed.write(text.encode())


def types_file():
    out = ["<routes>"]
    for name, (vclass, length, width, height, other) in TYPES.items():
        param = f'<param key="whyroad.class" value="{other}"/>' if other else ""
        out.append(f'  <vType id="{name}" vClass="{vclass}" length="{length}" width="{width}" height="{height}">{param}</vType>')
    return "\n".join([*out, "</routes>", ""])
