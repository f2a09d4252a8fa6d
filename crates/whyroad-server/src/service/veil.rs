//! Classes of which Stage I shows only the L2, if the project requires it. This is decided per L2: if one of its L3
//! classes has a name that reveals the outcome (`reveals` in `scenarios/decisions.yaml`), none of its L3 classes is
//! shown, because a missing name would reveal the same.

use crate::domain::project::{Settings, Stage1Class};
use crate::problem::Answer;
use crate::service::projects::{self, json};
use crate::store::Tx;
use crate::values;
use std::collections::BTreeSet;
use whyroad_framework::Framework;

/// The L2 of an L3 class: the first two parts of its id.
pub fn l2(scenario: &str) -> &str {
    scenario.match_indices('.').nth(1).map_or(scenario, |(at, _)| &scenario[..at])
}

/// Ids of the L2 classes whose L3 classes are hidden in Stage I with these settings.
pub fn classes(framework: &Framework, settings: &Settings) -> BTreeSet<String> {
    if settings.stage1_class == Stage1Class::Leaf {
        return BTreeSet::new();
    }
    let telling = framework.decision_table().leaves.iter().filter(|(_, class)| class.reveals);
    telling.map(|(leaf, _)| l2(&leaf.to_string()).to_owned()).collect()
}

/// Stores the hidden classes of `project`; reading a task then needs no framework.
pub fn set(tx: &mut dyn Tx, framework: &Framework, project: &str, settings: &Settings) -> Answer<()> {
    let veiled = json(&classes(framework, settings))?;
    tx.run(
        "UPDATE projects SET veiled = $1 WHERE id = $2 AND veiled <> $3",
        values![&veiled, project, &veiled],
    )
    .map(drop)
}

/// The same for all projects: the framework may have changed since the last start.
pub fn set_all(tx: &mut dyn Tx, framework: &Framework) -> Answer<()> {
    for project in projects::all(tx)? {
        set(tx, framework, &project.id, &project.settings)?;
    }
    Ok(())
}

/// The L2 classes of `project` whose L3 classes are hidden.
pub fn of(tx: &mut dyn Tx, project: &str) -> Answer<Vec<String>> {
    let row = tx.row("SELECT veiled FROM projects WHERE id = $1", values![project])?;
    row.map_or(Ok(vec![]), |r| projects::parse(&r.text("veiled")?))
}

/// SQL for the class of a task in lists: that of [`super::tasks::TaskRow::shown_class`]. `veiled` are ids from this
/// crate.
pub fn shown_class_sql(veiled: &[String]) -> String {
    let plain = |id: &&String| id.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'.'));
    let cases: Vec<String> = veiled
        .iter()
        .filter(plain)
        .map(|l2| format!("WHEN substr(scenario_id, 1, {}) = '{l2}.' THEN '{l2}'", l2.len() + 1))
        .collect();
    if cases.is_empty() {
        return "scenario_id".to_owned();
    }
    format!(
        "CASE WHEN state NOT IN ('open', 'stage1', 'skipped', 'rejected') THEN scenario_id {} ELSE scenario_id END",
        cases.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_l2_is_veiled_where_one_leaf_reveals_the_outcome() {
        let framework = Framework::bundled();
        let settings = Settings { stage1_class: Stage1Class::L2, ..Settings::default() };
        let veiled = classes(framework, &settings);
        // `lane_change.abort` and `lead_sudden_brake` are the examples of the issue; a cut-in reveals nothing.
        assert!(veiled.contains("proactive.lane_change") && veiled.contains("reactive_agent.following"));
        assert!(!veiled.contains("reactive_agent.cutin"), "{veiled:?}");
        assert!(classes(framework, &Settings::default()).is_empty());
        assert_eq!(l2("a.b.c"), "a.b");
        assert_eq!(l2("a.b"), "a.b");
    }
}
