//! The ego's motion after a keyframe: the 6 s that follow it (LABELING.md 6), or longer where the label's own range is
//! longer. Used by the checks, which compare a label with its drive, and by drafts.

pub(crate) mod across;
pub(crate) mod along;
pub(crate) mod other;

use whyroad_model::time::frame_at;
use whyroad_model::{Drive, Nanos, SignalTable, TrackId, Tri};

/// Duration after the keyframe that Stage II shows, s.
const FUTURE_S: f64 = 6.0;
/// A longer range is followed only up to this, s.
const LONGEST_S: f64 = 15.0;
/// Below this the ego is at standstill, m/s (schema/signals.yaml, standstill).
pub(crate) const STANDSTILL_MPS: f64 = 0.3;

/// History that Stage I shows, frames: what is a cause was visible in it (LABELING.md 6: 2 s).
pub(crate) const HISTORY_FRAMES: usize = 20;

/// The signals of a drive around a keyframe.
#[derive(Clone, Copy)]
pub(crate) struct Driven<'r> {
    pub drive: &'r Drive,
    pub signals: &'r SignalTable,
    /// Frame of the keyframe.
    pub keyframe: usize,
    /// One past the last frame of the 6 s after it.
    pub end: usize,
    /// One past the end of the label's range, at least `end`.
    pub range_end: usize,
}

impl<'r> Driven<'r> {
    /// The frames after `keyframe` of a drive, up to `range_end`.
    pub fn after(
        drive: &'r Drive,
        signals: &'r SignalTable,
        keyframe: usize,
        range_end: Option<Nanos>,
    ) -> Self {
        let times = &drive.times;
        let at = |s: f64| (frame_at(times, times[keyframe].plus_secs(s)) + 1).min(times.len());
        let range_s =
            range_end.map_or(FUTURE_S, |e| e.seconds_since(times[keyframe]).clamp(FUTURE_S, LONGEST_S));
        Self { drive, signals, keyframe, end: at(FUTURE_S), range_end: at(range_s) }
    }

    /// Time of a frame after the keyframe, s.
    pub fn seconds(&self, frame: usize) -> f64 {
        let times = &self.drive.times;
        times.get(frame).map_or(0.0, |t| t.seconds_since(times[self.keyframe]))
    }

    /// True when the recording continues for `s` seconds after the keyframe.
    pub fn lasts(&self, s: f64) -> bool {
        self.seconds(self.drive.times.len() - 1) >= s - 0.15
    }

    pub fn number(&self, signal: &str, frame: usize) -> Option<f64> {
        self.signals.frame_columns.get(signal)?.number(frame)
    }

    pub fn flag(&self, signal: &str, frame: usize) -> Tri {
        self.signals.frame_columns.get(signal).map_or(Tri::Unknown, |c| c.flag(frame))
    }

    pub fn category(&self, signal: &str, frame: usize) -> Option<&'r str> {
        self.signals.frame_columns.get(signal)?.category(frame)
    }

    /// The object was visible in the history that Stage I shows.
    pub fn was_seen(&self, id: &TrackId) -> bool {
        let history = self.keyframe.saturating_sub(HISTORY_FRAMES)..=self.keyframe;
        self.drive.track(id).is_some_and(|t| t.frames.iter().any(|f| history.contains(&(*f as usize))))
    }

    /// Distance that the ego drives in `s` seconds after the keyframe, m; `None` where the recording or a speed ends
    /// before.
    pub fn distance_m(&self, s: f64) -> Option<f64> {
        let times = &self.drive.times;
        let end = frame_at(times, times[self.keyframe].plus_secs(s)).min(times.len() - 1);
        let step = |f: usize| Some(self.speed(f)? * times[f + 1].seconds_since(times[f]));
        if self.lasts(s) { (self.keyframe..end).map(step).sum() } else { None }
    }

    pub fn speed(&self, frame: usize) -> Option<f64> {
        self.number("ego.speed", frame)
    }

    /// Lowest and highest speed in `frames`, each with its frame; `None` where less than half of it is known.
    pub fn speeds(&self, frames: std::ops::Range<usize>) -> Option<Speeds> {
        let mut out: Option<Speeds> = None;
        let (all, mut known) = (frames.len(), 0);
        for f in frames {
            let Some(v) = self.speed(f) else { continue };
            known += 1;
            let s = out.get_or_insert(Speeds { min: v, min_at: f, max: v, max_at: f, last: v });
            if v < s.min {
                (s.min, s.min_at) = (v, f);
            }
            if v > s.max {
                (s.max, s.max_at) = (v, f);
            }
            s.last = v;
        }
        out.filter(|_| 2 * known >= all)
    }

    /// Change of heading from the keyframe to each frame before `until`, unwrapped, rad; left is positive.
    pub fn heading_changes(&self, until: usize) -> Vec<f64> {
        let Some(ego) = &self.drive.ego else { return Vec::new() };
        let heading = &ego.motion.heading;
        let mut out = Vec::new();
        let (mut sum, mut last) = (0.0, heading.get(self.keyframe).copied().unwrap_or(f64::NAN));
        for h in heading.iter().take(until).skip(self.keyframe) {
            if h.is_nan() {
                continue;
            }
            let turn = turned(last, *h);
            sum += if turn.is_nan() { 0.0 } else { turn };
            last = *h;
            out.push(sum);
        }
        out
    }
}

/// The turn between two headings, the shorter way, rad; left is positive.
pub(crate) fn turned(from: f64, to: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (to - from + PI).rem_euclid(TAU) - PI
}

/// Speeds in a range of frames, m/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speeds {
    pub min: f64,
    pub min_at: usize,
    pub max: f64,
    pub max_at: usize,
    pub last: f64,
}

/// m/s to km/h, for messages.
pub(crate) fn kmh(mps: f64) -> f64 {
    mps * 3.6
}
