//! From paths to a lake: which sources there are, and one source at a time into the lake.

use crate::{SourceReport, av2, comma2k19, mcap, nuscenes, scenarionet, sumo, table, waymo};
use std::path::{Path, PathBuf};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Nanos};

/// Formats that have an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Argoverse 2 sensor logs.
    Av2,
    /// Argoverse 2 motion forecasting scenarios.
    Av2Motion,
    /// comma2k19 routes.
    Comma2k19,
    /// MCAP recordings.
    Mcap,
    /// nuScenes tables.
    NuScenes,
    /// ScenarioNet and MetaDrive scenarios.
    ScenarioNet,
    /// SUMO floating car data and network.
    Sumo,
    /// Our own table layout.
    Table,
    /// Waymo Open Motion Dataset.
    WaymoMotion,
}

impl Format {
    /// All formats.
    pub const ALL: &'static [Format] = &[
        Format::Av2,
        Format::Av2Motion,
        Format::Comma2k19,
        Format::Mcap,
        Format::NuScenes,
        Format::ScenarioNet,
        Format::Sumo,
        Format::Table,
        Format::WaymoMotion,
    ];

    /// Name on the command line and in `DriveMeta::format`.
    pub fn name(self) -> &'static str {
        match self {
            Format::Av2 => "av2",
            Format::Av2Motion => "av2-motion",
            Format::Comma2k19 => "comma2k19",
            Format::Mcap => "mcap",
            Format::NuScenes => "nuscenes",
            Format::ScenarioNet => "scenarionet",
            Format::Sumo => "sumo",
            Format::Table => "table",
            Format::WaymoMotion => "waymo-motion",
        }
    }

    /// The format with this name.
    pub fn from_name(name: &str) -> Option<Format> {
        Format::ALL.iter().copied().find(|f| f.name() == name)
    }

    /// The drives at or below `path`: the file or folder of each, and its part where a file holds several.
    fn find(self, path: &Path) -> std::io::Result<Vec<(PathBuf, Option<u64>)>> {
        let whole = match self {
            Format::NuScenes => {
                let found = nuscenes::find_scenes(path)?;
                return Ok(found.into_iter().map(|(set, index)| (set, Some(index))).collect());
            }
            Format::WaymoMotion => {
                let found = waymo::find_scenarios(path)?;
                return Ok(found.into_iter().map(|(file, at)| (file, Some(at))).collect());
            }
            Format::Av2 if path.is_dir() => av2::find_logs(path),
            Format::Av2 => Ok(Vec::new()),
            Format::Av2Motion => av2::motion::find_scenarios(path),
            Format::Comma2k19 => comma2k19::find_routes(path),
            Format::Mcap => mcap::find_recordings(path),
            Format::ScenarioNet => scenarionet::find_scenarios(path),
            Format::Sumo => sumo::find_simulations(path),
            Format::Table => table::find_drives(path),
        }?;
        Ok(whole.into_iter().map(|path| (path, None)).collect())
    }
}

/// What the user may say beside the paths.
#[derive(Clone, Debug)]
pub struct Options {
    /// Id of the drive, when there is one source; otherwise each names its own.
    pub drive_id: Option<DriveId>,
    /// Vehicles that are egos, for sources that do not say (simulations); each becomes a drive.
    pub egos: sumo::Egos,
    /// What the ego's sensor sees, for sources that know everything (simulations).
    pub sensing: sumo::Sensing,
    /// Time of the source's zero, for sources without a clock of their own.
    pub start: Nanos,
    /// Road network, when it does not lie beside the source.
    pub net: Option<PathBuf>,
    /// Files with vehicle types, when they do not lie beside the source.
    pub types: Vec<PathBuf>,
    /// Light states, when they do not lie beside the source.
    pub lights: Option<PathBuf>,
    /// Description of the messages on the vehicle bus (DBC), for sources with raw CAN.
    pub dbc: Option<PathBuf>,
    /// Which topics are what, for recordings of messages whose types do not say it.
    pub mapping: Option<PathBuf>,
    /// Licence of the data, for sources that do not say; SPDX id.
    pub licence: Option<String>,
}

/// 2026-01-01T00:00:00Z, where drives without a clock begin unless told otherwise.
pub const DEFAULT_START: Nanos = Nanos(1_767_225_600_000_000_000);

impl Default for Options {
    fn default() -> Self {
        Self {
            drive_id: None,
            egos: sumo::Egos::default(),
            sensing: sumo::Sensing::default(),
            start: DEFAULT_START,
            net: None,
            types: Vec::new(),
            lights: None,
            dbc: None,
            mapping: None,
            licence: None,
        }
    }
}

/// One drive to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Adapter.
    pub format: Format,
    /// Folder or file.
    pub path: PathBuf,
    /// Which drive of a file that holds several: the byte at which its record begins, the place of its scene.
    pub part: Option<u64>,
}

/// The sources at or below `paths`, and what is wrong with paths that have none. Without a format, every adapter is asked.
pub fn find_sources(format: Option<Format>, paths: &[PathBuf]) -> (Vec<Source>, Vec<Diagnostic>) {
    let formats = format.as_ref().map_or(Format::ALL, std::slice::from_ref);
    let (mut sources, mut problems) = (Vec::new(), Vec::new());
    for path in paths {
        let label = path.display().to_string();
        if !path.exists() {
            problems.push(not_there(&label));
            continue;
        }
        let before = sources.len();
        for &format in formats {
            match format.find(path) {
                Ok(found) => {
                    sources.extend(found.into_iter().map(|(path, part)| Source { format, path, part }))
                }
                Err(e) => problems.push(unreadable(&label, &e.to_string())),
            }
        }
        if sources.len() == before && problems.is_empty() {
            problems.push(nothing_found(&label, formats));
        }
    }
    (sources, problems)
}

/// Reads one source: its drive, or that of its first ego where it has several.
pub fn read(source: &Source, options: &Options) -> (Option<Drive>, SourceReport) {
    match source.format {
        Format::Av2 => av2::read(&source.path, options.drive_id.as_ref()),
        Format::Av2Motion => av2::motion::read(&source.path, options),
        Format::Comma2k19 => comma2k19::read(&source.path, options),
        Format::ScenarioNet => scenarionet::read(&source.path, options),
        Format::Mcap => mcap::read(&source.path, options),
        Format::NuScenes => nuscenes::read(&source.path, source.part.unwrap_or(0), options),
        Format::WaymoMotion => waymo::read(&source.path, source.part.unwrap_or(0), options),
        Format::Sumo => sumo::read(&source.path, options),
        Format::Table => table::read(&source.path, options),
    }
}

/// Scenes of one nuScenes set that are read together. The full set has 850; reading 50 at a time goes through its tables
/// 17 times and holds the rows of 50.
const SCENES_TOGETHER: usize = 50;

/// The sources in their order, cut into those that are read together.
pub fn batches(sources: &[Source]) -> impl Iterator<Item = &[Source]> {
    let together =
        |a: &Source, b: &Source| a.format == Format::NuScenes && (a.format, &a.path) == (b.format, &b.path);
    sources.chunk_by(together).flat_map(|alike| alike.chunks(SCENES_TOGETHER))
}

/// Reads a batch of sources and writes their drives, one at a time; a simulation has one for each ego. `each` gets a report a
/// drive, which says everything; a drive that is not in the lake has no `outcome`. What the lake holds already is not made
/// again: an ingest that was interrupted, also in the middle of a source, goes on where it was.
pub fn ingest_each(batch: &[Source], options: &Options, lake: &Lake, each: &mut dyn FnMut(SourceReport)) {
    let mut keep = |drive: Option<Drive>, mut report: SourceReport| {
        if let Some(drive) = drive {
            write(&drive, &mut report, lake);
        } else if let Some(id) = &report.drive_id
            && let Ok(drive) = lake.read_drive(id)
        {
            told(&drive, &mut report);
            report.outcome = Some(WriteOutcome::Unchanged);
        }
        each(report);
    };
    // One that cannot be read whole is made again.
    let held = |id: &DriveId, hash: &str| lake.read_drive(id).is_ok_and(|d| d.meta.content_hash == hash);
    for alike in batches(batch) {
        match (alike, alike[0].format) {
            (scenes, Format::NuScenes) => {
                let indices: Vec<u64> = scenes.iter().map(|s| s.part.unwrap_or(0)).collect();
                nuscenes::read_several(&scenes[0].path, &indices, options, &mut keep);
            }
            (simulations, Format::Sumo) => {
                simulations.iter().for_each(|s| sumo::read_new(&s.path, options, &held, &mut keep));
            }
            (others, _) => others.iter().for_each(|source| {
                let (drive, report) = read(source, options);
                keep(drive, report);
            }),
        }
    }
}

/// [`ingest_each`] for a source with one drive: the report of the first.
pub fn ingest(source: &Source, options: &Options, lake: &Lake) -> SourceReport {
    let mut first = None;
    ingest_each(std::slice::from_ref(source), options, lake, &mut |report| {
        first.get_or_insert(report);
    });
    first.unwrap_or_else(|| SourceReport::new(source.path.display().to_string()))
}

/// What a drive is, for its report.
fn told(drive: &Drive, report: &mut SourceReport) {
    let span = (drive.times.first(), drive.times.last());
    report.drive_id = Some(drive.meta.drive_id.clone());
    report.frames = drive.frame_count();
    report.duration_s = span.0.zip(span.1).map_or(0.0, |(a, b): (&Nanos, &Nanos)| b.seconds_since(*a));
    report.tracks = drive.tracks.len();
    report.missing = drive.meta.missing.clone();
}

fn write(drive: &Drive, report: &mut SourceReport, lake: &Lake) {
    told(drive, report);
    match lake.write_drive(drive) {
        Ok(outcome) => report.outcome = Some(outcome),
        Err(e) => report.diagnostics.push(e.diagnostic()),
    }
}

fn not_there(path: &str) -> Diagnostic {
    Diagnostic::error(
        "ingest.path.missing",
        Bilingual::new(format!("{path} 不存在"), format!("{path} does not exist")),
    )
    .in_file(path)
}

fn unreadable(path: &str, reason: &str) -> Diagnostic {
    Diagnostic::error(
        "ingest.path.unreadable",
        Bilingual::new(format!("{path} 无法读取：{reason}"), format!("{path} cannot be read: {reason}")),
    )
    .in_file(path)
}

fn nothing_found(path: &str, formats: &[Format]) -> Diagnostic {
    let names: Vec<&str> = formats.iter().map(|f| f.name()).collect();
    let names = names.join(", ");
    Diagnostic::error(
        "ingest.nothing_found",
        Bilingual::new(
            format!("{path} 中没有可识别的行程（已尝试：{names}）"),
            format!("nothing in {path} looks like a drive (tried: {names})"),
        ),
    )
    .with_hint(Bilingual::new(
        "docs/how-to/ingest.zh.md 说明各格式需要哪些文件",
        "docs/how-to/ingest.md says which files each format needs",
    ))
    .in_file(path)
}
