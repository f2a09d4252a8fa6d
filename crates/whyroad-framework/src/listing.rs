//! The classes as flat rows, for `taxonomy list --format json` and its readers.

use crate::taxonomy::TypicalDecisions;
use crate::{Framework, ResolvedSpec, Taxonomy};
use serde::Serialize;
use whyroad_model::{Bilingual, ScenarioId};

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

/// All details of one class, for `taxonomy show`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detail {
    /// The class itself.
    #[serde(flatten)]
    pub class: Row,
    /// Description of what mining looks for; a leaf without its own has its L2's.
    pub mining_conditions: Vec<Bilingual>,
    /// Rules between this class and others, stated by either of the two.
    pub decides: Vec<Boundary>,
    /// Classes directly below.
    pub children: Vec<Row>,
    /// How a leaf is labeled, inheritance applied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labeling: Option<ResolvedSpec>,
    /// Where a leaf's mining rule is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mining_rule: Option<RulePlace>,
}

/// A rule between two classes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Boundary {
    /// The class that states it.
    pub stated_by: ScenarioId,
    /// The other class.
    pub against: ScenarioId,
    /// The rule.
    pub rule: Bilingual,
}

/// Where a rule is written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RulePlace {
    /// File of the framework.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
}

/// The details of an existing class; `None` when `id` names none.
pub fn detail(framework: &Framework, id: &ScenarioId) -> Option<Detail> {
    let all = rows(framework, Some(&id.l1));
    let full = id.to_string();
    let class = all.iter().find(|r| r.id == full)?.clone();
    let children = all.iter().filter(|r| r.parent.as_deref() == Some(full.as_str())).cloned().collect();
    let t = &framework.taxonomy;
    let l2 = id.l2.as_deref().and_then(|l2| t.l2(&id.l1, l2)).map(|(_, b)| b);
    let own = t.leaf(id).map(|(_, _, c)| c.mining_conditions.clone()).filter(|c| !c.is_empty());
    Some(Detail {
        class,
        mining_conditions: own.or_else(|| l2.map(|b| b.mining_conditions.clone())).unwrap_or_default(),
        decides: boundaries(framework, id),
        children,
        labeling: framework.specs.get(id).cloned(),
        mining_rule: framework.rule(id).map(|r| RulePlace { file: r.file.clone(), line: r.mark.line }),
    })
}

/// Rules that `id`, a class above it, or a class that it overlaps states. The same words of both sides appear once.
fn boundaries(framework: &Framework, id: &ScenarioId) -> Vec<Boundary> {
    let mut out: Vec<Boundary> = Vec::new();
    for a in &framework.taxonomy.l1 {
        for b in &a.l2 {
            let l2_id = ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None };
            let of_l3 = b.l3.iter().map(|c| (ScenarioId::leaf(&a.id, &b.id, &c.id), &c.decides));
            for (stated_by, rules) in std::iter::once((l2_id, &b.decides)).chain(of_l3) {
                for d in rules {
                    let ours = id.l2.is_some() && (id.is_within(&stated_by) || id.is_within(&d.against));
                    if ours {
                        let (stated_by, against) = (stated_by.clone(), d.against.clone());
                        out.push(Boundary { stated_by, against, rule: d.rule.clone() });
                    }
                }
            }
        }
    }
    // Rules that this class states itself come first; the mirror image on the other side is then left out.
    out.sort_by_key(|b| !id.is_within(&b.stated_by));
    let mut seen: Vec<Bilingual> = Vec::new();
    out.retain(|b| {
        let new = !seen.contains(&b.rule);
        seen.push(b.rule.clone());
        new
    });
    out
}
