//! Actions that a user may do with a task now, as identifiers by which the page shows buttons. Determined by calling
//! the workflow itself.

use crate::domain::workflow::{self, Action, Actor, Draw, Role, State};
use crate::problem::Answer;
use crate::service::tasks::TaskRow;
use crate::service::{actions, leases, safety};
use crate::store::Tx;

/// Actions that the workflow allows, and `edit`, `safety`, `uncertainty` (of frozen components), `comment`, `assign`,
/// `adjudicate`, `reclass`.
pub fn of(tx: &mut dyn Tx, t: &TaskRow, actor: &Actor) -> Answer<Vec<String>> {
    let mut out: Vec<String> = Action::ALL
        .iter()
        .filter(|a| workflow::step(&t.at, actor, **a, Draw::Pass).is_ok())
        .filter(|a| **a != Action::Take || !leases::waits_for_choice(t))
        .map(|a| a.word().to_owned())
        .collect();
    let mut add = |word: &str, allowed: bool| {
        if allowed {
            out.push(word.to_owned());
        }
    };
    let holds = t.at.holder.as_deref() == Some(actor.id.as_str());
    let lead = actor.is(Role::Lead);
    let labels = holds && actor.is(Role::Annotator);
    add("edit", labels && t.at.state.is_editable());
    add("safety", labels && safety::applies(t.at.state));
    add("uncertainty", labels && t.veiled && t.at.state == State::Stage2);
    add("restore", labels && t.at.state.is_editable());
    add("comment", holds || t.at.state.shows_future());
    add("assign", lead && !matches!(t.at.state, State::Accepted));
    let may_end = matches!(t.at.state, State::Skipped | State::Rejected)
        || workflow::step(&t.at, actor, Action::Skip, Draw::Pass).is_ok();
    add("reclass", lead && t.replaced_by.is_none() && may_end);
    let may_choose = lead && t.overlap_count > 1 && t.at.state.stage() == workflow::Stage::Stage2;
    add("adjudicate", may_choose && actions::group_is_ready(tx, t)?);
    Ok(out)
}
