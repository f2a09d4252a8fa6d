//! One signal over time. Unknown is a value of its own everywhere: NaN in numbers (read through
//! [`Column::number`], never seen outside), a third truth value in flags, a reserved code in categories.

use std::sync::Arc;

/// Three-valued truth (strong Kleene logic).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Tri {
    /// Known to be false.
    False = 0,
    /// Known to be true.
    True = 1,
    /// Not known.
    #[default]
    Unknown = 2,
}

impl Tri {
    /// Known as an option.
    pub fn known(self) -> Option<bool> {
        match self {
            Tri::False => Some(false),
            Tri::True => Some(true),
            Tri::Unknown => None,
        }
    }
    /// True only when known to be true.
    pub fn is_true(self) -> bool {
        self == Tri::True
    }
    /// False wins, then unknown.
    #[must_use]
    pub fn and(self, other: Tri) -> Tri {
        match (self, other) {
            (Tri::False, _) | (_, Tri::False) => Tri::False,
            (Tri::True, Tri::True) => Tri::True,
            _ => Tri::Unknown,
        }
    }
    /// True wins, then unknown.
    #[must_use]
    pub fn or(self, other: Tri) -> Tri {
        match (self, other) {
            (Tri::True, _) | (_, Tri::True) => Tri::True,
            (Tri::False, Tri::False) => Tri::False,
            _ => Tri::Unknown,
        }
    }
}

impl std::ops::Not for Tri {
    type Output = Tri;
    fn not(self) -> Tri {
        match self {
            Tri::False => Tri::True,
            Tri::True => Tri::False,
            Tri::Unknown => Tri::Unknown,
        }
    }
}

impl From<bool> for Tri {
    #[inline]
    fn from(b: bool) -> Tri {
        if b { Tri::True } else { Tri::False }
    }
}

impl From<Option<bool>> for Tri {
    #[inline]
    fn from(b: Option<bool>) -> Tri {
        b.map_or(Tri::Unknown, Tri::from)
    }
}

/// Code in a category column that means "not known".
pub const UNKNOWN_CODE: u16 = u16::MAX;

/// The values of one signal on consecutive rows.
#[derive(Clone, Debug)]
pub enum Column {
    /// Numbers in the signal's base unit; NaN is unknown. Infinity is allowed where the definition says so (a gap
    /// that never closes).
    Number(Vec<f64>),
    /// Truth values.
    Flag(Vec<Tri>),
    /// One of a closed set of names.
    Category {
        /// Index into `names`, or [`UNKNOWN_CODE`].
        codes: Vec<u16>,
        /// The closed set, in the catalog's order.
        names: Arc<[String]>,
    },
}

impl Column {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Column::Number(v) => v.len(),
            Column::Flag(v) => v.len(),
            Column::Category { codes, .. } => codes.len(),
        }
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sets the value at `row` to unknown.
    pub fn forget(&mut self, row: usize) {
        match self {
            Column::Number(v) => v.get_mut(row).into_iter().for_each(|v| *v = f64::NAN),
            Column::Flag(v) => v.get_mut(row).into_iter().for_each(|v| *v = Tri::Unknown),
            Column::Category { codes, .. } => {
                codes.get_mut(row).into_iter().for_each(|code| *code = UNKNOWN_CODE);
            }
        }
    }

    /// The number at `row`; `None` when unknown or not a number column.
    pub fn number(&self, row: usize) -> Option<f64> {
        match self {
            Column::Number(v) => v.get(row).copied().filter(|x| !x.is_nan()),
            _ => None,
        }
    }

    /// The truth value at `row`; unknown when not a flag column.
    pub fn flag(&self, row: usize) -> Tri {
        match self {
            Column::Flag(v) => v.get(row).copied().unwrap_or_default(),
            _ => Tri::Unknown,
        }
    }

    /// The category's name at `row`; `None` when unknown or not a category column.
    pub fn category(&self, row: usize) -> Option<&str> {
        match self {
            Column::Category { codes, names } => {
                codes.get(row).and_then(|&c| names.get(usize::from(c))).map(String::as_str)
            }
            _ => None,
        }
    }

    /// True when the value at `row` is known.
    pub fn is_known(&self, row: usize) -> bool {
        match self {
            Column::Number(v) => v.get(row).is_some_and(|x| !x.is_nan()),
            Column::Flag(v) => v.get(row).is_some_and(|t| *t != Tri::Unknown),
            Column::Category { codes, .. } => codes.get(row).is_some_and(|c| *c != UNKNOWN_CODE),
        }
    }

    /// Number of rows whose value is known.
    pub fn known_count(&self) -> usize {
        (0..self.len()).filter(|&i| self.is_known(i)).count()
    }
}
