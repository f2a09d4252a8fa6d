//! Our lane changes compared with `lanechange-output`. SUMO's change is the moment at which the vehicle is assigned to
//! the new lane; ours is the whole period of moving across.

use super::errors::Errors;
use super::{GRID_RUN, MOTORWAY_RUN, Run, Tally, edge};
use whyroad_model::SignalTable;

/// First and last frame, and side (1 left, -1 right) of each change.
fn spans(table: &SignalTable) -> Vec<(usize, usize, i32)> {
    let column = &table.frame_columns["ego.lane_change"];
    let mut found: Vec<(usize, usize, i32)> = Vec::new();
    for frame in 0..table.times.len() {
        let side = match column.category(frame) {
            Some("left") => 1,
            Some("right") => -1,
            _ => continue,
        };
        match found.last_mut() {
            Some((_, last, s)) if *last + 1 == frame && *s == side => *last = frame,
            _ => found.push((frame, frame, side)),
        }
    }
    found
}

/// Frames in which our lane changes to another one of the same edge.
fn line_crossings(drive: &whyroad_model::Drive) -> Vec<usize> {
    let lanes = whyroad_signals::ego_lane_ids(drive);
    let changed = |f: &usize| match (&lanes[f - 1], &lanes[*f]) {
        (Some(a), Some(b)) => a != b && edge(a) == edge(b),
        _ => false,
    };
    (1..lanes.len()).filter(changed).collect()
}

fn compare(run: &Run) -> (Tally, Errors) {
    let s = &run.truth;
    let (mut tally, mut moment) = (Tally::default(), Errors::default());
    for (&ego, derived) in &run.seen_from {
        // Two consecutive changes are one span.
        let mut ours: Vec<_> = spans(&derived.table).into_iter().map(|span| (span, false)).collect();
        let crossings = line_crossings(&derived.drive);
        for change in s.lane_changes.iter().filter(|c| c.vehicle == ego) {
            let Some(&frame) = derived.frames.get(&change.step) else { continue };
            let within = |&((a, b, side), _): &((usize, usize, i32), bool)| {
                side == change.side && a <= frame && frame <= b
            };
            match ours.iter().position(within) {
                Some(i) => {
                    ours[i].1 = true;
                    tally.add("same");
                    let nearest = crossings
                        .iter()
                        .map(|&f| (f as f64 - frame as f64) / 10.0)
                        .min_by(|a, b| a.abs().total_cmp(&b.abs()));
                    moment.add(nearest.unwrap_or(f64::INFINITY));
                }
                None => tally.add("theirs only"),
            }
        }
        ours.iter().filter(|(_, seen)| !seen).for_each(|_| tally.add("ours only"));
    }
    println!(
        "lane changes, {}: {}; our line crossing after theirs: {} s",
        s.name,
        tally.line(),
        moment.line()
    );
    (tally, moment)
}

#[test]
fn lane_changes_are_the_simulators() {
    for (run, least) in [(&*GRID_RUN, 6), (&*MOTORWAY_RUN, 10)] {
        let (tally, moment) = compare(run);
        assert!(tally.get("same") >= least && tally.share(&["same"]) > 0.85, "{}", tally.line());
        assert!(moment.quantile(0.5) <= 0.5 && moment.quantile(1.0) <= 1.5, "{}", moment.line());
    }
}
