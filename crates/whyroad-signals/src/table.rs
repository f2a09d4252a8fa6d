//! Collects columns into a [`SignalTable`]. What a column is, and whether the log can support it, the catalogue
//! says; a family only computes.

use crate::catalogue::{Catalogue, Scope, SignalKind};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::road_map::{Lane, LaneMark};
use whyroad_model::scene::FrameOfReference;
use whyroad_model::signal::TargetSpan;
use whyroad_model::vocabulary::{FACILITY_KINDS, SIGN_KINDS};
use whyroad_model::{Column, Drive, ObjectClass, SignalTable, Tri};

/// What this log lacks, in the words of [`crate::catalogue::NEEDS`].
pub fn missing(drive: &Drive) -> BTreeSet<&'static str> {
    let mut missing = BTreeSet::new();
    let ego = drive.ego.as_ref().filter(|e| e.motion.x.iter().any(|x| x.is_finite()));
    if ego.is_none() || drive.meta.frame_of_reference == FrameOfReference::Ego {
        missing.insert("ego pose");
    }
    if drive.map.as_ref().is_none_or(|m| m.lanes.is_empty()) {
        missing.insert("map");
    }
    if drive.lights.is_none() {
        missing.insert("traffic lights");
    }
    if !drive.meta.can && ego.is_none_or(|e| !has_bus(&e.bus)) {
        missing.insert("vehicle bus");
    }
    // A log without any track has nothing whose size could be missing.
    let sized = |t: &whyroad_model::scene::Track| t.length_m.iter().any(|l| l.is_finite());
    let ego_sized = ego.is_none_or(|e| e.length_m.is_finite() && e.width_m.is_finite());
    if !ego_sized || (!drive.tracks.is_empty() && !drive.tracks.iter().any(sized)) {
        missing.insert("object sizes");
    }
    // A radar tells no classes: that none of its targets is a vehicle, or a pedestrian, would claim too much.
    if !drive.tracks.is_empty() && drive.tracks.iter().all(|t| t.class == ObjectClass::Unknown) {
        missing.insert("object classes");
    }
    if !drive.tracks.iter().any(|t| !t.turn_signal.is_empty()) {
        missing.insert("turn signals");
    }
    if !drive.tracks.iter().any(|t| t.interior_points.iter().any(|n| n.is_finite())) {
        missing.insert("visibility");
    }
    missing.extend(missing_of_road(drive));
    missing.extend(missing_context(drive));
    missing
}

/// What the map, the heights and the route do not tell.
fn missing_of_road(drive: &Drive) -> impl Iterator<Item = &'static str> {
    let map = drive.map.as_ref();
    let ego_z = drive.ego.iter().any(|e| e.motion.z.iter().any(|z| z.is_finite()));
    let road_z = map.is_some_and(|m| m.lanes.iter().any(|l| l.centre.iter().any(|p| p.z.is_finite())));
    let routed = drive.ego.iter().any(|e| e.bus.route_command.iter().any(Option::is_some))
        || states(drive, "route_distance");
    let marked = |l: &Lane| l.left_mark != LaneMark::Unknown || l.right_mark != LaneMark::Unknown;
    let marks = states(drive, "lane_marks") || map.is_some_and(|m| m.lanes.iter().any(marked));
    [
        ("elevation", ego_z || road_z),
        ("routing", routed),
        ("lane marks", marks),
        ("signs", map.is_some_and(|m| SIGN_KINDS.iter().any(|k| m.tells(k)))),
        ("facilities", map.is_some_and(|m| FACILITY_KINDS.iter().any(|k| m.tells(k)))),
    ]
    .into_iter()
    .filter_map(|(need, there)| (!there).then_some(need))
}

/// Needs that one kind of context state meets each; a log that never states the kind lacks it.
const CONTEXT_NEEDS: [(&str, &str); 10] = [
    ("weather", "weather"),
    ("surface", "surface"),
    ("lighting", "lighting"),
    ("road type", "road_type"),
    ("construction state", "construction"),
    ("accident state", "accident"),
    ("warning light", "warning_light"),
    ("gate state", "gate"),
    ("navigation limit", "nav_speed_limit"),
    ("pavement", "pavement"),
];

fn missing_context(drive: &Drive) -> impl Iterator<Item = &'static str> {
    // What another kind of state, or the lanes' tags, tell as well.
    let also = |need: &str| match need {
        "weather" => states(drive, "visibility"),
        "pavement" => drive.map.iter().flat_map(|m| &m.lanes).any(|l| l.is_tagged("unpaved")),
        _ => false,
    };
    let lacks =
        move |(need, kind): (&'static str, &str)| (!states(drive, kind) && !also(need)).then_some(need);
    CONTEXT_NEEDS.into_iter().filter_map(lacks)
}

/// True when the log states `kind` at least once.
fn states(drive: &Drive, kind: &str) -> bool {
    drive.context.iter().flatten().any(|s| s.kind == kind)
}

fn has_bus(bus: &whyroad_model::scene::EgoBus) -> bool {
    !(bus.brake.is_empty() && bus.turn_signal.is_empty() && bus.aeb.is_empty() && bus.steering.is_empty())
}

/// A signal table in the making.
pub struct TableBuilder<'a> {
    catalogue: &'a Catalogue,
    table: SignalTable,
    rows: usize,
}

impl<'a> TableBuilder<'a> {
    /// An empty table for `drive`: one target a track, dense from its first to its last frame.
    pub fn new(catalogue: &'a Catalogue, drive: &Drive) -> Self {
        let mut rows = 0;
        let mut targets = Vec::with_capacity(drive.tracks.len());
        for track in drive.tracks.iter().filter(|t| !t.frames.is_empty()) {
            let frames = track.span();
            targets.push(TargetSpan { id: track.id.clone(), class: track.class, first_row: rows, frames });
            rows += frames.len();
        }
        let table = SignalTable {
            drive_id: drive.meta.drive_id.clone(),
            times: drive.times.clone(),
            targets,
            ..SignalTable::default()
        };
        Self { catalogue, table, rows }
    }

    /// Number of target rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The targets, in row order.
    pub fn targets(&self) -> &[TargetSpan] {
        &self.table.targets
    }

    /// A number of target `k` already in the table, in `frame`; NaN where there is none.
    pub fn target_number(&self, name: &str, k: usize, frame: usize) -> f64 {
        let row = self.table.targets[k].row(frame);
        let column = self.table.target_columns.get(name);
        row.zip(column).and_then(|(row, c)| c.number(row)).unwrap_or(f64::NAN)
    }

    /// A column already in the table.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.table.frame_columns.get(name).or_else(|| self.table.target_columns.get(name))
    }

    /// Adds a number signal; one value a frame or target row.
    pub fn number(&mut self, name: &str, values: Vec<f64>) {
        self.add(name, Column::Number(values));
    }

    /// Adds a flag signal.
    pub fn flag(&mut self, name: &str, values: Vec<Tri>) {
        self.add(name, Column::Flag(values));
    }

    /// Adds a category signal from indices into the catalogue's values; `None` is unknown.
    pub fn category(&mut self, name: &str, codes: impl IntoIterator<Item = Option<u16>>) {
        let names = match self.catalogue.get(name).map(|d| &d.kind) {
            Some(SignalKind::Category(names)) => names.clone(),
            _ => std::sync::Arc::from([]),
        };
        let codes = codes.into_iter().map(|c| c.unwrap_or(UNKNOWN_CODE)).collect();
        self.add(name, Column::Category { codes, names });
    }

    fn add(&mut self, name: &str, column: Column) {
        let Some(def) = self.catalogue.get(name) else { return };
        let (columns, rows) = match def.scope {
            Scope::Frame => (&mut self.table.frame_columns, self.table.times.len()),
            Scope::Target => (&mut self.table.target_columns, self.rows),
        };
        debug_assert_eq!(column.len(), rows, "{name}");
        columns.insert(def.name.clone(), column);
    }

    /// The finished table: what the log cannot support is named instead of given. A signal that nothing computed is
    /// named with what it lacks, or with all that it needs when each part is there but not enough of it.
    pub fn finish(mut self, missing: &BTreeSet<&'static str>) -> SignalTable {
        let mut unavailable = BTreeMap::new();
        for def in self.catalogue.iter() {
            // A bus that never reports a channel lacks it: "AEB never seen active" must not read as "never active".
            let silent = |need: &String| {
                need == "vehicle bus"
                    && self.table.frame_columns.get(&def.name).is_none_or(|c| c.known_count() == 0)
            };
            let mut lacking: Vec<String> =
                def.needs.iter().filter(|n| missing.contains(n.as_str()) || silent(n)).cloned().collect();
            let computed = self.table.frame_columns.contains_key(&def.name)
                || self.table.target_columns.contains_key(&def.name);
            if lacking.is_empty() && !computed {
                lacking.clone_from(&def.needs);
            }
            if !lacking.is_empty() || !computed {
                self.table.frame_columns.remove(&def.name);
                self.table.target_columns.remove(&def.name);
                unavailable.insert(def.name.clone(), lacking);
            }
        }
        self.table.unavailable = unavailable;
        self.table
    }
}
