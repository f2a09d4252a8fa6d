//! Finds words in a text: leftmost, longest, whole words where they are of Latin letters. A trie of characters,
//! because traces are short and most characters start no word of the lexicon: an automaton over bytes
//! (aho-corasick, tried first) spends its time waiting for its large tables.

/// No word ends here.
const NONE: u32 = u32::MAX;

#[derive(Clone, Debug, Default)]
pub struct Trie {
    /// By character: 0, or one more than its place in `entries`. Characters beyond the table start no word.
    starts: Vec<u16>,
    /// The same for two ASCII characters, `first * 128 + second`: every Latin letter starts some word, so this
    /// is where most Latin words of a text are recognized as none of ours.
    pairs: Vec<u16>,
    /// Nodes to which one character or a pair leads, so that the two tables above stay half as large.
    entries: Vec<u32>,
    nodes: Vec<Node>,
    /// Edges of all nodes, those of one node side by side and sorted.
    edges: Vec<(char, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    edges: u32,
    count: u32,
    word: u32,
}

/// Word number `word` is at `start..end` of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    pub word: usize,
    pub start: usize,
    pub end: usize,
}

/// Lower-case Latin letters; nothing else has case here.
fn fold(c: char) -> char {
    c.to_ascii_lowercase()
}

fn is_latin(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl Trie {
    /// A trie of `words`, which are in lower case, sorted and different. `None` when there are too many.
    pub fn new<'w>(words: impl Iterator<Item = &'w str>) -> Option<Self> {
        let words: Vec<Vec<char>> = words.map(|w| w.chars().collect()).collect();
        let mut trie = Self { starts: vec![0; 0x1_0000], pairs: vec![0; 128 * 128], ..Self::default() };
        // Sorted words with a common beginning stand side by side: each node is a range of them.
        let mut from = 0;
        while from < words.len() {
            let Some(&first) = words[from].first() else {
                from += 1;
                continue;
            };
            let to = from + words[from..].iter().take_while(|w| w.first() == Some(&first)).count();
            let node = trie.add(&words, from, to, 1)?;
            *trie.starts.get_mut(first as usize)? = trie.entry(node)?;
            if first.is_ascii() {
                let n = trie.nodes[node as usize];
                for edge in n.edges..n.edges + n.count {
                    let (second, child) = trie.edges[edge as usize];
                    if second.is_ascii() {
                        trie.pairs[first as usize * 128 + second as usize] = trie.entry(child)?;
                    }
                }
            }
            from = to;
        }
        Some(trie)
    }

    /// What the tables hold for `node`.
    fn entry(&mut self, node: u32) -> Option<u16> {
        self.entries.push(node);
        u16::try_from(self.entries.len()).ok()
    }

    fn add(&mut self, words: &[Vec<char>], from: usize, to: usize, depth: usize) -> Option<u32> {
        let word = if words[from].len() == depth { u32::try_from(from).ok()? } else { NONE };
        let mut children = Vec::new();
        let mut at = if word == NONE { from } else { from + 1 };
        while at < to {
            let c = words[at][depth];
            let end = at + words[at..to].iter().take_while(|w| w[depth] == c).count();
            children.push((c, self.add(words, at, end, depth + 1)?));
            at = end;
        }
        let node = Node {
            edges: u32::try_from(self.edges.len()).ok()?,
            count: u32::try_from(children.len()).ok()?,
            word,
        };
        self.edges.extend(children);
        self.nodes.push(node);
        u32::try_from(self.nodes.len() - 1).ok()
    }

    /// Gives the words of `text` to `take`, in order, never overlapping.
    pub fn find(&self, text: &str, mut take: impl FnMut(Found)) {
        if self.starts.is_empty() {
            return;
        }
        let mut at = 0;
        let mut after_latin = false;
        while let Some(c) = text[at..].chars().next() {
            let next = at + c.len_utf8();
            let found = match self.starts.get(fold(c) as usize) {
                None | Some(0) => None,
                // A Latin word starts where no Latin letter precedes it.
                Some(_) if after_latin && is_latin(c) => None,
                Some(&entry) => self.longest(self.node(entry), text, at, next),
            };
            match found {
                Some(f) => {
                    take(f);
                    after_latin = text[..f.end].chars().next_back().is_some_and(is_latin);
                    at = f.end;
                }
                // Nothing starts inside a Latin word.
                None if is_latin(c) => {
                    let rest = &text.as_bytes()[next..];
                    at = next + rest.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
                    after_latin = true;
                }
                None => {
                    after_latin = false;
                    at = next;
                }
            }
        }
    }

    /// The node of an entry other than 0.
    fn node(&self, entry: u16) -> usize {
        self.entries[usize::from(entry) - 1] as usize
    }

    /// The longest word from `start` on; `at` is behind its first character, which led to `node`.
    fn longest(&self, mut node: usize, text: &str, start: usize, mut at: usize) -> Option<Found> {
        let mut best = None;
        let mut last = text[start..].chars().next()?;
        loop {
            let n = self.nodes[node];
            let next = text[at..].chars().next();
            // A Latin word ends where no Latin letter follows.
            if n.word != NONE && !(is_latin(last) && next.is_some_and(is_latin)) {
                best = Some(Found { word: n.word as usize, start, end: at });
            }
            let Some(c) = next else { return best };
            if at == start + 1 && last.is_ascii() && c.is_ascii() {
                match self.pairs[fold(last) as usize * 128 + fold(c) as usize] {
                    0 => return best,
                    entry => node = self.node(entry),
                }
                at += 1;
                last = c;
                continue;
            }
            let edges = &self.edges[n.edges as usize..(n.edges + n.count) as usize];
            let Ok(edge) = edges.binary_search_by_key(&fold(c), |e| e.0) else { return best };
            node = edges[edge].1 as usize;
            at += c.len_utf8();
            last = c;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same by trying every word at every place.
    fn plainly(words: &[&str], text: &str) -> Vec<Found> {
        let chars: Vec<(usize, char)> = text.char_indices().collect();
        let latin_at = |i: Option<usize>| i.and_then(|i| chars.get(i)).is_some_and(|c| is_latin(c.1));
        let (mut out, mut i) = (Vec::new(), 0);
        while i < chars.len() {
            let start = chars[i].0;
            let fits = |w: &&str| {
                let n = w.chars().count();
                let same = text[start..].chars().take(n).map(fold).eq(w.chars());
                let cut_before = latin_at(i.checked_sub(1)) && latin_at(Some(i));
                let cut_after = w.chars().last().is_some_and(is_latin) && latin_at(Some(i + n));
                same && !cut_before && !cut_after
            };
            let best =
                words.iter().enumerate().filter(|(_, w)| fits(w)).max_by_key(|(_, w)| w.chars().count());
            match best {
                Some((word, w)) => {
                    out.push(Found { word, start, end: start + w.len() });
                    i += w.chars().count();
                }
                None => i += 1,
            }
        }
        out
    }

    const WORDS: &[&str] = &[
        ", so",
        "no",
        "no need",
        "stop",
        "stop at",
        "不",
        "不得不",
        "停",
        "停车",
        "停车线",
        "变道",
        "左变道",
    ];

    proptest! {
        #[test]
        fn same_as_trying_everything(pieces in prop::collection::vec(
            prop::sample::select(vec!["不", "得", "停", "车", "线", "左", "变道", "no", " ", "need", "Stop", "at", "s", ", so", "，", "_", "1"]), 0..12)) {
            let text = pieces.concat();
            let mut sorted = WORDS.to_vec();
            sorted.sort_unstable();
            let trie = Trie::new(sorted.iter().copied()).unwrap();
            let mut found = Vec::new();
            trie.find(&text, |f| found.push(f));
            prop_assert_eq!(found, plainly(&sorted, &text));
        }
    }
}
