//! Standard deviations of signals: of each number that follows from estimated states, the deviation that these give it
//! (first order, states taken as independent). Columns beside the signals' own; a drive whose states are exact has
//! none.

mod objects;

pub(super) use objects::write as write_objects;

use super::smoother::Deviations;
use whyroad_model::scene::Track;
use whyroad_model::signal::{TargetSpan, deviation_name};
use whyroad_model::{Column, Drive, SignalTable};

/// What a signal of the ego is made of.
#[derive(Clone, Copy)]
enum OfEgo {
    Position,
    Heading,
    Speed,
    Accel,
    YawRate,
    /// Speed across a direction: the heading's deviation times the speed.
    Sideways,
    /// Yaw rate times speed.
    LateralAccel,
    /// Yaw rate over speed.
    Curvature,
}

/// What a signal of a target is made of; the ego's share is added where both are compared.
#[derive(Clone, Copy)]
enum OfTarget {
    Distance,
    Direction,
    Speed,
    Accel,
    RelativeSpeed,
    Sideways,
    /// Distance over closing speed.
    TimeToCollision,
    /// Distance over the ego's speed.
    Headway,
}

const EGO: &[(&str, OfEgo)] = &[
    ("ego.speed", OfEgo::Speed),
    ("ego.forward_speed", OfEgo::Speed),
    ("ego.accel", OfEgo::Accel),
    ("ego.yaw_rate", OfEgo::YawRate),
    ("ego.heading", OfEgo::Heading),
    ("ego.curvature", OfEgo::Curvature),
    ("ego.lateral_accel", OfEgo::LateralAccel),
    ("ego.lane_offset", OfEgo::Position),
    ("ego.lateral_deviation", OfEgo::Position),
    ("ego.lateral_speed", OfEgo::Sideways),
    ("map.distance_to_junction", OfEgo::Position),
    ("map.distance_to_crosswalk", OfEgo::Position),
    ("map.distance_to_stop_line", OfEgo::Position),
    ("light.distance_to_stop_line", OfEgo::Position),
];

const TARGET: &[(&str, OfTarget)] = &[
    ("target.distance", OfTarget::Distance),
    ("target.longitudinal", OfTarget::Distance),
    ("target.lateral", OfTarget::Distance),
    ("target.path_longitudinal", OfTarget::Distance),
    ("target.path_lateral", OfTarget::Distance),
    ("target.gap", OfTarget::Distance),
    ("target.lateral_offset", OfTarget::Distance),
    ("target.lane_centre_distance", OfTarget::Distance),
    ("target.lateral_gap", OfTarget::Distance),
    ("target.path_side_distance", OfTarget::Distance),
    ("target.speed", OfTarget::Speed),
    ("target.accel", OfTarget::Accel),
    ("target.heading_difference", OfTarget::Direction),
    ("target.crossing_angle", OfTarget::Direction),
    ("target.relative_speed", OfTarget::RelativeSpeed),
    ("target.lane_lateral_speed", OfTarget::Sideways),
    ("target.ttc", OfTarget::TimeToCollision),
    ("target.ttc_lane", OfTarget::TimeToCollision),
    ("target.ttc_box", OfTarget::TimeToCollision),
    ("target.thw", OfTarget::Headway),
];

/// Signals of the lead and those of the target that is the lead.
const LEAD: [(&str, &str); 5] = [
    ("lead.gap", "target.gap"),
    ("lead.speed", "target.speed"),
    ("lead.accel", "target.accel"),
    ("lead.ttc", "target.ttc"),
    ("lead.thw", "target.thw"),
];

/// A speed below this divides by no less, m/s.
const LEAST_SPEED_MPS: f64 = 0.5;

/// Standard deviations of the states of a drive.
pub(super) struct OfDrive<'a> {
    /// The estimated drive.
    pub drive: &'a Drive,
    /// One per frame; `None` where the ego is exact.
    pub ego: Option<&'a Deviations>,
    /// Of each track of the drive; `None` where it is exact.
    pub tracks: &'a [Option<Deviations>],
}

/// Adds the columns to the signals of the drive.
pub(super) fn write(of: &OfDrive<'_>, table: &mut SignalTable) {
    if of.ego.is_none() && of.tracks.iter().all(Option::is_none) {
        return;
    }
    of_ego(of, table);
    of_targets(of, table);
    of_lead(table);
}

fn number(value: Option<f64>) -> f64 {
    value.filter(|v| v.is_finite()).unwrap_or(0.0)
}

fn of_ego(of: &OfDrive<'_>, table: &mut SignalTable) {
    let (Some(sd), Some(ego)) = (of.ego, &of.drive.ego) else { return };
    for (name, made) in EGO {
        let Some(Column::Number(values)) = table.frame_columns.get(*name) else { continue };
        let one = |i: usize| {
            let speed = ego.motion.speed(i).max(LEAST_SPEED_MPS);
            match made {
                OfEgo::Position => sd.position[i],
                OfEgo::Heading => sd.heading[i],
                OfEgo::Speed => sd.speed[i],
                OfEgo::Accel => sd.accel[i],
                OfEgo::YawRate => sd.yaw_rate[i],
                OfEgo::Sideways => speed * sd.heading[i],
                OfEgo::LateralAccel => (speed * sd.yaw_rate[i]).hypot(ego.motion.yaw_rate[i] * sd.speed[i]),
                OfEgo::Curvature => sd.yaw_rate[i] / speed,
            }
        };
        let column = (0..values.len()).map(one).collect();
        table.frame_columns.insert(deviation_name(name), Column::Number(column));
    }
}

fn of_targets(of: &OfDrive<'_>, table: &mut SignalTable) {
    let tracks: Vec<(&Track, Option<&Deviations>)> = of
        .drive
        .tracks
        .iter()
        .zip(of.tracks)
        .filter(|(t, _)| !t.frames.is_empty())
        .map(|(t, sd)| (t, sd.as_ref()))
        .collect();
    let of_ego = |pick: fn(&Deviations) -> &Vec<f64>, frame: usize| {
        number(of.ego.and_then(|sd| pick(sd).get(frame).copied()))
    };
    for (name, made) in TARGET {
        let Some(Column::Number(values)) = table.target_columns.get(*name) else { continue };
        let mut column = vec![0.0; values.len()];
        let other =
            |other: &str, row: usize| number(table.target_columns.get(other).and_then(|c| c.number(row)));
        for (span, (track, sd)) in table.targets.iter().zip(&tracks) {
            for (i, &frame) in track.frames.iter().enumerate() {
                let frame = frame as usize;
                let row = row_of(span, frame);
                let own =
                    |pick: fn(&Deviations) -> &Vec<f64>| number(sd.and_then(|sd| pick(sd).get(i).copied()));
                let place = own(|s| &s.position).hypot(of_ego(|s| &s.position, frame));
                let speed = own(|s| &s.speed).hypot(of_ego(|s| &s.speed, frame));
                let turned = own(|s| &s.heading);
                column[row] = match made {
                    OfTarget::Distance => place,
                    OfTarget::Direction => turned.hypot(of_ego(|s| &s.heading, frame)),
                    OfTarget::Speed => own(|s| &s.speed),
                    OfTarget::Accel => own(|s| &s.accel),
                    OfTarget::RelativeSpeed => speed,
                    OfTarget::Sideways => {
                        (number(Some(track.motion.speed(i))) * turned).min(own(|s| &s.speed))
                    }
                    OfTarget::TimeToCollision => {
                        let gap = other("target.gap", row).abs().max(0.5);
                        let closing = other("target.relative_speed", row).abs().max(LEAST_SPEED_MPS);
                        number(Some(values[row].abs() * (place / gap).hypot(speed / closing)))
                    }
                    OfTarget::Headway => {
                        let ego = of.drive.ego.as_ref().map_or(f64::NAN, |e| e.motion.speed(frame));
                        let ego = number(Some(ego)).max(LEAST_SPEED_MPS);
                        (place / ego).hypot(number(Some(values[row])) * of_ego(|s| &s.speed, frame) / ego)
                    }
                };
            }
        }
        if column.iter().any(|d| *d > 0.0) {
            table.target_columns.insert(deviation_name(name), Column::Number(column));
        }
    }
}

fn row_of(span: &TargetSpan, frame: usize) -> usize {
    span.first_row + frame - span.frames.start
}

fn of_lead(table: &mut SignalTable) {
    let Some(is_lead) = table.target_columns.get("target.is_lead") else { return };
    let mut lead_row = vec![None; table.times.len()];
    for span in &table.targets {
        for frame in span.frames.start..span.frames.end {
            let row = row_of(span, frame);
            if is_lead.flag(row).is_true() {
                lead_row[frame] = Some(row);
            }
        }
    }
    for (name, of) in LEAD {
        let Some(sd) = table.target_columns.get(&deviation_name(of)) else { continue };
        if !table.frame_columns.contains_key(name) {
            continue;
        }
        let column = lead_row.iter().map(|row| number(row.and_then(|r| sd.number(r)))).collect();
        table.frame_columns.insert(deviation_name(name), Column::Number(column));
    }
}
