//! Older labels as their authors wrote them, and their conversion back.

use super::*;
use crate::check::Checker;

fn current(document: &Value) -> Migrated {
    migrate(Framework::bundled(), document, Target::Current)
}

#[test]
fn the_compact_layout_becomes_a_valid_label() {
    let document = json!({
        "clip_id": "clip_1",
        "scenario": "cutin.urgent",
        "keyframe": { "timestamp": "2026-01-15T10:30:09.400Z", "frame_idx": 94 },
        "time_range": [74, "2026-01-15T10:30:11.200Z"],
        "decision": "yield_to_agent",
        "primary_factors": [
            "左前方白色轿车未打转向灯向本车道切入，右前轮刚越过车道线",
            { "type": "critical_objects", "factor": "右侧车道有一辆货车与自车并行", "weight": 0.3 }
        ],
        "coc": "左前方的白色轿车没有打转向灯就切入本车道，右前轮已经越线，间距正迅速缩小；右侧货车并行，没有空间可以让开，因此自车应立即减速让行。",
        "rating": 5
    });
    let done = current(&document);
    assert_eq!(done.from, "compact");
    let label = done.label.unwrap();
    let found = Checker::new(Framework::bundled()).check_text(&label.to_string());
    assert!(found.is_empty(), "{found:#?}\n{label:#}");
    assert_eq!(label["time_range"]["start_timestamp"], "2026-01-15T10:30:07.400Z");
    assert_eq!(label["keyframe"]["type"], "reactive");
    let lost: Vec<_> = done.report.iter().filter_map(|d| d.location.pointer.clone()).collect();
    assert_eq!(lost, ["/rating", "/critical_components/1/weight"]);
}

#[test]
fn there_and_back_loses_what_2_0_cannot_say_and_says_so() {
    let text = include_str!("../../../../examples/cutin_urgent_example.json");
    let example: Value = serde_json::from_str(text).unwrap();
    assert_eq!(current(&example).label.as_ref(), Some(&example));
    assert_eq!(current(&example).report, []);
    let back = migrate(Framework::bundled(), &example, Target::V2_0);
    let lost: Vec<_> = back.report.iter().filter_map(|d| d.location.pointer.clone()).collect();
    assert_eq!(lost, ["/causes", "/provenance", "/critical_components"]);
    let old = back.label.unwrap();
    assert_eq!(old["version"], "2.0.0");
    let again = current(&old);
    assert_eq!((again.from, again.report), ("2.0", vec![]));
    assert!(Checker::new(Framework::bundled()).check_text(&again.label.unwrap().to_string()).is_empty());
}

#[test]
fn records_are_stored_without_language() {
    let mut example: Value =
        serde_json::from_str(include_str!("../../../../examples/vru_crossing_example.json")).unwrap();
    example["records"]["has_traffic_light"] = json!("无");
    assert_eq!(current(&example).label.unwrap()["records"]["has_traffic_light"], json!(false));
    example["records"]["has_traffic_light"] = json!("未知");
    assert_eq!(current(&example).label.unwrap()["records"]["has_traffic_light"], json!("unknown"));
}

#[test]
fn what_cannot_be_read_is_reported_and_not_guessed() {
    let done = current(&json!({ "scenario": "cutinn", "decision": ["brake"], "keyframe": 94 }));
    let said: Vec<_> = done.report.iter().map(|d| d.message.en.as_str()).collect();
    assert!(said.iter().any(|m| m.contains("'cutinn' does not name one class")), "{said:?}");
    assert!(said.iter().any(|m| m.contains("'brake' is not a decision")), "{said:?}");
    assert!(said.iter().any(|m| m.contains("no usable timestamp")), "{said:?}");
    assert!(said.iter().any(|m| m.contains("no clip_id")), "{said:?}");
    assert_eq!(current(&json!([1])).label, None);
}
