//! The recorded formats: one module each, registered in [`ALL`].

use crate::adapter::AdapterRef;
use crate::file_reader::FileReader;

pub mod av2;
pub mod av2_motion;
pub mod comma2k19;
pub mod mcap;
pub mod nuscenes;
pub mod openlabel;
pub mod pai;
pub mod rosbag;
pub mod scenarionet;
pub mod sumo;
pub mod table;
pub mod waymo;

/// All formats, by name.
pub const ALL: &[AdapterRef] = &[
    AdapterRef(&av2::Av2),
    AdapterRef(&av2_motion::Av2Motion),
    AdapterRef(&comma2k19::Comma2k19),
    AdapterRef(&mcap::Mcap),
    AdapterRef(&nuscenes::NuScenes),
    AdapterRef(&openlabel::OpenLabel),
    AdapterRef(&pai::PhysicalAiAv),
    AdapterRef(&rosbag::RosBag),
    AdapterRef(&scenarionet::ScenarioNet),
    AdapterRef(&sumo::Sumo),
    AdapterRef(&table::Table),
    AdapterRef(&waymo::WaymoMotion),
];

/// The format with this name.
pub fn by_name(name: &str) -> Option<AdapterRef> {
    ALL.iter().copied().find(|a| a.0.name() == name)
}

/// The known format whose name is closest to `name`; `None` when none is close.
pub fn closest(name: &str) -> Option<&'static str> {
    let scored = ALL.iter().map(|a| (strsim::jaro_winkler(a.0.name(), &name.to_lowercase()), a.0.name()));
    scored.filter(|(score, _)| *score >= 0.75).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name)
}

/// Readers of the formats that read single files.
pub(crate) const READERS: &[&[FileReader]] = &[
    av2::READERS,
    av2_motion::READERS,
    mcap::READERS,
    pai::READERS,
    sumo::READERS,
    table::READERS,
    waymo::READERS,
];
