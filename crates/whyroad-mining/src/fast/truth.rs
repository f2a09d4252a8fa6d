//! Three-valued truth in two bits per row: *yes* (known to be true) and *known*. Kleene logic on 64 rows at a time.

use super::bits::Bits;
use std::ops::Range;
use std::rc::Rc;

/// The truth of a condition on consecutive rows. A `yes` row is also `known`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Truth {
    /// Known to be true.
    pub yes: Rc<Bits>,
    /// Known to be true or false.
    pub known: Rc<Bits>,
}

impl Truth {
    /// From its planes.
    pub fn new(yes: Bits, known: Bits) -> Self {
        Self { yes: Rc::new(yes), known: Rc::new(known) }
    }

    /// From the certain and the possible rows (true or unknown).
    pub fn bounded(sure: Bits, possible: &Bits) -> Self {
        let known = sure.map2(possible, |s, p| s | !p);
        Self::new(sure, known)
    }

    /// Known in every row, true where `yes`.
    pub fn certain(yes: Bits) -> Self {
        let known = Bits::ones(yes.len());
        Self::new(yes, known)
    }

    /// Nothing known.
    pub fn unknown(n: usize) -> Self {
        let none = Rc::new(Bits::zeros(n));
        Self { yes: none.clone(), known: none }
    }

    /// The same in every row.
    pub fn constant(value: bool, n: usize) -> Self {
        Self::certain(if value { Bits::ones(n) } else { Bits::zeros(n) })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.yes.len()
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.yes.is_empty()
    }

    /// True or unknown.
    pub fn possible(&self) -> Bits {
        self.yes.map2(&self.known, |y, k| y | !k)
    }

    /// Kleene negation.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self { yes: Rc::new(self.yes.map2(&self.known, |y, k| k & !y)), known: self.known.clone() }
    }

    /// Kleene conjunction: false wins, then unknown.
    #[must_use]
    pub fn and(&self, other: &Truth) -> Self {
        let yes = self.yes.map2(&other.yes, |a, b| a & b);
        let mut known = yes.clone();
        for t in [self, other] {
            known.or_with(&t.known.map2(&t.yes, |k, y| k & !y));
        }
        Self::new(yes, known)
    }

    /// Kleene disjunction: true wins, then unknown.
    #[must_use]
    pub fn or(&self, other: &Truth) -> Self {
        let yes = self.yes.map2(&other.yes, |a, b| a | b);
        let mut known = self.known.map2(&other.known, |a, b| a & b);
        known.or_with(&yes);
        Self::new(yes, known)
    }

    /// True when it is known to be false in every row.
    pub fn is_nowhere(&self) -> bool {
        self.yes.none() && self.known.all()
    }

    /// True when it is known to be true in every row.
    pub fn is_everywhere(&self) -> bool {
        self.yes.all()
    }

    /// These rows alone.
    #[must_use]
    pub fn slice(&self, rows: Range<usize>) -> Self {
        if rows == (0..self.len()) {
            return self.clone();
        }
        Self::new(self.yes.slice(rows.clone()), self.known.slice(rows))
    }

    /// The value in one row.
    pub fn at(&self, row: usize) -> whyroad_model::Tri {
        self.known.get(row).then(|| self.yes.get(row)).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use whyroad_model::Tri;

    fn of(v: &[Tri]) -> Truth {
        let yes = Bits::collect(v.len(), |i| v[i] == Tri::True);
        Truth::new(yes, Bits::collect(v.len(), |i| v[i] != Tri::Unknown))
    }

    fn back(t: &Truth) -> Vec<Tri> {
        (0..t.len()).map(|i| t.at(i)).collect()
    }

    fn tri() -> impl Strategy<Value = Tri> {
        prop_oneof![Just(Tri::True), Just(Tri::False), Just(Tri::Unknown)]
    }

    proptest! {
        #[test]
        fn planes_follow_kleene(pairs in prop::collection::vec((tri(), tri()), 1..200)) {
            let (a, b): (Vec<Tri>, Vec<Tri>) = pairs.iter().copied().unzip();
            let each = |f: fn(Tri, Tri) -> Tri| pairs.iter().map(|(x, y)| f(*x, *y)).collect::<Vec<_>>();
            prop_assert_eq!(back(&of(&a).and(&of(&b))), each(Tri::and));
            prop_assert_eq!(back(&of(&a).or(&of(&b))), each(Tri::or));
            prop_assert_eq!(back(&of(&a).negated()), each(|x, _| !x));
            prop_assert_eq!(back(&Truth::bounded((*of(&a).yes).clone(), &of(&a).possible())), a);
        }
    }
}
