//! Stage 4: exact duplicates by content, near-duplicates by descriptor: inside an L2 of one split, and across splits in
//! any L2. Of samples in different splits, the one in training is dropped, otherwise the one in validation.

pub mod search;
pub(crate) mod trace;

use crate::descriptor;
use crate::item::{Dropped, Item, SplitName, Stage, id_text};
use crate::labels::Names;
use crate::spec::Deduplicate;
use rayon::prelude::*;
use search::{Neighbors, Projection};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Similarities at which the curve is reported.
const CURVE: [f64; 8] = [0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99];

/// Results of the stage; part of the manifest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DedupReport {
    /// Exact duplicates dropped.
    pub exact: usize,
    /// Near-duplicates dropped inside a split.
    pub near_within: usize,
    /// Near-duplicates dropped because of another split.
    pub near_across: usize,
    /// For each threshold how many samples it would drop (exact duplicates not counted).
    pub curve: Vec<Threshold>,
}

/// A point of the similarity curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// Least similarity.
    pub similarity: f64,
    /// Samples that it would drop inside a split.
    pub within: usize,
    /// Samples that it would drop because of another split.
    pub across: usize,
}

/// Marks duplicates.
pub(crate) fn deduplicate(items: &mut [Item], classes: &Names, spec: &Deduplicate) -> DedupReport {
    let mut report = DedupReport::default();
    // In the order in which samples are kept: test, validation, training; checked first; then the better score; then
    // the id.
    let mut order: Vec<usize> = (0..items.len()).filter(|i| items[*i].kept()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&items[a], &items[b]);
        (b.split, b.checked)
            .cmp(&(a.split, a.checked))
            .then(b.score.total_cmp(&a.score))
            .then_with(|| a.id.cmp(&b.id))
    });
    if spec.exact {
        report.exact = exact(items, &order);
        order.retain(|i| items[*i].kept());
    }
    let l2: Vec<u32> = l2_of(classes);
    let vectors: Vec<&[f32]> =
        order.iter().map(|&i| items[i].cut.as_ref().map_or(&[][..], |c| c.descriptor.as_slice())).collect();
    let view: Vec<Member> = order
        .iter()
        .map(|&i| Member { split: items[i].split, l2: l2.get(items[i].class as usize).copied().unwrap_or(0) })
        .collect();
    let projection = Projection::of(&vectors);
    for similarity in CURVE {
        let Marked { within, across, .. } = mark(&vectors, &view, &projection, similarity);
        report.curve.push(Threshold { similarity, within, across });
    }
    if let Some(similarity) = spec.near {
        let marked = mark(&vectors, &view, &projection, similarity);
        (report.near_within, report.near_across) = (marked.within, marked.across);
        for (k, because) in marked.drops {
            let (item, kept) = (order[k], order[because]);
            let reason =
                if items[item].split == items[kept].split { "duplicate_near" } else { "duplicate_across" };
            let off = descriptor::distance(vectors_of(items, item), vectors_of(items, kept));
            let detail = format!("{:.4} like {}", descriptor::similarity(off), id_text(items[kept].id));
            items[item].dropped = Some(Dropped::with(Stage::Deduplicate, reason, detail));
        }
    }
    report
}

fn vectors_of(items: &[Item], i: usize) -> &[f32] {
    items[i].cut.as_ref().map_or(&[][..], |c| c.descriptor.as_slice())
}

fn exact(items: &mut [Item], order: &[usize]) -> usize {
    let mut first: HashMap<[u8; 16], usize> = HashMap::new();
    let mut n = 0;
    for &i in order {
        let Some(content) = items[i].cut.as_ref().map(|c| c.content) else { continue };
        match first.get(&content) {
            None => drop(first.insert(content, i)),
            Some(&kept) => {
                let detail = format!("same content as {}", id_text(items[kept].id));
                items[i].dropped = Some(Dropped::with(Stage::Deduplicate, "duplicate_exact", detail));
                n += 1;
            }
        }
    }
    n
}

/// Number of the L2 of each class.
fn l2_of(classes: &Names) -> Vec<u32> {
    let mut names = Names::default();
    let l2 = |class: &String| class.split('.').take(2).collect::<Vec<_>>().join(".");
    classes.all().iter().map(|c| names.put(&l2(c))).collect()
}

struct Member {
    split: Option<SplitName>,
    l2: u32,
}

#[derive(Default)]
struct Marked {
    within: usize,
    across: usize,
    /// Dropped member, and the kept one that it resembles.
    drops: Vec<(usize, usize)>,
}

/// Members that are compared with the kept ones at once, on all cores.
const BATCH: usize = 4096;

/// Greedy in the order of the members: each is kept unless it resembles one that was kept before. Exact, and the same
/// on any number of cores: a batch is compared in parallel with the members kept before it, then with itself in order.
fn mark(vectors: &[&[f32]], members: &[Member], projection: &Projection, similarity: f64) -> Marked {
    let radius = descriptor::distance_of(similarity);
    let mut out = Marked::default();
    let mut kept = Neighbors::new(vectors, projection, radius);
    let resembles = |k: usize| {
        move |j: u32| {
            let other = &members[j as usize];
            members[k].split != other.split || members[k].l2 == other.l2
        }
    };
    for start in (0..members.len()).step_by(BATCH) {
        let batch = start..(start + BATCH).min(members.len());
        let found: Vec<Option<u32>> =
            batch.clone().into_par_iter().map(|k| kept.find(vectors[k], resembles(k))).collect();
        let mut fresh = Neighbors::new(vectors, projection, radius);
        for (k, before) in batch.zip(found) {
            match before.or_else(|| fresh.find(vectors[k], resembles(k))) {
                None => {
                    fresh.insert(k as u32);
                    kept.insert(k as u32);
                }
                Some(because) => {
                    if members[k].split == members[because as usize].split {
                        out.within += 1;
                    } else {
                        out.across += 1;
                    }
                    out.drops.push((k, because as usize));
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests;
