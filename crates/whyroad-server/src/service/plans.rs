//! Query plans of SQLite for frequent queries (<https://www.sqlite.org/eqp.html>). A row of a task has several
//! kilobytes; for a hundred thousand of them only an index may be read.

use crate::domain::project::HistoryRule;
use crate::service::{dashboard, disagreement, drafting, fixtures, seen};
use crate::store::Value;
use crate::values;

fn plan(sql: &str, values: &[Value]) -> Vec<String> {
    let (app, _dir) = fixtures::app();
    let plan = app.store.read(|tx| tx.rows(&format!("EXPLAIN QUERY PLAN {sql}"), values));
    plan.unwrap().iter().map(|r| r.text("detail").unwrap()).collect()
}

/// How the tasks are read.
fn read_for(sql: &str, values: &[Value]) -> Vec<String> {
    plan(sql, values).into_iter().filter(|l| l.contains("tasks")).collect()
}

#[test]
fn pending_tasks_are_read_from_their_index() {
    let both: [(&str, &[Value]); 2] =
        [(drafting::NEXT, values![1_i64, 64_i64]), (drafting::COUNT, values!["p", 1_i64])];
    for (sql, values) in both {
        let lines = read_for(sql, values);
        assert!(
            matches!(&lines[..], [one] if one.contains("USING COVERING INDEX tasks_pending")),
            "{lines:?}"
        );
    }
}

#[test]
fn coverage_is_read_from_its_index() {
    let lines = read_for(&dashboard::coverage_sql(), values!["p"]);
    assert!(matches!(&lines[..], [one] if one.contains("USING COVERING INDEX tasks_coverage")), "{lines:?}");
}

#[test]
fn audits_are_found_by_author() {
    let sql = dashboard::audits_sql("t.author = $2");
    let lines = plan(&sql, values!["p", "a"]);
    for index in ["tasks_author (project_id=? AND author=?)", "history_audit (task_id=?)"] {
        assert!(lines.iter().any(|l| l.contains(index)), "{index}: {lines:?}");
    }
}

#[test]
fn groups_without_a_choice_are_counted_from_their_index() {
    let sql =
        format!("SELECT count(*) AS n FROM tasks WHERE project_id = $1 AND {}", disagreement::TO_CHOOSE);
    let lines = read_for(&sql, values!["p"]);
    assert!(matches!(&lines[..], [one] if one.contains("USING COVERING INDEX tasks_to_choose")), "{lines:?}");
}

#[test]
fn a_service_that_starts_reads_no_ordinary_task() {
    let lines = read_for(&disagreement::not_compared(), &[]);
    assert!(
        matches!(&lines[..], [one] if one.contains("USING COVERING INDEX tasks_not_compared")),
        "{lines:?}"
    );
}

#[test]
fn what_a_user_has_in_hand_is_read_from_its_index() {
    let lines = read_for(seen::IN_HAND_BEFORE, values!["u", "d", "t", 2_i64, 1_i64]);
    assert!(matches!(&lines[..], [one] if one.contains("USING COVERING INDEX tasks_in_hand")), "{lines:?}");
    let hidden = seen::hidden_in_stage1(HistoryRule::Drive).replace('$', "$2");
    let sql = format!("SELECT count(*) FROM tasks WHERE project_id = $1 AND {hidden}");
    let lines = plan(&sql, values!["p", "u"]);
    for index in ["SEARCH h USING COVERING INDEX tasks_in_hand", "SEARCH t USING INDEX tasks_drive"] {
        assert!(lines.iter().any(|l| l.contains(index)), "{index}: {lines:?}");
    }
    // Once, not for each task of the project.
    assert!(!lines.iter().any(|l| l.contains("CORRELATED")), "{lines:?}");
}
