//! Which episode an imported label is about: a mined one, or the episode of a task. Labels that were imported before
//! their episode was known get it when tasks are created from it, so that it never has two tasks.

use crate::app::App;
use crate::problem::{Answer, Problem};
use crate::service::projects::{json, parse};
use crate::service::tasks::{self, Entry};
use crate::service::{copies, history};
use crate::values;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use whyroad_label::episode_of::{MADE, fits, is_made, linked};
use whyroad_model::messages::{EpisodeFilter, EpisodeRecord};
use whyroad_model::{DriveId, Nanos, ScenarioId};

/// Episodes of a mined folder that are read at once.
const PAGE: usize = 500;

type Moment = (ScenarioId, Nanos);

fn moment(e: &EpisodeRecord) -> Moment {
    (e.scenario_id.clone(), e.keyframe.timestamp)
}

/// The known episodes of one drive, by class and keyframe.
#[derive(Default)]
pub struct KnownEpisodes {
    drive: Option<DriveId>,
    by_moment: BTreeMap<Moment, Vec<EpisodeRecord>>,
}

impl KnownEpisodes {
    /// The episode that `label` is about; `made` was made from it. Labels come sorted by drive, so that each is read
    /// once.
    pub fn of(&mut self, app: &App, made: &EpisodeRecord, label: &Value) -> Answer<Option<EpisodeRecord>> {
        if self.drive.as_ref() != Some(&made.drive_id) {
            self.by_moment = read(app, &made.drive_id)?;
            self.drive = Some(made.drive_id.clone());
        }
        let here = self.by_moment.get(&moment(made)).map(Vec::as_slice).unwrap_or_default();
        let objects = linked(label);
        let fitting: Vec<&EpisodeRecord> = here.iter().filter(|e| fits(&objects, e)).collect();
        // Where several fit, one whose target the label links is meant, and a primary one rather than a secondary one.
        let is_named =
            |e: &EpisodeRecord| e.target_id.as_ref().is_some_and(|t| objects.contains(&t.to_string()));
        let best =
            fitting.iter().max_by_key(|e| (is_named(e), e.is_primary, std::cmp::Reverse(&e.episode_id)));
        Ok(best.map(|e| (*e).clone()))
    }
}

/// Episodes of the tasks of all projects and of all mined folders.
fn read(app: &App, drive: &DriveId) -> Answer<BTreeMap<Moment, Vec<EpisodeRecord>>> {
    let mut out: BTreeMap<String, EpisodeRecord> = BTreeMap::new();
    let sql = "SELECT episode FROM tasks WHERE drive_id = $1";
    let rows = app.store.read(|tx| tx.rows(sql, values![drive.as_str()]))?;
    for row in rows {
        let e: EpisodeRecord = parse(&row.text("episode")?)?;
        // Of copies and of tasks of another class, whose ids come from the mined one, the mined one is meant.
        if !is_made(&e.episode_id) && copies::mined_of(&e.episode_id) == e.episode_id {
            out.insert(e.episode_id.clone(), e);
        }
    }
    let filter = EpisodeFilter { drive: Some(drive.clone()), ..EpisodeFilter::default() };
    for name in app.recordings.mined() {
        let mut next = None;
        while let Some(page) = app.recordings.episodes(&name, &filter, next, PAGE) {
            let page = page.map_err(Problem::mined_unreadable)?;
            out.extend(page.episodes.into_iter().map(|e| (e.episode_id.clone(), e)));
            next = page.next;
            if next.is_none() {
                break;
            }
        }
    }
    let mut by_moment: BTreeMap<Moment, Vec<EpisodeRecord>> = BTreeMap::new();
    for e in out.into_values() {
        by_moment.entry(moment(&e)).or_default().push(e);
    }
    Ok(by_moment)
}

/// Ids of tasks, each with the objects that its label links.
type Linked = Vec<(String, BTreeSet<String>)>;

/// Tasks of imported labels whose episode is not known yet, by drive, class and keyframe.
pub struct Unnamed(HashMap<(String, String, i64), Linked>);

impl Unnamed {
    /// Those of all projects.
    pub fn of(app: &App) -> Answer<Self> {
        let sql = format!(
            "SELECT id, drive_id, scenario_id, keyframe_ns, initial FROM tasks WHERE episode_id LIKE '{MADE}%'"
        );
        let mut out: HashMap<_, Vec<_>> = HashMap::new();
        for row in app.store.read(|tx| tx.rows(&sql, &[]))? {
            let key = (row.text("drive_id")?, row.text("scenario_id")?, row.int("keyframe_ns")?);
            let initial: Value = parse(&row.text("initial")?)?;
            out.entry(key).or_default().push((row.text("id")?, linked(&initial)));
        }
        Ok(Self(out))
    }

    /// Gives `episode` to the tasks of labels about it.
    pub fn name(&mut self, app: &App, episode: &EpisodeRecord) -> Answer<()> {
        let key =
            (episode.drive_id.to_string(), episode.scenario_id.to_string(), episode.keyframe.timestamp.0);
        let Some(here) = self.0.get_mut(&key) else { return Ok(()) };
        let (about, rest) = std::mem::take(here).into_iter().partition(|(_, objects)| fits(objects, episode));
        *here = rest;
        let about: Linked = about;
        let (episode, now) = (episode.clone(), app.now());
        app.store.write(move |tx| {
            for (id, _) in &about {
                let mut t = tasks::get_for_change(tx, id)?;
                let taken = tx.row(
                    "SELECT 1 FROM tasks WHERE project_id = $1 AND episode_id = $2 AND overlap_index = $3 LIMIT 1",
                    values![&t.project, &episode.episode_id, t.overlap_index],
                )?;
                if taken.is_some() || !is_made(&t.episode.episode_id) {
                    continue;
                }
                let note = format!("episode {}", episode.episode_id);
                let entry = Entry { action: "edit", from: Some(t.at.state), note: Some(&note), ..Entry::default() };
                history::record(tx, &mut t, &entry, now)?;
                tasks::update(tx, &t)?;
                tx.run(
                    "UPDATE tasks SET episode = $1, episode_id = $2 WHERE id = $3",
                    values![json(&episode)?, &episode.episode_id, id],
                )?;
            }
            Ok(())
        })
    }
}
