//! Judgments of labels: true/false questions with a model's answers, and with people's answers for the labels that were
//! drawn for them. They are only information: no permitted action on a task depends on them.

use crate::domain::model::{JudgeAgreement, JudgeReport, Judgement, JudgementAnswers};
use crate::domain::workflow::{Actor, Role, State};
use crate::problem::{Answer, Problem};
use crate::service::projects::{json, parse};
use crate::service::tasks::{self, Entry, TaskRow};
use crate::service::{history, leases};
use crate::store::{Row, Tx};
use crate::values;
use std::collections::BTreeSet;
use whyroad_label::agreement::Estimate;
use whyroad_label::judged::{JudgedLabel, Question, QuestionAgreement, agreement_with_people};

/// `judge` of the model's answers; people's answers have their user's id.
const MODEL: &str = "";
/// Seed of the intervals.
const SEED: u64 = 1;

/// States with a submitted label that nobody may change now.
pub const HANDED_IN: [State; 5] =
    [State::Submitted, State::InCheck, State::Checked, State::InAudit, State::Accepted];

/// Stores a model's answers about the label of `t`; `actor` started the run. The state of the task does not change.
pub fn put(tx: &mut dyn Tx, t: &mut TaskRow, judged: &JudgedLabel, actor: &str, now: i64) -> Answer<()> {
    write(tx, t, MODEL, judged, now)?;
    let (moved, from) = (t.updated, Some(t.at.state));
    let note = Some(judged.judge.as_str());
    let entry = Entry { action: "judge", actor: Some(actor), from, note, ..Entry::default() };
    history::record(tx, t, &entry, now)?;
    t.updated = moved;
    tasks::update(tx, t)
}

fn write(tx: &mut dyn Tx, t: &TaskRow, judge: &str, judged: &JudgedLabel, now: i64) -> Answer<()> {
    tx.run(
        "INSERT INTO judgements (task_id, judge, project_id, version, answers, passed, for_people, at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)
         ON CONFLICT (task_id, judge) DO UPDATE SET version = excluded.version, answers = excluded.answers,
           passed = excluded.passed, for_people = excluded.for_people, at = excluded.at",
        values![
            &t.id,
            judge,
            &t.project,
            t.version,
            json(judged)?,
            judged.passed.map(i64::from),
            i64::from(judged.for_people),
            now,
        ],
    )
    .map(drop)
}

/// Answers about a label, and the version of the task to which they belong.
struct Stored {
    judged: JudgedLabel,
    version: i64,
    at: i64,
}

fn stored(tx: &mut dyn Tx, task: &str, judge: &str) -> Answer<Option<Stored>> {
    let sql = "SELECT version, answers, at FROM judgements WHERE task_id = $1 AND judge = $2";
    let Some(row) = tx.row(sql, values![task, judge])? else { return Ok(None) };
    let judged = parse(&row.text("answers")?)?;
    Ok(Some(Stored { judged, version: row.int("version")?, at: row.int("at")? }))
}

/// A model's judgment of the label of `t`, as far as `actor` may see it: checkers, auditors and leads, once Stage I is
/// over. Users who may still have to answer the same questions do not see the model's answers, because theirs would not
/// be independent then.
pub fn of(tx: &mut dyn Tx, t: &TaskRow, actor: &Actor) -> Answer<Option<Judgement>> {
    let checks = actor.is(Role::Checker) || actor.is(Role::Auditor);
    if !t.at.state.shows_future() || !(checks || actor.is(Role::Lead)) || t.at.author() == Some(&actor.id) {
        return Ok(None);
    }
    let Some(model) = stored(tx, &t.id, MODEL)? else { return Ok(None) };
    let own = stored(tx, &t.id, &actor.id)?.filter(|own| own.version == model.version);
    let outdated = model.version != t.version;
    let finished = matches!(t.at.state, State::Accepted | State::Skipped | State::Rejected);
    let withheld = model.judged.for_people && checks && own.is_none() && !outdated && !finished;
    let asks = withheld && may_answer(t, &actor.id);
    let shown = if withheld { model.judged.blank() } else { model.judged.clone() };
    let answer = |q: Question| Some((q.id, q.answer?));
    Ok(Some(Judgement {
        model: model.judged.judge,
        at: model.at,
        outdated,
        for_people: model.judged.for_people,
        asks,
        withheld,
        questions: shown.questions,
        own: own.map(|o| o.judged.questions.into_iter().filter_map(answer).collect()).unwrap_or_default(),
    }))
}

/// The user checks or audits it now.
fn may_answer(t: &TaskRow, user: &str) -> bool {
    t.at.holder.as_deref() == Some(user) && matches!(t.at.state, State::InCheck | State::InAudit)
}

/// Stores the answers of the user who checks or audits `t`.
pub fn answer(
    tx: &mut dyn Tx,
    id: &str,
    actor: &Actor,
    given: &JudgementAnswers,
    now: i64,
) -> Answer<TaskRow> {
    let mut t = tasks::get_for_change(tx, id)?;
    let role = if t.at.state == State::InAudit { Role::Auditor } else { Role::Checker };
    leases::held_as(&t, actor, role, Some(given.fence))?;
    let model = stored(tx, id, MODEL)?.filter(|m| m.version == t.version && m.judged.for_people);
    let Some(model) = model.filter(|_| may_answer(&t, &actor.id)) else {
        return Err(Problem::new(
            409,
            "judgement.not_asked",
            "此标注没有需要人工回答的问题",
            "this label has no questions for people",
        ));
    };
    let mut own = model.judged.blank();
    let known = |id: &String| own.questions.iter().any(|q| q.id == *id);
    if given.answers.is_empty() || !given.answers.keys().all(known) {
        return Err(Problem::request(
            "至少回答一个问题，且只回答列出的问题",
            "answer at least one question, and only questions that are listed",
        ));
    }
    for q in &mut own.questions {
        q.answer = given.answers.get(&q.id).copied();
    }
    own.decide();
    write(tx, &t, &actor.id, &own, now)?;
    let (actor, from) = (Some(actor.id.as_str()), Some(t.at.state));
    let entry = Entry { action: "judge_answers", actor, from, ..Entry::default() };
    history::record(tx, &mut t, &entry, now)?;
    tasks::update(tx, &t)?;
    Ok(t)
}

/// The judge's results for the labels of `project`, and its agreement with people.
pub fn report(tx: &mut dyn Tx, project: &str) -> Answer<JudgeReport> {
    let row = tx.row(
        "SELECT count(*) AS n, count(CASE WHEN passed = 1 THEN 1 END) AS passed,
           count(CASE WHEN for_people = 1 THEN 1 END) AS people
         FROM judgements WHERE project_id = $1 AND judge = ''",
        values![project],
    )?;
    let count = |column: &str| row.as_ref().map_or(Ok(0), |r| r.int(column));
    let (judged, passed, for_people) = (count("n")?, count("passed")?, count("people")?);
    let people = tx.rows(
        "SELECT p.task_id AS task, p.judge AS judge, p.answers AS answers, m.answers AS model
         FROM judgements p JOIN judgements m ON m.task_id = p.task_id AND m.judge = ''
         WHERE p.project_id = $1 AND p.judge <> '' ORDER BY p.task_id, p.judge",
        values![project],
    )?;
    // Several tasks may have the same clip and keyframe, and several people may answer for one task: pairs are matched
    // by both.
    let named = |r: &Row, column: &str| -> Answer<JudgedLabel> {
        let judged: JudgedLabel = parse(&r.text(column)?)?;
        Ok(JudgedLabel { clip_id: format!("{} {}", r.text("task")?, r.text("judge")?), ..judged })
    };
    let theirs = people.iter().map(|r| named(r, "answers")).collect::<Answer<Vec<_>>>()?;
    let model = people.iter().map(|r| named(r, "model")).collect::<Answer<Vec<_>>>()?;
    let found = agreement_with_people(&model, &theirs, SEED);
    let tasks: BTreeSet<&str> = theirs.iter().filter_map(|j| j.clip_id.split(' ').next()).collect();
    let kinds = found.kinds.iter().filter(|k| k.answers > 0).map(agreement).collect();
    Ok(JudgeReport { judged, passed, for_people, answered: tasks.len() as i64, kinds })
}

fn agreement(of: &QuestionAgreement) -> JudgeAgreement {
    let interval = |e: &Estimate| e.low.zip(e.high).map(|(low, high)| [low, high]);
    let [_, only_judge, only_people, _] = of.counts;
    JudgeAgreement {
        kind: of.kind.to_owned(),
        answers: of.answers as i64,
        same: of.same.value,
        same_interval: interval(&of.same),
        kappa: of.kappa.value,
        only_judge: only_judge as i64,
        only_people: only_people as i64,
    }
}
