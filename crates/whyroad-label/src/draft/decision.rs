//! The first action after the keyframe, read from the ego's motion. Motion shows *that* the ego slows, not why; the
//! reason is taken from the class's typical decisions, and if none of them fits, nothing is guessed.

use super::lead::Lead;
use super::moment::{Moment, light_state};
use super::motion::{HORIZON_FRAMES, LongitudinalMotion, side_of_change};
use crate::driven::along::{Course, Trend};
use whyroad_framework::decision_table::{ClassDecisions, Fit};
use whyroad_framework::decisions::DecisionSets;
use whyroad_framework::taxonomy::TypicalDecisions;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Bilingual, Column, ObjectClass, SignalTable, Tri};

/// Frames after the keyframe in which slowing that began within the horizon may come to a stop: from 50 km/h and more,
/// gentle braking takes longer than 6 s. Equal to the maximum range that the checks of motion follow.
const STOP_FRAMES: usize = 150;
/// Minimum length of a meta action that is a decision: 0.5 s.
const HELD_FRAMES: usize = 5;

/// Minimum lateral movement within the lane that is a nudge, m.
const NUDGE_M: f64 = 0.25;
/// A nudge may have begun this long before the keyframe.
const NUDGE_BEFORE_FRAMES: usize = 30;
/// A larger change of the lateral offset from one frame to the keyframe is a change to another lane, m.
const LANE_JUMP_M: f64 = 2.0;

/// Frames over which a change of speed is measured.
const CHANGE_FRAMES: usize = 30;
/// A speed that continues to change by this over those frames is a decision even if it began before the keyframe, m/s:
/// 8 km/h.
const CLEAR_MPS: f64 = 8.0 / 3.6;
/// Frames before the keyframe in which an ego that now speeds up moved off, if it stood in one of them.
const JUST_NOW_FRAMES: usize = 10;
/// An ego slower than this that speeds up is starting, m/s: walking pace.
pub(super) const ROLLING_MPS: f64 = 1.0;
/// Frames after the keyframe in which a turn or a lane change begins that is not typical of the class: 2 s.
const SOON_FRAMES: usize = 20;
/// An ego at least this fast at the keyframe that stands after those frames has decided to stop, m/s.
const CLEAR_STOP_MPS: f64 = 2.5;
/// Frames before the keyframe in which the ego has slowed, and a speed that is low, m/s: 15 km/h.
const SLOWED_FRAMES: usize = 50;
const SLOW_MPS: f64 = 15.0 / 3.6;
/// An ego that does not reach this speed has not moved off, m/s.
const MOVED_OFF_MPS: f64 = 1.0;
/// Frames in which it reaches that speed after it has moved off: 2.5 s, which is a slow start (0.4 m/s2).
const MOVE_OFF_FRAMES: usize = 25;
/// Slowing that begins later than this is not for a turn that the ego is in or at, s.
const TURN_SOON_S: f64 = 1.5;
/// Within the frames over which a change of speed is measured, an ego that speeds up gains this, m/s.
const GAIN_MPS: f64 = 0.5;
/// Speeding up that begins later than this is not a return to the target speed that the keyframe calls for, s.
const SOON_S: f64 = 2.0;
/// Minimum rise of the speed for such a return, m/s.
const RISE_MPS: f64 = 1.0;
/// An ego that moves off later than this waits first, s.
const WAITS_S: f64 = 1.5;
/// A U-turn this near to a roundabout, in frames, is the way round it.
const ROUND_FRAMES: usize = 30;
/// Maximum distance at which a road user in the next lane makes a gap, m.
const GAP_M: f64 = 40.0;

/// What the class and the target determine about the decision.
pub(super) struct Asked<'a> {
    /// Names of the decisions.
    pub names: &'a DecisionSets,
    pub typical: &'a TypicalDecisions,
    /// Decisions that the class allows; `None` where the framework has no table.
    pub allowed: Option<&'a ClassDecisions>,
    /// The lateral decision that the labeling spec prescribes.
    pub mandated: Option<Lateral>,
    pub target: Option<ObjectClass>,
    pub is_safety: bool,
    /// The class is about what the ego does because of another road user.
    pub of_others: bool,
    /// The class is about a roundabout.
    pub of_roundabout: bool,
    /// The class is about a road user whose path crosses the ego's.
    pub of_crossing: bool,
    /// Decisions that at least one variant allows, where the variant is not known.
    pub of_variants: Option<&'a ClassDecisions>,
    /// The lead.
    pub lead: Option<Lead<'a>>,
    /// Relation of the lead to the subject of the class.
    pub lead_is: LeadIs,
    /// The ego comes to a stand behind the lead.
    pub is_stopped_behind: bool,
    /// The speed changes so much that a label must state a decision.
    pub changes_plainly: bool,
    /// Course of the ego's speed, where it is known.
    pub course: Option<Course>,
    /// The class is about the road.
    pub of_road: bool,
    /// The class is about a legal limit, and not about what the limit is for.
    pub of_limit: bool,
    /// The class is about something that takes up the ego's lane, or the lane is left because of what stands in it:
    /// no reason to speed up.
    pub of_obstacle: bool,
    /// The class is about the ego's turn, or its way straight on, at a junction.
    pub of_turn: bool,
}

/// Relation of the lead to the subject of a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LeadIs {
    /// The lead is the subject of the class.
    Target,
    /// The lead is nearer than the subject, or the class has no subject.
    Nearer,
    /// The subject of the class is nearer.
    Farther,
}

impl Asked<'_> {
    /// The only longitudinal decision that the class can have.
    fn only_longitudinal(&self) -> Option<Longitudinal> {
        match self.allowed.map(|a| &a.longitudinal[..]) {
            Some([(Some(only), _)]) => Some(*only),
            _ => None,
        }
    }

    /// The class exists because the ego did something.
    pub(super) fn decides(&self) -> bool {
        self.allowed.is_some_and(|a| a.decides)
    }

    fn allows(&self, longitudinal: Longitudinal) -> bool {
        self.allowed
            .or(self.of_variants)
            .is_some_and(|a| a.longitudinal_fit(Some(longitudinal)) != Fit::Impossible)
    }

    fn allows_lateral(&self, lateral: Lateral, direction: LateralDirection) -> bool {
        self.allowed
            .or(self.of_variants)
            .is_some_and(|a| a.direction_fit(lateral, Some(direction)) != Fit::Impossible)
    }

    /// At a roundabout, this turn is a part of the way round it.
    fn goes_round(&self, turn: LateralDirection) -> bool {
        self.of_roundabout || (self.of_crossing && turn == LateralDirection::Uturn)
    }

    /// The only lateral decision that the class can have.
    fn only_lateral(&self) -> Option<Lateral> {
        let mut all = self.allowed?.lateral.iter().map(|(entry, _)| entry.lateral);
        let first = all.next()??;
        all.all(|l| l == Some(first)).then_some(first)
    }
}

pub(super) fn infer(
    signals: &SignalTable,
    keyframe: usize,
    asked: &Asked<'_>,
    notes: &mut Vec<Bilingual>,
) -> (DrivingDecision, LongitudinalMotion) {
    let mut of_lateral = Vec::new();
    let (lateral, lateral_direction) = lateral(signals, keyframe, asked, &mut of_lateral);
    let lateral = lateral.or_else(|| asked.only_lateral()).or_else(|| nudge(signals, keyframe, asked));
    let lateral_direction = lateral_direction.or_else(|| side_of(lateral?, signals, keyframe));
    // An ego that turns enters another road, not a gap of the lane beside it.
    let beside = lateral_direction.filter(|_| lateral != Some(Lateral::Turn));
    let gap = beside
        .or_else(|| side_without(lateral, signals, keyframe))
        .is_some_and(|side| is_near(signals, keyframe, side));
    // A decision that the class requires is made whatever the motion in the 6 s shows.
    let chosen = |(motion, began)| {
        if follows_lead(motion, lateral, asked) {
            return Some(Longitudinal::LeadFollowing);
        }
        let slows = motion == LongitudinalMotion::Slows;
        let out = |d: Longitudinal| match d {
            Longitudinal::SetSpeedTracking => {
                motion == LongitudinalMotion::SpeedsUp
                    && (!rises_soon(signals, keyframe, began)
                        || asked.of_obstacle
                        || (asked.of_road && !had_slowed(signals, keyframe)))
            }
            // Yielding needs somebody to yield to; a class about danger is about somebody.
            Longitudinal::YieldToAgent => asked.target.is_none() && !asked.is_safety,
            Longitudinal::GapMatching => !gap,
            // Following needs a lead.
            Longitudinal::LeadFollowing => {
                let behind = asked.lead.is_some_and(|l| l.is_cause_of(motion));
                asked.target.is_none() && !asked.of_others && !behind
            }
            // A lane change is not made to drive slowly.
            Longitudinal::RoadSpeedAdaptation => {
                let late = asked.of_turn && began > TURN_SOON_S;
                let lane_change =
                    lateral == Some(Lateral::LaneChange) && !asked.typical.longitudinal.contains(&d);
                lane_change || late || (slows && !gets_slower(signals, keyframe))
            }
            _ => false,
        };
        let rises =
            speeds(signals, keyframe).is_some_and(|(now, then)| then - now > CLEAR_MPS) && !asked.of_obstacle;
        let found = choose(motion, asked, out).or_else(|| choose_clear(motion, rises, asked));
        found.or_else(|| asked.only_longitudinal())
    };
    let course = asked.course.as_ref();
    let (mut motion, mut began) = longitudinal_motion(signals, keyframe, course, Before::IsNoAnswer);
    let mut longitudinal = chosen((motion, began));
    // If the class exists because the ego did something, a change that began before the keyframe counts; so does hard
    // braking in danger, and a speed that continues to change clearly. But an earlier change is no response to what
    // another road user does now.
    let own = lateral.is_none() && (asked.decides() || asked.is_safety);
    let clearly = asked.changes_plainly || (!asked.of_others && changes_clearly(signals, keyframe));
    // An ego that slows nearly to a stop gives way, even if it began to slow before the keyframe.
    let gives_way = asked.of_crossing
        && asked.target.is_some()
        && asked.typical.longitudinal.contains(&Longitudinal::YieldToAgent)
        && course.is_some_and(|c| c.nearly_stands && c.now_mps > ROLLING_MPS);
    if longitudinal.is_none() && (own || clearly || gives_way) {
        let counted = longitudinal_motion(signals, keyframe, course, Before::Counts);
        longitudinal = chosen(counted);
        if own || longitudinal.is_some() {
            (motion, began) = counted;
        }
    }
    note_longitudinal(motion, began, longitudinal, asked.names, notes);
    notes.append(&mut of_lateral);
    (DrivingDecision { longitudinal, lateral, lateral_direction }, motion)
}

/// The lead, not the subject of the class, determines the speed: it is nearer to the ego than the road and its rules
/// (LABELING.md 6, *proximate cause*). An ego that overtakes or changes lanes speeds up for that purpose.
fn follows_lead(motion: LongitudinalMotion, lateral: Option<Lateral>, asked: &Asked<'_>) -> bool {
    let goes_past = motion == LongitudinalMotion::SpeedsUp
        && lateral.is_some_and(|l| !matches!(l, Lateral::Turn | Lateral::LaneKeeping));
    let follows = matches!(
        motion,
        LongitudinalMotion::Slows | LongitudinalMotion::Stops | LongitudinalMotion::SpeedsUp
    );
    let (Some(lead), false) = (asked.lead, asked.is_safety) else { return false };
    let because = match asked.lead_is {
        // A typical follow decision is chosen below.
        LeadIs::Target => !asked.of_others && motion != LongitudinalMotion::SpeedsUp && lead.is_slower(),
        LeadIs::Nearer if asked.of_others => {
            let decides = lead.stops() || asked.is_stopped_behind || motion == LongitudinalMotion::SpeedsUp;
            decides && lead.is_cause_of(motion)
        }
        LeadIs::Nearer => lead.is_cause_of(motion),
        LeadIs::Farther => false,
    };
    follows && !goes_past && because && asked.allows(Longitudinal::LeadFollowing)
}

/// The lateral movement within the lane, if the class exists because the ego did something and this movement may be it.
fn nudge(signals: &SignalTable, keyframe: usize, asked: &Asked<'_>) -> Option<Lateral> {
    if !asked.decides() || side_of(Lateral::InLaneNudge, signals, keyframe).is_none() {
        return None;
    }
    let over = signals.frame_columns.get("ego.wheel_over_line");
    let end = |c: &Column| (keyframe + HORIZON_FRAMES + 1).min(c.len());
    let crosses = over.is_some_and(|c| (keyframe..end(c)).any(|f| c.flag(f).is_true()));
    let nudge = if crosses { Lateral::OutOfLaneNudge } else { Lateral::InLaneNudge };
    asked.typical.lateral.contains(&nudge).then_some(nudge)
}

/// The side of a decision that the class prescribes: for a nudge, the side to which the ego moves within its lane; for
/// a lane change that begins later, the side of the indicator.
fn side_of(lateral: Lateral, signals: &SignalTable, keyframe: usize) -> Option<LateralDirection> {
    match lateral {
        Lateral::InLaneNudge | Lateral::OutOfLaneNudge => {
            let offset = signals.frame_columns.get("ego.lane_offset")?;
            // It may have begun before the keyframe; then the return movement comes first after it.
            let begin = keyframe.saturating_sub(NUDGE_BEFORE_FRAMES);
            let here = offset.number(begin)?;
            let end = (keyframe + HORIZON_FRAMES + 1).min(offset.len());
            let moved = |f| offset.number(f).map(|o| o - here);
            // The offset jumps when the ego enters another lane.
            let mut moves = (begin..end).map_while(moved).take_while(|m| m.abs() < LANE_JUMP_M);
            let aside = moves.find(|m| m.abs() > NUDGE_M)?;
            Some(if aside > 0.0 { LateralDirection::Left } else { LateralDirection::Right })
        }
        Lateral::LaneChange => {
            let on = signals.frame_columns.get("ego.turn_signal")?.category(keyframe)?;
            LateralDirection::from_id(on).filter(|d| lateral.directions().contains(d))
        }
        _ => None,
    }
}

/// The side of a decision that has no direction: for a merge, that of the target lane; for an aborted change, that of
/// the lane from which the ego returns.
pub(super) fn side_without(
    lateral: Option<Lateral>,
    signals: &SignalTable,
    keyframe: usize,
) -> Option<LateralDirection> {
    match lateral? {
        Lateral::MergeOrSplit => side_of_change(signals, keyframe),
        Lateral::ManeuverAbort => {
            let aside = signals.frame_columns.get("ego.lane_offset")?.number(keyframe)?;
            (aside.abs() > NUDGE_M).then_some(if aside > 0.0 {
                LateralDirection::Left
            } else {
                LateralDirection::Right
            })
        }
        _ => None,
    }
}

/// Somebody in the lane on `side` is near enough to form a gap.
fn is_near(signals: &SignalTable, keyframe: usize, side: LateralDirection) -> bool {
    let moment = Moment::of(signals, keyframe, None, Some(side));
    let room = |name: &str| moment.number(name).is_some_and(|d| d < GAP_M);
    room("around.room_ahead") || room("around.room_behind")
}

/// Speed at the keyframe and at the end of the frames over which its change is measured, starting at `from`, m/s.
fn speeds(signals: &SignalTable, from: usize) -> Option<(f64, f64)> {
    let speed = signals.frame_columns.get("ego.speed")?;
    let to = (from + CHANGE_FRAMES).min(speed.len().checked_sub(1)?);
    Some((speed.number(from)?, speed.number(to)?))
}

fn changes_clearly(signals: &SignalTable, keyframe: usize) -> bool {
    let stands = signals
        .frame_columns
        .get("ego.standstill")
        .is_some_and(|c| keyframe + CHANGE_FRAMES < c.len() && c.flag(keyframe + CHANGE_FRAMES).is_true());
    speeds(signals, keyframe).is_some_and(|(now, then)| {
        (then - now).abs() > CLEAR_MPS || (now > CLEAR_STOP_MPS && then < now && stands)
    })
}

/// The speed rises significantly and soon, so what is seen at the keyframe may be the cause, and does not fall first.
/// True where it is unknown.
fn rises_soon(signals: &SignalTable, keyframe: usize, began_s: f64) -> bool {
    let frames = (began_s * FRAME_RATE_HZ).round() as usize;
    let gains = speeds(signals, keyframe).is_none_or(|(now, then)| then - now > GAIN_MPS);
    began_s <= SOON_S
        && gains
        && speeds(signals, keyframe + frames).is_none_or(|(now, then)| then - now > RISE_MPS)
}

/// The ego is slow, or was clearly faster within the 5 s before, so there is a speed to return to. True where it is
/// unknown.
pub(super) fn had_slowed(signals: &SignalTable, keyframe: usize) -> bool {
    let Some(speed) = signals.frame_columns.get("ego.speed") else { return true };
    let Some(now) = speed.number(keyframe) else { return true };
    let before = (keyframe.saturating_sub(SLOWED_FRAMES)..keyframe).filter_map(|f| speed.number(f));
    now < SLOW_MPS || before.fold(0.0, f64::max) > now + CLEAR_MPS
}

/// The ego is slower some time after the keyframe than at it. True where it is unknown.
fn gets_slower(signals: &SignalTable, keyframe: usize) -> bool {
    let Some(speed) = signals.frame_columns.get("ego.speed") else { return true };
    let end = (keyframe + HORIZON_FRAMES + 1).min(speed.len());
    let Some(now) = speed.number(keyframe) else { return true };
    (keyframe..end).filter_map(|f| speed.number(f)).any(|v| v < now - RISE_MPS)
}

/// What the ego was already doing at the keyframe.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Before {
    IsNoAnswer,
    Counts,
}

/// The motion, and how long after the keyframe it begins, s: from the speed, or from the meta actions where no speed is
/// known.
fn longitudinal_motion(
    signals: &SignalTable,
    keyframe: usize,
    course: Option<&Course>,
    before: Before,
) -> (LongitudinalMotion, f64) {
    let (Some(meta), Some(standstill)) =
        (signals.frame_columns.get("ego.meta_longitudinal"), signals.frame_columns.get("ego.standstill"))
    else {
        return (LongitudinalMotion::Unknown, 0.0);
    };
    let end = (keyframe + HORIZON_FRAMES + 1).min(meta.len());
    let seconds = |f: usize| match (signals.times.get(f), signals.times.get(keyframe)) {
        (Some(t), Some(k)) => t.seconds_since(*k),
        _ => 0.0,
    };
    if keyframe >= end || (keyframe..end).all(|f| !meta.is_known(f)) {
        return (LongitudinalMotion::Unknown, 0.0);
    }
    let speed = signals.frame_columns.get("ego.speed");
    if standstill.flag(keyframe).is_true() {
        let fastest = speed.and_then(|c| (keyframe..end).filter_map(|f| c.number(f)).reduce(f64::max));
        let moves_off = fastest.is_none_or(|v| v > MOVED_OFF_MPS);
        // An ego that creeps forward while it waits has not moved off: it does so shortly before it drives.
        let drives =
            speed.and_then(|c| (keyframe..end).find(|&f| c.number(f).is_some_and(|v| v > MOVED_OFF_MPS)));
        let from = drives.map_or(keyframe, |f| f.saturating_sub(MOVE_OFF_FRAMES).max(keyframe));
        let off = (from..end).find(|&f| standstill.flag(f) == Tri::False).filter(|_| moves_off);
        let light = light_state(signals, keyframe);
        let starts = |after_s: f64| match light {
            Some("red" | "red_yellow") => LongitudinalMotion::Waits,
            _ if after_s > WAITS_S => LongitudinalMotion::Waits,
            _ => LongitudinalMotion::Starts,
        };
        return off.map_or((LongitudinalMotion::Keeps, 0.0), |f| (starts(seconds(f)), seconds(f)));
    }
    let change = match course {
        Some(course) => {
            let change = if before == Before::Counts { course.first } else { course.new };
            change.map(|c| {
                (c.from, if c.trend == Trend::Rises { SpeedChange::Rises } else { SpeedChange::Falls })
            })
        }
        None => first_change(meta, keyframe, end, before),
    };
    let Some((began, change)) = change else {
        return (LongitudinalMotion::Keeps, 0.0);
    };
    if change == SpeedChange::Rises {
        let rolls = speed.and_then(|c| c.number(keyframe)).is_some_and(|v| v < ROLLING_MPS);
        // It stood a moment ago.
        let stood =
            (keyframe.saturating_sub(JUST_NOW_FRAMES)..keyframe).any(|f| standstill.flag(f).is_true());
        if rolls || stood {
            return (LongitudinalMotion::Starts, seconds(began));
        }
        return (LongitudinalMotion::SpeedsUp, seconds(began));
    }
    let stop_end = (keyframe + STOP_FRAMES + 1).min(meta.len());
    let stands = (began..stop_end)
        .take_while(|&f| speed_change(meta, f) != Some(SpeedChange::Rises))
        .any(|f| standstill.flag(f).is_true());
    // An ego that has not lost half of its speed after 6 s is not about to stop.
    let at_end = course.and(speed).and_then(|c| c.number(end - 1));
    let soon = at_end.zip(course).is_none_or(|(v, course)| v < course.now_mps / 2.0);
    let stops = course.is_some_and(|c| c.nearly_stands) || (stands && soon);
    let motion = if stops { LongitudinalMotion::Stops } else { LongitudinalMotion::Slows };
    (motion, seconds(began))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum SpeedChange {
    Falls,
    Rises,
}

fn speed_change(meta: &Column, frame: usize) -> Option<SpeedChange> {
    match meta.category(frame) {
        Some("gentle_decelerate" | "strong_decelerate") => Some(SpeedChange::Falls),
        Some("gentle_accelerate" | "strong_accelerate") => Some(SpeedChange::Rises),
        _ => None,
    }
}

/// First sustained period of speeding up or slowing after the keyframe. One that was already sustained for 0.5 s at the
/// keyframe is not a response to it, and is skipped unless `before` says that it counts.
fn first_change(meta: &Column, keyframe: usize, end: usize, before: Before) -> Option<(usize, SpeedChange)> {
    let held = |from: usize, to: usize, change: SpeedChange| {
        to <= end && (from..to).all(|f| speed_change(meta, f) == Some(change))
    };
    let mut from = keyframe;
    if let Some(underway) = speed_change(meta, keyframe)
        && before == Before::IsNoAnswer
        && keyframe >= HELD_FRAMES
        && held(keyframe - HELD_FRAMES, keyframe, underway)
    {
        from = (keyframe..end).find(|&f| speed_change(meta, f) != Some(underway))?;
    }
    (from..end).find_map(|f| {
        let change = speed_change(meta, f)?;
        held(f, f + HELD_FRAMES, change).then_some((f, change))
    })
}

/// Decisions that the motion can implement.
fn candidates(motion: LongitudinalMotion) -> &'static [Longitudinal] {
    use Longitudinal as D;
    match motion {
        LongitudinalMotion::Slows => {
            &[D::YieldToAgent, D::LeadFollowing, D::RoadSpeedAdaptation, D::GapMatching]
        }
        LongitudinalMotion::Stops => &[
            D::YieldToAgent,
            D::LeadFollowing,
            D::StopForRegulation,
            D::StopForObstacle,
            D::RoadSpeedAdaptation,
            D::GapMatching,
        ],
        LongitudinalMotion::Starts | LongitudinalMotion::Waits => &[D::Resume],
        LongitudinalMotion::SpeedsUp => {
            &[D::LeadFollowing, D::AccelerationForPassing, D::GapMatching, D::SetSpeedTracking]
        }
        LongitudinalMotion::Keeps | LongitudinalMotion::Unknown => &[],
    }
}

/// The decision that the motion implements, except those in `out`.
fn choose(
    motion: LongitudinalMotion,
    asked: &Asked<'_>,
    out: impl Fn(Longitudinal) -> bool,
) -> Option<Longitudinal> {
    // Slowing for a rule is not slowing for the road (LABELING.md 2): the ego goes to the speed that the limit sets.
    if asked.of_limit && motion == LongitudinalMotion::Slows && !out(Longitudinal::RoadSpeedAdaptation) {
        return Some(Longitudinal::SetSpeedTracking);
    }
    let possible = candidates(motion);
    // A crossing person, an animal, or an object that causes emergency braking is not followed.
    let follows =
        !asked.is_safety && asked.target.is_none_or(|t| t.is_vehicle() || t == ObjectClass::Bicycle);
    let fits = |d: &&Longitudinal| {
        possible.contains(d) && (follows || **d != Longitudinal::LeadFollowing) && !out(**d)
    };
    asked.typical.longitudinal.iter().find(fits).copied().or_else(|| choose_allowed(motion, asked, out))
}

/// Decisions that the class allows although they are not typical. Slowing before a crosswalk is one; an ego that stands
/// because of another road user and moves off, or that speeds up, may do so for any reason.
fn choose_allowed(
    motion: LongitudinalMotion,
    asked: &Asked<'_>,
    out: impl Fn(Longitudinal) -> bool,
) -> Option<Longitudinal> {
    use Longitudinal as D;
    let of_the_road: &[D] = match motion {
        LongitudinalMotion::Starts | LongitudinalMotion::Waits if !asked.of_others => &[D::Resume],
        LongitudinalMotion::Slows | LongitudinalMotion::Stops if !asked.of_limit => &[D::RoadSpeedAdaptation],
        _ => return None,
    };
    // If the variant of a class is not known, no decision is known to be impossible.
    let Some(allowed) = asked.allowed else {
        let of_others = asked.of_others || asked.is_safety;
        return of_the_road.first().copied().filter(|d| *d == D::Resume || !of_others);
    };
    let mut fits = allowed.longitudinal.iter().filter_map(|(d, _)| *d);
    fits.find(|d| of_the_road.contains(d) && !out(*d))
}

/// Decisions that the class allows where the speed changes clearly and no typical decision explains it: behind a lead
/// the ego follows it, and an ego that speeds up without such a reason adapts to the road.
fn choose_clear(motion: LongitudinalMotion, rises: bool, asked: &Asked<'_>) -> Option<Longitudinal> {
    use Longitudinal as D;
    match motion {
        LongitudinalMotion::Keeps | LongitudinalMotion::Unknown => return None,
        LongitudinalMotion::Starts | LongitudinalMotion::Waits => {
            return asked.allows(D::Resume).then_some(D::Resume);
        }
        LongitudinalMotion::Slows | LongitudinalMotion::Stops | LongitudinalMotion::SpeedsUp => {}
    }
    let behind = asked.lead_is == LeadIs::Nearer && asked.lead.is_some_and(|l| l.is_cause_of(motion));
    if behind && !asked.is_safety && asked.allows(D::LeadFollowing) {
        return Some(D::LeadFollowing);
    }
    let rises = motion == LongitudinalMotion::SpeedsUp && rises && asked.allows(D::SetSpeedTracking);
    rises.then_some(D::SetSpeedTracking)
}

fn note_longitudinal(
    motion: LongitudinalMotion,
    began_s: f64,
    chosen: Option<Longitudinal>,
    names: &DecisionSets,
    notes: &mut Vec<Bilingual>,
) {
    let began = |zh: &str, en: &str| {
        Bilingual::new(
            format!("关键帧后 {began_s:.1} s 自车{zh}"),
            format!("{began_s:.1} s after the keyframe the ego {en}"),
        )
    };
    let seen = match motion {
        LongitudinalMotion::Keeps => Bilingual::new(
            "关键帧后 6 s 内自车速度无明显变化",
            "within 6 s of the keyframe the ego's speed does not change",
        ),
        LongitudinalMotion::Slows => began("开始减速", "slows"),
        LongitudinalMotion::Stops => began("减速至停车", "slows to a stop"),
        LongitudinalMotion::Starts | LongitudinalMotion::Waits => began("起步", "moves off"),
        LongitudinalMotion::SpeedsUp => began("开始加速", "speeds up"),
        LongitudinalMotion::Unknown => Bilingual::new("自车运动未知", "the ego's motion is unknown"),
    };
    let name = chosen.and_then(|d| names.longitudinal(d)).map(|text| &text.name);
    notes.push(match name {
        Some(name) => Bilingual::new(
            format!("{}：纵向决策据此填为“{}”，请确认", seen.zh, name.zh),
            format!("{}: taken as the longitudinal decision \"{}\"; confirm", seen.en, name.en),
        ),
        None => Bilingual::new(
            format!("{}：纵向决策留空，请确认", seen.zh),
            format!("{}: the longitudinal decision is left empty; confirm", seen.en),
        ),
    });
}

/// The ego moves: a junction in which it stands has a direction of its turn already. True where the speed is unknown.
fn turns_at(signals: &SignalTable, frame: usize) -> bool {
    let speed = signals.frame_columns.get("ego.speed").and_then(|c| c.number(frame));
    speed.is_none_or(|v| v >= MOVED_OFF_MPS)
}

fn is_at_roundabout(signals: &SignalTable, frame: usize) -> bool {
    let around = frame.saturating_sub(ROUND_FRAMES)..frame + ROUND_FRAMES;
    let inside = signals.frame_columns.get("map.in_roundabout");
    inside.is_some_and(|c| around.take_while(|f| *f < c.len()).any(|f| c.flag(f).is_true()))
}

fn lateral(
    signals: &SignalTable,
    keyframe: usize,
    asked: &Asked<'_>,
    notes: &mut Vec<Bilingual>,
) -> (Option<Lateral>, Option<LateralDirection>) {
    if let Some(lateral) = asked.mandated {
        let name = asked.names.name(lateral.id());
        notes.push(Bilingual::new(
            format!("横向决策由标注规格规定：{}；方向请确认", name.zh),
            format!("the labeling spec prescribes the lateral decision \"{}\"; state its direction", name.en),
        ));
        return (Some(lateral), None);
    }
    let ahead = |name: &str, side: &dyn Fn(usize, &str) -> Option<LateralDirection>| {
        let column = signals.frame_columns.get(name)?;
        let end = (keyframe + HORIZON_FRAMES + 1).min(column.len());
        (keyframe..end).find_map(|f| Some((side(f, column.category(f)?)?, f - keyframe)))
    };
    let driving_side = signals.frame_columns.get("map.driving_side").and_then(|c| c.category(keyframe));
    let driving_side = driving_side.and_then(LateralDirection::from_id);
    let side_of_turn = |frame: usize, movement: &str| {
        let turn = LateralDirection::from_id(movement)?;
        turns_at(signals, frame).then(|| match driving_side {
            // It enters and leaves a roundabout on the side on which it drives.
            Some(side) if asked.goes_round(turn) && is_at_roundabout(signals, frame) => side,
            _ => turn,
        })
    };
    let mut found = [
        (Lateral::LaneChange, ahead("ego.lane_change", &|_, change| LateralDirection::from_id(change))),
        (Lateral::Turn, ahead("ego.movement", &side_of_turn)),
    ];
    // An ego that moves to the side to which it turns is turning.
    let side = |n: usize| found[n].1.map(|(side, _)| side);
    if side(0) == side(1) {
        found.reverse();
    }
    for (lateral, direction) in found {
        let Some((direction, after)) = direction.filter(|(d, _)| lateral.directions().contains(d)) else {
            continue;
        };
        // A decision that is not typical of the class counts only where it follows at once.
        let forbidden = asked.allowed.is_some() && !asked.allows_lateral(lateral, direction);
        let usual = (asked.typical.lateral.contains(&lateral) && !forbidden)
            || (after <= SOON_FRAMES && asked.allows_lateral(lateral, direction));
        let way = match (lateral, direction) {
            (_, LateralDirection::Uturn) => Bilingual::new("掉头", "makes a U-turn"),
            (Lateral::Turn, LateralDirection::Left) => Bilingual::new("左转", "turns left"),
            (Lateral::Turn, LateralDirection::Right) => Bilingual::new("右转", "turns right"),
            (_, LateralDirection::Left) => Bilingual::new("向左换道", "changes to the left lane"),
            (_, LateralDirection::Right) => Bilingual::new("向右换道", "changes to the right lane"),
        };
        notes.push(Bilingual::new(
            format!(
                "关键帧后 6 s 内自车{}{}",
                way.zh,
                if usual {
                    "，横向决策据此填写，请确认"
                } else {
                    "；该场景通常不以此为决策，留空"
                }
            ),
            format!(
                "within 6 s of the keyframe the ego {}{}",
                way.en,
                if usual {
                    ": taken as the lateral decision; confirm"
                } else {
                    "; not usual for this class, left null"
                }
            ),
        ));
        if usual {
            return (Some(lateral), Some(direction));
        }
    }
    (None, None)
}
