//! Values of users in messages: a value can be a whole file by mistake. The beginning is enough to know it, and its
//! location is stated anyway.

/// Quotations, and words without a space, of more characters than this are cut to [`KEPT`].
const LONGEST: usize = 240;
const KEPT: usize = 120;

/// The message with long quotations (`'...'`) and long words cut.
pub(super) fn shortened(text: String) -> String {
    if text.len() <= LONGEST {
        return text;
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text.as_str();
    // Of what was copied: an apostrophe inside a word opens nothing.
    let mut before = ' ';
    while let Some(at) = rest.find('\'') {
        let (plain, quoted) = rest.split_at(at);
        out += &with_short_words(plain);
        before = plain.chars().next_back().unwrap_or(before);
        let inner = &quoted[1..];
        let end = if before.is_ascii_alphanumeric() { None } else { closing(inner) };
        let Some(end) = end else {
            out.push('\'');
            (rest, before) = (inner, '\'');
            continue;
        };
        out.push('\'');
        out += &cut(&inner[..end]);
        out.push('\'');
        (rest, before) = (&inner[end + 1..], '\'');
    }
    out += &with_short_words(rest);
    out
}

/// Where a quotation ends: at a quotation mark that no letter or digit follows.
fn closing(inner: &str) -> Option<usize> {
    inner.match_indices('\'').map(|(at, _)| at).find(|at| {
        let next = inner[at + 1..].chars().next();
        !next.is_some_and(|c| c.is_ascii_alphanumeric())
    })
}

fn cut(text: &str) -> String {
    match (text.chars().nth(LONGEST), text.char_indices().nth(KEPT)) {
        (Some(_), Some((end, _))) => format!("{}…", &text[..end]),
        _ => text.to_owned(),
    }
}

/// Long runs of ASCII characters without a space; texts in Chinese have no spaces.
fn with_short_words(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while !rest.is_empty() {
        let is_word = |c: char| c.is_ascii_graphic();
        let first = rest.starts_with(is_word);
        let end = rest.find(|c: char| is_word(c) != first).unwrap_or(rest.len());
        let (part, after) = rest.split_at(end);
        out += &if first { cut(part) } else { part.to_owned() };
        rest = after;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_quotations_and_words_are_cut_and_sentences_are_not() {
        let long = "x".repeat(5000);
        let cut = format!("{}…", "x".repeat(120));
        assert_eq!(shortened(format!("'{long}' is not a time")), format!("'{cut}' is not a time"));
        assert_eq!(shortened(format!("there are: c1, {long}")), format!("there are: c1, {cut}"));
        assert_eq!(shortened(format!("'未知：{long}' 不是时刻")).chars().count(), 1 + 120 + 1 + 6);
        // A text with apostrophes, longer than a quotation may be.
        let sentence = "the ego's lane and the lead's lane are the map's; ".repeat(20);
        assert_eq!(shortened(sentence.clone()), sentence);
        let chinese = "自车的车道与前车的车道都在地图上。".repeat(30);
        assert_eq!(shortened(chinese.clone()), chinese);
        let short = format!("'{}' is not a number", "x".repeat(100));
        assert_eq!(shortened(short.clone()), short);
        // A quotation that nothing ends.
        assert_eq!(shortened(format!("found ' and {long}")), format!("found ' and {cut}"));
    }
}
