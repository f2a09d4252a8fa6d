//! Accepted labels that are questioned later, for example by a model that was trained on the others: returns them to
//! their author, in the task from which they came.

use crate::domain::workflow::{self, Action, Actor, Draw, Role, Seen, State};
use crate::problem::Answer;
use crate::service::history;
use crate::service::tasks::{self, Entry};
use crate::store::{Store, Tx};
use crate::values;
use serde_json::Value;

/// A label to review.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// Task of the label.
    pub task: String,
    /// The questioned label.
    pub label: Value,
    /// The reason; stored in the task's history.
    pub note: String,
}

/// Result of a request for review.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Review {
    /// The accepted label was returned for rework, with the note.
    Reopened,
    /// The task is in progress or waits in the workflow: nothing was changed.
    InWork,
    /// The accepted label differs from the questioned one: nothing was changed.
    Changed,
    /// The task was skipped or rejected since: nothing was changed.
    LeftOut,
    /// The store has no such task.
    Unknown,
}

/// Reopens the task of each request whose accepted label is still the questioned one; returns one result per request,
/// in their order. All changes are in one transaction.
pub fn ask(store: &Store, doubts: &[Doubt], now: i64) -> Answer<Vec<Review>> {
    let doubts = doubts.to_vec();
    store.write(move |tx| doubts.iter().map(|doubt| reopen(tx, doubt, now)).collect())
}

fn reopen(tx: &mut dyn Tx, doubt: &Doubt, now: i64) -> Answer<Review> {
    if tx.row("SELECT 1 FROM tasks WHERE id = $1", values![&doubt.task])?.is_none() {
        return Ok(Review::Unknown);
    }
    let mut t = tasks::get_for_change(tx, &doubt.task)?;
    match t.at.state {
        State::Accepted if t.draft != doubt.label => return Ok(Review::Changed),
        State::Accepted => {}
        State::Skipped | State::Rejected => return Ok(Review::LeftOut),
        _ => return Ok(Review::InWork),
    }
    // The command line acts for the operator of the service.
    let operator = Actor { id: String::new(), roles: vec![Role::Lead], has_seen: Seen::Future };
    let from = t.at.state;
    t.at = workflow::step(&t.at, &operator, Action::Reopen, Draw::Pass)?;
    t.lease_until = None;
    let entry = Entry {
        action: Action::Reopen.word(),
        from: Some(from),
        note: Some(&doubt.note),
        ..Entry::default()
    };
    history::record(tx, &mut t, &entry, now)?;
    tasks::update(tx, &t)?;
    Ok(Review::Reopened)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::workflow::Position;
    use crate::service::create;
    use crate::service::fixtures::{self, task};
    use crate::service::tasks::TaskRow;
    use crate::service::transfer::{ExportFormat, export};
    use serde_json::json;

    fn put(store: &Store, id: &str, state: State) {
        let mut t = TaskRow { id: id.into(), draft: json!({ "coc_trace": id }), seq: 0, ..task() };
        t.episode.episode_id = id.into();
        store
            .write(move |tx| {
                create::store(tx, t.clone(), None, 5)?;
                let mut t = tasks::get_for_change(tx, &t.id)?;
                t.at = Position { state, authors: vec!["ann".into()], checked: true, ..Position::open() };
                tasks::update(tx, &t)
            })
            .unwrap();
    }

    fn doubt(id: &str, trace: &str) -> Doubt {
        Doubt { task: id.into(), label: json!({ "coc_trace": trace }), note: "leaf: a, rather b".into() }
    }

    #[test]
    fn only_the_accepted_label_that_is_doubted_is_reopened() {
        let (app, _dir) = fixtures::app();
        for (id, state) in
            [("a", State::Accepted), ("b", State::Accepted), ("c", State::Submitted), ("d", State::Rejected)]
        {
            put(&app.store, id, state);
        }
        let doubts =
            [doubt("a", "a"), doubt("b", "older"), doubt("c", "c"), doubt("d", "d"), doubt("e", "e")];
        let done = ask(&app.store, &doubts, 9).unwrap();
        use Review::{Changed, InWork, LeftOut, Reopened, Unknown};
        assert_eq!(done, [Reopened, Changed, InWork, LeftOut, Unknown]);
        let t = app.store.read(|tx| tasks::get(tx, "a")).unwrap();
        // Returned to its author, as a rework that must be checked again; the label itself is unchanged.
        assert_eq!((t.at.state, t.at.author(), t.at.checked), (State::Rework, Some("ann"), false));
        assert_eq!(t.draft, json!({ "coc_trace": "a" }));
        let text = export(&app.store, "p", &ExportFormat::Tasks).unwrap();
        let line: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
        let last = line["task"]["history"].as_array().unwrap().last().unwrap().clone();
        assert_eq!((&last["action"], &last["note"]), (&json!("reopen"), &json!("leaf: a, rather b")));
        assert_eq!(ask(&app.store, &doubts[..1], 10).unwrap(), [InWork], "a second time changes nothing");
    }
}
