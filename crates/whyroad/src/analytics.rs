//! Inputs of the analytics, read from their sources: a mined folder, the store of the labeling service, releases.
//! `whyroad report` and the page of the service share it.

mod service;

pub(crate) use service::ServiceReports;

use crate::output::reason::{cannot_read, no_project};
use crate::store_args::{KeyArgs, error as refusal};
use anyhow::{Context as _, anyhow};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use whyroad_dataset::Release;
use whyroad_label::facts::{Judgement, TaskFacts};
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::{Diagnostic, Lang, Nanos, ScenarioId};
use whyroad_report::analytics::{DriveFacts, MinedFacts, ReleaseFacts, SampleFacts};
use whyroad_server::service::{facts, projects};

/// Summary of a mined folder; weather, and whether times are dates, from the lake. Both stay unknown for drives whose
/// context cannot be read, and these are named.
pub(crate) fn mined(
    folder: &MinedFolder,
    lake: &Lake,
) -> Result<(MinedFacts, Vec<Diagnostic>), Box<Diagnostic>> {
    let unreadable = |e: whyroad_lake::LakeError| Box::new(e.diagnostic());
    let mut out = MinedFacts { coverage: folder.coverage()?, ..MinedFacts::default() };
    let mut lost = Vec::new();
    for (id, drive) in folder.drive_summaries().map_err(unreadable)? {
        let (weather, dated) = match lake.stated_context(&id) {
            Ok(stated) => {
                let weather =
                    stated.states.and_then(|s| Some(s.into_iter().find(|c| c.kind == "weather")?.value));
                (weather, stated.dated)
            }
            Err(e) => {
                lost.push(e.diagnostic());
                (None, false)
            }
        };
        let facts = DriveFacts {
            seconds: drive.seconds,
            place: drive.place,
            source: drive.source,
            weather,
            start: drive.start.filter(|_| dated),
        };
        out.drives.insert(id, facts);
    }
    // Searched drives count even without a clip.
    for id in &out.coverage.drives {
        out.drives.entry(id.clone()).or_default();
    }
    folder.each_episode(|e| out.episodes.add(e)).map_err(unreadable)?;
    Ok((out, lost))
}

/// Tasks of the labeling service and the targets of its projects.
pub(crate) struct Labelling {
    pub tasks: Vec<TaskFacts>,
    pub wanted: BTreeMap<ScenarioId, u64>,
}

/// The tasks of a store: `labels.db`, the folder with it, or a PostgreSQL address; of one project, or of all.
pub(crate) fn labelling(
    (source, key): (&str, &KeyArgs),
    project: Option<&str>,
    lang: Lang,
) -> anyhow::Result<Labelling> {
    let store = key.open(source, lang)?;
    let all = store.read(projects::all).map_err(|p| refusal(&p, lang))?;
    let chosen: Vec<_> =
        all.iter().filter(|p| project.is_none_or(|name| p.name == name || p.id == name)).collect();
    if let Some(name) = project.filter(|_| chosen.is_empty()) {
        let names: Vec<&str> = all.iter().map(|p| p.name.as_str()).collect();
        return Err(no_project(name, &names));
    }
    let mut out = Labelling { tasks: vec![], wanted: BTreeMap::new() };
    for p in chosen {
        out.tasks.extend(store.read(|tx| facts::of(tx, &p.id)).map_err(|e| refusal(&e, lang))?);
        for (leaf, n) in &p.quota {
            if let Ok(id) = leaf.parse() {
                *out.wanted.entry(id).or_default() += u64::from(*n);
            }
        }
    }
    Ok(out)
}

/// Columns of a release needed for the counts.
const SAMPLE_COLUMNS: &[&str] = &[
    "sample_id",
    "scenario_id",
    "longitudinal",
    "lateral",
    "lateral_direction",
    "lineage",
    "groups",
    "context",
];

/// Summaries of releases, one row group at a time.
pub(crate) fn releases(dirs: &[PathBuf]) -> anyhow::Result<Vec<ReleaseFacts>> {
    dirs.iter().map(|dir| release(dir)).collect()
}

fn release(dir: &Path) -> anyhow::Result<ReleaseFacts> {
    let cannot = || cannot_read(dir.display());
    let release = Release::open(dir).with_context(cannot)?;
    let name = format!("{} {}", release.manifest.name, release.manifest.version);
    let mut out = ReleaseFacts { name, samples: vec![] };
    for batch in release.batches(None, Some(SAMPLE_COLUMNS)) {
        let batch = batch.with_context(cannot)?;
        for s in whyroad_dataset::sample::schema::from_batch(&batch)
            .map_err(|e| anyhow!("{}: {e}", dir.display()))?
        {
            let weather = s.context.and_then(|c| Some(c.into_iter().find(|c| c.kind == "weather")?.value));
            out.samples.push(SampleFacts {
                judgement: Judgement {
                    scenario: s.scenario_id.parse().ok(),
                    longitudinal: s.longitudinal.as_deref().and_then(Longitudinal::from_id),
                    lateral: s.lateral.as_deref().and_then(Lateral::from_id),
                    lateral_direction: s.lateral_direction.as_deref().and_then(LateralDirection::from_id),
                    keyframe: Some(Nanos(s.lineage.keyframe_time_ns)),
                },
                sample: s.sample_id,
                dated: s.groups.date.is_some(),
                place: s.groups.place,
                source: Some(s.groups.source).filter(|s| !s.is_empty()),
                weather,
            });
        }
    }
    Ok(out)
}

/// The largest of several mined folders: the page shows one and names it.
pub(crate) fn largest(dirs: &[PathBuf]) -> Option<MinedFolder> {
    let folders = dirs.iter().filter_map(|d| MinedFolder::find(d).ok()).flat_map(BTreeMap::into_values);
    folders.max_by_key(|f| f.coverage().map_or(0, |c| c.drives.len()))
}
