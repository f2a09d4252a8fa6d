//! Verdicts of people on mined episodes (docs/reference/verdicts.md).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A person's verdict on a mined episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VerdictKind {
    /// Class and keyframe are right.
    Right,
    /// An episode of another class is there.
    WrongLeaf,
    /// There is no episode.
    Nothing,
    /// The class is right, the keyframe is another moment.
    KeyframeMoved,
}

impl VerdictKind {
    /// Its identifier in the store and in exports.
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::WrongLeaf => "wrong_leaf",
            Self::Nothing => "nothing",
            Self::KeyframeMoved => "keyframe_moved",
        }
    }

    /// The one with this identifier.
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Right, Self::WrongLeaf, Self::Nothing, Self::KeyframeMoved]
            .into_iter()
            .find(|v| v.word() == word)
    }
}
