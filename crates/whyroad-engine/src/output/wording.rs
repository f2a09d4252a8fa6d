//! A condition of a rule in words, from the catalogue's meaning of the signal that it measures.

use whyroad_model::Bilingual;
use whyroad_model::signal::{is_id_character, short_meaning};
use whyroad_signals::Catalogue;

/// Words of the rule language that a sentence cannot keep: a condition with one of them is no single comparison.
const SYNTAX: [&str; 14] = [
    "and",
    "or",
    "not",
    "known",
    "within",
    "for",
    "until",
    "since",
    "then",
    "exists",
    "count",
    "previously",
    "max",
    "min",
];

/// `target.gap < 5 m` as what is measured and the rest of the condition, `not ego.standstill` as what is not so; `None`
/// where it speaks of no signal of the catalogue, or is more than one comparison.
pub(super) fn in_words(condition: &str, catalogue: &Catalogue) -> Option<Bilingual> {
    if let Some(what) = denied(condition) {
        let words = in_words(what, catalogue)?;
        return Some(Bilingual::new(format!("不成立：{}", words.zh), format!("not so: {}", words.en)));
    }
    if condition.split(|c: char| !is_id_character(c)).any(|word| SYNTAX.contains(&word)) {
        return None;
    }
    let mut names: Vec<&str> =
        condition.split(|c: char| !is_id_character(c)).filter(|w| catalogue.get(w).is_some()).collect();
    names.sort_unstable();
    names.dedup();
    if names.is_empty() {
        return None;
    }
    // A name may be the beginning of another.
    names.sort_by_key(|name| std::cmp::Reverse(name.len()));
    let said = |zh: bool| {
        let meaning = |id: &str| catalogue.get(id).map(|d| if zh { &*d.meaning.zh } else { &*d.meaning.en });
        // Two steps, so that a name in the words of another is not replaced again.
        let mut text = bars(condition);
        for (i, name) in names.iter().enumerate() {
            text = text.replace(name, &format!("\u{1}{i}\u{2}"));
        }
        for (i, name) in names.iter().enumerate() {
            let words = short_meaning(meaning(name).unwrap_or(name), meaning);
            text = text.replace(&format!("\u{1}{i}\u{2}"), &words);
        }
        text
    };
    Some(Bilingual::new(said(true), said(false)))
}

/// `abs(x)` as `|x|`, where nothing inside has brackets.
fn bars(condition: &str) -> String {
    let Some((before, rest)) = condition.split_once("abs(") else { return condition.to_owned() };
    match rest.split_once(')') {
        Some((inner, after)) if !inner.contains('(') => format!("{before}|{inner}|{}", bars(after)),
        _ => condition.to_owned(),
    }
}

/// What `not X` denies, also where it is written `not ((X is known) and X)`: of what is unknown it says the same.
fn denied(condition: &str) -> Option<&str> {
    let inner = condition.strip_prefix("not ")?.trim();
    let known = inner.strip_prefix("((").and_then(|rest| rest.split_once(" is known) and "));
    match known {
        Some((what, again)) if again.strip_suffix(')') == Some(what) => Some(what),
        Some(_) => None,
        None => Some(inner),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_names_what_it_measures() {
        let words = in_words("ego.speed > 5 m/s", Catalogue::bundled()).unwrap();
        assert_eq!(words.en, "Speed of the ego over ground > 5 m/s");
        assert_eq!(words.zh, "自车对地速度 > 5 m/s");
        assert_eq!(in_words("true", Catalogue::bundled()), None);
        let words = in_words("ego.speed > lead.speed", Catalogue::bundled()).unwrap();
        assert_eq!(words.zh, "自车对地速度 > 前车速度");
        let words = in_words("abs(ego.accel) < 1m/s2", Catalogue::bundled()).unwrap();
        assert!(words.en.starts_with('|') && words.en.ends_with("| < 1m/s2"), "{}", words.en);
    }

    #[test]
    fn a_comparison_of_several_signals_names_each() {
        let catalogue = Catalogue::bundled();
        let text = "abs(target.time_to_conflict - target.ego_time_to_conflict) < 4s";
        let words = in_words(text, catalogue).unwrap();
        for said in [&words.zh, &words.en] {
            assert!(!said.contains("target.") && !said.contains("abs"), "{said}");
            assert!(said.starts_with('|') && said.ends_with("| < 4s") && said.contains(" - "), "{said}");
        }
    }

    #[test]
    fn what_is_denied_is_said_and_other_syntax_has_no_words() {
        let catalogue = Catalogue::bundled();
        let plain = in_words("not map.in_roundabout", catalogue).unwrap();
        assert!(plain.zh.starts_with("不成立：") && plain.en.starts_with("not so: "), "{plain}");
        let guarded = in_words("not ((map.in_roundabout is known) and map.in_roundabout)", catalogue);
        assert_eq!(guarded, Some(plain));
        for syntax in [
            "not ((previously(ego.standstill, 5s) is known) and previously(ego.standstill, 5s))",
            "(map.speed_limit - min(map.speed_limit, 1s)) >= 5km/h",
            "ego.speed > 2m/s for 3s",
            "not ((ego.in_junction is known) and ego.standstill)",
        ] {
            assert_eq!(in_words(syntax, catalogue), None, "{syntax}");
        }
    }
}
