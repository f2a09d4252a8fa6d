//! Stage 5: caps and weights for the training split, and its shortfalls. A leaf or L2 that is at or below its floor is
//! never thinned; rare samples are never repeated, only weighted.

use crate::item::{Dropped, Item, SplitName, Stage};
use crate::labels::Names;
use crate::spec::Balance;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_model::ScenarioId;
use whyroad_model::scene::DriveMeta;

/// Results of the stage; part of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BalanceReport {
    /// Training samples dropped over a cap.
    pub capped: usize,
    /// Cells of leaf x decisions x place in training.
    pub cells: usize,
    /// Classes below their floor.
    pub shortfalls: Vec<Shortfall>,
}

/// A class with too few training samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shortfall {
    /// L2 or leaf.
    pub scenario_id: String,
    /// Its floor.
    pub wanted: usize,
    /// Number of training samples.
    pub present: usize,
    /// File of the mining query, relative to the release; `None` when no mining rule finds the class.
    pub query: Option<String>,
}

/// Leaf, decisions, place.
type Cell<'a> = (u32, Option<u8>, Option<u8>, Option<&'a str>);

/// Facts about the drives, by index.
type Drives = BTreeMap<u32, DriveMeta>;

/// The cell of a sample. Its place is that of its drive (`groups.place`), not the cell of the grid that the split cuts,
/// in which a car that moves is alone. Samples without a known place are one place.
fn cell<'a>(item: &Item, drives: &'a Drives) -> Cell<'a> {
    let cut = item.cut.as_deref();
    let place = drives.get(&item.drive).and_then(|meta| meta.place.as_deref());
    (item.class, cut.and_then(|c| c.longitudinal), cut.and_then(|c| c.lateral), place)
}

/// Drops samples over a cap, sets the weights, and lists the shortfalls.
pub(crate) fn balance(
    items: &mut [Item],
    (classes, drives): (&Names, &Drives),
    framework: &Framework,
    spec: &Balance,
    seed: u64,
) -> BalanceReport {
    let mut report =
        BalanceReport { capped: cap(items, (classes, drives), spec, seed), ..BalanceReport::default() };
    let mut cells: BTreeMap<Cell<'_>, usize> = BTreeMap::new();
    for item in training(items) {
        *cells.entry(cell(item, drives)).or_default() += 1;
    }
    report.cells = cells.len();
    weigh(items, drives, &cells, spec);
    report.shortfalls = shortfalls(items, classes, framework, spec);
    report
}

fn training(items: &[Item]) -> impl Iterator<Item = &Item> {
    items.iter().filter(|i| i.kept() && i.split == Some(SplitName::Train))
}

fn cap(items: &mut [Item], (classes, drives): (&Names, &Drives), spec: &Balance, seed: u64) -> usize {
    let mut by_class: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut by_l2: BTreeMap<String, usize> = BTreeMap::new();
    for (i, item) in items.iter().enumerate() {
        if item.kept() && item.split == Some(SplitName::Train) {
            by_class.entry(item.class).or_default().push(i);
            *by_l2.entry(l2(classes.get(item.class))).or_default() += 1;
        }
    }
    let mut dropped = 0;
    for (class, mut members) in by_class {
        let name = l2(classes.get(class));
        // The order in which samples are kept: by a hash, so that it does not depend on time or drive.
        members.sort_by_cached_key(|&i| {
            let mut hash = blake3::Hasher::new();
            hash.update(&seed.to_le_bytes());
            hash.update(&items[i].id);
            *hash.finalize().as_bytes()
        });
        // Cells take turns, so that a cap thins the full cells first.
        let mut of_cell: BTreeMap<Cell<'_>, usize> = BTreeMap::new();
        let mut turns: Vec<(usize, usize)> = members
            .iter()
            .map(|&i| {
                let turn = of_cell.entry(cell(&items[i], drives)).or_default();
                *turn += 1;
                (*turn, i)
            })
            .collect();
        turns.sort_by_key(|t| t.0);
        let mut left = turns.len();
        for (turn, i) in turns.iter().rev() {
            let over_cell = spec.cap_cell.is_some_and(|cap| *turn > cap);
            let over_leaf = spec.cap_leaf.is_some_and(|cap| left > cap);
            let l2_left = by_l2.get(&name).copied().unwrap_or(0);
            if (over_cell || over_leaf) && left > spec.floor_leaf && l2_left > spec.floor_l2 {
                let reason = if over_cell { "cap_cell" } else { "cap_leaf" };
                items[*i].dropped = Some(Dropped::with(Stage::Balance, reason, classes.get(class)));
                left -= 1;
                by_l2.entry(name.clone()).and_modify(|n| *n -= 1);
                dropped += 1;
            }
        }
    }
    dropped
}

fn l2(class: &str) -> String {
    class.split('.').take(2).collect::<Vec<_>>().join(".")
}

/// The weight of a cell falls with its size to the power of the exponent; limited, with mean 1.
fn weigh(items: &mut [Item], drives: &Drives, cells: &BTreeMap<Cell<'_>, usize>, spec: &Balance) {
    let n: usize = cells.values().sum();
    if n == 0 {
        return;
    }
    let raw = |size: usize| (size as f64).powf(-spec.weight_exponent);
    // Smallest cells first: they have the greatest weights, so those that reach the limit come first. What they would
    // have above it goes to the others, in proportion.
    let mut sizes: Vec<usize> = cells.values().copied().collect();
    sizes.sort_unstable();
    let (mut left, mut sum) = (n as f64, sizes.iter().map(|&size| size as f64 * raw(size)).sum::<f64>());
    let mut scale = f64::INFINITY;
    for &size in &sizes {
        if left / sum * raw(size) <= spec.max_weight {
            scale = left / sum;
            break;
        }
        left -= size as f64 * spec.max_weight;
        sum -= size as f64 * raw(size);
    }
    let weight = |size: usize| (scale * raw(size)).min(spec.max_weight);
    for item in items.iter_mut().filter(|i| i.kept()) {
        item.weight = match (item.split, cells.get(&cell(item, drives))) {
            (Some(SplitName::Train), Some(&size)) => weight(size),
            _ => 1.0,
        };
    }
}

fn shortfalls(items: &[Item], classes: &Names, framework: &Framework, spec: &Balance) -> Vec<Shortfall> {
    let mut present: BTreeMap<ScenarioId, usize> = BTreeMap::new();
    for item in training(items) {
        if let Ok(id) = classes.get(item.class).parse::<ScenarioId>() {
            let whole = ScenarioId { l3: None, ..id.clone() };
            if id.is_leaf() {
                *present.entry(id).or_default() += 1;
            }
            *present.entry(whole).or_default() += 1;
        }
    }
    let mut out = Vec::new();
    for id in framework.taxonomy.ids() {
        let wanted = match (&id.l2, &id.l3) {
            (Some(_), None) => spec.floor_l2,
            (Some(_), Some(_)) => spec.floor_leaf,
            _ => 0,
        };
        let has = present.get(&id).copied().unwrap_or(0);
        if has < wanted {
            out.push(Shortfall { scenario_id: id.to_string(), wanted, present: has, query: None });
        }
    }
    out
}
