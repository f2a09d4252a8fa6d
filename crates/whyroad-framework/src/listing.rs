//! The classes as flat rows, for `taxonomy list --format json` and whoever reads it.

use crate::taxonomy::TypicalDecisions;
use crate::{Framework, Taxonomy};
use serde::Serialize;
use whyroad_model::ScenarioId;

/// One class of any level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// `l1`, `l2` or `l3`.
    pub level: &'static str,
    /// Full id.
    pub id: String,
    /// Full id of the class above; null for an L1.
    pub parent: Option<String>,
    /// Chinese name.
    pub name_zh: String,
    /// English name.
    pub name_en: String,
    /// Chinese definition.
    pub definition_zh: String,
    /// English definition.
    pub definition_en: String,
    /// Chinese condition, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition_zh: Option<String>,
    /// English condition, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition_en: Option<String>,
    /// Decisions that the ego usually takes; absent for an L1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub typical_decisions: Option<TypicalDecisions>,
    /// Whether a mining rule exists; only for an L3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub has_mining_rule: Option<bool>,
}

/// All classes in tree order; with `l1`, that L1 and what is below it.
pub fn rows(framework: &Framework, l1: Option<&str>) -> Vec<Row> {
    let taxonomy: &Taxonomy = &framework.taxonomy;
    let mut out = Vec::new();
    for a in taxonomy.l1.iter().filter(|a| l1.is_none_or(|id| a.id == id)) {
        let blank = Row {
            level: "l1",
            id: a.id.clone(),
            parent: None,
            name_zh: a.name.zh.clone(),
            name_en: a.name.en.clone(),
            definition_zh: a.definition.zh.clone(),
            definition_en: a.definition.en.clone(),
            condition_zh: None,
            condition_en: None,
            typical_decisions: None,
            has_mining_rule: None,
        };
        out.push(blank.clone());
        for b in &a.l2 {
            let l2_id = format!("{}.{}", a.id, b.id);
            out.push(Row {
                level: "l2",
                id: l2_id.clone(),
                parent: Some(a.id.clone()),
                name_zh: b.name.zh.clone(),
                name_en: b.name.en.clone(),
                definition_zh: b.definition.zh.clone(),
                definition_en: b.definition.en.clone(),
                condition_zh: b.condition.as_ref().map(|c| c.zh.clone()),
                condition_en: b.condition.as_ref().map(|c| c.en.clone()),
                typical_decisions: Some(b.typical_decisions.clone()),
                ..blank.clone()
            });
            for c in &b.l3 {
                let leaf = ScenarioId::leaf(&a.id, &b.id, &c.id);
                out.push(Row {
                    level: "l3",
                    id: leaf.to_string(),
                    parent: Some(l2_id.clone()),
                    name_zh: c.name.zh.clone(),
                    name_en: c.name.en.clone(),
                    definition_zh: c.definition.zh.clone(),
                    definition_en: c.definition.en.clone(),
                    condition_zh: Some(c.condition.zh.clone()),
                    condition_en: Some(c.condition.en.clone()),
                    typical_decisions: Some(c.typical_decisions.clone()),
                    has_mining_rule: Some(framework.rule(&leaf).is_some()),
                });
            }
        }
    }
    out
}
