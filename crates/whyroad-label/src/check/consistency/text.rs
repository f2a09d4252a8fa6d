//! Texts against each other and against the class: a trace that is unrelated to its components, a decision that
//! continues as before, and words that belong to another class.

use crate::check::consistency::ego_at_last;
use crate::check::consistency::trace::{Force, Mention, Reading};
use crate::check::consistency::trace_rules;
use crate::check::overlap;
use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::TextScope;
use crate::check::view::View;
use whyroad_framework::check::class_index::Prescribed;
use whyroad_framework::check::{Finding, Sink, Words};
use whyroad_framework::label_words::{ConceptSet, Divider, GroupSet};
use whyroad_framework::lexicon::units::Units;
use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::label_fields::pointer;

/// Positions of the parts of a trace.
pub(in crate::check) struct TraceParts {
    /// It names the ego, or an action of a driver.
    pub acts: bool,
    /// First byte of its reason, if a word introduces one.
    pub because: Option<usize>,
    /// First byte of its decision.
    pub decides: usize,
    /// First byte of the last action of the ego.
    pub last: usize,
}

impl TraceParts {
    /// Without a trace all fields are empty.
    pub fn of(reading: Option<&Reading>) -> Self {
        let Some(r) = reading else { return Self { acts: false, because: None, decides: 0, last: 0 } };
        let all = r.mentions.iter().filter(|m| !m.by_other && m.force == Force::Asserted);
        let own = |m: &&Mention| !m.by_other && matches!(m.force, Force::Asserted | Force::Doubtful);
        let acts = r.mentions.iter().filter(own);
        let first = all.map(|m| m.start).find(|at| !r.marked || *at >= r.decision_from);
        Self {
            acts: !r.mentions.is_empty() || r.names_ego,
            because: r.because,
            decides: if r.marked { r.decision_from } else { first.unwrap_or(r.end) },
            last: acts.map(|m| m.start).next_back().unwrap_or(r.end),
        }
    }
}

/// The trace is about the subjects of the components. Returns true when it is unrelated to them.
pub(in crate::check) fn unrelated(scope: &TextScope<'_>, parts: &TraceParts, sink: &mut dyn Sink) -> bool {
    let TraceParts { acts, because, decides, last } = *parts;
    let TextScope { label, texts, words, background, .. } = *scope;
    if words.is_empty() || label.trace.get().is_none_or(|t| t.trim().is_empty()) {
        return false;
    }
    let reasonless = texts.trace.no_reason.map(|at| (at, true));
    let elsewhere = || {
        let own = because.and_then(|at| reason_elsewhere(scope, at));
        let other = || reason_of_others(scope, decides);
        own.or_else(other).or_else(|| reason_of_no_road(scope, decides)).map(|at| (at, false))
    };
    let found = reasonless.or_else(elsewhere);
    let covered = found.is_some() && restates(scope, last);
    if let Some((at, none)) = found.filter(|(_, none)| *none || !covered) {
        without_reason(label, at, none, sink);
        return true;
    }
    let components = texts.all_components(words);
    let nothing = texts.trace.groups.is_empty()
        && texts.trace.words == 0
        && !label.trace.get().is_some_and(|t| words.is_of_driving(t))
        || !acts && !texts.trace.groups.meets(components);
    let speaks_of = texts.trace.groups.without(background);
    if says_nothing_of_them(scope, last) {
        unrelated_to_all(sink);
        return true;
    }
    if !nothing && (components.is_empty() || speaks_of.is_empty() || texts.trace.groups.meets(components)) {
        return false;
    }
    // Other words may still be shared, fewer where a component is in words that are in no list.
    let enough = |t: &str| if t.is_ascii() || any_unread(scope) { 1 } else { 2 };
    if label.trace.get().is_some_and(|t| {
        overlap::shared(label, t, &words.compared, &|_| true) >= enough(t)
            || overlap::shares_characters(label, t, words)
    }) {
        return false;
    }
    if restates(scope, text_length(label)) {
        return false;
    }
    unrelated_to_all(sink);
    true
}

fn text_length(label: &View<'_>) -> usize {
    label.trace.get().map_or(0, str::len)
}

fn unrelated_to_all(sink: &mut dyn Sink) {
    sink.report(Finding::warning("label.text.unrelated", pointer::COC_TRACE), &|| {
        Words::new(
            "因果描述与关键要素无关：没有提到其中任何一个",
            "the trace is unrelated to the components: it names none of them",
        )
        .hint("按要素写出状态、原因、决策", "write state, reason and decision from the components")
    });
}

/// Meanings of all components, and how many of them the trace has, too, whatever its words. `to`: end of the part of
/// the trace.
pub(in crate::check) fn coverage(scope: &TextScope<'_>, to: usize) -> (u32, u32) {
    let TextScope { label, words, .. } = *scope;
    let of = |text: &str| words.concepts.of(text, &Units::of(text));
    let all = label.parts.iter().filter_map(|c| c.description.get()).map(of);
    let all = all.fold(ConceptSet::default(), ConceptSet::with);
    let said = label.trace.get().and_then(|t| t.get(..to)).map_or(ConceptSet::default(), of);
    (all.only(said).count(), all.count())
}

/// The trace says half of what the components say, in its own words: it is about them.
pub(in crate::check) fn restates(scope: &TextScope<'_>, to: usize) -> bool {
    const LEAST: u32 = 3;
    let (shared, all) = coverage(scope, to);
    shared >= LEAST && 2 * shared >= all
}

/// The trace says nothing of what the components say: it shares neither a thing nor a word with them, and next to no
/// meaning.
///
/// `last`: first byte of the last action of the ego. What the trace says before the clause with it is its reason.
fn says_nothing_of_them(scope: &TextScope<'_>, last: usize) -> bool {
    /// Minimum number of meanings of the components.
    const LEAST: u32 = 2;
    const SHARE: f64 = 0.15;
    /// Maximum share of the whole trace, which may be about the one to whom the ego gives way.
    const MOST: f64 = 0.3;
    /// Minimum number of letters of a reason.
    const LEAST_REASON: usize = 12;
    let TextScope { label, texts, words, background, .. } = *scope;
    let Some(text) = label.trace.get() else { return false };
    // Too short for a reason, which is reported as such.
    if text.chars().filter(|c| c.is_alphanumeric()).nth(LEAST_REASON).is_none() {
        return false;
    }
    let end = last.min(text.len());
    let (clause, _) = words.clauses.around(&texts.units, end..end, text.len(), &|d| d != Divider::Aside);
    // Without anything before the decision, the reason may be in its clause.
    let to = if text[..clause].chars().filter(|c| c.is_alphanumeric()).nth(LEAST_REASON).is_some() {
        clause
    } else {
        text.len()
    };
    let components = texts.all_components(words);
    let components = if to < text.len() { components.without(background) } else { components };
    if texts.trace.named.iter().any(|n| n.start < to && words.objects[n.group].own.meets(components)) {
        return false;
    }
    let is_common = |at: usize| to < text.len() && words.subjects.is_common(text, at);
    if overlap::shared(label, text, &words.compared, &|at| at < to && !is_common(at)) > 0
        || overlap::shares_characters(label, &text[..to], words)
    {
        return false;
    }
    // "58 in what is now a 40".
    let numbers = |t: &str| -> Vec<String> {
        let all = t.split(|c: char| !c.is_ascii_digit()).filter(|w| w.len() > 1);
        all.map(str::to_owned).collect()
    };
    let said = numbers(text);
    let mut given = label.parts.iter().filter_map(|c| c.description.get()).flat_map(numbers);
    if given.any(|n| said.contains(&n)) {
        return false;
    }
    let (shared, all) = coverage(scope, to);
    let is_little = |shared: u32, share: f64| f64::from(shared) <= share * f64::from(all);
    all >= LEAST
        && is_little(shared, SHARE)
        && (to == text.len() || is_little(coverage(scope, text.len()).0, MOST))
}

/// Bytes of the reason in the trace, if it names nothing, has no word about driving, and shares none with the
/// components although it has several: "because the battery is down to nine per cent". `from`: its first byte.
fn reason_elsewhere(scope: &TextScope<'_>, from: usize) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, .. } = *scope;
    let text = label.trace.get()?;
    let (_, to) = words.clauses.around(&texts.units, from..from, text.len(), &|d| d == Divider::Sentence);
    let part = text.get(from..to)?;
    let inside = |at: usize| (from..to).contains(&at);
    let elsewhere = !texts.trace.named.iter().any(|n| inside(n.start))
        && !words.is_of_driving(part)
        && overlap::says_more(text, &words.compared, &inside)
        && overlap::shared(label, text, &words.compared, &inside) == 0;
    elsewhere.then_some((from, to))
}

/// Bytes of a reason that names things, none of which is close to a thing of the components, and that has no word of
/// any component: the toll plaza, where the components have sheep. Checked only if all components have been read. The
/// route alone is no reason for a response to a road user. `to`: one past its last byte.
fn reason_of_others(scope: &TextScope<'_>, to: usize) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, background, about, .. } = *scope;
    let text = label.trace.get()?;
    let named = |n: &Named| words.objects[n.group].own;
    let all = || texts.trace.named.iter().filter(|n| n.start < to);
    let things = all().filter(|n| !n.supposed).fold(GroupSet::default(), |set, n| set.with(named(n)));
    let components = texts.all_components(words).without(background);
    let own = things.without(background);
    // A reason about a road or its condition does not state who else is there.
    let adverse = about.meets(words.known.adverse) && !about.meets(words.known.actor);
    let components = if adverse { components.without(words.known.actor) } else { components };
    let by_route = || {
        let actor = components.meets(words.known.actor) && trace_rules::responds(label);
        actor
            && things.meets(words.known.route)
            && !things.meets(words.known.gap)
            && !words.subjects.has_pronoun(text)
    };
    if components.is_empty() || own.meets(components) || things.meets(about) || own.is_empty() && !by_route()
    {
        return None;
    }
    let is_name = |at: usize| all().any(|n| (n.start..n.end).contains(&at));
    let is_common = |at: usize| words.subjects.is_common(text, at);
    let inside = |at: usize| at < to && !is_name(at) && !is_common(at);
    let shared = overlap::shared(label, text, &words.compared, &inside);
    (shared == 0 && !any_unread(scope)).then_some((0, to))
}

/// Bytes of the text before the decision, if it names nothing that the components name or the class is about, and has
/// several words, none of which is in the components: "oil prices have gone up again".
fn reason_of_no_road(scope: &TextScope<'_>, to: usize) -> Option<(usize, usize)> {
    let TextScope { label, texts, words, background, about, .. } = *scope;
    let text = label.trace.get()?;
    let part = text.get(..to)?;
    let components = texts.all_components(words).with(about);
    let own = |n: &Named| words.objects[n.group].own;
    let inside = |at: usize| at < to;
    // "My sister" is not an obstacle for the ego.
    let of_ego = |part: &str| match part.is_ascii() {
        true => part
            .split(|c: char| !c.is_ascii_alphabetic())
            .any(|w| ["ego", "we", "us", "our"].iter().any(|own| w.eq_ignore_ascii_case(own))),
        false => words.subjects.speaks_of_ego(part),
    };
    // The location of the ego belongs to the scene, too.
    let known = texts
        .trace
        .named
        .iter()
        .filter(|n| inside(n.start))
        .any(|n| own(n).meets(components) || own(n).meets(background) && !own(n).meets(words.known.gap));
    // About a meal or a football match, whatever words it shares.
    if !known && texts.trace.idle.is_some_and(|(at, _)| inside(at)) {
        return Some((0, to));
    }
    if known
        || texts.trace.acts.iter().any(|a| inside(a.start))
        || of_ego(part)
        || words.subjects.speaks_of_side(part)
        || part.is_ascii() && words.is_of_driving(part)
        || !overlap::says_more(text, &words.compared, &inside)
    {
        return None;
    }
    let is_common = |at: usize| words.subjects.is_common(text, at);
    let other = |at: usize| inside(at) && !is_common(at);
    let shares = overlap::shared(label, text, &words.compared, &other) > 0
        || overlap::shares_characters(label, part, words);
    (!shares && !any_unread(scope)).then_some((0, to))
}

/// `none`: the trace states this itself.
fn without_reason(label: &View<'_>, (start, end): (usize, usize), none: bool, sink: &mut dyn Sink) {
    let Some(text) = label.trace.get() else { return };
    sink.report(Finding::warning("label.text.unrelated", pointer::COC_TRACE).part(start, end), &|| {
        let reason = text[start..end].trim();
        match none {
            true => Words::new(
                format!("因果描述说“{reason}”，没有给出原因"),
                format!("the trace says '{reason}' and gives no reason"),
            ),
            false => Words::new(
                format!("因果描述给出的原因“{reason}”与关键要素无关"),
                format!("the reason in the trace, '{reason}', is unrelated to the components"),
            ),
        }
        .hint("按要素写出状态、原因、决策", "write state, reason and decision from the components")
    });
}

/// Some component mentions a thing in words that are in no list.
fn any_unread(scope: &TextScope<'_>) -> bool {
    let TextScope { label, texts, words, .. } = *scope;
    let mut parts = label.parts.iter().zip(&texts.components);
    parts.any(|(c, f)| c.description.get().is_none_or(|t| subject::is_unread(t, f, words)))
}

/// A stop is decided once: an ego that is already stationary and remains so decides nothing (LABELING.md 6,
/// minimality).
pub(in crate::check) fn unchanged(scope: &TextScope<'_>, sink: &mut dyn Sink) {
    let TextScope { label, texts, words, .. } = *scope;
    let stops = matches!(
        label.longitudinal.get(),
        Some(
            Longitudinal::StopForRegulation
                | Longitudinal::StopForObstacle
                | Longitudinal::YieldToAgent
                | Longitudinal::LeadFollowing
        )
    );
    // Keeping the lane or the speed is a decision by itself, but not in addition to another one.
    let beside = match (label.longitudinal.get(), label.lateral.get()) {
        (Some(along), Some(Lateral::LaneKeeping)) => along != Longitudinal::SetSpeedTracking,
        (Some(Longitudinal::SetSpeedTracking), Some(_)) => true,
        _ => false,
    };
    let course = || {
        let lower = label.trace.get()?.to_ascii_lowercase();
        let all = words.unchanged_course.iter();
        // "As the lane ran before": the course of the road.
        let of_thing =
            |end: usize| ["的走向", "的线形", "的方向"].iter().any(|w| lower[end..].starts_with(w));
        let found = all.filter_map(|w| lower.rfind(w.as_str()).map(|at| (at, at + w.len())));
        found.filter(|(_, end)| !of_thing(*end)).max()
    };
    // "The wheel has not moved, in the middle of the lane as before": also beside a set speed, which is kept by itself.
    let keeps_lane = label.longitudinal.get().is_some() && label.lateral.get() == Some(Lateral::LaneKeeping);
    let as_before = if beside { course() } else { None };
    let kept = as_before.or_else(|| keeps_lane.then(|| kept_course(scope)).flatten());
    let (Some((start, end)), Some(text)) = (
        texts.trace.unchanged.filter(|_| stops).or(kept).or_else(|| ego_at_last::as_before(scope)),
        label.trace.get(),
    ) else {
        return;
    };
    sink.report(
        Finding::warning("label.decision.unchanged", pointer::DRIVING_DECISION_LONGITUDINAL),
        &|| {
            let phrase = &text[start..end];
            Words::new(
                format!("因果描述说“{phrase}”：自车只是保持原状，没有做出新的决策"),
                format!(
                    "the trace says '{phrase}': the ego continues as before, which is not a new decision"
                ),
            )
            .hint(
                "选“无决策变化”；或把关键帧移到自车开始减速之前",
                "choose 'no change of decision', or move the keyframe to before the ego starts to slow",
            )
        },
    );
}

/// Bytes of a clause of the trace that states that the ego's course stays as it was.
fn kept_course(scope: &TextScope<'_>) -> Option<(usize, usize)> {
    let TextScope { label, words, .. } = *scope;
    let lower = label.trace.get()?.to_ascii_lowercase();
    let mut from = 0;
    for clause in lower.split(['，', '。', '；', '、', ',', '.', ';']) {
        let to = from + clause.len();
        let of_speed = clause.contains("speed") || clause.contains('速');
        if !of_speed && words.forms.course.find(clause).is_some() && words.forms.same.find(clause).is_some() {
            let begin = from + (clause.len() - clause.trim_start().len());
            return Some((begin, to));
        }
        from = to + lower[to..].chars().next().map_or(0, char::len_utf8);
    }
    None
}

/// The texts are about the subject of the class. Reported only where they are about something else, and about no thing
/// or road user in words that are in no list. `background`: things that are not the subject of a text.
pub(in crate::check) fn class(scope: &TextScope<'_>, prescribed: &Prescribed, sink: &mut dyn Sink) -> bool {
    let TextScope { label, texts, words, background, .. } = *scope;
    let Some(class) = &prescribed.decisions else { return false };
    if class.about.is_empty() || texts.components.is_empty() || words.is_empty() {
        return false;
    }
    let all = texts.components.iter().fold(texts.trace.groups, |set, f| set.with(f.groups));
    // A road user in words that are in no list, or one that may or may not be present.
    let supposes = |f: &TextFacts| f.named.iter().any(|n| n.supposed);
    let unknown_actor = texts.components.iter().any(|f| !f.states.is_empty() || supposes(f));
    if all.meets(class.about) || all.without(background).is_empty() || unknown_actor {
        return false;
    }
    // The road itself may hide the rest of the road: "nothing past the brow can be seen".
    let hides = class.about.meets(words.known.sight) && label.components.get().is_some_and(|c| c.any_high);
    let written = class.about.meets(words.known.sign) && {
        let mut texts = label.parts.iter().filter_map(|c| c.description.get());
        texts.any(|t| words.subjects.speaks_of_writing(t))
    };
    // A place may have any name; a road user that is absent cannot.
    let facility = words.kinds.get("facility").copied().unwrap_or_default();
    let something = words.known.actor.with(words.known.adverse).with(facility);
    let by_place = !class.about.meets(words.known.actor) && !all.meets(something);
    // The first component is about the weather: whatever the other words, the class is about something else.
    let kind = |id: &str| words.kinds.get(id).copied().unwrap_or_default();
    let weather =
        kind("rain").with(kind("fog")).with(kind("snow")).with(kind("snow_ice")).with(kind("glare"));
    let by_weather = !class.about.meets(words.known.condition.without(kind("bump")))
        && texts
            .components
            .first()
            .is_some_and(|f| f.there().any(|n| words.objects[n.group].own.meets(weather)));
    if hides || written || !by_weather && (by_place || any_unread(scope)) {
        return false;
    }
    sink.report(Finding::warning("label.text.class", pointer::SCENARIO), &|| {
        let about: Vec<Bilingual> = class.about_names.iter().map(|id| words.kind_name(id)).collect();
        let list = |pick: fn(&Bilingual) -> &String, or: &str| {
            about.iter().map(|b| pick(b).as_str()).collect::<Vec<_>>().join(or)
        };
        Words::new(
            format!("“{}”的文字应提到：{}；这里没有", prescribed.title.zh, list(|b| &b.zh, "、")),
            format!(
                "the texts of '{}' should mention: {}; these do not",
                prescribed.title.en,
                list(|b| &b.en, ", ")
            ),
        )
        .hint(
            "检查场景类别，或补上触发决策的要素",
            "check the scenario class, or add the component that triggered the decision",
        )
    });
    true
}
