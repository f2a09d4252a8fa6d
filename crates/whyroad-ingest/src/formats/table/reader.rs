//! What is needed to read every table of a drive: the folder, the report, and the drive's clock.

use super::layout::columns_of;
use super::mapping::{ColumnSource, Mapping};
use super::sheet::{Sheet, sheet_file};
use super::{findings, mapped};
use crate::assemble::frames::{Frames, every_tenth};
use crate::encodings::input::Folder;
use crate::report::SourceReport;
use crate::source::ContentHash;
use whyroad_model::Nanos;
use whyroad_model::scene::FRAME_RATE_HZ;

/// Between samples at 10 Hz or faster nothing is filled over more than this, s; slower logs: over one and a half of
/// their steps.
const MAX_GAP_S: f64 = 0.25;
const GAP_STEPS: f64 = 1.5;

/// What is needed to read every table.
pub(super) struct Reader<'a> {
    pub dir: Folder<'a>,
    pub hash: ContentHash,
    pub report: &'a mut SourceReport,
    /// Time of `time_s` zero.
    pub start: Nanos,
    /// The user's own, with its name.
    pub mapping: Option<(&'a str, &'a Mapping)>,
}

/// A log's times: frames, and how far apart samples may be to be joined.
pub(super) struct Clock {
    /// ns.
    pub origin: i64,
    /// s since `origin`.
    pub frames: Vec<f64>,
    pub max_gap_s: f64,
}

impl Clock {
    /// Frames from the ego's times (ns, ascending).
    pub fn of(times: &[i64]) -> (Self, Frames) {
        let origin = times.first().copied().unwrap_or_default();
        let clock = Self { origin, frames: Vec::new(), max_gap_s: MAX_GAP_S };
        let seconds: Vec<f64> = times.iter().map(|&t| clock.seconds(t)).collect();
        let mut frames = Frames::of(&seconds);
        // A log whose typical step is 0.1 s but which is not evenly spaced is brought to tenths as well.
        let uneven = seconds.windows(2).any(|w| w[1] - w[0] < 0.5 / FRAME_RATE_HZ);
        if uneven && !frames.resampled() {
            frames.seconds = every_tenth(&seconds);
        }
        let max_gap_s = gap_for(frames.native_step_s);
        if !frames.resampled() {
            frames.seconds = without_short_gaps(&frames.seconds);
        }
        (Self { frames: frames.seconds.clone(), max_gap_s, ..clock }, frames)
    }

    pub fn seconds(&self, time: i64) -> f64 {
        time.saturating_sub(self.origin) as f64 / 1e9
    }
}

/// The times with a frame where one row is lost: it is filled as at any other rate.
fn without_short_gaps(seconds: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(seconds.len());
    for &t in seconds {
        if let Some(&last) = out.last()
            && t - last <= MAX_GAP_S
        {
            let steps = ((t - last) * FRAME_RATE_HZ).round().max(1.0);
            out.extend((1..steps as usize).map(|k| last + (t - last) * k as f64 / steps));
        }
        out.push(t);
    }
    out
}

pub(super) fn gap_for(step_s: f64) -> f64 {
    // `max` passes over NaN.
    (GAP_STEPS * step_s).max(MAX_GAP_S)
}

impl Reader<'_> {
    /// Opens one table of the drive, if it is there and has what it needs.
    pub fn sheet(&mut self, stem: &'static str, required: &[&[&'static str]]) -> Option<Sheet> {
        let files = files_of(self.dir, stem, self.mapping.map(|m| m.1));
        let table = self.mapping.and_then(|(_, mapping)| mapping.tables.get(stem));
        let name = match (&files[..], table.and_then(|t| t.file.as_ref())) {
            ([name], _) => name,
            ([], Some(pattern)) => {
                self.report.diagnostics.push(findings::no_file(&self.dir.own_label(), stem, pattern));
                return None;
            }
            ([], None) => return None,
            (several, _) => {
                let (dir, names) = (self.dir.own_label(), several.join(", "));
                self.report.diagnostics.push(findings::several_files(&dir, stem, &names));
                return None;
            }
        };
        let label = self.dir.label(name);
        let csv = self.mapping.map(|(_, mapping)| mapping.csv).unwrap_or_default();
        let times = table.and_then(|t| match &t.columns.get("timestamp_ns")?.source {
            ColumnSource::Column(name) => Some(name.as_str()),
            _ => None,
        });
        let read = self.dir.file(name)?.bytes().map_err(|e| e.to_string());
        let read = read.and_then(|bytes| {
            self.hash.add(name, &bytes);
            Sheet::read(name, &label, bytes.into_owned(), csv, times.unwrap_or("timestamp_ns"))
        });
        let mut sheet = match read {
            Ok(s) => s,
            Err(e) => {
                self.report.diagnostics.push(findings::unreadable(&label, &e));
                return None;
            }
        };
        let columns = columns_of(stem);
        let out = &mut self.report.diagnostics;
        let mut unknown = sheet.names();
        unknown.retain(|n| !columns.contains(&n.as_str()));
        if let (Some((_, mapping)), Some(table)) = (self.mapping, table) {
            let mapped = mapped::apply(sheet, table, mapping, columns);
            let unread = mapped.unread.join(", ");
            out.extend(mapped.absent.iter().map(|n| findings::mapped_column_absent(&label, n, &unread)));
            sheet = mapped.sheet;
            // The mapping says which columns matter.
            if !table.columns.is_empty() {
                unknown.clear();
                out.extend((!unread.is_empty()).then(|| findings::columns_unread(&label, &unread)));
            }
        }
        out.extend(unknown.iter().map(|n| findings::unknown_column(&label, n, columns)));
        let absent: Vec<_> = required.iter().filter(|any| !any.iter().any(|n| sheet.has(n))).collect();
        out.extend(absent.iter().map(|any| findings::missing_column(&label, any)));
        absent.is_empty().then_some(sheet)
    }
}

/// Files of a table in the folder of a drive: one, unless the pattern of the mapping fits several.
pub(super) fn files_of(dir: Folder<'_>, stem: &str, mapping: Option<&Mapping>) -> Vec<String> {
    match mapping.and_then(|m| m.tables.get(stem)?.file.as_deref()) {
        None => sheet_file(dir, stem).into_iter().collect(),
        Some(name) if !name.contains('*') => dir.has(name).then(|| name.to_owned()).into_iter().collect(),
        Some(pattern) => dir.names().into_iter().filter(|n| fits(n, pattern) && dir.has(n)).collect(),
    }
}

/// True when `name` is `pattern`, in which `*` stands for any text.
fn fits(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((before, after)) => name.strip_prefix(before).is_some_and(|rest| {
            rest.char_indices().map(|(i, _)| i).chain([rest.len()]).any(|i| fits(&rest[i..], after))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn a_star_stands_for_any_text() {
        assert!(
            fits("a_pose.csv", "*_pose.csv") && fits("_pose.csv", "*_pose.csv") && fits("a.csv", "a.csv")
        );
        assert!(
            fits("2026 b pose 1.csv", "*pose*.csv")
                && !fits("pose.parquet", "*pose*.csv")
                && !fits("b.csv", "a.csv")
        );
    }
}
