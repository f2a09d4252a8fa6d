//! Statistics of a lake: numbers of clips, objects, map features, and how much of each signal is known.

use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_lake::{Lake, LakeError, SignalFile, clip_metadata, cut_clip};
use whyroad_model::messages::clip::ClipMetadata;
use whyroad_model::road_map::{LayerState, MapLayer};
use whyroad_model::scene::{Ego, FrameOfReference};
use whyroad_model::signal::is_deviation;
use whyroad_model::{ClipId, Drive, DriveId, FrameRange, Need, SignalId, SignalTable};
use whyroad_signals::Catalog;
use whyroad_signals::estimate;
use whyroad_signals::estimate::{LogNoise, Noise};

/// One drive, or one clip of it.
#[derive(Clone, Debug, Serialize)]
pub struct DriveSummary {
    /// Its id.
    pub drive_id: String,
    /// Format of the log.
    pub format: String,
    /// Where it was recorded; `None` is unknown.
    pub place: Option<String>,
    /// License of the recording; `None` is unknown.
    pub licence: Option<String>,
    /// Its clips.
    pub clips: Vec<ClipMetadata>,
    /// The ego; `None` where the log has no ego pose.
    pub ego: Option<EgoSummary>,
    /// Noise of the measurements, estimated from the log; `None` where there are no poses over ground.
    pub noise: Option<NoiseSummary>,
    /// Tracks by class, as the log has them.
    pub objects: BTreeMap<String, ObjectCount>,
    /// Number of objects after tracks that break off and go on under another id are joined: those that signals and
    /// rules are about.
    pub joined_objects: usize,
    /// Features by kind.
    pub map: Option<BTreeMap<String, usize>>,
    /// How much of each layer the map has.
    pub map_layers: BTreeMap<MapLayer, LayerState>,
    /// Tables that the drive has.
    pub tables: Vec<&'static str>,
    /// What the log lacks.
    pub missing: Vec<Need>,
    /// Signals that the log supports.
    pub signals: BTreeMap<String, SignalShare>,
    /// Signals that it does not support, with the needs that the log lacks; empty where the log has a part of each, but
    /// too little for this signal.
    pub unavailable: BTreeMap<String, Vec<Need>>,
    /// Signals among `signals` that are known only where other data proves them, with the needs that the log lacks.
    pub partial: BTreeMap<String, Vec<Need>>,
}

/// The ego's size and speeds.
#[derive(Clone, Debug, Serialize)]
pub struct EgoSummary {
    /// Length of its box, m.
    pub length_m: f64,
    /// Width of its box, m.
    pub width_m: f64,
    /// Lowest known speed, m/s; NaN where none is known.
    pub min_speed_mps: f64,
    /// Highest known speed, m/s.
    pub max_speed_mps: f64,
}

/// Noise by kind of object: standard deviations.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseSummary {
    /// Of the ego's pose; `None` without an ego.
    pub ego: Option<NoiseOf>,
    /// Of motor vehicles and two-wheelers.
    pub vehicles: NoiseOf,
    /// Of people and everything else.
    pub others: NoiseOf,
}

/// Noise of the measurements of one kind of object.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseOf {
    /// Of a coordinate, m: independent from row to row, and correlated over a second.
    pub position_m: [f64; 2],
    /// Of the heading, degrees, likewise.
    pub heading_deg: [f64; 2],
    /// Of a component of stated velocities, m/s, likewise.
    pub velocity_mps: [f64; 2],
    /// True when all of it is too small to need smoothing.
    pub exact: bool,
}

impl NoiseOf {
    fn new(noise: &LogNoise) -> Self {
        let both = |n: &Noise, scale: f64| [n.white, n.correlated].map(|v| (v * scale * 1e4).round() / 1e4);
        Self {
            position_m: both(&noise.position, 1.0),
            heading_deg: both(&noise.heading, 1f64.to_degrees()),
            velocity_mps: both(&noise.velocity, 1.0),
            exact: noise.is_negligible(),
        }
    }
}

fn noise(drive: &Drive) -> Option<NoiseSummary> {
    if drive.meta.frame_of_reference == FrameOfReference::Ego {
        return None;
    }
    let noise = estimate::noise(drive);
    Some(NoiseSummary {
        ego: drive.ego.is_some().then(|| NoiseOf::new(&noise.ego)),
        vehicles: NoiseOf::new(&noise.vehicles),
        others: NoiseOf::new(&noise.others),
    })
}

/// Tracks of one class.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ObjectCount {
    /// Tracks.
    pub objects: usize,
    /// Their observations.
    pub rows: usize,
}

/// Coverage of a signal.
#[derive(Clone, Debug, Serialize)]
pub struct SignalShare {
    /// Rows with a known value.
    pub known: usize,
    /// All rows.
    pub rows: usize,
}

impl DriveSummary {
    /// Counts a drive of the lake, or only its clip `clip`. Signals are read from the lake where it stores them.
    pub fn read(lake: &Lake, id: &DriveId, clip: Option<&str>) -> Result<Self, LakeError> {
        let drive = lake.read_drive(id)?;
        let noise = noise(&drive);
        let mut clips = clip_metadata(&drive);
        let mut frames = FrameRange::new(0, drive.frame_count());
        let id_of_clip = clip.map(|id| ClipId(id.to_owned()));
        let of_clip = id_of_clip.and_then(|c| Some((c.frames(id, &drive.times)?, c)));
        if let Some((range, clip)) = &of_clip {
            frames = *range;
            clips = clips.first().map(|any| cut_clip(any, &drive.times, clip, *range)).into_iter().collect();
        }
        // For a whole drive the statistics in the files' footers are enough.
        let stored = lake.signals(id, whyroad_signals::VERSION)?.filter(|_| of_clip.is_none());
        let stored = stored.and_then(|file| {
            let targets = file.contents().drives.first()?.targets.len();
            Some((stored_shares(&file)?, stored_speeds(&file)?, targets))
        });
        let (Shares { signals, unavailable, partial }, speeds, joined_objects) = match stored {
            Some(of_whole_drive) => of_whole_drive,
            None => {
                let table = crate::drives::signals_of(lake, id)?;
                let speeds = speeds(&estimate(&drive), frames);
                let seen = table.targets.iter().filter(|t| !t.frames.intersect(frames).is_empty()).count();
                let signals = shares(&table, frames);
                let SignalTable { unavailable, partial, .. } = table;
                (Shares { signals, unavailable, partial }, speeds, seen)
            }
        };
        let (unavailable, partial) = lacking(unavailable, partial, &signals);
        let meta = &drive.meta;
        Ok(Self {
            drive_id: meta.drive_id.0.clone(),
            format: meta.format.clone(),
            place: meta.place.clone(),
            licence: meta.licence.clone(),
            clips,
            ego: ego(&drive, speeds),
            noise,
            objects: objects(&drive, frames),
            joined_objects,
            map: map(&drive),
            map_layers: drive.map.as_ref().map(|m| m.layers.clone()).unwrap_or_default(),
            tables: tables(&drive),
            missing: meta.missing.clone(),
            signals,
            unavailable,
            partial,
        })
    }
}

/// All drives of a lake together.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LakeSummary {
    /// Number of drives.
    pub drives: usize,
    /// Number of clips.
    pub clips: usize,
    /// Hours that were recorded.
    pub hours: f64,
    /// Drives by format.
    pub formats: BTreeMap<String, usize>,
    /// Tracks by class, as the logs have them.
    pub objects: BTreeMap<String, ObjectCount>,
    /// Drives by the table that they have.
    pub tables: BTreeMap<&'static str, usize>,
}

impl LakeSummary {
    /// Adds a drive.
    pub fn add(&mut self, drive: &DriveSummary) {
        self.drives += 1;
        self.clips += drive.clips.len();
        // Of frames: gaps of the log were not recorded.
        self.hours +=
            drive.clips.iter().map(|c| f64::from(c.total_frames) / c.frame_rate).sum::<f64>() / 3600.0;
        *self.formats.entry(drive.format.clone()).or_default() += 1;
        for (class, count) in &drive.objects {
            let all = self.objects.entry(class.clone()).or_default();
            all.objects += count.objects;
            all.rows += count.rows;
        }
        for table in &drive.tables {
            *self.tables.entry(table).or_default() += 1;
        }
    }
}

/// Signals with the needs that the log lacks.
type Lacking = BTreeMap<String, Vec<Need>>;

/// The needs that the log lacks: those that no signal with a value proves to be present. A partial one proves none.
fn lacking(
    mut unavailable: Lacking,
    mut partial: Lacking,
    signals: &BTreeMap<String, SignalShare>,
) -> (Lacking, Lacking) {
    let known = |name: &str| signals.get(name).is_some_and(|share| share.known > 0);
    let valued = |name: &str| known(name) && !partial.contains_key(name);
    let there: BTreeSet<Need> = Catalog::bundled()
        .iter()
        .filter(|def| valued(&def.name))
        .flat_map(|def| def.needs.iter().copied())
        .collect();
    for needs in unavailable.values_mut().chain(partial.values_mut()) {
        needs.retain(|n| !there.contains(n));
    }
    (unavailable, partial)
}

/// Coverage of each signal, and the signals that the log cannot support, or only in part.
struct Shares {
    signals: BTreeMap<String, SignalShare>,
    unavailable: Lacking,
    partial: Lacking,
}

/// By the statistics of the stored columns; `None` where a file states none.
fn stored_shares(file: &SignalFile) -> Option<Shares> {
    let share = |name: &str| {
        let range = file.range(0, name)?;
        Some((name.to_owned(), SignalShare { known: range.known, rows: range.rows }))
    };
    let signals =
        file.signals(0).into_iter().filter(|name| !is_deviation(name)).map(share).collect::<Option<_>>()?;
    let of = file.contents().drives.first()?;
    Some(Shares { signals, unavailable: of.unavailable.clone(), partial: of.partial.clone() })
}

/// The signals that a drive does not support, or only in part, each with the data that its log lacks (see
/// [`DriveSummary::unavailable`] and [`DriveSummary::partial`]); `None` where the lake stores no signals of the drive.
pub fn unavailable(lake: &Lake, id: &DriveId) -> Result<Option<BTreeMap<String, Vec<Need>>>, LakeError> {
    let file = lake.signals(id, whyroad_signals::VERSION)?;
    let stored = file.and_then(|file| stored_shares(&file));
    Ok(stored.map(|Shares { signals, unavailable, partial }| {
        let (unavailable, partial) = lacking(unavailable, partial, &signals);
        unavailable.into_iter().chain(partial).collect()
    }))
}

/// Lowest and highest speed of the ego, m/s; NaN, which becomes null in JSON, where no speed is known.
type Speeds = (f64, f64);

/// Of the stored signal; `None` where its column has no statistics.
fn stored_speeds(file: &SignalFile) -> Option<Speeds> {
    match file.range(0, SignalId::EgoSpeed.name()) {
        Some(range) if range.known > 0 => range.bounds,
        _ => Some((f64::NAN, f64::NAN)),
    }
}

fn speeds(estimated: &Drive, frames: FrameRange) -> Speeds {
    let of = |ego: &Ego| {
        let known = (frames.start..frames.end).map(|f| ego.motion.speed(f)).filter(|v| !v.is_nan());
        known.fold((f64::NAN, f64::NAN), |(low, high), v| (v.min(low), v.max(high)))
    };
    estimated.ego.as_ref().map_or((f64::NAN, f64::NAN), of)
}

fn ego(drive: &Drive, (min, max): Speeds) -> Option<EgoSummary> {
    let ego = drive.ego.as_ref()?;
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
    let mut counts: BTreeMap<String, usize> =
        all.into_iter().filter(|(_, n)| *n > 0).map(|(k, n)| (k.to_owned(), n)).collect();
    for facility in &m.facilities {
        *counts.entry(format!("facilities/{}", facility.kind)).or_default() += 1;
    }
    Some(counts)
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

fn shares(table: &SignalTable, frames: FrameRange) -> BTreeMap<String, SignalShare> {
    let mut out = BTreeMap::new();
    for (name, column) in table.frame_columns.iter().filter(|(name, _)| !is_deviation(name)) {
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
    for (name, column) in table.target_columns.iter().filter(|(name, _)| !is_deviation(name)) {
        let known = rows.iter().filter(|&&r| column.is_known(r)).count();
        out.insert(name.clone(), SignalShare { known, rows: rows.len() });
    }
    out
}
