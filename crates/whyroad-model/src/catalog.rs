//! The signals of the catalog as types, generated from `schema/signals.yaml` by the build script of this crate.
//!
//! [`SignalId`] names a signal. The constants of [`id`] also carry its scope and type, so that writing a value of the
//! wrong type, or one per frame where one per target belongs, does not compile. The enums of [`value`] are the values
//! of category signals. Meanings, units for display and aliases are not here: `whyroad_signals::Catalog` has them,
//! because a framework folder may change them.

use crate::Need;
use crate::units::{Dimension, Unit};
use std::marker::PhantomData;

include!(concat!(env!("OUT_DIR"), "/signals.rs"));

/// What a signal has values for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SignalScope {
    /// One value per frame.
    Frame,
    /// One value per target and frame.
    Target,
    /// One value per object and frame, the ego among the objects; derived only when a rule uses it.
    Object,
    /// One value per ordered pair of near objects and frame; derived only when a rule uses it.
    Pair,
}

impl SignalScope {
    /// True for signals that are derived only when a rule uses them.
    pub fn is_on_demand(self) -> bool {
        matches!(self, Self::Object | Self::Pair)
    }

    /// Its name in the catalog.
    pub fn word(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Target => "target",
            Self::Object => "object",
            Self::Pair => "pair",
        }
    }
}

/// Type of a signal's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalType {
    /// A number; the symbol of the unit in which the catalog displays it. Stored in the base unit.
    Number(&'static str),
    /// True, false or unknown.
    Flag,
    /// One of these names.
    Category(&'static [&'static str]),
}

/// What is known about a signal at compile time.
#[derive(Debug)]
struct SignalFacts {
    name: &'static str,
    scope: SignalScope,
    kind: SignalType,
    needs: &'static [Need],
}

impl SignalId {
    fn facts(self) -> &'static SignalFacts {
        &FACTS[self as usize]
    }

    /// Full name: `ego.speed`.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// The signal with this full name; aliases are known to the catalog of whyroad-signals only.
    pub fn from_name(name: &str) -> Option<Self> {
        let at = FACTS.binary_search_by(|f| f.name.cmp(name)).ok()?;
        Some(Self::ALL[at])
    }

    /// What it has values for.
    pub fn scope(self) -> SignalScope {
        self.facts().scope
    }

    /// Type of its values.
    pub fn kind(self) -> SignalType {
        self.facts().kind
    }

    /// What a log must have to support it.
    pub fn needs(self) -> &'static [Need] {
        self.facts().needs
    }

    /// The unit in which the bundled catalog displays it; `None` for flags and categories.
    pub fn unit(self) -> Option<&'static Unit> {
        match self.kind() {
            SignalType::Number(symbol) => Unit::parse(symbol),
            SignalType::Flag | SignalType::Category(_) => None,
        }
    }

    /// The dimension of a number; `None` for flags and categories.
    pub fn dimension(self) -> Option<Dimension> {
        self.unit().map(|u| u.dimension)
    }
}

impl std::fmt::Display for SignalId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A value of a category signal: one of a closed set of names.
pub trait CategoryValue: Copy + Eq + 'static {
    /// Every value, in the catalog's order.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const NAMES: &'static [&'static str];

    /// Index in the catalog's values: the code in a column.
    fn code(self) -> u16;

    /// The value's name.
    fn name(self) -> &'static str {
        Self::NAMES[usize::from(self.code())]
    }

    /// The value with this name.
    fn from_name(name: &str) -> Option<Self> {
        let at = Self::NAMES.iter().position(|n| *n == name)?;
        Self::ALL.get(at).copied()
    }

    /// The value with this code; `None` for the code of unknown.
    fn from_code(code: u16) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// Marks a signal with one value per frame.
#[derive(Clone, Copy, Debug)]
pub struct PerFrame;
/// Marks a signal with one value per target and frame.
#[derive(Clone, Copy, Debug)]
pub struct PerTarget;
/// Marks a signal with one value per object and frame.
#[derive(Clone, Copy, Debug)]
pub struct PerObject;
/// Marks a signal with one value per pair of objects and frame.
#[derive(Clone, Copy, Debug)]
pub struct PerPair;
/// Marks a signal of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Number;
/// Marks a signal of truth values.
#[derive(Clone, Copy, Debug)]
pub struct Flag;
/// Marks a signal with values of the enum `C`.
#[derive(Clone, Copy, Debug)]
pub struct Category<C>(PhantomData<C>);

/// A signal with its scope `S` ([`PerFrame`], [`PerTarget`], [`PerObject`], [`PerPair`]) and type `K` ([`Number`],
/// [`Flag`], [`Category`]).
#[derive(Debug)]
pub struct Signal<S, K> {
    id: SignalId,
    typed: PhantomData<(S, K)>,
}

impl<S, K> Clone for Signal<S, K> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, K> Copy for Signal<S, K> {}

impl<S, K> Signal<S, K> {
    const fn new(id: SignalId) -> Self {
        Self { id, typed: PhantomData }
    }

    /// Which signal it is.
    pub const fn id(self) -> SignalId {
        self.id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_leads_back_from_its_name() {
        for (i, id) in SignalId::ALL.iter().enumerate() {
            assert_eq!((*id as usize, SignalId::from_name(id.name())), (i, Some(*id)));
            assert!(!matches!(id.kind(), SignalType::Number(_)) || id.unit().is_some(), "{id}: unit");
            // Rules and the lake derive the scope from the prefix.
            for (prefix, scope) in [
                ("target.", SignalScope::Target),
                ("object.", SignalScope::Object),
                ("pair.", SignalScope::Pair),
            ] {
                assert_eq!(id.name().starts_with(prefix), id.scope() == scope, "{id}");
            }
        }
        assert!(SignalId::ALL.is_sorted_by_key(|id| id.name()));
        assert_eq!(SignalId::from_name("ego.sped"), None);
    }

    #[test]
    fn values_are_those_of_the_file() {
        // schema/signals.yaml, light.state: [none, red, yellow, ...]; "off" is the eleventh.
        assert_eq!((value::LightState::Red.code(), value::LightState::Off.code()), (1, 10));
        assert_eq!(value::LightState::from_name("green_yield"), Some(value::LightState::GreenYield));
        assert_eq!(value::LightState::from_code(u16::MAX), None);
        assert_eq!(id::LIGHT_STATE.id().kind(), SignalType::Category(value::LightState::NAMES));
        assert_eq!(id::TARGET_GAP.id().scope(), SignalScope::Target);
        assert_eq!(id::MAP_SIGHT_ANGLE.id().dimension(), Some(Dimension::Angle));
    }
}
