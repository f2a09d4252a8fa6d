//! A list of words and phrases that is searched in a text in one pass, however long the list is.

use std::ops::Deref;

/// Words and phrases, in lower case, in the order of the file; as a slice they are that list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Phrases {
    all: Vec<String>,
    index: ByFirst,
}

impl Phrases {
    pub(crate) fn new(all: Vec<String>) -> Self {
        let index = ByFirst::of(all.iter().map(String::as_str));
        Self { all, index }
    }

    /// Bytes of the first of them in `lower`; Latin words as whole words.
    pub fn find(&self, lower: &str) -> Option<(usize, usize)> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '\'';
        let whole = |at: usize, w: &str| {
            !w.is_ascii() || !lower[..at].ends_with(letter) && !lower[at + w.len()..].starts_with(letter)
        };
        self.everywhere(lower).find(|(at, w)| whole(*at, w)).map(|(at, w)| (at, at + w.len()))
    }

    /// Each place in `lower` where one of them begins, also within a word; the shorter first where several do.
    pub fn everywhere<'p>(&'p self, lower: &'p str) -> impl Iterator<Item = (usize, &'p str)> {
        lower.char_indices().flat_map(move |(at, first)| {
            let here = self.index.at(first).iter().map(|i| self.all[*i as usize].as_str());
            here.filter(move |w| lower[at..].starts_with(w)).map(move |w| (at, w))
        })
    }
}

impl Deref for Phrases {
    type Target = [String];

    fn deref(&self) -> &[String] {
        &self.all
    }
}

/// Entries of a list by the first character of their word.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ByFirst {
    /// Each character with its first entry in `entries`, sorted.
    starts: Vec<(char, u32)>,
    /// Indices into the list.
    entries: Vec<u32>,
}

impl ByFirst {
    pub(crate) fn of<'w>(words: impl Iterator<Item = &'w str>) -> Self {
        let first =
            |(i, word): (usize, &str)| Some((word.chars().next()?, word.len(), u32::try_from(i).ok()?));
        let mut all: Vec<(char, usize, u32)> = words.enumerate().filter_map(first).collect();
        all.sort_unstable();
        let mut out = Self::default();
        for (at, (c, _, i)) in (0..).zip(all) {
            if out.starts.last().is_none_or(|(last, _)| *last != c) {
                out.starts.push((c, at));
            }
            out.entries.push(i);
        }
        out
    }

    /// Indices of the words that begin with `first`, the shorter first.
    pub(crate) fn at(&self, first: char) -> &[u32] {
        let Ok(i) = self.starts.binary_search_by_key(&first, |(c, _)| *c) else { return &[] };
        let end = self.starts.get(i + 1).map_or(self.entries.len(), |(_, at)| *at as usize);
        &self.entries[self.starts[i].1 as usize..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, word by word.
    fn plain(list: &[String], lower: &str) -> Option<(usize, usize)> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '\'';
        let mut found = Vec::new();
        for w in list {
            for (at, _) in lower.char_indices().filter(|(at, _)| lower[*at..].starts_with(w.as_str())) {
                let apart = !lower[..at].ends_with(letter) && !lower[at + w.len()..].starts_with(letter);
                if apart || !w.is_ascii() {
                    found.push((at, at + w.len()));
                }
            }
        }
        found.into_iter().min()
    }

    #[test]
    fn the_first_whole_word_is_found() {
        let list = Phrases::new(["car", "car park", "车", "右转车", "t字"].map(str::to_owned).to_vec());
        assert_eq!(list.find("the cart, a car park"), Some((12, 15)));
        assert_eq!(list.find("前方右转车道"), Some((6, 15)), "before 车, which begins later");
        assert_eq!(list.find("at字"), Some((1, 5)), "a phrase that is not Latin only");
        assert_eq!(list.find("the driver's cars"), None);
        assert_eq!(list.len(), 5);
        let all: Vec<_> = list.everywhere("右转车cars").collect();
        assert_eq!(all, [(0, "右转车"), (6, "车"), (9, "car")]);
    }

    proptest! {
        #[test]
        fn the_index_finds_what_the_definition_finds(
            list in prop::collection::vec("[ab' 车道]{1,3}", 0..12),
            text in "[abc' 车道左]{0,12}",
        ) {
            prop_assert_eq!(Phrases::new(list.clone()).find(&text), plain(&list, &text), "{:?} {}", list, text);
        }
    }
}
