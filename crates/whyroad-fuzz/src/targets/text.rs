//! Texts: YAML, the rule language, labels as JSON.

use super::{file, unchanged};
use crate::harness::Target;
use whyroad_framework::Framework;
use whyroad_framework::check::{Layout, Splitter};
use whyroad_label::check::Checker;
use whyroad_label::import;

const AUTO_LABEL: &str = "results:
  event_start_frame: 51
  event_start_timestamp: 5100000
  coc_prompt_version: v2
  final_content:
    ego_behavior_schema:
      effect_on_ego_behavior: The car ahead brakes, so the ego slows down.
";
const META_ACTIONS: &str = "Keep speed - Start: 0.0, End: 1.5\nSlow down - Start: 1.5, End: 3.0\n";
const ALPAMAYO: &str = concat!(
    r#"{"clip_id": "a", "event_start_timestamp": 5100000, "chain_of_causation": "The light is red.", "#,
    r#""critical_components_analysis": [{"component": "light", "why": "red"}, "queue"]}"#
);

pub(super) fn targets() -> Vec<Target> {
    let text = |name: &str, seeds: Vec<Vec<u8>>, run: crate::harness::Parser| Target {
        name: name.to_owned(),
        seeds,
        small: Vec::new(),
        repair: unchanged,
        run,
    };
    let yaml = ["scenarios/reactive_agent/cutin.yaml", "schema/needs.yaml", "schema/driving_decisions.yaml"];
    let rules = [
        "target.lateral_offset > 0.5 m and ttc < 5 s for 0.5 s",
        "exists(target.class in {car, bus} and not (target.gap < 3 m)) then ego.accel < -1.5 m/s2 within 2 s",
        "share(ego.speed > 30 km/h) > 0.5 since rises(light.state is known) within 10 s",
    ];
    let labels = [
        "examples/cutin_urgent_example.json",
        "examples/blind_spot_example.json",
        "examples/vru_crossing_example.json",
    ];
    let checker = Checker::new(Framework::bundled());
    vec![
        text(
            "yaml",
            yaml.iter().map(|p| file(p)).collect(),
            Box::new(|bytes| whyroad_model::yaml::parse(&String::from_utf8_lossy(bytes)).is_ok()),
        ),
        text(
            "rule-language",
            rules.iter().map(|r| r.as_bytes().to_vec()).collect(),
            Box::new(|bytes| whyroad_mining::language::parse::parse(&String::from_utf8_lossy(bytes)).is_ok()),
        ),
        text(
            "label-json",
            labels.iter().map(|p| file(p)).collect(),
            Box::new(move |bytes| checker.check_text(&String::from_utf8_lossy(bytes)).is_empty()),
        ),
        text(
            "import-auto-labeler",
            vec![AUTO_LABEL.into()],
            Box::new(|bytes| {
                let text = String::from_utf8_lossy(bytes);
                !import::auto_labeler::read_text("a.yaml", "a", "cot_5100000", &text).found.is_empty()
            }),
        ),
        text(
            "import-meta-actions",
            vec![META_ACTIONS.into()],
            Box::new(|bytes| {
                let text = String::from_utf8_lossy(bytes);
                import::auto_labeler::read_meta_actions("a.txt", &text).diagnostics.is_empty()
            }),
        ),
        text(
            "import-alpamayo",
            vec![ALPAMAYO.into(), [ALPAMAYO, "\n", ALPAMAYO].concat().into()],
            Box::new(|bytes| {
                !import::alpamayo2::read("a.json", "a", &String::from_utf8_lossy(bytes)).found.is_empty()
            }),
        ),
        text(
            "label-splitter",
            labels.iter().map(|p| file(p)).collect(),
            Box::new(|bytes| {
                for layout in [Layout::Lines, Layout::Values] {
                    let mut splitter = Splitter::new(layout);
                    let (head, tail) = bytes.split_at(bytes.len().min(5));
                    splitter.feed(head, &mut |_| ());
                    splitter.feed(tail, &mut |_| ());
                    splitter.finish(&mut |_| ());
                }
                true
            }),
        ),
    ]
}
