"""What happens in a run, by the words of TAXONOMY.md and LABELING.md, from SUMO's outputs alone: no signal or rule
of Whyroad's is used.

`COMPLETE` are the leaves that those outputs decide. SUMO's vehicles never reverse or swerve in an emergency, and no
model of theirs weaves, reveals or squeezes past oncoming traffic: those leaves are complete and have no required entry.
An entry is `optional` where
a threshold is met or missed by little or where the definition asks for a reason that the simulator does not give:
found or not, it counts neither way.
"""

import json

from judge_junctions import junctions
from judge_lanes import changes, cut_ins, facilities
from judge_lights import lights
from judge_others import others
from judge_traffic import following, leads, near_misses, people
from world import World

COMPLETE = [
    *(f"proactive.turn.{v}" for v in ("straight", "left_normal", "left_unprotected", "right_normal", "uturn")),
    *(f"proactive.lane_change.{v}" for v in ("navigation", "efficiency", "overtake", "escape")),
    *(f"proactive.merge_interaction.{v}" for v in ("normal_merge", "zipper_merge", "split_exit")),
    *(f"proactive.roundabout.{v}" for v in ("entry", "exit", "lane_in_roundabout")),
    "proactive.pull_over.normal",
    *(f"reactive_rule.traffic_light.{v}" for v in ("red_stop", "yellow_stop", "green_pass", "resume_first", "resume_follow")),
    *(f"reactive_agent.following.{v}" for v in ("steady", "stop_and_go", "creeping", "follow_start", "follow_stop", "lead_sudden_brake")),
    *(f"reactive_agent.cutin.{v}" for v in ("urgent", "slow", "large_vehicle", "ramp", "from_stationary", "intersection")),
    *(f"reactive_agent.intersection_interaction.{v}" for v in ("unprotected_left", "right_vs_straight", "cross_conflict")),
    *(f"reactive_agent.vru_crossing.{v}" for v in ("crosswalk", "horizontal", "diagonal")),
    *(f"reactive_agent.passing.{v}" for v in ("narrow_road", "large_vehicle", "construction")),
    *(f"reactive_agent.vehicle_abnormal.{v}" for v in ("reversing", "abnormal_motion", "cutout_reveal")),
    "safety.emergency_maneuver.steering", "safety.near_miss.general",
]


def derive(work, name, egos, lateral):
    world = World(work, name)
    egos = [e for e in egos if e in world.rows and max(world.rows[e]) - min(world.rows[e]) >= 150]
    entries = []
    for ego in egos:
        lead = leads(world, ego)
        entries += junctions(world, ego, lead)
        entries += lights(world, ego)
        entries += following(world, ego, lead)
        entries += changes(world, ego, lead)
        entries += facilities(world, ego)
        entries += cut_ins(world, ego)
        entries += people(world, ego)
        entries += near_misses(world, ego)
        entries += others(world, ego, lead)
    entries.sort(key=lambda e: (e["drive_id"], e["keyframe_ns"], e["scenario_id"], e.get("target_id", "")))
    return egos, [json.dumps(x) for x in ({"complete": COMPLETE, "drives": [f"{name}-{e}" for e in egos]}, *entries)]
