//! Every wording of a draft that states something measurable has a condition or a claim, or `checked.yaml` says why it
//! is true without one.

use super::{Claim, DraftTexts, Phrasings, WhyWhen};
use crate::Framework;
use serde::Deserialize;
use whyroad_model::{Lang, yaml};

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Checked {
    words: Parts,
    true_otherwise: Vec<Otherwise>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Parts {
    zh: Vec<String>,
    en: Vec<String>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Otherwise {
    because: String,
    zh: Vec<String>,
    en: Vec<String>,
}

impl Parts {
    fn of(&self, lang: Lang) -> &[String] {
        if lang == Lang::Zh { &self.zh } else { &self.en }
    }
}

/// The parts of `all` that `text` contains.
fn found<'a>(all: &'a [String], text: &str) -> Vec<&'a str> {
    let text = text.to_lowercase();
    all.iter().map(String::as_str).filter(|part| text.contains(part)).collect()
}

/// Wordings without conditions, with the class that uses them.
fn unconditional(texts: &DraftTexts) -> Vec<(String, &Phrasings)> {
    let free =
        |all: &'_ [WhyWhen]| -> Vec<usize> { (0..all.len()).filter(|&i| all[i].when.is_empty()).collect() };
    let common = |p| ("proactive".to_owned(), p);
    let mut all: Vec<(String, &Phrasings)> = Vec::new();
    all.extend(texts.kept.values().flat_map(|k| k.why.iter().chain(&k.none)).map(common));
    all.extend(texts.goes_on.values().map(common));
    for list in [&texts.lead, &texts.light] {
        all.extend(free(list).into_iter().map(|i| common(&list[i].why)));
    }
    all.extend(texts.decisions.longitudinal.values().chain(texts.decisions.lateral.values()).map(common));
    for (id, c) in &texts.classes {
        let only = c.why_only.iter().flat_map(|o| o.longitudinal.iter().chain(&o.lateral));
        let kept = c.kept.values().flat_map(|k| k.why.iter().chain(&k.none));
        let of_class =
            c.why.iter().chain(only).chain(kept).chain(c.why_for.values()).chain(c.decisions.values());
        all.extend(of_class.map(|p| (id.clone(), p)));
        all.extend(free(&c.why_when).into_iter().map(|i| (id.clone(), &c.why_when[i].why)));
    }
    all
}

/// Whether the wording needs a claim and makes none.
fn is_unchecked(texts: &DraftTexts, checked: &Checked, class: &str, text: &str, lang: Lang) -> bool {
    let class = class.parse().unwrap_or_else(|_| "proactive.turn".parse().unwrap());
    let says = |claim: &Claim| !claim.when.is_empty() || !claim.states.is_empty() || !claim.denies.is_empty();
    let claims = texts.claims(&class, text, lang).any(says);
    !found(checked.words.of(lang), text).is_empty() && !claims
}

fn checked() -> Checked {
    yaml::from_str(include_str!("checked.yaml")).unwrap_or_else(|e| panic!("{e:?}"))
}

#[test]
fn a_wording_that_says_something_measurable_is_checked() {
    let (texts, checked) = (&Framework::bundled().draft_texts, checked());
    let all = unconditional(texts);
    assert!(all.len() > 300, "{}", all.len());
    for lang in [Lang::Zh, Lang::En] {
        let excused: Vec<&String> = checked
            .true_otherwise
            .iter()
            .flat_map(|o| if lang == Lang::Zh { &o.zh } else { &o.en })
            .collect();
        let mut used = vec![false; excused.len()];
        let mut wrong = Vec::new();
        for (class, phrasings) in &all {
            for text in phrasings.all(lang) {
                if !is_unchecked(texts, &checked, class, text, lang) {
                    continue;
                }
                let because = excused.iter().position(|part| text.to_lowercase().contains(part.as_str()));
                match because {
                    Some(at) => used[at] = true,
                    None => wrong.push(format!("{class}: {text}")),
                }
            }
        }
        assert!(wrong.is_empty(), "no claim and no condition: {wrong:#?}");
        let idle: Vec<_> =
            excused.iter().zip(&used).filter(|(_, used)| !**used).map(|(part, _)| part).collect();
        assert!(idle.is_empty(), "no wording needs these: {idle:#?}");
    }
    assert!(checked.true_otherwise.iter().all(|o| !o.because.is_empty()));
}

#[test]
fn a_wording_without_a_claim_is_found() {
    let (texts, checked) = (&Framework::bundled().draft_texts, checked());
    let wrong = |text, lang| is_unchecked(texts, &checked, "reactive_rule.speed_limit", text, lang);
    assert!(wrong("自车马上就会飞起来", Lang::Zh));
    assert!(wrong("the ego flies at once", Lang::En));
    assert!(!wrong("自车现在的车速低于这个限速，不会超速", Lang::Zh));
    assert!(!wrong("the road ahead bends", Lang::En));
}
