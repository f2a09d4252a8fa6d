//! What is needed to read every table of a drive: the folder, the report, and the drive's clock.

use super::findings;
use super::sheet::{Sheet, sheet_file};
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
    pub fn sheet(
        &mut self,
        stem: &'static str,
        columns: &[&'static str],
        required: &[&[&'static str]],
    ) -> Option<Sheet> {
        let name = sheet_file(self.dir, stem)?;
        let label = self.dir.label(&name);
        let read = self.dir.file(&name)?.bytes().map_err(|e| e.to_string());
        let read = read.and_then(|bytes| {
            self.hash.add(&name, &bytes);
            Sheet::read(&name, &label, bytes.into_owned())
        });
        let sheet = match read {
            Ok(s) => s,
            Err(e) => {
                self.report.diagnostics.push(findings::unreadable(&label, &e));
                return None;
            }
        };
        let names = sheet.names();
        let unknown = names.iter().filter(|n| !columns.contains(&n.as_str()));
        self.report.diagnostics.extend(unknown.map(|n| findings::unknown_column(&label, n, columns)));
        let absent: Vec<_> = required.iter().filter(|any| !any.iter().any(|n| sheet.has(n))).collect();
        self.report.diagnostics.extend(absent.iter().map(|any| findings::missing_column(&label, any)));
        absent.is_empty().then_some(sheet)
    }
}
