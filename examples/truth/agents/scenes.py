"""Which scenes are played on which road. Next to scenes that are of a class stand some that look like it and are not (`decoy_*`): people
on the pavement, cars that reverse in their drive, and so on. Numbers are drawn again each time."""

from scenes_lanes import (
    cutin_large, cutin_slow, cutin_urgent, decoy_joins_behind, decoy_overtaken, escape, from_kerb, gains_speed, gives_up,
    joins_gently, joins_urgent, lorry_joins, overtakes, pulls_over,
)
from scenes_meeting import (
    aeb_car, aeb_lorry, aeb_walker, decoy_meeting, decoy_parked, ignores, late_braking, meets_at_works, meets_lorry,
    narrow_meeting, round_in_lane, round_over_line, swerve,
)
from scenes_people import (
    against_in_lane, animal_crosses, animal_stands, at_crosswalk, crossing_bike, crossing_slant, crossing_square, cyclist_ahead,
    cyclist_comes_in, decoy_animal, decoy_far_crossing, decoy_pavement, emerge_dynamic, emerge_static,
)
from scenes_vehicles import (
    creep, cutout, decoy_reversing, lead_brakes_hard, lead_brakes_softly, lead_follow, lead_stops, neighbour_brakes, queue_cutin,
    reversing, stop_and_go, weaving, wrong_way,
)

STREET = [crossing_square, crossing_slant, crossing_bike, emerge_static, emerge_dynamic, cyclist_ahead, cyclist_comes_in, against_in_lane,
          animal_crosses, animal_stands, reversing, wrong_way, weaving, lead_brakes_hard, lead_stops, round_in_lane, round_over_line,
          ignores, swerve, late_braking, aeb_car, aeb_lorry, aeb_walker, at_crosswalk, meets_at_works, pulls_over, meets_lorry, from_kerb, lead_follow, decoy_pavement, decoy_far_crossing, decoy_animal,
          decoy_reversing, decoy_meeting, decoy_parked, lead_brakes_softly]
AVENUE = [cutin_urgent, cutin_slow, cutin_large, from_kerb, cutout, neighbour_brakes, escape, gives_up, overtakes, gains_speed, stop_and_go, queue_cutin,
          creep, lead_stops, lead_brakes_hard, lead_follow, lead_brakes_softly, weaving, decoy_parked]
MOTORWAY = [joins_urgent, joins_gently, lorry_joins, decoy_joins_behind, decoy_overtaken, lead_follow, lead_brakes_hard]
LANE = [narrow_meeting, crossing_square, against_in_lane, decoy_pavement, creep, animal_crosses, emerge_static, cyclist_ahead]
