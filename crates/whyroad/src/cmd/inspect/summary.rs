//! Counting what a drive holds. No judgement: numbers of clips, objects, features, and how much of each signal is
//! known.

use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_lake::clip_metadata;
use whyroad_model::messages::clip::ClipMetadata;
use whyroad_model::{Drive, FrameRange, Need, SignalTable};

/// One drive, or one clip of it.
#[derive(Serialize)]
pub(super) struct DriveSummary {
    pub drive_id: String,
    pub format: String,
    pub place: Option<String>,
    pub licence: Option<String>,
    pub clips: Vec<ClipMetadata>,
    pub ego: Option<EgoSummary>,
    /// By class.
    pub objects: BTreeMap<String, ObjectCount>,
    /// Features by kind.
    pub map: Option<BTreeMap<String, usize>>,
    pub tables: Vec<&'static str>,
    pub missing: Vec<Need>,
    /// Signals that the log supports.
    pub signals: BTreeMap<String, SignalShare>,
    /// Signals that it does not support, with what they need.
    pub unavailable: BTreeMap<String, Vec<Need>>,
}

#[derive(Serialize)]
pub(super) struct EgoSummary {
    pub length_m: f64,
    pub width_m: f64,
    pub min_speed_mps: f64,
    pub max_speed_mps: f64,
}

#[derive(Default, Serialize)]
pub(super) struct ObjectCount {
    pub objects: usize,
    pub rows: usize,
}

/// How much of a signal is known.
#[derive(Serialize)]
pub(super) struct SignalShare {
    pub known: usize,
    pub rows: usize,
}

impl DriveSummary {
    /// Counts `drive`, or only its clip `clip`.
    pub fn new(drive: &Drive, clip: Option<&str>) -> Self {
        let mut clips = clip_metadata(drive);
        let mut frames = FrameRange::new(0, drive.frame_count());
        if let Some(index) = clip.and_then(|id| clips.iter().position(|c| c.clip_id == id)) {
            frames = drive.clips()[index];
            clips = vec![clips.swap_remove(index)];
        }
        let table = whyroad_signals::derive(drive);
        let meta = &drive.meta;
        Self {
            drive_id: meta.drive_id.0.clone(),
            format: meta.format.clone(),
            place: meta.place.clone(),
            licence: meta.licence.clone(),
            clips,
            ego: ego(drive, frames),
            objects: objects(drive, frames),
            map: map(drive),
            tables: tables(drive),
            missing: meta.missing.clone(),
            signals: signals(&table, frames),
            unavailable: table.unavailable,
        }
    }
}

fn ego(drive: &Drive, frames: FrameRange) -> Option<EgoSummary> {
    let ego = drive.ego.as_ref()?;
    let speeds = (frames.start..frames.end).map(|f| ego.motion.speed(f)).filter(|v| !v.is_nan());
    // NaN becomes null in JSON where no speed is known.
    let (min, max) = speeds.fold((f64::NAN, f64::NAN), |(a, b), v| (a.min(v), b.max(v)));
    Some(EgoSummary { length_m: ego.length_m, width_m: ego.width_m, min_speed_mps: min, max_speed_mps: max })
}

fn objects(drive: &Drive, frames: FrameRange) -> BTreeMap<String, ObjectCount> {
    let mut counts: BTreeMap<String, ObjectCount> = BTreeMap::new();
    for t in &drive.tracks {
        let rows = t.frames.iter().filter(|&&f| frames.contains(f as usize)).count();
        if rows > 0 {
            let c = counts.entry(t.class.id().to_owned()).or_default();
            c.objects += 1;
            c.rows += rows;
        }
    }
    counts
}

fn map(drive: &Drive) -> Option<BTreeMap<String, usize>> {
    let m = drive.map.as_ref()?;
    let all = [
        ("lanes", m.lanes.len()),
        ("lanes in junctions", m.lanes.iter().filter(|l| l.in_junction).count()),
        ("crosswalks", m.crosswalks.len()),
        ("junctions", m.junctions.len()),
        ("drivable areas", m.drivable_areas.len()),
        ("stop lines", m.stop_lines.len()),
        ("signs", m.signs.len()),
        ("facilities", m.facilities.len()),
    ];
    Some(all.into_iter().filter(|(_, n)| *n > 0).map(|(k, n)| (k.to_owned(), n)).collect())
}

fn tables(drive: &Drive) -> Vec<&'static str> {
    let optional = [
        ("ego", drive.ego.is_some()),
        ("map", drive.map.is_some()),
        ("lights", drive.lights.is_some()),
        ("context", drive.context.is_some()),
        ("media", drive.media.is_some()),
    ];
    let there = optional.into_iter().filter(|(_, has)| *has).map(|(name, _)| name);
    ["clips", "frames", "tracks"].into_iter().chain(there).collect()
}

fn signals(table: &SignalTable, frames: FrameRange) -> BTreeMap<String, SignalShare> {
    let mut out = BTreeMap::new();
    for (name, column) in &table.frame_columns {
        let known = (frames.start..frames.end).filter(|&f| column.is_known(f)).count();
        out.insert(name.clone(), SignalShare { known, rows: frames.len() });
    }
    let rows: Vec<usize> = table
        .targets
        .iter()
        .flat_map(|t| {
            let there = t.frames.intersect(frames);
            (there.start..there.end.max(there.start)).filter_map(|f| t.row(f)).collect::<Vec<_>>()
        })
        .collect();
    for (name, column) in &table.target_columns {
        let known = rows.iter().filter(|&&r| column.is_known(r)).count();
        out.insert(name.clone(), SignalShare { known, rows: rows.len() });
    }
    out
}
