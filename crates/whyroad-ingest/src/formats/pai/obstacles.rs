//! `obstacle.offline`: boxes of other road users in the rig **at each row's own time**. No row does not mean that
//! nothing was there: a clip without rows has unknown objects.

use super::egomotion::PoseTrack;
use crate::assemble::frames::{Sample, Sampled, median};
use crate::assemble::se3::{self, unit};
use crate::encodings::columns::Columns;
use crate::report::RowCount;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::ObjectClass;

/// Frame of reference of the boxes.
const RIG: &str = "rig";
/// A track whose box center stays within this of the ego's is the ego, m: no other object can be there.
const EGO_REACH_M: [f64; 2] = [1.0, 0.5];

/// What the table has.
#[derive(Default)]
pub(super) struct Obstacles {
    /// Class in the source's words and samples in the frame of the poses, by track.
    pub tracks: BTreeMap<String, (String, Sampled)>,
    pub count: RowCount,
    /// Description of the first row that could not be used.
    pub invalid_example: Option<String>,
    /// Rows by class that the format does not define.
    pub unknown_classes: BTreeMap<String, usize>,
    /// First and last time of a row, s.
    pub span: Option<(f64, f64)>,
}

struct Row {
    time: i64,
    class: String,
    /// In the rig, m.
    center: [f64; 3],
    size: [f64; 3],
    /// Box to rig.
    q: [f64; 4],
}

/// Reads the rows; `ego_centre` is the ego's box center in the rig, m.
pub(super) fn read(table: &Columns, poses: &PoseTrack, ego_center: [f64; 3]) -> Result<Obstacles, String> {
    let times = table.integers("timestamp_us")?;
    let (ids, classes) = (table.texts("track_id")?, table.texts("label_class")?);
    let three = |stem: &str| -> Result<[Vec<f64>; 3], String> {
        let of = |axis: &str| table.numbers(&format!("{stem}_{axis}"));
        Ok([of("x")?, of("y")?, of("z")?])
    };
    let (center, size, axis) = (three("center")?, three("size")?, three("orientation")?);
    let w = table.numbers("orientation_w")?;
    let optional = |name: &str| if table.has(name) { table.texts(name) } else { Ok(vec![None; times.len()]) };
    let (frames, sources) = (optional("reference_frame")?, optional("source")?);
    // Two labelers number their tracks independently.
    let several = sources.iter().flatten().collect::<BTreeSet<_>>().len() > 1;

    let mut out = Obstacles {
        count: RowCount { read: times.len(), ..RowCount::new("obstacles") },
        ..Obstacles::default()
    };
    let mut rows: BTreeMap<String, Vec<Row>> = BTreeMap::new();
    for i in 0..times.len() {
        if frames[i].as_deref().is_some_and(|f| f != RIG) {
            out.count.drop_rows("unknown_frame", 1);
            out.invalid_example.get_or_insert_with(|| format!("row {}", i + 1));
            continue;
        }
        let at = |columns: &[Vec<f64>; 3]| [columns[0][i], columns[1][i], columns[2][i]];
        let q = unit([w[i], axis[0][i], axis[1][i], axis[2][i]]);
        let finite = at(&center).iter().all(|v| v.is_finite());
        let (Some(time), Some(id), Some(q), true) = (times[i], ids[i].as_ref(), q, finite) else {
            out.count.drop_rows("invalid", 1);
            out.invalid_example.get_or_insert_with(|| format!("row {}", i + 1));
            continue;
        };
        let id = match sources[i].as_ref().filter(|_| several) {
            Some(source) => format!("{source}:{id}"),
            None => id.clone(),
        };
        let class = classes[i].clone().unwrap_or_default();
        rows.entry(id).or_default().push(Row { time, class, center: at(&center), size: at(&size), q });
    }
    for (id, mut rows) in rows {
        rows.sort_by_key(|r| r.time);
        let before = rows.len();
        rows.dedup_by_key(|r| r.time);
        out.count.drop_rows("duplicate", before - rows.len());
        if is_ego(&rows, ego_center) {
            out.count.keep("ego", rows.len());
            continue;
        }
        out.add(id, &rows, poses);
    }
    Ok(out)
}

fn is_ego(rows: &[Row], center: [f64; 3]) -> bool {
    (0..2).all(|k| {
        let off: Vec<f64> = rows.iter().map(|r| (r.center[k] - center[k]).abs()).collect();
        median(&off) < EGO_REACH_M[k]
    })
}

impl Obstacles {
    fn add(&mut self, id: String, rows: &[Row], poses: &PoseTrack) {
        let mut sampled = Sampled::default();
        for row in rows {
            let Some(pose) = poses.at(row.time) else {
                self.count.drop_rows("no_pose", 1);
                continue;
            };
            let time = row.time as f64 / 1e6;
            self.span = Some(self.span.map_or((time, time), |(a, b)| (a.min(time), b.max(time))));
            sampled.push(Sample {
                time,
                position: pose.apply(row.center),
                heading: se3::heading(se3::compose(pose.q, row.q)),
                velocity: [f64::NAN; 2],
                size: row.size,
                ..Sample::UNKNOWN
            });
        }
        let (Some(first), false) = (rows.first(), sampled.times.is_empty()) else { return };
        let kept = sampled.times.len();
        if class_of(&first.class).is_none() {
            *self.unknown_classes.entry(first.class.clone()).or_default() += kept;
        }
        self.count.keep("track", kept);
        self.tracks.insert(id, (first.class.clone(), sampled));
    }
}

/// Our class; `None` for a word that the format does not define. `rider` is a person on a two-wheeler, of which the
/// format does not say whether it has a motor.
pub(super) fn class_of(word: &str) -> Option<ObjectClass> {
    Some(match word {
        "automobile" => ObjectClass::Car,
        "heavy_truck" | "trailer" => ObjectClass::Truck,
        "bus" => ObjectClass::Bus,
        "other_vehicle" => ObjectClass::LargeVehicle,
        "person" => ObjectClass::Pedestrian,
        "rider" => ObjectClass::Bicyclist,
        "stroller" => ObjectClass::WheeledPedestrian,
        "animal" => ObjectClass::Animal,
        "protruding_object" => ObjectClass::StaticObject,
        _ => return None,
    })
}
