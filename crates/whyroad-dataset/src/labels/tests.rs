//! Labels of one keyframe and class: in two languages, without a text, repeated.

use super::*;
use serde_json::json;

/// A draft of one keyframe with this trace.
fn line(trace: &str) -> String {
    json!({ "task": { "id": "t", "state": "open", "draft": {
        "version": "2.1.0", "clip_id": "d_000",
        "scenario": { "l1": "reactive_agent", "l2": "cutin", "l3": "urgent" },
        "time_range": { "start_timestamp": "2026-01-01T00:00:01.000Z", "end_timestamp": "2026-01-01T00:00:05.000Z" },
        "keyframe": { "timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive" },
        "driving_decision": { "longitudinal": null, "lateral": null },
        "critical_components": [], "coc_trace": trace,
    } } })
    .to_string()
        + "\n"
}

/// The language of the label that is kept, whether it has the other language beside it, and why the rest was dropped.
fn read_lines(traces: &[&str]) -> (Option<Lang>, bool, Vec<String>) {
    read_text(traces.iter().map(|t| line(t)).collect())
}

fn read_text(text: String) -> (Option<Lang>, bool, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let stream = LabelStream { name: "labels".into(), lines: Box::new(std::io::Cursor::new(text)) };
    let read = read(vec![stream], Framework::bundled(), &dir.path().join("labels.records")).unwrap();
    assert_eq!(read.items.len(), 1, "{:?}", read.diagnostics);
    let dropped = read.dropped.iter().filter_map(|d| d.dropped.detail.as_deref().map(str::to_owned));
    (read.items[0].lang, read.items[0].other.is_some(), dropped.collect())
}

const ZH: &str = "前车急刹，自车减速";
const EN: &str = "The lead brakes hard, so the ego slows";

#[test]
fn a_label_without_a_text_is_not_the_other_language() {
    let before = || vec!["a label of the same keyframe and class was read before".to_owned()];
    assert_eq!(read_lines(&[ZH, EN]), (Some(Lang::Zh), true, vec![]));
    assert_eq!(read_lines(&[ZH, ""]), (Some(Lang::Zh), false, before()));
    assert_eq!(read_lines(&[EN, " \n"]), (Some(Lang::En), false, before()));
    // One with a text is taken instead, and can have the other language beside it.
    let empty = || vec!["an earlier label of the same keyframe and class has no trace".to_owned()];
    assert_eq!(read_lines(&["", ZH]), (Some(Lang::Zh), false, empty()));
    assert_eq!(read_lines(&["", EN, ZH]), (Some(Lang::En), true, empty()));
    assert_eq!(read_lines(&["", ""]), (None, false, before()));
}

/// A sample has one decision: the text of a label that decides otherwise would explain another one.
#[test]
fn languages_with_other_decisions_are_not_one_label() {
    let yields = line(EN).replace(r#""longitudinal":null"#, r#""longitudinal":"yield_to_agent""#);
    let detail = "the label in the other language, read before, has another decision".to_owned();
    assert_eq!(read_text(line(ZH) + &yields), (Some(Lang::Zh), false, vec![detail]));
}

/// `whyroad draft` writes labels, which have no place for the score and id of their episode (DATA_FORMAT.md 5). With
/// the mined folder beside them they have both, in whatever order they are read.
#[test]
fn a_label_takes_the_facts_of_its_episode() {
    let label: Value = serde_json::from_str(&line(EN)).unwrap();
    let label = &label["task"]["draft"];
    let episode = json!({
        "episode_id": "e1", "scenario_id": "reactive_agent.cutin.urgent", "drive_id": "d", "clip_id": "d_000",
        "target_id": "car7", "time_range": label["time_range"], "keyframe": label["keyframe"], "score": 0.7,
        "is_primary": true, "keyframe_rule": { "zh": "", "en": "" }, "conditions_matched": [], "signals": [],
        "rule_version": "r1",
    });
    let stated = {
        let mut label = label.clone();
        label["provenance"] = json!({ "source": "rule" });
        label
    };
    // A store keeps a label under an episode that was made from it (`tasks import`), which says nothing about it.
    let imported = {
        let made = json!({
            "episode_id": "label-0123", "scenario_id": "reactive_agent.cutin.urgent", "drive_id": "d", "clip_id": "d_000",
            "time_range": label["time_range"], "keyframe": label["keyframe"], "score": 1.0, "is_primary": true,
            "keyframe_rule": { "zh": "", "en": "" }, "conditions_matched": [], "signals": [],
        });
        json!({ "task": { "id": "t", "state": "open", "draft": label, "episode": made } })
    };
    for lines in [[&stated, &episode], [&episode, &stated], [&imported, &episode], [&episode, &imported]] {
        let dir = tempfile::tempdir().unwrap();
        let text: String = lines.iter().map(|l| format!("{l}\n")).collect();
        let stream = LabelStream { name: "labels".into(), lines: Box::new(std::io::Cursor::new(text)) };
        let path = dir.path().join("labels.records");
        let read = read(vec![stream], Framework::bundled(), &path).unwrap();
        let [item] = &read.items[..] else { panic!("{:?}", read.items) };
        assert_eq!((item.lang, item.score), (Some(Lang::En), 0.7));
        let record = |at| crate::records::read_record::<LabelRecord>(&path, at).unwrap();
        let label = record(item.label).of_episode(record(item.episode.unwrap()));
        assert!(!label.is_episode && label.json.contains(EN));
        let facts = [label.episode_id, label.target_id, label.rule_version].map(Option::unwrap);
        assert_eq!((facts, label.score), (["e1", "car7", "r1"].map(String::from), Some(0.7)));
        assert_eq!(read.dropped.len(), 1, "the other line is counted");
    }
    // Without the mined folder its score and episode are unknown (docs/reference/release.md: null is unknown).
    let checker = Checker::new(Framework::bundled());
    let mut of_export = imported.clone();
    of_export["task"]["episode"]["score"] = Value::Null;
    for line in [imported, of_export] {
        let read = read_line(line.to_string().as_bytes(), &checker).map_err(|f| f.reason).unwrap();
        assert_eq!((read.record.episode_id, read.record.score), (None, None));
        assert_eq!((read.record.task_id.as_deref(), read.drive.as_deref()), (Some("t"), Some("d")));
    }
}

/// As the labeling service exports tasks (docs/reference/service.md, *Queue*): of an episode with several labels
/// only the chosen one is used.
#[test]
fn of_several_labels_of_an_episode_only_the_chosen_one_is_read() {
    let text = include_str!("../../../../examples/cutin_urgent_example.json");
    let label: Value = serde_json::from_str(text).unwrap();
    let checker = Checker::new(Framework::bundled());
    let read = |count: i64, adjudication: Option<&str>| {
        let line = json!({ "task": { "id": "t", "state": "accepted", "draft": label, "overlap_count": count,
            "adjudication": adjudication } });
        read_line(line.to_string().as_bytes(), &checker).map_or_else(|f| f.reason, |_| "read")
    };
    assert_eq!((read(1, None), read(2, Some("chosen"))), ("read", "read"));
    assert_eq!((read(2, None), read(2, Some("superseded"))), ("not_chosen", "overruled"));
}

/// LABELING.md, Stage II: what is not legal and safe is no sample; a draft of it is none either.
#[test]
fn what_people_refused_is_not_replaced_by_a_draft() {
    let episode = json!({
        "episode_id": "e", "drive_id": "d", "clip_id": "d_000", "scenario_id": "reactive_agent.cutin.urgent",
        "time_range": { "start_timestamp": "2026-01-01T00:00:01.000Z", "end_timestamp": "2026-01-01T00:00:05.000Z",
            "start_frame_idx": 0, "end_frame_idx": 40 },
        "keyframe": { "timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive" },
        "score": 0.8, "is_primary": true, "keyframe_rule": { "zh": "", "en": "" }, "conditions_matched": [],
        "signals": [],
    });
    // The annotator left a text in it that nobody finished.
    let refused = |state: &str| {
        let mut task: Value = serde_json::from_str(&line(EN)).unwrap();
        (task["task"]["state"], task["task"]["episode"]) = (json!(state), episode.clone());
        task.to_string() + "\n"
    };
    let of_lines = |text: String| {
        let dir = tempfile::tempdir().unwrap();
        let stream = LabelStream { name: "labels".into(), lines: Box::new(std::io::Cursor::new(text)) };
        let read = read(vec![stream], Framework::bundled(), &dir.path().join("labels.records")).unwrap();
        let status = |item: &Item| read.statuses.get(item.status).to_owned();
        read.items.iter().map(status).collect::<Vec<_>>()
    };
    for state in ["rejected", "skipped"] {
        let mined = episode.to_string() + "\n";
        assert_eq!(of_lines(refused(state) + &mined + &line(ZH)), [state]);
        assert_eq!(of_lines(line(ZH) + &mined + &refused(state)), [state]);
        assert_eq!(of_lines(mined + &refused(state)), [state]);
    }
}
