//! The workflow on random paths. The invariants are computed here from the accepted actions alone, not from the fields
//! that the workflow keeps.

use super::*;
use proptest::prelude::*;

const USERS: usize = 5;

#[derive(Clone, Debug)]
struct Move {
    user: usize,
    action: Action,
    draw: Draw,
}

fn moves() -> impl Strategy<Value = Vec<Move>> {
    let action = proptest::sample::select(Action::ALL.to_vec());
    // Most paths need `Take` most often.
    let action = prop_oneof![2 => action, 1 => Just(Action::Take)];
    let one = (0..USERS, action, any::<bool>()).prop_map(|(user, action, audit)| Move {
        user,
        action,
        draw: if audit { Draw::Audit } else { Draw::Pass },
    });
    proptest::collection::vec(one, 0..120)
}

fn roles() -> impl Strategy<Value = Vec<Vec<Role>>> {
    let some = proptest::sample::subsequence(Role::ALL.to_vec(), 0..=4);
    proptest::collection::vec(some, USERS)
}

/// What an independent observer records about a task.
#[derive(Default)]
struct Onlooker {
    /// Users who held it while it was editable since it was last opened.
    writers: Vec<usize>,
    /// User who accepted the last submission as its checker.
    checked_by: Option<usize>,
    /// Users who were ever shown the future.
    saw: Vec<usize>,
}

fn play(roles: &[Vec<Role>], moves: &[Move]) -> Result<usize, TestCaseError> {
    let mut at = Position::open();
    let mut seen = Onlooker::default();
    let mut accepted = 0;
    for m in moves {
        let knows = if seen.saw.contains(&m.user) { Seen::Future } else { Seen::History };
        let actor = Actor { id: m.user.to_string(), roles: roles[m.user].clone(), has_seen: knows };
        let Ok(next) = step(&at, &actor, m.action, m.draw) else { continue };
        match (m.action, next.state) {
            (Action::Take, State::Stage1) => {
                prop_assert!(!seen.saw.contains(&m.user), "Stage I by one who knows the future");
                seen.writers.push(m.user);
            }
            (Action::Take, State::Stage2 | State::Rework) => {
                prop_assert!(seen.writers.contains(&m.user), "Stage II by one who did not do Stage I");
            }
            (Action::Take, State::InCheck | State::InAudit) => {
                prop_assert!(!seen.writers.contains(&m.user), "judged by a writer");
            }
            (Action::Submit, _) => seen.checked_by = None,
            (Action::Accept, _) if at.state == State::InCheck => {
                prop_assert!(!seen.writers.contains(&m.user), "checked by a writer");
                prop_assert!(roles[m.user].contains(&Role::Checker));
                seen.checked_by = Some(m.user);
            }
            (Action::Accept, _) => {
                prop_assert_eq!(at.state, State::InAudit);
                prop_assert!(seen.checked_by != Some(m.user), "audited by the checker");
            }
            (Action::SendBack, _) => seen.checked_by = None,
            (Action::Reopen, State::Open) => seen = Onlooker { saw: seen.saw, ..Onlooker::default() },
            (Action::Reopen, _) => seen.checked_by = None,
            _ => {}
        }
        if next.state == State::Accepted {
            prop_assert!(seen.checked_by.is_some(), "accepted without a check");
            accepted += 1;
        }
        if let Some(holder) = next.holder.as_ref().filter(|_| next.state.shows_future()) {
            seen.saw.push(holder.parse().unwrap());
        }
        prop_assert_eq!(next.holder.is_some() && !next.state.is_held(), false, "held where nobody works");
        at = next;
    }
    Ok(accepted)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn no_path_breaks_what_must_hold(roles in roles(), moves in moves()) {
        play(&roles, &moves)?;
    }
}

fn moves_of(text: &[(usize, Action)], draw: Draw) -> Vec<Move> {
    text.iter().map(|(user, action)| Move { user: *user, action: *action, draw }).collect()
}

#[test]
fn the_plain_path_and_the_one_through_rework_and_audit_reach_accepted() {
    use Action::*;
    let all = vec![Role::ALL.to_vec(); USERS];
    let plain = [(0, Take), (0, LockStage1), (0, Submit), (1, Take), (1, Accept)];
    assert_eq!(play(&all, &moves_of(&plain, Draw::Pass)).unwrap(), 1);
    let long = [
        (0, Take),
        (0, LockStage1),
        (0, Submit),
        (1, Take),
        (1, SendBack),
        (0, Take),
        (0, Submit),
        (2, Take),
        (2, Accept),
        (3, Take),
        (3, Accept),
    ];
    assert_eq!(play(&all, &moves_of(&long, Draw::Audit)).unwrap(), 1);
    // Nobody else can replace the checker, nor the checker the auditor.
    let own = [(0, Take), (0, LockStage1), (0, Submit), (0, Take), (0, Accept)];
    assert_eq!(play(&all, &moves_of(&own, Draw::Pass)).unwrap(), 0);
    let same = [(0, Take), (0, LockStage1), (0, Submit), (1, Take), (1, Accept), (1, Take), (1, Accept)];
    assert_eq!(play(&all, &moves_of(&same, Draw::Audit)).unwrap(), 0);
}

#[test]
fn words_round_trip() {
    for s in State::ALL {
        assert_eq!(State::from_word(s.word()), Some(*s));
        assert_eq!(serde_json::to_value(s).unwrap(), s.word());
    }
}

/// Messages of the service name states, actions and roles as the page does.
#[test]
fn names_are_those_of_the_page() {
    let page = concat!(
        include_str!("../../../../../web/src/text/screen_texts.ts"),
        include_str!("../../../../../web/src/text/label_texts.ts")
    );
    let is_on_page = |key: &str, name: Bilingual| {
        let line = format!("\"{key}\": [\"{}\"", name.zh);
        assert!(page.contains(&line), "{line}");
    };
    let word = |value: serde_json::Value| value.as_str().unwrap().to_owned();
    for state in State::ALL {
        is_on_page(&format!("state.{}", word(serde_json::json!(state))), state.name());
    }
    for action in Action::ALL {
        is_on_page(&format!("act.{}", word(serde_json::json!(action))), action.name());
    }
    for role in Role::ALL {
        is_on_page(&format!("role.{}", word(serde_json::json!(role))), role.name());
    }
}
