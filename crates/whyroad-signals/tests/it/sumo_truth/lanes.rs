//! Our assigned lane compared with the lane in FCD. SUMO's lane is that of the front bumper, ours that of the box
//! center: at the joint of two lanes ours follows half a car's length later, so the lane at the time when the front was
//! at the center's current position also counts.

use super::{GRID_RUN, MOTORWAY_RUN, Run, Tally};

fn compare(run: &Run) -> Tally {
    let s = &run.truth;
    let mut tally = Tally::default();
    for (&ego, derived) in &run.seen_from {
        let half = derived.drive.ego.as_ref().expect("an ego").length_m / 2.0;
        let ours = whyroad_signals::ego_lane_ids(&derived.drive);
        for (&step, &frame) in &derived.frames {
            let now = s.vehicle(step, ego).expect("the ego is in its own log");
            let behind = |v: &super::simulation::Vehicle| (v.x - now.x).hypot(v.y - now.y);
            let then = (0..).map_while(|back| s.vehicle(step - back, ego)).find(|v| behind(v) >= half);
            let changing = s.lane_changes.iter().any(|c| c.vehicle == ego && (c.step - step).abs() <= 40);
            tally.add(match &ours[frame] {
                Some(lane) if *lane == now.lane => "same",
                Some(lane) if then.is_some_and(|v| v.lane == *lane) => "the front is a lane ahead",
                _ if changing => "while changing lanes",
                None => "none of ours",
                Some(_) => "another",
            });
        }
    }
    println!("lanes, {}: {}", s.name, tally.line());
    tally
}

#[test]
fn lanes_are_the_simulators() {
    for run in [&*GRID_RUN, &*MOTORWAY_RUN] {
        let tally = compare(run);
        assert!(tally.total() > 2000, "{}", tally.line());
        assert!(tally.share(&["same", "the front is a lane ahead"]) > 0.95, "{}", tally.line());
        assert!(tally.share(&["another", "none of ours"]) < 0.005, "{}", tally.line());
    }
}
