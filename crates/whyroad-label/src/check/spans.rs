//! Ranges of bytes of a text, sought by position.

/// Ranges of bytes.
pub(super) struct Spans(Vec<(usize, usize)>);

impl Spans {
    /// In any order; they may overlap.
    pub fn of(all: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut all: Vec<(usize, usize)> = all.collect();
        all.sort_unstable();
        let mut joined: Vec<(usize, usize)> = Vec::with_capacity(all.len());
        for (from, to) in all {
            match joined.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => joined.push((from, to)),
            }
        }
        Self(joined)
    }

    /// One of them holds the byte `at`.
    pub fn holds(&self, at: usize) -> bool {
        let before = self.0.partition_point(|(from, _)| *from <= at);
        before > 0 && at < self.0[before - 1].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_is_held_by_one_of_the_ranges() {
        let all = [(7, 9), (1, 3), (2, 4), (4, 5), (8, 8), (12, 12)];
        let spans = Spans::of(all.into_iter());
        for at in 0..14 {
            assert_eq!(spans.holds(at), all.iter().any(|(a, b)| (*a..*b).contains(&at)), "{at}");
        }
    }
}
