//! Identifiers. Each is a distinct type so that a drive is never passed where a clip is meant.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

macro_rules! string_id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[serde(transparent)]
        pub struct $name(pub String);

        impl $name {
            /// The id as text.
            pub fn as_str(&self) -> &str { &self.0 }
        }
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result { f.write_str(&self.0) }
        }
        impl From<&str> for $name {
            fn from(s: &str) -> Self { Self(s.to_owned()) }
        }
        impl From<String> for $name {
            fn from(s: String) -> Self { Self(s) }
        }
    };
}

string_id!(
    /// One recorded drive: a continuous log of one ego vehicle.
    DriveId
);
string_id!(
    /// One clip: at most 20 s cut from a drive (LABELING.md 4). `<drive>_<three-digit index>`.
    ClipId
);
string_id!(
    /// One tracked object within a drive.
    TrackId
);

impl DriveId {
    /// Maximum length, characters.
    pub const MOST_CHARS: usize = 128;

    /// True for a character that may be in an id: an ASCII letter or digit, `-`, `_` or `.`.
    pub fn is_folder_safe_char(c: char) -> bool {
        c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.')
    }

    /// True if the id names a folder on every file system and never leaves the lake.
    pub fn is_folder_safe(&self) -> bool {
        let id = &self.0;
        (1..=Self::MOST_CHARS).contains(&id.len())
            && !id.starts_with('.')
            && id.chars().all(Self::is_folder_safe_char)
    }
}

/// First part of the ids of custom rules.
const CUSTOM: &str = "custom";

/// A place in the taxonomy: `l1`, `l1.l2` or `l1.l2.l3` (TAXONOMY.md "full id"). The class need not exist.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ScenarioId {
    /// Trigger category.
    pub l1: String,
    /// Scenario, absent when the id names a whole L1.
    pub l2: Option<String>,
    /// Variant, absent when the id names an L1 or L2.
    pub l3: Option<String>,
}

/// Id for unclassified moments: as L1 for decision moments that no class explains, as L2 and L3 for those that belong
/// to no class of the parent (LABELING.md 1). It is in no taxonomy file.
pub const OTHER: &str = "other";

impl ScenarioId {
    /// A leaf.
    pub fn leaf(l1: &str, l2: &str, l3: &str) -> Self {
        Self { l1: l1.into(), l2: Some(l2.into()), l3: Some(l3.into()) }
    }

    /// True when `self` is `other` or lies below it.
    pub fn is_within(&self, other: &ScenarioId) -> bool {
        self.l1 == other.l1
            && (other.l2.is_none() || self.l2 == other.l2)
            && (other.l3.is_none() || self.l3 == other.l3)
    }

    /// The class of what a custom rule finds: `custom.<name>`. It is in no taxonomy.
    pub fn custom(name: &str) -> Self {
        Self { l1: CUSTOM.to_owned(), l2: Some(name.to_owned()), l3: None }
    }

    /// The name of the custom rule, for an id that [`ScenarioId::custom`] made.
    pub fn custom_name(&self) -> Option<&str> {
        self.l2.as_deref().filter(|_| self.l1 == CUSTOM)
    }

    /// True for a three-part id.
    pub fn is_leaf(&self) -> bool {
        self.l3.is_some()
    }
}

impl fmt::Display for ScenarioId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.l1)?;
        for part in [&self.l2, &self.l3].into_iter().flatten() {
            write!(f, ".{part}")?;
        }
        Ok(())
    }
}

impl std::str::FromStr for ScenarioId {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        let parts: Vec<&str> = s.split('.').collect();
        let well_formed = |p: &&str| {
            !p.is_empty() && p.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        };
        if parts.len() > 3 || !parts.iter().all(well_formed) {
            return Err(format!(
                "'{s}' is not a scenario id (expected l1, l1.l2 or l1.l2.l3 in lower snake case)"
            ));
        }
        Ok(Self {
            l1: parts[0].to_owned(),
            l2: parts.get(1).map(|p| (*p).to_owned()),
            l3: parts.get(2).map(|p| (*p).to_owned()),
        })
    }
}

impl Serialize for ScenarioId {
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ScenarioId {
    fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        String::deserialize(d)?.parse().map_err(serde::de::Error::custom)
    }
}

impl JsonSchema for ScenarioId {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ScenarioId".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "pattern": "^[a-z0-9_]+(\\.[a-z0-9_]+){0,2}$" })
    }
}
