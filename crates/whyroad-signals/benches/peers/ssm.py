"""Seconds of CPU time that SUMO's SSM device adds per equipped vehicle and step: the grid of examples/truth/make.py, with
TTC, DRAC and PET within 80 m for every vehicle, against the same run without the device (least of five runs each). Prints
it and the mean number of vehicles on the road."""

import random
import re
import resource
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve()
TRUTH = HERE.parents[4] / "examples" / "truth"
sys.path.insert(0, str(TRUTH))
import make  # noqa: E402


def cpu_seconds():
    use = resource.getrusage(resource.RUSAGE_CHILDREN)
    return use.ru_utime + use.ru_stime


def main():
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        make.grid_network(work / "net.xml")
        trips = "\n".join(make.grid_demand(random.Random(make.SEED)))
        (work / "trips.xml").write_text(f"<routes>\n{trips}\n</routes>\n")

        def run(*more):
            before = cpu_seconds()
            make.tool("sumo", "--net-file", work / "net.xml", "--route-files", f"{TRUTH / 'types.rou.xml'},{work / 'trips.xml'}",
                      "--step-length", 0.1, "--end", make.DURATION_S["grid"], "--seed", make.SEED, "--lanechange.duration", 3,
                      "--time-to-teleport", -1, "--collision.action", "warn", "--no-step-log", "--duration-log.disable", *more)
            return cpu_seconds() - before

        device = ("--device.ssm.probability", 1, "--device.ssm.file", work / "ssm.xml", "--device.ssm.measures", "TTC DRAC PET",
                  "--device.ssm.thresholds", make.SSM_THRESHOLDS, "--device.ssm.range", 80, "--device.ssm.extratime", 5)
        run("--summary-output", work / "summary.xml")
        running = [int(n) for n in re.findall(r'running="(\d+)"', (work / "summary.xml").read_text())]
        # In alternation: what else the machine does meets both.
        times = [(run(), run(*device)) for _ in range(5)]
        without, with_device = (min(t) for t in zip(*times))
        print((with_device - without) / sum(running), sum(running) / len(running))


if __name__ == "__main__":
    main()
