"""Simulated drives for trying the whole pipeline: a three-lane road, car following by the intelligent driver model (Treiber,
Hennecke, Helbing 2000), drivers who change lane into short gaps, brake without visible reason or drive slowly. Writes drives
in the table layout (docs/reference/table-format.md). The same seed gives the same files.

    python fleet.py --drives 200 --seed 1 --out drives
    whyroad ingest table drives --lake lake
    whyroad mine --lake lake --out mined
    whyroad dataset init dataset.yaml
    whyroad dataset build --spec dataset.yaml --labels mined --drafts --lake lake --out release
    whyroad baseline train release --out baseline.json
    whyroad baseline evaluate release --model baseline.json --page baseline.html
"""

import argparse
import csv
import math
import pathlib
import random

STEP = 0.1
LANE = 3.5
LENGTH = {"car": 4.6, "truck": 11.0}
WIDTH = {"car": 1.9, "truck": 2.5}


class Vehicle:
    def __init__(self, rng, name, lane, s):
        self.name, self.lane, self.s = name, lane, s
        self.kind = "truck" if rng.random() < 0.15 and name != "ego" else "car"
        self.wish = rng.gauss(14.0 - 1.5 * (self.kind == "truck"), 2.5 if name != "ego" else 1.0)
        self.wish = max(self.wish, 5.0)
        self.v = self.wish * rng.uniform(0.8, 1.0)
        self.gap_s = rng.uniform(0.8, 1.8)
        self.y, self.vy, self.a = LANE * lane, 0.0, 0.0
        self.patience = rng.uniform(1.0, 4.0)
        self.brake_until, self.blocked = -1.0, 0.0

    @property
    def length(self):
        return LENGTH[self.kind]


def idm(me, lead):
    """Acceleration that keeps the wished speed and gap."""
    free = 1.5 * (1 - (me.v / me.wish) ** 4)
    if lead is None:
        return max(free, -3.0)
    gap = max(lead.s - me.s - (lead.length + me.length) / 2, 0.5)
    wanted = 2.0 + max(0.0, me.v * me.gap_s + me.v * (me.v - lead.v) / (2 * math.sqrt(1.5 * 2.0)))
    return max(free - 1.5 * (wanted / gap) ** 2, -8.0)


def near(vehicles, me, lane):
    """The next vehicle ahead and behind in a lane; who is between two lanes is in both."""
    others = [o for o in vehicles if o is not me and abs(o.y - LANE * lane) < 0.75 * LANE]
    ahead = min((o for o in others if o.s >= me.s), key=lambda o: o.s, default=None)
    behind = max((o for o in others if o.s < me.s), key=lambda o: o.s, default=None)
    return ahead, behind


def step(rng, vehicles, t):
    for me in vehicles:
        lead, _ = near(vehicles, me, me.lane)
        me.a = idm(me, lead)
        if t < me.brake_until:
            me.a = min(me.a, -3.0)
        elif me.name != "ego" and rng.random() < 0.0012:
            me.brake_until = t + rng.uniform(0.8, 3.0)
        me.blocked = me.blocked + STEP if lead and lead.s - me.s < 35 and lead.v < 0.85 * me.wish else 0.0
        settled = abs(me.y - LANE * me.lane) < 0.1
        if me.name != "ego" and settled and me.blocked > me.patience:
            for lane in rng.sample([me.lane - 1, me.lane + 1], 2):
                ahead, behind = near(vehicles, me, lane)
                room = (ahead is None or ahead.s - me.s > 12) and (behind is None or me.s - behind.s > rng.uniform(9, 22))
                if 0 <= lane <= 2 and room:
                    me.lane, me.blocked = lane, 0.0
                    break
    for me in vehicles:
        me.v = max(0.0, me.v + me.a * STEP)
        me.s += me.v * STEP
        wanted = max(-1.3, min(1.3, 1.5 * (LANE * me.lane - me.y)))
        me.vy += max(-0.15, min(0.15, wanted - me.vy))
        me.y += me.vy * STEP * (me.v > 0.3)


def drive(out, seed, number, seconds):
    rng = random.Random(f"{seed}/{number}")
    ego = Vehicle(rng, "ego", 1, 0.0)
    vehicles = [ego]
    for lane in range(3):
        s = rng.uniform(-90, -50)
        while s < 420:
            if not (lane == 1 and abs(s) < 18):
                vehicles.append(Vehicle(rng, f"v{len(vehicles)}", lane, s))
            s += rng.uniform(16, 70)
    for i in range(100):
        step(rng, vehicles, i * STEP - 10)
    # Each drive is on a road of its own, far from the others.
    x0, y0 = 5000.0 * (number % 50), 2000.0 * (number // 50)
    folder = out / f"sim{number:05}"
    folder.mkdir(parents=True, exist_ok=True)
    start = ego.s
    with open(folder / "ego.csv", "w", newline="") as e, open(folder / "objects.csv", "w", newline="") as o:
        rows, objects = csv.writer(e), csv.writer(o)
        rows.writerow("time_s x_m y_m z_m heading_rad speed_mps accel_mps2".split())
        objects.writerow("time_s track_id class x_m y_m heading_rad vx_mps vy_mps length_m width_m height_m".split())
        for i in range(round(seconds / STEP)):
            t = f"{i * STEP:.1f}"
            rows.writerow([t, f"{x0 + ego.s - start:.3f}", f"{y0 + ego.y:.3f}", 0, 0, f"{ego.v:.3f}", f"{ego.a:.3f}"])
            for v in vehicles[1:]:
                if abs(v.s - ego.s) < 90:
                    heading = math.atan2(v.vy, max(v.v, 3.0))
                    place = [f"{x0 + v.s - start:.3f}", f"{y0 + v.y:.3f}", f"{heading:.4f}"]
                    speed = [f"{v.v:.3f}", f"{v.vy:.3f}"]
                    size = [v.length, WIDTH[v.kind], 1.5 if v.kind == "car" else 3.5]
                    objects.writerow([t, v.name, v.kind, *place, *speed, *size])
            step(rng, vehicles, i * STEP)
    with open(folder / "lanes.csv", "w", newline="") as f:
        rows = csv.writer(f)
        rows.writerow("lane_id centre_xyz_m left_mark right_mark left_neighbour right_neighbour speed_limit_mps width_m".split())
        for lane in range(3):
            line = "; ".join(f"{x0 + x:.1f} {y0 + LANE * lane:.2f} 0" for x in range(-150, int(ego.s - start) + 250, 20))
            left, right = (f"l{lane + 1}" if lane < 2 else ""), (f"l{lane - 1}" if lane else "")
            marks = ["dashed" if left else "solid", "dashed" if right else "solid"]
            rows.writerow([f"l{lane}", line, *marks, left, right, 16.7, LANE])
    (folder / "drive.yaml").write_text(
        f"source: simulated\nplace: road{number % 10}\nlicence: Apache-2.0\nstart_time: 2026-01-{1 + number % 28:02}T08:00:00Z\n"
        "ego: {reference_to_centre_m: 0, length_m: 4.6, width_m: 1.9, height_m: 1.5}\n"
    )


def main():
    parser = argparse.ArgumentParser(description="Simulated drives in the table layout.")
    parser.add_argument("--drives", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    a = parser.parse_args()
    for number in range(a.drives):
        drive(a.out, a.seed, number, a.seconds)
    print(f"{a.drives} drives of {a.seconds:.0f} s in {a.out}")


if __name__ == "__main__":
    main()
