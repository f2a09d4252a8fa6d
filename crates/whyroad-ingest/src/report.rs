//! What an ingest did: rows read, kept, set aside and dropped, by reason, for every source. Counts add up:
//! read = kept + set aside + dropped.

use std::collections::BTreeMap;
use whyroad_lake::WriteOutcome;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Lang, Need, Severity};

/// Why rows are not in the lake, or the types under which they are stored.
pub type Counts = BTreeMap<&'static str, usize>;

/// The rows of one table or file of a source.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RowCount {
    /// `annotations`, `pose`, `map`, `fcd`, ...
    pub table: &'static str,
    /// Rows that the file has.
    pub read: usize,
    /// Rows in the lake, by what they became.
    pub kept: Counts,
    /// Rows left out by design (between frames, while the ego was away).
    pub set_aside: Counts,
    /// Rows lost, by reason.
    pub dropped: Counts,
}

impl RowCount {
    /// Counts of a table, all zero.
    pub fn new(table: &'static str) -> Self {
        Self { table, ..Self::default() }
    }

    /// Number of rows in the lake.
    pub fn kept_total(&self) -> usize {
        self.kept.values().sum()
    }

    /// Number of rows lost.
    pub fn dropped_total(&self) -> usize {
        self.dropped.values().sum()
    }

    /// True when every row is accounted for.
    pub fn adds_up(&self) -> bool {
        self.read == self.kept_total() + self.set_aside.values().sum::<usize>() + self.dropped_total()
    }

    pub(crate) fn keep(&mut self, what: &'static str, rows: usize) {
        add(&mut self.kept, what, rows);
    }
    pub(crate) fn set_aside(&mut self, why: &'static str, rows: usize) {
        add(&mut self.set_aside, why, rows);
    }
    /// Rows that were kept, and that a later check did not use.
    pub(crate) fn set_all_aside(&mut self, why: &'static str) {
        let kept = self.kept_total();
        self.kept.clear();
        self.set_aside(why, kept);
    }
    pub(crate) fn drop_rows(&mut self, why: &'static str, rows: usize) {
        add(&mut self.dropped, why, rows);
    }
}

fn add(counts: &mut Counts, key: &'static str, rows: usize) {
    if rows > 0 {
        *counts.entry(key).or_default() += rows;
    }
}

/// The result of one source: a log folder, a simulation.
#[derive(Clone, Debug, Default)]
pub struct SourceReport {
    /// The name that the user gave.
    pub source: String,
    /// The drive that it became.
    pub drive_id: Option<DriveId>,
    /// What the lake did with it; `None` when there is no drive.
    pub outcome: Option<WriteOutcome>,
    /// Frames of the drive.
    pub frames: usize,
    /// Recorded time: its frames at 10 Hz, s.
    pub duration_s: f64,
    /// Tracked objects.
    pub tracks: usize,
    /// Rows by table.
    pub tables: Vec<RowCount>,
    /// What the log lacks.
    pub missing: Vec<Need>,
    /// Diagnostics for the user.
    pub diagnostics: Vec<Diagnostic>,
}

impl SourceReport {
    /// An empty report.
    pub fn new(source: impl Into<String>) -> Self {
        Self { source: source.into(), ..Self::default() }
    }

    /// True when input was lost: rows dropped, or a part that could not be read.
    pub fn lost_input(&self) -> bool {
        self.tables.iter().any(|t| t.dropped_total() > 0)
            || self.diagnostics.iter().any(|d| d.severity == Severity::Error)
    }
}

/// Counts with their displayed names, as in `invalid values 3, duplicate 1`.
pub fn counts_text(counts: &Counts, lang: Lang) -> String {
    let parts: Vec<String> =
        counts.iter().map(|(key, n)| format!("{} {n}", reason_text(key).get(lang))).collect();
    parts.join(", ")
}

/// The displayed name of a reason or a kind of row.
pub fn reason_text(key: &str) -> Bilingual {
    let (zh, en) = match key {
        "track" => ("轨迹", "tracks"),
        "ego" => ("自车", "ego"),
        "pose" => ("位姿", "poses"),
        "lane" => ("车道", "lanes"),
        "crosswalk" => ("人行横道", "crosswalks"),
        "junction" => ("路口", "junctions"),
        "drivable_area" => ("可行驶区域", "drivable areas"),
        "duplicate" => ("重复", "duplicate"),
        "invalid" => ("数值无效", "invalid values"),
        "no_pose" => ("该时刻没有位姿", "no pose at that time"),
        "not_observed" => ("未观测到", "not observed"),
        "line" => ("标线与路缘", "lines and curbs"),
        "sign" => ("标志", "signs"),
        "facility" => ("设施", "facilities"),
        "no_list" => ("没有对象列表", "no list of objects"),
        "unknown_frame" => ("未知坐标系", "unknown frame"),
        "another_topic" => ("其他主题", "another topic"),
        "not_used" => ("未使用", "not used"),
        "no_such_lane" => ("地图中没有该车道", "of a lane that the map does not have"),
        "no_lane_ends_there" => ("没有车道止于此处", "no lane ends there"),
        "between_frames" => ("在两帧之间", "between frames"),
        "out_of_range" => ("超出感知范围", "out of the sensor's range"),
        "hidden" => ("被其他车辆遮挡", "hidden by other vehicles"),
        "ego_away" => ("自车不在", "while the ego was away"),
        "no_time" => ("没有时间", "no time"),
        "no_id" => ("没有编号", "no id"),
        "no_line" => ("没有线或面", "no line or area"),
        "scenery" => ("景物", "scenery"),
        "unknown_word" => ("不在词表中", "a word that is in no list"),
        "no_position" => ("没有位置", "no position"),
        "static_box" => ("整个文档的静止框", "boxes of no frame (static objects)"),
        "no_heading" => ("没有航向", "no heading"),
        "undecodable" => ("无法解码", "cannot be decoded"),
        "light" => ("灯态", "light states"),
        "state" => ("状态", "states"),
        "stop_line" => ("停止线", "stop lines"),
        "out_of_order" => ("时间倒退", "backward time"),
        "carried" => ("乘坐或装载在车上", "riding in a vehicle, or freight"),
        "not_a_road_user_lane" => ("不是道路车道", "not a lane of the road"),
        other => (other, other),
    };
    Bilingual::new(zh, en)
}
