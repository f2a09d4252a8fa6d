//! Stage 3: train, validation and test by groups. Samples that share a group key, directly or through others, are one
//! connected component and never separated. Nothing has been dropped as a duplicate or over a cap before this.

mod components;
mod distance;
mod keep;

pub use distance::Distance;
pub(crate) use distance::distances;
pub(crate) use keep::Keep;
pub use keep::KeptSplits;

use crate::DatasetError;
use crate::item::{DAY_NS, Item, SplitName, id_text};
use crate::labels::Names;
use crate::place;
use crate::sample::Sample;
use crate::spec::{GroupKey, Split};
use components::Components;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use whyroad_model::Nanos;
use whyroad_model::scene::DriveMeta;

/// The split of the release; part of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SplitReport {
    /// Requested keys.
    pub by: Vec<GroupKey>,
    /// Number of connected components.
    pub components: usize,
    /// Samples of the largest one.
    pub largest_component: usize,
    /// Samples whose group by this key is unknown; they are grouped by their drive.
    pub unknown: BTreeMap<String, usize>,
    /// Samples per split.
    pub samples: BTreeMap<String, usize>,
    /// Shares per split.
    pub shares: BTreeMap<String, f64>,
    /// How near the splits are to each other.
    pub distances: Vec<Distance>,
    /// The earlier release whose splits were kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<KeptSplits>,
}

/// A sample as the report counts it: its split, its component, the requested keys that are unknown.
pub(crate) type Counted = (SplitName, u32, Vec<GroupKey>);

impl SplitReport {
    /// Replaces all numbers but the distances.
    pub(crate) fn count(&mut self, samples: impl Iterator<Item = Counted>) {
        let mut of_component: BTreeMap<u32, usize> = BTreeMap::new();
        let mut of_split = SplitName::ALL.map(|s| (s.name().to_owned(), 0_usize));
        self.unknown.clear();
        for (split, component, unknown) in samples {
            *of_component.entry(component).or_default() += 1;
            of_split[split as usize].1 += 1;
            for key in unknown {
                *self.unknown.entry(key_name(key).to_owned()).or_default() += 1;
            }
        }
        self.components = of_component.len();
        self.largest_component = of_component.values().copied().max().unwrap_or(0);
        let total = of_component.values().sum::<usize>().max(1) as f64;
        self.samples = of_split.into();
        self.shares = self.samples.iter().map(|(s, n)| (s.clone(), *n as f64 / total)).collect();
    }
}

/// What the values of group keys of items come from.
#[derive(Clone, Copy)]
pub(crate) struct Facts<'a> {
    /// Drives by index.
    pub drives: &'a Names,
    /// Place cells by index.
    pub cells: &'a Names,
    /// Facts about the drives, by index.
    pub meta: &'a BTreeMap<u32, DriveMeta>,
}

impl Facts<'_> {
    /// The value of a key, as a finished sample states it; `None` where it is unknown.
    fn value(&self, item: &Item, key: GroupKey) -> Option<String> {
        let meta = self.meta.get(&item.drive);
        match key {
            GroupKey::Drive => Some(self.drives.get(item.drive).to_owned()),
            GroupKey::Session => meta?.session.clone(),
            GroupKey::Vehicle => meta?.vehicle.clone(),
            GroupKey::Place => {
                Some(item.place_cell).filter(|c| *c != u32::MAX).map(|c| self.cells.get(c).to_owned())
            }
            GroupKey::Date if meta.is_some_and(|m| !m.is_dated()) => None,
            GroupKey::Date => {
                let start = Nanos(i64::from(item.cut.as_ref()?.day) * DAY_NS);
                start.to_string().get(..10).map(str::to_owned)
            }
        }
    }
}

/// Every kept item, for the report.
pub(crate) fn counted<'a>(
    items: &'a [Item],
    facts: Facts<'a>,
    by: &'a [GroupKey],
) -> impl Iterator<Item = Counted> + 'a {
    items.iter().filter(|i| i.kept()).filter_map(move |item| {
        let unknown = by.iter().filter(|key| facts.value(item, **key).is_none());
        Some((item.split?, item.component, unknown.copied().collect()))
    })
}

/// The same of a finished sample.
pub(crate) fn value_of_sample(sample: &Sample, key: GroupKey) -> Option<String> {
    let g = &sample.groups;
    match key {
        GroupKey::Drive => Some(sample.lineage.drive_id.clone()),
        GroupKey::Session => g.session.clone(),
        GroupKey::Vehicle => g.vehicle.clone(),
        GroupKey::Place => g.place_cell.clone(),
        GroupKey::Date => g.date.clone(),
    }
}

/// Assigns every kept item to a split; `cells` gets the names of the place cells. The report counts these items. With
/// `keep`, what an earlier release has stays where it is there.
///
/// # Errors
/// When the groups of the spec join splits of the earlier release.
pub(crate) fn split(
    items: &mut [Item],
    (drives, meta): (&Names, &BTreeMap<u32, DriveMeta>),
    spec: &Split,
    seed: u64,
    cells: &mut Names,
    keep: Option<(&std::path::Path, &Keep)>,
) -> Result<SplitReport, DatasetError> {
    for item in items.iter_mut().filter(|i| i.kept()) {
        if let Some(position) = item.cut.as_ref().and_then(|c| c.position.as_ref()) {
            item.place_cell = cells.put(&place::cell(position, spec));
        }
    }
    let facts = Facts { drives, cells, meta };
    let mut between = 0;
    let (kept, groups, held) = loop {
        let kept: Vec<usize> = (0..items.len()).filter(|i| items[*i].kept()).collect();
        let groups = grouped(items, &kept, facts, spec);
        let Some((dir, keep)) = keep else {
            let free = vec![None; groups.len()];
            break (kept, groups, free);
        };
        let ties = keep.ties(items, &kept, &spec.by, facts);
        let of_group = |members: &Vec<usize>| -> BTreeSet<SplitName> {
            members.iter().flat_map(|&k| ties[k].iter().copied()).collect()
        };
        let torn: Vec<&Vec<usize>> = groups.iter().filter(|g| of_group(g).len() > 1).collect();
        if torn.is_empty() {
            let held = groups.iter().map(|g| of_group(g).into_iter().next()).collect();
            break (kept, groups, held);
        }
        // First the samples that are tied to two splits themselves; where the splits are joined by a chain of new
        // samples, all new ones of the chain.
        let new = |k: &&usize| !keep.has(&items[kept[**k]]);
        let bridges: Vec<usize> =
            torn.iter().flat_map(|g| g.iter().filter(new)).filter(|k| ties[**k].len() > 1).copied().collect();
        let out: Vec<usize> = match bridges.is_empty() {
            false => bridges,
            true => torn.iter().flat_map(|g| g.iter().filter(new)).copied().collect(),
        };
        if out.is_empty() {
            let first = torn.first().and_then(|g| g.first()).map(|&k| id_text(items[kept[k]].id));
            return Err(keep::torn(dir, torn.len(), &first.unwrap_or_default()));
        }
        between += out.len();
        out.iter().for_each(|&k| keep::leave_out(&mut items[kept[k]]));
    };
    let chosen = assign(&groups, &held, &kept, items, spec, seed);
    for (component, (members, split)) in groups.iter().zip(&chosen).enumerate() {
        for &k in members {
            let item = &mut items[kept[k]];
            item.component = component as u32;
            item.split = Some(*split);
        }
    }
    let samples = groups.iter().zip(&held).filter(|(_, h)| h.is_some()).map(|(g, _)| g.len()).sum();
    let mut report = SplitReport {
        by: spec.by.clone(),
        kept: keep.map(|(_, keep)| KeptSplits { samples, between, ..keep.about.clone() }),
        ..SplitReport::default()
    };
    report.count(counted(items, facts, &spec.by));
    Ok(report)
}

/// The connected components of `kept`.
fn grouped(items: &[Item], kept: &[usize], facts: Facts<'_>, spec: &Split) -> Vec<Vec<usize>> {
    let mut components = Components::new(kept.len());
    let mut first: HashMap<(GroupKey, String), usize> = HashMap::new();
    for (k, &i) in kept.iter().enumerate() {
        let item = &items[i];
        for key in spec.by.iter().chain([&GroupKey::Drive]) {
            if let Some(value) = facts.value(item, *key) {
                let other = *first.entry((*key, value)).or_insert(k);
                components.join(k, other);
            }
        }
    }
    if spec.by.contains(&GroupKey::Place) {
        let points = kept.iter().map(|&i| items[i].cut.as_ref().and_then(|c| c.position.as_ref())).collect();
        let grid = place::Grid::new(points, spec.min_distance_m);
        for (k, &i) in kept.iter().enumerate() {
            if let Some(position) = items[i].cut.as_ref().and_then(|c| c.position.as_ref()) {
                grid.near(position, |other| {
                    components.join(k, other as usize);
                    true
                });
            }
        }
    }
    components.groups()
}

pub(crate) fn key_name(key: GroupKey) -> &'static str {
    match key {
        GroupKey::Drive => "drive",
        GroupKey::Session => "session",
        GroupKey::Vehicle => "vehicle",
        GroupKey::Place => "place",
        GroupKey::Date => "date",
    }
}

/// Largest components first; each goes to the split that needs its classes most and overshoots least. Those that are
/// `held` in a split are in it before.
fn assign(
    groups: &[Vec<usize>],
    held: &[Option<SplitName>],
    kept: &[usize],
    items: &[Item],
    spec: &Split,
    seed: u64,
) -> Vec<SplitName> {
    let shares = [spec.train, spec.val, spec.test];
    let mut of_class: HashMap<u32, f64> = HashMap::new();
    for &i in kept {
        *of_class.entry(items[i].class).or_default() += 1.0;
    }
    let total = kept.len() as f64;
    let mut filled = [0.0_f64; 3];
    let mut filled_class: [HashMap<u32, f64>; 3] = Default::default();
    let key = |g: usize| {
        let first = groups[g].first().map(|&k| items[kept[k]].id).unwrap_or_default();
        let mut hash = blake3::Hasher::new();
        hash.update(&seed.to_le_bytes());
        hash.update(&first);
        *hash.finalize().as_bytes()
    };
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_cached_key(|&g| (held[g].is_none(), std::cmp::Reverse(groups[g].len()), key(g)));
    let mut out = vec![SplitName::Train; groups.len()];
    for g in order {
        let size = groups[g].len() as f64;
        let mut classes: BTreeMap<u32, f64> = BTreeMap::new();
        for &k in &groups[g] {
            *classes.entry(items[kept[k]].class).or_default() += 1.0;
        }
        let score = |s: usize| {
            if shares[s] <= 0.0 {
                return f64::NEG_INFINITY;
            }
            let need: f64 = classes
                .iter()
                .map(|(class, n)| {
                    let target = shares[s] * of_class.get(class).copied().unwrap_or(0.0);
                    let missing = target - filled_class[s].get(class).copied().unwrap_or(0.0);
                    n * (missing / target.max(1e-9)).max(-1.0)
                })
                .sum();
            let target = shares[s] * total;
            let over = (filled[s] + size - target).max(0.0) / target.max(1e-9);
            let room = (target - filled[s]) / target.max(1e-9);
            need / size + room - 4.0 * over
        };
        // With equal scores the first is chosen: the training split.
        let mut best = 0;
        for s in 1..3 {
            if score(s) > score(best) + 1e-9 {
                best = s;
            }
        }
        if let Some(split) = held[g] {
            best = split as usize;
        }
        filled[best] += size;
        for (class, n) in classes {
            *filled_class[best].entry(class).or_default() += n;
        }
        out[g] = SplitName::ALL[best];
    }
    out
}
