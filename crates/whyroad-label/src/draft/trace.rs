//! The draft of the trace: the state, why it calls for a decision, the decision (LABELING.md 7), in words of
//! `schema/draft_texts.yaml`. Which phrasings are taken follows from a seed, so that the same episode gives the same
//! text.

use std::ops::RangeInclusive;
use whyroad_framework::Framework;
use whyroad_framework::draft_texts::{Phrasings, WhyKept};
use whyroad_framework::label_words::WordRole;
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::messages::{CriticalComponent, DrivingDecision};
use whyroad_model::{ComponentCategory, Lang, ScenarioId, SignalTable, TrackId};

/// Things in the state: two are enough for a person to see what matters.
const MOST_IN_STATE: usize = 2;
/// Below this speed the ego is at standstill, m/s.
const STANDING_MPS: f64 = 0.3;
/// Below this acceleration the speed falls, m/s2; as for a target.
const SLOWING_MPS2: f64 = -0.5;
/// Below this speed the ego is slow, m/s: it stops within its own length.
const SLOW_MPS: f64 = 15.0 / 3.6;
/// Braking that nobody calls hard, m/s2.
const COMFORTABLE_MPS2: f64 = 2.0;
/// Before a driver brakes, s.
const REACTION_S: f64 = 1.5;
/// Frames over which a distance shrinks or does not.
const BEFORE_FRAMES: usize = 5;
/// What a distance may shrink by over them, m: noise.
const NOISE_M: f64 = 0.1;
/// Speeds are given in steps of this, km/h.
const SPEED_STEP_KMH: f64 = 5.0;

/// What a trace is about.
pub(super) struct DraftFacts<'a> {
    pub framework: &'a Framework,
    pub class: &'a ScenarioId,
    pub components: &'a [CriticalComponent],
    pub decision: &'a DrivingDecision,
    /// Why nothing new is decided, where nothing is.
    pub kept: WhyKept,
    pub lang: Lang,
}

/// Why nothing new is decided at `frame` about `target`; `of_others`: it is about others where no target is known, or
/// about who may be hidden.
pub(super) fn why_kept(
    signals: &SignalTable,
    frame: usize,
    target: Option<&TrackId>,
    of_others: bool,
) -> WhyKept {
    let number = |name: &str| signals.frame_columns.get(name).and_then(|c| c.number(frame));
    let speed = number("ego.speed");
    if speed.is_some_and(|v| v < STANDING_MPS) {
        return WhyKept::Standing;
    }
    if number("ego.accel").is_some_and(|a| a < SLOWING_MPS2) {
        return WhyKept::Slowing;
    }
    let Some(target) = target else {
        return if of_others { WhyKept::Driving } else { WhyKept::Suits };
    };
    let distance = |frame: usize| {
        let row = signals.target(target)?.row(frame)?;
        signals.target_columns.get("target.distance")?.number(row)
    };
    let now = distance(frame);
    let before = frame.checked_sub(BEFORE_FRAMES).and_then(distance);
    if now.zip(before).is_some_and(|(now, before)| now > before - NOISE_M) {
        return WhyKept::NotCloser;
    }
    let stopping = speed.map(|v| v * REACTION_S + v * v / (2.0 * COMFORTABLE_MPS2));
    if now.zip(stopping).is_some_and(|(now, stopping)| now > stopping) {
        WhyKept::FarAway
    } else if speed.is_some_and(|v| v < SLOW_MPS) {
        WhyKept::Slow
    } else {
        WhyKept::Driving
    }
}

/// Which phrasings are taken.
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

/// Wanted length in characters (LABELING.md 7: 50 to 100 in Chinese; in English some 25 to 60 words).
fn wanted(lang: Lang) -> RangeInclusive<usize> {
    match lang {
        Lang::Zh => 50..=100,
        Lang::En => 120..=330,
    }
}

/// The trace with the phrasings that `seed` chooses, as long as a trace should be: with what the ego does at the
/// keyframe where there is room, and with fewer things in the state where there is not.
pub(super) fn trace(facts: &DraftFacts<'_>, signals: &SignalTable, keyframe: usize, seed: u64) -> String {
    let choice = Choice::of(seed);
    let opening = opening(facts, signals, keyframe, choice.opening);
    let opens = (choice.opening / 8).is_multiple_of(2);
    let variants = [(MOST_IN_STATE, opens), (MOST_IN_STATE, !opens), (1, opens), (1, !opens)];
    let texts: Vec<String> = variants
        .into_iter()
        .map(|(things, opens)| facts.sentence(opening.as_deref().filter(|_| opens), things, choice))
        .collect();
    let wanted = wanted(facts.lang);
    let length = |t: &&String| t.chars().count();
    let fits = texts.iter().find(|t| wanted.contains(&length(t)));
    // None fits: the one that is least too long, or else the longest.
    let nearest = || {
        texts.iter().min_by_key(|t| {
            let n = length(t);
            if n > *wanted.end() { (1, n) } else { (0, wanted.start().saturating_sub(n)) }
        })
    };
    fits.or_else(nearest).cloned().unwrap_or_default()
}

/// What the ego does at the keyframe.
fn opening(facts: &DraftFacts<'_>, signals: &SignalTable, keyframe: usize, seed: u64) -> Option<String> {
    let speed = signals.frame_columns.get("ego.speed")?.number(keyframe)?;
    let all = facts.framework.draft_texts.openings();
    if speed < STANDING_MPS {
        // Where nothing is decided, the rest says so.
        return facts.decides().then(|| all.standing.pick(facts.lang, seed).to_owned());
    }
    // Who still rolls at the keyframe and then moves off has no speed worth telling.
    if facts.decision.longitudinal == Some(Longitudinal::Resume) {
        return None;
    }
    // Nor is there room for it before what says already where the ego drives.
    let of_ego = if facts.lang == Lang::Zh { "自车" } else { "the ego " };
    if facts.components.iter().take(MOST_IN_STATE).any(|c| c.description.starts_with(of_ego)) {
        return None;
    }
    let kmh = (speed * 3.6 / SPEED_STEP_KMH).round().max(1.0) * SPEED_STEP_KMH;
    Some(all.moving.pick(facts.lang, seed).replace("{speed}", &format!("{kmh:.0}")))
}

impl<'a> DraftFacts<'a> {
    /// One way to say it. The first component is said last in the state: what follows refers to it.
    fn sentence(&self, opening: Option<&str>, things: usize, choice: Choice) -> String {
        let texts = &self.framework.draft_texts;
        let things = self.components.iter().take(things).rev();
        let state: Vec<&str> = things.map(|c| c.description.trim_end_matches(['。', '.'])).collect();
        let why = texts.why(self.class, self.decision).map_or("", |p| p.pick(self.lang, choice.why));
        let action = self.action(choice.action);
        let joined = self.joints().pick(self.lang, choice.joined);
        let (comma, stop) = if self.lang == Lang::Zh { ("，", "。") } else { ("; ", ".") };
        let state = state.join(comma);
        let core = match (state.is_empty(), why.is_empty()) {
            (false, false) => {
                joined.replace("{state}", &state).replace("{why}", why).replace("{action}", &action)
            }
            (false, true) => format!("{state}{comma}{action}{stop}"),
            (true, false) => format!("{why}{comma}{action}{stop}"),
            (true, true) => format!("{action}{stop}"),
        };
        match (opening, self.lang) {
            (Some(opening), Lang::Zh) => format!("{opening}，{core}"),
            (Some(opening), Lang::En) => format!("{}. {}", capital(opening), capital(&core)),
            (None, _) => capital(&core),
        }
    }

    /// That nothing changes.
    fn none(&self) -> &'a Phrasings {
        &self.framework.draft_texts.kept(self.kept).none
    }

    /// How the parts are joined. Where nothing new is decided, what calls for a decision is no reason for what the ego
    /// does; nor is what others do where it turns as its route has it.
    fn joints(&self) -> &'a Phrasings {
        let texts = &self.framework.draft_texts;
        let kept = if self.decision.lateral.is_some() { WhyKept::Turning } else { self.kept };
        if self.decides() { texts.traces() } else { &texts.kept(kept).traces }
    }

    fn decides(&self) -> bool {
        let own_turn = |l: Lateral| l != Lateral::Turn || self.class.l1 == "proactive";
        self.decision.longitudinal.is_some() || self.decision.lateral.is_some_and(own_turn)
    }

    /// The decision of both channels.
    fn action(&self, seed: u64) -> String {
        let (texts, lang) = (&self.framework.draft_texts, self.lang);
        let DrivingDecision { longitudinal, lateral, lateral_direction } = self.decision;
        let along = longitudinal
            .and_then(|d| texts.longitudinal(self.class, d))
            .map(|p| p.pick(lang, seed).to_owned());
        let across = lateral.and_then(|d| texts.lateral(self.class, d)).map(|p| {
            let text = p.pick(lang, seed);
            match lateral_direction {
                Some(side) => text.replace("{side}", texts.side(*side, lang)),
                None => without_side(text),
            }
        });
        match (lang, along, across) {
            (_, None, None) => self.none().pick(lang, seed).to_owned(),
            (Lang::Zh, Some(a), Some(b)) => format!("{a}，并{b}"),
            (Lang::Zh, None, Some(b)) => format!("自车{b}"),
            (Lang::En, Some(a), Some(b)) => format!("{a} and {b}"),
            (Lang::En, None, Some(b)) => format!("the ego {b}"),
            (_, Some(a), None) => a,
        }
    }

    /// Numbers of phrasings: of the reason, of the decision (whose parts are chosen by one number), and of the joints.
    fn phrasings(&self) -> (u64, u64, u64) {
        let (texts, lang) = (&self.framework.draft_texts, self.lang);
        let count = |p: &Phrasings| p.all(lang).len().max(1) as u64;
        let why = texts.why(self.class, self.decision).map_or(1, count);
        let along =
            self.decision.longitudinal.and_then(|d| texts.longitudinal(self.class, d)).map_or(1, count);
        let across = self.decision.lateral.and_then(|d| texts.lateral(self.class, d)).map_or(1, count);
        let action =
            if along * across == 1 { count(self.none()) } else { along * across / common(along, across) };
        (why, action, count(self.joints()))
    }

    /// The trace has the beginning of a reason of the class in it, or what is said instead: cheap, and rare where a
    /// person has written it.
    fn may_be(&self, trace: &str) -> bool {
        let begins = |text: &str| has_beginning(trace, text);
        if !self.decides() {
            let mut kept = self.joints().all(self.lang).iter();
            return kept.any(|joint| {
                let said = joint.trim_start_matches("{state}").trim_start_matches(['；', ';', ' ']);
                begins(said)
            });
        }
        let Some(whys) = self.framework.draft_texts.why(self.class, self.decision) else { return true };
        whys.all(self.lang).iter().any(|why| begins(why))
    }
}

/// Greatest common divisor.
fn common(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common(b, a % b) }
}

/// An action whose side is not known yet: a person states it.
fn without_side(text: &str) -> String {
    let parts = [
        ("向{side}偏移", "向一侧偏移"),
        ("向{side}", ""),
        ("从{side}侧", ""),
        ("{side}转", "转弯"),
        (" to the {side} lane", " lanes"),
        (" to the {side}", ""),
        (" {side}", ""),
    ];
    parts.iter().fold(text.to_owned(), |text, (with, without)| text.replace(with, without))
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

/// A number from an id and a run's seed, the same on every machine (FNV-1a, and the last step of SplitMix64, without
/// which the high bits of ids that differ in a digit are alike).
pub(super) fn seed(id: &str, run: u64) -> u64 {
    let h = id
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325 ^ run, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    let z = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// In both languages, whatever keeps the ego from deciding.
fn all_facts<'a>(
    framework: &'a Framework,
    class: &'a ScenarioId,
    components: &'a [CriticalComponent],
    decision: &'a DrivingDecision,
) -> impl Iterator<Item = DraftFacts<'a>> {
    let of = move |lang, kept| DraftFacts { framework, class, components, decision, kept, lang };
    [Lang::Zh, Lang::En].into_iter().flat_map(move |lang| {
        // It is said only where nothing new is decided.
        let count = if of(lang, WhyKept::Driving).decides() { 1 } else { WhyKept::ALL.len() };
        WhyKept::ALL.into_iter().take(count).map(move |kept| of(lang, kept))
    })
}

/// `trace` has the beginning of `text` in it; the first letter may be a capital there and is left out.
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

/// True when `trace` ends with what a draft of these parts says, in any of its phrasings: nobody has written it. What a
/// draft says of the ego before that is not compared: it depends on the recording.
pub(crate) fn is_draft(
    framework: &Framework,
    class: &ScenarioId,
    components: &[CriticalComponent],
    decision: &DrivingDecision,
    trace: &str,
) -> bool {
    let bare =
        |t: &str| t.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    let all = all_facts(framework, class, components, decision);
    let likely: Vec<DraftFacts<'_>> = all.filter(|facts| facts.may_be(trace)).collect();
    if likely.is_empty() {
        return false;
    }
    let trace = bare(trace);
    likely.into_iter().any(|facts| {
        let (whys, actions, joints) = facts.phrasings();
        (1..=MOST_IN_STATE).any(|things| {
            (0..whys * actions * joints).any(|i| {
                let choice = Choice {
                    why: i % whys,
                    action: i / whys % actions,
                    joined: i / whys / actions,
                    opening: 0,
                };
                trace.ends_with(&bare(&facts.sentence(None, things, choice)))
            })
        })
    })
}

/// The component that says what the class is about, where the recording shows none that does.
pub(super) fn seen(
    framework: &Framework,
    class: &ScenarioId,
    found: &[CriticalComponent],
    lang: Lang,
) -> Option<CriticalComponent> {
    let words = framework.label_words();
    let about = framework.decision_table().leaves.get(class).map(|c| c.about);
    // A light says what a class is about only where the class is about nothing else.
    let light = words.kinds.get("light").copied().unwrap_or_default();
    let only_light = about == Some(light);
    let is_light =
        |c: &CriticalComponent| c.category.as_deref() == Some(ComponentCategory::TrafficLights.id());
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
    // Where nothing is known of the class, what was found has to do; a light alone says little of other classes.
    if found.iter().any(speaks) || (about.is_none() && !found.iter().all(is_light)) {
        return None;
    }
    let seen = framework.draft_texts.seen(class)?;
    Some(CriticalComponent {
        category: seen.category.map(|c| c.id().to_owned()),
        description: seen.get(lang).to_owned(),
        uncertainty: seen.high.then_some(whyroad_model::messages::Uncertainty::High),
        id: None,
        evidence_times: Vec::new(),
        linked_objects: Vec::new(),
    })
}
