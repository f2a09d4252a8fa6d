//! Classes that leads enter, in quotas and as skills. A class that is not in the taxonomy would cause silent errors: a
//! quota that is never met, a member who gets no task.

use crate::problem::{Answer, Problem};
use std::collections::BTreeMap;
use whyroad_framework::Taxonomy;
use whyroad_model::ScenarioId;

/// Refuses a quota for an id that is not an L3 class, unless it was there `before`: the taxonomy may have changed
/// since.
pub fn check_quota(
    taxonomy: &Taxonomy,
    quota: &BTreeMap<String, u32>,
    before: &BTreeMap<String, u32>,
) -> Answer<()> {
    let is_leaf =
        |id: &str| taxonomy.leaves().any(|(a, b, c)| ScenarioId::leaf(&a.id, &b.id, &c.id).to_string() == id);
    match quota.keys().find(|id| !before.contains_key(*id) && !is_leaf(id)) {
        None => Ok(()),
        Some(id) => Err(Problem::new(
            422,
            "project.quota",
            format!("配额中的 '{id}' 不是 L3 场景"),
            format!("'{id}' in the quota is not an L3 class of the taxonomy"),
        )),
    }
}

/// Refuses a skill that is neither an L1, an L2 nor an L3 class.
pub fn check_skills(taxonomy: &Taxonomy, skills: &[String]) -> Answer<()> {
    let ids: Vec<String> = taxonomy.ids().iter().map(ToString::to_string).collect();
    match skills.iter().find(|s| !ids.contains(s)) {
        None => Ok(()),
        Some(skill) => Err(Problem::new(
            422,
            "member.skill",
            format!("'{skill}' 不是场景分类"),
            format!("'{skill}' is not a class of the taxonomy"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_framework::Framework;

    #[test]
    fn quotas_are_on_leaves_and_skills_on_any_class() {
        let taxonomy = &Framework::bundled().taxonomy;
        let quota = |ids: &[&str]| ids.iter().map(|id| ((*id).to_owned(), 5)).collect::<BTreeMap<_, _>>();
        let none = BTreeMap::new();
        assert!(check_quota(taxonomy, &quota(&["reactive_agent.cutin.urgent"]), &none).is_ok());
        for wrong in ["reactive_agent.cutin", "reactive_agent.cutin.none", ""] {
            assert_eq!(check_quota(taxonomy, &quota(&[wrong]), &none).unwrap_err().code, "project.quota");
            assert!(check_quota(taxonomy, &quota(&[wrong]), &quota(&[wrong])).is_ok(), "it was there");
        }
        let skills = |ids: &[&str]| ids.iter().map(|id| (*id).to_owned()).collect::<Vec<_>>();
        let fine = skills(&["reactive_agent", "reactive_agent.cutin", "reactive_agent.cutin.urgent"]);
        assert!(check_skills(taxonomy, &fine).is_ok());
        assert_eq!(check_skills(taxonomy, &skills(&["cutin"])).unwrap_err().code, "member.skill");
    }
}
