"""Many tiny drives, for trying lakes with a large number of them: 3 s on a straight road behind a car, beside another.
Writes drives in the table layout (docs/reference/table-format.md). The same numbers give the same files.

    python tiny.py --first 0 --drives 100000 --out drives
    whyroad ingest table drives --lake lake
    whyroad mine --lake lake --out mined
"""

import argparse
import pathlib
import random

FRAMES = 30
ABOUT = """source: tiny
place: p{place}
licence: Apache-2.0
start_time: 2026-01-01T00:00:00Z
ego: {{reference_to_centre_m: 1.4, length_m: 4.6, width_m: 1.9}}
"""


def write(number, out):
    rng = random.Random(number)
    folder = out / f"d{number:06d}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drive.yaml").write_text(ABOUT.format(place=number % 50))
    speed, accel = rng.uniform(8, 14), rng.uniform(-1, 1)
    times = [i / 10 for i in range(FRAMES)]
    ego = ["time_s,x_m,y_m,heading_rad,speed_mps"]
    ego += [f"{t:.1f},{speed * t + accel * t * t / 2:.3f},0,0,{speed + accel * t:.3f}" for t in times]
    (folder / "ego.csv").write_text("\n".join(ego) + "\n")
    objects = ["time_s,track_id,class,x_m,y_m,heading_rad,length_m,width_m,speed_mps"]
    for name, (x0, y0) in enumerate([(25, 0), (10, 3.5)]):
        objects += [f"{t:.1f},t{name},car,{x0 + speed * t:.3f},{y0},0,4.5,1.8,{speed:.3f}" for t in times]
    (folder / "objects.csv").write_text("\n".join(objects) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=0, help="number of the first drive")
    parser.add_argument("--drives", type=int, default=1000)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("drives"))
    args = parser.parse_args()
    for number in range(args.first, args.first + args.drives):
        write(number, args.out)


if __name__ == "__main__":
    main()
