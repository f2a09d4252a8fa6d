//! What would let a person recognize a gold task that they label: the label from which it was copied, and other copies
//! of it. Users who also check or audit see all tasks of their project, so these are hidden from them until they have
//! submitted their own. Leads see everything.

use crate::domain::project::{Dashboard, WaitingLabels};
use crate::domain::workflow::{Role, State};
use crate::problem::Answer;
use crate::service::by_state;
use crate::service::copies::episode_of;
use crate::service::disagreement::NOT_SUPERSEDED;
use crate::store::{Row, Tx};
use crate::values;
use std::collections::{BTreeMap, BTreeSet};

/// Tasks that are hidden from a user.
#[derive(Clone, Debug, Default)]
pub struct Hidden {
    /// Their ids.
    pub ids: BTreeSet<String>,
    /// Their number by state.
    by_state: BTreeMap<String, i64>,
    /// What those in the state `submitted` wait for.
    submitted: WaitingLabels,
    /// Number of their episodes with an accepted label, by class.
    accepted: BTreeMap<String, i64>,
}

/// What is read of a hidden task; `tasks` is the table.
fn columns() -> String {
    format!(
        "tasks.id, tasks.episode_id, tasks.state, tasks.scenario_id, {} AS waits,
         CASE WHEN {NOT_SUPERSEDED} THEN 1 ELSE 0 END AS counts",
        by_state::waits_for()
    )
}

impl Hidden {
    /// The tasks of `project` that are hidden from `user`.
    pub fn of(tx: &mut dyn Tx, project: &str, user: &str, roles: &[Role]) -> Answer<Self> {
        let checks = roles.contains(&Role::Checker) || roles.contains(&Role::Auditor);
        if roles.contains(&Role::Lead) || !checks || !roles.contains(&Role::Annotator) {
            return Ok(Self::default());
        }
        let own = tx.rows(
            "SELECT t.episode_id FROM gold g JOIN tasks t ON t.id = g.task_id WHERE g.project_id = $1 AND g.user_id = $2
               AND t.state IN ('open', 'stage1', 'stage1_locked', 'stage2')",
            values![project, user],
        )?;
        let episodes = own.iter().map(|r| Ok(episode_of(&r.text("episode_id")?).to_owned()));
        let episodes: BTreeSet<String> = episodes.collect::<Answer<_>>()?;
        let mut out = Self::default();
        if episodes.is_empty() {
            return Ok(out);
        }
        for episode in &episodes {
            let sql = format!("SELECT {} FROM tasks WHERE project_id = $1 AND episode_id = $2", columns());
            let labels = tx.rows(&sql, values![project, episode])?;
            let mut class = None;
            for r in labels {
                if r.text("state")? == "accepted" {
                    class = Some(r.text("scenario_id")?);
                }
                out.add(&r)?;
            }
            if let Some(class) = class {
                *out.accepted.entry(class).or_default() += 1;
            }
        }
        let sql = format!(
            "SELECT {} FROM gold g JOIN tasks ON tasks.id = g.task_id WHERE g.project_id = $1 AND g.user_id <> $2",
            columns()
        );
        for r in tx.rows(&sql, values![project, user])? {
            if episodes.contains(episode_of(&r.text("episode_id")?)) {
                out.add(&r)?;
            }
        }
        Ok(out)
    }

    fn add(&mut self, row: &Row) -> Answer<()> {
        // A label of which another one was chosen is in no count by state.
        if self.ids.insert(row.text("id")?) && row.flag("counts")? {
            let state = row.text("state")?;
            if state == State::Submitted.word() {
                self.submitted.add(&row.text("waits")?, 1);
            }
            *self.by_state.entry(state).or_default() += 1;
        }
        Ok(())
    }

    /// Numbers of tasks by state without these; states without a task are left out, as in the count itself.
    pub fn without(&self, by_state: &mut BTreeMap<String, i64>) {
        for (state, n) in &self.by_state {
            if let Some(all) = by_state.get_mut(state) {
                *all -= n;
            }
        }
        by_state.retain(|_, n| *n > 0);
    }

    /// The dashboard without these. The copy itself counts as an episode that has a task, in place of its source.
    pub fn from_dashboard(&self, mut board: Dashboard) -> Dashboard {
        self.without(&mut board.by_state);
        let WaitingLabels { check, choice, other_labels } = self.submitted;
        board.submitted.check -= check;
        board.submitted.choice -= choice;
        board.submitted.other_labels -= other_labels;
        board.ageing.retain(|a| !self.ids.contains(&a.task));
        for c in &mut board.coverage {
            c.have -= self.accepted.get(&c.leaf).copied().unwrap_or_default();
        }
        board
    }
}
