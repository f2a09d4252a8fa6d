//! A release migrated when classes are renamed, merged or split: a new release with the same samples, splits and
//! images, other classes, and its own hashes. The old one stays unchanged. Samples that need a person's decision are
//! left out and listed; tables of the stages are those of the build.

use crate::aside::empty_partial;
use crate::freeze::manifest::{Counts, FileEntry, Manifest};
use crate::freeze::{
    CARD, CHARTS, CHECKSUMS, CROISSANT, DATA, MANIFEST, QUERIES, card, checksums, croissant, shards,
};
use crate::item::{SplitName, hex, id_text};
use crate::labels::sample_id;
use crate::sample::Sample;
use crate::spec::Images;
use crate::split::{Counted, value_of_sample};
use crate::{DatasetError, Release};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use whyroad_framework::mapping::ClassMapping;
use whyroad_label::carry::{Carried, carry};
use whyroad_model::ScenarioId;

/// File with the samples that were left out, in the new release.
pub const UNDECIDED: &str = "undecided.jsonl";
/// Reasons in the manifest's counts, below `6-migrate`.
const STAGE: &str = "6-migrate";

/// The changes made, or those of a dry run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CarriedRelease {
    /// Samples whose class has another id, by class before and after.
    pub moved: BTreeMap<String, BTreeMap<String, u64>>,
    /// Samples of which only secondary classes changed.
    pub secondary: u64,
    /// Samples that need a person's decision.
    pub undecided: Vec<UndecidedSample>,
    /// Samples left out because another of the same drive and keyframe has the class now.
    pub repeated: Vec<String>,
    /// Samples of the new release.
    pub samples: usize,
}

/// A sample that needs a person's decision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct UndecidedSample {
    /// Its id in the old release.
    pub sample_id: String,
    /// Its drive.
    pub drive_id: String,
    /// Its clip.
    pub clip_id: String,
    /// Its task, where it comes from the labeling service.
    pub task_id: Option<String>,
    /// Class before.
    pub from: String,
    /// Classes to choose from.
    pub parts: Vec<String>,
}

/// Migrates `release` into the folder `out`, which must not exist; `None` writes nothing.
///
/// # Errors
/// When a file cannot be read or written, or `out` exists.
pub fn carry_release(
    release: &Release,
    mapping: &ClassMapping,
    out: Option<&Path>,
) -> Result<CarriedRelease, DatasetError> {
    let mut done = CarriedRelease::default();
    let mut ids: BTreeSet<String> = BTreeSet::new();
    let Some(out) = out else {
        for sample in release.samples(None) {
            one(sample?, mapping, &mut done, &mut ids);
        }
        return Ok(done);
    };
    if out.exists() {
        return Err(DatasetError::Exists(out.to_owned()));
    }
    // Written to a temporary folder and renamed, so it appears atomically.
    let aside = empty_partial(out)?;
    let manifest = write(release, mapping, &aside, &mut done, &mut ids)?;
    finish(&aside, manifest)?;
    fs::rename(&aside, out).map_err(DatasetError::io(out))?;
    Ok(done)
}

fn write(
    release: &Release,
    mapping: &ClassMapping,
    dir: &Path,
    done: &mut CarriedRelease,
    ids: &mut BTreeSet<String>,
) -> Result<Manifest, DatasetError> {
    let mut manifest = release.manifest.clone();
    let made_again = [MANIFEST, CHECKSUMS, CROISSANT, CARD, UNDECIDED];
    for entry in &release.manifest.files {
        let path = entry.path.as_str();
        let (from, to) = (release.dir().join(path), dir.join(path));
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(DatasetError::io(parent))?;
        }
        let below = |folder: &str| path.starts_with(&format!("{folder}/"));
        if made_again.contains(&path) || below(DATA) || below(CHARTS) || below(QUERIES) {
            continue;
        }
        fs::copy(&from, &to).map_err(DatasetError::io(&from))?;
    }
    fs::create_dir_all(dir.join(DATA)).map_err(DatasetError::io(dir))?;
    let rows = match manifest.spec.sample.images {
        Images::None => shards::ROWS,
        _ => shards::ROWS_WITH_IMAGES,
    };
    let dropped = std::mem::take(&mut manifest.counts.dropped);
    let splits = manifest.counts.by_split.keys().map(|k| (k.clone(), 0)).collect();
    let alike_traces = manifest.counts.alike_traces;
    manifest.counts = Counts { dropped, by_split: splits, alike_traces, ..Counts::default() };
    let mut licensed: BTreeMap<String, (BTreeSet<String>, usize)> = BTreeMap::new();
    let mut in_file: BTreeMap<String, usize> = BTreeMap::new();
    let mut in_split: Vec<Counted> = Vec::new();
    let by = manifest.split.by.clone();
    for file in release.data_files(None) {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut kept = 0;
        let counts = &mut manifest.counts;
        let licensed = &mut licensed;
        let samples = of_file(&file)?.filter_map(|sample| {
            let carried = match sample {
                Ok(sample) => one(sample, mapping, done, ids)?,
                Err(e) => return Some(Err(e)),
            };
            kept += 1;
            count(counts, &carried);
            if let Some(split) = SplitName::of_name(&carried.split) {
                let unknown = by.iter().copied().filter(|key| value_of_sample(&carried, *key).is_none());
                in_split.push((split, carried.groups.component, unknown.collect()));
            }
            let of = licensed.entry(carried.groups.licence.clone()).or_default();
            of.0.insert(carried.lineage.drive_id.clone());
            of.1 += 1;
            Some(Ok(carried))
        });
        shards::write(&dir.join(DATA).join(&name), rows, samples)?;
        in_file.insert(format!("{DATA}/{name}"), kept);
    }
    for (reason, n) in [("undecided", done.undecided.len()), ("repeated_label", done.repeated.len())] {
        if n > 0 {
            manifest.counts.dropped.entry(STAGE.to_owned()).or_default().insert(reason.to_owned(), n);
        }
    }
    manifest.split.count(in_split.into_iter());
    manifest.licences.retain_mut(|l| {
        let of = licensed.get(&l.id);
        (l.drives, l.samples) = of.map_or((0, 0), |(drives, samples)| (drives.len(), *samples));
        of.is_some()
    });
    let lines: Vec<String> = done.undecided.iter().filter_map(|u| serde_json::to_string(u).ok()).collect();
    let path = dir.join(UNDECIDED);
    fs::write(&path, lines.join("\n") + if lines.is_empty() { "" } else { "\n" })
        .map_err(DatasetError::io(&path))?;
    manifest.version = format!("{}+taxonomy-{}", manifest.version, mapping.to);
    manifest.versions.insert("taxonomy".into(), mapping.to.clone());
    manifest.versions.insert("class_mapping".into(), mapping.mark.clone());
    manifest.files = in_file
        .into_iter()
        .map(|(path, n)| FileEntry { path, bytes: 0, sha256: String::new(), samples: Some(n) })
        .collect();
    shortfalls(&mut manifest, mapping);
    Ok(manifest)
}

fn count(counts: &mut Counts, s: &Sample) {
    counts.samples += 1;
    *counts.by_split.entry(s.split.clone()).or_default() += 1;
    *counts.by_class.entry(s.scenario_id.clone()).or_default().entry(s.split.clone()).or_default() += 1;
    let place = s.groups.place.clone().unwrap_or_else(|| "unknown".to_owned());
    *counts.by_place.entry(place).or_default() += 1;
    *counts.by_status.entry(s.lineage.label_status.clone()).or_default() += 1;
    let word = |d: &Option<String>| d.clone().unwrap_or_else(|| "null".to_owned());
    *counts.by_decision.entry(format!("{} / {}", word(&s.longitudinal), word(&s.lateral))).or_default() += 1;
    counts.images += s.images.len();
}

fn of_file(path: &Path) -> Result<impl Iterator<Item = Result<Sample, DatasetError>>, DatasetError> {
    let path = path.to_owned();
    let batches = crate::release::open(&path, None)?;
    Ok(batches.flat_map(move |batch| {
        let read = batch
            .and_then(|b| crate::sample::schema::from_batch(&b).map_err(|e| DatasetError::broken(&path, e)));
        match read {
            Ok(samples) => samples.into_iter().map(Ok).collect::<Vec<_>>(),
            Err(e) => vec![Err(e)],
        }
    }))
}

/// The sample with its class after; `None` when it is left out.
fn one(
    mut sample: Sample,
    mapping: &ClassMapping,
    done: &mut CarriedRelease,
    ids: &mut BTreeSet<String>,
) -> Option<Sample> {
    // A label that is not JSON has no class to migrate.
    let mut label: serde_json::Value = serde_json::from_str(&sample.label_json).unwrap_or_default();
    let carried = carry(mapping, &mut label);
    match &carried {
        Carried::Same => {}
        Carried::Undecided { from, parts, .. } => {
            done.undecided.push(UndecidedSample {
                sample_id: sample.sample_id,
                drive_id: sample.lineage.drive_id,
                clip_id: sample.lineage.clip_id,
                task_id: sample.lineage.task_id,
                from: from.to_string(),
                parts: parts.iter().map(ToString::to_string).collect(),
            });
            return None;
        }
        Carried::Moved { to, .. } | Carried::Secondary { class: to } => {
            put(&mut sample, to, &label, mapping);
        }
    }
    if !ids.insert(sample.sample_id.clone()) {
        done.repeated.push(sample.sample_id);
        return None;
    }
    done.secondary += u64::from(matches!(carried, Carried::Secondary { .. }));
    if let Carried::Moved { from, to } = &carried {
        *done.moved.entry(from.to_string()).or_default().entry(to.to_string()).or_default() += 1;
    }
    done.samples += 1;
    Some(sample)
}

fn put(sample: &mut Sample, to: &ScenarioId, label: &serde_json::Value, mapping: &ClassMapping) {
    sample.l1.clone_from(&to.l1);
    sample.l2 = to.l2.clone().unwrap_or_default();
    sample.l3.clone_from(&to.l3);
    sample.scenario_id = to.to_string();
    let listed = label["secondary_scenarios"].as_array().into_iter().flatten();
    sample.secondary_scenarios = listed.filter_map(|id| id.as_str().map(str::to_owned)).collect();
    sample.label_json = label.to_string();
    sample.lineage.label_sha256 = hex(&Sha256::digest(sample.label_json.as_bytes()));
    sample.lineage.taxonomy_version = Some(mapping.to.clone());
    let other = |text: &String| -> Option<String> {
        let mut label: serde_json::Value = serde_json::from_str(text).ok()?;
        carry(mapping, &mut label);
        Some(label.to_string())
    };
    if let Some(text) = sample.label_json_other.as_ref().and_then(other) {
        sample.label_json_other = Some(text);
    }
    for rejected in &mut sample.rejected {
        if let Some(text) = other(&rejected.label_json) {
            rejected.label_json = text;
        }
    }
    // The same id that a build from the carried labels gives.
    sample.sample_id =
        id_text(sample_id(&sample.lineage.drive_id, sample.lineage.keyframe_time_ns, &sample.scenario_id));
}

/// Floors of removed classes do not apply; queries were made from the old rules.
fn shortfalls(manifest: &mut Manifest, mapping: &ClassMapping) {
    manifest
        .balance
        .shortfalls
        .retain(|s| s.scenario_id.parse::<ScenarioId>().is_ok_and(|id| mapping.change(&id).is_none()));
    manifest.balance.shortfalls.iter_mut().for_each(|s| s.query = None);
}

/// Card, charts, metadata and hashes of a release whose data are written.
fn finish(dir: &Path, mut manifest: Manifest) -> Result<(), DatasetError> {
    let put = |path: &str, text: &str| {
        let path = dir.join(path);
        fs::write(&path, text).map_err(DatasetError::io(&path))
    };
    let charts = dir.join(CHARTS);
    fs::create_dir_all(&charts).map_err(DatasetError::io(&charts))?;
    for (name, svg) in card::charts(&manifest) {
        put(&format!("{CHARTS}/{name}"), &svg)?;
    }
    put(CARD, &card::card(&manifest))?;
    let samples: BTreeMap<String, Option<usize>> =
        manifest.files.iter().map(|f| (f.path.clone(), f.samples)).collect();
    let mut paths = checksums::files_below(dir)?;
    for own in [MANIFEST, CHECKSUMS, CROISSANT] {
        paths.remove(own);
    }
    manifest.files = checksums::entries(dir, &paths)?;
    for entry in &mut manifest.files {
        entry.samples = samples.get(&entry.path).copied().flatten();
    }
    put(CROISSANT, &croissant::croissant(&manifest))?;
    manifest.files.extend(checksums::entries(dir, &[CROISSANT.to_owned()].into())?);
    manifest.files.sort_by(|a, b| a.path.cmp(&b.path));
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| DatasetError::broken(dir, e))?;
    put(MANIFEST, &format!("{text}\n"))?;
    let (bytes, sha256) = checksums::sum(&dir.join(MANIFEST))?;
    let mut listed = manifest.files.clone();
    listed.push(FileEntry { path: MANIFEST.into(), bytes, sha256, samples: None });
    listed.sort_by(|a, b| a.path.cmp(&b.path));
    put(CHECKSUMS, &checksums::listing(&listed))
}
