//! Texts of label drafts (`schema/draft_texts.yaml`, which says what each part is).

use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::DrivingDecision;
use whyroad_model::{Bilingual, ComponentCategory, Diagnostic, Lang, ScenarioId, yaml};

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
    kept: Kept,
    classes: BTreeMap<String, ClassTexts>,
    decisions: DecisionTexts,
}

/// What the ego does at the keyframe.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Openings {
    /// It stands.
    pub standing: Phrasings,
    /// It moves; `{speed}` is its speed.
    pub moving: Phrasings,
}

/// Texts of one class.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassTexts {
    /// The component where the recording tells none.
    seen: Option<Seen>,
    /// Where the navigation leads is a component, where the recording tells it.
    routed: Option<bool>,
    /// What the target of the episode does, where the class says it better than its motion at the keyframe.
    doing: Option<Pair>,
    /// What the target does, where a signal of it tells: the first that holds at the keyframe.
    #[serde(default)]
    doing_when: Vec<DoingWhen>,
    /// Why it calls for a decision.
    why: Option<Phrasings>,
    /// The same where only one of the two channels decides.
    why_only: Option<WhyOnly>,
    /// Decisions of both channels in words of this class.
    #[serde(default)]
    decisions: BTreeMap<String, Phrasings>,
}

/// What a target does while a signal of it holds.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoingWhen {
    /// Name of a flag of targets.
    pub signal: String,
    zh: String,
    en: String,
}

impl DoingWhen {
    /// In Chinese and English.
    pub fn texts(&self) -> (&str, &str) {
        (&self.zh, &self.en)
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhyOnly {
    longitudinal: Option<Phrasings>,
    lateral: Option<Phrasings>,
}

/// What a class is about, in words.
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

/// Several ways to say the same.
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

/// Why nothing new is decided: what holds at the keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyKept {
    /// The ego is at standstill.
    Standing,
    /// The speed of the ego falls already.
    Slowing,
    /// The distance to the target does not shrink.
    NotCloser,
    /// The target is farther away than the ego needs to stop comfortably.
    FarAway,
    /// The ego is slow.
    Slow,
    /// Nobody else is what the class is about: the speed of the ego suits the place.
    Suits,
    /// The ego turns, which changes nothing along its path.
    Turning,
    /// None of these is known.
    Driving,
}

impl WhyKept {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Standing,
        Self::Slowing,
        Self::NotCloser,
        Self::FarAway,
        Self::Slow,
        Self::Suits,
        Self::Turning,
        Self::Driving,
    ];
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    standing: KeptTexts,
    slowing: KeptTexts,
    not_closer: KeptTexts,
    far_away: KeptTexts,
    slow: KeptTexts,
    suits: KeptTexts,
    turning: KeptTexts,
    driving: KeptTexts,
}

/// Where nothing new is decided.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptTexts {
    /// How the parts of a trace are joined: `{state}`, `{action}`.
    pub traces: Phrasings,
    /// That the ego goes on with what it does.
    pub none: Phrasings,
}

impl DraftTexts {
    /// From the text of `schema/draft_texts.yaml`; `file` is named in diagnostics.
    pub fn parse(file: &str, text: &str) -> (DraftTexts, Vec<Diagnostic>) {
        match yaml::from_str(text) {
            Ok(texts) => (texts, Vec::new()),
            Err(e) => {
                let what = Bilingual::new("草稿文本", "the texts of drafts");
                (DraftTexts::default(), vec![e.diagnostic("lexicon.syntax", file, what)])
            }
        }
    }

    /// What the class is about: of the leaf, or of its L2.
    pub fn seen(&self, class: &ScenarioId) -> Option<&Seen> {
        self.of(class, |c| c.seen.as_ref())
    }

    /// The ego does what it does because of its route: the leaf, or its L2.
    pub fn is_routed(&self, class: &ScenarioId) -> bool {
        self.of(class, |c| c.routed.as_ref()).is_some_and(|r| *r)
    }

    /// What the target does, in Chinese and English: of the leaf, or of its L2.
    pub fn doing(&self, class: &ScenarioId) -> Option<(&str, &str)> {
        self.of(class, |c| c.doing.as_ref()).map(|p| (p.zh.as_str(), p.en.as_str()))
    }

    /// What the target does while a signal of it holds: of the leaf, or of its L2.
    pub fn doing_when(&self, class: &ScenarioId) -> &[DoingWhen] {
        self.of(class, |c| Some(&c.doing_when).filter(|all| !all.is_empty())).map_or(&[], Vec::as_slice)
    }

    /// Why it calls for this decision: of the leaf, or of its L2.
    pub fn why(&self, class: &ScenarioId, decision: &DrivingDecision) -> Option<&Phrasings> {
        self.of(class, |c| {
            let only = c.why_only.as_ref().and_then(|only| match (decision.longitudinal, decision.lateral) {
                (Some(_), None) => only.longitudinal.as_ref(),
                (None, Some(_)) => only.lateral.as_ref(),
                _ => None,
            });
            only.or(c.why.as_ref())
        })
    }

    fn of<T>(&self, class: &ScenarioId, part: impl Fn(&ClassTexts) -> Option<&T>) -> Option<&T> {
        let l2 = ScenarioId { l3: None, ..class.clone() };
        [class, &l2].into_iter().find_map(|id| self.classes.get(&id.to_string()).and_then(&part))
    }

    /// A longitudinal decision as the end of a trace: in words of the class, or else in those of all.
    pub fn longitudinal(&self, class: &ScenarioId, d: Longitudinal) -> Option<&Phrasings> {
        self.of(class, |c| c.decisions.get(d.id())).or_else(|| self.decisions.longitudinal.get(d.id()))
    }

    /// A lateral decision as the end of a trace, in words of the class, or else in those of all; `{side}` stands for
    /// its direction.
    pub fn lateral(&self, class: &ScenarioId, d: Lateral) -> Option<&Phrasings> {
        self.of(class, |c| c.decisions.get(d.id())).or_else(|| self.decisions.lateral.get(d.id()))
    }

    /// How a trace may begin.
    pub fn openings(&self) -> &Openings {
        &self.openings
    }

    /// How the parts of a trace are joined: `{state}`, `{why}`, `{action}`.
    pub fn traces(&self) -> &Phrasings {
        &self.traces
    }

    /// The same where nothing new is decided.
    pub fn kept(&self, why: WhyKept) -> &KeptTexts {
        match why {
            WhyKept::Standing => &self.kept.standing,
            WhyKept::Slowing => &self.kept.slowing,
            WhyKept::NotCloser => &self.kept.not_closer,
            WhyKept::FarAway => &self.kept.far_away,
            WhyKept::Slow => &self.kept.slow,
            WhyKept::Suits => &self.kept.suits,
            WhyKept::Turning => &self.kept.turning,
            WhyKept::Driving => &self.kept.driving,
        }
    }

    /// The word of a direction.
    pub fn side(&self, side: LateralDirection, lang: Lang) -> &str {
        self.sides.get(side.id()).map_or("", |p| match lang {
            Lang::Zh => &p.zh,
            Lang::En => &p.en,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::Framework;
    use whyroad_model::Lang;
    use whyroad_model::decision::{Lateral, Longitudinal};
    use whyroad_model::messages::DrivingDecision;

    #[test]
    fn every_leaf_and_decision_has_texts() {
        let f = Framework::bundled();
        for leaf in f.specs.keys() {
            let seen = f.draft_texts.seen(leaf).unwrap_or_else(|| panic!("{leaf}"));
            assert!(!seen.get(Lang::Zh).is_ascii() && seen.get(Lang::En).is_ascii(), "{leaf}");
            assert!(seen.category.is_some(), "{leaf}");
            let none = DrivingDecision { longitudinal: None, lateral: None, lateral_direction: None };
            let why = f.draft_texts.why(leaf, &none).unwrap_or_else(|| panic!("{leaf}"));
            for when in f.draft_texts.doing_when(leaf) {
                assert!(
                    f.signals_yaml.contains(&format!("- name: {}\n", when.signal)),
                    "{leaf}: {}",
                    when.signal
                );
            }
            for lang in [Lang::Zh, Lang::En] {
                assert!(why.all(lang).len() >= 2, "{leaf}");
            }
        }
        let leaf = f.specs.keys().next().unwrap().clone();
        for d in Longitudinal::ALL {
            assert!(f.draft_texts.longitudinal(&leaf, *d).is_some_and(|p| p.all(Lang::Zh).len() >= 2), "{d}");
        }
        for d in Lateral::ALL {
            assert!(f.draft_texts.lateral(&leaf, *d).is_some_and(|p| p.all(Lang::En).len() >= 2), "{d}");
        }
    }
}
