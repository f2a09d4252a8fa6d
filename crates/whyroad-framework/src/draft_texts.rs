//! Texts of label drafts (`schema/draft_texts.yaml`, which documents each part).

#[cfg(test)]
mod checked;

use crate::{Taxonomy, yaml_text};
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::yaml::Node;
use whyroad_model::{Bilingual, ComponentCategory, Diagnostic, Lang, Location, ScenarioId};

/// All texts of drafts.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DraftTexts {
    #[allow(dead_code)] // read by people
    #[serde(default)]
    version: String,
    sides: BTreeMap<String, Pair>,
    openings: Openings,
    traces: Phrasings,
    /// By id of [`WhyKept`].
    kept: BTreeMap<String, KeptTexts>,
    /// States that the ego continues a change of its speed, without a new decision: `rises` or `falls`.
    goes_on: BTreeMap<String, Phrasings>,
    /// Why the lead requires a decision where the class is about something else.
    lead: Vec<WhyWhen>,
    /// Why the light requires a decision where the class is about something else.
    #[serde(default)]
    light: Vec<WhyWhen>,
    /// Words whose truth the signals show.
    #[serde(default)]
    claims: Vec<Claim>,
    classes: BTreeMap<String, ClassTexts>,
    decisions: DecisionTexts,
}

/// Words that state something which signals show.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Any of these.
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
    /// Only in drafts of this class, or of the L3 classes of this L2 class.
    of: Option<ScenarioId>,
    /// They are about the lead.
    #[serde(default)]
    pub of_lead: bool,
    /// They are true where all of these hold.
    #[serde(default)]
    pub when: Vec<SignalCondition>,
    /// Facts that they state; no text states a fact and denies it.
    #[serde(default)]
    pub states: Vec<String>,
    /// Facts that they deny.
    #[serde(default)]
    pub denies: Vec<String>,
}

impl Claim {
    /// `text` is in lower case, since a sentence may begin with the words.
    fn is_made(&self, text: &str, lang: Lang) -> bool {
        let words = match lang {
            Lang::Zh => &self.zh,
            Lang::En => &self.en,
        };
        words.iter().any(|word| text.contains(word.as_str()))
    }

    fn is_of(&self, class: &ScenarioId) -> bool {
        let same = |of: &ScenarioId| of.l1 == class.l1 && of.l2 == class.l2;
        self.of.as_ref().is_none_or(|of| same(of) && (of.l3.is_none() || of.l3 == class.l3))
    }
}

/// What the ego does at the keyframe.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Openings {
    /// It stands.
    pub standing: Phrasings,
    /// It moves; `{speed}` is its speed.
    pub moving: Phrasings,
    /// It moves, and the text has a number of something else.
    pub moving_without_speed: Phrasings,
}

/// Texts of one class.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassTexts {
    /// The component where the recording shows none.
    seen: Option<Seen>,
    /// More specific components by signals: the first whose conditions hold at the keyframe.
    seen_when: Option<Vec<SeenWhen>>,
    /// A further component where signals show what the reason refers to: the first whose conditions hold.
    also_when: Option<Vec<SeenWhen>>,
    /// The navigation route is a component, where the recording has it.
    routed: Option<bool>,
    /// The class is about the lead, where its rule names no target.
    of_lead: Option<bool>,
    /// Action of the episode's target, where the class describes it better than its motion at the keyframe.
    doing: Option<Pair>,
    /// Action of the target by its signals: the first that holds at the keyframe.
    #[serde(default)]
    doing_when: Vec<DoingWhen>,
    /// Why it requires a decision.
    why: Option<Phrasings>,
    /// The same while signals hold: the first whose conditions do.
    #[serde(default)]
    why_when: Vec<WhyWhen>,
    /// The same for one decision, by its id.
    #[serde(default)]
    why_for: BTreeMap<String, Phrasings>,
    /// The same where only one of the two channels decides.
    why_only: Option<WhyOnly>,
    /// Without a new decision, in the class's own words.
    #[serde(default)]
    kept: BTreeMap<String, KeptTexts>,
    /// Decisions of both channels, in the class's own words.
    #[serde(default)]
    decisions: BTreeMap<String, Phrasings>,
}

/// A condition on a signal at the keyframe: a flag is true, or a number or category meets the condition.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalCondition {
    /// A signal of frames or of the episode's target, or one of `around.*`, `decided.*`, `past.*` and `soon.*`, which
    /// drafts make themselves.
    pub signal: String,
    /// A flag is false instead.
    #[serde(default)]
    pub isnt: bool,
    /// A category.
    pub is: Option<String>,
    /// A number is greater than this, in base units.
    pub above: Option<f64>,
    /// A number is less than this, in base units.
    pub below: Option<f64>,
    /// A number is greater than another signal.
    pub above_signal: Option<String>,
    /// A number is less than another signal.
    pub below_signal: Option<String>,
}

/// Action of a target while conditions hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoingWhen {
    /// All of these hold.
    pub when: Vec<SignalCondition>,
    zh: String,
    en: String,
}

impl DoingWhen {
    /// In Chinese and English.
    pub fn texts(&self) -> (&str, &str) {
        (&self.zh, &self.en)
    }
}

/// A component while conditions hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeenWhen {
    /// All of these hold.
    pub when: Vec<SignalCondition>,
    /// The speed that `{number}` stands for, in km/h.
    pub number: Option<String>,
    /// Category of the component; that of `seen` where it is not stated.
    pub category: Option<ComponentCategory>,
    zh: String,
    en: String,
}

impl SeenWhen {
    /// In `lang`.
    pub fn get(&self, lang: Lang) -> &str {
        match lang {
            Lang::Zh => &self.zh,
            Lang::En => &self.en,
        }
    }
}

/// Why it requires a decision while conditions hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhyWhen {
    when: Vec<SignalCondition>,
    /// Of this decision only, by its id; `none` for no new decision.
    decision: Option<String>,
    why: Phrasings,
}

impl WhyWhen {
    fn is_of_none(&self) -> bool {
        self.decision.as_deref() == Some("none")
    }
}

/// Those of one decision, or of no new one.
fn of_decision(all: &[WhyWhen], decision: Option<Longitudinal>) -> Vec<Reason<'_>> {
    let fits = |w: &&WhyWhen| match decision {
        Some(d) => w.decision.as_deref() == Some(d.id()),
        None => w.is_of_none(),
    };
    all.iter().filter(fits).map(|w| Reason { when: &w.when, texts: &w.why }).collect()
}

/// A reason, and when it may be given.
#[derive(Clone, Copy, Debug)]
pub struct Reason<'a> {
    /// All of these hold; without any it always may.
    pub when: &'a [SignalCondition],
    /// Alternative phrasings.
    pub texts: &'a Phrasings,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhyOnly {
    longitudinal: Option<Phrasings>,
    lateral: Option<Phrasings>,
}

/// Texts of the subject of a class.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    zh: String,
    en: String,
    /// Uncertainty high.
    #[serde(default)]
    pub high: bool,
    /// Category of the component.
    pub category: Option<ComponentCategory>,
}

impl Seen {
    /// In `lang`.
    pub fn get(&self, lang: Lang) -> &str {
        match lang {
            Lang::Zh => &self.zh,
            Lang::En => &self.en,
        }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pair {
    zh: String,
    en: String,
}

/// Alternative phrasings.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Phrasings {
    zh: Vec<String>,
    en: Vec<String>,
}

impl Phrasings {
    /// All of `lang`.
    pub fn all(&self, lang: Lang) -> &[String] {
        match lang {
            Lang::Zh => &self.zh,
            Lang::En => &self.en,
        }
    }

    /// The one that `seed` chooses; empty where there is none.
    pub fn pick(&self, lang: Lang, seed: u64) -> &str {
        let all = self.all(lang);
        let n = all.len() as u64;
        all.get(seed.checked_rem(n).unwrap_or(0) as usize).map_or("", String::as_str)
    }
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct DecisionTexts {
    longitudinal: BTreeMap<String, Phrasings>,
    lateral: BTreeMap<String, Phrasings>,
}

/// Why there is no new decision: the situation at the keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyKept {
    /// The ego is at standstill.
    Standing,
    /// The ego's speed is already falling.
    Slowing,
    /// The ego's speed is already rising.
    Speeding,
    /// The target is beside the ego or behind it.
    Beside,
    /// The distance to the target does not shrink.
    NotCloser,
    /// The target is farther away than the ego needs to stop comfortably.
    FarAway,
    /// The target is beside the band that the ego sweeps.
    OffPath,
    /// The ego is slow.
    Slow,
    /// The class is not about another road user: the ego's speed suits the location.
    Suits,
    /// The ego turns, which changes nothing along its path.
    Turning,
    /// None of these is known.
    Driving,
}

impl WhyKept {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Standing,
        Self::Slowing,
        Self::Speeding,
        Self::Beside,
        Self::NotCloser,
        Self::FarAway,
        Self::OffPath,
        Self::Slow,
        Self::Suits,
        Self::Turning,
        Self::Driving,
    ];

    /// Its name in `schema/draft_texts.yaml`.
    pub fn id(self) -> &'static str {
        match self {
            Self::Standing => "standing",
            Self::Slowing => "slowing",
            Self::Speeding => "speeding",
            Self::Beside => "beside",
            Self::NotCloser => "not_closer",
            Self::FarAway => "far_away",
            Self::OffPath => "off_path",
            Self::Slow => "slow",
            Self::Suits => "suits",
            Self::Turning => "turning",
            Self::Driving => "driving",
        }
    }
}

/// Texts for no new decision.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptTexts {
    /// The reason why the ego continues its action.
    why: Option<Phrasings>,
    /// The statement that it continues.
    none: Option<Phrasings>,
}

impl DraftTexts {
    /// From the text of `schema/draft_texts.yaml`; `file` is named in diagnostics. Texts of a class that `taxonomy`
    /// does not have are never used: they are reported.
    pub fn parse(file: &str, text: &str, taxonomy: &Taxonomy) -> (DraftTexts, Vec<Diagnostic>) {
        let what = Bilingual::new("草稿文本", "the texts of drafts");
        let (texts, root): (DraftTexts, Node) = match yaml_text::read("lexicon.syntax", file, text, what) {
            Ok(read) => read,
            Err(finding) => return (DraftTexts::default(), vec![*finding]),
        };
        let known: Vec<ScenarioId> = taxonomy.ids().into_iter().filter(|id| id.l2.is_some()).collect();
        let known: Vec<String> = known.iter().map(ToString::to_string).collect();
        let classes = root.get("classes").map_or(&[][..], Node::entries).iter();
        let classes = classes.map(|e| (e.key.as_str(), e.mark, e.node.pointer.as_str()));
        let claims =
            root.get("claims").map_or(&[][..], Node::items).iter().filter_map(|claim| claim.get("of"));
        let claims = claims.filter_map(|of| Some((of.text()?, of.mark, of.pointer.as_str())));
        let unknown = classes.chain(claims).filter(|(id, ..)| !known.iter().any(|k| k == id));
        let found = unknown.map(|(id, mark, pointer)| {
            let message = Bilingual::new(
                format!("分类体系中没有 L2 或 L3 场景 '{id}'，它的草稿文本不起作用"),
                format!("the taxonomy has no L2 or leaf '{id}', so its texts of drafts have no effect"),
            );
            let at = Location { pointer: Some(pointer.to_owned()), ..yaml_text::location(file, text, mark) };
            let hint = did_you_mean(id, known.iter().map(String::as_str)).map(suggestion);
            Diagnostic { hint, ..Diagnostic::warning("lexicon.class", message).at(at) }
        });
        let found = found.collect();
        (texts, found)
    }

    /// Subject of the class: of the leaf, or of its L2.
    pub fn seen(&self, class: &ScenarioId) -> Option<&Seen> {
        self.of(class, |c| c.seen.as_ref())
    }

    /// The route is the reason for the ego's action: of the leaf, or of its L2.
    pub fn is_routed(&self, class: &ScenarioId) -> bool {
        self.of(class, |c| c.routed.as_ref()).is_some_and(|r| *r)
    }

    /// The class is about the lead, where its rule names no target: the leaf, or its L2.
    pub fn is_of_lead(&self, class: &ScenarioId) -> bool {
        self.of(class, |c| c.of_lead.as_ref()).is_some_and(|l| *l)
    }

    /// Why the lead requires this longitudinal decision, in any class, in the order in which they are tried.
    pub fn reasons_of_lead(&self, decision: Option<Longitudinal>) -> Vec<Reason<'_>> {
        of_decision(&self.lead, decision)
    }

    /// The same of the light.
    pub fn reasons_of_light(&self, decision: Option<Longitudinal>) -> Vec<Reason<'_>> {
        of_decision(&self.light, decision)
    }

    /// The claims that a text of the class makes.
    pub fn claims<'a>(
        &'a self,
        class: &'a ScenarioId,
        text: &str,
        lang: Lang,
    ) -> impl Iterator<Item = &'a Claim> {
        let text = text.to_ascii_lowercase();
        self.claims.iter().filter(move |claim| claim.is_of(class) && claim.is_made(&text, lang))
    }

    /// Action of the target, in Chinese and English: of the leaf, or of its L2.
    pub fn doing(&self, class: &ScenarioId) -> Option<(&str, &str)> {
        self.of(class, |c| c.doing.as_ref()).map(|p| (p.zh.as_str(), p.en.as_str()))
    }

    /// Action of the target while conditions hold: of the leaf, or of its L2.
    pub fn doing_when(&self, class: &ScenarioId) -> &[DoingWhen] {
        self.of(class, |c| Some(&c.doing_when).filter(|all| !all.is_empty())).map_or(&[], Vec::as_slice)
    }

    /// Subject of the class where signals are more specific than [`DraftTexts::seen`]: of the leaf, or of its L2.
    pub fn seen_when(&self, class: &ScenarioId) -> &[SeenWhen] {
        self.of(class, |c| c.seen_when.as_ref()).map_or(&[], Vec::as_slice)
    }

    /// A further component: of the leaf, or of its L2.
    pub fn also_when(&self, class: &ScenarioId) -> &[SeenWhen] {
        self.of(class, |c| c.also_when.as_ref()).map_or(&[], Vec::as_slice)
    }

    /// Why the class requires this decision, in the order in which they are tried; the last one has no conditions. An
    /// L2's text for this decision takes precedence over a leaf's text for any decision.
    pub fn reasons(&self, class: &ScenarioId, decision: &DrivingDecision) -> Vec<Reason<'_>> {
        let ids = [decision.longitudinal.map(Longitudinal::id), decision.lateral.map(Lateral::id)];
        let (mut found, mut any) = (Vec::new(), None);
        for c in self.levels(class) {
            let of_one = ids.iter().flatten().find_map(|d| Some((*d, c.why_for.get(*d)?)));
            let fits = |w: &&WhyWhen| match w.decision.as_deref() {
                _ if w.is_of_none() => false,
                Some(d) => ids.contains(&Some(d)) && (any.is_none() || of_one.is_some_and(|(of, _)| of == d)),
                None => any.is_none(),
            };
            found.extend(c.why_when.iter().filter(fits).map(|w| Reason { when: &w.when, texts: &w.why }));
            if let Some((_, texts)) = of_one {
                found.push(Reason { when: &[], texts });
                return found;
            }
            let only = c.why_only.as_ref().and_then(|only| match (decision.longitudinal, decision.lateral) {
                (Some(_), None) => only.longitudinal.as_ref(),
                (None, Some(_)) => only.lateral.as_ref(),
                _ => None,
            });
            any = any.or(only).or(c.why.as_ref());
        }
        found.extend(any.map(|texts| Reason { when: &[], texts }));
        found
    }

    /// The class, or its L2, has its own reason for this decision, by its id.
    pub fn has_reason_for(&self, class: &ScenarioId, decision: &str) -> bool {
        self.of(class, |c| c.why_for.get(decision)).is_some()
    }

    /// Why the class requires no new decision, by signals, in the order in which they are tried.
    pub fn reasons_for_none(&self, class: &ScenarioId) -> Vec<Reason<'_>> {
        let all = self.levels(class).flat_map(|c| &c.why_when);
        all.filter(|w| w.is_of_none()).map(|w| Reason { when: &w.when, texts: &w.why }).collect()
    }

    /// States that the ego's speed continues to change, without a new decision: `rises` or `falls`.
    pub fn goes_on(&self, trend: &str) -> Option<&Phrasings> {
        self.goes_on.get(trend)
    }

    /// Why there is no new decision, and the statement that there is none: in the class's own words, or else in the
    /// common words.
    pub fn kept(&self, class: &ScenarioId, kept: WhyKept) -> (Option<&Phrasings>, Option<&Phrasings>) {
        let of_all = self.kept.get(kept.id());
        let of_class = self.of(class, |c| c.kept.get(kept.id()));
        let part = |get: fn(&KeptTexts) -> Option<&Phrasings>| {
            of_class.and_then(get).or_else(|| of_all.and_then(get))
        };
        (part(|k| k.why.as_ref()), part(|k| k.none.as_ref()))
    }

    /// Texts of the class and, for a leaf, those of its L2.
    fn levels(&self, class: &ScenarioId) -> impl Iterator<Item = &ClassTexts> {
        let l2 = class.l3.is_some().then(|| ScenarioId { l3: None, ..class.clone() }.to_string());
        std::iter::once(class.to_string()).chain(l2).filter_map(|id| self.classes.get(&id))
    }

    fn of<T>(&self, class: &ScenarioId, part: impl Fn(&ClassTexts) -> Option<&T>) -> Option<&T> {
        self.levels(class).find_map(part)
    }

    /// A longitudinal decision as the end of a trace: in the class's own words, or else in the common words; each first
    /// for the ego's `motion` (`slows`, `stops`, `speeds_up`), then for any motion.
    pub fn longitudinal(&self, class: &ScenarioId, d: Longitudinal, motion: &str) -> Option<&Phrasings> {
        let keys = [format!("{}.{motion}", d.id()), d.id().to_owned()];
        let of_class = self.of(class, |c| keys.iter().find_map(|key| c.decisions.get(key)));
        of_class.or_else(|| keys.iter().find_map(|key| self.decisions.longitudinal.get(key)))
    }

    /// A lateral decision as the end of a trace, in the class's own words, or else in the common words; `{side}` stands
    /// for its direction.
    pub fn lateral(&self, class: &ScenarioId, d: Lateral) -> Option<&Phrasings> {
        self.of(class, |c| c.decisions.get(d.id())).or_else(|| self.decisions.lateral.get(d.id()))
    }

    /// Beginnings of a trace.
    pub fn openings(&self) -> &Openings {
        &self.openings
    }

    /// How the parts of a trace are joined: `{state}`, `{why}`, `{action}`.
    pub fn traces(&self) -> &Phrasings {
        &self.traces
    }

    /// The text of a direction.
    pub fn side(&self, side: LateralDirection, lang: Lang) -> &str {
        self.sides.get(side.id()).map_or("", |p| match lang {
            Lang::Zh => &p.zh,
            Lang::En => &p.en,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::WhyKept;
    use crate::Framework;
    use whyroad_model::Lang;
    use whyroad_model::decision::{Lateral, Longitudinal};
    use whyroad_model::messages::DrivingDecision;

    #[test]
    fn every_leaf_and_decision_has_texts() {
        let f = Framework::bundled();
        let is_known = |name: &str| {
            let own = ["around.", "decided.", "past.", "soon."];
            own.iter().any(|p| name.starts_with(p)) || f.signals_yaml.contains(&format!("- name: {name}\n"))
        };
        for leaf in f.specs.keys() {
            let seen = f.draft_texts.seen(leaf).unwrap_or_else(|| panic!("{leaf}"));
            assert!(!seen.get(Lang::Zh).is_ascii() && seen.get(Lang::En).is_ascii(), "{leaf}");
            assert!(seen.category.is_some(), "{leaf}");
            let none = DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };
            let reasons = f.draft_texts.reasons(leaf, &none);
            let last = reasons.last().unwrap_or_else(|| panic!("{leaf}"));
            assert!(last.when.is_empty(), "{leaf}");
            let texts = &f.draft_texts;
            let of_doing = texts.doing_when(leaf).iter().map(|w| &w.when[..]);
            let of_seen = texts.seen_when(leaf).iter().chain(texts.also_when(leaf)).map(|w| &w.when[..]);
            for when in of_doing.chain(of_seen).chain(reasons.iter().map(|r| r.when)).flatten() {
                let others = [&when.above_signal, &when.below_signal];
                for name in others.into_iter().flatten().chain([&when.signal]) {
                    assert!(is_known(name), "{leaf}: {name}");
                }
            }
            for lang in [Lang::Zh, Lang::En] {
                for reason in &reasons {
                    assert!(!reason.texts.all(lang).is_empty(), "{leaf}");
                }
                assert!(last.texts.all(lang).len() >= 2, "{leaf}");
                for kept in WhyKept::ALL {
                    let (why, none) = texts.kept(leaf, kept);
                    assert!(why.is_some_and(|p| !p.all(lang).is_empty()), "{leaf}: {kept:?}");
                    assert!(none.is_some_and(|p| !p.all(lang).is_empty()), "{leaf}: {kept:?}");
                }
            }
        }
        for claim in &f.draft_texts.claims {
            // A fact may have words in one language only; what signals are asked about is said in both.
            let (in_both, in_one) =
                (!claim.zh.is_empty() && !claim.en.is_empty(), !claim.zh.is_empty() || !claim.en.is_empty());
            let facts = !claim.states.is_empty() || !claim.denies.is_empty();
            assert!(if claim.when.is_empty() { facts && in_one } else { in_both }, "{claim:?}");
            for condition in &claim.when {
                assert!(is_known(&condition.signal), "{claim:?}");
            }
        }
        let leaf = f.specs.keys().next().unwrap().clone();
        for d in Longitudinal::ALL {
            assert!(
                f.draft_texts.longitudinal(&leaf, *d, "").is_some_and(|p| p.all(Lang::Zh).len() >= 2),
                "{d}"
            );
        }
        for d in Lateral::ALL {
            assert!(f.draft_texts.lateral(&leaf, *d).is_some_and(|p| p.all(Lang::En).len() >= 2), "{d}");
        }
    }
}
