//! The motion of another road user relative to the ego's path, around a keyframe. Distances are from the path that the
//! ego drives: along it from the ego on (`target.path_longitudinal`) and across it, left positive
//! (`target.path_lateral`).

use super::Driven;
use std::ops::RangeInclusive;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{TrackId, Tri};

/// Maximum distance from the path at which an object's center is on it, m.
const ON_PATH_M: f64 = 1.8;
/// Frames in which a crossing is searched: 12 s.
const CROSSES_FRAMES: usize = 120;

/// Another road user, around the keyframe.
#[derive(Clone, Copy)]
pub(crate) struct Other<'r> {
    w: Driven<'r>,
    span: &'r TargetSpan,
}

/// Which of two gets first to the point where their paths meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum First {
    Other,
    Ego,
    /// The other does not come onto the path of the ego.
    Neither,
}

/// Direction in which an object moves along the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moves {
    Still,
    Along,
    Against,
    Across,
}

impl<'r> Other<'r> {
    pub(crate) fn of(w: &Driven<'r>, id: &TrackId) -> Option<Self> {
        Some(Self { w: *w, span: w.signals.target(id)? })
    }

    pub(crate) fn number(&self, signal: &str, frame: usize) -> Option<f64> {
        let value = self.w.signals.target_columns.get(signal)?.number(self.span.row(frame)?);
        value.filter(|v| !v.is_nan())
    }

    pub(crate) fn flag(&self, signal: &str, frame: usize) -> Tri {
        let row = self.span.row(frame);
        let column = self.w.signals.target_columns.get(signal);
        column.zip(row).map_or(Tri::Unknown, |(c, row)| c.flag(row))
    }

    pub(crate) fn category(&self, signal: &str, frame: usize) -> Option<&'r str> {
        self.w.signals.target_columns.get(signal)?.category(self.span.row(frame)?)
    }

    /// Frame of the keyframe.
    pub(crate) fn keyframe(&self) -> usize {
        self.w.keyframe
    }

    /// Frames from `before` frames before the keyframe to `after` frames after it.
    pub(crate) fn frames(&self, before: usize, after: usize) -> RangeInclusive<usize> {
        let last = self.w.drive.times.len().saturating_sub(1);
        self.w.keyframe.saturating_sub(before)..=(self.w.keyframe + after).min(last)
    }

    /// A flag is true in some frame of `frames`; unknown where it is known in none.
    pub(crate) fn ever(&self, signal: &str, frames: RangeInclusive<usize>) -> Tri {
        let all: Vec<Tri> = frames.map(|f| self.flag(signal, f)).collect();
        if all.iter().any(|t| t.is_true()) {
            Tri::True
        } else if all.contains(&Tri::False) {
            Tri::False
        } else {
            Tri::Unknown
        }
    }

    /// The minimum of a number in `frames`.
    pub(crate) fn least(&self, signal: &str, frames: RangeInclusive<usize>) -> Option<f64> {
        frames.filter_map(|f| self.number(signal, f)).min_by(f64::total_cmp)
    }

    pub(crate) fn moves(&self, frame: usize) -> Option<Moves> {
        match self.category("target.moves_along", frame)? {
            "still" => Some(Moves::Still),
            "along" => Some(Moves::Along),
            "against" => Some(Moves::Against),
            "across" => Some(Moves::Across),
            _ => None,
        }
    }

    /// Distance across the path, m; never negative.
    pub(crate) fn aside(&self, frame: usize) -> Option<f64> {
        self.number("target.path_lateral", frame).map(f64::abs)
    }

    /// The minimum distance across the path in `frames`, m.
    pub(crate) fn nearest_aside(&self, frames: RangeInclusive<usize>) -> Option<f64> {
        frames.filter_map(|f| self.aside(f)).min_by(f64::total_cmp)
    }

    /// Decrease of its distance from the path from 1 s before the keyframe to 2 s after it, m.
    pub(crate) fn comes_nearer(&self) -> Option<f64> {
        let frames = self.frames(10, 20);
        let mut known = frames.filter_map(|f| self.aside(f));
        let before = known.next()?;
        Some(before - known.next_back().unwrap_or(before))
    }

    /// Which one gets first to where the two paths meet after the keyframe, as recorded; `None` where it is not known.
    pub(crate) fn first(&self) -> Option<First> {
        let mut known = false;
        for f in self.frames(0, CROSSES_FRAMES) {
            let Some((across, along)) =
                self.number("target.path_lateral", f).zip(self.number("target.path_longitudinal", f))
            else {
                continue;
            };
            known = true;
            if across.abs() < ON_PATH_M {
                return Some(if along > 0.0 { First::Other } else { First::Ego });
            }
        }
        known.then_some(First::Neither)
    }

    /// It was on the path before the keyframe and has left it.
    pub(crate) fn is_through(&self) -> bool {
        let away = self.aside(self.w.keyframe).is_some_and(|a| a > ON_PATH_M);
        let was = self.frames(40, 0).filter_map(|f| self.aside(f)).any(|a| a < ON_PATH_M);
        away && was && self.comes_nearer().is_some_and(|m| m < 0.0)
    }
}
