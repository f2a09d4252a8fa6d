#!/usr/bin/env python3
"""Writes `truth.jsonl` beside each drive: what happens in it, from the script's orders and everybody's motion alone.

`python3 truth.py [DIR...]` (default: `seen` and `unseen` beside this file). Nothing here comes from Whyroad's signals or rules. The
first line names the classes for which the list is complete.
"""

import json
import sys
from collections import Counter
from pathlib import Path

import leaves
import leaves_crossing
import leaves_ego
import leaves_vehicles
from leaves_crossing import CrossingLog
from log import Log

HERE = Path(__file__).resolve().parent
START_NS = 1_767_225_600 * 10**9  # 2026-01-01T00:00:00Z, where `ingest sumo` puts zero
PARTS = [
    leaves.cutins, leaves.crossings, leaves.emergences, leaves.invasions, leaves.animals_on_road,
    leaves_vehicles.hard_braking, leaves_vehicles.reversing, leaves_vehicles.cutouts, leaves_vehicles.abnormal, leaves_vehicles.steady,
    leaves_vehicles.creeping, leaves_vehicles.queues, leaves_vehicles.meetings,
    leaves_ego.avoidances, leaves_ego.steering, leaves_ego.emergency_braking, leaves_ego.near_misses, leaves_ego.lane_changes, leaves_ego.pulls_over,
]
COMPLETE = [
    *(f"reactive_agent.cutin.{v}" for v in ("urgent", "slow", "large_vehicle", "from_stationary", "congestion", "ramp")),
    "reactive_agent.vru_crossing", "reactive_agent.vru_emergence", "reactive_agent.vru_invasion", "reactive_agent.vehicle_abnormal",
    "reactive_agent.following", "reactive_agent.passing", "reactive_agent.animal",
    *(f"proactive.lane_change.{v}" for v in ("navigation", "efficiency", "escape", "overtake", "abort")),
    "proactive.obstacle_avoidance", "proactive.pull_over.normal", "safety",
]
COMPLETE_CROSSING = ["reactive_agent.intersection_interaction", "reactive_agent.cutin.intersection"]


def entries(log, parts):
    ns = lambda t: START_NS + round(max(log.times[0], min(t, log.times[-1])) * 10) * 10**8
    out = []
    for part in parts:
        for leaf, start, key, end, target, *left_open in part(log):
            out.append({"scenario_id": leaf, "drive_id": f"{log.name}-ego", "start_ns": ns(min(start, key)), "keyframe_ns": ns(key),
                        "end_ns": ns(max(end, key))} | ({"target_id": target} if target else {}) | ({"optional": True} if any(left_open) else {}))
    return sorted(out, key=lambda r: (r["keyframe_ns"], r["scenario_id"], r.get("target_id", "")))


def main():
    folders = [Path(a) for a in sys.argv[1:]] or [HERE / "seen", HERE / "unseen"]
    for top in folders:
        counts = Counter()
        for folder in sorted(p.parent for p in top.glob("*/script.json.gz")):
            junction = "_crossing_" in folder.name
            found = entries(CrossingLog(folder), [leaves_crossing.interactions]) if junction else entries(Log(folder), PARTS)
            head = {"complete": COMPLETE_CROSSING if junction else COMPLETE, "drives": [f"{folder.name}-ego"]}
            (folder / "truth.jsonl").write_text("\n".join(json.dumps(x) for x in [head, *found]) + "\n")
            counts.update(r["scenario_id"] for r in found)
        print(top, len(counts), "classes")
        for leaf, n in sorted(counts.items()):
            print(f"  {n:4} {leaf}")


if __name__ == "__main__":
    main()
