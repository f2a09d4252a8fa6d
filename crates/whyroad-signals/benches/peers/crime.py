"""Seconds that commonroad-crime needs for six measures (HW, THW, TTC, DST, ALongReq, BTN) of the scene of
examples/truth/crime/make.py, per vehicle and step: the sum of the least times of each measure in three rounds. A measure
is made once and asked for all vehicles and steps; reading and building the scene are not counted."""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[4] / "examples" / "truth" / "crime"))
from commonroad_crime.measure import BTN, DST, HW, THW, TTC, ALongReq  # noqa: E402
from make import configuration  # noqa: E402

OTHERS = (200, 300, 400, 500)
STEPS = range(0, 30, 3)


def seconds(kind):
    def once():
        measure = kind(configuration())
        start = time.process_time()
        for other in OTHERS:
            for step in STEPS:
                measure.compute(other, step, verbose=False)
        return time.process_time() - start

    return min(once() for _ in range(3))


if __name__ == "__main__":
    print(sum(map(seconds, (HW, THW, TTC, DST, ALongReq, BTN))) / (len(OTHERS) * len(STEPS)))
