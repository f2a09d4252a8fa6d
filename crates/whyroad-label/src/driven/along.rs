//! The course of the ego's speed after a keyframe, and which longitudinal decisions it supports (LABELING.md 2).

use super::{Driven, STANDSTILL_MPS, Speeds};
use whyroad_model::Tri;
use whyroad_model::decision::Longitudinal;

/// Minimum change of speed that is not noise, m/s.
pub(crate) const PLAIN_MPS: f64 = 1.5;
/// Minimum change of speed that an annotator cannot overlook, m/s.
pub(crate) const LARGE_MPS: f64 = 3.0;
/// Variation of a car that keeps its speed, m/s.
pub(crate) const STEADY_MPS: f64 = 0.5;
/// Share of the speed at the keyframe: a car below it is about to stop.
pub(crate) const NEARLY_STOPPED: f64 = 0.5;

/// Minimum change of speed that is an action: this share of the speed, at least this, m/s, ...
const ACTION_SHARE: f64 = 0.06;
const ACTION_MPS: f64 = 0.8;
/// ... and at least this where the ego hardly moves, m/s.
const ACTION_SLOW_MPS: f64 = 0.4;
/// Below this speed the ego hardly moves, m/s.
const HARDLY_MOVES_MPS: f64 = 2.0;
/// An action is visible within this many frames after the keyframe.
const ACTION_FRAMES: usize = 35;
/// A speed is held if it stays within this share, and within this, m/s.
const HELD_SHARE: f64 = 0.1;
const HELD_MPS: f64 = 0.8;
/// Frames over which a speed must be held: 3 s.
const HELD_FRAMES: usize = 30;
/// Frames before the keyframe over which a change of speed is under way, or a standstill ends, and the minimum of the
/// change, m/s, for separating it from a response to what is seen at the keyframe.
const BEFORE_FRAMES: usize = 10;
const ANSWER_MPS: f64 = 0.45;
/// A change that continues after the keyframe and gets stronger by this is a response to it, m/s2.
const STRONGER_MPS2: f64 = 1.2;
/// A change that begins shortly before the keyframe and changes by this times as much after it is a response to it.
const MOST_TO_COME: f64 = 2.0;
/// Frames after the keyframe over which its strength is measured.
const STRENGTH_FRAMES: usize = 15;
/// Maximum number of frames after the keyframe at which an earlier change ends, if the next change is the first new
/// action.
const ENDS_FRAMES: usize = 10;
/// Below this speed the ego nearly stands, m/s.
const NEARLY_STANDS_MPS: f64 = 0.6;

/// How a decision contradicts the recorded motion: speeds in m/s, and their frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Conflict {
    /// It only gets faster.
    SpeedsUp { to: f64, frame: usize },
    /// It stands at the keyframe, where it cannot slow any more, and only gets faster.
    MovesOff { to: f64, frame: usize },
    /// It only gets slower.
    Slows { to: f64, frame: usize },
    /// It does not come to a stop.
    NoStop { lowest: f64, frame: usize },
    /// It comes to a stop.
    Stops { frame: usize },
    /// There is no lead.
    NoLead,
    /// It is not stationary at the keyframe.
    Moves,
    /// It does not move off.
    Stays,
    /// It keeps its speed.
    Unchanged { min: f64, max: f64 },
    /// It clearly acts although nothing is decided.
    Changes { to: f64, frame: usize },
}

/// The speed at the keyframe and the speeds in the 6 s after it; `None` where they are not known for 2 s.
pub(crate) fn known_speeds(w: &Driven<'_>) -> Option<(f64, Speeds)> {
    w.speed(w.keyframe).zip(w.speeds(w.keyframe..w.end).filter(|_| w.lasts(2.0)))
}

/// The contradiction between `decision` and the recorded motion; `None` where speeds are not known for 2 s.
pub(crate) fn conflict(w: &Driven<'_>, decision: Option<Longitudinal>) -> Option<Conflict> {
    let (v0, all) = known_speeds(w)?;
    let Some(decision) = decision else { return undecided(w, v0) };
    let stands = v0 < STANDSTILL_MPS;
    let only_faster = all.min > v0 - STEADY_MPS && all.max > v0 + PLAIN_MPS;
    let faster = only_faster.then_some(Conflict::SpeedsUp { to: all.max, frame: all.max_at });
    // An ego that stands goes on standing: no decision (LABELING.md 2, null).
    let steady = w.lasts(6.0) && all.max - all.min < STEADY_MPS;
    let unchanged = steady.then_some(Conflict::Unchanged { min: all.min, max: all.max });
    let stood =
        stands && w.speed(w.keyframe.saturating_sub(BEFORE_FRAMES)).is_some_and(|v| v < STANDSTILL_MPS);
    match decision {
        Longitudinal::StopForRegulation | Longitudinal::StopForObstacle if stood && steady => unchanged,
        Longitudinal::StopForRegulation | Longitudinal::StopForObstacle => faster.or_else(|| {
            let range = w.speeds(w.keyframe..w.range_end)?;
            let slows_still = range.last < NEARLY_STOPPED * v0 && range.last <= range.min + STEADY_MPS;
            let no_stop = range.min >= STANDSTILL_MPS && !slows_still && w.lasts(6.0);
            no_stop.then_some(Conflict::NoStop { lowest: range.min, frame: range.min_at })
        }),
        // An ego that has stopped to give way before the keyframe can only move off.
        Longitudinal::YieldToAgent if only_faster && v0 < STEADY_MPS => {
            Some(Conflict::MovesOff { to: all.max, frame: all.max_at })
        }
        Longitudinal::YieldToAgent | Longitudinal::RoadSpeedAdaptation => faster.or(unchanged),
        Longitudinal::LeadFollowing => {
            let known = |f: &usize| w.flag("lead.exists", *f) != Tri::Unknown;
            let frames = w.keyframe.saturating_sub(10)..w.end;
            let none = frames.clone().all(|f| w.flag("lead.exists", f) == Tri::False);
            (none && frames.filter(known).count() > 20).then_some(Conflict::NoLead)
        }
        Longitudinal::SetSpeedTracking => {
            let stops = all.min < STANDSTILL_MPS && v0 > LARGE_MPS;
            stops.then_some(Conflict::Stops { frame: all.min_at })
        }
        Longitudinal::Resume => {
            let from = w.keyframe.saturating_sub(10);
            let moving = w.speeds(from..w.keyframe + 1).is_some_and(|s| s.min > 1.0);
            if moving && all.min > 1.0 {
                Some(Conflict::Moves)
            } else {
                (all.max < 0.5 && w.lasts(6.0)).then_some(Conflict::Stays)
            }
        }
        Longitudinal::AccelerationForPassing => {
            let slows = all.max < v0 + STEADY_MPS && all.min < v0 - PLAIN_MPS;
            slows.then_some(Conflict::Slows { to: all.min, frame: all.min_at }).or(unchanged)
        }
        Longitudinal::GapMatching => None,
    }
}

/// The ego plainly does what `decision` says: it slows, stops, starts or speeds up so that nobody can overlook it.
pub(crate) fn shows(w: &Driven<'_>, decision: Longitudinal) -> bool {
    let Some((v0, all)) = known_speeds(w) else { return false };
    if conflict(w, Some(decision)).is_some() {
        return false;
    }
    match decision {
        Longitudinal::YieldToAgent | Longitudinal::RoadSpeedAdaptation => all.min <= v0 - LARGE_MPS,
        Longitudinal::StopForRegulation | Longitudinal::StopForObstacle => {
            v0 >= LARGE_MPS && all.min < STANDSTILL_MPS
        }
        Longitudinal::Resume => v0 < STANDSTILL_MPS && all.max >= PLAIN_MPS,
        Longitudinal::AccelerationForPassing => all.max >= v0 + LARGE_MPS,
        Longitudinal::SetSpeedTracking | Longitudinal::LeadFollowing | Longitudinal::GapMatching => false,
    }
}

/// Nothing is decided, although the ego clearly changes its speed at once.
fn undecided(w: &Driven<'_>, v0: f64) -> Option<Conflict> {
    let soon = w.speeds(w.keyframe..(w.keyframe + 31).min(w.end))?;
    // Gaining speed after a turn or a stop is ordinary; starting from standstill, or nearly, now or a moment ago, is
    // not.
    let begin = w.keyframe.saturating_sub(BEFORE_FRAMES);
    let stood = w.speeds(begin..w.keyframe + 1).is_some_and(|s| s.min < STANDSTILL_MPS);
    let starts = stood || v0 < NEARLY_STANDS_MPS;
    let (to, frame) = if starts { (soon.max, soon.max_at) } else { (soon.min, soon.min_at) };
    // A change that was under way at the keyframe, and gets no stronger, is not a new decision.
    let underway = is_underway(w, if starts { Trend::Rises } else { Trend::Falls });
    (!underway && (to - v0).abs() >= LARGE_MPS).then_some(Conflict::Changes { to, frame })
}

/// Direction in which a speed changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trend {
    Falls,
    Rises,
    /// It stays within about a tenth.
    Holds,
    Unknown,
}

/// A change of speed that is an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Change {
    pub trend: Trend,
    /// The frame from which on the speed changes.
    pub from: usize,
    /// It was under way at the keyframe and does not get stronger: not a response to what is seen there.
    pub is_underway: bool,
}

/// The course of the ego's speed in the seconds after the keyframe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    /// At the keyframe, m/s.
    pub now_mps: f64,
    /// The first clear change that begins after the keyframe or is under way at it.
    pub first: Option<Change>,
    /// The first clear change that is not under way at the keyframe.
    pub new: Option<Change>,
    /// Direction over the next 3 s.
    pub trend: Trend,
    /// It comes to a stop, or nearly, within 6 s.
    pub nearly_stands: bool,
    /// Greatest deceleration within 4 s, over half a second, m/s2.
    pub braking_mps2: f64,
}

impl Course {
    /// The speed is already changing in this direction at the keyframe.
    pub(crate) fn is_underway(&self, trend: Trend) -> bool {
        self.first.is_some_and(|c| c.is_underway && c.trend == trend)
    }

    /// The ego is stationary at the keyframe.
    pub(crate) fn stands(&self) -> bool {
        self.now_mps < STANDSTILL_MPS
    }
}

/// The course of the speed after the keyframe; `None` where it is not known for 2 s.
pub(crate) fn course(w: &Driven<'_>) -> Option<Course> {
    known_speeds(w)?;
    let now_mps = steady_speed(w, w.keyframe)?;
    let first = first_change(w, w.keyframe);
    let new = match first {
        Some(change) if change.is_underway => {
            let end = turning_point(w, change);
            // An ego that first goes on slowing clearly has not decided to speed up yet.
            let goes_on = change.trend == Trend::Falls
                && steady_speed(w, end).is_some_and(|v| v < now_mps - action(now_mps));
            let ends = end <= w.keyframe + ENDS_FRAMES && !goes_on;
            first_change(w, end).filter(|c| ends && c.trend != change.trend)
        }
        other => other,
    };
    let new = new.map(|c| Change { is_underway: false, ..c });
    let per_half = |f: usize| Some((w.speed(f)? - w.speed(f + 5)?) / 0.5);
    let soon = w.keyframe..(w.keyframe + 40).min(w.end.saturating_sub(5));
    Some(Course {
        now_mps,
        first,
        new,
        trend: trend(w, now_mps),
        nearly_stands: nearly_stands(w),
        braking_mps2: soon.filter_map(per_half).fold(0.0, f64::max),
    })
}

/// The speed falls to nearly zero before it rises again.
fn nearly_stands(w: &Driven<'_>) -> bool {
    let mut low = f64::INFINITY;
    for v in (w.keyframe..w.end).filter_map(|f| steady_speed(w, f)) {
        low = low.min(v);
        if low < NEARLY_STANDS_MPS || v > low + ACTION_MPS {
            break;
        }
    }
    low < NEARLY_STANDS_MPS
}

/// Minimum change of a speed that is an action, m/s.
fn action(mps: f64) -> f64 {
    if mps < HARDLY_MOVES_MPS { ACTION_SLOW_MPS } else { (ACTION_SHARE * mps).max(ACTION_MPS) }
}

/// The first change from `from` on that is as large as an action.
fn first_change(w: &Driven<'_>, from: usize) -> Option<Change> {
    let v0 = steady_speed(w, from)?;
    let threshold = action(v0);
    let (mut low, mut high) = ((v0, from), (v0, from));
    for f in from..(from + ACTION_FRAMES + 1).min(w.end) {
        let Some(v) = steady_speed(w, f) else { continue };
        if v <= low.0 {
            low = (v, f);
        }
        if v >= high.0 {
            high = (v, f);
        }
        let found = if v <= high.0 - threshold {
            Some((Trend::Falls, high.1))
        } else if v >= low.0 + threshold {
            Some((Trend::Rises, low.1))
        } else {
            None
        };
        if let Some((trend, began)) = found {
            let is_underway = from == w.keyframe && began <= from + 3 && is_underway(w, trend);
            return Some(Change { trend, from: (began + 1).min(f), is_underway });
        }
    }
    None
}

/// The speed changed in the same direction before the keyframe, and not much less.
fn is_underway(w: &Driven<'_>, trend: Trend) -> bool {
    let sign = if trend == Trend::Falls { -1.0 } else { 1.0 };
    let of =
        |a: usize, b: usize| Some(sign * (steady_speed(w, b)? - steady_speed(w, a)?) * 10.0 / (b - a) as f64);
    let Some(before) = w.keyframe.checked_sub(BEFORE_FRAMES).and_then(|f| of(f, w.keyframe)) else {
        return false;
    };
    // A change that began within that second may be the response, slightly early.
    let (begin, middle) = (w.keyframe - BEFORE_FRAMES, w.keyframe - BEFORE_FRAMES / 2);
    let all_along = of(begin, middle).is_none_or(|v| v > ANSWER_MPS / 2.0);
    let after = of(w.keyframe, w.keyframe + STRENGTH_FRAMES).unwrap_or(before);
    before > ANSWER_MPS
        && all_along
        && after < before + STRONGER_MPS2
        && !is_just_beginning(w, trend, sign, before)
}

/// The change began within the second before the keyframe, and most of it comes after: the response, slightly early.
fn is_just_beginning(w: &Driven<'_>, trend: Trend, sign: f64, before: f64) -> bool {
    let Some(begin) = w.keyframe.checked_sub(2 * BEFORE_FRAMES) else { return false };
    let speeds = steady_speed(w, begin).zip(steady_speed(w, w.keyframe - BEFORE_FRAMES));
    let earlier = speeds.map(|(a, b)| sign * (b - a));
    let Some(now) = steady_speed(w, w.keyframe) else { return false };
    let end = turning_point(w, Change { trend, from: w.keyframe, is_underway: true });
    // An ego that stops cannot lose more than it has.
    let most = |v: f64| {
        let to_come = sign * (v - now);
        to_come > MOST_TO_COME * before || (v < NEARLY_STANDS_MPS && to_come > before)
    };
    earlier.is_some_and(|v| v < ANSWER_MPS / 2.0) && steady_speed(w, end).is_some_and(most)
}

/// The frame in which a change that is under way ends: its extreme.
fn turning_point(w: &Driven<'_>, change: Change) -> usize {
    let mut extreme = (steady_speed(w, change.from).unwrap_or(f64::NAN), change.from);
    for f in change.from..w.end {
        let Some(v) = steady_speed(w, f) else { continue };
        let goes_on = if change.trend == Trend::Falls { v <= extreme.0 } else { v >= extreme.0 };
        if goes_on {
            extreme = (v, f);
        } else if (v - extreme.0).abs() > ACTION_SLOW_MPS {
            break;
        }
    }
    extreme.1
}

/// The speed without outliers of a single frame: the median of three.
fn steady_speed(w: &Driven<'_>, frame: usize) -> Option<f64> {
    let here = w.speed(frame)?;
    let (Some(a), Some(b)) = (frame.checked_sub(1).and_then(|f| w.speed(f)), w.speed(frame + 1)) else {
        return Some(here);
    };
    Some(here.clamp(a.min(b), a.max(b)))
}

/// The direction of the speed over the next 3 s: by which side it leaves a tenth of itself, about 1 s and 2.5 s after
/// the keyframe; unknown where these differ.
fn trend(w: &Driven<'_>, now: f64) -> Trend {
    let held = (HELD_SHARE * now).max(if now < HARDLY_MOVES_MPS { ACTION_SLOW_MPS } else { HELD_MPS });
    let change = |from: usize, to: usize| {
        let known: Vec<f64> = (w.keyframe + from..=w.keyframe + to).filter_map(|f| w.speed(f)).collect();
        (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64 - now)
    };
    let goes = |d: Option<f64>| match d {
        Some(d) if d < -held => Trend::Falls,
        Some(d) if d > held => Trend::Rises,
        _ => Trend::Holds,
    };
    let (soon, later) = (change(5, 15), change(20, HELD_FRAMES));
    // It falls and rises again, or the other way round.
    let turns = soon.zip(later).is_some_and(|(soon, later)| soon * later < 0.0);
    match (goes(soon), goes(later)) {
        (Trend::Falls | Trend::Rises, Trend::Holds) if turns => Trend::Unknown,
        (soon, Trend::Holds) => soon,
        (Trend::Holds, later) => later,
        (soon, later) if soon == later => later,
        _ => Trend::Unknown,
    }
}
