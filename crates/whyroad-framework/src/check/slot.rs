//! A field that may be absent, broken or there.

/// A field of a message as a check sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slot<T> {
    /// Not there, or null, where that is allowed.
    #[default]
    Absent,
    /// There and wrong, or not there and required: already reported, so no rule speaks of it again.
    Broken,
    /// There.
    Is(T),
}

impl<T> Slot<T> {
    /// The value, where there is a good one.
    pub fn get(self) -> Option<T> {
        match self {
            Slot::Is(t) => Some(t),
            Slot::Absent | Slot::Broken => None,
        }
    }

    /// Not there, or null.
    pub fn is_absent(&self) -> bool {
        matches!(self, Slot::Absent)
    }
}

impl<T> From<Option<T>> for Slot<T> {
    fn from(o: Option<T>) -> Self {
        o.map_or(Slot::Absent, Slot::Is)
    }
}
