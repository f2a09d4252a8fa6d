//! Our own layout of Parquet or CSV files, for any fleet and for formats that have no adapter. What each file and
//! column means is written in `docs/reference/table-format.md`, which people write their exporters by; change both
//! together.
//!
//! A fleet's own tables, with other names, units and words, are read by a mapping file
//! (`docs/reference/table-mapping.md`): `mapped` makes tables of the layout of them, and nothing else knows it.
//!
//! Frames are the ego's times where those are 10 times a second, else every 0.1 s. Nothing is guessed: an unknown
//! column or word is reported, a cell that cannot be read is unknown and counted, a row without time, place or id is
//! dropped and counted.

mod ego;
mod findings;
mod group;
mod layout;
mod mapped;
mod mapping;
mod meta;
mod objects;
mod problems;
mod reader;
mod road;
mod sheet;
mod signs;
mod states;
mod words;

use crate::adapter::{Adapter, DriveSink, FilesInMemory, FormatAbout, Located, Source, whole};
use crate::encodings::input::{Folder, Input};
use crate::file_reader::FileReader;
use crate::options::{LICENCE, OptionSpec, OptionType, Options, START};
use crate::report::SourceReport;
use crate::source::{
    ContentHash, drive_id, file_label, find_folders, implausible_span, implausible_step, renamed, resampled,
};
pub(crate) use findings::CODES;
use layout::TABLES;
use mapping::Mapping;
use meta::Meta;
use reader::{Clock, Reader, files_of};
use std::path::{Path, PathBuf};
use whyroad_model::scene::{DriveMeta, FrameOfReference};
use whyroad_model::{Diagnostic, Drive, Nanos, Need};

/// Raised when the adapter makes something else of the same files, so that drives in a lake are replaced.
const REVISION: u32 = 8;

/// The file that says which of the fleet's own files and columns are which.
pub const MAPPING: OptionSpec = OptionSpec::new(
    "mapping",
    OptionType::File,
    "FILE",
    "mapping file: file and column names, units, axes and words of your own tables",
);

/// Our own table layout.
pub struct Table;

impl Adapter for Table {
    fn about(&self) -> &'static FormatAbout {
        const {
            &FormatAbout {
                name: "table",
                summary: "tables: Parquet or CSV files in the documented layout, or in another one by --mapping",
                example: "table path/to/drives --lake lake\n  whyroad ingest table path/to/drives --mapping fleet.yaml --lake lake",
                options: &[MAPPING, START, LICENCE],
                codes: CODES,
            }
        }
    }

    fn find(&self, path: &Path) -> Vec<Located> {
        whole(find_drives(path))
    }

    fn check(&self, options: &Options) -> Vec<Diagnostic> {
        own_mapping(options).err().unwrap_or_default()
    }

    fn find_with(&self, path: &Path, options: &Options) -> Vec<Located> {
        let mapping = own_mapping(options).ok().flatten();
        let mapping = mapping.as_ref().map(|m| &m.mapping);
        whole(find_folders(path, |dir| is_drive(dir, mapping)))
    }

    fn read_files(&self, files: &FilesInMemory, options: &Options, drives: &mut DriveSink<'_>) {
        let mut report = SourceReport::new("memory".to_owned());
        let name = "mapping.yaml";
        let text = files.get(name).map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        let drive = match text.map(|text| NamedMapping::read(name, text)).transpose() {
            Ok(mapping) => {
                read_drive(Folder::Memory(files), "memory", mapping.as_ref(), options, &mut report)
            }
            Err(problems) => {
                report.diagnostics.extend(problems);
                None
            }
        };
        drives.put((drive, report));
    }

    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>) {
        drives.put(read(&source.path, options));
    }
}

/// A mapping with the name and the text of its file.
struct NamedMapping {
    name: String,
    text: String,
    mapping: Mapping,
}

impl NamedMapping {
    fn read(name: &str, text: String) -> Result<Self, Vec<Diagnostic>> {
        let (mapping, problems) = Mapping::read(name, &text);
        let problems = problems.into_iter().map(findings::with_guide).collect();
        mapping.map(|mapping| Self { name: name.to_owned(), text, mapping }).ok_or(problems)
    }
}

/// The mapping that the options name.
fn own_mapping(options: &Options) -> Result<Option<NamedMapping>, Vec<Diagnostic>> {
    let Some(file) = options.file(&MAPPING) else { return Ok(None) };
    let name = file.display().to_string();
    let text = Input::from(file).text().map(|text| text.into_owned());
    let text = text.map_err(|e| vec![findings::mapping_unreadable(&name, &e.to_string())])?;
    NamedMapping::read(&name, text).map(Some)
}

/// Drive folders at or below `path`, sorted: with a drive file and a table, or with the tables of ego and objects, and
/// not of a lake (which has `clips.parquet`).
pub fn find_drives(path: &Path) -> Vec<PathBuf> {
    find_folders(path, |dir| is_drive(dir, None))
}

fn is_drive(dir: &Path, mapping: Option<&Mapping>) -> bool {
    let dir = Folder::Disk(dir);
    let has = |stem| !files_of(dir, stem, mapping).is_empty();
    // Both tables without a drive file are a drive whose file is missing, which is reported.
    let is_described = meta::drive_file(dir).is_some() || mapping.is_some_and(|m| m.drive.is_some());
    let is_meant = if is_described { has("ego") || has("objects") } else { has("ego") && has("objects") };
    is_meant && !dir.has("clips.parquet")
}

/// Endings of what programs write tables into.
const ENDINGS: &[&str] =
    &["csv", "parquet", "tsv", "txt", "gz", "zst", "xz", "zip", "xlsx", "json", "feather"];

/// Files of the folder that are not read and look like a table: another spelling, compressed, a link that leads
/// nowhere.
fn unread(dir: Folder<'_>, mapping: Option<&Mapping>) -> Vec<Diagnostic> {
    let is_read =
        |name: &str| TABLES.iter().any(|stem| files_of(dir, stem, mapping).iter().any(|f| f == name));
    let mut out = Vec::new();
    for name in dir.names() {
        let lower = name.to_lowercase();
        let Some((stem, ending)) = lower.split_once('.') else { continue };
        if is_read(&name) || !ending.split('.').all(|e| ENDINGS.contains(&e)) || lower.starts_with("drive.") {
            continue;
        }
        let near = |table: &&&str| strsim::damerau_levenshtein(stem, table) <= 1;
        let Some(table) = TABLES.iter().find(near) else { continue };
        // The other form of a table that is read is no loss.
        let is_other_form = !files_of(dir, table, mapping).is_empty() && stem == *table;
        if !is_other_form {
            let is_named_so = ["csv", "parquet"].iter().any(|ending| name == format!("{table}.{ending}"));
            let file = dir.label(&name);
            out.push(if is_named_so { findings::not_a_file(&file) } else { findings::unread(&file, table) });
        }
    }
    out
}

/// Reads one drive folder. `None` when there is nothing that could be kept; the report says why.
pub fn read(dir: &Path, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut report = SourceReport::new(dir.display().to_string());
    let drive = match own_mapping(options) {
        Ok(mapping) => {
            read_drive(Folder::Disk(dir), &file_label(dir), mapping.as_ref(), options, &mut report)
        }
        Err(problems) => {
            report.diagnostics.extend(problems);
            None
        }
    };
    (drive, report)
}

fn read_drive(
    dir: Folder<'_>,
    name: &str,
    mapping: Option<&NamedMapping>,
    options: &Options,
    report: &mut SourceReport,
) -> Option<Drive> {
    let mut hash = ContentHash::new("table", REVISION);
    if let Some(mapping) = mapping {
        hash.add("mapping", mapping.text.as_bytes());
    }
    let mapping = mapping.map(|m| (m.name.as_str(), &m.mapping));
    let mut reader = Reader { dir, hash, report, start: options.start(), mapping };
    let meta = Meta::read(&mut reader)?;
    match meta.start_time {
        Some(start) => reader.start = start,
        None => options.hash_start(&mut reader.hash),
    }
    let ego_sheet = reader.sheet("ego", ego::REQUIRED);
    let dated = meta.start_time.is_some()
        || options.is_set(&START)
        || ego_sheet.as_ref().is_some_and(sheet::Sheet::states_dates);
    let Some(rows) = ego_sheet.and_then(|s| ego::rows(s, &mut reader)) else {
        if files_of(dir, "ego", None).is_empty() && reader.mapping.is_none() {
            reader.report.diagnostics.push(findings::ego_missing(&dir.own_label()));
        }
        return None;
    };
    let seconds = |at: Option<&i64>| at.map_or(0.0, |&t| t as f64 / 1e9);
    if let Some(d) = implausible_span(
        &rows.label,
        seconds(rows.times.first()),
        seconds(rows.times.last()),
        rows.times.len(),
    ) {
        reader.report.diagnostics.push(d);
        return None;
    }
    let (mut clock, native) = Clock::of(&rows.times);
    if let Some(d) = implausible_step(&rows.label, native.native_step_s) {
        reader.report.diagnostics.push(d);
        return None;
    }
    if native.resampled() {
        reader.report.diagnostics.push(resampled(&rows.label, native.native_step_s));
    }
    rows.keep_covered(&mut clock);
    let ego = rows.at(&clock, &meta.ego);

    let mut missing = Vec::new();
    let (tracks, lacking) = match reader.sheet("objects", objects::REQUIRED) {
        Some(sheet) => objects::tracks(sheet, &clock, &mut reader),
        None => (Vec::new(), vec![Need::Objects]),
    };
    missing.extend(lacking);
    let map = road::read(&meta.map_complete_for, &mut reader);
    let lights = states::lights(&mut reader);
    reader.report.diagnostics.extend(unread(dir, mapping.map(|m| m.1)));
    let context = states::context(&mut reader);
    if !ego.length_m.is_finite() || !ego.width_m.is_finite() {
        missing.push(Need::EgoSize);
    }
    let bus = &ego.bus;
    let can = [
        (Need::VehicleSpeed, bus.speed_mps.is_empty()),
        (Need::SteeringAngle, bus.steering.is_empty()),
        (Need::Throttle, bus.throttle.is_empty()),
        (Need::Brake, bus.brake.is_empty()),
        (Need::Gear, bus.gear.is_empty()),
        (Need::TurnSignal, bus.turn_signal.is_empty()),
        (Need::EmergencyBraking, bus.aeb.is_empty()),
        (Need::Cruise, bus.cruise.is_empty()),
        (Need::Route, bus.route_command.is_empty()),
    ];
    if can.iter().all(|(_, absent)| *absent) {
        missing.push(Need::VehicleBus);
    } else {
        missing.extend(can.iter().filter(|(_, absent)| *absent).map(|(name, _)| *name));
    }
    for (name, absent) in [
        (Need::Map, map.is_none()),
        (Need::TrafficLights, lights.is_none()),
        (Need::WeatherAndSurface, context.is_none()),
    ] {
        if absent {
            missing.push(name);
        }
    }
    missing.push(Need::CameraPictures);
    missing.extend((!dated).then_some(Need::Date));

    let times = clock.frames.iter().map(|&t| Nanos(clock.origin).plus_secs(t)).collect();
    let stated = meta.drive_id.as_deref().unwrap_or(name);
    let drive_id = options.drive_id.clone().unwrap_or_else(|| {
        let id = drive_id(stated);
        reader.report.diagnostics.extend(renamed(&dir.own_label(), stated, &id));
        id
    });
    Some(Drive {
        meta: DriveMeta {
            drive_id,
            format: "table".into(),
            source: meta.source,
            place: meta.place,
            map_ref: meta.map_ref,
            licence: meta.licence.or_else(|| options.licence()),
            frame_of_reference: FrameOfReference::World,
            content_hash: reader.hash.finish(),
            video: Vec::new(),
            sensors: Vec::new(),
            can: can.iter().any(|(_, absent)| !absent),
            missing,
            ..DriveMeta::default()
        },
        times,
        ego: Some(ego),
        tracks,
        map,
        lights,
        context,
        media: None,
    })
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[FileReader {
    name: "table-mapping",
    read: |bytes| Mapping::read("mapping", &String::from_utf8_lossy(bytes)).0.is_some(),
}];
