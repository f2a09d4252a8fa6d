//! Settings of a project, and changes of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of a project.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Length of a lease, s.
    pub lease_s: u32,
    /// Minimum audit rate of checked labels, in percent.
    pub audit_min_percent: u32,
    /// Maximum audit rate, for an author with a poor record, in percent.
    pub audit_max_percent: u32,
    /// Language of drafts: `zh` or `en`.
    pub lang: String,
    /// Condition that excludes a user from Stage I of a task.
    pub history: HistoryRule,
    /// How precisely Stage I shows the class of a task.
    pub stage1_class: Stage1Class,
    /// Precision of locations, m: scenes are given relative to the corner of a square of this size, without the
    /// position of that corner. 0 for recorded positions.
    pub place_precision_m: u32,
    /// Gold labels that an annotator submits before being judged; 0 for no qualification.
    pub gold_labels: u32,
    /// Minimum mean agreement with gold answers for qualification, in percent. Annotators who are not qualified are
    /// audited at the maximum rate.
    pub gold_percent: u32,
    /// Days after which finished tasks are removed with their labels; 0 to keep them.
    pub retention_days: u32,
    /// Cost of an hour of work, for the cost per accepted label; null if unknown.
    pub hourly_rate: Option<f64>,
    /// Currency of the rate, for display.
    pub currency: String,
    /// Minutes by which the project's clock is ahead of UTC: its days begin at midnight of that clock. A change applies
    /// to work from then on.
    pub utc_offset_min: i32,
}

/// A change of [`Settings`]: only the fields that are given are changed; null leaves one as it is, except where the
/// setting itself can be null.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SettingsChange {
    /// Length of a lease, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lease_s: Option<u32>,
    /// Minimum audit rate of checked labels, in percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit_min_percent: Option<u32>,
    /// Maximum audit rate, in percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit_max_percent: Option<u32>,
    /// Language of drafts: `zh` or `en`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lang: Option<String>,
    /// Condition that excludes a user from Stage I of a task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<HistoryRule>,
    /// How precisely Stage I shows the class of a task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage1_class: Option<Stage1Class>,
    /// Precision of locations, m; 0 for recorded positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place_precision_m: Option<u32>,
    /// Gold labels that an annotator submits before being judged; 0 for no qualification.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gold_labels: Option<u32>,
    /// Minimum mean agreement with gold answers for qualification, in percent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gold_percent: Option<u32>,
    /// Days after which finished tasks are removed with their labels; 0 to keep them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retention_days: Option<u32>,
    /// Cost of an hour of work; null if it is unknown from now on.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "given")]
    #[schemars(with = "Option<f64>")]
    pub hourly_rate: Option<Option<f64>>,
    /// Currency of the rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// Minutes by which the project's clock is ahead of UTC.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub utc_offset_min: Option<i32>,
}

/// A field that is given, also as null.
fn given<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(from).map(Some)
}

impl Settings {
    /// These settings with the fields of `change` that are given.
    ///
    /// # Errors
    /// A value that no setting can have; `change` was read from a request, so there is none.
    pub fn with(&self, change: &SettingsChange) -> Result<Self, serde_json::Error> {
        let mut all = serde_json::to_value(self)?;
        if let (Some(all), serde_json::Value::Object(given)) =
            (all.as_object_mut(), serde_json::to_value(change)?)
        {
            all.extend(given);
        }
        serde_json::from_value(all)
    }
}

/// What a user may have seen of a drive and still do Stage I of one of its tasks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum HistoryRule {
    /// Nothing after the task's keyframe, in any task.
    #[default]
    Drive,
    /// Nothing after the keyframe in a task of the same episode. For small teams and short drives, where the same few
    /// people eventually see all of a drive.
    Episode,
}

/// How precisely Stage I shows the class of a task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Stage1Class {
    /// The L3 class.
    #[default]
    Leaf,
    /// The L2 class, if an L3 class of that L2 has a name that reveals the outcome. Everything that depends on the L3
    /// class (specification, signals, target, range, drafted components) is then withheld until Stage I is locked.
    L2,
}

impl Default for Settings {
    /// LABELING.md 6: audit of 10 to 20 %. Leases of five minutes, renewed by a heartbeat.
    fn default() -> Self {
        Self {
            lease_s: 300,
            audit_min_percent: 10,
            audit_max_percent: 20,
            lang: "zh".to_owned(),
            history: HistoryRule::Drive,
            stage1_class: Stage1Class::Leaf,
            place_precision_m: 0,
            gold_labels: 0,
            gold_percent: 80,
            retention_days: 0,
            hourly_rate: None,
            currency: "CNY".to_owned(),
            utc_offset_min: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// openapi.json: "changes the fields that are given".
    #[test]
    fn a_change_of_one_setting_leaves_the_others() {
        let before: Settings = serde_json::from_value(json!({
            "lease_s": 900, "audit_min_percent": 3, "audit_max_percent": 7, "lang": "en", "history": "episode",
            "stage1_class": "l2", "place_precision_m": 1000, "gold_labels": 4, "gold_percent": 70,
            "retention_days": 180, "hourly_rate": 12.5, "currency": "EUR", "utc_offset_min": 480,
        }))
        .unwrap();
        let all = serde_json::to_value(&before).unwrap();
        for (name, value) in [("lease_s", json!(600)), ("lang", json!("zh")), ("hourly_rate", Value::Null)] {
            let change: SettingsChange = serde_json::from_value(json!({ name: value })).unwrap();
            let mut wanted = all.clone();
            wanted[name] = value;
            assert_eq!(serde_json::to_value(before.with(&change).unwrap()).unwrap(), wanted, "{name}");
        }
        assert_eq!(before.with(&SettingsChange::default()).unwrap(), before);
        // Each setting can be changed.
        let change: SettingsChange = serde_json::from_value(all).unwrap();
        assert_eq!(Settings::default().with(&change).unwrap(), before);
        assert!(serde_json::from_value::<SettingsChange>(json!({ "leases": 600 })).is_err());
    }
}
