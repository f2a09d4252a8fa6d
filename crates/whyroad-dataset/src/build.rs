//! The build: stages in order, with everything between them in a work folder beside the output, so that an
//! interrupted build goes on where it was. The output appears whole or not at all.

mod cutting;
mod freezing;
mod work;

use crate::dedup::deduplicate;
use crate::freeze::manifest::Manifest;
use crate::item::{Dropped, SplitName};
use crate::labels::{self, LabelStream, Labels, Names};
use crate::licence::LicenceTable;
use crate::select::{Selected, select};
use crate::spec::Spec;
use crate::split::{self, split};
use crate::{DatasetError, Media, balance};
use std::collections::BTreeMap;
use std::path::Path;
use whyroad_framework::Framework;
use whyroad_lake::Lake;
use whyroad_model::messages::MiningQueryMessage;
use whyroad_model::{Bilingual, Diagnostic, Lang, ScenarioId};
use work::Work;

/// Makes the mining query that finds more of a class, up to a number of clips; `None` when the class has no rule.
pub type QueryMaker<'a> = dyn Fn(&ScenarioId, usize) -> Option<MiningQueryMessage> + Sync + 'a;

/// What a build is made from.
pub struct Inputs<'a> {
    /// The spec.
    pub spec: Spec,
    /// Its text, which becomes a file of the release.
    pub spec_text: String,
    /// Classes and the label checker's knowledge.
    pub framework: &'a Framework,
    /// Known licences.
    pub licences: &'a LicenceTable,
    /// Drives.
    pub lake: &'a Lake,
    /// Folders with camera images.
    pub media: Media,
    /// Folder of the release; must not exist.
    pub out: &'a Path,
    /// Language of drafts that are made from episodes.
    pub lang: Lang,
    /// Queries for what is missing.
    pub queries: &'a QueryMaker<'a>,
    /// Discards what a build with other inputs left.
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

/// What was built.
#[derive(Debug)]
pub struct Built {
    /// The manifest.
    pub manifest: Manifest,
    /// What somebody should know; no error.
    pub diagnostics: Vec<Diagnostic>,
    /// Drives whose samples were there from an interrupted build.
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

/// Builds a release from the labels of `streams`. `progress` is called with a step, what is done and what there is to
/// do; when it returns false the build stops, and the next one with the same inputs goes on from there.
///
/// # Errors
/// When the output exists, an input cannot be read, a licence forbids it, or `progress` stopped it.
pub fn build(
    inputs: &Inputs<'_>,
    streams: Vec<LabelStream>,
    progress: &(dyn Fn(Step, usize, usize) -> bool + Sync),
) -> Result<Built, DatasetError> {
    if inputs.out.exists() {
        return Err(DatasetError::Exists(inputs.out.to_owned()));
    }
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
    work.claim(&key(inputs, &labels, &selected), inputs.restart)?;
    let mut state = State { inputs, labels, selected, cells: Names::default(), work, diagnostics };

    let resumed = cutting::cut(&mut state, progress)?;
    let spec = &state.inputs.spec;
    let mut split_report =
        split(&mut state.labels.items, &state.selected.drives, &spec.split, spec.seed, &mut state.cells);
    let dedup = deduplicate(&mut state.labels.items, &state.labels.classes, &spec.deduplicate);
    let balanced = balance::balance(
        &mut state.labels.items,
        &state.labels.classes,
        state.inputs.framework,
        &spec.balance,
        spec.seed,
    );
    split_report.distances = split::distances(&state.labels.items);
    report_groups(&mut state, &split_report);
    let manifest = freezing::freeze(&mut state, &names, (split_report, dedup, balanced), progress)?;
    let State { work, diagnostics, .. } = state;
    work.publish(inputs.out)?;
    Ok(Built { manifest, diagnostics, resumed })
}

/// Whatever a build depends on.
fn key(inputs: &Inputs<'_>, labels: &Labels, selected: &Selected) -> String {
    let mut hash = blake3::Hasher::new();
    let mut put = |text: &str| {
        hash.update(text.as_bytes());
        hash.update(&[0]);
    };
    put(env!("CARGO_PKG_VERSION"));
    put(crate::sample::SAMPLE_VERSION);
    put(whyroad_engine::SIGNALS_VERSION);
    put(&inputs.framework.taxonomy.version);
    put(&inputs.spec_text);
    put(&serde_json::to_string(&inputs.spec).unwrap_or_default());
    put(&labels.hash);
    put(&format!("{:?} {:?}", inputs.lang, inputs.media));
    for (drive, meta) in &selected.drives {
        put(labels.drives.get(*drive));
        put(&serde_json::to_string(meta).unwrap_or_default());
    }
    hash.finalize().to_hex().to_string()
}

fn nothing(labels: &Labels) -> Diagnostic {
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    let of = |d: &Option<Dropped>| d.as_ref().map(|d| d.reason.clone());
    let words: Vec<_> = labels.items.iter().filter_map(|i| of(&i.dropped)).collect();
    for word in &words {
        *reasons.entry(word).or_default() += 1;
    }
    for line in &labels.dropped {
        *reasons.entry(&line.dropped.reason).or_default() += 1;
    }
    let list = reasons.iter().map(|(r, n)| format!("{r} {n}")).collect::<Vec<_>>().join(", ");
    Diagnostic::error(
        "dataset.labels.none",
        Bilingual::new(
            format!("{} 行标签中没有一行被选中（{list}）", labels.lines),
            format!("none of {} label lines is selected ({list})", labels.lines),
        ),
    )
    .with_hint(Bilingual::new(
        "检查 spec 的 labels 与 select；未质检的草稿须设 labels.drafts: true 或加 --drafts",
        "check labels and select in the spec; unchecked drafts need labels.drafts: true or --drafts",
    ))
}

/// What could not be grouped, and splits that got nothing.
fn report_groups(state: &mut State<'_>, report: &split::SplitReport) {
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
    for (split, share) in SplitName::ALL.into_iter().zip([spec.train, spec.val, spec.test]) {
        let (name, given) = (split.name(), report.samples.get(split.name()).copied().unwrap_or(0));
        let left = state.labels.items.iter().any(|i| i.kept() && i.split == Some(split));
        if share <= 0.0 || left {
            continue;
        }
        let (n, largest) = (report.components, report.largest_component);
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
