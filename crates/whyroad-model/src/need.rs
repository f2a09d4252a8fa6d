//! What a log can lack, with one name per language for all pages and commands.

use crate::{Bilingual, Lang};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

include!(concat!(env!("OUT_DIR"), "/needs.rs"));

impl Need {
    /// The identifier in files: `traffic lights`.
    pub fn id(self) -> &'static str {
        NAMES[self as usize].0
    }

    /// The need with this identifier.
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|n| n.id() == id)
    }

    /// The displayed name.
    pub fn name(self) -> Bilingual {
        let (_, zh, en) = NAMES[self as usize];
        Bilingual::new(zh, en)
    }

    /// The names of several needs in one line.
    pub fn list(needs: &[Need], lang: Lang) -> String {
        let names: Vec<String> = needs.iter().map(|n| n.name().get(lang).to_owned()).collect();
        names.join(match lang {
            Lang::Zh => "、",
            Lang::En => ", ",
        })
    }

    /// Those whose condition holds, in the order given: how an adapter states what a log lacks.
    pub fn absent(parts: impl IntoIterator<Item = (bool, Need)>) -> Vec<Need> {
        parts.into_iter().filter_map(|(absent, need)| absent.then_some(need)).collect()
    }
}

impl Serialize for Need {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.id())
    }
}

impl<'de> Deserialize<'de> for Need {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let id = String::deserialize(from)?;
        Self::from_id(&id).ok_or_else(|| serde::de::Error::custom(format!("unknown need '{id}'")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_lead_back() {
        for (i, need) in Need::ALL.iter().enumerate() {
            assert_eq!(Need::from_id(need.id()), Some(*need));
            assert_eq!(*need as usize, i);
            assert!(!need.name().zh.is_ascii(), "{}", need.id());
        }
        assert_eq!(Need::from_id("pose"), None);
    }

    #[test]
    fn json_is_the_id_and_an_unknown_one_is_an_error() {
        let json = serde_json::to_string(&[Need::EgoPose, Need::TrafficLights]).unwrap();
        assert_eq!(json, r#"["ego pose","traffic lights"]"#);
        assert_eq!(serde_json::from_str::<Vec<Need>>(&json).unwrap(), [Need::EgoPose, Need::TrafficLights]);
        assert!(serde_json::from_str::<Need>(r#""pose""#).unwrap_err().to_string().contains("'pose'"));
    }
}
