//! The catalog of signals, read from `schema/signals.yaml`: the meaning of each signal, the unit in which it is
//! displayed, and the data that a log must have for it. The computation of a value is code; name, scope and type of a
//! signal are compiled in ([`SignalId`]), so a framework folder's catalog is checked against them.

mod page;
mod read;

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};
use whyroad_model::suggest::similarity;
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Diagnostic, Displayed, Need, SignalId};

pub use read::CODES;
pub use whyroad_model::catalog::SignalScope;

/// Type of a signal's values.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalKind {
    /// A number in the base unit of the dimension.
    Number(Dimension),
    /// True, false or unknown.
    Flag,
    /// One of these names.
    Category(Arc<[String]>),
}

/// One entry of the catalog.
#[derive(Clone, Debug)]
pub struct SignalDef {
    /// The signal.
    pub id: SignalId,
    /// Full name: `ego.speed`, `target.gap`.
    pub name: String,
    /// Its scope.
    pub scope: SignalScope,
    /// Type of its values.
    pub kind: SignalKind,
    /// Unit in which a number is displayed; `None` for flags and categories. Values are stored in the base unit.
    pub unit: Option<&'static Unit>,
    /// Its title for people: a noun for a number or category, a clause for a flag.
    pub title: Bilingual,
    /// Its meaning, with its formula.
    pub meaning: Bilingual,
    /// Data that the log must have.
    pub needs: Vec<Need>,
    /// Source of the definition.
    pub source: String,
    /// Typical magnitude in the base unit, for normalizing margins; 1 for flags and categories.
    pub scale: f64,
    /// The least possible value of a number, in the base unit, where there is one.
    pub least: Option<f64>,
    /// Other names for it.
    pub aliases: Vec<String>,
}

impl SignalDef {
    /// A stored value of this signal in its display unit; `None` for flags and categories.
    pub fn displayed(&self, base: f64) -> Option<Displayed> {
        self.unit.map(|unit| Displayed::of_base(base, unit))
    }

    /// Symbol of the unit in which a number is displayed; empty for pure numbers, flags and categories.
    pub fn unit_symbol(&self) -> &'static str {
        self.unit.map_or("", |u| u.symbol)
    }
}

/// Targets to which a name restricts a rule: `target_vehicle.gap` is `target.gap` of vehicles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetRestriction {
    /// Any target.
    Any,
    /// Vehicles only (`target_vehicle.`).
    Vehicle,
    /// Vulnerable road users only (`target_vru.`).
    Vru,
}

/// All signals by name.
#[derive(Clone, Debug, Default)]
pub struct Catalog {
    /// Version of the catalog.
    pub version: String,
    defs: Vec<SignalDef>,
    by_name: BTreeMap<String, usize>,
    values: BTreeMap<String, Bilingual>,
}

static BUNDLED: LazyLock<Catalog> =
    LazyLock::new(|| Catalog::parse(include_str!("../../../schema/signals.yaml")).0);

impl Catalog {
    /// The catalog of this build, which [`crate::derive`] follows. A test asserts that it has no errors.
    pub fn bundled() -> &'static Catalog {
        &BUNDLED
    }

    /// Reads the text of `schema/signals.yaml`, from the repository or from a framework folder. Entries with errors are
    /// skipped and reported; the others are usable. A folder may change meanings, display units, scales, aliases and
    /// sources; an unknown or missing signal and a changed scope, type or need are errors.
    pub fn parse(text: &str) -> (Catalog, Vec<Diagnostic>) {
        read::read(text)
    }

    /// All signals in the catalog's order.
    pub fn iter(&self) -> impl Iterator<Item = &SignalDef> {
        self.defs.iter()
    }

    /// The display name of a category's value; the value itself if it has no name.
    pub fn value_name(&self, value: &str) -> Bilingual {
        self.values.get(value).cloned().unwrap_or_else(|| Bilingual::same(value.replace('_', " ")))
    }

    /// The title of a signal; its name if it has no title.
    pub fn title(&self, name: &str) -> Bilingual {
        let title = self.get(name).map(|def| def.title.clone());
        title.filter(|t| !t.zh.is_empty()).unwrap_or_else(|| Bilingual::same(name))
    }

    /// The signal with this name or alias; `target_vehicle.` and `target_vru.` stand for `target.`.
    pub fn get(&self, name: &str) -> Option<&SignalDef> {
        self.resolve(name).map(|(def, _)| def)
    }

    /// The signal with this name or alias, and the targets to which the prefix of the name restricts it.
    pub fn resolve(&self, name: &str) -> Option<(&SignalDef, TargetRestriction)> {
        let prefixes =
            [("target_vehicle.", TargetRestriction::Vehicle), ("target_vru.", TargetRestriction::Vru)];
        for (prefix, restriction) in prefixes {
            if let Some(rest) = name.strip_prefix(prefix) {
                let index = *self.by_name.get(&format!("target.{rest}"))?;
                return Some((&self.defs[index], restriction));
            }
        }
        self.by_name.get(name).map(|&i| (&self.defs[i], TargetRestriction::Any))
    }

    /// A signal of the program whose entry has an error, or is missing, which was reported: that what uses it does not
    /// find it follows from that. `name` is as a rule writes it; a role of the rule stands for `target`.
    pub fn lacks(&self, name: &str) -> bool {
        let of_target = name.split_once('.').map(|(_, rest)| format!("target.{rest}"));
        let bundled = Self::bundled();
        let def = bundled.get(name).or_else(|| bundled.get(&of_target?));
        def.is_some_and(|def| self.get(&def.name).is_none())
    }

    /// Up to three known names similar to `name`, the nearest first: for "did you mean".
    pub fn similar(&self, name: &str) -> Vec<&str> {
        let mut scored: Vec<(f64, &str)> =
            self.by_name.keys().map(|known| (similarity(name, known), known.as_str())).collect();
        scored.retain(|(score, _)| *score > 0.7);
        scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
        scored.into_iter().take(3).map(|(_, known)| known).collect()
    }
}

#[cfg(test)]
mod tests;
