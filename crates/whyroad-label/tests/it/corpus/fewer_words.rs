//! The word lists without a part of their words, to test how the checks treat texts with words that are in no list.

use serde_json::Value;
use whyroad_framework::{Framework, LabelWords, Lexicon};
use whyroad_model::yaml;

const LABEL_WORDS: &str = include_str!("../../../../../schema/label_words.yaml");
const DECISIONS: &str = include_str!("../../../../../schema/decision_lexicon.yaml");

/// One word in this many is removed.
pub(super) const PARTS: u64 = 5;

/// The bundled framework without part `part` of the words for things, states and decisions.
pub(super) fn without(part: u64) -> Framework {
    let mut words: Value = yaml::from_str(LABEL_WORDS).unwrap();
    for lists in words["objects"].as_array_mut().unwrap() {
        thin(lists, part);
    }
    for list in ["states", "doings"] {
        for lists in words[list].as_object_mut().unwrap().values_mut() {
            thin(lists, part);
        }
    }
    let mut decisions: Value = yaml::from_str(DECISIONS).unwrap();
    thin(&mut decisions["words"]["agent"], part);
    for list in ["phrases", "stems", "effects"] {
        for lists in decisions[list].as_array_mut().unwrap() {
            thin(lists, part);
        }
    }
    let (words, problems) = LabelWords::parse("label_words.yaml", &words.to_string());
    assert!(problems.is_empty(), "{problems:?}");
    // Words for road users that are in no list of agents are agents, too.
    let (lexicon, problems) =
        Lexicon::parse("decision_lexicon.yaml", &decisions.to_string(), &words.road_users);
    assert!(problems.is_empty(), "{problems:?}");
    Framework::bundled().clone().with_reading(|tables| {
        tables.label_words = words;
        tables.lexicon = lexicon;
    })
}

/// Removes part `part` of the words of both languages, and keeps at least one.
fn thin(lists: &mut Value, part: u64) {
    for language in ["zh", "en"] {
        let Some(list) = lists.get_mut(language).and_then(Value::as_array_mut) else { continue };
        let all: Vec<String> = list.iter().filter_map(Value::as_str).flat_map(alternatives).collect();
        let kept: Vec<&String> = all.iter().filter(|w| hash(w) % PARTS != part).collect();
        *list = if kept.is_empty() {
            all[..1].iter().map(|w| w.as_str().into()).collect()
        } else {
            kept.into_iter().map(|w| w.as_str().into()).collect()
        };
    }
}

/// The words of a pattern that is only a choice; another pattern is one word.
fn alternatives(pattern: &str) -> Vec<String> {
    let choice = pattern.strip_prefix('(').and_then(|p| p.strip_suffix(')'));
    match choice.filter(|c| !c.contains(['(', ')'])) {
        Some(all) => all.split('|').map(str::to_owned).collect(),
        None => vec![pattern.to_owned()],
    }
}

/// FNV-1a: the same on every machine.
fn hash(word: &str) -> u64 {
    word.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}
