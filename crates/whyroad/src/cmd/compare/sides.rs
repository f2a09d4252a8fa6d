//! One side of a comparison as episodes: read from a mined folder, found by a framework's rules in a lake, or made from
//! the samples of a release.

use crate::output::reason::{cannot_read, no_framework, reason, stop};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, anyhow};
use std::collections::BTreeMap;
use std::path::Path;
use whyroad_dataset::diff::content_hash;
use whyroad_dataset::{Release, Sample};
use whyroad_engine::mine::{MineOptions, mine_each};
use whyroad_framework::{Framework, Taxonomy};
use whyroad_lake::mined::MiningQuestion;
use whyroad_lake::{Lake, MinedFolder};
use whyroad_mining::RuleSet;
use whyroad_model::messages::{EpisodeRecord, Keyframe, KeyframeType, TimeRange};
use whyroad_model::{Bilingual, ClipId, DriveId, Lang, Nanos, ScenarioId, Severity, TrackId};
use whyroad_report::comparison::Searched;
use whyroad_signals::Catalog;

/// Type of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A folder of `whyroad mine --out DIR`.
    Mined,
    /// A framework folder, or the built-in framework.
    Framework,
    /// A folder of `whyroad dataset build`.
    Release,
}

/// The name of the built-in framework.
const BUNDLED: &str = "bundled";

impl Kind {
    pub(super) fn of(path: &Path) -> anyhow::Result<Self> {
        if MinedFolder::open(path).is_some() {
            Ok(Self::Mined)
        } else if path.join("manifest.json").is_file() {
            Ok(Self::Release)
        } else if path.join("schema").is_dir()
            || path.join("scenarios").is_dir()
            || (path == Path::new(BUNDLED) && !path.exists())
        {
            Ok(Self::Framework)
        } else {
            Err(stop(
                format!(
                    "{} 既不是 `whyroad mine --out DIR` 的文件夹，也不是框架文件夹或数据集",
                    path.display()
                ),
                format!(
                    "{} is neither a folder of `whyroad mine --out DIR`, a framework folder nor a release",
                    path.display()
                ),
            ))
        }
    }
}

/// One side.
pub(super) struct Side {
    /// Drives that were searched.
    pub drives: Vec<DriveId>,
    /// Episodes of the requested classes.
    pub episodes: Vec<EpisodeRecord>,
    /// Classes that were asked for; `None`: all.
    pub classes: Option<Vec<ScenarioId>>,
    /// Hashes of the labels by the id of the sample, of a release.
    pub labels: Option<BTreeMap<String, String>>,
    /// The taxonomy, of a framework.
    pub taxonomy: Option<Taxonomy>,
    /// Some input could not be read.
    pub lost: bool,
}

impl Side {
    /// For the comparison.
    pub(super) fn searched(&self) -> Searched<'_> {
        let Self { drives, episodes, classes, labels, .. } = self;
        Searched { drives, classes: classes.as_deref(), episodes, labels: labels.as_ref() }
    }

    pub(super) fn read(
        global: &Global,
        path: &Path,
        kind: Kind,
        lake: Option<&Path>,
        class: Option<&ScenarioId>,
    ) -> anyhow::Result<Self> {
        let wanted = |e: &EpisodeRecord| class.is_none_or(|c| e.scenario_id.is_within(c));
        match kind {
            Kind::Mined => mined(path, global.lang, wanted),
            Kind::Framework => {
                let dir = lake.with_context(|| {
                    reason(
                        format!("{} 是框架：请用 --lake 指定要运行的数据湖", path.display()),
                        format!(
                            "{} is a framework: name the lake to run it over with --lake",
                            path.display()
                        ),
                    )
                })?;
                run_rules(global, path, &Lake::open(dir)?, wanted)
            }
            Kind::Release => release(path, wanted),
        }
    }
}

fn mined(dir: &Path, lang: Lang, wanted: impl Fn(&EpisodeRecord) -> bool) -> anyhow::Result<Side> {
    let folder = MinedFolder::open(dir).with_context(|| cannot_read(dir.display()))?;
    let text = |d: &whyroad_model::Diagnostic| anyhow!("{}", output::render_text(d, lang));
    let coverage = folder.coverage().map_err(|d| text(&d))?;
    let mut episodes = Vec::new();
    for episode in folder.episodes().map_err(|e| text(&e.diagnostic()))? {
        let episode = episode.map_err(|d| text(&d))?;
        if wanted(&episode) {
            episodes.push(episode);
        }
    }
    let classes = match folder.question() {
        Some(MiningQuestion::Framework { scenarios }) => Some(scenarios).filter(|s| !s.is_empty()),
        Some(MiningQuestion::Rule { scenario, .. }) => Some(vec![scenario]),
        Some(MiningQuestion::Query { query }) => class_of(&query).map(|class| vec![class]),
        // A folder of an earlier version: what it found is all that is known.
        None => {
            let dir = dir.display();
            let note = match lang {
                Lang::Zh => format!(
                    "警告：{dir} 没有记录挖掘时查询的是哪些类别，按全部类别比较；若当时只查询了部分类别，请用 --scenario 限定，或重新挖掘"
                ),
                Lang::En => format!(
                    "warning: {dir} does not record which classes were asked for and is compared in all; if only some \
                     were, name them with --scenario, or mine again"
                ),
            };
            tell!("{note}");
            None
        }
    };
    Ok(Side { drives: coverage.drives, episodes, classes, labels: None, taxonomy: None, lost: false })
}

/// The class of a `mining_query` message.
fn class_of(query: &serde_json::Value) -> Option<ScenarioId> {
    query.pointer("/mining_query/scenario_id").or_else(|| query.get("scenario_id"))?.as_str()?.parse().ok()
}

/// Runs all rules of a framework over the lake; its errors are reported on stderr.
fn run_rules(
    global: &Global,
    path: &Path,
    lake: &Lake,
    wanted: impl Fn(&EpisodeRecord) -> bool,
) -> anyhow::Result<Side> {
    let (framework, mut found) = if path == Path::new(BUNDLED) {
        (Some(Framework::bundled().clone()), vec![])
    } else {
        framework_folder::read(path)?
    };
    let framework = framework.with_context(|| no_framework(path.display()))?;
    let (catalog, of_signals) = Catalog::parse(&framework.signals_yaml);
    let (rules, of_rules) = RuleSet::of_framework(&framework, &catalog);
    let rules = rules.with_decision_moments(&catalog);
    found.extend(of_signals.into_iter().chain(of_rules));
    for d in &found {
        tell!("{}", output::render_text(d, global.lang));
    }
    // Without a rule that has an error the comparison is not that of the framework as written.
    let is_faulty = found.iter().any(|d| d.severity == Severity::Error);
    let bar = output::progress(lake.drive_ids().len());
    let options = MineOptions { lang: global.lang, ..MineOptions::default() };
    let (mut drives, mut episodes) = (Vec::new(), Vec::new());
    let unread: Result<_, std::convert::Infallible> = mine_each(
        lake,
        &rules,
        &options,
        |id| {
            bar.set_message(format!("{}: {id}", path.display()));
            bar.inc(1);
        },
        |drive| {
            episodes.extend(drive.episodes.into_iter().map(|e| e.record).filter(|e| wanted(e)));
            drives.push(drive.drive_id);
            Ok(())
        },
    );
    bar.finish_and_clear();
    let Ok(unread) = unread;
    for d in &unread {
        tell!("{}", output::render_text(d, global.lang));
    }
    let taxonomy = Some(framework.taxonomy);
    Ok(Side {
        drives,
        episodes,
        classes: None,
        labels: None,
        taxonomy,
        lost: is_faulty || !unread.is_empty(),
    })
}

/// Columns of a release needed for moments.
const COLUMNS: &[&str] = &["sample_id", "scenario_id", "secondary_scenarios", "lineage", "label_json"];

fn release(dir: &Path, wanted: impl Fn(&EpisodeRecord) -> bool) -> anyhow::Result<Side> {
    let cannot = || cannot_read(dir.display());
    let release = Release::open(dir).with_context(cannot)?;
    let mut out =
        Side { drives: vec![], episodes: vec![], classes: None, labels: None, taxonomy: None, lost: false };
    let labels = out.labels.insert(BTreeMap::new());
    for batch in release.batches(None, Some(COLUMNS)) {
        let samples = whyroad_dataset::sample::schema::from_batch(&batch.with_context(cannot)?);
        for sample in samples.map_err(|e| anyhow!("{}: {e}", dir.display()))? {
            labels.insert(sample.sample_id.clone(), content_hash(&sample.label_json).to_string());
            out.drives.push(DriveId::from(sample.lineage.drive_id.as_str()));
            out.episodes.extend(moments(&sample)?.into_iter().filter(|e| wanted(e)));
        }
    }
    out.drives.sort();
    out.drives.dedup();
    Ok(out)
}

/// Adds the target from the other release to each moment without one: plain labels name no target and would not match a
/// release of episodes.
pub(super) fn name_targets(of: &mut [EpisodeRecord], other: &[EpisodeRecord]) {
    let known: BTreeMap<(&DriveId, Nanos), &TrackId> = other
        .iter()
        .filter_map(|e| Some(((&e.drive_id, e.keyframe.timestamp), e.target_id.as_ref()?)))
        .collect();
    for e in of.iter_mut().filter(|e| e.target_id.is_none()) {
        e.target_id = known.get(&(&e.drive_id, e.keyframe.timestamp)).map(|t| (*t).clone());
    }
}

/// A sample as an episode of its class, and one of each class that is secondary to it.
fn moments(sample: &Sample) -> anyhow::Result<Vec<EpisodeRecord>> {
    let class = |id: &str| id.parse::<ScenarioId>().map_err(|e| anyhow!("{}: {e}", sample.sample_id));
    let keyframe = Nanos(sample.lineage.keyframe_time_ns);
    let label: serde_json::Value = serde_json::from_str(&sample.label_json).unwrap_or_default();
    let time = |pointer: &str| {
        let text = label.pointer(pointer).and_then(serde_json::Value::as_str);
        text.and_then(|t| Nanos::parse_iso(t).ok()).unwrap_or(keyframe)
    };
    let primary = EpisodeRecord {
        episode_id: sample.sample_id.clone(),
        scenario_id: class(&sample.scenario_id)?,
        drive_id: DriveId::from(sample.lineage.drive_id.as_str()),
        clip_id: ClipId::from(sample.lineage.clip_id.as_str()),
        target_id: sample.lineage.target_id.as_deref().map(TrackId::from),
        roles: [].into(),
        ego_response: None,
        margin_score: None,
        calibrated: None,
        time_range: TimeRange {
            start_timestamp: time("/time_range/start_timestamp"),
            end_timestamp: time("/time_range/end_timestamp"),
            start_frame_idx: None,
            end_frame_idx: None,
        },
        keyframe: Keyframe {
            timestamp: keyframe,
            frame_idx: sample.lineage.keyframe_frame,
            kind: KeyframeType::Reactive,
            range_start: None,
            range_end: None,
        },
        second_keyframe: None,
        score: sample.lineage.score.unwrap_or(1.0),
        is_primary: true,
        primary_episode_id: None,
        keyframe_rule: Bilingual::default(),
        conditions_matched: vec![],
        signals: vec![],
        rule_version: None,
    };
    let mut out = vec![primary.clone()];
    for id in &sample.secondary_scenarios {
        let secondary = EpisodeRecord {
            episode_id: format!("{} ({id})", sample.sample_id),
            scenario_id: class(id)?,
            is_primary: false,
            primary_episode_id: Some(sample.sample_id.clone()),
            ..primary.clone()
        };
        out.push(secondary);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_release_of_plain_labels_has_the_moments_of_one_of_episodes() {
        let sample = |target: Option<&str>| {
            let mut sample =
                Sample { scenario_id: "reactive_agent.cutin.urgent".into(), ..Sample::default() };
            sample.lineage.drive_id = "d".into();
            sample.lineage.keyframe_time_ns = 7_000_000_000;
            sample.lineage.target_id = target.map(str::to_owned);
            moments(&sample).unwrap()
        };
        let (mut plain, mined) = (sample(None), sample(Some("car7")));
        name_targets(&mut plain, &mined);
        let drives = [DriveId::from("d")];
        let side = |episodes| Searched { drives: &drives, classes: None, episodes, labels: None };
        let found = whyroad_report::comparison::compare(side(&plain), side(&mined), None);
        assert_eq!(found.unchanged, 1);
        let other = {
            let mut e = mined.clone();
            e[0].keyframe.timestamp = Nanos(9_000_000_000);
            e
        };
        let mut plain = sample(None);
        name_targets(&mut plain, &other);
        assert_eq!(plain[0].target_id, None, "another moment");
    }
}
