//! Texts: YAML, the rule language, labels as JSON.

use super::{file, unchanged};
use crate::harness::Target;
use whyroad_framework::Framework;
use whyroad_framework::check::{Layout, Splitter};
use whyroad_label::check::Checker;

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
            Box::new(|bytes| drop(whyroad_model::yaml::parse(&String::from_utf8_lossy(bytes)))),
        ),
        text(
            "rule-language",
            rules.iter().map(|r| r.as_bytes().to_vec()).collect(),
            Box::new(|bytes| drop(whyroad_mining::language::parse::parse(&String::from_utf8_lossy(bytes)))),
        ),
        text(
            "label-json",
            labels.iter().map(|p| file(p)).collect(),
            Box::new(move |bytes| {
                drop(checker.check_text(&String::from_utf8_lossy(bytes)));
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
            }),
        ),
    ]
}
