#!/usr/bin/env python3
"""Makes the drives with known truth for the road and the rules again: `python3 make.py [seen|unseen] [OUT_DIR]`.

Needs SUMO 1.28.0 and pyarrow (`pip install eclipse-sumo==1.28.0 pyarrow`). Both sets come from the same scripts with another seed
and on roads of another speed limit: other layouts, sizes, speeds and orders. Beside a set's drives stands its `truth.jsonl`. Two runs give equal bytes.
"""

import json
import random
import sys
import tempfile
from pathlib import Path

import along
import lanes
import lights
import shapes
import signs
import truth
import yards

SEEDS = {"seen": 11, "unseen": 47}
# Speed limit of ordinary road and the speeds that drivers keep on it, m/s.
WORLDS = {"seen": (13.89, (12.8, 13.6)), "unseen": (16.67, (15.2, 16.4))}


def drawer(name, of):
    draw = random.Random(f"{SEEDS[name]}-{of}")
    draw.limit, draw.speeds = WORLDS[name]
    return draw


def main():
    sets = [a for a in sys.argv[1:] if a in SEEDS] or list(SEEDS)
    root = Path(next((a for a in sys.argv[1:] if a not in SEEDS), Path(__file__).resolve().parent))
    for name in sets:
        found, drives = [], []
        for family in (along, lights, signs, lanes, shapes, yards):
            for drive, *plan in family.drives(drawer(name, family.__name__)):
                with tempfile.TemporaryDirectory() as folder:
                    made = family.build(drive, *plan, drawer(name, drive), Path(folder))
                    made.name = f"{name}-{drive}"
                    made.run(root / name)
                drives.append(made.name)
                found += truth.entries(made)
        complete = sorted({e["scenario_id"] for e in found} - set(truth.NOT_ALL))
        lines = [{"complete": complete, "drives": drives}, *found]
        (root / name / "truth.jsonl").write_text("".join(json.dumps(x) + "\n" for x in lines))
        print(name, len(drives), "drives,", len(found), "entries of", len({e["scenario_id"] for e in found}), "leaves")


if __name__ == "__main__":
    main()
