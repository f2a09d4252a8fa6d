//! Agreement of a judge with people: question by question with the answers of a file, or label by label with the
//! actions of checkers in the labeling service.

use super::{JudgedLabel, QuestionKind};
use crate::agreement::{Estimate, bootstrap, cohen};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use whyroad_model::Nanos;

/// Agreement on the questions of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuestionAgreement {
    /// `decision`, ..., or `all`; `label` where whole labels are compared.
    pub kind: &'static str,
    /// Pairs of answers.
    pub answers: usize,
    /// Share of equal answers.
    pub same: Estimate,
    /// Cohen's kappa.
    pub kappa: Estimate,
    /// Number of cases in which both find an error; only the judge; only the people; neither.
    pub counts: [usize; 4],
}

/// Agreement of a judge with people.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeopleAgreement {
    /// Labels that both judged.
    pub labels: usize,
    /// Labels of the people that the judge has not judged, or that have no answer yet.
    pub unmatched: usize,
    /// By kind, then over all kinds.
    pub kinds: Vec<QuestionAgreement>,
}

/// Whether each side finds no error.
type Pair = (bool, bool);

/// Compares answer by answer. An answer that a person left open does not count.
pub fn agreement_with_people(judged: &[JudgedLabel], people: &[JudgedLabel], seed: u64) -> PeopleAgreement {
    let index: BTreeMap<(&str, Nanos), &JudgedLabel> =
        judged.iter().map(|j| ((j.clip_id.as_str(), j.keyframe), j)).collect();
    let (mut by_kind, mut labels): (BTreeMap<QuestionKind, Vec<Pair>>, usize) = (BTreeMap::new(), 0);
    for person in people {
        let Some(own) = index.get(&(person.clip_id.as_str(), person.keyframe)) else { continue };
        let mut any = false;
        for question in &person.questions {
            let same = own.questions.iter().find(|q| q.id == question.id && q.text == question.text);
            let Some(pair) = same.and_then(|q| q.passed().zip(question.passed())) else { continue };
            by_kind.entry(question.kind).or_default().push(pair);
            any = true;
        }
        labels += usize::from(any);
    }
    let mut kinds: Vec<QuestionAgreement> = QuestionKind::ALL
        .into_iter()
        .filter_map(|kind| Some(of(kind.id(), by_kind.get(&kind)?, seed)))
        .collect();
    let all: Vec<Pair> = by_kind.into_values().flatten().collect();
    kinds.push(of("all", &all, seed));
    PeopleAgreement { labels, unmatched: people.len() - labels, kinds }
}

/// Compares whole labels with tasks of the labeling service (`tasks export --content tasks`): people find no error in a
/// label that was accepted without being returned.
pub fn agreement_with_tasks(judged: &[JudgedLabel], tasks: &[Value], seed: u64) -> PeopleAgreement {
    let index: BTreeMap<(&str, Nanos), bool> =
        judged.iter().filter_map(|j| Some(((j.clip_id.as_str(), j.keyframe), j.passed?))).collect();
    let (mut pairs, mut unmatched) = (Vec::new(), 0);
    for line in tasks {
        let task = line.get("task").unwrap_or(line);
        let Some((clip, keyframe, accepted)) = verdict(task) else { continue };
        match index.get(&(clip.as_str(), keyframe)) {
            Some(passed) => pairs.push((*passed, accepted)),
            None => unmatched += 1,
        }
    }
    PeopleAgreement { labels: pairs.len(), unmatched, kinds: vec![of("label", &pairs, seed)] }
}

/// Clip and keyframe of the label that was checked first, and whether it was accepted unchanged. `None` where nobody
/// has decided.
fn verdict(task: &Value) -> Option<(String, Nanos, bool)> {
    let history: Vec<&Value> = task.get("history")?.as_array()?.iter().collect();
    let action = |e: &&Value| e.get("action").and_then(Value::as_str).unwrap_or_default().to_owned();
    let returned = history.iter().any(|e| ["send_back", "reject", "reopen"].contains(&action(e).as_str()));
    let accepted = task.get("state").and_then(Value::as_str) == Some("accepted");
    if !returned && !accepted {
        return None;
    }
    let first = history.iter().find(|e| action(e) == "submit").and_then(|e| e.get("draft"));
    let label = first.filter(|l| l.is_object()).or_else(|| task.get("draft"))?;
    let keyframe = Nanos::parse_iso(label.pointer("/keyframe/timestamp")?.as_str()?).ok()?;
    Some((label.get("clip_id")?.as_str()?.to_owned(), keyframe, !returned))
}

fn of(kind: &'static str, pairs: &[Pair], seed: u64) -> QuestionAgreement {
    let count = |judge: bool, people: bool| pairs.iter().filter(|p| **p == (judge, people)).count();
    let same = |p: &[Pair]| {
        (!p.is_empty()).then(|| p.iter().filter(|(a, b)| a == b).count() as f64 / p.len() as f64)
    };
    QuestionAgreement {
        kind,
        answers: pairs.len(),
        same: bootstrap(pairs, seed, same),
        kappa: bootstrap(pairs, seed, cohen),
        counts: [count(false, false), count(false, true), count(true, false), count(true, true)],
    }
}
