//! The arrays of a route's segments, joined in the order of time. What cannot be read is reported and left out.

use super::findings;
use crate::assemble::se3::unit;
use crate::encodings::input::Folder;
use crate::encodings::npy::{self, ByteStrings, Table};
use crate::report::{RowCount, SourceReport};
use crate::source::ContentHash;

/// Everything that is read of a route. Times are seconds since the device booted.
#[derive(Default)]
pub(super) struct Recording {
    pub pose: Pose,
    pub can: RawCan,
    /// Times, steering wheel angle in degrees, left positive.
    pub steering: (Vec<f64>, Vec<f64>),
    /// Times, the car's own speed in m/s.
    pub speed: (Vec<f64>, Vec<f64>),
    pub radar: Vec<RadarRow>,
}

/// Camera poses, ascending in time.
#[derive(Default)]
pub(super) struct Pose {
    pub times: Vec<f64>,
    /// Earth-centered, m.
    pub positions: Vec<[f64; 3]>,
    /// Earth-centered, m/s.
    pub velocities: Vec<[f64; 3]>,
    /// w, x, y, z.
    pub orientations: Vec<[f64; 4]>,
    /// GPS week and second of the first pose.
    pub gps_of_first: Option<(f64, f64)>,
}

/// Bus frames as recorded.
#[derive(Default)]
pub(super) struct RawCan {
    pub times: Vec<f64>,
    pub sources: Vec<i64>,
    pub addresses: Vec<i64>,
    /// Data of each segment's frames with the number of its first, ascending.
    data: Vec<(usize, ByteStrings)>,
}

impl RawCan {
    /// Data of frame `i`.
    pub fn frame(&self, i: usize) -> &[u8] {
        let segment = self.data.partition_point(|(first, _)| *first <= i) - 1;
        let (first, data) = &self.data[segment];
        data.row(i - first)
    }
}

/// One radar return.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RadarRow {
    pub time: f64,
    /// From the front bumper forward, m.
    pub forward_m: f64,
    /// To the left, m.
    pub left_m: f64,
    /// Rate of `forward_m`, m/s.
    pub relative_speed_mps: f64,
    /// The radar's slot for the target.
    pub slot: u32,
    /// The slot holds another target than before.
    pub is_new: bool,
}

impl Recording {
    pub fn read(segments: &[Folder<'_>], hash: &mut ContentHash, report: &mut SourceReport) -> Self {
        let mut recording = Recording::default();
        let mut poses = RowCount::new("pose");
        for &segment in segments {
            recording.read_segment(segment, hash, report, &mut poses);
        }
        report.tables.push(poses);
        recording.radar.sort_by(|a, b| a.time.total_cmp(&b.time));
        recording
    }

    fn read_segment(
        &mut self,
        dir: Folder<'_>,
        hash: &mut ContentHash,
        report: &mut SourceReport,
        poses: &mut RowCount,
    ) {
        let mut file = Files { dir, hash, report };
        if let [Some(t), Some(p), Some(v), Some(q)] = ["times", "positions", "velocities", "orientations"]
            .map(|n| file.numbers(&format!("global_pose/frame_{n}")))
        {
            if [&p, &v, &q].iter().any(|a| a.rows() != t.rows())
                || (p.columns, v.columns, q.columns) != (3, 3, 4)
            {
                file.report.diagnostics.push(findings::shape(&dir.label("global_pose")));
            } else {
                let gps = file
                    .numbers("global_pose/frame_gps_times")
                    .filter(|g| g.columns == 2 && g.rows() == t.rows());
                self.pose.append(&t, &p, &v, &q, gps.as_ref(), poses);
            }
        }
        for (name, series) in [("steering_angle", &mut self.steering), ("speed", &mut self.speed)] {
            let folder = format!("processed_log/CAN/{name}");
            let [Some(t), Some(v)] = ["t", "value"].map(|n| file.numbers(&format!("{folder}/{n}"))) else {
                continue;
            };
            if v.columns == 1 && v.rows() == t.rows() {
                series.0.extend(t.column(0));
                series.1.extend(v.column(0));
            } else {
                file.report.diagnostics.push(findings::shape(&dir.label(&folder)));
            }
        }
        if let [Some(t), Some(v)] =
            ["t", "value"].map(|n| file.numbers(&format!("processed_log/CAN/radar/{n}")))
        {
            if v.columns == 7 && v.rows() == t.rows() {
                self.radar.extend((0..v.rows()).map(|i| radar_row(t.row(i)[0], v.row(i))));
            } else {
                file.report.diagnostics.push(findings::shape(&dir.label("processed_log/CAN/radar")));
            }
        }
        if let [Some(t), Some(s), Some(a)] =
            ["t", "src", "address"].map(|n| file.numbers(&format!("processed_log/CAN/raw_can/{n}")))
            && let Some(data) = file.bytes("processed_log/CAN/raw_can/data")
        {
            if [s.rows(), a.rows(), data.rows()] == [t.rows(); 3] {
                self.can.data.push((self.can.times.len(), data));
                self.can.times.extend(t.column(0));
                self.can.sources.extend(s.column(0).iter().map(|&x| x as i64));
                self.can.addresses.extend(a.column(0).iter().map(|&x| x as i64));
            } else {
                file.report.diagnostics.push(findings::shape(&dir.label("processed_log/CAN/raw_can")));
            }
        }
    }
}

fn radar_row(time: f64, v: &[f64]) -> RadarRow {
    RadarRow {
        time,
        forward_m: v[0],
        left_m: v[1],
        relative_speed_mps: v[2],
        slot: v[5] as u32,
        is_new: v[6] != 0.0,
    }
}

impl Pose {
    fn append(
        &mut self,
        t: &Table,
        p: &Table,
        v: &Table,
        q: &Table,
        gps: Option<&Table>,
        count: &mut RowCount,
    ) {
        count.read += t.rows();
        for i in 0..t.rows() {
            let time = t.row(i)[0];
            let three = |a: &Table| std::array::from_fn(|j| a.row(i)[j]);
            let (position, velocity): ([f64; 3], [f64; 3]) = (three(p), three(v));
            let rotation = unit(std::array::from_fn(|j| q.row(i)[j]));
            if !(time.is_finite() && position.iter().chain(&velocity).all(|x| x.is_finite())) {
                count.drop_rows("invalid", 1);
                continue;
            }
            let Some(rotation) = rotation else {
                count.drop_rows("invalid", 1);
                continue;
            };
            if self.times.last().is_some_and(|&last| time <= last) {
                count.drop_rows(
                    if self.times.last() == Some(&time) { "duplicate" } else { "out_of_order" },
                    1,
                );
                continue;
            }
            if self.times.is_empty() {
                self.gps_of_first =
                    gps.map(|g| (g.row(i)[0], g.row(i)[1])).filter(|g| g.0.is_finite() && g.1.is_finite());
            }
            self.times.push(time);
            self.positions.push(position);
            self.velocities.push(velocity);
            self.orientations.push(rotation);
            count.keep("pose", 1);
        }
    }
}

/// Reads arrays of one segment, hashing what it reads. A missing file is allowed, a broken one is reported.
struct Files<'a> {
    dir: Folder<'a>,
    hash: &'a mut ContentHash,
    report: &'a mut SourceReport,
}

impl Files<'_> {
    fn numbers(&mut self, name: &str) -> Option<Table> {
        self.read(name, npy::numbers)
    }

    fn bytes(&mut self, name: &str) -> Option<ByteStrings> {
        self.read(name, npy::byte_strings)
    }

    /// Each file is read once: the same bytes are hashed and parsed.
    fn read<T>(&mut self, name: &str, parse: impl Fn(&[u8]) -> Result<T, String>) -> Option<T> {
        let read = self.dir.file(name)?.bytes().map_err(|e| e.to_string()).and_then(|content| {
            self.hash.add(name, &content);
            parse(&content)
        });
        read.map_err(|e| self.report.diagnostics.push(findings::unreadable(&self.dir.label(name), &e))).ok()
    }
}
