//! Changes of speed and distance just before the keyframe (`past.*`) and just after it (`soon.*`), to which the
//! conditions of `schema/draft_texts.yaml` refer. A change that needs frames outside of the drive is unknown.

use super::moment::Moment;
use std::ops::RangeInclusive;
use whyroad_model::Tri;

/// Frames before the keyframe over which the ego's change is measured, and those over which another's is.
const EGO_FRAMES: usize = 10;
pub(super) const OTHER_FRAMES: usize = 8;
/// Minimum change of the ego's speed over them, m/s.
const EGO_MPS: f64 = 0.25;
/// Minimum change of another's speed over them, m/s.
const OTHER_MPS: f64 = 0.25;
/// Speeds that differ by less than this are alike, m/s.
pub(super) const ALIKE_MPS: f64 = 0.3;
/// Minimum loss of speed in the second before the keyframe that is visible as hard braking, m/s.
const BRAKED_MPS: f64 = 0.7;
/// Minimum change of a distance over them, m.
const DISTANCE_M: f64 = 0.1;
/// Frames before the keyframe in which the ego was faster: 5 s; and the minimum difference: this share, plus this, m/s.
const FASTER_FRAMES: usize = 50;
const FASTER_SHARE: f64 = 0.15;
const FASTER_MPS: f64 = 0.7;
/// Frames after the keyframe in which a change goes on: 1 s; in which a response begins: 1.5 s; and in which a speed is
/// kept: 3 s.
const SOON_FRAMES: usize = 10;
const ANSWER_FRAMES: usize = 15;
const KEPT_FRAMES: usize = 30;
/// Minimum loss of speed that is a response, m/s.
const ANSWER_MPS: f64 = 0.4;
/// A speed is kept if it stays within this share, and within this, m/s; it changes little within the larger ones.
const KEPT: (f64, f64) = (0.1, 0.6);
const LITTLE: (f64, f64) = (0.2, 1.5);
/// Frames in which the ego comes to a stand: 10 s; the speed below which it does, m/s; and the same before the
/// keyframe.
const STOP_FRAMES: usize = 100;
const STOPPED_MPS: f64 = 0.6;
const STOOD_FRAMES: usize = 30;
/// An ego that goes on braking loses more than this share of its speed within the frames in which a speed is kept.
const BRAKES_ON_SHARE: f64 = 0.4;
/// An ego that speeds up gains this within 3 s, m/s, and one that slows loses this, or this share of its speed, within
/// 4 s.
const CHANGED_MPS: f64 = 0.5;
const CHANGED_SHARE: f64 = 0.3;
const SLOWS_FRAMES: usize = 40;
/// Frames before the keyframe between which an ego brakes that does not begin to at the keyframe: 2 s and 1 s; its loss
/// of speed over them, m/s.
const BRAKING_FRAMES: (usize, usize) = (20, 10);
const BRAKING_MPS: f64 = 1.0;
/// Share of the limit above which a speed exceeds it, and the frames in which it does: 6 s.
const OVER_SHARE: f64 = 1.03;
const LIMIT_FRAMES: usize = 60;
/// Minimum growth of the distance from the ego's path of a road user that leaves it, m.
const LEAVES_M: f64 = 0.1;

impl Moment<'_> {
    /// The change with this name in `schema/draft_texts.yaml`; unknown for other names, and where the table has only
    /// the keyframe.
    pub(super) fn change(&self, name: &str) -> Tri {
        if !self.has_course() {
            return Tri::Unknown;
        }
        let ego = || self.gained("ego.speed", EGO_FRAMES);
        let target = |frames| self.gained("target.speed", frames);
        // Where its speed before is unknown, one that is faster than the ego does not hold it up, and one that is
        // slower makes no room.
        let or_relative = |known: Tri, denies: fn(f64) -> bool| match self.number("target.relative_speed") {
            Some(v) if known == Tri::Unknown && denies(v) => Tri::False,
            _ => known,
        };
        let distance = || self.gained("target.distance", OTHER_FRAMES);
        match name {
            "past.slowed" => is(ego(), |d| d < -EGO_MPS),
            "past.gained" => is(ego(), |d| d > EGO_MPS),
            "past.was_faster" => self.was_faster(),
            "past.target_slowed" => {
                or_relative(is(target(OTHER_FRAMES), |d| d < -OTHER_MPS), |v| v > ALIKE_MPS)
            }
            "past.target_gained" => {
                or_relative(is(target(OTHER_FRAMES), |d| d > OTHER_MPS), |v| v < -ALIKE_MPS)
            }
            "past.target_braked" => is(target(EGO_FRAMES), |d| d < -BRAKED_MPS),
            "past.target_leaves" => self.target_leaves(),
            "past.stood" => {
                let from = self.frame().saturating_sub(STOOD_FRAMES);
                let stood = is(self.least_speed(from..=self.frame()), |v| v < STOPPED_MPS);
                self.unless_cut(stood, self.frame() >= STOOD_FRAMES)
            }
            "past.closer" => or_relative(is(distance(), |d| d < -DISTANCE_M), |v| v > ALIKE_MPS),
            "past.farther" => or_relative(is(distance(), |d| d > DISTANCE_M), |v| v < ALIKE_MPS),
            "soon.falls" => is(self.gains(SOON_FRAMES), |d| d < 0.0),
            "soon.rises" => is(self.gains(SOON_FRAMES), |d| d > 0.0),
            "soon.gains" => is(self.gains(KEPT_FRAMES), |d| d > CHANGED_MPS),
            "soon.slows" => self.slows(),
            "past.braking" => self.was_braking(),
            "soon.stops" => {
                let stops =
                    is(self.least_speed(self.frame()..=self.frame() + STOP_FRAMES), |v| v < STOPPED_MPS);
                self.unless_cut(stops, self.gains(STOP_FRAMES).is_some())
            }
            "soon.brakes_on" => self.brakes_on(),
            "soon.under_limit" => self.is_under_limit(),
            "soon.reaches_limit" => self.reaches_limit(),
            "soon.answers" => self.answers(),
            "soon.keeps" => self.stays_within(KEPT),
            "soon.changes_little" => self.stays_within(LITTLE),
            _ => Tri::Unknown,
        }
    }

    /// Change of a number over the `frames` before the keyframe.
    fn gained(&self, name: &str, frames: usize) -> Option<f64> {
        let before = self.number_at(name, self.frame().checked_sub(frames)?)?;
        Some(self.number_at(name, self.frame())? - before)
    }

    /// Change of the ego's speed over the `frames` after the keyframe.
    fn gains(&self, frames: usize) -> Option<f64> {
        let speed = |frame| self.number_at("ego.speed", frame);
        Some(speed(self.frame() + frames)? - speed(self.frame())?)
    }

    /// Least known speed of the ego in `frames`, m/s.
    fn least_speed(&self, frames: RangeInclusive<usize>) -> Option<f64> {
        frames.filter_map(|f| self.number_at("ego.speed", f)).min_by(f64::total_cmp)
    }

    /// What was not found in frames of which some are outside of the drive is unknown.
    fn unless_cut(&self, found: Tri, is_whole: bool) -> Tri {
        if found == Tri::False && !is_whole { Tri::Unknown } else { found }
    }

    fn slows(&self) -> Tri {
        let least = self.least_speed(self.frame()..=self.frame() + SLOWS_FRAMES);
        let slows = self
            .number_at("ego.speed", self.frame())
            .zip(least)
            .map_or(Tri::Unknown, |(v, least)| Tri::from(v - least > CHANGED_MPS.min(CHANGED_SHARE * v)));
        self.unless_cut(slows, self.gains(SLOWS_FRAMES).is_some())
    }

    fn was_braking(&self) -> Tri {
        let speed = |before: usize| self.number_at("ego.speed", self.frame().checked_sub(before)?);
        let lost = speed(BRAKING_FRAMES.0).zip(speed(BRAKING_FRAMES.1)).map(|(then, later)| then - later);
        lost.map_or(Tri::Unknown, |lost| Tri::from(lost > BRAKING_MPS))
    }

    fn brakes_on(&self) -> Tri {
        let now = self.number_at("ego.speed", self.frame());
        let lost = self.gains(KEPT_FRAMES).map(|d| -d);
        now.zip(lost).map_or(Tri::Unknown, |(v, lost)| Tri::from(lost > (BRAKES_ON_SHARE * v).max(LITTLE.1)))
    }

    fn is_under_limit(&self) -> Tri {
        let Some(limit) = self.number_at("map.speed_limit", self.frame()) else { return Tri::Unknown };
        // A higher limit that is near may be used.
        let limit = self.limit().map_or(limit, |ahead| ahead.max(limit));
        let frames = self.frame()..=self.frame() + LIMIT_FRAMES;
        let mut speeds = frames.filter_map(|f| self.number_at("ego.speed", f));
        let under = Tri::from(speeds.all(|v| v <= limit * OVER_SHARE));
        !self.unless_cut(!under, self.gains(LIMIT_FRAMES).is_some())
    }

    fn reaches_limit(&self) -> Tri {
        let Some(limit) = self.limit() else { return Tri::Unknown };
        let least = self.least_speed(self.frame()..=self.frame() + STOP_FRAMES);
        self.unless_cut(is_below(least, limit * OVER_SHARE), self.gains(STOP_FRAMES).is_some())
    }

    /// Change of the ego's speed in the frames in which a speed is kept, m/s.
    pub(super) fn gain(&self) -> Option<f64> {
        if self.has_course() { self.gains(KEPT_FRAMES) } else { None }
    }

    fn target_leaves(&self) -> Tri {
        let aside = |frame| self.number_at("target.path_lateral", frame).map(f64::abs);
        let before = self.frame().checked_sub(OTHER_FRAMES).and_then(aside);
        aside(self.frame()).zip(before).map_or(Tri::Unknown, |(now, b)| Tri::from(now > b + LEAVES_M))
    }

    fn was_faster(&self) -> Tri {
        let from = self.frame().saturating_sub(FASTER_FRAMES);
        let before = (from..self.frame()).filter_map(|f| self.number_at("ego.speed", f));
        let now = self.number_at("ego.speed", self.frame());
        let most = before.max_by(f64::total_cmp);
        let faster =
            most.zip(now).map_or(Tri::Unknown, |(m, v)| Tri::from(m > v * (1.0 + FASTER_SHARE) + FASTER_MPS));
        self.unless_cut(faster, self.frame() >= FASTER_FRAMES)
    }

    /// The ego loses speed at once, or was losing it already.
    fn answers(&self) -> Tri {
        let least = (1..=ANSWER_FRAMES).filter_map(|n| self.gains(n)).min_by(f64::total_cmp);
        let answers = is(least, |d| d < -ANSWER_MPS);
        self.unless_cut(answers, self.gains(ANSWER_FRAMES).is_some())
            .or(is(self.gained("ego.speed", EGO_FRAMES), |d| d < -ANSWER_MPS))
    }

    /// The speed stays within a share of its value and a tolerance (m/s), from 0.8 s before the keyframe to 3 s after
    /// it.
    fn stays_within(&self, (share, tolerance_mps): (f64, f64)) -> Tri {
        let (Some(now), Some(_)) = (self.number_at("ego.speed", self.frame()), self.gains(KEPT_FRAMES))
        else {
            return Tri::Unknown;
        };
        let limit = (share * now).max(tolerance_mps);
        let frames = self.frame().saturating_sub(OTHER_FRAMES)..=self.frame() + KEPT_FRAMES;
        let mut speeds = frames.filter_map(|f| self.number_at("ego.speed", f));
        Tri::from(speeds.all(|v| (v - now).abs() <= limit))
    }
}

fn is_below(value: Option<f64>, limit: f64) -> Tri {
    value.map_or(Tri::Unknown, |v| Tri::from(v <= limit))
}

fn is(change: Option<f64>, condition: fn(f64) -> bool) -> Tri {
    change.map_or(Tri::Unknown, |d| Tri::from(condition(d)))
}
