//! Export and import on tasks made by hand; round trips over real drives are in the binary's tests.

use super::*;
use crate::api::wire::task::FieldChange;
use crate::service::fixtures::{self, task};
use crate::service::tasks::Entry;
use serde_json::json;

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
    let change = FieldChange { path: "/coc_trace".into(), value: json!(id), remove: false };
    let entry = Entry { action: "edit", changes: &[change], note: Some("why"), ..Entry::default() };
    tasks::record(tx, &mut t, &entry, 7).unwrap();
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
    let format = Format::from_words(words.0, words.1, words.2).unwrap();
    let text = app.store.read(|tx| export(tx, "p", &format)).unwrap();
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
fn odd_words_are_refused() {
    for words in [(Some("csv"), None, None), (None, Some("3"), None), (None, None, Some("done"))] {
        assert_eq!(Format::from_words(words.0, words.1, words.2).unwrap_err().code, "request.invalid");
    }
}

#[test]
fn lines_that_cannot_come_in_are_named_and_do_not_stop_the_rest() {
    let (app, _dir) = fixtures::app();
    let text = format!("nonsense\n\n{}\n{}\n", label("t"), json!({"other": 1}));
    let made = import(&app, "p", &text, None).unwrap();
    assert_eq!((made.tasks, made.known), (0, 0));
    let heads: Vec<&str> = made.lost.iter().map(|l| l.split(':').next().unwrap()).collect();
    // The label is sound, but there is no drive `d` here.
    assert_eq!(heads, ["line 1", "line 3", "line 4"]);
    assert!(made.lost[1].contains("drive"), "{}", made.lost[1]);
    let many = "{}\n".repeat(MOST_LINES + 1);
    assert_eq!(import(&app, "p", &many, None).unwrap_err().code, "request.invalid");
}
