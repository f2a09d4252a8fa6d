//! Text of what could be observed at the keyframe: the target, the light, the road, and the route as it was commanded
//! or signaled by then. Nothing after the keyframe is read: the later maneuver is not the intention that caused it.

use super::change::OTHER_FRAMES;
use super::lead::{self, Lead};
use super::moment::{Moment, light_state};
use whyroad_framework::Framework;
use whyroad_framework::draft_texts::DoingWhen;
use whyroad_model::messages::{CriticalComponent, EpisodeRecord};
use whyroad_model::names::class_name;
use whyroad_model::{Bilingual, ComponentCategory, Drive, Lang, ObjectClass, SignalTable, TrackId, Tri};

/// Objects nearer than this along the ego's path are beside it, even if they are short, m.
const BESIDE_M: f64 = 3.0;
/// Objects farther than this from the ego's center line are on a side, m.
const ASIDE_M: f64 = 1.8;
/// The same for road users that enter the ego's lane, m; nearer to its center, they are in it.
const FROM_A_SIDE_M: f64 = 1.0;

/// Minimum difference of speeds that is mentioned, m/s.
const NOTABLY_MPS: f64 = 1.0;

/// A lead that is slower than the ego by this is called slow, even if it speeds up, m/s.
const MUCH_SLOWER_MPS: f64 = 1.0;

/// Minimum speed and acceleration of a vehicle that is moving off, m/s, m/s2.
const MOVING_OFF_MPS: f64 = 0.2;
const MOVING_OFF_MPS2: f64 = 0.3;

/// Minimum speed towards the middle of the ego's lane of a road user that plainly enters it, m/s.
const ENTERING_MPS: f64 = 0.3;

/// A road user that is faster than this does not stand, m/s: half of a slow walk.
const MOVING_MPS: f64 = 0.4;

/// The L2 class about traffic lights.
const TRAFFIC_LIGHT: &str = "traffic_light";

/// The L2 class about following.
const FOLLOWING: &str = "following";

/// The L3 class about going straight through a junction, and the movement of an ego that does.
const STRAIGHT: &str = "straight";

/// The L1 class about the road.
pub(super) const ROAD: &str = "reactive_road";

fn is_of_lights(episode: &EpisodeRecord) -> bool {
    episode.scenario_id.l2.as_deref() == Some(TRAFFIC_LIGHT)
}

/// Rules about other road users also read the bend of the road, to determine who follows it; the bend is not relevant
/// there.
fn is_of_bend(episode: &EpisodeRecord) -> bool {
    episode.scenario_id.l1 == ROAD && episode.signals.iter().any(|s| s.starts_with("map.curvature"))
}

fn is_of_junction(episode: &EpisodeRecord) -> bool {
    episode.signals.iter().any(|s| s == "ego.movement")
}

/// The class is about the ego's lane, which it also changes where no junction is near.
fn is_of_lanes(episode: &EpisodeRecord) -> bool {
    matches!(episode.scenario_id.l2.as_deref(), Some("lane_change" | "merge_interaction"))
}

/// What is said of a road user that stands.
const STANDS: (&str, &str) = ("静止不动", "is standing still");

/// True if the text says that its subject stands.
pub(super) fn says_standing(text: &str) -> bool {
    text.contains(STANDS.0) || text.contains(STANDS.1)
}

/// How the position of a road user is described.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Named {
    /// By its position relative to the ego.
    ByPlace,
    /// As the vehicle ahead of the ego.
    AsLead,
}

/// The input: an episode at its keyframe.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub framework: &'a Framework,
    pub drive: &'a Drive,
    pub signals: &'a SignalTable,
    pub episode: &'a EpisodeRecord,
    /// The subject of the class.
    pub target: Option<&'a TrackId>,
    pub keyframe: usize,
    /// The table has the frames before the keyframe and after it.
    pub has_course: bool,
}

impl Scene<'_> {
    /// The subject of the class, as shown by the signals.
    pub(super) fn observed(&self, moment: &Moment<'_>, lang: Lang) -> Vec<CriticalComponent> {
        let Scene { framework, signals, episode, keyframe, .. } = *self;
        let mut found: Vec<CriticalComponent> = Vec::new();
        let told = framework.draft_texts.doing_when(&episode.scenario_id).iter();
        let told = told.filter(|when| moment.all(&when.when)).map(DoingWhen::texts).next();
        let doing = told.or_else(|| framework.draft_texts.doing(&episode.scenario_id));
        // Whom the ego follows is ahead even where another is the lead for a moment.
        let is_followed = episode.scenario_id.l2.as_deref() == Some(FOLLOWING);
        let named = if is_followed { Named::AsLead } else { Named::ByPlace };
        found.extend(self.target.and_then(|target| self.object(target, doing, named, lang)));
        let mut add = |category, text: Option<Bilingual>| {
            found.extend(text.map(|text| component(category, &text, lang)));
        };
        // Only what affects the decision: with a lead or a crossing pedestrian, the light does not.
        if is_of_lights(episode) {
            add(ComponentCategory::TrafficLights, light(signals, keyframe));
        }
        if is_of_bend(episode) {
            add(ComponentCategory::RoadEvents, bend(signals, keyframe));
        }
        if framework.draft_texts.is_routed(&episode.scenario_id) {
            let intent = route(signals, keyframe).or_else(|| {
                // An indicator that was left on, or is for an earlier lane change, is no evidence of this turn.
                // Nor is one of a way straight on.
                let goes_straight = moment.category("ego.movement") == Some(STRAIGHT);
                let is_straight = goes_straight || episode.scenario_id.l3.as_deref() == Some(STRAIGHT);
                let tells = is_of_junction(episode) && !is_straight && !moment.indicator_against();
                tells.then(|| signaled_turn(signals, keyframe, !is_of_lanes(episode))).flatten()
            });
            add(ComponentCategory::RoutingIntent, intent);
        }
        found
    }

    /// The direction in which the ego intends to turn, if the route or its indicator shows it and the class is not
    /// about it.
    pub(super) fn turn_intent(&self, moment: &Moment<'_>, lang: Lang) -> Option<CriticalComponent> {
        if self.framework.draft_texts.is_routed(&self.episode.scenario_id) {
            return None;
        }
        // Where the class is about a junction, the road user names it.
        let names_it = self.episode.scenario_id.l2.as_deref() == Some("intersection_interaction");
        let signaled = || {
            let on = if names_it { signal(self.signals, self.keyframe) } else { None };
            let on = on.or_else(|| signaled_turn(self.signals, self.keyframe, true));
            on.filter(|_| !moment.indicator_against())
        };
        let text = route(self.signals, self.keyframe).or_else(signaled)?;
        Some(component(ComponentCategory::RoutingIntent, &text, lang))
    }

    /// The light that the ego faces, if it concerns what the ego does and the class is not about it.
    pub(super) fn light(&self, moment: &Moment<'_>, lang: Lang) -> Option<CriticalComponent> {
        if is_of_lights(self.episode) || !moment.concerns_light() {
            return None;
        }
        let text = light(self.signals, self.keyframe)?;
        Some(component(ComponentCategory::TrafficLights, &text, lang))
    }

    /// The lead, if it is not the subject of the class.
    pub(super) fn lead(&self, lead: &Lead<'_>, lang: Lang) -> Option<CriticalComponent> {
        self.object(lead.id, None, Named::AsLead, lang)
    }

    /// Position and motion of a road user; `doing` replaces the motion where the class describes it better.
    fn object(
        &self,
        id: &TrackId,
        doing: Option<(&str, &str)>,
        named: Named,
        lang: Lang,
    ) -> Option<CriticalComponent> {
        let text = self.target_in_words(id, doing, named)?;
        let linked_objects = vec![id.to_string()];
        Some(CriticalComponent {
            linked_objects,
            ..component(ComponentCategory::CriticalObjects, &text, lang)
        })
    }
}

/// True for a component about a traffic light.
pub(super) fn is_light(component: &CriticalComponent) -> bool {
    component.category.as_deref() == Some(ComponentCategory::TrafficLights.id())
}

/// True for a component about the route.
pub(super) fn is_route(component: &CriticalComponent) -> bool {
    component.category.as_deref() == Some(ComponentCategory::RoutingIntent.id())
}

fn component(category: ComponentCategory, text: &Bilingual, lang: Lang) -> CriticalComponent {
    CriticalComponent {
        category: Some(category.id().to_owned()),
        description: text.get(lang).to_owned(),
        uncertainty: None,
        id: None,
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    }
}

impl Scene<'_> {
    /// Position and motion of a road user.
    fn target_in_words(&self, id: &TrackId, doing: Option<(&str, &str)>, named: Named) -> Option<Bilingual> {
        let Scene { drive, signals, keyframe: frame, .. } = *self;
        let class = drive.track(id).map_or(ObjectClass::Unknown, |t| t.class);
        let row = signals.target(id)?.row(frame)?;
        let number = |name: &str| signals.target_columns.get(name).and_then(|c| c.number(row));
        let holds = |name: &str| signals.target_columns.get(name).is_some_and(|c| c.flag(row).is_true());
        let is_lead = holds("target.is_lead");
        let crosses_a_line = holds("target.wheel_over_line")
            || number("target.lane_lateral_speed").is_some_and(|v| v > ENTERING_MPS);
        let (ahead, aside) = (number("target.longitudinal")?, number("target.lateral")?);
        let turned = number("target.heading_difference").map(f64::abs);
        let same_way = turned.is_some_and(|a| a < 45_f64.to_radians());
        // Opposite headings within 45 degrees; in a hairpin bend, a lead has one too.
        let oncoming = !is_lead && turned.is_some_and(|a| a > 135_f64.to_radians());
        // One whose center is in the lane already only comes in while it still moves towards the middle; one that is
        // partly in it and moves away leaves it.
        let is_inside = holds("target.in_ego_lane") || holds("target.is_follower");
        let enters = match number("target.lane_lateral_speed") {
            towards if is_inside => {
                holds("target.wheel_over_line") && towards.is_some_and(|v| v > ENTERING_MPS)
            }
            towards => crosses_a_line && towards.is_none_or(|v| v > 0.0),
        };
        let comes_in = enters && !is_lead && !oncoming;
        // In a bend a lead is on a side of the ego and turned, and in its lane nevertheless.
        let in_lane = number("target.lane_centre_distance").is_some_and(|m| m < FROM_A_SIDE_M);
        let place = if is_lead && same_way && !crosses_a_line && ahead > BESIDE_M {
            Bilingual::new("本车道前方", "ahead in the ego's lane")
        } else if named == Named::AsLead || (is_lead && (!crosses_a_line || in_lane)) {
            Bilingual::new("前方", "ahead")
        } else {
            // A road user that enters the lane does so from a side.
            let from_m = if crosses_a_line { FROM_A_SIDE_M } else { ASIDE_M };
            let beside_m = if is_lead { 0.0 } else { self.beside(id, turned) };
            place(ahead, aside, beside_m, from_m)
        };
        let name = match class {
            ObjectClass::StaticObject => Bilingual::new("障碍物", "obstacle"),
            _ => class_name(class),
        };
        let is_fixed = matches!(class, ObjectClass::Cone | ObjectClass::Barrier | ObjectClass::StaticObject);
        // Its standstill ends only with the hysteresis of the signal.
        let speed = number("target.speed");
        let stands = signals.target_columns.get("target.standstill").map_or(Tri::Unknown, |c| c.flag(row));
        // Seen for the first time, nobody can tell how it moves: that it does is known later.
        let has_speeds = signals.target_columns.contains_key("target.speed");
        if !is_fixed && has_speeds && speed.is_none() && stands == Tri::Unknown {
            return Some(Bilingual::new(
                format!("{}有{}", place.zh, name.zh),
                format!("the {} is {}", name.en, place.en),
            ));
        }
        let moves_off = speed.is_some_and(|v| v > MOVING_MPS)
            || (speed.is_some_and(|v| v > MOVING_OFF_MPS)
                && number("target.accel").is_some_and(|a| a > MOVING_OFF_MPS2));
        let doing = if let Some((zh, en)) = doing {
            Bilingual::new(zh, en)
        } else if is_fixed || (stands.is_true() && !moves_off) {
            Bilingual::new(STANDS.0, STANDS.1)
        } else if class.is_vru() && holds("target.on_crosswalk") {
            Bilingual::new("正在斑马线上通行", "is on the crosswalk")
        } else if class.is_vru() && number("target.crossing_angle").is_some_and(|a| a > 20_f64.to_radians()) {
            if ahead > 0.0 {
                Bilingual::new("正在横穿自车前方的道路", "is crossing the road in front of the ego")
            } else {
                Bilingual::new("正在横穿道路", "is crossing the road")
            }
        } else if comes_in && class.is_vehicle() {
            Bilingual::new("正在驶入自车车道", "is coming into the ego's lane")
        } else if comes_in {
            Bilingual::new("正在进入自车车道", "is coming into the ego's lane")
        } else {
            let speeds =
                || Some(number("target.speed")? - signals.frame_columns.get("ego.speed")?.number(frame)?);
            let faster = number("target.relative_speed").or_else(speeds).filter(|v| is_lead && !v.is_nan());
            let of_it = Moment::of(signals, frame, Some(id), None).with_course(self.has_course);
            // The acceleration of one frame is not seen, the change of a speed is. Stage I has its table of the last
            // frame only.
            let seen = |change: &str| match of_it.change(change) {
                Tri::Unknown => !self.has_course && frame >= OTHER_FRAMES,
                known => known.is_true(),
            };
            match number("target.accel") {
                _ if oncoming && class == ObjectClass::Pedestrian => {
                    Bilingual::new("正迎面走来", "is coming towards the ego")
                }
                _ if oncoming && ahead < -BESIDE_M => {
                    Bilingual::new("已经对向驶过", "has come the other way and passed")
                }
                _ if oncoming => Bilingual::new("正对向驶来", "is oncoming"),
                Some(a) if a < -0.5 && seen("past.target_slowed") => Bilingual::new("正在减速", "is slowing"),
                // A lead that the ego closes in on is slow first of all.
                Some(a)
                    if a > 0.5
                        && seen("past.target_gained")
                        && faster.is_none_or(|v| v > -MUCH_SLOWER_MPS) =>
                {
                    Bilingual::new("正在加速", "is speeding up")
                }
                _ if faster.is_some_and(|v| v < -NOTABLY_MPS) => {
                    Bilingual::new("车速低于自车", "is slower than the ego")
                }
                _ if faster.is_some_and(|v| v > NOTABLY_MPS) => {
                    Bilingual::new("车速高于自车", "is faster than the ego")
                }
                _ if faster.is_some() => {
                    Bilingual::new("车速与自车相近", "is driving at about the ego's speed")
                }
                _ if class == ObjectClass::Pedestrian => Bilingual::new("正在走动", "is walking"),
                _ if class.is_vru() => Bilingual::new("正在骑行", "is riding"),
                _ if class == ObjectClass::Animal => Bilingual::new("正在移动", "is moving"),
                _ => Bilingual::new("正在行驶", "is driving"),
            }
        };
        Some(Bilingual::new(
            format!("{}的{}{}", place.zh, name.zh, doing.zh),
            format!("the {} {} {}", name.en, place.en, doing.en),
        ))
    }

    /// Distance along the ego's path below which the boxes of both overlap, so one is beside the other, m.
    fn beside(&self, id: &TrackId, turned: Option<f64>) -> f64 {
        let ego = self.drive.ego.as_ref().map(|e| e.length_m);
        let (length, width) = lead::size_at(self.drive, id, self.keyframe).unwrap_or((f64::NAN, f64::NAN));
        let angle = turned.unwrap_or(0.0);
        let reach = (ego.unwrap_or(f64::NAN) + length * angle.cos().abs() + width * angle.sin().abs()) / 2.0;
        if reach.is_finite() { reach.max(BESIDE_M) } else { BESIDE_M }
    }
}

/// Ahead, behind or beside, from the position in the ego's frame (m); beside within `beside_m`, on a side from
/// `aside_m` on.
fn place(longitudinal_m: f64, lateral_m: f64, beside_m: f64, aside_m: f64) -> Bilingual {
    let side = match lateral_m {
        y if y > aside_m => Some(("左", "left")),
        y if y < -aside_m => Some(("右", "right")),
        _ => None,
    };
    match (longitudinal_m > beside_m, longitudinal_m < -beside_m, side) {
        (true, _, Some((zh, en))) => Bilingual::new(format!("{zh}前方"), format!("ahead on the {en}")),
        (true, _, None) => Bilingual::new("正前方", "straight ahead"),
        (_, true, Some((zh, en))) => Bilingual::new(format!("{zh}后方"), format!("behind on the {en}")),
        (_, true, None) => Bilingual::new("正后方", "behind"),
        (_, _, Some((zh, en))) => Bilingual::new(format!("{zh}侧"), format!("on the {en}")),
        _ => Bilingual::new("紧邻", "very close"),
    }
}

fn light(signals: &SignalTable, frame: usize) -> Option<Bilingual> {
    let (zh, en) = match light_state(signals, frame)? {
        "red" => ("红灯", "red"),
        "yellow" => ("黄灯", "yellow"),
        "green" => ("绿灯", "green"),
        "green_round" => ("圆形绿灯", "round green"),
        "green_arrow" => ("绿色箭头灯", "green arrow"),
        "flashing_green" => ("绿闪", "flashing green"),
        "green_yield" => ("绿灯，但须让行", "green, but the ego has to give way"),
        "red_yellow" => ("红黄灯", "red and yellow"),
        "flashing_yellow" => ("黄灯闪烁", "flashing yellow"),
        _ => return None,
    };
    Some(Bilingual::new(format!("本车道信号灯为{zh}"), format!("the light for the ego's lane is {en}")))
}

fn bend(signals: &SignalTable, frame: usize) -> Option<Bilingual> {
    let here = signals.frame_columns.get("map.curvature")?.number(frame)?;
    let ahead =
        signals.frame_columns.get("map.curvature_ahead").and_then(|c| c.number(frame)).unwrap_or(here);
    // A radius below 100 m is clearly a bend; the class's own threshold decides about the class, this one does not.
    (here.abs().max(ahead.abs()) > 0.01)
        .then(|| Bilingual::new("前方道路为急弯", "the road ahead bends sharply"))
}

/// The ego is inside a junction, so the junction is no longer ahead.
fn is_inside(signals: &SignalTable, frame: usize) -> bool {
    signals.frame_columns.get("ego.in_junction").is_some_and(|c| c.flag(frame).is_true())
}

/// The command of the navigation.
fn route(signals: &SignalTable, frame: usize) -> Option<Bilingual> {
    let command = signals.frame_columns.get("route.command")?.category(frame)?;
    let (zh, en) = match (command, is_inside(signals, frame)) {
        ("straight", false) => {
            ("导航路线在前方路口直行", "the route leads straight on at the junction ahead")
        }
        ("left", false) => ("导航路线在前方路口左转", "the route leads left at the junction ahead"),
        ("right", false) => ("导航路线在前方路口右转", "the route leads right at the junction ahead"),
        ("uturn", false) => ("导航路线在前方路口掉头", "the route makes a U-turn at the junction ahead"),
        ("straight", true) => (
            "自车已在路口内，导航路线为直行",
            "the ego is in the junction, where its route leads straight on",
        ),
        ("left", true) => {
            ("自车已在路口内，导航路线为左转", "the ego is in the junction, where its route leads left")
        }
        ("right", true) => {
            ("自车已在路口内，导航路线为右转", "the ego is in the junction, where its route leads right")
        }
        ("uturn", true) => {
            ("自车已在路口内，导航路线为掉头", "the ego is in the junction, where its route makes a U-turn")
        }
        ("exit", _) => ("导航路线从前方出口驶出", "the route takes the exit ahead"),
        _ => return None,
    };
    Some(Bilingual::new(zh, en))
}

/// The ego's turn signal, in a text that already names the junction.
fn signal(signals: &SignalTable, frame: usize) -> Option<Bilingual> {
    match signals.frame_columns.get("ego.turn_signal")?.category(frame)? {
        "left" => Some(Bilingual::new("自车已打左转向灯", "the ego signals left")),
        "right" => Some(Bilingual::new("自车已打右转向灯", "the ego signals right")),
        _ => None,
    }
}

/// What the ego's own turn signal announces: a turn at a junction, or in classes about lanes a change of lane.
fn signaled_turn(signals: &SignalTable, frame: usize, at_junction: bool) -> Option<Bilingual> {
    let on = signals.frame_columns.get("ego.turn_signal")?.category(frame)?;
    let (zh, en) = match on {
        "left" => ("左转向灯", "left"),
        "right" => ("右转向灯", "right"),
        _ => return None,
    };
    Some(if is_inside(signals, frame) {
        Bilingual::new(
            format!("自车已在路口内，打着{zh}"),
            format!("the ego is in the junction and signals {en}"),
        )
    } else if at_junction {
        Bilingual::new(
            format!("前方为路口，自车已打{zh}"),
            format!("a junction lies ahead and the ego signals {en}"),
        )
    } else {
        Bilingual::new(format!("自车已打{zh}"), format!("the ego signals {en}"))
    })
}
