//! Notes that a text is a draft (`draft_notes` of `schema/label_words.yaml`).

use super::LabelWords;

impl LabelWords {
    /// Bytes of a note that the text is a draft: in brackets at its beginning or its end, or before a colon.
    pub fn draft_note(&self, text: &str) -> Option<(usize, usize)> {
        /// Bytes up to a colon.
        const LONGEST_HEAD: usize = 60;
        let is_note = |part: &str| {
            let part = part.to_ascii_lowercase();
            self.draft_notes.iter().any(|w| {
                let bounded = |at: usize| {
                    let letter = |c: char| c.is_ascii_alphanumeric();
                    !part[..at].ends_with(letter) && !part[at + w.len()..].starts_with(letter)
                };
                part.match_indices(w.as_str()).any(|(at, _)| !w.is_ascii() || bounded(at))
            })
        };
        let start = text.len() - text.trim_start().len();
        let end = text.trim_end().trim_end_matches(['.', '。', '!', '！']).len();
        let (opens, closes) = (['(', '[', '（', '【', '{', '〔'], [')', ']', '）', '】', '}', '〕']);
        let head = text[start..].starts_with(opens).then(|| text[start..].find(closes)).flatten();
        let tail = text[..end].ends_with(closes).then(|| text[..end].rfind(opens)).flatten();
        let colon = text[start..].find([':', '：']).filter(|at| *at <= LONGEST_HEAD);
        let parts = [
            head.map(|to| (start, start + to)),
            tail.map(|from| (from, end)),
            colon.map(|to| (start, start + to)),
        ];
        parts.into_iter().flatten().find(|(from, to)| is_note(&text[*from..*to]))
    }
}
