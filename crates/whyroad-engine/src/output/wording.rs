//! A condition of a rule in words, from the catalogue's meaning of the signal that it measures.

use whyroad_model::Bilingual;
use whyroad_signals::Catalogue;

/// The first clause of a text: what a signal is, without how it is computed.
fn first_clause(text: &str) -> &str {
    let stops = [". ", ", ", ": ", "; ", " (", "。", "，", "：", "；", "（"];
    let end = stops.iter().filter_map(|s| text.find(s)).filter(|&i| i > 0).min().unwrap_or(text.len());
    text[..end].trim_end_matches(['.', '。'])
}

/// `target.gap < 5 m` as what is measured and the rest of the condition; `None` where it speaks of no signal of the
/// catalogue, or of more than one.
pub(super) fn in_words(condition: &str, catalogue: &Catalogue) -> Option<Bilingual> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let mut names = condition.split(|c: char| !is_name(c)).filter(|w| catalogue.get(w).is_some());
    let name = names.next()?;
    if names.any(|other| other != name) {
        return None;
    }
    let meaning = &catalogue.get(name)?.meaning;
    // A meaning may refer to that of another signal.
    let whole = |text: &str, zh: bool| -> String {
        let clause = first_clause(text);
        let inner = clause.split(|c: char| !is_name(c)).find_map(|w| Some((w, catalogue.get(w)?)));
        inner.map_or_else(
            || clause.to_owned(),
            |(w, d)| clause.replace(w, first_clause(if zh { &d.meaning.zh } else { &d.meaning.en })),
        )
    };
    let said = |words: String| condition.replace(name, &words);
    Some(Bilingual::new(said(whole(&meaning.zh, true)), said(whole(&meaning.en, false))))
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
        assert_eq!(in_words("ego.speed > lead.speed", Catalogue::bundled()), None);
    }
}
