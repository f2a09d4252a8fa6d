//! "Did you mean": the known name that is most like a misspelled one.

use crate::Bilingual;

/// Similarity of two names, 0 to 1: Damerau-Levenshtein distance, normalized by length.
pub fn similarity(a: &str, b: &str) -> f64 {
    strsim::normalized_damerau_levenshtein(a, b)
}

/// The candidate most like `text`, if one is similar enough to suggest.
pub fn did_you_mean<'a>(text: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|c| (similarity(text, c), c))
        .filter(|(score, _)| *score > 0.6)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

/// The hint that proposes `near`.
pub fn suggestion(near: &str) -> Bilingual {
    Bilingual::new(format!("是否想写 '{near}'？"), format!("did you mean '{near}'?"))
}

/// The hint for a misspelled name: the nearest known name, or all of them if none is near.
pub fn suggestion_or_known<'a>(
    text: &str,
    known: impl IntoIterator<Item = &'a str, IntoIter: Clone>,
) -> Bilingual {
    let known = known.into_iter();
    match did_you_mean(text, known.clone()) {
        Some(near) => suggestion(near),
        None => {
            let all = known.collect::<Vec<_>>().join(", ");
            Bilingual::new(format!("可用：{all}"), format!("known: {all}"))
        }
    }
}
