//! Whole numbers that mostly go up by the same step, as stretches of equal steps: frames of an object, frame times.

/// Numbers `first`, `first + step`, ... of which there are `len`. Sums of 64 bits wrap around.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    first: i64,
    step: i64,
    len: usize,
}

impl Stretch {
    fn at(&self, k: usize) -> i64 {
        self.first.wrapping_add(self.step.wrapping_mul(k as i64))
    }
}

/// Whole numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Steps {
    stretches: Vec<Stretch>,
    len: usize,
    /// The value that would continue the last stretch.
    next: i64,
}

impl Steps {
    pub fn len(&self) -> usize {
        self.len
    }

    pub fn push(&mut self, value: i64) {
        self.len += 1;
        match self.stretches.last_mut() {
            Some(last) if last.len > 1 && self.next == value => {
                last.len += 1;
                self.next = value.wrapping_add(last.step);
            }
            Some(last) if last.len == 1 => {
                (last.step, last.len) = (value.wrapping_sub(last.first), 2);
                self.next = value.wrapping_add(last.step);
            }
            _ => self.stretches.push(Stretch { first: value, step: 0, len: 1 }),
        }
    }

    /// Appends `first`, `first + step`, ... of which there are `n`.
    pub fn push_run(&mut self, first: i64, step: i64, n: usize) {
        // Two at most do not go on with the stretch before, or begin one.
        let at = |k: usize| first.wrapping_add(step.wrapping_mul(k as i64));
        let single = n.min(2);
        (0..single).for_each(|k| self.push(at(k)));
        let rest = n - single;
        if let (Some(last), 1..) = (self.stretches.last_mut(), rest) {
            if last.len > 1 && last.step == step {
                last.len += rest;
            } else {
                self.stretches.push(Stretch { first: at(single), step, len: rest });
            }
            self.len += rest;
            self.next = at(n);
        }
    }

    /// All numbers.
    pub fn iter(&self) -> impl Iterator<Item = i64> {
        self.stretches.iter().flat_map(|s| (0..s.len).map(|k| s.at(k)))
    }

    /// Appends all of these.
    pub fn append(&mut self, other: Steps) {
        other.stretches.into_iter().for_each(|s| self.push_run(s.first, s.step, s.len));
    }

    /// True when `f` holds for every number. `f` must hold between any two numbers for which it holds. Sums must not
    /// wrap around in 64 bits.
    pub fn all(&self, f: impl Fn(i64) -> bool) -> bool {
        self.stretches.iter().all(|s| f(s.first) && f(s.at(s.len - 1)))
    }

    /// Each number changed by `f`.
    pub fn mapped(&self, f: impl Fn(i64) -> i64) -> Self {
        let mut out = Self::default();
        self.iter().for_each(|x| out.push(f(x)));
        out
    }

    /// The first place at which these are not the numbers of `expected`, one range after another; `None` where they are
    /// all of them. Additional numbers are ignored.
    pub fn differ(&self, expected: impl Iterator<Item = std::ops::Range<i64>>) -> Option<usize> {
        let mut stretches = self.stretches.iter();
        let (mut now, mut row): (&[Stretch], usize) = (&[], 0);
        let mut used = 0;
        for mut range in expected {
            while range.start < range.end {
                if now.first().is_none_or(|s| used == s.len) {
                    let Some(next) = stretches.next() else { return Some(row) };
                    (now, used) = (std::slice::from_ref(next), 0);
                }
                let stretch = now.first()?;
                if stretch.at(used) != range.start {
                    return Some(row);
                }
                let left = usize::try_from(range.end - range.start).unwrap_or(usize::MAX);
                let along = if stretch.step == 1 { left.min(stretch.len - used) } else { 1 };
                (used, row) = (used + along, row + along);
                range.start += along as i64;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn steps_are_the_numbers_that_were_pushed(
            parts in prop::collection::vec((-3i64..9, -1i64..3, 0usize..9, any::<bool>()), 0..20),
            changed in any::<prop::sample::Index>(),
        ) {
            let (mut steps, mut numbers) = (Steps::default(), Vec::new());
            for (first, step, n, run) in parts {
                let all: Vec<i64> = (0..n as i64).map(|k| first + k * step).collect();
                if run {
                    steps.push_run(first, step, n);
                } else {
                    all.iter().for_each(|x| steps.push(*x));
                }
                numbers.extend(all);
            }
            prop_assert_eq!(steps.len(), numbers.len());
            prop_assert_eq!(steps.iter().collect::<Vec<_>>(), numbers.clone());
            // As ranges of one, and as the longest ones.
            let ones = numbers.iter().map(|x| *x..x + 1);
            prop_assert_eq!(steps.differ(ones), None);
            let longest: Vec<_> = numbers.chunk_by(|a, b| *b == a + 1).map(|c| c[0]..c[0] + c.len() as i64).collect();
            prop_assert_eq!(steps.differ(longest.into_iter()), None);
            if !numbers.is_empty() {
                let at = changed.index(numbers.len());
                let other = numbers.iter().enumerate().map(|(i, x)| if i == at { 1000..1001 } else { *x..x + 1 });
                prop_assert_eq!(steps.differ(other), Some(at));
                let longer = numbers.iter().map(|x| *x..x + 1).chain(std::iter::once(5..7));
                prop_assert_eq!(steps.differ(longer), Some(numbers.len()));
            }
        }
    }
}
