//! The catalogue of signals, read from `schema/signals.yaml`: what each name means, in what unit, and what
//! a log must have for it. Only names and meanings live there; how a value is computed is code.

mod page;

use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Diagnostic, Location};

/// Codes of the diagnostics that this crate emits; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &["signals.syntax", "signals.name", "signals.type", "signals.needs"];

/// What a log can have or lack; the words of `needs` in the catalogue and of `SignalTable::unavailable`.
pub const NEEDS: &[&str] = &[
    "ego pose",
    "map",
    "traffic lights",
    "vehicle bus",
    "object sizes",
    "object classes",
    "turn signals",
    "visibility",
    "elevation",
    "routing",
    "weather",
    "surface",
    "lighting",
    "road type",
    "lane marks",
    "signs",
    "facilities",
    "construction state",
    "accident state",
    "warning light",
    "gate state",
    "navigation limit",
    "pavement",
];

/// Over what a signal has values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// One value a frame.
    Frame,
    /// One value a target and frame.
    Target,
}

/// What values a signal has.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalKind {
    /// A number in the base unit of the dimension.
    Number(Dimension),
    /// True, false or unknown.
    Flag,
    /// One of these names.
    Category(Arc<[String]>),
}

/// One entry of the catalogue.
#[derive(Clone, Debug)]
pub struct SignalDef {
    /// Full name: `ego.speed`, `target.gap`.
    pub name: String,
    /// Over what it has values.
    pub scope: Scope,
    /// What values it has.
    pub kind: SignalKind,
    /// Unit as the catalogue writes it; empty for flags, categories and pure numbers. Values are in the base unit.
    pub unit: String,
    /// What it means, with its formula.
    pub meaning: Bilingual,
    /// What the log must have (words of [`NEEDS`]).
    pub needs: Vec<String>,
    /// Where the definition comes from.
    pub source: String,
    /// Typical magnitude in the base unit, for normalising margins; 1 for flags and categories.
    pub scale: f64,
    /// Other names for it.
    pub aliases: Vec<String>,
}

/// To which targets a name restricts a rule: `target_vehicle.gap` is `target.gap` of vehicles.
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
pub struct Catalogue {
    /// Version of the catalogue.
    pub version: String,
    defs: Vec<SignalDef>,
    by_name: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCatalogue {
    version: String,
    signals: Vec<RawSignal>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSignal {
    name: String,
    scope: Scope,
    #[serde(rename = "type")]
    kind: RawKind,
    unit: Option<String>,
    scale: Option<f64>,
    #[serde(default)]
    values: Vec<String>,
    needs: Vec<String>,
    meaning: Bilingual,
    source: String,
    #[serde(default)]
    aliases: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawKind {
    Number,
    Flag,
    Category,
}

/// The catalogue's file, relative to the framework's folder.
const FILE: &str = "schema/signals.yaml";

/// Where the entries stand. serde forgets places; entries come in file order, so each is found after the one before.
struct Places<'t> {
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
}

impl<'t> Places<'t> {
    fn of(text: &'t str) -> Self {
        Self { lines: text.lines().enumerate() }
    }

    /// The place of the next entry, whose name is `name`.
    fn next(&mut self, name: &str) -> Location {
        let in_file = Location { file: Some(FILE.to_owned()), ..Location::default() };
        let names_it = |line: &str| {
            let (_, value) = line.split_once("name:")?;
            let value = value.trim().trim_matches(['"', '\'']);
            (value == name).then(|| line.find(name)).flatten()
        };
        let Some((at, line, start)) = self.lines.find_map(|(i, line)| Some((i, line, names_it(line)?)))
        else {
            return in_file;
        };
        Location {
            line: Some(at + 1),
            column: Some(line[..start].chars().count() + 1),
            snippet: Some(line.to_owned()),
            span: name.chars().count(),
            ..in_file
        }
    }
}

static BUNDLED: LazyLock<Catalogue> =
    LazyLock::new(|| Catalogue::parse(include_str!("../../../schema/signals.yaml")).0);

impl Catalogue {
    /// The catalogue that this build was made with; the one [`crate::derive`] follows. A test holds it free of errors.
    pub fn bundled() -> &'static Catalogue {
        &BUNDLED
    }

    /// Reads a catalogue. Entries with errors are left out and reported; the rest is usable.
    pub fn parse(text: &str) -> (Catalogue, Vec<Diagnostic>) {
        let raw: RawCatalogue = match serde_yaml_ng::from_str(text) {
            Ok(raw) => raw,
            Err(e) => {
                let place = e.location().map_or_else(Location::default, |l| Location {
                    file: Some(FILE.to_owned()),
                    line: Some(l.line()),
                    column: Some(l.column()),
                    ..Location::default()
                });
                let message = Bilingual::new(
                    format!("信号目录无法读取：{e}"),
                    format!("the signal catalogue cannot be read: {e}"),
                );
                return (Catalogue::default(), vec![Diagnostic::error("signals.syntax", message).at(place)]);
            }
        };
        let mut catalogue = Catalogue { version: raw.version, ..Catalogue::default() };
        let mut diagnostics = Vec::new();
        let mut places = Places::of(text);
        for signal in raw.signals {
            let place = places.next(&signal.name);
            let known = diagnostics.len();
            match resolve(signal) {
                Ok(def) => catalogue.add(def, &mut diagnostics),
                Err(d) => diagnostics.push(*d),
            }
            for d in diagnostics.iter_mut().skip(known) {
                d.location = place.clone();
            }
        }
        (catalogue, diagnostics)
    }

    fn add(&mut self, def: SignalDef, diagnostics: &mut Vec<Diagnostic>) {
        let names: Vec<String> = std::iter::once(&def.name).chain(&def.aliases).cloned().collect();
        if let Some(taken) = names.iter().find(|n| self.by_name.contains_key(*n)) {
            diagnostics.push(Diagnostic::error(
                "signals.name",
                Bilingual::new(
                    format!("信号名 '{taken}' 重复"),
                    format!("signal name '{taken}' is used twice"),
                ),
            ));
            return;
        }
        for name in names {
            self.by_name.insert(name, self.defs.len());
        }
        self.defs.push(def);
    }

    /// All signals in the catalogue's order.
    pub fn iter(&self) -> impl Iterator<Item = &SignalDef> {
        self.defs.iter()
    }

    /// The signal with this name or alias; `target_vehicle.` and `target_vru.` stand for `target.`.
    pub fn get(&self, name: &str) -> Option<&SignalDef> {
        self.resolve(name).map(|(def, _)| def)
    }

    /// The signal with this name or alias, and to which targets the way it was named restricts it.
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

    /// Up to three known names that look like `name`, the nearest first: for "did you mean".
    pub fn similar(&self, name: &str) -> Vec<&str> {
        let mut scored: Vec<(f64, &str)> = self
            .by_name
            .keys()
            .map(|known| (strsim::normalized_damerau_levenshtein(name, known), known.as_str()))
            .collect();
        scored.retain(|(score, _)| *score > 0.7);
        scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
        scored.into_iter().take(3).map(|(_, known)| known).collect()
    }
}

fn resolve(raw: RawSignal) -> Result<SignalDef, Box<Diagnostic>> {
    let error = |code: &'static str, zh: String, en: String| {
        let message =
            Bilingual::new(format!("信号 '{}'：{zh}", raw.name), format!("signal '{}': {en}", raw.name));
        Box::new(Diagnostic::error(code, message))
    };
    let prefix_fits = match raw.scope {
        Scope::Target => raw.name.starts_with("target."),
        Scope::Frame => !raw.name.starts_with("target") && raw.name.contains('.'),
    };
    if !prefix_fits {
        return Err(error(
            "signals.name",
            "名称与作用域不符".into(),
            "its name does not fit its scope".into(),
        ));
    }
    if let Some(word) = raw.needs.iter().find(|n| !NEEDS.contains(&n.as_str())) {
        let known = NEEDS.join(", ");
        return Err(error(
            "signals.needs",
            format!("未知的需求 '{word}'（可用：{known}）"),
            format!("unknown need '{word}' (known: {known})"),
        ));
    }
    let (kind, to_base) = match raw.kind {
        RawKind::Number => {
            let symbol = raw.unit.as_deref().unwrap_or("");
            let Some(unit) = Unit::parse(symbol).filter(|_| raw.unit.is_some()) else {
                return Err(error(
                    "signals.type",
                    format!("未知或缺失的单位 '{symbol}'"),
                    format!("unknown or missing unit '{symbol}'"),
                ));
            };
            if !raw.scale.is_some_and(|s| s.is_finite() && s > 0.0) {
                return Err(error(
                    "signals.type",
                    "数值信号须有正的 scale".into(),
                    "a number needs a positive scale".into(),
                ));
            }
            (SignalKind::Number(unit.dimension), unit.to_base)
        }
        RawKind::Flag => (SignalKind::Flag, 1.0),
        RawKind::Category if raw.values.is_empty() => {
            return Err(error(
                "signals.type",
                "类别信号须列出 values".into(),
                "a category needs its values".into(),
            ));
        }
        RawKind::Category => (SignalKind::Category(raw.values.clone().into()), 1.0),
    };
    Ok(SignalDef {
        name: raw.name,
        scope: raw.scope,
        kind,
        unit: raw.unit.unwrap_or_default(),
        meaning: raw.meaning,
        needs: raw.needs,
        source: raw.source,
        scale: raw.scale.map_or(1.0, |s| s * to_base),
        aliases: raw.aliases,
    })
}

#[cfg(test)]
mod tests;
