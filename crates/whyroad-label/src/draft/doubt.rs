//! Compares what a class states about another road user, or about the ego, with their motion around the keyframe. If
//! the motion contradicts it, there is no draft: no draft is better for the annotator than a false one. What the
//! recording does not show is not doubted. The class itself is determined by the rules and their thresholds, not here.

use super::decision::{Asked, LeadIs, had_slowed};
use super::lead::Lead;
use super::moment::{is_green, light_state};
use super::motion::LongitudinalMotion;
use crate::driven::across::first_lane_change;
use crate::driven::along::{Course, Trend};
use crate::driven::other::{First, Moves, Other};
use crate::driven::{Driven, turned};
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::{Bilingual, Drive, ObjectClass, ScenarioId, TrackId, Tri};

/// Maximum distance from the path at which an object occupies part of the ego's lane, m.
const IN_LANE_M: f64 = 2.2;
/// Maximum distance of an object's center from the ego's lane center, plus half its own width, m.
const LANE_SIDE_M: f64 = 1.7;
/// Minimum approach to the path of an object that enters it, m.
const COMES_IN_M: f64 = 0.3;
/// An object that comes out of an occlusion matters if it comes nearer to the path than this within 8 s, m.
const NEAR_PATH_M: f64 = 3.0;
/// A near miss is one at its keyframe: the time to a collision of the boxes, s, or their distance, m, is less than
/// this.
const NEAR_MISS_S: f64 = 2.5;
const NEAR_MISS_M: f64 = 2.0;
/// Minimum change of the heading within 3 s of a road user that does not go straight, rad: 30 degrees, ...
const TURNS_RAD: f64 = std::f64::consts::PI / 6.0;
const TURN_FRAMES: usize = 30;
/// ... and that of an ego that drives through a bend within 6 s, rad: 10 degrees.
const BEND_RAD: f64 = std::f64::consts::PI / 18.0;
/// Minimum loss of speed from one second before the keyframe to one second after it that is hard braking, m/s.
const LOST_MPS: f64 = 1.5;
/// A road user farther behind than this has passed long ago, m.
const GONE_M: f64 = -15.0;
/// Sudden braking, m/s2; the rule requires stronger braking at one moment.
const BRAKES_MPS2: f64 = -2.0;
/// An object faster than this has not just started, m/s.
const JUST_STARTED_MPS: f64 = 4.0;
/// An object slower than this was stationary, m/s.
const STOOD_MPS: f64 = 0.6;
/// Minimum speed difference to a vehicle that the ego passes, m/s, and its maximum distance, m.
const PASSED_MPS: f64 = 3.0;
const PASSED_M: f64 = 40.0;

/// A road user that is faster than the ego by more than this does not hold it up, m/s.
const FASTER_MPS: f64 = 0.5;

/// A faster road user holds the ego up if it is slower than the limit by this, m/s.
const BELOW_MPS: f64 = 2.0;

/// Maximum distance to a junction whose red light an ego slows for that loses half of its speed within these frames, m:
/// 4 s.
const NEAR_LIGHT_M: f64 = 60.0;
const HALVES_FRAMES: usize = 40;

/// An ego that was not in the roundabout this many frames before is at its entry: 1 s.
const ENTERED_FRAMES: usize = 10;
/// It stays in it if it is there after this many frames: 5 s.
const STAYS_FRAMES: usize = 50;

/// Frames within which a lane change explains a rise of the speed, and the ego responds to hard braking: 2 s.
const SOON_FRAMES: usize = 20;

/// A record that ends sooner after the keyframe may end before the ego acts, s.
const CUT_S: f64 = 3.0;

/// The L2 class about meeting oncoming traffic, which need not be what stops the ego.
pub(super) const MEETING: &str = "passing";

/// Minimum decrease of the speed within these frames that is a response, m/s.
const ANSWER_MPS: f64 = 0.4;

/// Why there is no draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// The subject of the class is not ahead of the ego.
    NotAhead,
    /// It is not in the ego's lane.
    NotInLane,
    /// It moves in another direction than the class states.
    OtherWay,
    /// It does not come towards the ego's path.
    NotComing,
    /// It does not cross the ego's path.
    NotCrossing,
    /// It has not just started.
    NotStarting,
    /// It does not brake hard.
    NotBraking,
    /// It changes lanes instead of weaving.
    ChangesLane,
    /// What is ahead of the leaving road user is the queue at a light.
    NoObstacle,
    /// The ego gets there first: it does not give way.
    EgoFirst,
    /// The ego is not yet in the roundabout.
    NotInRoundabout,
    /// No vehicle beside the ego hides the view.
    NobodyBeside,
    /// The ego slows for its turn at the junction.
    TurnsThere,
    /// The ego passes a slower vehicle.
    Passes,
    /// The ego speeds up for a lane change.
    ForLaneChange,
    /// The ego stops behind a lead, not for the subject of the class.
    BehindLead,
    /// The ego stops for a red light.
    RedLight,
    /// Something that the draft does not name holds the ego, and what it names does not.
    OtherCause,
    /// Nothing in the recording shows why the ego changes lanes.
    NoReason,
    /// The ego stands at the keyframe and waits: what lets it go comes later.
    WaitsFirst,
    /// The ego's motion is not that of the class.
    Motion,
    /// The record ends before it shows the decision that the class is about.
    Cut,
    /// The ego goes although its light is red.
    AgainstRed,
    /// Every wording states something that the recording contradicts.
    Words,
    /// The class has no texts that say what it is about and why that calls for this decision.
    Texts,
    /// The label checks find errors in the draft.
    Checks,
}

impl Doubt {
    /// In both languages.
    pub fn text(self) -> Bilingual {
        let (zh, en) = match self {
            Self::NotAhead => ("目标不在自车前方", "the target is not ahead of the ego"),
            Self::NotInLane => ("目标不在自车车道内", "the target is not in the ego's lane"),
            Self::OtherWay => {
                ("目标的行驶方向与场景不符", "the target does not move in the direction of the class")
            }
            Self::NotComing => ("目标没有靠近自车的路线", "the target does not come towards the ego's path"),
            Self::NotCrossing => ("目标没有横穿自车的路线", "the target does not cross the ego's path"),
            Self::NotStarting => ("目标不是刚刚起步", "the target has not just started"),
            Self::NotBraking => ("目标没有急减速", "the target does not brake hard"),
            Self::ChangesLane => ("目标只是在换道", "the target only changes lanes"),
            Self::NoObstacle => (
                "前方停着的是等灯的车队，不是障碍物",
                "the vehicles ahead wait at the light and are no obstacle",
            ),
            Self::EgoFirst => ("自车先通过，没有让行", "the ego passes first and does not yield"),
            Self::NotInRoundabout => ("自车还没有进入环岛", "the ego is not in the roundabout yet"),
            Self::NobodyBeside => ("旁边没有挡住视线的车辆", "no vehicle beside the ego hides the view"),
            Self::TurnsThere => ("自车是为路口转弯而减速", "the ego slows for its turn at the junction"),
            Self::Passes => ("自车正在超过一辆慢车", "the ego is passing a slower vehicle"),
            Self::ForLaneChange => ("自车是为换道而加速", "the ego speeds up to change lanes"),
            Self::BehindLead => ("自车是因为前车停下而减速", "the ego slows for a lead that stops"),
            Self::RedLight => ("自车是为红灯停车", "the ego stops for the red light"),
            Self::OtherCause => (
                "自车减速或停着是因为草稿没有提到的其他目标或信号灯",
                "the ego slows or stands for another object or a light that the draft does not name",
            ),
            Self::NoReason => {
                ("记录没有显示自车换道的原因", "the recording does not show why the ego changes lanes")
            }
            Self::WaitsFirst => (
                "自车在关键帧处还在等待，之后才起步",
                "the ego still waits at the keyframe and moves off later",
            ),
            Self::Motion => ("自车的实际运动与场景不符", "the motion of the ego does not fit the class"),
            Self::Cut => {
                ("记录在显示出自车的决策之前就结束了", "the record ends before it shows what the ego decides")
            }
            Self::AgainstRed => (
                "自车面对红灯却在行驶，记录没有显示原因",
                "the ego goes although its light is red, and the recording does not show why",
            ),
            Self::Words => (
                "可用的写法都与记录的运动或灯色不符",
                "the recorded motion or light contradicts every wording",
            ),
            Self::Texts => (
                "场景没有说明这一决策起因的草稿文本；请在 schema/draft_texts.yaml 的 classes 中补充",
                "the class has no texts for the cause of this decision: add them under classes in schema/draft_texts.yaml",
            ),
            Self::Checks => ("标签校验在草稿中发现错误", "the label checks find errors in the draft"),
        };
        Bilingual::new(zh, en)
    }
}

/// The motion of the target contradicts the class.
pub(super) fn of_target(
    class: &ScenarioId,
    w: &Driven<'_>,
    drive: &Drive,
    target: Option<&TrackId>,
) -> Option<Doubt> {
    let id = target?;
    let other = Other::of(w, id)?;
    let kind = drive.track(id).map_or(ObjectClass::Unknown, |t| t.class);
    let k = w.keyframe;
    let (l2, l3) = (class.l2.as_deref()?, class.l3.as_deref().unwrap_or_default());
    let known = |m: Option<Moves>, fits: &[Moves]| m.is_none_or(|m| fits.contains(&m));
    let ahead = |least: f64| other.number("target.longitudinal", k).is_none_or(|x| x > least);
    match (class.l1.as_str(), l2) {
        ("reactive_agent", "cutin") => {
            let comes = other.comes_nearer().is_none_or(|m| m > COMES_IN_M)
                || other.ever("target.is_lead", other.frames(0, 30)).is_true();
            first_of(&[
                (!ahead(-1.0), Doubt::NotAhead),
                (
                    l3 != "intersection" && !known(other.moves(k), &[Moves::Along, Moves::Still]),
                    Doubt::OtherWay,
                ),
                (!comes, Doubt::NotComing),
                (l3 == "from_stationary" && !just_started(&other), Doubt::NotStarting),
            ])
        }
        ("reactive_agent", "vru_crossing" | "animal") if l2 == "vru_crossing" || l3 == "crossing" => {
            first_of(&[(!ahead(0.0), Doubt::NotAhead), (!crosses(&other), Doubt::NotCrossing)])
        }
        ("reactive_agent", "vru_emergence") => {
            let near = other.nearest_aside(other.frames(0, 80)).is_none_or(|m| m < NEAR_PATH_M);
            let here = other.aside(k).is_none_or(|m| m < IN_LANE_M);
            let comes = here || other.comes_nearer().is_none_or(|m| m > COMES_IN_M);
            first_of(&[(!ahead(0.0), Doubt::NotAhead), (!near || !comes, Doubt::NotComing)])
        }
        ("reactive_agent", "vru_invasion") => {
            let in_lane = other.nearest_aside(other.frames(5, 10)).is_none_or(|m| m < IN_LANE_M);
            let way = match l3 {
                "opposite_direction" => known(other.moves(k), &[Moves::Against]),
                "vru_cutin" => known(other.moves(k), &[Moves::Along, Moves::Across, Moves::Still]),
                _ => known(other.moves(k), &[Moves::Along]),
            };
            let comes = other.comes_nearer().is_none_or(|m| m > COMES_IN_M) || in_lane;
            first_of(&[
                (!ahead(0.0), Doubt::NotAhead),
                (!way, Doubt::OtherWay),
                (l3 == "vru_cutin" && !comes, Doubt::NotComing),
                (l3 != "vru_cutin" && !in_lane, Doubt::NotInLane),
            ])
        }
        ("reactive_agent", "vehicle_abnormal") => abnormal(&other, w, l3, ahead(0.0)),
        ("reactive_agent", "following") => first_of(&[
            (!ahead(0.0), Doubt::NotAhead),
            (!is_lead(&other), Doubt::NotInLane),
            (!known(other.moves(k), &[Moves::Along, Moves::Still]), Doubt::OtherWay),
            (l3 == "lead_sudden_brake" && !brakes(&other), Doubt::NotBraking),
            (l3 == "follow_start" && !just_started(&other), Doubt::NotStarting),
        ]),
        ("reactive_agent", "intersection_interaction") => {
            // A road user that the ego lets pass may have left the path of a turn when the turn begins.
            let near = other.nearest_aside(other.frames(40, 120)).is_none_or(|m| m < NEAR_PATH_M);
            let through = l3 != "unprotected_left" && other.is_through();
            let way = match l3 {
                "cross_conflict" => known(other.moves(k), &[Moves::Across, Moves::Still]),
                "unprotected_left" => known(other.moves(k), &[Moves::Against, Moves::Across, Moves::Still]),
                _ => true,
            };
            let beside = l3 == "same_direction_turn";
            let turns = l3 == "right_vs_straight" && turns_off(&other, w);
            let gone = other.number("target.longitudinal", k).is_some_and(|x| x < GONE_M);
            first_of(&[
                (!way || turns, Doubt::OtherWay),
                (gone || (!beside && (!near || through)), Doubt::NotCrossing),
            ])
        }
        ("reactive_agent", "passing") => first_of(&[
            (!ahead(0.0), Doubt::NotAhead),
            (!known(other.moves(k), &[Moves::Against]), Doubt::OtherWay),
        ]),
        ("safety", "near_miss") => {
            let least = |name: &str| other.least(name, other.frames(5, 5));
            let [ttc, distance] = [least("target.ttc_box"), least("target.distance")];
            let near = ttc.is_none_or(|s| s < NEAR_MISS_S) || distance.is_none_or(|m| m < NEAR_MISS_M);
            // One that comes towards the ego in its own lane passes beside it.
            let passes = other.moves(k) == Some(Moves::Against)
                && other.nearest_aside(other.frames(0, SOON_FRAMES)).is_some_and(|m| m > IN_LANE_M);
            (!near || passes).then_some(Doubt::NotComing)
        }
        ("proactive", "lane_change") if matches!(l3, "" | "efficiency" | "overtake") => {
            // It is coming in from the next lane.
            let moves = other.number("target.speed", k).is_some_and(|v| v > STOOD_MPS);
            let enters = moves && other.ever("target.wheel_over_line", other.frames(0, 0)).is_true();
            // It changes to the same side: the ego stays behind it.
            let side = first_lane_change(w, k..(k + TURN_FRAMES).min(w.end));
            let side = side.map(|(_, left)| if left { "left" } else { "right" });
            let goes_along = side.is_some() && other.category("target.lane_change", k) == side;
            (enters || goes_along).then_some(Doubt::NotInLane)
        }
        ("proactive", "obstacle_avoidance") => {
            let width = super::lead::size_at(drive, id, k).map_or(f64::NAN, |(_, width)| width);
            let half = if width.is_finite() { width / 2.0 } else { 1.0 };
            let aside = other.least("target.lane_centre_distance", other.frames(10, 20));
            let still = matches!(kind, ObjectClass::Cone | ObjectClass::Barrier | ObjectClass::StaticObject);
            first_of(&[
                (!ahead(-2.0), Doubt::NotAhead),
                (!still && aside.is_some_and(|m| m > LANE_SIDE_M + half), Doubt::NotInLane),
            ])
        }
        _ => None,
    }
}

/// The road user's heading changes too much for one that goes straight.
fn turns_off(other: &Other<'_>, w: &Driven<'_>) -> bool {
    let heading =
        |f: usize| Some(w.number("ego.heading", f)? + other.number("target.heading_difference", f)?);
    let k = other.keyframe();
    let change = heading(k).zip(heading(k + TURN_FRAMES)).map(|(now, then)| turned(now, then).abs());
    change.is_some_and(|turn| turn > TURNS_RAD)
}

fn first_of(all: &[(bool, Doubt)]) -> Option<Doubt> {
    all.iter().find(|(holds, _)| *holds).map(|(_, doubt)| *doubt)
}

/// It goes across the path and gets onto it, or is on it already.
fn crosses(other: &Other<'_>) -> bool {
    let k = other.keyframe();
    // A road user that first walks along the road may turn onto it only after the keyframe.
    let ways = other.frames(5, 80).filter_map(|f| other.moves(f)).collect::<Vec<_>>();
    let goes = ways.is_empty() || ways.contains(&Moves::Across);
    let gets_there = other.first().is_none_or(|f| f != First::Neither);
    let here = other.aside(k).is_some_and(|m| m < IN_LANE_M);
    goes && (gets_there || here)
}

fn just_started(other: &Other<'_>) -> bool {
    let k = other.keyframe();
    let slow = other.number("target.speed", k).is_none_or(|v| v < JUST_STARTED_MPS);
    let stood = other.least("target.speed", other.frames(50, 0)).is_none_or(|v| v < STOOD_MPS);
    slow && stood
}

fn brakes(other: &Other<'_>) -> bool {
    // What brakes only later is not seen at the keyframe.
    let hard = other.least("target.accel", other.frames(5, 5)).is_none_or(|a| a < BRAKES_MPS2);
    let before = other.number("target.speed", other.keyframe().saturating_sub(SOON_FRAMES / 2));
    let least = other.least("target.speed", other.frames(0, SOON_FRAMES / 2));
    hard && before.zip(least).is_none_or(|(before, least)| before - least > LOST_MPS)
}

/// It is the lead at the keyframe, or one second before or after it.
fn is_lead(other: &Other<'_>) -> bool {
    other.ever("target.is_lead", other.frames(10, 10)) != Tri::False
}

fn abnormal(other: &Other<'_>, w: &Driven<'_>, l3: &str, ahead: bool) -> Option<Doubt> {
    let k = w.keyframe;
    let lane = |frames| other.ever("target.in_ego_lane", frames) != Tri::False;
    let along = other.moves(k).is_none_or(|m| matches!(m, Moves::Along | Moves::Still));
    match l3 {
        "sudden_brake" => first_of(&[
            (!ahead, Doubt::NotAhead),
            (!lane(other.frames(10, 5)), Doubt::NotInLane),
            (!along, Doubt::OtherWay),
            (!brakes(other), Doubt::NotBraking),
        ]),
        "cutout_reveal" => {
            let red = matches!(light_state(w.signals, k), Some("red" | "yellow" | "red_yellow"));
            first_of(&[
                (!ahead, Doubt::NotAhead),
                (!lane(other.frames(20, 0)), Doubt::NotInLane),
                (!along, Doubt::OtherWay),
                (red, Doubt::NoObstacle),
            ])
        }
        "abnormal_motion" => {
            let wrong_way = other.ever("target.wrong_way", other.frames(0, 0)).is_true();
            let changes = other
                .frames(30, 40)
                .any(|f| matches!(other.category("target.lane_change", f), Some("left" | "right")));
            first_of(&[(!ahead, Doubt::NotAhead), (!wrong_way && changes, Doubt::ChangesLane)])
        }
        _ => None,
    }
}

/// The ego's motion contradicts the class, or something nearer explains it.
pub(super) fn of_ego(
    class: &ScenarioId,
    w: &Driven<'_>,
    course: Option<&Course>,
    drive: &Drive,
    target: Option<&TrackId>,
    decision: &DrivingDecision,
    motion: LongitudinalMotion,
) -> Option<Doubt> {
    let (l2, l3) = (class.l2.as_deref()?, class.l3.as_deref().unwrap_or_default());
    let slows = matches!(motion, LongitudinalMotion::Slows | LongitudinalMotion::Stops);
    let faster = motion == LongitudinalMotion::SpeedsUp;
    match (class.l1.as_str(), l2) {
        ("proactive", "roundabout") if matches!(l3, "lane_in_roundabout" | "exit") => {
            let inside = w.flag("map.in_roundabout", w.keyframe) != Tri::False
                || w.flag("ego.in_junction", w.keyframe).is_true();
            // An ego that has only just come in, and stays for a while, is at its entry.
            let stays = w.flag("map.in_roundabout", w.keyframe + STAYS_FRAMES).is_true();
            let enters = l3 == "exit"
                && stays
                && w.keyframe.checked_sub(ENTERED_FRAMES).is_some_and(|f| {
                    w.flag("map.in_roundabout", f) == Tri::False && w.flag("ego.in_junction", f) == Tri::False
                });
            (!inside || enters).then_some(Doubt::NotInRoundabout)
        }
        ("reactive_road", "blind_spot_slowdown") if l3 == "ramp" => {
            // The ego slows for the ramp that it takes itself.
            let exits = w.category("map.merge_zone", w.keyframe) == Some("deceleration")
                || w.flag("map.on_ramp", w.keyframe).is_true();
            (exits && slows).then_some(Doubt::Motion)
        }
        ("reactive_road", "blind_spot_slowdown") if l3 == "vehicle" => {
            (!is_somebody_beside(w, drive)).then_some(Doubt::NobodyBeside)
        }
        ("reactive_road", "geometry_adaptation") => {
            let turns = (w.keyframe..w.end)
                .any(|f| matches!(w.category("ego.movement", f), Some("left" | "right" | "uturn")));
            let soon = w.keyframe..(w.keyframe + SOON_FRAMES).min(w.end);
            let most = w.heading_changes(w.end).into_iter().map(f64::abs).max_by(f64::total_cmp);
            let straight = !slows && w.lasts(6.0) && most.is_some_and(|turn| turn < BEND_RAD);
            first_of(&[
                (l3 == "high_curvature" && slows && turns, Doubt::TurnsThere),
                (l3 == "high_curvature" && straight, Doubt::Motion),
                (faster && is_passing(w), Doubt::Passes),
                (faster && first_lane_change(w, soon).is_some(), Doubt::ForLaneChange),
            ])
        }
        ("reactive_agent", "following" | "vehicle_abnormal")
            if matches!(l3, "lead_sudden_brake" | "sudden_brake") =>
        {
            let k = w.keyframe;
            let falls =
                w.speed(k).zip(w.speed(k + SOON_FRAMES)).is_none_or(|(now, then)| then < now - ANSWER_MPS);
            let rises = course.is_some_and(|c| c.trend == Trend::Rises);
            (!falls || faster || rises).then_some(Doubt::Motion)
        }
        ("reactive_agent", "vru_crossing" | "intersection_interaction")
            if decision.longitudinal == Some(Longitudinal::YieldToAgent) =>
        {
            let first = target.and_then(|id| Other::of(w, id)?.first());
            (first == Some(First::Ego)).then_some(Doubt::EgoFirst)
        }
        ("reactive_agent", "vru_crossing" | "intersection_interaction")
            if decision.longitudinal == Some(Longitudinal::Resume)
                && motion == LongitudinalMotion::Starts =>
        {
            // An ego that moves off although the other still has to pass in front of it does so for another reason.
            let green = light_state(w.signals, w.keyframe).is_some_and(is_green);
            let other = target.and_then(|id| Other::of(w, id));
            let ahead = other.is_some_and(|o| {
                o.number("target.longitudinal", w.keyframe).is_some_and(|x| x > 0.0)
                    && o.first() == Some(First::Other)
                    && !o.is_through()
            });
            (ahead && !green).then_some(Doubt::Motion)
        }
        _ => None,
    }
}

/// Something nearer than the subject of the class explains why the ego slows: a lead that stops, or a red light.
pub(super) fn of_nearer(
    class: &ScenarioId,
    w: &Driven<'_>,
    asked: &Asked<'_>,
    decision: &DrivingDecision,
    motion: LongitudinalMotion,
) -> Option<Doubt> {
    use Longitudinal::{RoadSpeedAdaptation, StopForObstacle, StopForRegulation, YieldToAgent};
    let slowing = [YieldToAgent, StopForObstacle, StopForRegulation, RoadSpeedAdaptation];
    let decided = decision.longitudinal.filter(|d| slowing.contains(d) && !asked.is_safety)?;
    let stops = |lead: &Lead<'_>| lead.stops() || asked.is_stopped_behind;
    let lead = asked
        .lead
        .filter(|lead| asked.lead_is == LeadIs::Nearer && lead.is_cause_of(LongitudinalMotion::Slows));
    // The texts of turns name a red light themselves.
    let names_light = matches!(class.l2.as_deref(), Some("traffic_light" | "turn"));
    let of_others = asked.of_others && class.l2.as_deref() != Some(MEETING);
    let of_light = decided != StopForRegulation && !names_light && !of_others;
    let red = matches!(light_state(w.signals, w.keyframe), Some("red" | "red_yellow" | "yellow"));
    // An ego that loses half of its speed close to the light slows for it, even if it turns green before the ego
    // stands.
    let near = w.number("map.distance_to_junction", w.keyframe).is_some_and(|m| m < NEAR_LIGHT_M);
    let later = w.speed(w.keyframe + HALVES_FRAMES);
    let halves = w.speed(w.keyframe).zip(later).is_some_and(|(now, then)| then < now / 2.0);
    let stops_at_it = motion == LongitudinalMotion::Stops || (near && halves);
    first_of(&[
        (lead.as_ref().is_some_and(stops), Doubt::BehindLead),
        (of_light && red && stops_at_it, Doubt::RedLight),
    ])
}

/// An ego that waits behind a standing lead, or at a junction whose turn is not known, and moves off later has no
/// reason for it at the keyframe.
pub(super) fn of_wait(
    class: &ScenarioId,
    asked: &Asked<'_>,
    decision: &DrivingDecision,
    motion: LongitudinalMotion,
) -> Option<Doubt> {
    let resumes = decision.longitudinal == Some(Longitudinal::Resume) && motion == LongitudinalMotion::Waits;
    let is_open = class.l2.as_deref() == Some("turn") && class.l3.is_none();
    let is_held = is_open || asked.lead.is_some_and(|lead| lead.stands());
    (resumes && is_held).then_some(Doubt::WaitsFirst)
}

/// The class exists because the ego did something, and nothing of it is seen; or the ego, which had not slowed, speeds
/// up where the class is about the road.
pub(super) fn of_nothing(w: &Driven<'_>, asked: &Asked<'_>, decision: &DrivingDecision) -> Option<Doubt> {
    let nothing = decision.longitudinal.is_none() && decision.lateral.is_none();
    // The class states a turn, and the ego's is to the other side.
    let no_side = decision.lateral == Some(Lateral::Turn)
        && decision.lateral_direction.is_none()
        && asked.mandated.is_none()
        && w.signals.shows_all("ego.movement");
    let missing = (nothing && asked.decides()) || no_side;
    let against = asked.of_road
        && decision.longitudinal == Some(Longitudinal::SetSpeedTracking)
        && !had_slowed(w.signals, w.keyframe);
    first_of(&[(missing && !w.lasts(CUT_S), Doubt::Cut), (missing || against, Doubt::Motion)])
}

/// A lane change for a faster road user, or without one in the ego's way, has its reason outside of the recording.
pub(super) fn of_reason(class: &ScenarioId, w: &Driven<'_>, target: Option<&TrackId>) -> Option<Doubt> {
    let unknown = class.l2.as_deref() == Some("lane_change")
        && matches!(class.l3.as_deref(), None | Some("efficiency"));
    let slower = target.and_then(|id| Other::of(w, id)).is_some_and(|other| {
        let relative = other.number("target.relative_speed", w.keyframe);
        let limit = w.number("map.speed_limit", w.keyframe);
        let below_limit = other
            .number("target.speed", w.keyframe)
            .zip(limit)
            .is_some_and(|(v, limit)| v < limit - BELOW_MPS);
        let is_seen = other.number("target.longitudinal", w.keyframe).is_some_and(|x| x > 0.0);
        is_seen && (relative.is_none_or(|v| v <= FASTER_MPS) || (class.l3.is_some() && below_limit))
    });
    (unknown && !slower).then_some(Doubt::NoReason)
}

/// A vehicle is beside the ego or slightly ahead of it, in another lane.
fn is_somebody_beside(w: &Driven<'_>, drive: &Drive) -> bool {
    if w.signals.targets.is_empty() || !w.signals.target_columns.contains_key("target.lateral") {
        return true;
    }
    w.signals.targets.iter().any(|t| {
        let vehicle = drive.track(&t.id).is_some_and(|t| t.class.is_vehicle());
        let Some(other) = Other::of(w, &t.id).filter(|_| vehicle) else { return false };
        other.frames(5, 20).step_by(5).any(|f| {
            let at = other.number("target.longitudinal", f).zip(other.number("target.lateral", f));
            at.is_some_and(|(x, y)| (-4.0..25.0).contains(&x) && (1.5..8.0).contains(&y.abs()))
        })
    })
}

/// The ego passes a much slower vehicle: one is close ahead of its path or beside it, and outside of its lane by then.
fn is_passing(w: &Driven<'_>) -> bool {
    let Some(speed) = w.speed(w.keyframe) else { return false };
    w.signals.targets.iter().any(|t| {
        let Some(other) = Other::of(w, &t.id) else { return false };
        let k = w.keyframe;
        let slow = other.number("target.speed", k).is_some_and(|v| v < speed - PASSED_MPS);
        let along = other.moves(k) == Some(Moves::Along);
        let near = other.number("target.longitudinal", k).is_some_and(|x| (-5.0..PASSED_M).contains(&x));
        let aside = other.aside(k).is_some_and(|m| (1.5..7.0).contains(&m));
        slow && along && near && aside
    })
}
