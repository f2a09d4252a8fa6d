//! Export and import on hand-made tasks; round trips over real drives are in the binary's tests.

use super::*;
use crate::service::fixtures::{self, task};
use crate::service::history;
use crate::service::tasks::Entry;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};
use whyroad_label::merge::FieldChange;

fn label(trace: &str) -> Value {
    json!({
        "version": "2.1.0", "clip_id": "d_000",
        "scenario": {"l1": "reactive_agent", "l2": "cutin", "l3": "normal"},
        "time_range": {"start_timestamp": "2026-01-01T00:00:01.000Z", "end_timestamp": "2026-01-01T00:00:05.000Z"},
        "keyframe": {"timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive"},
        "driving_decision": {"longitudinal": null, "lateral": null},
        "critical_components": [{"description": "x", "id": "c1"}], "coc_trace": trace,
        "causes": {"longitudinal": {"components": ["c1"]}},
    })
}

fn stored(tx: &mut dyn Tx, id: &str, state: State, adjudication: Option<&str>) {
    let mut t = TaskRow { id: id.into(), draft: label(id), seq: 0, ..task() };
    t.episode.episode_id = id.into();
    assert!(create::store(tx, t.clone(), None, 5).unwrap());
    t.seq = 1;
    t.at.state = state;
    t.adjudication = adjudication.map(str::to_owned);
    if adjudication.is_some() {
        tx.run("UPDATE tasks SET overlap_count = 2 WHERE id = $1", values![id]).unwrap();
    }
    let change = FieldChange { path: "/coc_trace".into(), value: json!(id), remove: false };
    let entry = Entry { action: "edit", changes: &[change], note: Some("why"), ..Entry::default() };
    history::record(tx, &mut t, &entry, 7).unwrap();
    tasks::update(tx, &t).unwrap();
}

fn exported(words: (Option<&str>, Option<&str>, Option<&str>)) -> Vec<Value> {
    let (app, _dir) = fixtures::app();
    app.store
        .write(|tx| {
            stored(tx, "a", State::Accepted, None);
            stored(tx, "b", State::Accepted, Some("superseded"));
            stored(tx, "c", State::Submitted, None);
            Ok(())
        })
        .unwrap();
    let format = ExportFormat::from_words(words.0, words.1, words.2).unwrap();
    let text = export(&app.store, "p", &format).unwrap();
    assert!(text.is_empty() || text.ends_with('\n'));
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn accepted_labels_go_out_in_either_format() {
    assert_eq!(exported((None, None, None)), [label("a")]);
    let old = exported((Some("labels"), Some("2.0"), None));
    assert_eq!(old[0]["version"], "2.0.0");
    assert!(old[0].get("causes").is_none() && old[0]["critical_components"][0].get("id").is_none());
    assert_eq!(exported((None, None, Some("submitted"))), [label("c")]);
    assert_eq!(exported((None, None, Some("accepted,submitted"))).len(), 2);
    assert!(exported((None, None, Some("rework"))).is_empty());
}

#[test]
fn of_several_labels_of_an_episode_only_the_chosen_one_goes_out() {
    let (app, _dir) = fixtures::app();
    let words = |states: Option<&str>| ExportFormat::from_words(None, None, states).unwrap();
    let count = |store: &Store, states| store.read(|tx| not_chosen(tx, "p", &words(states))).unwrap();
    app.store
        .write(|tx| {
            stored(tx, "alone", State::Accepted, None);
            stored(tx, "chosen", State::Accepted, Some("chosen"));
            // Two labels of one episode that were accepted before a choice was required.
            for (id, index) in [("first", 0), ("second", 1)] {
                stored(tx, id, State::Accepted, None);
                let sql =
                    "UPDATE tasks SET overlap_count = 2, overlap_index = $1, episode_id = 'e' WHERE id = $2";
                tx.run(sql, values![index, id])?;
            }
            Ok(())
        })
        .unwrap();
    let exported = |store: &Store| {
        let text = export(store, "p", &words(None)).unwrap();
        let trace =
            |l: &str| serde_json::from_str::<Value>(l).unwrap()["coc_trace"].as_str().unwrap().to_owned();
        let mut traces: Vec<String> = text.lines().map(trace).collect();
        traces.sort();
        traces
    };
    assert_eq!(exported(&app.store), ["alone", "chosen"]);
    assert_eq!((count(&app.store, None), count(&app.store, Some("submitted"))), (1, 0));
    let report = report_not_chosen(1);
    assert_eq!(report.code, NOT_CHOSEN);
    let hint = report.hint.unwrap();
    assert!(hint.en.contains("to choose") && hint.zh.contains("待采用"), "{hint:?}");
    let whole = ExportFormat::from_words(Some("tasks"), None, None).unwrap();
    assert_eq!(export(&app.store, "p", &whole).unwrap().lines().count(), 4);
    assert_eq!(app.store.read(|tx| not_chosen(tx, "p", &whole)).unwrap(), 0);
    app.store
        .write(|tx| {
            tx.run("UPDATE tasks SET adjudication = 'superseded' WHERE id = 'first'", &[])?;
            tx.run("UPDATE tasks SET adjudication = 'chosen' WHERE id = 'second'", &[])
        })
        .unwrap();
    assert_eq!(exported(&app.store), ["alone", "chosen", "second"]);
    assert_eq!(count(&app.store, None), 0);
}

#[test]
fn tasks_go_out_with_their_history() {
    let all = exported((Some("tasks"), None, None));
    assert_eq!(all.len(), 3);
    let t = &all[0]["task"];
    assert_eq!((&t["state"], &t["episode"]["episode_id"]), (&json!("accepted"), &json!("a")));
    let actions: Vec<&str> =
        t["history"].as_array().unwrap().iter().map(|h| h["action"].as_str().unwrap()).collect();
    assert_eq!(actions, ["create", "edit"]);
    assert_eq!(t["history"][1]["changes"][0]["path"], "/coc_trace");
    assert_eq!((&t["history"][1]["note"], &t["history"][1]["at"]), (&json!("why"), &json!(7)));
}

#[test]
fn a_long_history_goes_out_whole_and_in_order() {
    let (app, _dir) = fixtures::app();
    // Longer than the entries that are read together, and than the part that is read in one transaction.
    let text = "x".repeat(2000);
    app.store
        .write(move |tx| {
            for id in ["a", "b"] {
                stored(tx, id, State::Stage2, None);
                let mut t = tasks::get(tx, id)?;
                for n in 0..333 {
                    let value = json!(format!("{n} {text}"));
                    let change = FieldChange { path: "/coc_trace".into(), value, remove: false };
                    let entry = Entry { action: "edit", changes: &[change], ..Entry::default() };
                    history::record(tx, &mut t, &entry, 9)?;
                }
                tasks::update(tx, &t)?;
            }
            Ok(())
        })
        .unwrap();
    let text = export(&app.store, "p", &ExportFormat::Tasks).unwrap();
    let lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    for line in &lines {
        let history = line["task"]["history"].as_array().unwrap();
        let seqs: Vec<i64> = history.iter().map(|h| h["seq"].as_i64().unwrap()).collect();
        assert_eq!(seqs, (1..=335).collect::<Vec<i64>>());
        let last = history.last().unwrap()["changes"][0]["value"].as_str().unwrap();
        assert!(last.starts_with("332 x"), "{last}");
    }
}

#[test]
fn odd_words_are_refused() {
    for words in [(Some("csv"), None, None), (None, Some("3"), None), (None, None, Some("done"))] {
        assert_eq!(ExportFormat::from_words(words.0, words.1, words.2).unwrap_err().code, "request.invalid");
    }
}

#[test]
fn lines_that_cannot_come_in_are_named_and_do_not_stop_the_rest() {
    let (app, _dir) = fixtures::app();
    let text = format!("nonsense\n\n{}\n{}\n", label("t"), json!({"other": 1}));
    let made = import(&app, "p", &text, None).unwrap();
    assert_eq!((made.tasks, made.known), (0, 0));
    let lines: Vec<u32> = made.lost.iter().map(|l| l.line).collect();
    // The label is valid, but there is no drive `d` here.
    assert_eq!((lines, made.more), (vec![1, 3, 4], 0));
    let why = &made.lost[1].text;
    assert!(why.en.contains("drive") && why.zh.contains("行程"), "{why:?}");
    let made = import(&app, "p", &"{}\n".repeat(103), None).unwrap();
    assert_eq!((made.lost.len(), made.more), (100, 3), "many are counted");
    let many = "{}\n".repeat(MOST_LINES + 1);
    assert_eq!(import(&app, "p", &many, None).unwrap_err().code, "request.invalid");
}

#[test]
fn many_labels_of_a_drive_read_it_once_and_derive_nothing() {
    let (app, recordings, _dir) = fixtures::counted();
    // Lines of two drives in alternation, as other tools write them.
    let line = |i: usize| {
        let mut label = label(&format!("trace {i}"));
        label["clip_id"] = json!(format!("{}_000", ["d", "e"][i % 2]));
        label["keyframe"]["timestamp"] = json!(format!("2026-01-01T00:00:02.{i:03}Z"));
        format!("{label}\n")
    };
    let text: String = (0..40).map(line).collect();
    assert_eq!(import(&app, "p", &text, None).unwrap().tasks, 40);
    let count = |n: &AtomicUsize| n.load(Ordering::SeqCst);
    assert_eq!((count(&recordings.read), count(&recordings.derived)), (2, 0));
    let stored = app.store.read(|tx| tasks_of(tx, "p", None)).unwrap();
    assert_eq!(stored.iter().filter(|t| t.drive_id == "e").count(), 20);
    assert_eq!(import(&app, "p", &text, None).unwrap().known, 40, "the same again makes nothing");
    // The last line once more, with one whose time is not in its drive.
    let mut late = label("late");
    late["keyframe"]["timestamp"] = json!("2026-01-01T01:00:00.000Z");
    let made = import(&app, "p", &format!("{late}\n"), None).unwrap();
    assert!(made.lost[0].text.en.contains("outside the drive"), "{:?}", made.lost);
}

#[test]
fn many_episodes_of_a_drive_derive_it_once_beside_their_own_history() {
    let (app, recordings, _dir) = fixtures::counted();
    let text: String = (0..10).map(|i| format!("{}\n", fixtures::episode(&format!("e{i}")))).collect();
    assert_eq!(import(&app, "p", &text, None).unwrap().tasks, 10);
    // Once for the whole drive, and once per task up to its keyframe.
    assert_eq!(recordings.derived.load(Ordering::SeqCst), 11);
}

/// docs/how-to/manage-tasks.md: there is never a second task for an episode, and a label is a draft of its episode.
#[test]
fn an_imported_label_is_of_the_episode_that_it_is_about() {
    let (app, _recordings, _dir) = fixtures::counted();
    let with = |trace: &str, object: &str| {
        let mut label = label(trace);
        label["scenario"]["l3"] = json!("urgent");
        label["critical_components"] =
            json!([{"description": trace, "id": "c1", "linked_objects": [object]}]);
        label
    };
    let mut episode = fixtures::episode("mined-1");
    episode["scenario_id"] = json!("reactive_agent.cutin.urgent");
    episode["keyframe"]["timestamp"] = json!("2026-01-01T00:00:02.000Z");
    episode["target_id"] = json!("car7");
    episode["score"] = json!(0.57);
    let ids = |project: &str| {
        let all = app.store.read(|tx| tasks_of(tx, project, None)).unwrap();
        let mut ids: Vec<(String, String)> = all
            .into_iter()
            .map(|t| (t.episode.episode_id, t.draft["coc_trace"].as_str().unwrap_or_default().to_owned()))
            .collect();
        ids.sort();
        ids
    };
    let pair = |id: &str, trace: &str| (id.to_owned(), trace.to_owned());
    // Labels first: the draft in the other language is of the same episode, that of another object is not.
    let text =
        format!("{}\n{}\n{}\n", with("前车切入", "car7"), with("a car cuts in", "car7"), with("x", "car8"));
    let made = import(&app, "p", &text, None).unwrap();
    assert_eq!((made.tasks, made.known), (2, 1));
    // Then the mined episode: the label about its target gets it, and there is no second task.
    let request = serde_json::from_value(json!({ "episodes": [episode.clone()] })).unwrap();
    let created = create::create(&app, "p", &request, None, create::Drafting::Later).unwrap();
    assert_eq!((created.tasks.len(), created.known), (0, 1));
    let all = ids("p");
    assert!(all.contains(&pair("mined-1", "前车切入")), "{all:?}");
    assert!(all.iter().any(|(id, trace)| id.starts_with("label-") && trace == "x"), "{all:?}");
    let whole = ExportFormat::from_words(Some("tasks"), None, None).unwrap();
    for line in export(&app.store, "p", &whole).unwrap().lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let episode = &line["task"]["episode"];
        let expected = if episode["episode_id"] == "mined-1" { json!(0.57) } else { Value::Null };
        assert_eq!(episode["score"], expected, "{episode}");
    }
    // In another project, whose tasks come from the episode first.
    let insert = "INSERT INTO projects (id, name, guide, quota, settings, created) VALUES ('q', 'q', '', '{}', '{}', 0)";
    app.store.write(move |tx| tx.run(insert, &[])).unwrap();
    let made = import(&app, "q", &format!("{}\n", with("a car cuts in", "car7")), None).unwrap();
    assert_eq!((made.tasks, made.known), (1, 0));
    assert_eq!(ids("q"), [pair("mined-1", "a car cuts in")]);
    let created = create::create(&app, "q", &request, None, create::Drafting::Later).unwrap();
    assert_eq!((created.tasks.len(), created.known), (0, 1));
}

fixtures::on_postgresql! {
    an_imported_label_is_of_the_episode_that_it_is_about,
    accepted_labels_go_out_in_either_format,
    of_several_labels_of_an_episode_only_the_chosen_one_goes_out,
    tasks_go_out_with_their_history,
    a_long_history_goes_out_whole_and_in_order,
    odd_words_are_refused,
    lines_that_cannot_come_in_are_named_and_do_not_stop_the_rest,
    many_labels_of_a_drive_read_it_once_and_derive_nothing,
    many_episodes_of_a_drive_derive_it_once_beside_their_own_history,
}
