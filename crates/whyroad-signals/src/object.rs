//! Signals of any object and of pairs of near objects, including the ego as an object: derived only when a rule uses
//! them, and only the used ones. Definitions follow RefAV's functions if there is one (see `schema/signals.yaml`); none
//! of its code is used.

mod body;
mod lanes;
mod near;
mod pair;
mod scene;
mod single;

pub use near::PairClasses;
pub use scene::{Objects, WithPairs};

use crate::catalog::Catalog;
use crate::estimate::estimated;
use crate::estimate::with_possible_sizes;
use crate::needs::{missing, without_boxes};
use crate::road::network::Road;
use crate::series::seconds;
use body::Body;
use lanes::BodyLanes;
use scene::Scene;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::catalog::SignalScope;
use whyroad_model::pair::PairTable;
use whyroad_model::signal::{EGO_ID, TargetSpan};
use whyroad_model::{Column, Drive, Need, SignalTable};

/// A table of the `object.` and `pair.` signals that are `wanted`, and of `object.observed`. It has no other signals;
/// those that the drive cannot support are in `unavailable`. It contains pairs if `pairs` requires them.
pub fn derive_objects(
    drive: &Drive,
    wanted: &BTreeSet<String>,
    objects: Objects,
    pairs: WithPairs,
) -> SignalTable {
    let drive = with_possible_sizes(drive);
    let estimated = estimated(&drive);
    let drive = &*estimated.drive;
    let lacking = missing(drive);
    let times = seconds(drive);
    let ego = drive.ego.as_ref().filter(|_| objects == Objects::WithEgo);
    let bodies = body::bodies(drive, ego);
    let mut table = SignalTable {
        drive_id: drive.meta.drive_id.clone(),
        times: drive.times.clone(),
        targets: spans(drive, &bodies),
        without_boxes: without_boxes(drive),
        ..SignalTable::default()
    };
    let mut possible = BTreeSet::new();
    for def in Catalog::bundled().iter().filter(|d| d.scope.is_on_demand()) {
        let lacks: Vec<Need> = def.needs.iter().filter(|n| lacking.contains(n)).copied().collect();
        if def.name != OBSERVED && !wanted.contains(&def.name) {
            continue;
        }
        if lacks.is_empty() {
            possible.insert((def.scope == SignalScope::Pair, def.name.clone()));
        } else {
            table.unavailable.insert(def.name.clone(), lacks);
        }
    }
    let names = |of_pairs: bool| {
        possible.iter().filter(move |(p, _)| *p == of_pairs).map(|(_, n)| n.as_str()).collect::<Vec<_>>()
    };
    let on_map = possible.iter().any(|(_, n)| needs_map(n));
    let road = drive.map.as_ref().filter(|_| on_map && !lacking.contains(&Need::Map)).map(Road::new);
    let lanes = road.as_ref().map(|r| BodyLanes::new(r, &bodies));
    let scene = Scene { drive, times: &times, bodies: &bodies, road: road.as_ref(), lanes: lanes.as_ref() };
    let mut lost = Vec::new();
    for name in names(false) {
        match single::column(&scene, name) {
            Some(column) => drop(table.target_columns.insert(name.to_owned(), column)),
            None => lost.push(name),
        }
    }
    let between = match &pairs {
        WithPairs::No => None,
        WithPairs::Yes => Some(None),
        WithPairs::Between(classes) => Some(Some(classes)),
    };
    if let Some(between) = between {
        let mut found = pair_table(&scene, between, &names(true));
        let unknown = |columns: &BTreeMap<String, Column>| columns.values().any(|c| c.known_count() == 0);
        if between.is_some() && unknown(&found.0.columns) {
            found = pair_table(&scene, None, &names(true));
        }
        lost.extend(found.1);
        table.pairs = Some(found.0);
    }
    for name in lost {
        let needs = Catalog::bundled().get(name).map(|d| d.needs.clone()).unwrap_or_default();
        table.unavailable.insert(name.to_owned(), needs);
    }
    estimated.complete_objects(&mut table);
    table
}

/// The pairs of objects of these classes with these signals, and the signals that cannot be known.
fn pair_table<'n>(
    scene: &Scene<'_>,
    between: Option<&PairClasses>,
    names: &[&'n str],
) -> (PairTable, Vec<&'n str>) {
    let (spans, near) = near::pairs(scene.bodies, between);
    let (mut columns, mut lost) = (BTreeMap::new(), Vec::new());
    for name in names {
        match pair::column(scene, name, &spans, &near) {
            Some(column) => drop(columns.insert((*name).to_owned(), column)),
            None => lost.push(*name),
        }
    }
    (PairTable { spans, near, columns }, lost)
}

/// The signal that states in which frames an object was observed.
const OBSERVED: &str = "object.observed";

fn needs_map(name: &str) -> bool {
    Catalog::bundled().get(name).is_some_and(|d| d.needs.contains(&Need::Map))
}

fn spans(drive: &Drive, bodies: &[Body]) -> Vec<TargetSpan> {
    let mut first_row = 0;
    bodies
        .iter()
        .map(|b| {
            let id = match b.track {
                Some(i) => drive.tracks[i].id.clone(),
                None => EGO_ID.into(),
            };
            let span = TargetSpan { id, class: b.class, first_row, frames: b.frames };
            first_row += b.frames.len();
            span
        })
        .collect()
}
