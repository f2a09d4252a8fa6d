//! A field that may be absent, broken or present.

/// A field of a message as a check sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slot<T> {
    /// Absent or null, where that is allowed.
    #[default]
    Absent,
    /// Present and wrong, or absent and required: already reported, so no rule reports it again.
    Broken,
    /// There.
    Is(T),
}

impl<T> Slot<T> {
    /// The value, where it is valid.
    pub fn get(self) -> Option<T> {
        match self {
            Slot::Is(t) => Some(t),
            Slot::Absent | Slot::Broken => None,
        }
    }

    /// Absent or null.
    pub fn is_absent(&self) -> bool {
        matches!(self, Slot::Absent)
    }
}

impl<T> From<Option<T>> for Slot<T> {
    fn from(o: Option<T>) -> Self {
        o.map_or(Slot::Absent, Slot::Is)
    }
}
