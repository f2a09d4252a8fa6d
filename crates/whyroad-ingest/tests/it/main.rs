//! Integration tests of the ingest: one module per format.

mod av2_broken;
mod av2_motion;
mod av2_real;
mod comma2k19;
mod finding;
mod maps;
mod mcap;
mod mcap_fields;
mod nuscenes;
mod pai;
#[path = "../../../whyroad-model/testing/require.rs"]
mod require;
mod rosbag;
mod scenarionet;
mod sumo;
mod sumo_egos;
mod table;
mod table_mapping;
mod waymo;

/// True when every problem is a warning about files that are not recordings, such as the fixtures' scripts.
fn only_skipped(problems: &[whyroad_model::Diagnostic]) -> bool {
    let of_scripts = |d: &whyroad_model::Diagnostic| {
        d.code == "ingest.files.skipped" && ["make.py", "README.md"].iter().any(|n| d.message.en.contains(n))
    };
    !problems.is_empty() && problems.iter().all(of_scripts)
}

/// The drive with complete motion: adapters give what was measured.
fn estimated(drive: whyroad_model::Drive) -> whyroad_model::Drive {
    whyroad_signals::estimate(&drive).into_owned()
}
