//! The build: stages in order, with everything between them in a work folder beside the output, so that an interrupted
//! build continues where it stopped. The output appears atomically.

mod cutting;
mod freezing;
mod work;

use crate::dedup::deduplicate;
use crate::freeze::manifest::Manifest;
use crate::item::{SplitName, reason_in_words};
use crate::labels::{self, LabelStream, Labels, Names};
use crate::licence::LicenceTable;
use crate::select::{Selected, select};
use crate::spec::{GroupKey, Spec};
use crate::split::{self, Facts, Keep, split};
use crate::{DatasetError, Media, balance, place};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use whyroad_framework::Framework;
use whyroad_label::check::Recordings;
use whyroad_lake::Lake;
use whyroad_model::messages::MiningQueryMessage;
use whyroad_model::{Bilingual, Diagnostic, Lang, ScenarioId};
use work::Work;

/// Makes the mining query that finds more of a class, up to a number of clips; `None` when the class has no rule.
pub type QueryMaker<'a> = dyn Fn(&ScenarioId, usize) -> Option<MiningQueryMessage> + Sync + 'a;

/// Inputs of a build.
pub struct Inputs<'a> {
    /// The spec.
    pub spec: Spec,
    /// Its text, which becomes a file of the release.
    pub spec_text: String,
    /// Classes and the label checker's knowledge.
    pub framework: &'a Framework,
    /// Known licenses.
    pub licences: &'a LicenceTable,
    /// Drives.
    pub lake: &'a Lake,
    /// The same for the checks of finished labels, as [`verify_with`](crate::verify::verify_with) makes them; without
    /// it labels are not compared with their drives.
    pub recordings: Option<Arc<dyn Recordings>>,
    /// Folders with camera images.
    pub media: Media,
    /// Folder that paths in the spec are relative to.
    pub spec_dir: &'a Path,
    /// Folder of the release; must not exist.
    pub out: &'a Path,
    /// Queries for the shortfalls.
    pub queries: &'a QueryMaker<'a>,
    /// Discards leftovers of a build with other inputs.
    pub restart: bool,
}

/// A step that takes time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Drives cut.
    Cut,
    /// Files written.
    Write,
}

/// Result of a build.
#[derive(Debug)]
pub struct Built {
    /// The manifest.
    pub manifest: Manifest,
    /// Diagnostics for the user, none of them errors.
    pub diagnostics: Vec<Diagnostic>,
    /// Drives whose samples were taken from an interrupted build.
    pub resumed: usize,
}

/// Everything known between the stages.
pub(crate) struct State<'a> {
    inputs: &'a Inputs<'a>,
    labels: Labels,
    selected: Selected,
    cells: Names,
    work: Work,
    diagnostics: Vec<Diagnostic>,
}

/// Builds a release from the labels of `streams`. `progress` is called with a step, the work done and the total; when
/// it returns false the build stops, and the next one with the same inputs continues from there.
///
/// # Errors
/// When the output exists, an input cannot be read, a license forbids it, or `progress` stopped it.
pub fn build(
    inputs: &Inputs<'_>,
    streams: Vec<LabelStream>,
    progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
) -> Result<Built, DatasetError> {
    if inputs.out.exists() {
        return Err(DatasetError::Exists(inputs.out.to_owned()));
    }
    let keep = match &inputs.spec.split.keep {
        Some(path) => {
            let dir = inputs.spec_dir.join(path);
            let read = Keep::read(&dir, &inputs.spec.split)?;
            Some((dir, read))
        }
        None => None,
    };
    let keep = keep.as_ref().map(|(dir, keep)| (dir.as_path(), keep));
    let mut work = Work::open(inputs.out)?;
    let names: Vec<String> = streams.iter().map(|s| s.name.clone()).collect();
    let mut labels = labels::read(streams, inputs.framework, &work.labels())?;
    let mut selected = select(&mut labels, &inputs.spec, inputs.lake, inputs.licences);
    if !selected.refused.is_empty() {
        return Err(DatasetError::Refused(std::mem::take(&mut selected.refused)));
    }
    let mut diagnostics = std::mem::take(&mut labels.diagnostics);
    diagnostics.append(&mut selected.diagnostics);
    if !labels.items.iter().any(crate::item::Item::kept) {
        diagnostics.push(nothing(&labels));
        return Err(DatasetError::Refused(diagnostics));
    }
    let mut key = key(inputs, &labels, &selected);
    if let Some((_, keep)) = keep {
        key += &keep.about.manifest_sha256;
    }
    work.claim(&key, inputs.restart)?;
    let mut state = State { inputs, labels, selected, cells: Names::default(), work, diagnostics };

    let resumed = cutting::cut(&mut state, progress)?;
    if !state.labels.items.iter().any(crate::item::Item::kept) {
        let mut found = std::mem::take(&mut state.diagnostics);
        found.push(nothing_left(&state.labels));
        return Err(DatasetError::Refused(found));
    }
    let spec = &state.inputs.spec;
    let mut split_report = split(
        &mut state.labels.items,
        (&state.labels.drives, &state.selected.drives),
        &spec.split,
        spec.seed,
        &mut state.cells,
        keep,
    )?;
    let dedup = deduplicate(&mut state.labels.items, &state.labels.classes, &spec.deduplicate);
    let balanced = balance::balance(
        &mut state.labels.items,
        (&state.labels.classes, &state.selected.drives),
        state.inputs.framework,
        &spec.balance,
        spec.seed,
    );
    // What the split did explains an empty one; the manifest and the card describe the release.
    let assigned = split_report.clone();
    let facts = Facts { drives: &state.labels.drives, cells: &state.cells, meta: &state.selected.drives };
    split_report.count(split::counted(&state.labels.items, facts, &spec.split.by));
    split_report.distances = split::distances(&state.labels.items);
    report_groups(&mut state, &split_report, &assigned);
    report_kept(&mut state, &split_report);
    let manifest = freezing::freeze(&mut state, &names, (split_report, dedup, balanced), progress)?;
    let State { work, diagnostics, .. } = state;
    work.publish(inputs.out)?;
    Ok(Built { manifest, diagnostics, resumed })
}

/// Everything that a build depends on.
fn key(inputs: &Inputs<'_>, labels: &Labels, selected: &Selected) -> String {
    let mut hash = blake3::Hasher::new();
    let mut put = |text: &str| {
        hash.update(text.as_bytes());
        hash.update(&[0]);
    };
    put(env!("CARGO_PKG_VERSION"));
    put(crate::sample::SAMPLE_VERSION);
    put(whyroad_engine::SIGNALS_VERSION);
    // Drafts and their checks depend on all of these, regardless of the stated version.
    let f = inputs.framework;
    put(&format!("{:?} {:?} {:?} {:?}", f.taxonomy, f.specs, f.l1_specs, f.l2_specs));
    put(&format!("{:?} {:?} {:?}", f.decision_table(), f.record_types, f.draft_texts));
    put(&inputs.spec_text);
    put(&serde_json::to_string(&inputs.spec).unwrap_or_default());
    put(&labels.hash);
    put(&format!("{:?}", inputs.media));
    for (drive, meta) in &selected.drives {
        put(labels.drives.get(*drive));
        put(&serde_json::to_string(meta).unwrap_or_default());
        put(selected.licences.get(drive).map_or("", String::as_str));
    }
    hash.finalize().to_hex().to_string()
}

/// Why candidates were dropped, with their numbers.
fn reasons(labels: &Labels) -> BTreeMap<&str, usize> {
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    let of_items = labels.items.iter().filter_map(|i| i.dropped.as_ref());
    for dropped in of_items.chain(labels.dropped.iter().map(|line| &line.dropped)) {
        *reasons.entry(&dropped.reason).or_default() += 1;
    }
    reasons
}

/// No label was selected.
fn nothing(labels: &Labels) -> Diagnostic {
    let code = "dataset.labels.none";
    if labels.lines == 0 {
        return Diagnostic::error(
            code,
            Bilingual::new("标签文件是空的", "there are no labels in the source"),
        )
        .with_hint(Bilingual::new("检查 --labels", "check --labels"));
    }
    let reasons = reasons(labels);
    let list = |lang: Lang| {
        let one = |(id, n): (&&str, &usize)| format!("{} {n}", reason_in_words(id).get(lang));
        reasons.iter().map(one).collect::<Vec<_>>()
    };
    let message = Bilingual::new(
        format!("{} 行标签中没有一行被选中（{}）", labels.lines, list(Lang::Zh).join("、")),
        format!("none of {} label lines is selected ({})", labels.lines, list(Lang::En).join(", ")),
    );
    let (zh, en) = match reasons.iter().max_by_key(|(_, n)| **n).map(|(reason, _)| *reason) {
        Some("invalid_label" | "unreadable") => (
            "用 `whyroad validate` 检查标签文件，它给出每个错误的位置",
            "run `whyroad validate` on the labels: it shows where each error is",
        ),
        Some("drive_missing") => (
            "检查 --lake：标签引用的行程不在其中",
            "check --lake: the drives that the labels name are not in it",
        ),
        _ => (
            "检查 spec 的 labels、select 与 licences；未质检的草稿须设 labels.drafts: true 或加 --drafts",
            "check labels, select and licences in the spec; unchecked drafts need labels.drafts: true or --drafts",
        ),
    };
    Diagnostic::error(code, message).with_hint(Bilingual::new(zh, en))
}

/// Labels were selected, but no sample is left of them.
fn nothing_left(labels: &Labels) -> Diagnostic {
    let list = reasons(labels).iter().map(|(r, n)| format!("{r} {n}")).collect::<Vec<_>>().join(", ");
    Diagnostic::error(
        "dataset.samples.none",
        Bilingual::new(
            format!("没有一个样本可收入，未写出数据集（{list}）"),
            format!("no sample is left, so no release is written ({list})"),
        ),
    )
    .with_hint(Bilingual::new(
        "对照 docs/reference/release.md 中的原因修改 spec 的 sample 部分，或改正输入",
        "change `sample` in the spec or the inputs; docs/reference/release.md explains the reasons",
    ))
}

/// Samples that would join splits of the earlier release.
fn report_kept(state: &mut State<'_>, report: &split::SplitReport) {
    let Some(n) = report.kept.as_ref().map(|k| k.between).filter(|n| *n > 0) else { return };
    let message = Bilingual::new(
        format!("{n} 个新样本与旧数据集的两个划分有共同的分组或地点，未收入"),
        format!(
            "{n} new samples share a group or a place with two splits of the earlier release and are left out"
        ),
    );
    state.diagnostics.push(Diagnostic::warning("dataset.split.keep", message).with_hint(Bilingual::new(
        "stages/3-split.parquet 列出这些样本；若不再需要旧的划分，去掉 split.keep",
        "stages/3-split.parquet lists them; unset split.keep once the earlier splits are no longer needed",
    )));
}

/// Places of which some drives have a latitude and longitude and others only map coordinates: these cannot be compared.
fn report_frames(state: &mut State<'_>) {
    let mut frames: BTreeMap<&str, [BTreeSet<u32>; 2]> = BTreeMap::new();
    for item in state.labels.items.iter().filter(|i| i.kept()) {
        let place = state.selected.drives.get(&item.drive).and_then(|meta| meta.place.as_deref());
        let position = item.cut.as_ref().and_then(|cut| cut.position.as_ref());
        if let (Some(place), Some(position)) = (place, position) {
            frames.entry(place).or_default()[usize::from(position.frame == place::GEO)].insert(item.drive);
        }
    }
    for (place, [of_map, geo]) in frames {
        let (with, without) = (geo.len(), of_map.len());
        if with == 0 || without == 0 {
            continue;
        }
        let message = Bilingual::new(
            format!(
                "地点 {place}：{with} 个行程有经纬度，{without} 个只有地图坐标，二者之间的距离未知，同一路段可能进入不同划分"
            ),
            format!(
                "place {place}: {with} drives have a latitude and longitude and {without} only map coordinates; the \
                 distances between them are unknown, so that one road may be in two splits"
            ),
        );
        state.diagnostics.push(Diagnostic::warning("dataset.split.frames", message).with_hint(
            Bilingual::new(
                "用 `whyroad ingest --meta CSV` 为该地点的所有行程补充经纬度，或都不填",
                "state the latitude and longitude of all drives of the place, or of none, with \
             `whyroad ingest --meta CSV`",
            ),
        ));
    }
}

/// Samples that could not be grouped, and empty splits. `assigned` counts the samples before duplicates were dropped.
fn report_groups(state: &mut State<'_>, report: &split::SplitReport, assigned: &split::SplitReport) {
    for (key, n) in &report.unknown {
        state.diagnostics.push(
            Diagnostic::warning(
                "dataset.group.unknown",
                Bilingual::new(
                    format!("{n} 个样本的 {key} 未知，按行程分组"),
                    format!("{n} samples have no known {key}; they are grouped by drive"),
                ),
            )
            .with_hint(Bilingual::new(
                "用 `whyroad ingest --meta CSV` 补充",
                "state it with `whyroad ingest --meta CSV`",
            )),
        );
    }
    let spec = &state.inputs.spec.split;
    let by_place = spec.by.contains(&GroupKey::Place);
    if by_place {
        report_frames(state);
    }
    for polygon in &spec.polygons {
        if by_place && state.cells.all().contains(&polygon.name) {
            continue;
        }
        let name = &polygon.name;
        let (zh, en) = if by_place {
            (format!("多边形 '{name}' 中没有样本"), format!("no sample is in the polygon '{name}'"))
        } else {
            (
                format!("split.by 中没有 place，多边形 '{name}' 不起作用"),
                format!("the polygon '{name}' has no effect: `place` is not in split.by"),
            )
        };
        state.diagnostics.push(
            Diagnostic::warning("dataset.polygon.unused", Bilingual::new(zh, en)).with_hint(Bilingual::new(
                "有经纬度的行程只用不带 place 的多边形（经度、纬度）；其余行程用 place 与地图坐标（米）",
                "drives with a latitude and longitude need a polygon without `place`, in degrees (longitude, \
                 latitude); all others need `place` and map coordinates in meters",
            )),
        );
    }
    for (split, share) in SplitName::ALL.into_iter().zip([spec.train, spec.val, spec.test]) {
        let (name, given) = (split.name(), assigned.samples.get(split.name()).copied().unwrap_or(0));
        let left = state.labels.items.iter().any(|i| i.kept() && i.split == Some(split));
        if share <= 0.0 || left {
            continue;
        }
        let (n, largest) = (assigned.components, assigned.largest_component);
        let message = if given == 0 {
            Bilingual::new(
                format!("划分 {name} 为空：只有 {n} 个连通分组，最大的有 {largest} 个样本"),
                format!(
                    "split {name} is empty: there are {n} groups that cannot be separated, the largest has \
                     {largest} samples"
                ),
            )
        } else {
            Bilingual::new(
                format!("划分 {name} 为空：它的 {given} 个样本都在去重或均衡时舍去"),
                format!(
                    "split {name} is empty: its {given} samples were all dropped as duplicates or by a cap"
                ),
            )
        };
        state.diagnostics.push(Diagnostic::warning("dataset.split.empty", message));
    }
}
