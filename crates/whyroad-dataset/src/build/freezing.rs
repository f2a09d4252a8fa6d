//! Stage 6: writes everything into the work folder's release.

use super::{State, Step};
use crate::DatasetError;
use crate::balance::{BalanceReport, Shortfall};
use crate::dedup::{DedupReport, trace};
use crate::freeze::manifest::{Counts, FORMAT, FORMAT_VERSION, FileEntry, Inputs, LicenceCount, Manifest};
use crate::freeze::tables::{self, StageRow, stage_columns};
use crate::freeze::{
    CARD, CHARTS, CHECKSUMS, CROISSANT, DATA, MANIFEST, QUERIES, SPEC, STAGES, card, checksums, croissant,
    shards,
};
use crate::item::{Item, SplitName, Stage, hex, id_text};
use crate::records::read_record;
use crate::sample::{SAMPLE_VERSION, Sample};
use crate::spec::Images;
use crate::split::SplitReport;
use arrow_schema::DataType;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};

type Reports = (SplitReport, DedupReport, BalanceReport);

/// Writes the release and returns its manifest.
pub(super) fn freeze(
    state: &mut State<'_>,
    label_names: &[String],
    (split, deduplicate, mut balance): Reports,
    progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
) -> Result<Manifest, DatasetError> {
    let dir = state.work.release();
    for name in [DATA, STAGES, QUERIES, CHARTS] {
        let path = dir.join(name);
        fs::create_dir_all(&path).map_err(DatasetError::io(&path))?;
    }
    let samples_of = data(state, &dir, progress)?;
    stages(state, &dir, &deduplicate)?;
    let alike_traces = traces(state, &dir)?;
    shortfalls(state, &dir, &mut balance)?;
    put(&dir.join(SPEC), &state.inputs.spec_text)?;

    let spec = state.inputs.spec.clone();
    let counts = counts(state, alike_traces);
    let licences = licences(state);
    let ids: BTreeSet<String> = licences.iter().map(|l| l.id.clone()).collect();
    let licence = state
        .inputs
        .licences
        .declared(&ids, spec.licences.purpose)
        .map_err(|d| DatasetError::Refused(vec![*d]))?;
    let taxonomy = &state.inputs.framework.taxonomy.version;
    let mut manifest = Manifest {
        format: FORMAT.into(),
        format_version: FORMAT_VERSION.into(),
        sample_version: SAMPLE_VERSION.into(),
        name: spec.name.clone(),
        version: spec.version.clone(),
        title: spec.title.clone(),
        created_by: format!("whyroad {}", env!("CARGO_PKG_VERSION")),
        versions: [
            ("taxonomy", taxonomy.clone()),
            ("messages", whyroad_model::FORMAT_VERSION.to_owned()),
            ("signals", whyroad_engine::SIGNALS_VERSION.to_owned()),
            ("licences", state.inputs.licences.version.clone()),
            ("lake", whyroad_lake::LAKE_VERSION.to_string()),
        ]
        .map(|(k, v)| (k.to_owned(), v))
        .into(),
        seed: spec.seed,
        licence,
        licences,
        inputs: made_from(state, label_names),
        counts,
        split,
        deduplicate,
        balance,
        spec,
        files: Vec::new(),
    };
    for (name, svg) in card::charts(&manifest) {
        put(&dir.join(CHARTS).join(name), &svg)?;
    }
    put(&dir.join(CARD), &card::card(&manifest))?;
    let mut paths = checksums::files_below(&dir)?;
    for own in [MANIFEST, CHECKSUMS, CROISSANT] {
        paths.remove(own);
    }
    manifest.files = checksums::entries(&dir, &paths)?;
    for entry in &mut manifest.files {
        entry.samples = samples_of.get(&entry.path).copied();
    }
    let text = croissant::croissant(&manifest);
    put(&dir.join(CROISSANT), &text)?;
    manifest.files.extend(checksums::entries(&dir, &[CROISSANT.to_owned()].into())?);
    manifest.files.sort_by(|a, b| a.path.cmp(&b.path));
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| DatasetError::broken(&dir, e))?;
    put(&dir.join(MANIFEST), &format!("{text}\n"))?;
    let (bytes, sha256) = checksums::sum(&dir.join(MANIFEST))?;
    let mut listed = manifest.files.clone();
    listed.push(FileEntry { path: MANIFEST.into(), bytes, sha256, samples: None });
    listed.sort_by(|a, b| a.path.cmp(&b.path));
    put(&dir.join(CHECKSUMS), &checksums::listing(&listed))?;
    Ok(manifest)
}

fn put(path: &Path, text: &str) -> Result<(), DatasetError> {
    fs::write(path, text).map_err(DatasetError::io(path))
}

/// Items of a split in their shuffled order.
fn shuffled(items: &[Item], split: SplitName, seed: u64) -> Vec<usize> {
    let mut out: Vec<usize> =
        (0..items.len()).filter(|i| items[*i].kept() && items[*i].split == Some(split)).collect();
    out.sort_by_cached_key(|&i| {
        let mut hash = blake3::Hasher::new();
        hash.update(b"order");
        hash.update(&seed.to_le_bytes());
        hash.update(&items[i].id);
        *hash.finalize().as_bytes()
    });
    out
}

/// The samples' files; samples per file.
fn data(
    state: &State<'_>,
    dir: &Path,
    progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
) -> Result<BTreeMap<String, usize>, DatasetError> {
    let spec = &state.inputs.spec;
    let orders = SplitName::ALL.map(|s| (s, shuffled(&state.labels.items, s, spec.seed)));
    let mut jobs = Vec::new();
    for (split, order) in &orders {
        for shard in shards::shards(split.name(), order.len(), spec.samples_per_shard) {
            jobs.push((shard.name, &order[shard.range]));
        }
    }
    let rows = if spec.sample.images == Images::None { shards::ROWS } else { shards::ROWS_WITH_IMAGES };
    let (done, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    jobs.par_iter().with_max_len(1).try_for_each(|(name, members)| {
        if stopped.load(Ordering::Relaxed) {
            return Err(DatasetError::Stopped);
        }
        let path = dir.join(DATA).join(name);
        // Already present: an interrupted build with the same inputs wrote it.
        if !path.exists() {
            shards::write(&path, rows, members.iter().map(|&i| finished(state, &state.labels.items[i])))?;
        }
        let n = done.fetch_add(1, Ordering::Relaxed) + 1;
        if !progress(Step::Write, n, jobs.len()) {
            stopped.store(true, Ordering::Relaxed);
        }
        Ok(())
    })?;
    if stopped.load(Ordering::Relaxed) {
        return Err(DatasetError::Stopped);
    }
    Ok(jobs.iter().map(|(name, members)| (format!("{DATA}/{name}"), members.len())).collect())
}

/// The sample with the results of the stages after the cut.
fn finished(state: &State<'_>, item: &Item) -> Result<Sample, DatasetError> {
    let path = state.work.samples(item.drive as usize);
    let at = item.cut.as_ref().map(|c| c.at).unwrap_or_default();
    let mut sample: Sample = read_record(&path, at)?;
    sample.split = item.split.map_or("", SplitName::name).to_owned();
    sample.weight = item.weight;
    sample.groups.component = item.component;
    sample.groups.place_cell =
        (item.place_cell != u32::MAX).then(|| state.cells.get(item.place_cell).to_owned());
    Ok(sample)
}

/// Rows of a stage: every candidate that reached it.
fn rows_of<'a>(state: &'a State<'_>, stage: Stage) -> impl Iterator<Item = StageRow> + 'a {
    let reached = move |i: &&Item| i.dropped.as_ref().is_none_or(|d| d.stage >= stage);
    state.labels.items.iter().filter(reached).map(move |item| {
        let here = item.dropped.as_ref().filter(|d| d.stage == stage);
        let after = stage >= Stage::Split;
        StageRow {
            sample_id: Some(id_text(item.id)),
            drive_id: Some(state.labels.drives.get(item.drive).to_owned()),
            keyframe_time_ns: Some(item.keyframe_ns),
            scenario_id: state.labels.classes.get(item.class).to_owned(),
            label_status: Some(state.labels.statuses.get(item.status).to_owned()),
            split: item.split.filter(|_| after).map(|s| s.name().to_owned()),
            component: after.then_some(item.component),
            weight: (stage == Stage::Balance && here.is_none()).then_some(item.weight),
            kept: here.is_none(),
            reason: here.map(|d| d.reason.to_string()),
            detail: here.and_then(|d| d.detail.as_deref().map(str::to_owned)),
        }
    })
}

#[derive(Serialize)]
struct CurveRow {
    similarity: f64,
    dropped_within: u64,
    dropped_across: u64,
}

fn stages(state: &State<'_>, dir: &Path, dedup: &DedupReport) -> Result<(), DatasetError> {
    for stage in Stage::ALL {
        let path = dir.join(STAGES).join(format!("{}.parquet", stage.name()));
        let lines = state.labels.dropped.iter().filter(|_| stage == Stage::Select).map(|line| StageRow {
            sample_id: None,
            drive_id: Some(crate::labels::drive_of(&line.clip_id).to_owned()).filter(|d| !d.is_empty()),
            keyframe_time_ns: None,
            scenario_id: line.scenario_id.clone(),
            label_status: None,
            split: None,
            component: None,
            weight: None,
            kept: false,
            reason: Some(line.dropped.reason.to_string()),
            detail: Some(format!(
                "{}: {}",
                file_name(&line.line),
                line.dropped.detail.as_deref().unwrap_or_default()
            )),
        });
        tables::write(&path, stage_columns(), rows_of(state, stage).chain(lines))?;
    }
    let columns = vec![
        ("similarity", DataType::Float64),
        ("dropped_within", DataType::UInt64),
        ("dropped_across", DataType::UInt64),
    ];
    let rows = dedup.curve.iter().map(|t| CurveRow {
        similarity: t.similarity,
        dropped_within: t.within as u64,
        dropped_across: t.across as u64,
    });
    tables::write(&dir.join(STAGES).join("similarity.parquet"), columns, rows)
}

#[derive(Serialize)]
struct TraceRow {
    group: u32,
    sample_id: String,
    split: String,
    similarity: f64,
    trace: String,
}

/// Near-identical traces: groups, and traces in them.
fn traces(state: &State<'_>, dir: &Path) -> Result<[usize; 2], DatasetError> {
    let kept: Vec<&Item> = state.labels.items.iter().filter(|i| i.kept()).collect();
    let sketches: Vec<_> = kept.iter().map(|i| i.cut.as_ref().map_or([0; 16], |c| c.sketch)).collect();
    let text = |k: usize| -> Result<String, DatasetError> {
        let sample = finished(state, kept[k])?;
        Ok(sample.trace_zh.or(sample.trace_en).unwrap_or_default())
    };
    let groups = trace::groups(&sketches, state.inputs.spec.deduplicate.traces, text)?;
    let columns = vec![
        ("group", DataType::UInt32),
        ("sample_id", DataType::Utf8),
        ("split", DataType::Utf8),
        ("similarity", DataType::Float64),
        ("trace", DataType::Utf8),
    ];
    let mut rows = Vec::new();
    for (g, group) in groups.iter().enumerate() {
        for (k, similarity) in group {
            rows.push(TraceRow {
                group: g as u32,
                sample_id: id_text(kept[*k].id),
                split: kept[*k].split.map_or("", SplitName::name).to_owned(),
                similarity: *similarity,
                trace: text(*k)?,
            });
        }
    }
    let n = rows.len();
    tables::write(&dir.join(STAGES).join("traces.parquet"), columns, rows.into_iter())?;
    Ok([groups.len(), n])
}

/// A mining query for each class with too few samples.
fn shortfalls(state: &mut State<'_>, dir: &Path, balance: &mut BalanceReport) -> Result<(), DatasetError> {
    for short in &mut balance.shortfalls {
        let Ok(id) = short.scenario_id.parse::<ScenarioId>() else { continue };
        if let Some(query) = (state.inputs.queries)(&id, short.wanted - short.present) {
            let name = format!("{QUERIES}/{id}.json");
            let text = serde_json::to_string_pretty(&query).map_err(|e| DatasetError::broken(dir, e))?;
            put(&dir.join(&name), &format!("{text}\n"))?;
            short.query = Some(name);
        }
    }
    if !balance.shortfalls.is_empty() {
        state.diagnostics.push(shortfall(&balance.shortfalls));
    }
    Ok(())
}

/// Classes that the note about shortfalls names.
const NAMED: usize = 10;

/// How many classes are short, and which of them have no query.
fn shortfall(shortfalls: &[Shortfall]) -> Diagnostic {
    let without: Vec<&str> =
        shortfalls.iter().filter(|s| s.query.is_none()).map(|s| s.scenario_id.as_str()).collect();
    let (n, written) = (shortfalls.len(), shortfalls.len() - without.len());
    let mut message = Bilingual::new(
        format!("{n} 个类别的训练样本低于下限；{written} 个挖掘查询写入 {QUERIES}/"),
        format!(
            "{n} classes have fewer training samples than their floor; {written} mining queries are in {QUERIES}/"
        ),
    );
    if without.is_empty() {
        return Diagnostic::note("dataset.shortfall", message);
    }
    let list = without[..without.len().min(NAMED)].join(", ");
    let more = without.len().saturating_sub(NAMED);
    let (rest_zh, rest_en) = if more > 0 {
        (format!(" 等 {} 个", without.len()), format!(" and {more} more"))
    } else {
        Default::default()
    };
    message.zh += &format!("；没有规则能找到、因此没有查询的类别：{list}{rest_zh}");
    message.en += &format!("; without a query, because no mining rule finds them: {list}{rest_en}");
    Diagnostic::note("dataset.shortfall", message).with_hint(Bilingual::new(
        "为这些类别编写挖掘规则（docs/how-to/write-a-rule.zh.md），或人工标注样本",
        "write a mining rule for these classes (docs/how-to/write-a-rule.md), or label samples of them by hand",
    ))
}

fn counts(state: &State<'_>, alike_traces: [usize; 2]) -> Counts {
    let mut out = Counts { alike_traces, ..Counts::default() };
    for split in SplitName::ALL {
        out.by_split.insert(split.name().to_owned(), 0);
    }
    let labels = &state.labels;
    for item in &labels.items {
        if let Some(d) = &item.dropped {
            let of_stage = out.dropped.entry(d.stage.name().to_owned()).or_default();
            *of_stage.entry(d.reason.to_string()).or_default() += 1;
            continue;
        }
        out.samples += 1;
        let split = item.split.map_or("", SplitName::name).to_owned();
        *out.by_split.entry(split.clone()).or_default() += 1;
        let class = labels.classes.get(item.class).to_owned();
        *out.by_class.entry(class).or_default().entry(split).or_default() += 1;
        let meta = state.selected.drives.get(&item.drive);
        let place = meta.and_then(|m| m.place.clone()).unwrap_or_else(|| "unknown".to_owned());
        *out.by_place.entry(place).or_default() += 1;
        *out.by_status.entry(labels.statuses.get(item.status).to_owned()).or_default() += 1;
        if let Some(cut) = &item.cut {
            out.images += usize::from(cut.images);
            let along = cut
                .longitudinal
                .map_or("null", |i| whyroad_model::decision::Longitudinal::ALL[i as usize].id());
            let across =
                cut.lateral.map_or("null", |i| whyroad_model::decision::Lateral::ALL[i as usize].id());
            *out.by_decision.entry(format!("{along} / {across}")).or_default() += 1;
        }
    }
    for line in &labels.dropped {
        let of_stage = out.dropped.entry(Stage::Select.name().to_owned()).or_default();
        *of_stage.entry(line.dropped.reason.to_string()).or_default() += 1;
    }
    out
}

fn licences(state: &State<'_>) -> Vec<LicenceCount> {
    let mut by_id: BTreeMap<&str, (BTreeSet<u32>, usize)> = BTreeMap::new();
    for item in state.labels.items.iter().filter(|i| i.kept()) {
        if let Some(id) = state.selected.licences.get(&item.drive) {
            let of = by_id.entry(id).or_default();
            of.0.insert(item.drive);
            of.1 += 1;
        }
    }
    let about = |(id, (drives, samples)): (&str, (BTreeSet<u32>, usize))| {
        let known = state.inputs.licences.find(id);
        LicenceCount {
            id: id.to_owned(),
            url: known.and_then(|l| l.url.clone()),
            attribution: known.and_then(|l| l.attribution.clone()),
            assumed: drives.intersection(&state.selected.assumed).count(),
            drives: drives.len(),
            samples,
        }
    };
    by_id.into_iter().map(about).collect()
}

fn made_from(state: &State<'_>, label_names: &[String]) -> Inputs {
    let mut hash = blake3::Hasher::new();
    let mut drives: Vec<(&str, &str)> = state
        .selected
        .drives
        .iter()
        .map(|(d, m)| (state.labels.drives.get(*d), m.content_hash.as_str()))
        .collect();
    drives.sort_unstable();
    for (id, content) in &drives {
        hash.update(format!("{id} {content}\n").as_bytes());
    }
    Inputs {
        labels: label_names.iter().map(|name| file_name(name)).collect(),
        label_lines: state.labels.lines,
        labels_hash: state.labels.hash.clone(),
        drives: drives.len(),
        drives_hash: hex(hash.finalize().as_bytes()),
    }
}

/// The name without its folder: a release does not depend on the location of its inputs.
fn file_name(name: &str) -> String {
    Path::new(name).file_name().map_or(name.to_owned(), |f| f.to_string_lossy().into_owned())
}
