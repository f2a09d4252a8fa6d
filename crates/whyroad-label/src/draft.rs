//! Label skeletons: pre-filled with what mining and the ego's own motion show; the rest is left for a person.
//!
//! A skeleton is never a finished label. Its provenance is a rule, the label checks recognize its trace when a person
//! submits it unchanged, and its notes list what was inferred from what, and what the annotator must still add. Causes
//! are taken only from what could be observed at or before the keyframe; decisions only from the motion after it
//! (LABELING.md 6).

mod change;
mod clip;
mod components;
mod decision;
mod doubt;
mod lead;
mod moment;
mod motion;
mod records;
mod rival;
mod subjects;
mod trace;
mod wording;

pub use doubt::Doubt;
pub use motion::LongitudinalMotion;
pub use subjects::is_same;
pub(crate) use trace::{has_beginning, is_draft, may_be_draft};

use crate::check::cause::side::{Side, to_mention};
use crate::driven::along::{self, Trend, course};
use crate::driven::{Driven, across};
use components::{ROAD, is_light, is_route};
use decision::LeadIs;
use lead::Lead;
use moment::{Moment, light_state};
use std::collections::BTreeMap;
use whyroad_framework::decision_table::ClassDecisions;
use whyroad_framework::draft_texts::WhyKept;
use whyroad_framework::taxonomy::TypicalDecisions;
use whyroad_framework::{Framework, Taxonomy};
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::messages::{
    Cause, Causes, CocLabel, CriticalComponent, DrivingDecision, EpisodeRecord, Keyframe, Provenance,
    ProvenanceSource, ScenarioLabel, TimeRange,
};
use whyroad_model::time::frame_at;
use whyroad_model::{
    Bilingual, ComponentCategory, Diagnostic, Drive, Lang, Nanos, ScenarioId, Severity, SignalTable, TrackId,
    Tri,
};

/// The code of a record that a person has to fill in, because the drive does not show it.
pub const MISSING_RECORD: &str = "label.record.missing";

/// Minimum change of the heading of an ego that turns, rad: 15 degrees.
const TURNED_RAD: f64 = std::f64::consts::PI / 12.0;

/// A skeleton and its notes.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Draft {
    /// The episode that it was made from.
    pub episode_id: String,
    /// The skeleton, in the format of a finished label.
    #[serde(skip)]
    pub label: CocLabel,
    /// Why the label has no components, decision and trace: the recording does not support what the class states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubt: Option<Doubt>,
    /// What was inferred and how, and what is missing.
    pub notes: Vec<Bilingual>,
}

/// The skeleton of one episode. `lang` is the language of its texts.
pub fn draft(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
    lang: Lang,
) -> Draft {
    draft_with_seed(framework, drive, signals, episode, lang, 0)
}

/// The same with other phrasings: the episode and `run` determine which are used.
pub fn draft_with_seed(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
    lang: Lang,
    run: u64,
) -> Draft {
    make(framework, drive, signals, episode, subjects::How { lang, run, listed: None })
}

/// The same where Stage I lists the components `listed`: the draft names no other components (LABELING.md 6, *Stage I
/// components only, plus routing or rules*).
pub fn draft_of_listed(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
    lang: Lang,
    listed: &[CriticalComponent],
) -> Draft {
    make(framework, drive, signals, episode, subjects::How { lang, run: 0, listed: Some(listed) })
}

fn make(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
    how: subjects::How<'_>,
) -> Draft {
    let subjects::How { lang, run, .. } = how;
    let mut notes = Vec::new();
    let keyframe = keyframe_of(drive, episode);
    let class = &episode.scenario_id;
    let spec = framework.specs.get(class);
    let typical = typical_decisions(&framework.taxonomy, class);
    if !class.is_leaf() {
        notes.push(Bilingual::new(
            "记录不足以判定变体（L3），请标注员确定",
            "the recording does not show the variant (L3): choose it",
        ));
    }

    let (target_id, lead, lead_is) = target_and_lead(framework, drive, signals, episode, keyframe);
    // In a drive that ends at the keyframe nothing is decided: there is no side (see `components`). The signals of its
    // last frame do not include the road's rules either.
    let goes_on = keyframe + 1 < drive.times.len();
    let driven =
        goes_on.then(|| Driven::after(drive, signals, keyframe, Some(episode.time_range.end_timestamp)));
    // In a turn, the vehicle ahead in the lane need not be on the ego's way; one that the ego leaves for another lane
    // is a reason for that.
    let lead = lead.filter(|lead| {
        let unseen = |w: &Driven<'_>| across::first_lane_change(w, w.keyframe..w.end).is_none();
        let leaves_it = driven.as_ref().is_some_and(|w| unseen(w) && !lead.is_on_the_way(w));
        lead_is == LeadIs::Target || !leaves_it
    });
    let of_variants = class.l3.is_none().then(|| of_variants(framework, class)).flatten();
    let target = target_id.and_then(|id| drive.track(id)).map(|t| t.class);
    let course = driven.as_ref().and_then(course);
    let asked = decision::Asked {
        names: &framework.decisions,
        typical: &typical,
        allowed: framework.decision_table().leaves.get(class),
        mandated: spec.and_then(|s| s.lateral),
        target,
        is_safety: class.l1 == "safety",
        of_others: class.l1 == "reactive_agent",
        of_roundabout: class.l2.as_deref() == Some("roundabout"),
        of_crossing: matches!(class.l2.as_deref(), Some("vru_crossing" | "intersection_interaction")),
        of_variants: of_variants.as_ref(),
        lead,
        lead_is,
        is_stopped_behind: lead.zip(driven.as_ref()).is_some_and(|(lead, w)| lead.is_stopped_behind(w)),
        changes_plainly: driven.as_ref().is_some_and(|w| along::conflict(w, None).is_some()),
        course,
        of_road: class.l1 == ROAD,
        of_limit: class.l2.as_deref() == Some("speed_limit")
            && !matches!(class.l3.as_deref(), Some("bump_limit" | "crosswalk_limit")),
        of_obstacle: class.l2.as_deref() == Some("obstacle_avoidance")
            || (class.l2.as_deref() == Some("lane_change")
                && target_id.is_some_and(|id| stands(signals, keyframe, id))),
        of_turn: class.l1 == "proactive" && class.l2.as_deref() == Some("turn"),
    };
    let (decision, motion) = decision::infer(signals, keyframe, &asked, &mut notes);
    let goes_to =
        || decision.lateral_direction.or_else(|| decision::side_without(decision.lateral, signals, keyframe));
    let side = goes_on.then(goes_to).flatten();
    let doubt = driven.as_ref().and_then(|w| {
        let of_ego = || doubt::of_ego(class, w, course.as_ref(), drive, target_id, &decision, motion);
        let is_no_motion =
            || course.is_some_and(|course| is_of_other_motion(w, &course, &decision, &asked, target_id));
        doubt::of_target(class, w, drive, target_id)
            .or_else(of_ego)
            .or_else(|| doubt::of_nearer(class, w, &asked, &decision, motion))
            .or_else(|| doubt::of_wait(class, &asked, &decision, motion))
            .or_else(|| doubt::of_reason(class, w, target_id))
            .or_else(|| is_no_motion().then_some(Doubt::Motion))
            .or_else(|| doubt::of_nothing(w, &asked, &decision))
    });
    let records = spec
        .map(|s| records::known(signals, keyframe, target_id, &s.records, &mut notes))
        .unwrap_or_default();
    if let Some(doubt) = doubt {
        return undrafted(framework, drive, episode, doubt, records, notes);
    }
    let moment =
        Moment::of(signals, keyframe, target_id, side).deciding(&decision, motion).with_course(goes_on);
    if goes_on && class.l2.as_deref() == Some("turn") && moment.goes_against_red().is_true() {
        return undrafted(framework, drive, episode, Doubt::AgainstRed, records, notes);
    }
    // Whatever the class, the ego moves off before a red light only to turn to the side on which it drives.
    let starts = decision.longitudinal == Some(Longitudinal::Resume) && decision.lateral.is_none();
    let starts_at_red = starts
        && class.l2.as_deref() != Some("traffic_light")
        && moment.red().is_true()
        && driven.as_ref().is_some_and(drives_at_red);
    if starts_at_red && !driven.as_ref().is_some_and(turns_near) {
        return undrafted(framework, drive, episode, Doubt::AgainstRed, records, notes);
    }
    let lead = lead.filter(|lead| goes_on && lead_is == LeadIs::Nearer && how.names(lead.id));
    let goes_on_slowing = course.is_some_and(|c| c.trend == Trend::Falls && c.is_underway(Trend::Falls));
    let by_lead = lead.filter(|lead| {
        // If the ego was already slowing for a lead, what is seen at the keyframe is only an additional component.
        let slows = goes_on_slowing && lead.is_slower() && lead.is_cause_of(LongitudinalMotion::Slows);
        let undecided = decision.longitudinal.is_none();
        // A turn or a lane change needs a reason of its own, and so does one that is given up.
        let only_lateral =
            (undecided && decision.lateral.is_some()) || decision.lateral == Some(Lateral::ManeuverAbort);
        let queues = undecided && lead.is_crept_behind();
        !only_lateral && (is_because_of(lead, &decision, motion) || (undecided && slows) || queues)
    });
    if class.l1 == ROAD && motion == LongitudinalMotion::Stops {
        notes.push(Bilingual::new(
            "自车随后减速至停车，请核对原因是不是道路",
            "the ego slows to a stop: confirm that the road is the cause",
        ));
    }
    if moment.indicator_against() {
        notes.push(Bilingual::new(
            "自车的转向灯与所转的方向相反，请核对横向决策",
            "the ego's indicator is on for the opposite side: confirm the lateral decision",
        ));
    }
    let (target, has_course) = (target_id, goes_on);
    let scene = components::Scene { framework, drive, signals, episode, target, keyframe, has_course };
    if scene.observed(&moment, lang).is_empty() {
        notes.push(Bilingual::new(
            "没有可由信号得出的关键要素，请标注员补充",
            "the signals show no critical component: add them",
        ));
    }
    let waits = decision.longitudinal == Some(Longitudinal::Resume) && motion == LongitudinalMotion::Waits;
    // If the class requires a decision other than following, a lead that slows the ego is still named.
    let slows = matches!(motion, LongitudinalMotion::Slows | LongitudinalMotion::Stops);
    let beside = lead.filter(|lead| by_lead.is_none() && slows && lead.is_cause_of(motion));
    let beside = beside.filter(|_| decision.longitudinal.is_some() && target_id.is_none());
    let of_others = framework
        .draft_texts
        .seen(class)
        .is_some_and(|seen| seen.high || seen.category == Some(ComponentCategory::CriticalObjects));
    let kept = trace::why_kept(signals, keyframe, target_id, of_others, course.as_ref());
    let stops = decision.longitudinal.is_none()
        && (kept == WhyKept::Standing
            || (kept == WhyKept::Slowing && course.is_some_and(|c| c.nearly_stands)));
    // A road user in the way is nearer to the ego than its light; one that enters the lane or moves along it is not,
    // where the ego stands.
    let moves_along = matches!(class.l2.as_deref(), Some("cutin" | "vru_invasion" | "vehicle_abnormal"));
    let passes_by = class.l2.as_deref() == Some(doubt::MEETING) || (moves_along && kept == WhyKept::Standing);
    let of_other = class.l1 == "safety" || (class.l1 == "reactive_agent" && !passes_by);
    let light_decides = moment.red().is_true()
        && by_lead.is_none()
        && !of_other
        && decision.lateral.is_none()
        && (stops || waits);
    // A red light is no reason to speed up; nor is it one to move off.
    let goes_at_red = starts_at_red || (motion == LongitudinalMotion::SpeedsUp && moment.red().is_true());
    let has_light = goes_on && !goes_at_red;
    let named = subjects::Named {
        scene: &scene,
        moment: &moment,
        how,
        decision: &decision,
        by_lead,
        beside,
        has_light,
        light_decides,
    };
    let subjects = named.in_language(lang);
    if subjects.has_moved {
        return undrafted(framework, drive, episode, Doubt::Words, records, notes);
    }
    let holds = slows || waits;
    let is_of_speed = match decision.longitudinal {
        Some(Longitudinal::GapMatching) => false,
        Some(_) => holds,
        None => decision.lateral.is_none() && matches!(kept, WhyKept::Slowing | WhyKept::Standing),
    };
    let of_rival = |w: &Driven<'_>| rival::of(w, target_id, &subjects.components).is_some();
    if is_of_speed && driven.as_ref().is_some_and(of_rival) {
        return undrafted(framework, drive, episode, Doubt::OtherCause, records, notes);
    }
    // An ego that changes lanes does not stop behind what it leaves; one that keeps rolling has not stopped.
    let leaves = decision.lateral == Some(Lateral::LaneChange) && motion == LongitudinalMotion::Stops;
    let rolls = motion == LongitudinalMotion::Stops && moment.change("soon.stops") == Tri::False;
    let seed = trace::seed(&episode.episode_id, run);
    let told = |subjects: &subjects::Subjects, most: usize, lang| {
        let facts = trace::DraftFacts {
            framework,
            class,
            components: &subjects.components[..most.min(subjects.components.len())],
            decision: &decision,
            motion: if leaves || rolls { LongitudinalMotion::Slows } else { motion },
            kept,
            trend: course.map_or(Trend::Unknown, |c| c.trend),
            brakes_hard: course.is_some_and(|c| c.braking_mps2 > trace::SMOOTH_MPS2),
            lead: by_lead.map(|lead| moment.of_row(lead.row)),
            by_light: subjects.by_light,
            lang,
        };
        trace::trace(&facts, (subjects.order, subjects.along), signals, keyframe, &moment, seed)
    };
    // An episode has a draft in both languages or in none, with the same components, whatever one of them could say.
    let other = if lang == Lang::Zh { Lang::En } else { Lang::Zh };
    let all = subjects.components.len();
    let own = told(&subjects, all, lang);
    let fewest = own.and_then(|own| match told(&named.in_language(other), all, other)?.things {
        things if things < own.things => told(&subjects, things, lang),
        _ => Ok(own),
    });
    let written = match fewest {
        Ok(written) => written,
        Err(doubt) => return undrafted(framework, drive, episode, doubt, records, notes),
    };
    let (coc_trace, subjects::Subjects { mut components, of_turn, along, .. }) = (written.text, subjects);
    // What the trace does not say is not listed.
    components.truncate(written.things);
    notes.push(Bilingual::new(
        "推理文本为模板草稿，须改写为完整的因果说明",
        "the trace is a template: write the state, why it calls for the decision, and the decision",
    ));
    let clipped = clip::inside(drive, episode, &mut notes);
    number(&mut components, clipped.1.timestamp);
    let across = match decision.lateral {
        Some(lateral) if !typical.lateral.contains(&lateral) && spec.and_then(|s| s.lateral).is_none() => {
            of_turn.filter(|n| *n < components.len())
        }
        // Only a route or the indicator shows why the ego turns.
        Some(Lateral::Turn) if class.l2.as_deref() == Some("turn") => {
            let side = decision.lateral_direction.and_then(Side::of);
            let words = framework.label_words();
            let names_it = |c: &CriticalComponent| side.is_some_and(|s| s.is_named(&c.description, words));
            components.iter().position(|c| is_route(c) || names_it(c))
        }
        // What is known at the keyframe may not say to which side the ego goes.
        _ => {
            let words = framework.label_words();
            let about = framework.decision_table().leaves.get(class).map(|c| c.about).unwrap_or_default();
            let unnamed = |side: Side| !components.iter().any(|c| side.is_named(&c.description, words));
            (!to_mention(&decision, about, words).is_some_and(unnamed)).then_some(0)
        }
    };
    let causes = causes(&decision, &components, along, across, lang);
    let parts = Parts { decision, components, coc_trace, records, causes };
    let label = label_of(framework, episode, clipped, parts);
    Draft { episode_id: episode.episode_id.clone(), label, doubt: None, notes }
}

/// Those of the findings about a draft that keep it from being used: errors other than a record that the drive does not
/// show, which a person fills in.
pub fn errors(findings: &[Diagnostic]) -> impl Iterator<Item = &Diagnostic> {
    findings.iter().filter(|d| d.severity == Severity::Error && d.code != MISSING_RECORD)
}

/// The skeleton of an episode that is not drafted, with the reason.
fn undrafted(
    framework: &Framework,
    drive: &Drive,
    episode: &EpisodeRecord,
    doubt: Doubt,
    records: BTreeMap<String, serde_json::Value>,
    mut notes: Vec<Bilingual>,
) -> Draft {
    let why = doubt.text();
    notes.insert(0, Bilingual::new(format!("没有草稿：{}", why.zh), format!("no draft: {}", why.en)));
    let decision = DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };
    let (components, coc_trace) = (Vec::new(), String::new());
    let nothing = Parts { decision, components, coc_trace, records, causes: None };
    let clipped = clip::inside(drive, episode, &mut notes);
    let label = label_of(framework, episode, clipped, nothing);
    Draft { episode_id: episode.episode_id.clone(), label, doubt: Some(doubt), notes }
}

/// Drafted parts of a label.
struct Parts {
    decision: DrivingDecision,
    components: Vec<CriticalComponent>,
    coc_trace: String,
    records: BTreeMap<String, serde_json::Value>,
    causes: Option<Causes>,
}

/// The label of an episode with its range and keyframe inside the clip, and its drafted parts.
fn label_of(
    framework: &Framework,
    episode: &EpisodeRecord,
    (time_range, keyframe): (TimeRange, Keyframe),
    parts: Parts,
) -> CocLabel {
    let id = &episode.scenario_id;
    CocLabel {
        version: Some(whyroad_model::FORMAT_VERSION.to_owned()),
        clip_id: episode.clip_id.to_string(),
        scenario: ScenarioLabel {
            l1: id.l1.clone(),
            l2: id.l2.clone().unwrap_or_default(),
            l3: id.l3.clone(),
            full_id: Some(id.to_string()),
        },
        time_range,
        keyframe,
        driving_decision: parts.decision,
        critical_components: parts.components,
        coc_trace: parts.coc_trace,
        records: parts.records,
        causes: parts.causes,
        second_keyframe: episode.second_keyframe.clone(),
        secondary_scenarios: Vec::new(),
        safety_filter: None,
        provenance: Some(Provenance {
            source: ProvenanceSource::Rule,
            by: Some(id.to_string()),
            at: None,
            tool: Some(format!("whyroad {}", env!("CARGO_PKG_VERSION"))),
            versions: versions(framework, episode),
        }),
    }
}

/// Versions of what a draft rests on: the taxonomy, and the rules that found its episode.
fn versions(framework: &Framework, episode: &EpisodeRecord) -> BTreeMap<String, String> {
    let taxonomy = ("taxonomy".to_owned(), framework.taxonomy.version.clone());
    let rules = episode.rule_version.clone().map(|version| ("rules".to_owned(), version));
    [taxonomy].into_iter().chain(rules).collect()
}

fn stands(signals: &SignalTable, keyframe: usize, id: &TrackId) -> bool {
    Moment::of(signals, keyframe, Some(id), None)
        .number("target.speed")
        .is_some_and(|v| v < lead::STANDING_MPS)
}

/// The ego's motion after the keyframe does not fit the decision or, where nothing is decided, is not constant.
fn is_of_other_motion(
    w: &Driven<'_>,
    course: &along::Course,
    decision: &DrivingDecision,
    asked: &decision::Asked<'_>,
    target: Option<&TrackId>,
) -> bool {
    let DrivingDecision { longitudinal, lateral, lateral_direction } = *decision;
    let objects: Vec<&str> = target.iter().map(|id| id.as_str()).collect();
    if (longitudinal.is_some() || lateral.is_none()) && along::conflict(w, longitudinal).is_some()
        || lateral.is_some_and(|l| across::conflict(w, l, lateral_direction, &objects).is_some())
    {
        return true;
    }
    // The speed change that accompanies a turn or a lane change need not be stated.
    if longitudinal.is_some() || lateral.is_some() {
        return false;
    }
    let slows = course.new.is_some_and(|c| c.trend == Trend::Falls);
    let moves_off = course.stands() && course.trend == Trend::Rises;
    let stops =
        course.nearly_stands && course.now_mps > decision::ROLLING_MPS && !course.is_underway(Trend::Falls);
    // The speed rises and falls within 3 s: something happens that the class does not cover.
    let both = course.trend == Trend::Unknown && !course.stands();
    // If the log has no turns and lane changes, the ego may have done what the class states.
    let known = ["ego.movement", "ego.lane_change"].iter().all(|s| w.signals.shows_all(s));
    slows || moves_off || stops || both || (known && asked.decides())
}

/// The light of an ego that has moved off is still red.
fn drives_at_red(w: &Driven<'_>) -> bool {
    let drives = (w.keyframe..w.end).find(|&f| w.speed(f).is_some_and(|v| v > decision::ROLLING_MPS));
    drives.is_some_and(|f| light_state(w.signals, f) == Some("red"))
}

/// The ego turns to the side on which it drives in the seconds after the keyframe.
fn turns_near(w: &Driven<'_>) -> bool {
    let turned = w.heading_changes(w.end).last().copied().unwrap_or(0.0);
    match w.category("map.driving_side", w.keyframe) {
        Some("left") => turned > TURNED_RAD,
        Some("right") => turned < -TURNED_RAD,
        _ => turned.abs() > TURNED_RAD,
    }
}

/// The critical components that Stage I lists: those of [`draft`] for a drive that ends at the keyframe, a near lead,
/// and the turn that the ego announces at a junction. Needs only the signals of `whyroad_signals::derive_last_frame`.
pub fn components(
    framework: &Framework,
    drive: &Drive,
    signals: &SignalTable,
    episode: &EpisodeRecord,
    lang: Lang,
) -> Vec<CriticalComponent> {
    let class = &episode.scenario_id;
    let keyframe = keyframe_of(drive, episode);
    let (target, lead, lead_is) = target_and_lead(framework, drive, signals, episode, keyframe);
    let moment = Moment::of(signals, keyframe, target, None);
    let has_course = false;
    let scene = components::Scene { framework, drive, signals, episode, target, keyframe, has_course };
    let mut all = subjects::with_cause(&scene, scene.observed(&moment, lang), &moment, lang);
    all.extend(trace::also(framework, class, &moment, lang));
    if !all.iter().any(is_light) {
        all.extend(scene.light(&moment, lang));
    }
    // A near lead and the announced turn may be causes, whatever the ego then does.
    let lead = lead.filter(|lead| lead_is == LeadIs::Nearer && lead.is_near());
    all.extend(lead.and_then(|lead| scene.lead(&lead, lang)));
    if class.l1 == "reactive_agent" && moment.is_at_junction() {
        all.extend(scene.turn_intent(&moment, lang));
    }
    let (_, moment) = clip::inside(drive, episode, &mut Vec::new());
    number(&mut all, moment.timestamp);
    all
}

/// The frame of the keyframe, or the last frame if the keyframe is later.
fn keyframe_of(drive: &Drive, episode: &EpisodeRecord) -> usize {
    frame_at(&drive.times, episode.keyframe.timestamp).min(drive.times.len().saturating_sub(1))
}

/// Gives components their ids and the moment at which they are evident.
fn number(components: &mut [CriticalComponent], at: Nanos) {
    for (i, c) in components.iter_mut().enumerate() {
        c.id = Some(format!("c{}", i + 1));
        c.evidence_times = vec![at];
    }
}

/// The draft's first component is what the rule detected: it is proposed as the cause of both decisions, unless another
/// one is nearer. `across` is unset where the log does not show the cause of the lateral decision.
fn causes(
    decision: &DrivingDecision,
    components: &[CriticalComponent],
    along: usize,
    across: Option<usize>,
    lang: Lang,
) -> Option<Causes> {
    let of = |n: usize| {
        let id = components.get(n).or(components.first())?.id.clone()?;
        Some(Cause { components: vec![id], unobserved: None })
    };
    let unobserved = Bilingual::new(
        "记录中没有导航路线或转向灯能说明这一横向动作",
        "neither the route nor the indicator in the log shows why the ego does this",
    );
    let not_seen = || Cause { components: Vec::new(), unobserved: Some(unobserved.get(lang).to_owned()) };
    components.first()?;
    Some(Causes {
        longitudinal: decision.longitudinal.and_then(|_| of(along)),
        lateral: decision.lateral.and_then(|_| across.map_or_else(|| Some(not_seen()), of)),
    })
}

/// The subject of the class, the lead, and the relation of the lead to the subject. The rules of some classes name no
/// target although the class is about the lead.
fn target_and_lead<'a>(
    framework: &Framework,
    drive: &Drive,
    signals: &'a SignalTable,
    episode: &'a EpisodeRecord,
    keyframe: usize,
) -> (Option<&'a TrackId>, Option<Lead<'a>>, LeadIs) {
    let class = &episode.scenario_id;
    let lead = Lead::at(drive, signals, keyframe);
    let of_lead = framework.draft_texts.is_of_lead(class);
    let named = lead.filter(|lead| of_lead && lead.is_reason()).map(|lead| lead.id);
    let target = episode.target_id.as_ref().or(named);
    let along = |id: &TrackId| {
        let row = signals.target(id)?.row(keyframe)?;
        signals.target_columns.get("target.longitudinal")?.number(row)
    };
    let lead_is = match (target, lead) {
        (Some(target), Some(lead)) if target == lead.id => LeadIs::Target,
        (Some(target), Some(lead)) => match along(target).zip(along(lead.id)) {
            // A lead that stops keeps the ego from the point where the paths cross.
            _ if class.l2.as_deref() == Some("intersection_interaction") && lead.stops() => LeadIs::Nearer,
            Some((target, lead)) if target > 0.0 && target < lead => LeadIs::Farther,
            _ => LeadIs::Nearer,
        },
        _ => LeadIs::Nearer,
    };
    (target, lead, lead_is)
}

/// Decisions that any of the variants of an L2 class allows.
fn of_variants(framework: &Framework, class: &ScenarioId) -> Option<ClassDecisions> {
    let leaves = &framework.decision_table().leaves;
    let own = leaves.iter().filter(|(leaf, _)| leaf.l1 == class.l1 && leaf.l2 == class.l2);
    own.map(|(_, decisions)| decisions.clone()).reduce(|all, one| all.or(&one))
}

/// The ego decides as it does, or remains stationary, because of `lead`.
fn is_because_of(lead: &Lead<'_>, decision: &DrivingDecision, motion: LongitudinalMotion) -> bool {
    match decision.longitudinal {
        Some(Longitudinal::LeadFollowing | Longitudinal::Resume) => lead.is_cause_of(motion),
        Some(_) => false,
        None => lead.is_cause_of(LongitudinalMotion::Keeps),
    }
}

/// Typical decisions of the L3 class, or of the L2 class where the variant is not known.
fn typical_decisions(taxonomy: &Taxonomy, class: &ScenarioId) -> TypicalDecisions {
    if let Some((_, _, l3)) = taxonomy.leaf(class) {
        return l3.typical_decisions.clone();
    }
    let l2 = class.l2.as_deref().and_then(|l2| taxonomy.l2(&class.l1, l2));
    l2.map(|(_, l2)| l2.typical_decisions.clone()).unwrap_or_default()
}

#[cfg(test)]
mod tests;
