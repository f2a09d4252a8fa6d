"""What happens in a run, as entries of a truth file: every leaf whose definition holds, from SUMO's outputs alone.

`COMPLETE` names the leaves that those outputs decide: what is found of them beyond the truth is false. An entry with `optional` is one on which
the definition or the threshold leaves room (said at each derivation): found or not, it counts neither way.

Not complete, so that only what is missed counts: intersection_interaction (SUMO knows who yields to whom, not whether that was why a driver slowed
who turns anyway), near_miss (its measures know vehicles only).
"""

import json

from follow import following, leads, near_misses, riders_ahead
from junctions import passages, roundabouts, turns_and_conflicts
from lanes import cut_ins, own_changes, ramps
from lights import lights, unfinished
from log import Run
from people import crossings

COMPLETE = [
    *(f"proactive.turn.{v}" for v in ("straight", "left_normal", "left_unprotected", "right_normal", "uturn")),
    *(f"proactive.lane_change.{v}" for v in ("navigation", "efficiency", "overtake")),
    *(f"proactive.merge_interaction.{v}" for v in ("normal_merge", "split_exit")),
    *(f"proactive.roundabout.{v}" for v in ("entry", "exit", "lane_in_roundabout")),
    "reactive_rule.special_lane.bus_lane",
    *(f"reactive_rule.traffic_light.{v}" for v in ("red_stop", "yellow_stop", "green_pass", "resume_first", "resume_follow")),
    *(f"reactive_agent.following.{v}" for v in ("steady", "stop_and_go", "creeping", "follow_start", "follow_stop", "lead_sudden_brake")),
    *(f"reactive_agent.cutin.{v}" for v in ("urgent", "slow", "large_vehicle", "ramp")),
    *(f"reactive_agent.vru_crossing.{v}" for v in ("crosswalk", "horizontal", "diagonal")),
    "reactive_agent.vru_invasion.same_direction",
]


def derive(work, name, egos):
    run = Run(work, name)
    vehicles = [i for i in run.rows if run.vehicle(i)]
    all_passages = {i: passages(run, i) for i in vehicles}
    entries = []
    for ego in egos:
        lead = leads(run, ego)
        entries += turns_and_conflicts(run, ego, all_passages)
        entries += roundabouts(run, ego, all_passages)
        entries += own_changes(run, ego)
        entries += ramps(run, ego)
        entries += cut_ins(run, ego)
        entries += lights(run, ego, all_passages)
        entries += unfinished(run, ego, all_passages)
        entries += following(run, ego, lead)
        entries += near_misses(run, ego)
        entries += riders_ahead(run, ego, lead)
        entries += crossings(run, ego, all_passages, lead)
    entries.sort(key=lambda e: (e["drive_id"], e["keyframe_ns"], e["scenario_id"], e.get("target_id", "")))
    head = {"complete": COMPLETE, "drives": [f"{name}-{e}" for e in egos]}
    return [json.dumps(x) for x in (head, *entries)]
