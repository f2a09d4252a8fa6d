//! Gold tasks: copies of accepted episodes, each for one annotator, compared with the known answer after submission.
//!
//! Nothing that an annotator can read distinguishes a copy from other tasks. Its id is random; its priority, its time
//! of creation and the size of its overlap group are those of an ordinary task that waits in the project, so that
//! neither order nor history reveals it; no field of a task marks it, and it goes through check and audit like any
//! other. Only the queue knows its annotator.

use crate::app::App;
use crate::domain::gold::{GoldPerson, GoldRefused, GoldReport, GoldStanding, GoldTask, MadeGold, NewGold};
use crate::domain::project::{HistoryRule, Project, Settings};
use crate::domain::workflow::{Position, Role, Seen, State};
use crate::problem::{Answer, Problem};
use crate::secret;
use crate::service::compared::compare;
use crate::service::copies::{MARK, NOT_GOLD, episode_of};
use crate::service::projects::{self, json, parse};
use crate::service::tasks::{self, TaskRow};
use crate::service::{create, people, seen, thumbnail};
use crate::store::Tx;
use crate::values;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Maximum number of accepted tasks, and of annotators, in one request.
const MOST_TASKS: usize = 200;
const MOST_PEOPLE: usize = 50;
/// Number of ordinary tasks from which the attributes of a copy are taken.
const DONORS: i64 = 2000;

/// Creates copies of accepted tasks for annotators.
pub fn make(app: &App, tx: &mut dyn Tx, project: &Project, request: &NewGold) -> Answer<MadeGold> {
    if request.tasks.is_empty() || request.tasks.len() > MOST_TASKS || request.users.len() > MOST_PEOPLE {
        return Err(Problem::request(
            format!("须有 1 至 {MOST_TASKS} 个任务、至多 {MOST_PEOPLE} 名标注员"),
            format!("a request must have 1 to {MOST_TASKS} tasks and at most {MOST_PEOPLE} annotators"),
        ));
    }
    let donors = donors(tx, &project.id)?;
    let mut out = MadeGold { made: 0, refused: vec![] };
    for user in &request.users {
        let found = people::find(tx, user)?;
        let roles = found.as_ref().map_or(Ok(vec![]), |u| projects::roles(tx, &project.id, &u.id))?;
        let Some(user) = found.filter(|_| roles.contains(&Role::Annotator)) else {
            return Err(Problem::request(
                format!("'{user}' 不是本项目的标注员"),
                format!("'{user}' is not an annotator of this project"),
            ));
        };
        for source in &request.tasks {
            let source = tasks::get(tx, source)?;
            if source.project != project.id {
                return Err(Problem::missing());
            }
            match refusal(tx, &source, &user.id, &roles, project.settings.history)? {
                Some(text) => {
                    let refused = GoldRefused { task: source.id, user: user.display.clone(), text };
                    out.refused.push(refused);
                }
                None => {
                    copy(app, tx, &source, &user.id, &donors)?;
                    out.made += 1;
                }
            }
        }
    }
    Ok(out)
}

/// Why no copy of `source` can be created for this annotator.
fn refusal(
    tx: &mut dyn Tx,
    source: &TaskRow,
    user: &str,
    roles: &[Role],
    rule: HistoryRule,
) -> Answer<Option<Bilingual>> {
    if source.at.state != State::Accepted {
        return Ok(Some(Bilingual::new("不是已接受的任务", "the task is not accepted")));
    }
    if source.overlap_count > 1 && !source.is_chosen() {
        return Ok(Some(Bilingual::new(
            "该事件有多份标注，此份未被采用",
            "the episode has several labels, and this one was not chosen",
        )));
    }
    let twice = tx.row(
        "SELECT 1 FROM gold WHERE project_id = $1 AND user_id = $2 AND source_task = $3",
        values![&source.project, user, &source.id],
    )?;
    let is_copy = tx.row("SELECT 1 FROM gold WHERE task_id = $1", values![&source.id])?;
    if twice.is_some() || is_copy.is_some() {
        return Ok(Some(Bilingual::new("已有这样的金标任务", "this gold task already exists")));
    }
    if seen::actor(tx, source, user, roles, rule)?.has_seen == Seen::Future {
        return Ok(Some(Bilingual::new(
            "此人已看过关键帧之后的内容",
            "this person has seen what comes after the keyframe",
        )));
    }
    Ok(None)
}

/// An ordinary task from which a copy takes the attributes that would distinguish it.
struct Donor {
    created: i64,
    priority: i64,
    overlap_count: i64,
    maker: Option<String>,
}

fn donors(tx: &mut dyn Tx, project: &str) -> Answer<Vec<Donor>> {
    let sql = format!(
        "SELECT created, priority, overlap_count,
           (SELECT h.actor FROM history h WHERE h.task_id = tasks.id AND h.seq = 1) AS maker
         FROM tasks WHERE project_id = $1 AND state = 'open' AND assigned IS NULL AND {NOT_GOLD}
         ORDER BY id LIMIT $2"
    );
    let rows = tx.rows(&sql, values![project, DONORS])?;
    let one = |r: &crate::store::Row| {
        Ok(Donor {
            created: r.int("created")?,
            priority: r.int("priority")?,
            overlap_count: r.int("overlap_count")?,
            maker: r.maybe_text("maker")?,
        })
    };
    rows.iter().map(one).collect()
}

fn copy(app: &App, tx: &mut dyn Tx, source: &TaskRow, user: &str, donors: &[Donor]) -> Answer<()> {
    let random = secret::id()?;
    let at = u64::from_str_radix(random.get(..12).unwrap_or_default(), 16).unwrap_or_default() as usize;
    let donor = donors.get(at % donors.len().max(1));
    let mut t = source.clone();
    t.id = secret::id()?;
    t.episode.episode_id = format!("{}{MARK}{random}", episode_of(&source.episode.episode_id));
    t.draft = source.initial.clone();
    (t.version, t.seq, t.fence, t.overlap_index) = (1, 0, 0, 0);
    t.at = Position::open();
    (t.audited, t.adjudication, t.assigned, t.lease_until) = (false, None, None, None);
    t.created = donor.map_or_else(|| app.now(), |d| d.created);
    t.priority = donor.map_or(0, |d| d.priority);
    t.overlap_count = donor.map_or(1, |d| d.overlap_count);
    t.thumbnail = thumbnail::get(tx, &source.id)?.unwrap_or_default();
    let (id, project, made) = (t.id.clone(), t.project.clone(), t.created);
    create::store(tx, t, donor.and_then(|d| d.maker.as_deref()), made)?;
    tx.run(
        "INSERT INTO gold (task_id, project_id, user_id, source_task, answer, created) VALUES ($1, $2, $3, $4, $5, $6)",
        values![&id, &project, user, &source.id, json(&source.draft)?, app.now()],
    )?;
    Ok(())
}

/// A gold task in the store, with its comparison.
struct Scored {
    task: String,
    source: String,
    scenario_id: String,
    user: String,
    state: String,
    fields: Option<BTreeMap<&'static str, bool>>,
}

/// Gold tasks of a project, newest first; of one author if one is given. A copy that another person labeled counts for
/// that person.
fn scored(tx: &mut dyn Tx, project: &str, author: Option<&str>) -> Answer<Vec<Scored>> {
    let rows = tx.rows(
        "SELECT g.task_id, g.source_task, g.answer, t.scenario_id, t.state, coalesce(t.author, g.user_id) AS person,
           (SELECT h.snapshot FROM history h WHERE h.task_id = g.task_id AND h.action = 'submit' AND h.snapshot IS NOT NULL
            ORDER BY h.seq LIMIT 1) AS first
         FROM gold g JOIN tasks t ON t.id = g.task_id
         WHERE g.project_id = $1 AND ($2 = '' OR coalesce(t.author, g.user_id) = $3) ORDER BY g.created DESC, g.task_id",
        values![project, author.unwrap_or_default(), author.unwrap_or_default()],
    )?;
    let mut out = Vec::with_capacity(rows.len());
    for r in rows {
        let fields = match r.maybe_text("first")? {
            Some(first) => Some(compare(&parse(&r.text("answer")?)?, &parse(&first)?)),
            None => None,
        };
        out.push(Scored {
            task: r.text("task_id")?,
            source: r.text("source_task")?,
            scenario_id: r.text("scenario_id")?,
            user: r.text("person")?,
            state: r.text("state")?,
            fields,
        });
    }
    Ok(out)
}

fn share(fields: &BTreeMap<&'static str, bool>) -> f64 {
    fields.values().filter(|agrees| **agrees).count() as f64 / fields.len().max(1) as f64 * 100.0
}

fn standing_of(settings: &Settings, shares: &[f64]) -> GoldStanding {
    if settings.gold_labels == 0 {
        return GoldStanding::NotAsked;
    }
    if shares.len() < settings.gold_labels as usize {
        return GoldStanding::Open;
    }
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    if mean >= f64::from(settings.gold_percent) { GoldStanding::Qualified } else { GoldStanding::Failed }
}

/// Whether `author` is qualified in `project`.
pub fn standing(tx: &mut dyn Tx, project: &Project, author: &str) -> Answer<GoldStanding> {
    if project.settings.gold_labels == 0 {
        return Ok(GoldStanding::NotAsked);
    }
    let scored = scored(tx, &project.id, Some(author))?;
    let shares: Vec<f64> = scored.iter().filter_map(|s| s.fields.as_ref()).map(share).collect();
    Ok(standing_of(&project.settings, &shares))
}

/// All gold tasks of `project` and the results of people.
pub fn report(tx: &mut dyn Tx, project: &Project) -> Answer<GoldReport> {
    let names = tasks::names(tx)?;
    let display = |id: &str| names.get(id).cloned().unwrap_or_else(|| id.to_owned());
    let all = scored(tx, &project.id, None)?;
    let mut by_person: BTreeMap<String, Vec<&Scored>> = BTreeMap::new();
    for one in &all {
        by_person.entry(display(&one.user)).or_default().push(one);
    }
    let person = |(user, tasks): (String, Vec<&Scored>)| {
        let done: Vec<_> = tasks.iter().filter_map(|t| t.fields.as_ref()).collect();
        let shares: Vec<f64> = done.iter().map(|f| share(f)).collect();
        let mut fields = BTreeMap::new();
        for field in ["scenario", "longitudinal", "lateral", "keyframe", "objects"] {
            let judged: Vec<bool> = done.iter().filter_map(|f| f.get(field).copied()).collect();
            if !judged.is_empty() {
                let agree = judged.iter().filter(|a| **a).count();
                fields.insert(field.to_owned(), agree as f64 / judged.len() as f64 * 100.0);
            }
        }
        GoldPerson {
            user,
            given: tasks.len() as i64,
            done: done.len() as i64,
            percent: (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64),
            fields,
            standing: standing_of(&project.settings, &shares),
        }
    };
    let task = |s: &Scored| GoldTask {
        task: s.task.clone(),
        source: s.source.clone(),
        scenario_id: s.scenario_id.clone(),
        user: display(&s.user),
        state: s.state.clone(),
        differs: s
            .fields
            .as_ref()
            .map(|f| f.iter().filter(|(_, a)| !**a).map(|(n, _)| (*n).to_owned()).collect()),
    };
    Ok(GoldReport {
        tasks: all.iter().map(task).collect(),
        people: by_person.into_iter().map(person).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn label(keyframe: &str, longitudinal: &str, objects: Value) -> Value {
        json!({
            "scenario": { "l1": "a", "l2": "b", "l3": "c" },
            "keyframe": { "timestamp": keyframe },
            "driving_decision": { "longitudinal": longitudinal, "lateral": null },
            "causes": { "longitudinal": { "components": ["c1"] } },
            "critical_components": [{ "id": "c1", "linked_objects": objects }, { "id": "c2", "linked_objects": ["other"] }],
        })
    }

    #[test]
    fn a_label_agrees_field_by_field() {
        let answer = label("2026-01-01T00:00:05.000Z", "yield_to_agent", json!(["t1"]));
        assert_eq!(share(&compare(&answer, &answer)), 100.0);
        // 0.5 s is still accepted; another decision and another object do not agree.
        let near = label("2026-01-01T00:00:05.500Z", "yield_to_agent", json!(["t1", "t2"]));
        assert_eq!(share(&compare(&answer, &near)), 100.0);
        let wrong = label("2026-01-01T00:00:05.600Z", "lead_following", json!(["other"]));
        let differs: Vec<&str> =
            compare(&answer, &wrong).into_iter().filter(|(_, a)| !a).map(|(n, _)| n).collect();
        assert_eq!(differs, ["keyframe", "longitudinal", "objects"]);
        assert_eq!(share(&compare(&answer, &wrong)), 40.0);
        // An answer without objects requires none.
        let bare = label("2026-01-01T00:00:05.000Z", "yield_to_agent", json!([]));
        assert_eq!(compare(&bare, &wrong).len(), 4);
    }

    #[test]
    fn who_is_qualified_follows_the_settings() {
        let asks =
            |labels, percent| Settings { gold_labels: labels, gold_percent: percent, ..Settings::default() };
        assert_eq!(standing_of(&asks(0, 80), &[0.0]), GoldStanding::NotAsked);
        assert_eq!(standing_of(&asks(2, 80), &[100.0]), GoldStanding::Open);
        assert_eq!(standing_of(&asks(2, 80), &[100.0, 60.0]), GoldStanding::Qualified);
        assert_eq!(standing_of(&asks(2, 80), &[80.0, 60.0]), GoldStanding::Failed);
        assert_eq!(episode_of("e1~abc"), "e1");
        assert_eq!(episode_of("e1"), "e1");
    }
}
