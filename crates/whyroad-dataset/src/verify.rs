//! Checking a release: every file's hash, no file missing or extra, no group or sample in two splits, no sample of
//! one split near one of another, no near-duplicate across splits, licenses, and every label against the framework of
//! today.

use crate::dedup::search::{Neighbors, Projection};
use crate::freeze::checksums::{files_below, listing, sum};
use crate::freeze::manifest::FileEntry;
use crate::freeze::{CHECKSUMS, MANIFEST};
use crate::item::{Position, SplitName};
use crate::labels::DRAFT;
use crate::licence::LicenceTable;
use crate::place::{self, Grid};
use crate::release::read_text;
use crate::spec::GroupKey;
use crate::split::value_of_sample;
use crate::{DatasetError, Release, Sample, descriptor};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use whyroad_framework::Framework;
use whyroad_label::check::{Checker, Recordings};
use whyroad_model::{Bilingual, Diagnostic, Severity};

/// Columns that the check reads: all but the heavy ones that it does not need.
const COLUMNS: &[&str] = &[
    "sample_id",
    "split",
    "scenario_id",
    "l1",
    "l2",
    "l3",
    "lineage",
    "groups",
    "history",
    "future",
    "objects",
    "lights",
    "map",
    "context",
    "label_json",
    "trace_zh",
    "trace_en",
];
/// Beginnings of the codes about the class of a label, and about a text that is no label at all.
const OF_CLASS: [&str; 2] = ["label.scenario.", "label.json."];
/// Findings of one kind that are written out; the rest is counted.
const TOLD: usize = 10;

/// Results of a check.
#[derive(Debug, Default)]
pub struct Verified {
    /// Samples read.
    pub samples: usize,
    /// Files whose hash was computed.
    pub files: usize,
    /// Labels that were checked again, completely.
    pub labels: usize,
    /// Drafts, of which only the class was checked: they need not be complete.
    pub drafts: usize,
    /// Labels that were compared with the recording of their drive, and labels that could not be, because the drive is
    /// not available; `None` where no recordings were given.
    pub compared: Option<[usize; 2]>,
    /// Near-duplicates across splits were sought: not in a release whose spec keeps them.
    pub near_duplicates: bool,
    /// Samples that the manifest states.
    pub stated: usize,
    /// Findings.
    pub diagnostics: Vec<Diagnostic>,
}

/// The kept part of a sample.
struct Seen {
    id: String,
    split: SplitName,
    position: Option<Position>,
    descriptor: Vec<f32>,
}

/// Checks the release in `dir`.
///
/// # Errors
/// When it cannot be read at all.
pub fn verify(
    dir: &std::path::Path,
    framework: &Framework,
    licences: &LicenceTable,
) -> Result<Verified, DatasetError> {
    verify_with(dir, framework, licences, None)
}

/// The same; with `recordings`, labels are also compared with the drives that they refer to.
///
/// # Errors
/// When the release cannot be read at all.
pub fn verify_with(
    dir: &std::path::Path,
    framework: &Framework,
    licences: &LicenceTable,
    recordings: Option<Arc<dyn Recordings>>,
) -> Result<Verified, DatasetError> {
    let release = Release::open(dir)?;
    let mut out = Verified::default();
    files(&release, &mut out)?;
    out.stated = release.manifest.counts.samples;
    out.near_duplicates = release.manifest.spec.deduplicate.near.is_some();
    // What is missing is reported already; the rest is checked.
    let missing: BTreeSet<String> = out
        .diagnostics
        .iter()
        .filter(|d| d.code == "dataset.file.missing")
        .filter_map(|d| d.location.file.clone())
        .collect();
    let mut present = release.clone();
    present.manifest.files.retain(|f| !missing.contains(&f.path));
    let mut groups: BTreeMap<(GroupKey, String), BTreeSet<SplitName>> = BTreeMap::new();
    let mut ids: HashMap<String, SplitName> = HashMap::new();
    let mut seen = Vec::new();
    let mut found = Findings::default();
    let mut checker = Checker::new(framework);
    if let Some(recordings) = &recordings {
        checker = checker.with_recordings(Arc::clone(recordings));
    }
    let mut unavailable: BTreeSet<String> = BTreeSet::new();
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut stated: BTreeSet<String> = BTreeSet::new();
    for split in SplitName::ALL {
        for batch in present.batches(Some(split), Some(COLUMNS)) {
            let batch = match batch {
                Ok(batch) => batch,
                Err(e) => {
                    out.diagnostics.extend(e.diagnostics());
                    continue;
                }
            };
            let samples = match crate::sample::schema::from_batch(&batch) {
                Ok(samples) => samples,
                Err(e) => {
                    out.diagnostics.extend(DatasetError::broken(dir, e).diagnostics());
                    continue;
                }
            };
            // Right after the label's check, while its drive is still kept in memory.
            let recorded = |s: &Sample| Some(recordings.as_ref()?.of_clip(&s.lineage.clip_id).is_some());
            let checked: Vec<(Option<String>, Option<bool>)> =
                samples.par_iter().map(|s| (stale(s, &checker), recorded(s))).collect();
            for (sample, (stale, recorded)) in samples.into_iter().zip(checked) {
                *counts.entry(split.name()).or_default() += 1;
                out.samples += 1;
                let is_draft = sample.lineage.label_status == DRAFT;
                *(if is_draft { &mut out.drafts } else { &mut out.labels }) += 1;
                if let Some(recorded) = recorded.filter(|_| !is_draft) {
                    out.compared.get_or_insert_default()[usize::from(!recorded)] += 1;
                    if !recorded {
                        unavailable.insert(sample.lineage.drive_id.clone());
                    }
                }
                stated.insert(sample.groups.licence.clone());
                if let Some(codes) = stale {
                    found.label(&sample.sample_id, &codes);
                }
                if let Some(other) = ids.insert(sample.sample_id.clone(), split) {
                    found.repeated(&sample.sample_id, other, split);
                }
                for key in release.manifest.spec.split.by.iter().chain([&GroupKey::Drive]) {
                    if let Some(value) = value_of_sample(&sample, *key) {
                        groups.entry((*key, value)).or_default().insert(split);
                    }
                }
                seen.push(keep(&sample, split));
            }
        }
    }
    for ((key, value), splits) in &groups {
        if splits.len() > 1 {
            found.leak(*key, value, splits);
        }
    }
    for (split, n) in &release.manifest.counts.by_split {
        let has = counts.get(split.as_str()).copied().unwrap_or(0);
        if has != *n && missing.is_empty() {
            found.count(split, *n, has);
        }
    }
    near(&release, &seen, &mut found);
    alike(&release, &seen, &mut found);
    out.diagnostics.extend(found.finish());
    licence(&release, licences, &stated, &mut out.diagnostics);
    if let Some([_, n]) = out.compared.filter(|[_, n]| *n > 0) {
        out.diagnostics.push(uncompared(n, &unavailable));
    }
    Ok(out)
}

/// Code of the warning that labels could not be compared with a recording.
pub const UNCOMPARED: &str = "dataset.label.uncompared";

/// `n` labels of drives that are not available.
fn uncompared(n: usize, drives: &BTreeSet<String>) -> Diagnostic {
    let first = drives.iter().take(3).map(String::as_str).collect::<Vec<_>>().join(", ");
    let all = drives.len();
    let message = Bilingual::new(
        format!("{n} 个标签未能与录制数据比对：{all} 个行程不在数据湖中或无法读取，例如 {first}"),
        format!(
            "{n} labels could not be compared with a recording: {all} drives are not in the lake or cannot be read, \
             for example {first}"
        ),
    );
    Diagnostic::warning(UNCOMPARED, message).with_hint(Bilingual::new(
        "用 --lake 指定含有这些行程的数据湖",
        "name the lake that has the drives with --lake",
    ))
}

/// Hashes and the list of files.
fn files(release: &Release, out: &mut Verified) -> Result<(), DatasetError> {
    let dir = release.dir();
    let present = files_below(dir)?;
    let listed: BTreeSet<String> = release.manifest.files.iter().map(|f| f.path.clone()).collect();
    for path in present.iter().filter(|p| !listed.contains(*p) && *p != MANIFEST && *p != CHECKSUMS) {
        let message =
            Bilingual::new(format!("{path} 不在清单中"), format!("{path} is not listed in the manifest"));
        let hint = Bilingual::new(
            "移到别处：读取 data/*.parquet 的程序也会读到它",
            "move it elsewhere: a loader that reads data/*.parquet would read it, too",
        );
        out.diagnostics
            .push(Diagnostic::error("dataset.file.extra", message).in_file(path.clone()).with_hint(hint));
    }
    let sums: Vec<(&FileEntry, Option<(u64, String)>)> =
        release.manifest.files.par_iter().map(|f| (f, sum(&dir.join(&f.path)).ok())).collect();
    for (entry, found) in sums {
        out.files += 1;
        let d = match found {
            None => Diagnostic::error(
                "dataset.file.missing",
                Bilingual::new(
                    format!("{} 缺失或无法读取", entry.path),
                    format!("{} is missing or cannot be read", entry.path),
                ),
            ),
            Some((bytes, sha256)) if bytes == entry.bytes && sha256 == entry.sha256 => continue,
            Some(_) => Diagnostic::error(
                "dataset.file.hash",
                Bilingual::new(
                    format!("{} 的内容与清单的哈希不符", entry.path),
                    format!("the content of {} does not match its hash in the manifest", entry.path),
                ),
            ),
        };
        out.diagnostics.push(d.in_file(entry.path.clone()).with_hint(again()));
    }
    // The manifest itself: the checksums list it.
    let mut all = release.manifest.files.clone();
    let (bytes, sha256) = sum(&dir.join(MANIFEST))?;
    all.push(FileEntry { path: MANIFEST.into(), bytes, sha256, samples: None });
    all.sort_by(|a, b| a.path.cmp(&b.path));
    if read_text(&dir.join(CHECKSUMS)).ok().as_deref() != Some(&listing(&all)) {
        let message = Bilingual::new(
            format!("{CHECKSUMS} 与清单不符：清单或校验文件被改动"),
            format!("{CHECKSUMS} does not match the manifest: one of them was changed"),
        );
        out.diagnostics
            .push(Diagnostic::error("dataset.file.hash", message).in_file(CHECKSUMS).with_hint(again()));
    }
    Ok(())
}

/// What to do about a damaged file.
fn again() -> Bilingual {
    Bilingual::new(
        "从完整的副本重新复制该文件，或重新构建数据集",
        "copy the file again from an intact copy of the release, or build the release again",
    )
}

/// The errors of a label that was valid once; `None` when it still is. A draft was never complete: only its class must
/// exist.
pub(crate) fn stale(sample: &Sample, checker: &Checker<'_>) -> Option<String> {
    if checker.is_clean_label(&sample.label_json) {
        return None;
    }
    let is_draft = sample.lineage.label_status == DRAFT;
    let found = checker.check_text(&sample.label_json);
    let errors = found.iter().filter(|d| d.severity == Severity::Error).map(|d| d.code);
    let codes: Vec<&str> =
        errors.filter(|code| !is_draft || OF_CLASS.iter().any(|of| code.starts_with(of))).collect();
    (!codes.is_empty()).then(|| codes.join(", "))
}

fn keep(sample: &Sample, split: SplitName) -> Seen {
    let named = sample.objects.iter().filter(|o| o.named).map(|o| o.id.clone()).collect();
    let position = place::of_sample(sample);
    Seen { id: sample.sample_id.clone(), split, position, descriptor: descriptor::of(sample, &named) }
}

/// Samples of one split closer than the spec's distance to one of another.
fn near(release: &Release, seen: &[Seen], found: &mut Findings) {
    let spec = &release.manifest.spec.split;
    if !spec.by.contains(&GroupKey::Place) {
        return;
    }
    let grid = Grid::new(seen.iter().map(|s| s.position.as_ref()).collect(), spec.min_distance_m);
    for s in seen {
        let Some(position) = &s.position else { continue };
        let mut other = None;
        grid.near(position, |o| {
            if seen[o as usize].split > s.split {
                other = Some(o as usize);
            }
            other.is_none()
        });
        if let Some(o) = other {
            found.near(s, &seen[o], spec.min_distance_m);
        }
    }
}

/// Near-duplicates across splits.
fn alike(release: &Release, seen: &[Seen], found: &mut Findings) {
    let Some(similarity) = release.manifest.spec.deduplicate.near else { return };
    let vectors: Vec<&[f32]> = seen.iter().map(|s| s.descriptor.as_slice()).collect();
    let projection = Projection::of(&vectors);
    // Slightly stricter than the build, so that rounding on disk is not a finding.
    let radius = descriptor::distance_of(similarity) * 0.999;
    let mut index = Neighbors::new(&vectors, &projection, radius);
    for (i, s) in seen.iter().enumerate() {
        if s.split != SplitName::Train {
            index.insert(i as u32);
        }
    }
    let pairs: Vec<(usize, u32)> = (0..seen.len())
        .into_par_iter()
        .filter_map(|i| index.find(vectors[i], |o| seen[o as usize].split > seen[i].split).map(|o| (i, o)))
        .collect();
    for (i, o) in pairs {
        found.alike(&seen[i], &seen[o as usize]);
    }
}

fn licence(release: &Release, table: &LicenceTable, stated: &BTreeSet<String>, out: &mut Vec<Diagnostic>) {
    let spec = &release.manifest.spec.licences;
    for id in stated {
        match table.find(id) {
            None => out.push(Diagnostic::error(
                "dataset.licence.unknown",
                Bilingual::new(format!("许可 '{id}' 未知"), format!("license '{id}' is unknown")),
            )),
            Some(l) => {
                out.extend(table.objection(l, spec));
                if !table.is_allowed(l, spec) {
                    out.push(Diagnostic::error(
                        "dataset.licence.forbidden",
                        Bilingual::new(
                            format!("许可 {id} 不在 licences.allow 中"),
                            format!("license {id} is not in licences.allow"),
                        ),
                    ));
                }
            }
        }
    }
    match table.declared(stated, spec.purpose) {
        Ok(id) if id == release.manifest.licence => {}
        Ok(id) => out.push(Diagnostic::error(
            "dataset.licence.conflict",
            Bilingual::new(
                format!("数据集声明 {}，而其行程要求 {id}", release.manifest.licence),
                format!("the release declares {}, its drives require {id}", release.manifest.licence),
            ),
        )),
        Err(d) => out.push(*d),
    }
}

/// Findings by kind: the first are written out, the rest counted.
#[derive(Default)]
struct Findings {
    by_code: BTreeMap<&'static str, (usize, Vec<Diagnostic>)>,
}

impl Findings {
    fn put(&mut self, code: &'static str, zh: String, en: String) {
        let (n, told) = self.by_code.entry(code).or_default();
        *n += 1;
        if told.len() < TOLD {
            told.push(Diagnostic::error(code, Bilingual::new(zh, en)));
        }
    }

    fn label(&mut self, id: &str, codes: &str) {
        let (zh, en) = (
            format!("样本 {id} 的标签不再通过校验：{codes}"),
            format!("the label of sample {id} no longer validates: {codes}"),
        );
        self.put("dataset.label.stale", zh, en);
    }

    fn repeated(&mut self, id: &str, a: SplitName, b: SplitName) {
        let (a, b) = (a.name(), b.name());
        let (zh, en) =
            (format!("样本 {id} 出现两次（{a}、{b}）"), format!("sample {id} occurs twice ({a}, {b})"));
        self.put("dataset.sample.repeated", zh, en);
    }

    fn leak(&mut self, key: GroupKey, value: &str, splits: &BTreeSet<SplitName>) {
        let key = crate::split::key_name(key);
        let list = splits.iter().map(|s| s.name()).collect::<Vec<_>>().join(", ");
        let (zh, en) =
            (format!("{key} '{value}' 同时出现在 {list}"), format!("{key} '{value}' is in {list}"));
        self.put("dataset.split.leak", zh, en);
    }

    fn count(&mut self, split: &str, stated: usize, has: usize) {
        let (zh, en) = (
            format!("{split} 有 {has} 个样本，清单写 {stated}"),
            format!("{split} has {has} samples, the manifest states {stated}"),
        );
        self.put("dataset.sample.count", zh, en);
    }

    fn near(&mut self, a: &Seen, b: &Seen, least: f64) {
        let ((x, sx), (y, sy)) = ((&a.id, a.split.name()), (&b.id, b.split.name()));
        let (zh, en) = (
            format!("样本 {x}（{sx}）与 {y}（{sy}）相距不足 {least} m"),
            format!("samples {x} ({sx}) and {y} ({sy}) are less than {least} m apart"),
        );
        self.put("dataset.split.near", zh, en);
    }

    fn alike(&mut self, a: &Seen, b: &Seen) {
        let ((x, sx), (y, sy)) = ((&a.id, a.split.name()), (&b.id, b.split.name()));
        let s = descriptor::similarity(descriptor::distance(&a.descriptor, &b.descriptor));
        let (zh, en) = (
            format!("样本 {x}（{sx}）与 {y}（{sy}）近似重复，相似度 {s:.3}"),
            format!("samples {x} ({sx}) and {y} ({sy}) are near-duplicates, similarity {s:.3}"),
        );
        self.put("dataset.duplicate.across", zh, en);
    }

    fn finish(self) -> Vec<Diagnostic> {
        let mut out = Vec::new();
        for (code, (n, told)) in self.by_code {
            let more = n - told.len();
            out.extend(told);
            if more > 0 {
                let message = Bilingual::new(format!("另有 {more} 处"), format!("{more} more of these"));
                out.push(Diagnostic::error(code, message));
            }
        }
        out
    }
}
