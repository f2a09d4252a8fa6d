//! Options of an ingest: those that every format understands, and those that an adapter declares. The command line
//! builds its arguments from the declarations, so an option exists once, beside the code that reads it.

use crate::maps::cache::MapCache;
use crate::source::ContentHash;
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, DriveId, Nanos};

/// 2026-01-01T00:00:00Z: start of drives whose log has no clock, by default.
pub const DEFAULT_START: Nanos = Nanos(1_767_225_600_000_000_000);

/// Start of drives whose log has no clock.
pub const START: OptionSpec = OptionSpec::new(
    "start-time",
    OptionType::Time,
    "TIME",
    "start of drives whose log has no clock (default: 2026-01-01T00:00:00Z)",
);
/// License of the data.
pub const LICENCE: OptionSpec = OptionSpec::new(
    "licence",
    OptionType::Text,
    "ID",
    "license of the data (SPDX id), for logs that do not state it",
);

/// Type of an option's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OptionType {
    /// No value: given or not.
    Flag,
    /// Any text.
    Text,
    /// Path of a file.
    File,
    /// Time, ISO 8601 in UTC.
    Time,
    /// Integer from 0.
    Integer,
    /// Number from `min` to `max`, both included.
    Number {
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
}

/// An option that an adapter declares.
#[derive(Clone, Debug)]
pub struct OptionSpec {
    /// Name on the command line, without dashes.
    pub name: &'static str,
    /// Type of its value.
    pub value: OptionType,
    /// Placeholder of the value in the help text; empty for a flag.
    pub value_name: &'static str,
    /// One line for the help text.
    pub help: &'static str,
    /// True when the option may be given several times.
    pub repeatable: bool,
    /// True when the value can begin with a minus sign.
    pub signed: bool,
    /// Names of options of the same adapter that exclude this one.
    pub conflicts: &'static [&'static str],
    /// Option of the same adapter that must be given too.
    pub requires: Option<&'static str>,
}

impl OptionSpec {
    /// An option with a value, given at most once.
    pub const fn new(
        name: &'static str,
        value: OptionType,
        value_name: &'static str,
        help: &'static str,
    ) -> Self {
        Self {
            name,
            value,
            value_name,
            help,
            repeatable: false,
            signed: false,
            conflicts: &[],
            requires: None,
        }
    }

    /// The same option, allowed several times.
    pub const fn repeatable(mut self) -> Self {
        self.repeatable = true;
        self
    }

    /// The same option, with values that can begin with a minus sign.
    pub const fn signed(mut self) -> Self {
        self.signed = true;
        self
    }

    /// The same option, excluded by others.
    pub const fn conflicts_with(mut self, names: &'static [&'static str]) -> Self {
        self.conflicts = names;
        self
    }

    /// The same option, only together with another.
    pub const fn requires(mut self, name: &'static str) -> Self {
        self.requires = Some(name);
        self
    }

    /// The value in a text of the user; `Err` says what was expected.
    pub fn parse(&self, text: &str) -> Result<OptionValue, Bilingual> {
        match self.value {
            OptionType::Flag => Ok(OptionValue::Flag),
            OptionType::Text => Ok(OptionValue::Text(text.to_owned())),
            OptionType::Time => Nanos::parse_iso(text).map(OptionValue::Time).map_err(|e| e.text()),
            OptionType::File => Ok(OptionValue::File(text.into())),
            OptionType::Integer => text
                .parse()
                .map(OptionValue::Integer)
                .map_err(|_| Bilingual::new("应为不小于 0 的整数", "expected an integer from 0")),
            OptionType::Number { min, max } => {
                let number = text.parse().ok().filter(|v: &f64| (min..=max).contains(v));
                number.map(OptionValue::Number).ok_or_else(|| {
                    if max.is_finite() {
                        Bilingual::new(
                            format!("应为 {min} 到 {max} 之间的数"),
                            format!("expected a number from {min} to {max}"),
                        )
                    } else {
                        Bilingual::new(
                            format!("应为不小于 {min} 的数"),
                            format!("expected a number from {min}"),
                        )
                    }
                })
            }
        }
    }
}

/// Value of an option.
#[derive(Clone, Debug, PartialEq)]
pub enum OptionValue {
    /// The flag was given.
    Flag,
    /// A text.
    Text(String),
    /// A path.
    File(PathBuf),
    /// A time.
    Time(Nanos),
    /// An integer.
    Integer(u64),
    /// A number.
    Number(f64),
}

impl From<&str> for OptionValue {
    fn from(text: &str) -> Self {
        OptionValue::Text(text.to_owned())
    }
}

impl From<String> for OptionValue {
    fn from(text: String) -> Self {
        OptionValue::Text(text)
    }
}

impl From<f64> for OptionValue {
    fn from(number: f64) -> Self {
        OptionValue::Number(number)
    }
}

impl From<u64> for OptionValue {
    fn from(number: u64) -> Self {
        OptionValue::Integer(number)
    }
}

impl From<Nanos> for OptionValue {
    fn from(time: Nanos) -> Self {
        OptionValue::Time(time)
    }
}

impl From<PathBuf> for OptionValue {
    fn from(path: PathBuf) -> Self {
        OptionValue::File(path)
    }
}

/// Options of an ingest.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Id of the drive, when there is one source; otherwise derived from the source's name.
    pub drive_id: Option<DriveId>,
    /// Values of declared options, in the order in which they were given.
    values: Vec<(&'static str, OptionValue)>,
    /// The map that they name, once it has been read.
    pub(crate) map: MapCache,
}

impl Options {
    /// These options with an id for the drive.
    pub fn with_drive_id(mut self, id: DriveId) -> Self {
        self.drive_id = Some(id);
        self
    }

    /// These options and a value of an adapter's option.
    pub fn with(mut self, option: &OptionSpec, value: impl Into<OptionValue>) -> Self {
        self.set(option, value.into());
        self
    }

    /// Adds a value of an adapter's option; replaces the last one unless the option is repeatable.
    pub fn set(&mut self, option: &OptionSpec, value: OptionValue) {
        self.map = MapCache::default();
        if !option.repeatable {
            self.values.retain(|(name, _)| *name != option.name);
        }
        self.values.push((option.name, value));
    }

    fn all<'a>(&'a self, option: &'a OptionSpec) -> impl Iterator<Item = &'a OptionValue> {
        self.values.iter().filter(|(name, _)| *name == option.name).map(|(_, value)| value)
    }

    /// Start of drives whose log has no clock.
    pub fn start(&self) -> Nanos {
        self.all(&START)
            .find_map(|v| if let OptionValue::Time(t) = v { Some(*t) } else { None })
            .unwrap_or(DEFAULT_START)
    }

    /// Adds the start of drives whose log has no clock to the hash of a drive. Where it was given it is a date; the
    /// default is none, so that the same time given is another content.
    pub(crate) fn hash_start(&self, hash: &mut ContentHash) {
        let start = self.start();
        hash.add("start", &start.0.to_le_bytes());
        if start == DEFAULT_START && self.is_set(&START) {
            hash.add("start given", &[]);
        }
    }

    /// License of the data (SPDX id), for logs that do not state it.
    pub fn licence(&self) -> Option<String> {
        self.texts(&LICENCE).pop()
    }

    /// True when the option was given.
    pub fn is_set(&self, option: &OptionSpec) -> bool {
        self.all(option).next().is_some()
    }

    /// Texts of a repeatable option.
    pub fn texts(&self, option: &OptionSpec) -> Vec<String> {
        self.all(option)
            .filter_map(|v| if let OptionValue::Text(text) = v { Some(text.clone()) } else { None })
            .collect()
    }

    /// Paths of a repeatable option.
    pub fn files(&self, option: &OptionSpec) -> Vec<PathBuf> {
        self.all(option)
            .filter_map(|v| if let OptionValue::File(path) = v { Some(path.clone()) } else { None })
            .collect()
    }

    /// Path of an option.
    pub fn file<'a>(&'a self, option: &'a OptionSpec) -> Option<&'a Path> {
        self.all(option)
            .find_map(|v| if let OptionValue::File(path) = v { Some(path.as_path()) } else { None })
    }

    /// Number of an option.
    pub fn number(&self, option: &OptionSpec) -> Option<f64> {
        self.all(option).find_map(|v| if let OptionValue::Number(number) = v { Some(*number) } else { None })
    }

    /// Integer of an option.
    pub fn integer(&self, option: &OptionSpec) -> Option<u64> {
        self.all(option).find_map(|v| if let OptionValue::Integer(number) = v { Some(*number) } else { None })
    }
}
