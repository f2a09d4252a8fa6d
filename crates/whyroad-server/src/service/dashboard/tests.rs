//! Hand-written tasks and histories; expected values counted by hand.

use super::*;
use crate::domain::project::WaitingLabels;
use crate::service::fixtures::{self, episode};
use crate::values;
use serde_json::json;

const NOW: i64 = 1_790_000_000_000;

fn project(quota: &[(&str, u32)]) -> Project {
    Project {
        id: "p".into(),
        name: "p".into(),
        guide: String::new(),
        quota: quota.iter().map(|(k, n)| ((*k).to_owned(), *n)).collect(),
        settings: Settings::default(),
        roles: vec![],
    }
}

struct Made<'a> {
    id: &'a str,
    episode: &'a str,
    leaf: &'a str,
    state: &'a str,
    author: Option<&'a str>,
    updated: i64,
    overlap: i64,
}

fn task(tx: &mut dyn Tx, m: &Made<'_>, draft: &Value) {
    tx.run(
        "INSERT INTO tasks (id, project_id, episode_id, overlap_index, overlap_count, drive_id, clip_id, scenario_id,
           keyframe_ns, from_ns, to_ns, episode, initial, draft, version, priority, state, authors, author, checked,
           audited, fence, seq, created, updated)
         VALUES ($1, 'p', $2, $3, $4, 'd', 'd_000', $5, 0, 0, 0, $6, '{}', $7, 0, 0, $8, $9, $10, 0, 0, 0, 0, 0, $11)",
        values![
            m.id, m.episode, m.id.len() as i64, m.overlap, m.leaf, episode(m.episode).to_string(), draft.to_string(),
            m.state, json!(m.author.into_iter().collect::<Vec<_>>()).to_string(), m.author, m.updated
        ],
    )
    .unwrap();
}

fn history(
    tx: &mut dyn Tx,
    task: &str,
    seq: i64,
    at: i64,
    actor: &str,
    (from, action): (&str, &str),
    draft: Option<&Value>,
) {
    tx.run(
        "INSERT INTO history (task_id, seq, at, actor, action, from_state, snapshot, version) VALUES ($1, $2, $3, $4, $5, $6, $7, 0)",
        values![task, seq, at, actor, action, from, draft.map(Value::to_string)],
    )
    .unwrap();
    // Counted in the same way as when an entry is recorded.
    crate::service::history::count(tx, "p", (Some(actor), action), at).unwrap();
}

/// A store with a project and the users `a`, `b`, `c`, with the display names `Ann`, `Bo`, `Cy`.
fn on_store<T: Send + 'static>(job: impl Fn(&mut dyn Tx) -> T + Send + 'static) -> T {
    let (app, _dir) = fixtures::app();
    app.store
        .write(move |tx| {
            for (id, display) in [("a", "Ann"), ("b", "Bo"), ("c", "Cy")] {
                tx.run(
                    "INSERT INTO users (id, name, display, admin, lang, password_hash, disabled, created)
                     VALUES ($1, $2, $3, 0, 'en', '', 0, 0)",
                    values![id, id, display],
                )?;
            }
            Ok(job(tx))
        })
        .unwrap()
}

fn made<'a>(id: &'a str, episode: &'a str, state: &'a str) -> Made<'a> {
    Made { id, episode, leaf: "x.y.z", state, author: Some("a"), updated: NOW, overlap: 1 }
}

fn label(longitudinal: &str, lateral: &str, keyframe: &str) -> Value {
    json!({ "driving_decision": { "longitudinal": longitudinal, "lateral": lateral }, "keyframe": { "timestamp": keyframe } })
}

#[test]
fn coverage_counts_episodes_once_and_only_those_that_can_be_accepted() {
    let rows = on_store(|tx| {
        task(tx, &Made { overlap: 2, ..made("1", "e1", "accepted") }, &json!({}));
        task(tx, &Made { overlap: 2, ..made("22", "e1", "accepted") }, &json!({}));
        task(tx, &made("333", "e2", "open"), &json!({}));
        task(tx, &Made { leaf: "x.y.other", ..made("4444", "e3", "stage2") }, &json!({}));
        // Nobody will label these: they are no supply.
        task(tx, &made("55555", "e4", "skipped"), &json!({}));
        task(tx, &made("666666", "e5", "rejected"), &json!({}));
        coverage(tx, &project(&[("x.y.z", 5), ("x.never", 3)])).unwrap()
    });
    let rows: Vec<_> =
        rows.iter().map(|c| (c.leaf.as_str(), c.have, c.quota, c.mined, c.shortfall)).collect();
    assert_eq!(rows, [("x.never", 0, 3, 0, 3), ("x.y.other", 0, 0, 1, 0), ("x.y.z", 1, 5, 2, 3)]);
}

#[test]
fn coverage_of_a_veiled_class_does_not_tell_its_variants() {
    let one =
        |leaf: &str, mined| Coverage { leaf: leaf.into(), have: 1, quota: 4, mined, shortfall: 4 - mined };
    let all = vec![one("x.y.a", 2), one("x.ya.b", 1), one("x.y.c", 1), one("x.y", 0)];
    let shown = veil_coverage(all, &["x.y".into()]);
    let rows: Vec<_> =
        shown.iter().map(|c| (c.leaf.as_str(), c.have, c.quota, c.mined, c.shortfall)).collect();
    assert_eq!(rows, [("x.y", 3, 12, 3, 9), ("x.ya.b", 1, 4, 1, 3)]);
}

#[test]
fn throughput_is_by_day_person_and_action_and_ageing_by_rest() {
    let board = on_store(|tx| {
        task(tx, &Made { updated: NOW - 7_200_000, ..made("1", "e1", "stage2") }, &json!({}));
        task(tx, &Made { updated: NOW - 3_600_000, author: None, ..made("22", "e2", "open") }, &json!({}));
        task(tx, &made("333", "e3", "accepted"), &json!({}));
        // The other label of its episode was chosen: nobody waits for it.
        let old = Made { overlap: 2, updated: NOW - 9_000_000, ..made("4444", "e3", "submitted") };
        task(tx, &old, &json!({}));
        tx.run("UPDATE tasks SET adjudication = 'superseded' WHERE id = '4444'", &[]).unwrap();
        // 2026-09-21 UTC began at 1 789 948 800 s (`date -u -d 2026-09-21 +%s`).
        let midnight = 1_789_948_800_000;
        history(tx, "1", 1, midnight - 1, "a", ("stage2", "submit"), None);
        history(tx, "1", 2, midnight, "a", ("stage2", "submit"), None);
        history(tx, "1", 3, midnight + 5, "a", ("rework", "submit"), None);
        history(tx, "1", 4, midnight + 6, "b", ("in_check", "accept"), None);
        history(tx, "1", 5, midnight + 7, "b", ("stage1", "edit"), None);
        history(tx, "1", 6, NOW - 70 * DAY_MS, "a", ("stage2", "submit"), None);
        of(tx, &project(&[]), NOW).unwrap()
    });
    let rows: Vec<_> = board
        .throughput
        .iter()
        .map(|t| (t.day.as_str(), t.user.as_str(), t.action.as_str(), t.count))
        .collect();
    assert_eq!(
        rows,
        [
            ("2026-09-21", "Ann", "submit", 2),
            ("2026-09-21", "Bo", "accept", 1),
            ("2026-09-20", "Ann", "submit", 1)
        ]
    );
    let rows: Vec<_> = board.ageing.iter().map(|a| (a.task.as_str(), a.user.as_deref(), a.hours)).collect();
    assert_eq!(rows, [("1", Some("Ann"), 2.0), ("22", None, 1.0)]);
    assert_eq!((board.by_state.get("accepted"), board.by_state.get("submitted")), (Some(&1), None));
}

/// docs/reference/service.md: labels of which another one was chosen are in no count by state; of those that are handed
/// in, only single labels and chosen ones can be checked. Counted by hand.
#[test]
fn labels_that_nobody_can_check_are_not_shown_as_waiting_for_a_check() {
    let (board, all, listed, hidden, own) = on_store(|tx| {
        let copy = |id: &'static str, episode: &'static str, state: &'static str, hours: i64| Made {
            overlap: 3,
            updated: NOW - hours * 3_600_000,
            ..made(id, episode, state)
        };
        // One label of one person, to be checked.
        task(tx, &Made { updated: NOW - 3_600_000, ..made("1", "e1", "submitted") }, &json!({}));
        // All handed in, none chosen: a lead waits since the last of them, 4 h ago.
        for (id, hours) in [("22", 9), ("333", 4), ("4444", 6)] {
            task(tx, &copy(id, "e2", "submitted", hours), &json!({}));
        }
        // Chosen, and overruled.
        for (id, state, outcome) in [
            ("55555", "submitted", "chosen"),
            ("666666", "submitted", "superseded"),
            ("7777777", "submitted", "superseded"),
        ] {
            task(tx, &copy(id, "e3", state, 2), &json!({}));
            tx.run("UPDATE tasks SET adjudication = $1 WHERE id = $2", values![outcome, id]).unwrap();
        }
        // Handed in; another copy is still being labeled.
        task(tx, &copy("88888888", "e4", "submitted", 8), &json!({}));
        task(tx, &copy("999999999", "e4", "stage1", 5), &json!({}));
        tx.run("UPDATE tasks SET complete = 1 WHERE episode_id = 'e2'", &[]).unwrap();
        let board = of(tx, &project(&[]), NOW).unwrap();
        // Another project, for the metrics.
        tx.run(
            "INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('q', 'q', '', '{}', '{}', 0)",
            &[],
        )
        .unwrap();
        task(tx, &made("1010101010", "e5", "open"), &json!({}));
        tx.run("UPDATE tasks SET project_id = 'q' WHERE id = '1010101010'", &[]).unwrap();
        let all = by_state::of_all(tx).unwrap();
        let count =
            |tx: &mut dyn Tx, state| crate::service::transfer::tasks_of(tx, "p", state).unwrap().len();
        let listed = (count(tx, Some("submitted")), count(tx, None));
        // A copy of e3 that a person labels hides the labels of e3 from them.
        let hidden = {
            task(tx, &made("11111111111", "e3~1", "open"), &json!({}));
            tx.run(
                "INSERT INTO gold (task_id, project_id, user_id, source_task, answer, created)
                 VALUES ('11111111111', 'p', 'b', '55555', '{}', 0)",
                &[],
            )
            .unwrap();
            let roles = [crate::domain::workflow::Role::Annotator, crate::domain::workflow::Role::Checker];
            crate::service::recognized::Hidden::of(tx, "p", "b", &roles).unwrap()
        };
        // Of the author of all copies of e3, two overruled.
        let own = crate::service::work::of(tx, "p", "a", &[], NOW).unwrap().mine.waiting;
        (board, all, listed, hidden, own)
    });
    assert_eq!(own, 6, "as by state: an overruled label waits for nothing");
    let state = |of: &BTreeMap<String, i64>, word: &str| of.get(word).copied().unwrap_or(0);
    assert_eq!((state(&board.by_state, "submitted"), state(&board.by_state, "stage1")), (6, 1));
    let waiting = |check, choice, other_labels| WaitingLabels { check, choice, other_labels };
    assert_eq!(board.submitted, waiting(2, 3, 1));
    assert_eq!((state(&all, "submitted"), state(&all, "stage1"), state(&all, "open")), (6, 1, 1));
    assert_eq!(listed, (6, 9), "all are listed without a filter");
    let rows: Vec<_> =
        board.ageing.iter().map(|a| (a.task.as_str(), a.to_choose, a.user.as_deref(), a.hours)).collect();
    assert_eq!(
        rows,
        [
            ("999999999", false, Some("Ann"), 5.0),
            ("333", true, None, 4.0),
            ("55555", false, Some("Ann"), 2.0),
            ("1", false, Some("Ann"), 1.0)
        ]
    );
    let seen = hidden.from_dashboard(board);
    assert_eq!((state(&seen.by_state, "submitted"), seen.submitted), (5, waiting(1, 3, 1)));
}

#[test]
fn agreement_is_that_of_the_first_submissions() {
    let found = on_store(|tx| {
        let t = |s: &str| format!("2026-01-01T00:00:{s}Z");
        let pairs = [
            ("e1", label("stop", "null", &t("10.000")), label("stop", "null", &t("10.500"))),
            ("e2", label("yield", "null", &t("10.000")), label("yield", "null", &t("10.000"))),
            ("e3", label("stop", "null", &t("10.000")), label("yield", "null", &t("12.000"))),
            ("e4", label("yield", "null", &t("10.000")), label("yield", "null", &t("10.100"))),
        ];
        let names = ["1", "22", "333", "4444", "55555", "666666", "7777777", "88888888"];
        for (i, (episode, ours, theirs)) in pairs.iter().enumerate() {
            for (id, author, first) in [(names[2 * i], "a", ours), (names[2 * i + 1], "b", theirs)] {
                // After the check both are equal; only the first submission counts.
                let now = label("cruise", "null", &t("00.000"));
                task(tx, &Made { overlap: 2, author: Some(author), ..made(id, episode, "accepted") }, &now);
                history(tx, id, 1, 1, author, ("stage2", "submit"), Some(first));
                history(tx, id, 2, 2, author, ("rework", "submit"), Some(&now));
            }
        }
        // Alone in its group: nothing to compare.
        task(tx, &Made { overlap: 2, ..made("999999999", "e5", "submitted") }, &label("stop", "null", "-"));
        history(tx, "999999999", 1, 1, "a", ("stage2", "submit"), None);
        let names = tasks::names(tx).unwrap();
        agreement(tx, "p", &names).unwrap()
    });
    assert_eq!((found.pairs, found.groups), (4, 4));
    // By hand: a says stop 2, yield 2; b stop 1, yield 3; agree 3 of 4. pe = (2*1 + 2*3)/16 = 0.5; (0.75-0.5)/0.5.
    assert!((found.longitudinal_kappa.unwrap() - 0.5).abs() < 1e-12);
    // Fleiss: stop 3/8, yield 5/8; pe = 34/64; P = 3/4; (0.75 - 0.53125)/(1 - 0.53125).
    assert!((found.longitudinal_fleiss.unwrap() - 0.218_75 / 0.468_75).abs() < 1e-12);
    assert_eq!((found.lateral_kappa, found.lateral_fleiss), (None, None));
    assert!((found.keyframe_median_s.unwrap() - 0.3).abs() < 1e-9);
    assert!((found.keyframe_worst_s.unwrap() - 2.0).abs() < 1e-9);
    assert_eq!(found.by_pair.len(), 1);
    assert_eq!((found.by_pair[0].users.join(" "), found.by_pair[0].labels), ("Ann Bo".to_owned(), 4));
}

#[test]
fn audits_are_counted_by_author() {
    let rows = on_store(|tx| {
        task(tx, &made("1", "e1", "accepted"), &json!({}));
        task(tx, &Made { author: Some("b"), ..made("22", "e2", "rework") }, &json!({}));
        for seq in 1..=20 {
            let action = if seq == 3 { "send_back" } else { "accept" };
            history(tx, "1", seq, 1, "c", ("in_audit", action), None);
        }
        history(tx, "1", 21, 1, "c", ("in_check", "send_back"), None);
        history(tx, "22", 1, 1, "c", ("in_audit", "send_back"), None);
        let names = tasks::names(tx).unwrap();
        audit_outcomes(tx, &project(&[]), &names).unwrap()
    });
    let rows: Vec<_> =
        rows.iter().map(|a| (a.author.as_str(), a.audited, a.failed, a.share_percent)).collect();
    // One failure in twenty is a quarter of a poor record (0.2); Bo has no record yet.
    assert_eq!(rows, [("Ann", 20, 1, 12.5), ("Bo", 1, 1, 20.0)]);
    let share = |audited, failed| audit_share(&Settings::default(), audited, failed);
    // LABELING.md 6: 10 to 20 %.
    assert_eq!(
        [share(0, 0), share(50, 0), share(50, 5), share(50, 10), share(50, 50)],
        [20.0, 10.0, 15.0, 20.0, 20.0]
    );
}

fixtures::on_postgresql! {
    coverage_counts_episodes_once_and_only_those_that_can_be_accepted,
    coverage_of_a_veiled_class_does_not_tell_its_variants,
    throughput_is_by_day_person_and_action_and_ageing_by_rest,
    labels_that_nobody_can_check_are_not_shown_as_waiting_for_a_check,
    agreement_is_that_of_the_first_submissions,
    audits_are_counted_by_author,
}
