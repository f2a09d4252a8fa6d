//! Our in-path lead and its gap compared with SUMO's leader (`leaderID`, `leaderGap` of FCD).
//!
//! SUMO's gap is bumper to bumper along the lanes (its `minGap` is not subtracted in FCD: for 10 000 pairs in one
//! straight lane it equals the distance of the front bumpers minus the leader's length, within 0.01 m).

use super::errors::Errors;
use super::{GRID_RUN, MOTORWAY_RUN, Run, Tally, edge};
use std::collections::BTreeSet;

/// Both sides are limited to this: around the egos the log is 90 m wide.
const REACH_M: f64 = 80.0;

struct Figures {
    tally: Tally,
    /// All frames with the same lead.
    gaps: Errors,
    /// Those in which both are in one lane between junctions and neither changes lanes before the ego gets there.
    gaps_in_lane: Errors,
}

fn compare(run: &Run) -> Figures {
    let s = &run.truth;
    let mut f = Figures { tally: Tally::default(), gaps: Errors::default(), gaps_in_lane: Errors::default() };
    for (&ego, derived) in &run.seen_from {
        let route: BTreeSet<&str> =
            s.vehicles.values().filter_map(|all| Some(edge(&all.get(ego)?.lane))).collect();
        for &step in derived.frames.keys() {
            let own = s.vehicle(step, ego).expect("the ego is in its own log");
            let ours = derived.lead(step).filter(|l| l.1 <= REACH_M);
            let theirs =
                own.leader.clone().filter(|(id, gap)| *gap <= REACH_M && s.vehicle(step, id).is_some());
            let changing = |after: i64| {
                let who: Vec<&str> =
                    [Some(ego), ours.as_ref().map(|l| l.0.as_str()), theirs.as_ref().map(|l| l.0.as_str())]
                        .into_iter()
                        .flatten()
                        .collect();
                s.lane_changes.iter().any(|c| {
                    who.contains(&c.vehicle.as_str()) && (step - 40..=step + after).contains(&c.step)
                })
            };
            // The simulator also follows vehicles that will cross or join the ego's path ("link leaders"), and others
            // on the rest of its planned route, which may be beyond the end of the recording.
            let off_route = theirs
                .as_ref()
                .and_then(|(id, _)| s.vehicle(step, id))
                .is_some_and(|v| !route.contains(edge(&v.lane)));
            f.tally.add(match (&ours, &theirs) {
                (None, None) => "both none",
                (Some(a), Some(b)) if a.0 == b.0 => {
                    f.gaps.add(a.1 - b.1);
                    let lane = |id: &str| s.vehicle(step, id).map(|v| v.lane.as_str());
                    if lane(&a.0) == lane(ego) && !own.lane.starts_with(':') && !changing(300) {
                        f.gaps_in_lane.add(a.1 - b.1);
                    }
                    "same"
                }
                _ if off_route => "leader not on the ego's driven route",
                _ if changing(10) => "while one changes lanes",
                _ => "unexplained",
            });
        }
    }
    println!("leads, {}: {}", s.name, f.tally.line());
    println!("  gap, same lead: {} m", f.gaps.line());
    println!("  gap, in one lane: {} m", f.gaps_in_lane.line());
    f
}

#[test]
fn leads_and_gaps_on_the_grid() {
    let f = compare(&GRID_RUN);
    assert!(f.tally.get("same") > 1000 && f.tally.get("unexplained") == 0, "{}", f.tally.line());
    assert!(f.tally.share(&["while one changes lanes"]) < 0.03, "{}", f.tally.line());
    assert!(f.gaps_in_lane.len() > 200 && f.gaps_in_lane.quantile(0.99) < 0.15, "{}", f.gaps_in_lane.line());
    assert!(f.gaps.quantile(0.5) < 0.1 && f.gaps.quantile(0.9) < 1.0, "{}", f.gaps.line());
}

#[test]
fn leads_and_gaps_on_the_motorway() {
    let f = compare(&MOTORWAY_RUN);
    assert!(
        f.tally.share(&["same", "both none"]) > 0.99 && f.tally.get("unexplained") == 0,
        "{}",
        f.tally.line()
    );
    assert!(f.gaps_in_lane.len() > 500 && f.gaps_in_lane.quantile(0.99) < 0.15, "{}", f.gaps_in_lane.line());
    assert!(f.gaps.quantile(0.9) < 0.15, "{}", f.gaps.line());
}
