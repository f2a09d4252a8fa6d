//! The keyframe as seen by the conditions of `schema/draft_texts.yaml`: signals of the frame and of the episode's
//! target, and `around.*`, which describe the road users near the ego. Nothing after the keyframe is read, except for
//! `decided.*` and the side of the decision.

use super::motion::{LongitudinalMotion, changes_lane};
use whyroad_framework::draft_texts::SignalCondition;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::{Column, SignalTable, TrackId, Tri};

/// Objects ahead or crossing that are nearer than this block the way, m.
const IN_THE_WAY_M: f64 = 40.0;
/// A road user in this area in front of the ego's center is straight ahead, m.
const AHEAD_M: f64 = 15.0;
const AHEAD_SIDE_M: f64 = 2.5;

/// Road users from the opposite direction that are nearer than this matter to an ego that crosses their way, m.
const ONCOMING_M: f64 = 80.0;
/// Minimum difference of the headings to such a road user, rad: 100 degrees, since the ego may have begun to turn.
pub(super) const FACING_RAD: f64 = 100.0 * std::f64::consts::PI / 180.0;

/// A junction nearer than this is the one for which the ego indicates, m.
const AT_JUNCTION_M: f64 = 40.0;

/// A junction nearer than this may be named, m.
const NEAR_JUNCTION_M: f64 = 120.0;

/// A light whose stop line is nearer than this concerns the ego at any speed, m; a farther one within its stopping
/// distance.
const NEAR_LIGHT_M: f64 = 40.0;

/// An ego slower than this has not moved off yet, m/s.
const HARDLY_MOVES_MPS: f64 = 1.0;

/// Frames before the keyframe in which an ego on a ramp comes from it: 5 s; and those after it in which it reaches the
/// lane behind the ramp: 8 s.
const RAMP_FRAMES: usize = 50;
const LANE_FRAMES: usize = 80;

/// An ego that is in a junction after these frames has not left it: 1.5 s.
const JUNCTION_FRAMES: usize = 15;

/// The light lets the ego go: round, an arrow, or with the duty to give way. A flashing green is about to end.
pub(super) fn is_green(state: &str) -> bool {
    state.starts_with("green")
}

const LIGHT: &str = "light.state";

/// State of the light that the ego faces. In a junction, `light.state` is that of the next one: `none` controls its
/// way.
pub(super) fn light_state(signals: &SignalTable, frame: usize) -> Option<&str> {
    let column = signals.frame_columns.get(LIGHT)?;
    let inside = signals.frame_columns.get("ego.in_junction").is_some_and(|c| c.flag(frame).is_true());
    if inside { Some("none") } else { column.category(frame) }
}

/// Distance from center to center, m: positions are known in the last frame of a drive too, distances of boxes are not.
fn between_centers(along: &Column, across: &Column, row: usize) -> Option<f64> {
    Some(along.number(row)?.hypot(across.number(row)?))
}

fn is_ahead(longitudinal_m: f64) -> bool {
    longitudinal_m >= 0.0
}

fn is_behind(longitudinal_m: f64) -> bool {
    longitudinal_m < 0.0
}

/// One frame, one target.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    signals: &'a SignalTable,
    frame: usize,
    /// Row of the target.
    row: Option<usize>,
    /// Side of the ego's decision.
    side: Option<LateralDirection>,
    /// Longitudinal motion of the ego's decision.
    motion: LongitudinalMotion,
    /// The decision adapts the speed to a gap.
    fits_gap: bool,
    /// The ego turns.
    turns: bool,
    has_course: bool,
}

impl<'a> Moment<'a> {
    pub(super) fn of(
        signals: &'a SignalTable,
        frame: usize,
        target: Option<&TrackId>,
        side: Option<LateralDirection>,
    ) -> Self {
        Self {
            signals,
            frame,
            row: target.and_then(|t| signals.target(t)?.row(frame)),
            side,
            motion: LongitudinalMotion::Unknown,
            fits_gap: false,
            turns: false,
            has_course: false,
        }
    }

    /// The same, with changes before and after the keyframe (`past.*`, `soon.*`) if the table has those frames.
    pub(super) fn with_course(self, has_course: bool) -> Self {
        Self { has_course, ..self }
    }

    /// The same, where the ego does this after the keyframe.
    pub(super) fn deciding(self, decision: &DrivingDecision, motion: LongitudinalMotion) -> Self {
        let fits_gap = decision.longitudinal == Some(Longitudinal::GapMatching);
        Self { motion, fits_gap, turns: decision.lateral == Some(Lateral::Turn), ..self }
    }

    /// The same, with the target in this row.
    pub(super) fn of_row(self, row: usize) -> Self {
        Self { row: Some(row), ..self }
    }

    /// Side of the ego's decision.
    pub(super) fn side(&self) -> Option<LateralDirection> {
        self.side
    }

    pub(super) fn all(&self, conditions: &[SignalCondition]) -> bool {
        conditions.iter().all(|c| self.holds(c))
    }

    /// A condition on an unknown signal does not hold.
    fn holds(&self, condition: &SignalCondition) -> bool {
        self.truth(condition).is_true()
    }

    /// Whether a condition holds; unknown where one of its signals is.
    pub(super) fn truth(&self, condition: &SignalCondition) -> Tri {
        let SignalCondition { signal, isnt, is, above, below, above_signal, below_signal } = condition;
        if let Some(is) = is {
            return self.category(signal).map_or(Tri::Unknown, |c| Tri::from((c == is) != *isnt));
        }
        let of_signal = |name: &Option<String>| name.as_deref().map(|n| self.number(n));
        let least = above.map(Some).or_else(|| of_signal(above_signal));
        let most = below.map(Some).or_else(|| of_signal(below_signal));
        if least.is_none() && most.is_none() {
            let flag = self.flag(signal);
            return if *isnt { !flag } else { flag };
        }
        let compare = |limit: Option<Option<f64>>, is_met: fn(f64, f64) -> bool| match limit {
            None => Tri::True,
            Some(limit) => {
                self.number(signal).zip(limit).map_or(Tri::Unknown, |(v, l)| Tri::from(is_met(v, l)))
            }
        };
        compare(least, |v, l| v > l).and(compare(most, |v, m| v < m))
    }

    /// A known number; it may be infinite.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        let value = match name {
            "around.room_ahead" => self.room(is_ahead),
            "around.room_behind" => self.room(is_behind),
            "around.limit_left" => self.limit().zip(self.number("ego.speed")).map(|(limit, v)| limit - v),
            "soon.gain" => self.gain(),
            _ => match self.signals.frame_columns.get(name) {
                Some(column) => column.number(self.frame),
                None => self.signals.target_columns.get(name)?.number(self.row?),
            },
        };
        value.filter(|v| !v.is_nan())
    }

    pub(super) fn category(&self, name: &str) -> Option<&'a str> {
        if name == LIGHT {
            return light_state(self.signals, self.frame);
        }
        match self.signals.frame_columns.get(name) {
            Some(column) => column.category(self.frame),
            None => self.signals.target_columns.get(name)?.category(self.row?),
        }
    }

    /// The log states the route here.
    pub(super) fn knows_route(&self) -> bool {
        self.category("route.command").is_some() || self.flag("route.lane_fits") != Tri::Unknown
    }

    fn flag(&self, name: &str) -> Tri {
        match name {
            "around.clear" => self.clear(),
            "around.oncoming" => self.oncoming(),
            "around.target" => Tri::from(self.row.is_some()),
            "around.green" => {
                self.category("light.state").map_or(Tri::Unknown, |state| Tri::from(is_green(state)))
            }
            "around.red" => self.red(),
            "decided.changes_lane" => Tri::from(changes_lane(self.signals, self.frame)),
            "decided.fits_gap" => Tri::from(self.fits_gap),
            "decided.turns" => Tri::from(self.turns),
            "around.junction" => self.junction(),
            "around.ramp" => self.ramp(),
            "around.acceleration_lane" => self.acceleration_lane(),
            "soon.in_junction" => {
                let column = self.signals.frame_columns.get("ego.in_junction").filter(|_| self.has_course);
                let at = self.frame + JUNCTION_FRAMES;
                column.filter(|c| at < c.len()).map_or(Tri::Unknown, |c| c.flag(at))
            }
            "decided.against_red" => self.goes_against_red(),
            "around.indicator_against" => Tri::from(self.indicator_against()),
            _ if name.starts_with("past.") || name.starts_with("soon.") => self.change(name),
            _ if name.starts_with("decided.") => {
                Tri::from(name.strip_prefix("decided.") == Some(self.motion.id()))
            }
            _ => {
                match (self.signals.frame_columns.get(name), self.signals.target_columns.get(name), self.row)
                {
                    (Some(column), ..) => column.flag(self.frame),
                    (None, Some(column), Some(row)) => column.flag(row),
                    _ => Tri::Unknown,
                }
            }
        }
    }

    /// The light that the ego faces is red or yellow, and near. A log without lights shows none.
    pub(super) fn red(&self) -> Tri {
        if !self.signals.frame_columns.contains_key(LIGHT) {
            return Tri::False;
        }
        let red = |state| Tri::from(matches!(state, "red" | "red_yellow" | "yellow"));
        self.category(LIGHT).map_or(Tri::Unknown, red).and(self.is_at_light())
    }

    /// The stop line of the light that the ego faces is near; the junction, where the line is not known.
    fn is_at_light(&self) -> Tri {
        let line = self.number("light.distance_to_stop_line");
        let stopping = self.number("ego.stopping_distance").filter(|d| d.is_finite()).unwrap_or(0.0);
        let near = |m| Tri::from(m < NEAR_LIGHT_M.max(stopping));
        line.or_else(|| self.number("map.distance_to_junction")).map_or(Tri::Unknown, near)
    }

    /// The light concerns what the ego does: it is near, and red or yellow, or green where the ego stands.
    pub(super) fn concerns_light(&self) -> bool {
        let green = self.category(LIGHT).is_some_and(is_green) && self.is_at_light().is_true();
        self.red().is_true() || (green && self.number("ego.speed").is_some_and(|v| v < HARDLY_MOVES_MPS))
    }

    /// The limit that a text names, m/s: the next one where it differs.
    pub(super) fn limit(&self) -> Option<f64> {
        let here = self.number("map.speed_limit");
        self.number("map.speed_limit_ahead").filter(|v| v.is_finite()).or(here)
    }

    /// The ego goes although its light is red, and does not turn to the side on which it drives.
    pub(super) fn goes_against_red(&self) -> Tri {
        let goes = match self.motion {
            LongitudinalMotion::Starts | LongitudinalMotion::SpeedsUp => true,
            LongitudinalMotion::Keeps => self.turns,
            _ => false,
        };
        let driving_side = self.category("map.driving_side").and_then(LateralDirection::from_id);
        let turns_near = self.turns && self.side.is_some() && self.side == driving_side;
        let red = self.category(LIGHT).map_or(Tri::Unknown, |state| Tri::from(state == "red"));
        red.and(Tri::from(goes && !turns_near))
    }

    /// The ego is in a junction, or one is ahead.
    fn junction(&self) -> Tri {
        let near = self.number("map.distance_to_junction");
        self.flag("ego.in_junction").or(near.map_or(Tri::Unknown, |d| Tri::from(d < NEAR_JUNCTION_M)))
    }

    /// The ego is on a ramp or in a lane where one joins, or was there shortly before.
    fn ramp(&self) -> Tri {
        let columns = &self.signals.frame_columns;
        let (Some(ramp), Some(zone)) = (columns.get("map.on_ramp"), columns.get("map.merge_zone")) else {
            return Tri::Unknown;
        };
        let joins = |zone: &str| Tri::from(matches!(zone, "acceleration" | "weaving"));
        let at = |f: usize| ramp.flag(f).or(zone.category(f).map_or(Tri::Unknown, joins));
        let frames = self.frame.saturating_sub(RAMP_FRAMES)..=self.frame;
        frames.map(at).fold(Tri::False, Tri::or)
    }

    /// The ego is in an acceleration or weaving lane, was there shortly before, or comes to one soon.
    fn acceleration_lane(&self) -> Tri {
        let Some(zone) = self.signals.frame_columns.get("map.merge_zone") else { return Tri::Unknown };
        let last = if self.has_course { self.frame + LANE_FRAMES } else { self.frame };
        let frames = self.frame.saturating_sub(RAMP_FRAMES)..=last.min(zone.len().saturating_sub(1));
        let joins = |zone: &str| Tri::from(matches!(zone, "acceleration" | "weaving"));
        frames.map(|f| zone.category(f).map_or(Tri::Unknown, joins)).fold(Tri::False, Tri::or)
    }

    /// Number of a frame before or after the keyframe, or of the target in it.
    pub(super) fn number_at(&self, name: &str, frame: usize) -> Option<f64> {
        let value = match self.signals.frame_columns.get(name) {
            Some(column) if frame < column.len() => column.number(frame),
            Some(_) => None,
            None => {
                let row = self.row?;
                let spans = &self.signals.targets;
                let span = spans.iter().find(|span| span.row(self.frame) == Some(row))?;
                self.signals.target_columns.get(name)?.number(span.row(frame)?)
            }
        };
        value.filter(|v| !v.is_nan())
    }

    /// Frames before the keyframe, and after it, are known too.
    pub(super) fn has_course(&self) -> bool {
        self.has_course
    }

    /// The frame of the keyframe.
    pub(super) fn frame(&self) -> usize {
        self.frame
    }

    /// No object near the ego is ahead in its lane or crosses its path.
    fn clear(&self) -> Tri {
        let column = |name: &str| self.signals.target_columns.get(name);
        let (Some(relation), Some(along), Some(across)) =
            (column("target.relation"), column("target.longitudinal"), column("target.lateral"))
        else {
            return Tri::Unknown;
        };
        // Whatever its relation, one straight ahead and near is in the way.
        let ahead = |row: usize| {
            let (x, y) = (along.number(row), across.number(row));
            x.is_some_and(|x| (0.0..AHEAD_M).contains(&x)) && y.is_some_and(|y| y.abs() < AHEAD_SIDE_M)
        };
        let in_the_way = |row: usize| {
            ahead(row)
                || matches!(relation.category(row), Some("lead" | "crossing" | "ahead"))
                    && between_centers(along, across, row).is_some_and(|d| d < IN_THE_WAY_M)
        };
        Tri::from(!self.rows().any(in_the_way))
    }

    /// A road user ahead comes from the opposite direction, or stands there.
    fn oncoming(&self) -> Tri {
        let column = |name: &str| self.signals.target_columns.get(name);
        let (Some(turned), Some(along), Some(across)) =
            (column("target.heading_difference"), column("target.longitudinal"), column("target.lateral"))
        else {
            return Tri::Unknown;
        };
        let near = |row: &usize| {
            along.number(*row).is_some_and(|x| x > 0.0)
                && between_centers(along, across, *row).is_some_and(|d| d < ONCOMING_M)
        };
        let faces = |row| turned.number(row).map_or(Tri::Unknown, |a| Tri::from(a.abs() > FACING_RAD));
        self.rows().filter(near).map(faces).fold(Tri::False, Tri::or)
    }

    /// Distance to the nearest object in the lane that the ego enters, m; infinite without one.
    fn room(&self, is_there: fn(f64) -> bool) -> Option<f64> {
        Some(self.nearest(is_there)?.map_or(f64::INFINITY, |(distance, _)| distance))
    }

    /// The object that `around.room_ahead` or `around.room_behind` is the distance to.
    pub(super) fn takes_room(&self, name: &str) -> Option<&'a TrackId> {
        let row = match name {
            "around.room_ahead" => self.nearest(is_ahead)?,
            "around.room_behind" => self.nearest(is_behind)?,
            _ => None,
        };
        let (_, row) = row?;
        let spans = self.signals.targets.iter();
        spans.filter(|span| span.row(self.frame) == Some(row)).map(|span| &span.id).next()
    }

    /// Distance, m, and row of the nearest object in the lane that the ego enters, if there is one.
    #[allow(clippy::option_option, reason = "unknown is not none")]
    fn nearest(&self, is_there: fn(f64) -> bool) -> Option<Option<(f64, usize)>> {
        let columns = &self.signals.target_columns;
        let side = self.side.filter(|s| *s != LateralDirection::Uturn)?.id();
        let (lane, along, distance) = (
            columns.get("target.lane_side")?,
            columns.get("target.longitudinal")?,
            columns.get("target.distance")?,
        );
        let there =
            |row: &usize| lane.category(*row) == Some(side) && along.number(*row).is_some_and(is_there);
        let near = self.rows().filter(there).filter_map(|row| Some((distance.number(row)?, row)));
        Some(near.filter(|(m, _)| !m.is_nan()).min_by(|a, b| a.0.total_cmp(&b.0)))
    }

    /// The ego is at a junction or in it.
    pub(super) fn is_at_junction(&self) -> bool {
        self.flag("ego.in_junction").is_true()
            || self.number("map.distance_to_junction").is_some_and(|d| d < AT_JUNCTION_M)
    }

    /// The indicator is on for the opposite side.
    pub(super) fn indicator_against(&self) -> bool {
        let on = self.category("ego.turn_signal");
        match self.side {
            Some(LateralDirection::Left) => on == Some("right"),
            Some(LateralDirection::Right) => on == Some("left"),
            _ => false,
        }
    }

    /// Rows of the objects in the frame.
    fn rows(&self) -> impl Iterator<Item = usize> {
        self.signals.targets.iter().filter_map(|span| span.row(self.frame))
    }
}
