//! What all adapters do with a source: find it, name the drive, hash the input, report impossible speeds.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, Diagnostic, DriveId};

/// Codes that several adapters use.
pub(crate) const CODES: &[&str] = &[
    "ingest.speed.impossible",
    "ingest.rate.resampled",
    "ingest.time.span",
    "ingest.time.step",
    "ingest.objects.unused",
    "ingest.objects.unobserved",
    "ingest.drive.renamed",
];

/// Hash of everything that a drive is made from: adapter and its revision, options, names and contents of files.
/// Equal hashes mean an equal drive, so a lake need not write it again.
pub(crate) struct ContentHash(blake3::Hasher);

impl ContentHash {
    pub fn new(format: &str, revision: u32) -> Self {
        let mut h = Self(blake3::Hasher::new());
        h.add("format", format.as_bytes());
        h.add("revision", &revision.to_le_bytes());
        h
    }

    pub fn add(&mut self, name: &str, content: &[u8]) {
        // Lengths first, so that no two lists of parts run together into the same bytes.
        for part in [name.as_bytes(), content] {
            self.0.update(&(part.len() as u64).to_le_bytes());
            self.0.update(part);
        }
    }

    pub fn finish(self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// How far below a named folder sources are looked for.
pub(crate) const SEARCH_DEPTH: usize = 8;

/// What is directly in a folder. Nothing where the folder cannot be listed: what is beside it is still found, and
/// [`crate::leftover::unreadable`] reports it once for all formats.
pub(crate) fn entries(dir: &Path) -> impl Iterator<Item = PathBuf> {
    fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path())
}

/// Folders at or below `path` that `is_source` accepts, sorted. What is inside one is not searched.
pub(crate) fn find_folders(path: &Path, is_source: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    fn search(dir: &Path, depth: usize, is_source: &dyn Fn(&Path) -> bool, out: &mut Vec<PathBuf>) {
        if is_source(dir) {
            out.push(dir.to_owned());
        } else if depth > 0 {
            let folders = entries(dir).filter(|path| path.is_dir());
            folders.for_each(|path| search(&path, depth - 1, is_source, out));
        }
    }
    let mut out = Vec::new();
    if path.is_dir() {
        search(path, SEARCH_DEPTH, &is_source, &mut out);
    }
    out.sort();
    out
}

/// Files at or below `path` that `is_source` accepts, sorted.
pub(crate) fn find_files(path: &Path, is_source: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    fn search(path: &Path, depth: usize, is_source: &dyn Fn(&Path) -> bool, out: &mut Vec<PathBuf>) {
        if path.is_file() {
            if is_source(path) {
                out.push(path.to_owned());
            }
        } else if depth > 0 {
            entries(path).for_each(|entry| search(&entry, depth - 1, is_source, out));
        }
    }
    let mut out = Vec::new();
    // A file directly in the named folder is one level down already.
    search(path, SEARCH_DEPTH + 1, &is_source, &mut out);
    out.sort();
    out
}

/// The last part of a path, as text.
pub(crate) fn file_label(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A drive id from a name: what is not safe in a folder name becomes `-`. A name that loses letters or digits so (of
/// other scripts) keeps its identity by the first eight digits of its hash.
pub(crate) fn drive_id(name: &str) -> DriveId {
    const MOST: usize = DriveId::MOST_CHARS;
    let is_safe = DriveId::is_folder_safe_char;
    let id: String = name.chars().map(|c| if is_safe(c) { c } else { '-' }).take(MOST).collect();
    if name.chars().any(|c| !is_safe(c) && c.is_alphanumeric()) {
        let kept = id.trim_matches(['-', '.']);
        let kept = if kept.is_empty() { "drive" } else { &kept[..kept.len().min(MOST - 9)] };
        return DriveId::from(format!("{kept}-{}", &blake3::hash(name.as_bytes()).to_hex()[..8]).as_str());
    }
    let id = id.trim_start_matches('.');
    DriveId::from(if id.is_empty() { "drive" } else { id })
}

/// A note where a drive cannot have the name that its log states.
pub(crate) fn renamed(file: &str, name: &str, id: &DriveId) -> Option<Diagnostic> {
    let message = Bilingual::new(
        format!("行程编号只能含字母、数字与 - _ .：'{name}' 存为 '{id}'"),
        format!("ids of drives have letters, digits and - _ . only: '{name}' is stored as '{id}'"),
    );
    (id.0 != name).then(|| Diagnostic::note("ingest.drive.renamed", message).in_file(file))
}

/// Impossible speeds by track; no diagnostic if there are none.
pub(crate) fn impossible_speeds(file: &str, rows_by_track: &BTreeMap<String, usize>) -> Option<Diagnostic> {
    let (track, _) = rows_by_track.first_key_value()?;
    let (rows, tracks) = (rows_by_track.values().sum::<usize>(), rows_by_track.len());
    let message = Bilingual::new(
        format!("{tracks} 条轨迹的 {rows} 行速度不可能；其速度与加速度记为未知；例如 {track}"),
        format!(
            "{rows} rows of {tracks} tracks have impossible speeds; their speed and acceleration are set to unknown; for example {track}"
        ),
    );
    Some(Diagnostic::warning("ingest.speed.impossible", message).in_file(file))
}

/// Longest drive, s: one day. Frames are made for the whole span, so one wrong time would make millions.
const MAX_DRIVE_S: f64 = 86_400.0;

/// A recording of a drive has no shorter mean step, s (2.5 kHz), and no longer median step, s (pauses do not count).
/// Others are times in another unit than stated.
const LEAST_STEP_S: f64 = 4e-4;
const GREATEST_STEP_S: f64 = 10.0;

/// A diagnostic when `samples` times from `first` to `last` (s) cannot be those of one drive; then nothing can be kept.
pub(crate) fn implausible_span(file: &str, first: f64, last: f64, samples: usize) -> Option<Diagnostic> {
    let span = last - first;
    if span <= MAX_DRIVE_S {
        let step = span / samples.saturating_sub(1) as f64;
        return (samples >= 3 && step < LEAST_STEP_S).then(|| wrong_unit(file, step));
    }
    let days = span / 86_400.0;
    let message = Bilingual::new(
        format!("时间跨度为 {days:.1} 天，超过一天：至少有一个时间是错的"),
        format!("its times span {days:.1} days, more than one day: at least one of them is wrong"),
    );
    let hint = Bilingual::new(
        "修正日志中的时间，或把日志切分成行程",
        "correct the times in the log, or cut it into drives",
    );
    Some(Diagnostic::error("ingest.time.span", message).with_hint(hint).in_file(file))
}

/// A diagnostic when the median step of a log, s, is none of a recording of a drive; then nothing can be kept.
pub(crate) fn implausible_step(file: &str, step: f64) -> Option<Diagnostic> {
    (step > GREATEST_STEP_S).then(|| wrong_unit(file, step))
}

fn wrong_unit(file: &str, step: f64) -> Diagnostic {
    let message = Bilingual::new(
        format!("相邻时刻相隔 {step:.3e} s，不可能是行车记录：时间的单位有误"),
        format!("its times are {step:.3e} s apart, which no recording of a drive is: their unit is wrong"),
    );
    let hint = Bilingual::new(
        "检查时间的单位（s、ms、µs、ns）与列名或映射文件所写的是否一致",
        "check that the unit of the times (s, ms, us, ns) is the one that the column or the mapping states",
    );
    Diagnostic::error("ingest.time.step", message).with_hint(hint).in_file(file)
}

/// The log's own rate was not 10 Hz.
pub(crate) fn resampled(file: &str, native_step_s: f64) -> Diagnostic {
    let hz = 1.0 / native_step_s;
    let message = Bilingual::new(
        format!("日志的频率为 {hz:.1} Hz；已线性插值到 10 Hz"),
        format!("the log is at {hz:.1} Hz; it was interpolated linearly to 10 Hz"),
    );
    Diagnostic::note("ingest.rate.resampled", message).in_file(file)
}
