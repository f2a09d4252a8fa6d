//! Progress and quality of a project: tasks by state, actions of users, agreement, coverage, audit results.
//! Read only; computed from the tasks and their history.

use crate::domain::project::{
    Ageing, Agreement, AuditRecord, Coverage, Dashboard, PairAgreement, Project, Settings, Throughput,
};
use crate::problem::Answer;
use crate::service::copies::NOT_GOLD;
use crate::service::disagreement::{NOT_SUPERSEDED, STANDS, TO_CHOOSE};
use crate::service::projects::{self, DAY_MS, parse};
use crate::service::{by_state, disagreement, drafts, safety, tasks, veil};
use crate::store::Tx;
use crate::values;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use whyroad_label::agreement::{cohen_pooled, fleiss, median};
use whyroad_model::Nanos;
use whyroad_model::label_fields::pointer;

/// Number of days of throughput that are shown.
const DAYS: i64 = 60;
/// Number of tasks with the oldest last change that are shown.
const OLDEST: i64 = 20;

/// Number of the newest audits that are counted.
const RECENT_AUDITS: i64 = 50;
/// Minimum number of audits for a record; before that an author counts as unknown and is audited at the maximum rate.
const RECORD_LENGTH: i64 = 10;
/// Share of failed audits at which the author's audit rate is at its maximum.
const POOR_RECORD: f64 = 0.2;

type Names = HashMap<String, String>;

/// The dashboard of `project` at `now` (ms since 1970).
pub fn of(tx: &mut dyn Tx, project: &Project, now: i64) -> Answer<Dashboard> {
    let names = tasks::names(tx)?;
    Ok(Dashboard {
        by_state: by_state::of(tx, &project.id)?,
        submitted: by_state::submitted(tx, &project.id)?,
        utc_offset_min: project.settings.utc_offset_min,
        throughput: throughput(tx, project, &names, now)?,
        ageing: ageing(tx, &project.id, &names, now)?,
        agreement: agreement(tx, &project.id, &names)?,
        to_choose: disagreement::episodes_to_choose(tx, &project.id)?,
        coverage: coverage(tx, project)?,
        audit: audit_outcomes(tx, project, &names)?,
        safety: safety::counts(tx, &project.id)?,
    })
}

fn display(names: &Names, id: Option<String>) -> Option<String> {
    id.map(|id| names.get(&id).cloned().unwrap_or(id))
}

fn throughput(tx: &mut dyn Tx, project: &Project, names: &Names, now: i64) -> Answer<Vec<Throughput>> {
    let rows = tx.rows(
        "SELECT day, actor, action, n FROM activity WHERE project_id = $1 AND day >= $2",
        values![&project.id, projects::day(&project.settings, now) - DAYS],
    )?;
    let mut out = Vec::new();
    for r in rows {
        let midnight = Nanos(r.int("day")? * DAY_MS * 1_000_000);
        let day = midnight.to_string().chars().take(10).collect();
        let user = display(names, Some(r.text("actor")?)).unwrap_or_default();
        out.push(Throughput { day, user, action: r.text("action")?, count: r.int("n")? });
    }
    out.sort_by(|a, b| (&b.day, &a.user, &a.action).cmp(&(&a.day, &b.user, &b.action)));
    Ok(out)
}

/// Unfinished tasks by the time without a change: what somebody can act on. Labels that are handed in and that nobody
/// can check yet are left out while other labels of their episode are missing, since those are listed themselves; an
/// episode that waits for the choice of a lead is one row, which began to wait with its last label.
fn ageing(tx: &mut dyn Tx, project: &str, names: &Names, now: i64) -> Answer<Vec<Ageing>> {
    let class = veil::shown_class_sql(&veil::of(tx, project)?);
    let sql = format!(
        "SELECT id, {class} AS shown_class, state, coalesce(holder, assigned, author) AS person, updated,
           CASE WHEN {TO_CHOOSE} THEN 1 ELSE 0 END AS to_choose FROM tasks
         WHERE project_id = $1 AND state NOT IN ('accepted', 'skipped', 'rejected') AND {NOT_SUPERSEDED}
           AND (state <> 'submitted' OR {STANDS} OR ({TO_CHOOSE} AND NOT EXISTS (SELECT 1 FROM tasks o
             WHERE o.project_id = tasks.project_id AND o.episode_id = tasks.episode_id AND o.complete = 1
               AND o.adjudication IS NULL AND o.state NOT IN ('accepted', 'skipped', 'rejected')
               AND (o.updated > tasks.updated OR (o.updated = tasks.updated AND o.id > tasks.id)))))
         ORDER BY updated, id LIMIT $2"
    );
    let rows = tx.rows(&sql, values![project, OLDEST])?;
    let one = |r: &crate::store::Row| {
        let to_choose = r.flag("to_choose")?;
        Ok(Ageing {
            task: r.text("id")?,
            scenario_id: r.text("shown_class")?,
            state: r.text("state")?,
            to_choose,
            // Its authors are done: a lead has it.
            user: display(names, r.maybe_text("person")?).filter(|_| !to_choose),
            // A clock that was set back gives no negative age.
            hours: (now - r.int("updated")?).max(0) as f64 / 3_600_000.0,
        })
    };
    rows.iter().map(one).collect()
}

/// Decision of one person about an episode.
struct Rated {
    author: String,
    longitudinal: String,
    lateral: String,
    keyframe: Option<Nanos>,
}

impl Rated {
    fn of(author: String, label: &Value) -> Self {
        let word = |at: &str| label.pointer(at).and_then(Value::as_str).unwrap_or("null").to_owned();
        let direction = label.pointer(pointer::DRIVING_DECISION_LATERAL_DIRECTION).and_then(Value::as_str);
        let lateral = word(pointer::DRIVING_DECISION_LATERAL);
        let keyframe = label.pointer(pointer::KEYFRAME_TIMESTAMP).and_then(Value::as_str);
        Self {
            author,
            longitudinal: word(pointer::DRIVING_DECISION_LONGITUDINAL),
            lateral: direction.map_or(lateral.clone(), |d| format!("{lateral} {d}")),
            keyframe: keyframe.and_then(|t| Nanos::parse_iso(t).ok()),
        }
    }
}

/// Labels of overlap groups, by episode: as first submitted, before a check could make them more similar.
fn overlaps(tx: &mut dyn Tx, project: &str) -> Answer<Vec<Vec<Rated>>> {
    let rows = tx.rows(
        "SELECT t.id, t.episode_id, t.author, h.seq, h.snapshot FROM tasks t JOIN history h ON h.task_id = t.id
         WHERE t.project_id = $1 AND t.overlap_count > 1 AND t.author IS NOT NULL AND h.action = 'submit'
           AND h.seq = (SELECT min(f.seq) FROM history f WHERE f.task_id = t.id AND f.action = 'submit')",
        values![project],
    )?;
    let mut groups: BTreeMap<String, Vec<Rated>> = BTreeMap::new();
    for r in rows {
        // Submissions are stored completely; older ones are rebuilt from their changes.
        let label = match r.maybe_text("snapshot")? {
            Some(snapshot) => parse(&snapshot)?,
            None => {
                let t = tasks::get(tx, &r.text("id")?)?;
                drafts::at(tx, &t, r.int("seq")?)?
            }
        };
        groups.entry(r.text("episode_id")?).or_default().push(Rated::of(r.text("author")?, &label));
    }
    let mut groups: Vec<Vec<Rated>> = groups.into_values().filter(|g| g.len() > 1).collect();
    groups.iter_mut().for_each(|g| g.sort_by(|a, b| a.author.cmp(&b.author)));
    Ok(groups)
}

fn agreement(tx: &mut dyn Tx, project: &str, names: &Names) -> Answer<Agreement> {
    let groups = overlaps(tx, project)?;
    let mut by_pair: BTreeMap<(&str, &str), Vec<(&Rated, &Rated)>> = BTreeMap::new();
    for group in &groups {
        for (i, a) in group.iter().enumerate() {
            for b in &group[i + 1..] {
                by_pair.entry((&a.author, &b.author)).or_default().push((a, b));
            }
        }
    }
    let all: Vec<(&Rated, &Rated)> = by_pair.values().flatten().copied().collect();
    let away: Vec<f64> =
        all.iter().filter_map(|(a, b)| Some(a.keyframe?.seconds_since(b.keyframe?).abs())).collect();
    let kappa = |pairs: &[(&Rated, &Rated)], of: fn(&Rated) -> &str| {
        let rated = |r: &Rated| (r.author.clone(), of(r).to_owned());
        cohen_pooled(&pairs.iter().map(|(a, b)| (rated(a), rated(b))).collect::<Vec<_>>())
    };
    let group_kappa = |of: fn(&Rated) -> &str| {
        fleiss(&groups.iter().map(|g| g.iter().map(of).collect::<Vec<_>>()).collect::<Vec<_>>())
    };
    let name = |id: &str| names.get(id).cloned().unwrap_or_else(|| id.to_owned());
    Ok(Agreement {
        pairs: all.len() as u32,
        longitudinal_kappa: kappa(&all, |r| &r.longitudinal),
        lateral_kappa: kappa(&all, |r| &r.lateral),
        groups: groups.len() as u32,
        longitudinal_fleiss: group_kappa(|r| &r.longitudinal),
        lateral_fleiss: group_kappa(|r| &r.lateral),
        keyframe_median_s: median(away.clone()),
        keyframe_worst_s: away.into_iter().reduce(f64::max),
        by_pair: by_pair
            .iter()
            .map(|((a, b), pairs)| PairAgreement {
                users: [name(a), name(b)],
                labels: pairs.len() as u32,
                longitudinal_kappa: kappa(pairs, |r| &r.longitudinal),
                lateral_kappa: kappa(pairs, |r| &r.lateral),
            })
            .collect(),
    })
}

/// The episodes of a project by L3 class, without those of which every task was skipped or rejected, and the accepted
/// ones. Reads only an index, even with a hundred thousand tasks.
pub(super) fn coverage_sql() -> String {
    format!(
        "SELECT scenario_id,
           count(DISTINCT CASE WHEN state NOT IN ('skipped', 'rejected') THEN episode_id END) AS mined,
           count(DISTINCT CASE WHEN state = 'accepted' THEN episode_id END) AS accepted
         FROM tasks WHERE project_id = $1 AND {NOT_GOLD} GROUP BY scenario_id"
    )
}

/// Each episode counts once, however many people label it.
fn coverage(tx: &mut dyn Tx, project: &Project) -> Answer<Vec<Coverage>> {
    let rows = tx.rows(&coverage_sql(), values![&project.id])?;
    let mut leaves: BTreeMap<String, (i64, i64)> = BTreeMap::new();
    for r in rows {
        leaves.insert(r.text("scenario_id")?, (r.int("mined")?, r.int("accepted")?));
    }
    for leaf in project.quota.keys() {
        leaves.entry(leaf.clone()).or_default();
    }
    let one = |(leaf, (mined, have)): (String, (i64, i64))| {
        let quota = project.quota.get(&leaf).map_or(0, |n| i64::from(*n));
        Coverage { leaf, have, quota, mined, shortfall: (quota - mined).max(0) }
    };
    Ok(leaves.into_iter().map(one).collect())
}

/// The coverage with the L3 classes of `veiled` L2 classes counted together: how many tasks of each are left would tell
/// a person who labels what Stage I hides.
pub fn veil_coverage(coverage: Vec<Coverage>, veiled: &[String]) -> Vec<Coverage> {
    let mut out = BTreeMap::new();
    for mut c in coverage {
        let l2 = veil::l2(&c.leaf);
        if veiled.iter().any(|v| v == l2) {
            c.leaf = l2.to_owned();
        }
        out.entry(c.leaf.clone())
            .and_modify(|o: &mut Coverage| {
                o.have += c.have;
                o.quota += c.quota;
                o.mined += c.mined;
                o.shortfall += c.shortfall;
            })
            .or_insert(c);
    }
    out.into_values().collect()
}

fn audit_outcomes(tx: &mut dyn Tx, project: &Project, names: &Names) -> Answer<Vec<AuditRecord>> {
    let authors = tx.rows(
        "SELECT DISTINCT author FROM tasks WHERE project_id = $1 AND author IS NOT NULL",
        values![&project.id],
    )?;
    let records = audit_records(tx, &audits_sql("t.author IS NOT NULL"), values![&project.id])?;
    let mut out = Vec::new();
    for r in authors {
        let id = r.text("author")?;
        let (audited, failed) = records.get(&id).copied().unwrap_or_default();
        let share_percent = audit_share(&project.settings, audited, failed);
        let author = display(names, Some(id)).unwrap_or_default();
        out.push(AuditRecord { author, audited, failed, share_percent });
    }
    out.sort_by(|a, b| a.author.cmp(&b.author));
    Ok(out)
}

/// Number of `author`'s labels in `project` that were audited, and how many of these were returned; only the newest
/// [`RECENT_AUDITS`], so that an author who has improved is not audited for old errors.
pub fn audit_record(tx: &mut dyn Tx, project: &str, author: &str) -> Answer<(i64, i64)> {
    let records = audit_records(tx, &audits_sql("t.author = $2"), values![project, author])?;
    Ok(records.get(author).copied().unwrap_or_default())
}

/// The newest audits of these authors, counted by outcome; one query for all of them.
pub(super) fn audits_sql(authors: &str) -> String {
    format!(
        "SELECT author, action, count(*) AS n FROM (
           SELECT t.author AS author, h.action AS action,
             row_number() OVER (PARTITION BY t.author ORDER BY h.at DESC, h.task_id, h.seq DESC) AS place
           FROM history h JOIN tasks t ON t.id = h.task_id
           WHERE t.project_id = $1 AND {authors} AND h.from_state = 'in_audit' AND h.action IN ('accept', 'send_back')
         ) AS audits WHERE place <= {RECENT_AUDITS} GROUP BY author, action"
    )
}

/// By author, the number of audited labels, and how many of these were returned.
fn audit_records(
    tx: &mut dyn Tx,
    sql: &str,
    values: &[crate::store::Value],
) -> Answer<HashMap<String, (i64, i64)>> {
    let mut out = HashMap::new();
    for r in tx.rows(sql, values)? {
        let (audited, failed): &mut (i64, i64) = out.entry(r.text("author")?).or_default();
        let n = r.int("n")?;
        *audited += n;
        if r.text("action")? == "send_back" {
            *failed += n;
        }
    }
    Ok(out)
}

/// Audit rate of an author's labels, in percent (LABELING.md 6: 10 to 20 by the author's record): the maximum until
/// there is a record, then from the minimum to the maximum as the share of failed audits rises from 0 to
/// [`POOR_RECORD`].
pub fn audit_share(settings: &Settings, audited: i64, failed: i64) -> f64 {
    let (least, most) = (f64::from(settings.audit_min_percent), f64::from(settings.audit_max_percent));
    if audited < RECORD_LENGTH {
        return most;
    }
    least + (most - least) * (failed as f64 / audited as f64 / POOR_RECORD).min(1.0)
}

#[cfg(test)]
mod tests;
