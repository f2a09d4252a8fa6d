//! The pending work in a project, for cards and the annotator's home page: tasks by state, and the caller's own.

use crate::domain::project::{MyWork, Work};
use crate::domain::task::WorkKind;
use crate::domain::workflow::Role;
use crate::problem::Answer;
use crate::service::recognized::Hidden;
use crate::service::{by_state, disagreement, drafting, other_class, people, projects, queue};
use crate::store::{Tx, Value as Cell};
use crate::values;
use std::collections::BTreeMap;

/// The work of `user` in `project` at `now`, ms since 1970; for staff also tasks by state, and for leads the tasks to
/// adjudicate.
pub fn of(tx: &mut dyn Tx, project: &str, user: &str, roles: &[Role], now: i64) -> Answer<Work> {
    let today = projects::day(&projects::get(tx, project)?.settings, now);
    let staff = roles.iter().any(|r| *r != Role::Annotator);
    let mut by_state = BTreeMap::new();
    if staff {
        by_state = by_state::of(tx, project)?;
        Hidden::of(tx, project, user, roles)?.without(&mut by_state);
    }
    let mut count = |sql: &str, values: &[Cell]| tx.row(sql, values)?.map_or(Ok(0), |r| r.int("n"));
    // A label of which another one was chosen is in no list either.
    let mut authored = |states: &str| {
        let sql = format!(
            "SELECT count(*) AS n FROM tasks
             WHERE project_id = $1 AND author = $2 AND state IN ({states}) AND {}",
            disagreement::NOT_SUPERSEDED
        );
        count(&sql, values![project, user])
    };
    let returned = authored("'rework'")?;
    let begun = authored("'stage1', 'stage1_locked', 'stage2'")?;
    let waiting = authored("'submitted', 'in_check', 'checked', 'in_audit'")?;
    let accepted = authored("'accepted'")?;
    let assigned = count(
        "SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND state = 'open' AND assigned = $2",
        values![project, user],
    )?;
    let submitted_today = count(
        "SELECT CAST(coalesce(sum(n), 0) AS BIGINT) AS n FROM activity
         WHERE project_id = $1 AND day = $2 AND actor = $3 AND action = 'submit'",
        values![project, today, user],
    )?;
    let asked = if staff {
        count(
            "SELECT count(DISTINCT c.task_id) AS n FROM comments c JOIN tasks t ON t.id = c.task_id
             WHERE c.to_lead = 1 AND c.resolved = 0 AND t.project_id = $1",
            values![project],
        )?
    } else {
        0
    };
    let [to_check, to_audit] = takeable(tx, project, user, roles, now)?;
    let pending = if staff { drafting::pending(tx, project)? } else { 0 };
    let (mut disagreeing, mut to_choose, mut wrong_class) = (0, 0, 0);
    if roles.contains(&Role::Lead) {
        disagreeing = disagreement::count(tx, project, disagreement::TO_ADJUDICATE)?;
        to_choose = disagreement::count(tx, project, disagreement::TO_CHOOSE)?;
        wrong_class = disagreement::count(tx, project, other_class::WAITING)?;
    }
    let total = by_state.values().sum();
    let mine = MyWork { returned, begun, assigned, waiting, accepted, submitted_today };
    Ok(Work {
        by_state,
        total,
        to_check,
        to_audit,
        asked,
        disagreeing,
        wrong_class,
        to_choose,
        pending,
        mine,
    })
}

/// Tasks that the queue has for `user` to check and to audit; 0 without the role.
fn takeable(tx: &mut dyn Tx, project: &str, user: &str, roles: &[Role], now: i64) -> Answer<[i64; 2]> {
    let kinds = [(Role::Checker, WorkKind::Check), (Role::Auditor, WorkKind::Audit)];
    let mut out = [0; 2];
    if !kinds.iter().any(|(role, _)| roles.contains(role)) {
        return Ok(out);
    }
    let project = projects::get(tx, project)?;
    let Some(user) = people::find(tx, user)? else { return Ok(out) };
    for (n, (role, kind)) in out.iter_mut().zip(kinds) {
        if roles.contains(&role) {
            *n = queue::takeable(tx, &project, &user, roles, kind, now)?;
        }
    }
    Ok(out)
}
