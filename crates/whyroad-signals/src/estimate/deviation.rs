//! Standard deviations of signals: for each number computed from estimated states, the resulting deviation (first
//! order, states treated as independent). They are columns in addition to the signals' own; a drive with exact states
//! has none.

mod objects;

pub(super) use objects::write as write_objects;

use super::smoother::Deviations;
use whyroad_model::scene::Track;
use whyroad_model::signal::{TargetSpan, deviation_name};
use whyroad_model::{Column, Drive, SignalTable};

/// Inputs of a signal of the ego.
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

/// Inputs of a signal of a target; the ego's share is added where both are compared.
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

/// Minimum speed for a division, m/s.
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

/// Deviation of a sum of two values with these deviations, the first of which is finite and not negative: a drive can
/// be exact for the ego.
fn joint(of: f64, other: f64) -> f64 {
    if other == 0.0 { of } else { of.hypot(other) }
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

/// Data of one observed row of a target, for all signals.
struct OfRow {
    /// Row of the table.
    row: usize,
    frame: usize,
    /// Of a distance between the ego and the target, m.
    place: f64,
    /// Of the difference of their speeds, m/s.
    difference: f64,
    /// Of the target's own heading (rad), speed (m/s) and acceleration (m/s2).
    turned: f64,
    speed: f64,
    accel: f64,
}

impl OfRow {
    fn new(row: usize, frame: usize, of_ego: &[f64; 2], own: Option<(&Deviations, usize)>) -> Self {
        let own =
            |pick: fn(&Deviations) -> &Vec<f64>| number(own.and_then(|(sd, i)| pick(sd).get(i).copied()));
        let (turned, speed, accel) = (own(|sd| &sd.heading), own(|sd| &sd.speed), own(|sd| &sd.accel));
        let (place, difference) = (joint(own(|sd| &sd.position), of_ego[0]), joint(speed, of_ego[1]));
        Self { row, frame, place, difference, turned, speed, accel }
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
    let of_ego = |pick: fn(&Deviations) -> &Vec<f64>| -> Vec<f64> {
        (0..of.drive.times.len()).map(|i| number(of.ego.and_then(|sd| pick(sd).get(i).copied()))).collect()
    };
    let (ego_place, ego_speed) = (of_ego(|sd| &sd.position), of_ego(|sd| &sd.speed));
    let ego_heading = of_ego(|sd| &sd.heading);
    let ego = of.drive.ego.as_ref();
    let own_speed: Vec<f64> = (0..of.drive.times.len())
        .map(|i| number(ego.map(|e| e.motion.speed(i))).max(LEAST_SPEED_MPS))
        .collect();
    let mut rows: Vec<Vec<OfRow>> = Vec::with_capacity(tracks.len());
    for (span, (track, sd)) in table.targets.iter().zip(&tracks) {
        let row = |(i, &frame): (usize, &u32)| {
            let frame = frame as usize;
            OfRow::new(
                row_of(span, frame),
                frame,
                &[ego_place[frame], ego_speed[frame]],
                sd.map(|sd| (sd, i)),
            )
        };
        rows.push(track.frames.iter().enumerate().map(row).collect());
    }
    let spread = |values: &[f64], value: &dyn Fn(&OfRow, usize, &Track) -> f64| {
        let mut column = vec![0.0; values.len()];
        for ((track, _), rows) in tracks.iter().zip(&rows) {
            rows.iter().enumerate().for_each(|(i, r)| column[r.row] = value(r, i, track));
        }
        column
    };
    // Half of the signals use a distance.
    let mut of_distance: Option<Vec<f64>> = None;
    let mut of_direction: Option<Vec<f64>> = None;
    for (name, made) in TARGET {
        let Some(Column::Number(values)) = table.target_columns.get(*name) else { continue };
        let (gap, relative) =
            (table.target_columns.get("target.gap"), table.target_columns.get("target.relative_speed"));
        let other = |column: Option<&Column>, row: usize| number(column.and_then(|c| c.number(row)));
        let column = match made {
            OfTarget::Distance => {
                of_distance.get_or_insert_with(|| spread(values, &|r, _, _| r.place)).clone()
            }
            OfTarget::Direction => {
                let of = || spread(values, &|r, _, _| joint(r.turned, ego_heading[r.frame]));
                of_direction.get_or_insert_with(of).clone()
            }
            OfTarget::Speed => spread(values, &|r, _, _| r.speed),
            OfTarget::Accel => spread(values, &|r, _, _| r.accel),
            OfTarget::RelativeSpeed => spread(values, &|r, _, _| r.difference),
            OfTarget::Sideways => {
                spread(values, &|r, i, track| (number(Some(track.motion.speed(i))) * r.turned).min(r.speed))
            }
            OfTarget::TimeToCollision => spread(values, &|r, _, _| {
                let time = values[r.row].abs();
                // Where a time is unknown or infinite, its deviation is unknown, too.
                if !time.is_finite() {
                    return 0.0;
                }
                let gap = other(gap, r.row).abs().max(0.5);
                let closing = other(relative, r.row).abs().max(LEAST_SPEED_MPS);
                number(Some(time * (r.place / gap).hypot(r.difference / closing)))
            }),
            OfTarget::Headway => spread(values, &|r, _, _| {
                let ego = own_speed[r.frame];
                joint(r.place / ego, number(Some(values[r.row])) * ego_speed[r.frame] / ego)
            }),
        };
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
