//! Stops, the position in the queue and the light's history compared with FCD and `SaveTLSStates`: vehicles that stand
//! between the ego and the end of its lane, number of stops, times when the letter of its link changed.

use super::simulation::{Derived, Simulation, Step};
use super::{GRID_RUN, Tally};

/// Below this speed a vehicle is halting in SUMO, m/s.
const HALTING_MPS: f64 = 0.1;

/// Steps at which the ego's speed in FCD falls below 0.3 m/s and was above 0.5 m/s since the last time (the catalog's
/// standstill; SUMO's own halting, below 0.1 m/s, counts two stops for a car that moves up by half a meter).
fn stops(s: &Simulation, ego: &str, derived: &Derived) -> Vec<Step> {
    let (mut stands, mut found) = (false, Vec::new());
    for &step in derived.frames.keys() {
        let speed = s.vehicle(step, ego).expect("the ego is in its own log").speed;
        if !stands && speed < 0.3 {
            found.push(step);
        }
        stands = if stands { speed <= 0.5 } else { speed < 0.3 };
    }
    found
}

#[test]
fn stops_are_the_simulators() {
    let mut tally = Tally::default();
    for (&ego, derived) in &GRID_RUN.seen_from {
        let column = &derived.table.frame_columns["ego.stop_count"];
        let began = stops(&GRID_RUN.truth, ego, derived);
        for (&step, &frame) in &derived.frames {
            let theirs = began.iter().filter(|&&b| b <= step && step - b <= 600).count();
            let ours = column.number(frame).expect("known");
            // FCD writes speeds to 0.01 m/s, and a frame may differ by one.
            let near = began.iter().any(|b| (b - step).abs() <= 1 || (b + 600 - step).abs() <= 1);
            tally.add(if ours == theirs as f64 {
                "same"
            } else if near {
                "within a frame of it"
            } else {
                "different"
            });
        }
    }
    println!("stop count, grid: {}", tally.line());
    assert!(tally.get("same") > 2000 && tally.share(&["different"]) < 0.001, "{}", tally.line());
}

#[test]
fn the_place_in_the_queue_is_the_simulators() {
    let s = &GRID_RUN.truth;
    let mut tally = Tally::default();
    let mut in_queue = 0;
    for (&ego, derived) in &GRID_RUN.seen_from {
        let column = &derived.table.frame_columns["traffic.queue_position"];
        let steps: Vec<Step> = derived.frames.keys().copied().collect();
        let stands = |t: &Step| s.vehicle(*t, ego).is_some_and(|v| v.speed < HALTING_MPS);
        for run in steps.chunk_by(|a, b| stands(a) == stands(b) && b - a == 1) {
            let Some(own) = s.vehicle(run[run.len() / 2], ego) else { continue };
            if !stands(&run[0]) || run.len() < 10 || own.lane.starts_with(':') {
                continue;
            }
            let end = s.lane_end[&own.lane];
            let to_end = |x: f64, y: f64| (end.0 - x).hypot(end.1 - y);
            if to_end(own.x, own.y) > 90.0 {
                continue;
            }
            // Maximum number of vehicles that stood ahead in the lane at one step of the standstill.
            let ahead = |t: &Step| {
                s.vehicles[t]
                    .iter()
                    .filter(|(id, v)| id.as_str() != ego && v.lane == own.lane && v.speed < 0.5)
                    .filter(|(_, v)| to_end(v.x, v.y) < to_end(own.x, own.y))
                    .count()
            };
            let theirs = run.iter().map(ahead).max().unwrap_or(0);
            in_queue += usize::from(theirs > 0);
            let ours = column.number(derived.frames[&run[run.len() / 2]]).expect("known");
            tally.add(if ours == theirs as f64 { "same" } else { "different" });
        }
    }
    println!("place in the queue by stand, grid: {}; {in_queue} not first", tally.line());
    assert!(tally.total() >= 5 && in_queue >= 2, "{}", tally.line());
    assert!(tally.share(&["same"]) > 0.85, "{}", tally.line());
}

#[test]
fn the_lights_history_is_the_simulators() {
    let s = &GRID_RUN.truth;
    let mut tally = Tally::default();
    for (&ego, derived) in &GRID_RUN.seen_from {
        let columns = &derived.table.frame_columns;
        let (state, since, previous) =
            (&columns["light.state"], &columns["light.time_since_change"], &columns["light.previous"]);
        for (&step, &frame) in &derived.frames {
            let now = s.vehicle(step, ego).expect("the ego is in its own log");
            let ahead = (step..).map_while(|t| s.vehicle(t, ego)).find(|v| v.lane.starts_with(':'));
            let Some(next) = ahead.filter(|_| !now.lane.starts_with(':')) else { continue };
            let Some((light, link)) = s.link_of.get(&next.lane) else { continue };
            let letters = |t: Step| s.lights[light].range(..=t).next_back().map(|(_, l)| l.as_bytes()[*link]);
            // Only if both refer to the same light.
            if state.category(frame) != letters(step).map(word) {
                continue;
            }
            let changed =
                s.lights[light].keys().rev().copied().find(|&t| t <= step && letters(t - 1) != letters(t));
            let Some(changed) = changed.filter(|&t| letters(t - 1).is_some()) else { continue };
            // The recording must contain the change.
            let first = *derived.frames.keys().next().expect("frames");
            let known = since.number(frame);
            let theirs = (step - changed) as f64 / 10.0;
            tally.add(match known {
                None if changed <= first => "unknown, not recorded",
                Some(ours) if (ours - theirs).abs() <= 0.15 => {
                    if previous.category(frame) == letters(changed - 1).map(word) {
                        "same"
                    } else {
                        "other state before"
                    }
                }
                Some(ours) if changed <= first && ours < theirs => "lower bound, not recorded",
                _ => "different",
            });
        }
    }
    println!("light's last change, grid: {}", tally.line());
    assert!(tally.get("same") > 500, "{}", tally.line());
    assert!(tally.share(&["different", "other state before"]) < 0.01, "{}", tally.line());
}

fn word(letter: u8) -> &'static str {
    match letter {
        b'r' => "red",
        b'y' => "yellow",
        b'G' => "green",
        b'g' => "green_yield",
        _ => "other",
    }
}
