//! The draft of the trace: the state, the reason for the decision, the decision (LABELING.md 7), in phrasings of
//! `schema/draft_texts.yaml`. A seed selects the phrasings, so that the same episode always gets the same text.

use super::change::ALIKE_MPS;
use super::components::is_light;
use super::doubt::Doubt;
use super::moment::Moment;
use super::motion::LongitudinalMotion;
use super::wording::{backwards, capital, fits, names_twice, repeats, wanted, without_side};
use crate::check::bare;
use crate::driven::along::{Course, Trend};
use whyroad_framework::Framework;
use whyroad_framework::draft_texts::{Claim, Phrasings, SeenWhen, SignalCondition, WhyKept};
use whyroad_framework::label_words::WordRole;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{CriticalComponent, DrivingDecision, Uncertainty};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{ComponentCategory, Lang, ScenarioId, SignalTable, TrackId, Tri};

/// Maximum number of components in the state: a reader needs no more than two.
pub(super) const MOST_IN_STATE: usize = 2;
/// Below this speed the ego is at standstill, m/s.
const STANDING_MPS: f64 = 0.3;
/// Below this acceleration the speed falls, and above its negative it rises, m/s2; as for a target.
const SLOWING_MPS2: f64 = -0.5;
/// Below this acceleration the ego brakes whatever its speed does then, m/s2.
const BRAKING_MPS2: f64 = -1.5;
/// An object whose center is not farther ahead than this is beside the ego, or behind it, m.
const BESIDE_M: f64 = 0.0;
/// Below this speed the ego is slow, m/s: it stops within its own length.
const SLOW_MPS: f64 = 15.0 / 3.6;
/// Braking up to this is not hard, m/s2.
const COMFORTABLE_MPS2: f64 = 2.0;
/// Objects farther than this from the area that the ego sweeps do not block it, m.
const BESIDE_PATH_M: f64 = 0.5;
/// An object nearer than this is not far away at any speed, m.
const NEAR_M: f64 = 15.0;
/// Reaction time of a driver before braking, s.
const REACTION_S: f64 = 1.5;
/// Frames over which a change of a distance is measured.
const BEFORE_FRAMES: usize = 5;
/// A decrease of a distance up to this is noise, m.
const NOISE_M: f64 = 0.1;
/// An object that comes onto the path within this time is not beside it, s.
const SOON_S: f64 = 1.5;
/// Braking harder than this is not smooth, m/s2.
pub(super) const SMOOTH_MPS2: f64 = 2.5;
/// Words for smooth driving.
const SMOOTH: [&str; 3] = ["平稳", "smooth", "gently"];
/// An English trace with more of these words needs one sentence less.
const MOST_ANDS: usize = 2;
/// Speeds are given in steps of this, km/h, and below two of them in whole numbers.
const SPEED_STEP_KMH: f64 = 5.0;

/// Beginning of an English clause about the ego.
const OF_EGO: &str = "the ego ";

/// Facts for a trace.
pub(super) struct DraftFacts<'a> {
    pub framework: &'a Framework,
    pub class: &'a ScenarioId,
    pub components: &'a [CriticalComponent],
    pub decision: &'a DrivingDecision,
    /// The ego's longitudinal motion after the keyframe.
    pub motion: LongitudinalMotion,
    /// Why there is no new decision, if there is none.
    pub kept: WhyKept,
    /// Trend of the speed.
    pub trend: Trend,
    /// The ego brakes harder than smoothly.
    pub brakes_hard: bool,
    /// The keyframe with the lead as the target, where the lead and not the subject of the class is the nearest cause.
    pub lead: Option<Moment<'a>>,
    /// The light, and not the subject of the class, is the nearest cause.
    pub by_light: bool,
    pub lang: Lang,
}

/// Why there is no new decision at `frame` about `target`; `of_others`: the class is about other road users although no
/// target is known, or about a road user that may be hidden.
pub(super) fn why_kept(
    signals: &SignalTable,
    frame: usize,
    target: Option<&TrackId>,
    of_others: bool,
    course: Option<&Course>,
) -> WhyKept {
    let number = |name: &str| signals.frame_columns.get(name).and_then(|c| c.number(frame));
    let speed = number("ego.speed");
    if speed.is_some_and(|v| v < STANDING_MPS) {
        return WhyKept::Standing;
    }
    // The current motion is a reason only if the ego continues it.
    let goes_on = |trend: Trend| course.is_none_or(|c| c.trend == trend);
    let underway = |trend: Trend| course.is_some_and(|c| c.is_underway(trend));
    match number("ego.accel") {
        Some(a) if a < BRAKING_MPS2 => return WhyKept::Slowing,
        Some(a) if a < SLOWING_MPS2 && goes_on(Trend::Falls) => return WhyKept::Slowing,
        Some(a) if a > -SLOWING_MPS2 && goes_on(Trend::Rises) => return WhyKept::Speeding,
        _ if underway(Trend::Falls) && goes_on(Trend::Falls) => return WhyKept::Slowing,
        _ if underway(Trend::Rises) && goes_on(Trend::Rises) => return WhyKept::Speeding,
        _ => {}
    }
    let Some(target) = target else {
        return match speed {
            Some(v) if v < SLOW_MPS => WhyKept::Slow,
            _ if of_others => WhyKept::Driving,
            _ => WhyKept::Suits,
        };
    };
    let of_target = |name: &str, frame: usize| {
        let row = signals.target(target)?.row(frame)?;
        signals.target_columns.get(name)?.number(row)
    };
    if of_target("target.longitudinal", frame).is_some_and(|x| x < BESIDE_M) {
        return WhyKept::Beside;
    }
    let distance = |frame: usize| of_target("target.distance", frame);
    let now = distance(frame);
    let before = frame.checked_sub(BEFORE_FRAMES).and_then(distance);
    // Where the recording has just begun, the speeds show it.
    let faster = || of_target("target.relative_speed", frame).is_some_and(|v| v > -ALIKE_MPS);
    if now.is_some_and(|now| before.map_or_else(faster, |before| now > before - NOISE_M)) {
        return WhyKept::NotCloser;
    }
    let stopping = speed.map(|v| v * REACTION_S + v * v / (2.0 * COMFORTABLE_MPS2));
    if now.zip(stopping).is_some_and(|(now, stopping)| now > stopping.max(NEAR_M)) {
        WhyKept::FarAway
    } else if stays_beside(|frame| of_target("target.path_side_distance", frame), frame) {
        WhyKept::OffPath
    } else if speed.is_some_and(|v| v < SLOW_MPS) {
        WhyKept::Slow
    } else {
        WhyKept::Driving
    }
}

/// It is beside the path, and not about to come onto it.
fn stays_beside(distance: impl Fn(usize) -> Option<f64>, frame: usize) -> bool {
    let Some(now) = distance(frame).filter(|d| *d > BESIDE_PATH_M) else { return false };
    let Some(before) = frame.checked_sub(BEFORE_FRAMES).and_then(distance) else { return true };
    let closing_mps = (before - now) * FRAME_RATE_HZ / BEFORE_FRAMES as f64;
    now > closing_mps * SOON_S
}

/// Numbers that select the phrasings.
#[derive(Clone, Copy)]
struct Choice {
    why: u64,
    action: u64,
    joined: u64,
    opening: u64,
}

impl Choice {
    fn of(seed: u64) -> Self {
        Self {
            why: seed & 0xffff,
            action: (seed >> 16) & 0xffff,
            joined: (seed >> 32) & 0xffff,
            opening: seed >> 48,
        }
    }
}

/// Order of the components of a state in the text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum StateOrder {
    /// The first one last: the text after it refers to it.
    FirstLast,
    /// In the order of the list: a later one makes room for the decision.
    AsListed,
}

/// Phrasings of the decision that are tried.
const MOST_ACTIONS: u64 = 4;

/// The trace, and the number of components that it states, from the first one on.
pub(super) struct Written {
    pub text: String,
    pub things: usize,
}

/// A text that may be used.
struct Told {
    /// Whether what it claims is true.
    truth: Tri,
    /// Number of its components.
    things: usize,
    /// Bytes of its state.
    state: usize,
    text: String,
}

/// The trace with the phrasings that `seed` selects, of the preferred length: with the ego's motion at the keyframe if
/// there is room, and with fewer components in the state if there is not. A doubt where the signals contradict a claim
/// of each of them.
///
/// `order`, `along`: order of the components, and the index of the one that causes the longitudinal decision, which is
/// not left out. Without a component or a reason the text would not say why: there is none.
pub(super) fn trace(
    facts: &DraftFacts<'_>,
    (order, along): (StateOrder, usize),
    signals: &SignalTable,
    keyframe: usize,
    moment: &Moment<'_>,
    seed: u64,
) -> Result<Written, Doubt> {
    let choice = Choice::of(seed);
    let reasons = facts.reason(moment);
    if reasons.is_none() || facts.components.is_empty() {
        return Err(Doubt::Texts);
    }
    let openings = openings(facts, signals, keyframe, moment, choice.opening);
    // The speed is mentioned in few traces, because it affects few decisions.
    let opens = (choice.opening / 8).is_multiple_of(4)
        && openings.first().is_some_and(|o| o.contains(|c: char| c.is_ascii_digit()));
    // The other openings are used where the first makes it too short or too long.
    let with = |things| openings.iter().map(move |o| (things, Some(o.as_str())));
    let without = |things| std::iter::once((things, None));
    let most = facts.components.len().min(MOST_IN_STATE);
    let numbers = [most, 1].into_iter().take(if most > 1 && along == 0 { 2 } else { 1 });
    let variants: Vec<(usize, Option<&str>)> = if opens {
        numbers.flat_map(|n| with(n).chain(without(n))).collect()
    } else {
        numbers.flat_map(|n| without(n).chain(with(n))).collect()
    };
    // The other phrasings of reason and decision are used where no opening gives a fitting length.
    let others = reasons.map_or(1, |p| p.all(facts.lang).len().max(1) as u64);
    let actions = facts.phrasings().0.clamp(1, MOST_ACTIONS);
    let choices = (0..others).flat_map(|why| {
        (0..actions).map(move |action| Choice {
            why: choice.why + why,
            action: choice.action + action,
            ..choice
        })
    });
    // What is claimed before the reason does not depend on the choice, nor the rest on the components.
    let states: Vec<(String, Vec<&Claim>)> = variants
        .iter()
        .map(|(things, opening)| {
            let state = facts.state(*opening, (*things, order));
            let claims = facts.claims(&state);
            (state, claims)
        })
        .collect();
    let texts = choices.flat_map(|choice| {
        let why = reasons.map_or("", |p| p.pick(facts.lang, choice.why));
        let mut of_rest: Option<Vec<&Claim>> = None;
        let told = variants.iter().zip(&states).map(|((things, opening), (state, of_state))| {
            let text = facts.sentence(*opening, (*things, order), why, choice);
            let of_rest =
                of_rest.get_or_insert_with(|| facts.claims(text.get(state.len()..).unwrap_or(text.as_str())));
            let claims = of_state.iter().chain(of_rest.iter()).copied();
            Told { truth: facts.truth(claims, moment), things: *things, state: state.len(), text }
        });
        told.collect::<Vec<_>>()
    });
    let mut texts: Vec<Told> = texts.filter(|t| t.truth != Tri::False).collect();
    // Texts with words that contradict the numbers, or with long chains of clauses, are left out if there are others.
    let smooth = |t: &Told| facts.brakes_hard && SMOOTH.iter().any(|w| t.text.contains(w));
    let unsure = |t: &Told| t.truth == Tri::Unknown;
    let chained = |t: &Told| t.text.matches(" and ").count() > MOST_ANDS;
    let short = |t: &Told| t.text.chars().count() < *wanted(facts.lang).start();
    let twice = |t: &Told| names_twice(&t.text, facts.lang);
    let repeats = |t: &Told| repeats(&t.text, t.state, facts.lang);
    // A light that concerns the ego is mentioned.
    let light = facts.components.iter().take(MOST_IN_STATE).find(|c| is_light(c));
    let light = light.map(|c| c.description.to_lowercase());
    let unlit = |t: &Told| light.as_ref().is_some_and(|l| !t.text.to_lowercase().contains(l.as_str()));
    let all: [&dyn Fn(&Told) -> bool; 7] = [&smooth, &unlit, &unsure, &chained, &short, &twice, &repeats];
    for is_worse in all {
        if !texts.iter().all(is_worse) {
            texts.retain(|t| !is_worse(t));
        }
    }
    // A component is left out only where no text has room for it.
    let found = (1..=most.max(1)).rev().find_map(|n| {
        texts.iter().filter(|t| t.things == n || most == 0).find(|t| fits(&t.text, facts.lang))
    });
    // None fits: the one that exceeds the length least, or else the longest.
    let wanted = wanted(facts.lang);
    let nearest = || {
        texts.iter().min_by_key(|t| {
            let n = t.text.chars().count();
            if n > *wanted.end() { (1, n) } else { (0, wanted.start().saturating_sub(n)) }
        })
    };
    let chosen = found.or_else(nearest).ok_or(Doubt::Words)?;
    Ok(Written { text: chosen.text.clone(), things: chosen.things })
}

/// Phrasings of the ego's motion at the keyframe, that of `seed` first.
fn openings(
    facts: &DraftFacts<'_>,
    signals: &SignalTable,
    keyframe: usize,
    moment: &Moment<'_>,
    seed: u64,
) -> Vec<String> {
    let speed = signals.frame_columns.get("ego.speed").and_then(|c| c.number(keyframe));
    let Some(speed) = speed else { return Vec::new() };
    let all = facts.framework.draft_texts.openings();
    let of = |p: &Phrasings| -> Vec<String> {
        let n = p.all(facts.lang).len() as u64;
        (0..n).map(|i| p.pick(facts.lang, (seed % n.max(1)) + i).to_owned()).collect()
    };
    let of_ego = if facts.lang == Lang::Zh { "自车" } else { OF_EGO };
    let state = || facts.components.iter().take(MOST_IN_STATE).map(|c| c.description.as_str());
    if speed < STANDING_MPS {
        // If nothing is decided, the rest of the text states it; so does a component that says where the ego stands.
        let stands = if facts.lang == Lang::Zh { "停" } else { "stands" };
        let said = state().any(|text| text.starts_with(of_ego) && text.contains(stands));
        return if facts.decides() && !said { of(&all.standing) } else { Vec::new() };
    }
    // The speed of an ego that still rolls at the keyframe and then moves off is not worth mentioning.
    if facts.decision.longitudinal == Some(Longitudinal::Resume) {
        return Vec::new();
    }
    // An opening does not fit before a text that already states where the ego drives.
    if state().any(|text| text.starts_with(of_ego)) {
        return Vec::new();
    }
    // One number is enough; that the ego drives at all need not be said.
    if state().any(|text| text.contains(|c: char| c.is_ascii_digit())) {
        let changes = |name| moment.change(name) != Tri::False;
        let steady = !changes("past.slowed") && !changes("past.gained");
        return if steady { of(&all.moving_without_speed) } else { Vec::new() };
    }
    let step = if speed * 3.6 < 2.0 * SPEED_STEP_KMH { 1.0 } else { SPEED_STEP_KMH };
    let kmh = (speed * 3.6 / step).round().max(1.0) * step;
    of(&all.moving).into_iter().map(|text| text.replace("{speed}", &format!("{kmh:.0}"))).collect()
}

/// The pattern `joined` without its empty parts: without a state the text begins with the reason, without a reason the
/// decision follows the state.
fn said(joined: &str, state: &str, why: &str) -> String {
    let (state_at, why_at, action_at) = match (joined.find("}"), joined.find("{action}")) {
        (Some(end), Some(action)) => (end + 1, joined[end..].find('{').map_or(action, |n| end + n), action),
        _ => return joined.to_owned(),
    };
    let why_end = joined[why_at..].find('}').map_or(action_at, |n| why_at + n + 1);
    match (state.is_empty(), why.is_empty()) {
        (false, false) => joined.to_owned(),
        (true, false) => joined[why_at..].to_owned(),
        (false, true) => format!("{}{}", &joined[..state_at], &joined[why_end..]),
        (true, true) => joined[action_at..].to_owned(),
    }
}

impl<'a> DraftFacts<'a> {
    /// The opening and the components, as one text.
    fn state(&self, opening: Option<&str>, (things, order): (usize, StateOrder)) -> String {
        let mut state: Vec<&str> = self
            .components
            .iter()
            .take(things)
            .map(|c| c.description.trim_end_matches(['。', '.']))
            .collect();
        if order == StateOrder::FirstLast {
            state.reverse();
        }
        let comma = if self.lang == Lang::Zh { "，" } else { ", and " };
        let mut state = state.join(comma);
        if let Some(opening) = opening {
            state = match self.lang {
                _ if state.is_empty() => opening.to_owned(),
                Lang::Zh => format!("{opening}，{state}"),
                // A complete sentence remains a sentence of its own.
                Lang::En if opening.starts_with(OF_EGO) => format!("{opening}. {}", capital(&state)),
                Lang::En => format!("{opening}, {state}"),
            };
        }
        state
    }

    /// One sentence from the parts.
    fn sentence(
        &self,
        opening: Option<&str>,
        (things, order): (usize, StateOrder),
        why: &str,
        choice: Choice,
    ) -> String {
        let mut action = self.action(choice.action);
        // A subject that the reason already names is not repeated.
        if why.starts_with(OF_EGO)
            && let Some(rest) = action.strip_prefix(OF_EGO)
        {
            action = format!("it {rest}");
        } else if !why.starts_with(OF_EGO)
            && let Some(rest) = action.strip_prefix("it ")
        {
            // After another subject, "it" would be that one.
            action = format!("{OF_EGO}{rest}");
        }
        let joined = self.framework.draft_texts.traces().pick(self.lang, choice.joined);
        let state = self.state(opening, (things, order));
        let why = if joined.contains("{Why}") { capital(why) } else { why.to_owned() };
        let joined = said(joined, &state, &why);
        let text = joined.replace("{state}", &state).replace("{why}", &why).replace("{Why}", &why);
        capital(&text.replace("{action}", &action))
    }

    /// Why the ego continues its motion, and that it does, where there is no new decision.
    fn kept(&self) -> (Option<&'a Phrasings>, Option<&'a Phrasings>) {
        // A road user that the ego has passed does not affect the turn.
        let turns = self.decision.lateral.is_some() && self.kept != WhyKept::Beside;
        let kept = if turns { WhyKept::Turning } else { self.kept };
        let texts = &self.framework.draft_texts;
        let (why, none) = texts.kept(self.class, kept);
        // A continuing change of speed is stated whatever the reason.
        let says_so = matches!(self.kept, WhyKept::Slowing | WhyKept::Speeding | WhyKept::Standing);
        let goes_on = match self.trend {
            Trend::Rises if !says_so => texts.goes_on("rises"),
            Trend::Falls if !says_so => texts.goes_on("falls"),
            _ => None,
        };
        (why, goes_on.or(none))
    }

    /// The reason for the decision, as far as the signals of `moment` support it.
    fn reason(&self, moment: &Moment<'_>) -> Option<&'a Phrasings> {
        let texts = &self.framework.draft_texts;
        let of_lead = self.lead.and_then(|lead| {
            texts.reasons_of_lead(self.decision.longitudinal).into_iter().find(|r| lead.all(r.when))
        });
        if let Some(reason) = of_lead {
            return Some(reason.texts);
        }
        let of_light = self.by_light.then(|| texts.reasons_of_light(self.decision.longitudinal));
        if let Some(reason) = of_light.into_iter().flatten().find(|r| moment.all(r.when)) {
            return Some(reason.texts);
        }
        if !self.decides() {
            let told = texts.reasons_for_none(self.class).into_iter();
            let told = told.filter(|_| self.decision.lateral.is_none()).find(|r| moment.all(r.when));
            return told.map(|r| r.texts).or(self.kept().0);
        }
        let reasons = texts.reasons(self.class, self.decision);
        reasons.into_iter().find(|r| moment.all(r.when)).map(|r| r.texts)
    }

    /// What the words of a text claim.
    fn claims(&self, text: &str) -> Vec<&'a Claim> {
        self.framework.draft_texts.claims(self.class, text, self.lang).collect()
    }

    /// Whether that is true, as far as signals show it; what is denied too is not. What is said of the lead is compared
    /// with the lead, also where the class is about another road user.
    fn truth<'c>(&self, claims: impl Iterator<Item = &'c Claim> + Clone, moment: &Moment<'_>) -> Tri {
        let denied = |fact: &String| claims.clone().any(|other| other.denies.contains(fact));
        if claims.clone().any(|claim| claim.states.iter().any(denied)) {
            return Tri::False;
        }
        let truth = |claim: &Claim| {
            let of = self.lead.as_ref().filter(|_| claim.of_lead).unwrap_or(moment);
            claim.when.iter().map(|c| of.truth(c)).fold(Tri::True, Tri::and)
        };
        claims.map(truth).fold(Tri::True, Tri::and)
    }

    /// Every reason that a draft may contain.
    fn whys(&self) -> Vec<&'a str> {
        let of = |p: &'a Phrasings| p.all(self.lang).iter().map(String::as_str);
        let texts = &self.framework.draft_texts;
        let along = self.decision.longitudinal;
        let nearer = texts.reasons_of_lead(along).into_iter().chain(texts.reasons_of_light(along));
        let nearer = nearer.map(|r| r.texts);
        if !self.decides() {
            let told = texts.reasons_for_none(self.class).into_iter().map(|r| r.texts);
            return told.chain(self.kept().0).chain(nearer).flat_map(of).collect();
        }
        let reasons = texts.reasons(self.class, self.decision).into_iter().map(|r| r.texts);
        reasons.chain(nearer).flat_map(of).collect()
    }

    fn decides(&self) -> bool {
        let turns = || {
            self.class.l1 == "proactive"
                || self.framework.draft_texts.has_reason_for(self.class, Lateral::Turn.id())
        };
        let own_turn = |l: Lateral| l != Lateral::Turn || turns();
        self.decision.longitudinal.is_some() || self.decision.lateral.is_some_and(own_turn)
    }

    /// The decision of both channels.
    fn action(&self, seed: u64) -> String {
        let (texts, lang) = (&self.framework.draft_texts, self.lang);
        let DrivingDecision { longitudinal, lateral, lateral_direction } = self.decision;
        let along = longitudinal
            .and_then(|d| texts.longitudinal(self.class, d, self.motion.id()))
            .map(|p| p.pick(lang, seed).to_owned());
        let across = lateral.and_then(|d| texts.lateral(self.class, d)).map(|p| {
            let text = p.pick(lang, seed);
            match lateral_direction {
                Some(LateralDirection::Uturn) => backwards(text),
                Some(side) => text.replace("{side}", texts.side(*side, lang)),
                None => without_side(text),
            }
        });
        // Who gives way first does so before the maneuver.
        let first = self.motion == LongitudinalMotion::Stops
            || matches!(longitudinal, Some(Longitudinal::YieldToAgent | Longitudinal::StopForRegulation));
        match (lang, along, across) {
            (_, None, None) => self.kept().1.map_or("", |p| p.pick(lang, seed)).to_owned(),
            (Lang::Zh, Some(a), Some(b)) => format!("{a}，{}{b}", if first { "再" } else { "并" }),
            (Lang::Zh, None, Some(b)) => format!("自车{b}"),
            (Lang::En, Some(a), Some(b)) if first => format!("{a}, then {b}"),
            (Lang::En, Some(a), Some(b)) if a.contains(" and ") => format!("{a}, and {b}"),
            (Lang::En, Some(a), Some(b)) => format!("{a} and {b}"),
            (Lang::En, None, Some(b)) => format!("the ego {b}"),
            (_, Some(a), None) => a,
        }
    }

    /// Numbers of phrasings: of the decision (one number selects all its parts), and of the joints.
    fn phrasings(&self) -> (u64, u64) {
        let (texts, lang) = (&self.framework.draft_texts, self.lang);
        let count = |p: &Phrasings| p.all(lang).len().max(1) as u64;
        let along = self
            .decision
            .longitudinal
            .and_then(|d| texts.longitudinal(self.class, d, self.motion.id()))
            .map_or(1, count);
        let across = self.decision.lateral.and_then(|d| texts.lateral(self.class, d)).map_or(1, count);
        let none = self.kept().1.map_or(1, count);
        let action = if along * across == 1 { none } else { along * across / common(along, across) };
        (action, count(texts.traces()))
    }

    /// The trace contains the beginning of a reason that a draft may contain: cheap, and rarely true for text by a
    /// person.
    fn may_be(&self, trace: &str) -> bool {
        self.whys().into_iter().any(|why| has_beginning(trace, why))
    }
}

/// Greatest common divisor.
fn common(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common(b, a % b) }
}

/// A number from an id and a run's seed, equal on every machine (FNV-1a with the last step of SplitMix64, without which
/// ids that differ in one digit have similar high bits).
pub(super) fn seed(id: &str, run: u64) -> u64 {
    let h = id
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325 ^ run, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    let z = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The facts in both languages for every reason without a new decision; the reasons do not depend on the motion.
fn all_facts<'a>(
    framework: &'a Framework,
    class: &'a ScenarioId,
    components: &'a [CriticalComponent],
    decision: &'a DrivingDecision,
) -> impl Iterator<Item = DraftFacts<'a>> {
    let motion = LongitudinalMotion::Unknown;
    let of = move |lang, kept| DraftFacts {
        framework,
        class,
        components,
        decision,
        motion,
        kept,
        trend: Trend::Unknown,
        brakes_hard: false,
        lead: None,
        by_light: false,
        lang,
    };
    [Lang::Zh, Lang::En].into_iter().flat_map(move |lang| {
        // These are used only where nothing new is decided.
        let count = if of(lang, WhyKept::Driving).decides() { 1 } else { WhyKept::ALL.len() };
        WhyKept::ALL.into_iter().take(count).map(move |kept| of(lang, kept))
    })
}

/// `trace` contains the beginning of `text`; the first letter may be a capital there and is not compared.
pub(crate) fn has_beginning(trace: &str, text: &str) -> bool {
    let mut ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let from = ends.nth(1).unwrap_or(text.len());
    let to = ends.nth(5).unwrap_or(text.len());
    memchr::memmem::find(trace.as_bytes(), &text.as_bytes()[from..to]).is_some()
}

/// False where [`is_draft`] is false whatever the components are.
pub(crate) fn may_be_draft(
    framework: &Framework,
    class: &ScenarioId,
    decision: &DrivingDecision,
    trace: &str,
) -> bool {
    all_facts(framework, class, &[], decision).any(|facts| facts.may_be(trace))
}

/// True when `trace` ends as a draft with these parts does, in any phrasing, so no person has written it. The part of a
/// draft about the ego before that is not compared: it depends on the recording.
pub(crate) fn is_draft(
    framework: &Framework,
    class: &ScenarioId,
    components: &[CriticalComponent],
    decision: &DrivingDecision,
    trace: &str,
) -> bool {
    let all = all_facts(framework, class, components, decision);
    let likely: Vec<DraftFacts<'_>> = all.filter(|facts| facts.may_be(trace)).collect();
    if likely.is_empty() {
        return false;
    }
    let trace = bare(trace);
    // The ego's motion occurs in the texts of longitudinal decisions.
    let motions = match decision.longitudinal {
        Some(_) => &LongitudinalMotion::ALL[..],
        None => &[LongitudinalMotion::Unknown],
    };
    // So does the trend of its speed where nothing is decided.
    let mut moving = likely.iter().flat_map(|of| {
        let trends =
            if of.decides() { &[Trend::Holds][..] } else { &[Trend::Holds, Trend::Rises, Trend::Falls] };
        let each = motions.iter().flat_map(move |motion| trends.iter().map(move |trend| (*motion, *trend)));
        each.map(move |(motion, trend)| DraftFacts { motion, trend, ..*of })
    });
    moving.any(|facts| {
        let (actions, joints) = facts.phrasings();
        // The text is put together only with a reason and an action that the trace has: there are thousands of others.
        let mut whys = facts.whys();
        whys.retain(|why| trace.contains(&bare(why)));
        if whys.is_empty() {
            return false;
        }
        let has_action: Vec<bool> =
            (0..actions).map(|action| trace.contains(&bare(without_ego(&facts.action(action))))).collect();
        let is_possible = |action: u64| usize::try_from(action).is_ok_and(|i| has_action[i]);
        let mut states = (1..=MOST_IN_STATE)
            .flat_map(|things| [(things, StateOrder::FirstLast), (things, StateOrder::AsListed)]);
        states.any(|state| {
            whys.iter().any(|why| {
                (0..actions * joints).filter(|i| is_possible(i % actions)).any(|i| {
                    let choice = Choice { why: 0, action: i % actions, joined: i / actions, opening: 0 };
                    trace.ends_with(&bare(&facts.sentence(None, state, why, choice)))
                })
            })
        })
    })
}

/// An action without its subject.
fn without_ego(action: &str) -> &str {
    action.strip_prefix(OF_EGO).or_else(|| action.strip_prefix("it ")).unwrap_or(action)
}

/// The component that describes the subject of the class, if the recording shows none that does.
pub(super) fn seen(
    framework: &Framework,
    class: &ScenarioId,
    found: &[CriticalComponent],
    moment: &Moment<'_>,
    lang: Lang,
) -> Option<CriticalComponent> {
    let words = framework.label_words();
    let about = framework.decision_table().leaves.get(class).map(|c| c.about);
    // A light is the subject only of classes that have no other subject.
    let light = words.kinds.get("light").copied().unwrap_or_default();
    let only_light = about == Some(light);
    let speaks = |c: &CriticalComponent| {
        if is_light(c) && !only_light {
            return false;
        }
        let mut any = false;
        words.hits(&c.description, |hit| {
            any |= matches!(hit.role, WordRole::Object(g) if about.is_some_and(|a| words.objects[g].own.meets(a)));
        });
        any
    };
    // If nothing is known about the class, the found components are used; a light alone is not enough for other
    // classes.
    if found.iter().any(speaks) || (about.is_none() && !found.iter().all(is_light)) {
        return None;
    }
    let texts = &framework.draft_texts;
    let seen = texts.seen(class)?;
    // Before the ego's way is known, only the log tells its route.
    if seen.category == Some(ComponentCategory::RoutingIntent)
        && !moment.has_course()
        && !moment.knows_route()
    {
        return None;
    }
    let told = if moment.has_course() {
        texts.seen_when(class).iter().find_map(|w| when_told(w, moment, lang))
    } else {
        None
    };
    let (category, description) = told.unwrap_or_else(|| (None, seen.get(lang).to_owned()));
    Some(component(category.or(seen.category), description, seen.high.then_some(Uncertainty::High)))
}

/// The further component that the signals show and that the reason refers to.
pub(super) fn also(
    framework: &Framework,
    class: &ScenarioId,
    moment: &Moment<'_>,
    lang: Lang,
) -> Option<CriticalComponent> {
    let texts = &framework.draft_texts;
    let told = |when| when_told(when, moment, lang).map(|(category, text)| (when, category, text));
    let (when, category, text) = texts.also_when(class).iter().find_map(told)?;
    let text = match moment.side() {
        Some(side) => text.replace("{side}", texts.side(side, lang)),
        None => without_side(&text),
    };
    // Those that leave little room are who the text is about.
    let near = |c: &&SignalCondition| c.below.is_some();
    let linked_objects =
        when.when.iter().filter(near).filter_map(|c| moment.takes_room(&c.signal)).map(ToString::to_string);
    let linked_objects = linked_objects.collect();
    Some(CriticalComponent {
        linked_objects,
        ..component(category.or(texts.seen(class)?.category), text, None)
    })
}

/// Category and text of a component whose conditions hold.
fn when_told(
    when: &SeenWhen,
    moment: &Moment<'_>,
    lang: Lang,
) -> Option<(Option<ComponentCategory>, String)> {
    if !moment.all(&when.when) {
        return None;
    }
    let text = when.get(lang);
    let Some(name) = &when.number else { return Some((when.category, text.to_owned())) };
    let kmh = moment.number(name).filter(|v| v.is_finite())? * 3.6;
    Some((when.category, text.replace("{number}", &format!("{kmh:.0}"))))
}

fn component(
    category: Option<ComponentCategory>,
    description: String,
    uncertainty: Option<Uncertainty>,
) -> CriticalComponent {
    CriticalComponent {
        category: category.map(|c| c.id().to_owned()),
        description,
        uncertainty,
        id: None,
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::said;

    #[test]
    fn a_trace_without_state_or_reason_has_no_empty_part() {
        let zh = "{state}；{why}，因此{action}。";
        assert_eq!(said(zh, "a", "b"), zh);
        assert_eq!(said(zh, "", "b"), "{why}，因此{action}。");
        assert_eq!(said(zh, "a", ""), "{state}，因此{action}。");
        assert_eq!(said(zh, "", ""), "{action}。");
        let en = "{state}. {Why}, so {action}.";
        assert_eq!(said(en, "", "b"), "{Why}, so {action}.");
        assert_eq!(said(en, "a", ""), "{state}, so {action}.");
    }
}
