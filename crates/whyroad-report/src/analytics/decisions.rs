//! Decisions by leaf: of accepted labels, else of submitted labels, else of the samples of releases.

use super::input::AnalyticsInputs;
use serde::Serialize;
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_label::facts::{Judgement, LabelStage};
use whyroad_model::decision::LateralDirection;
use whyroad_model::{Bilingual, ScenarioId};

/// Source of the decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DecisionBasis {
    /// Accepted labels.
    Accepted,
    /// Submitted labels: none is accepted yet.
    Labelled,
    /// Samples of releases: no tasks were given.
    Released,
    /// There are none.
    Nothing,
}

/// Channel of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Along the path.
    Longitudinal,
    /// Across the path.
    Lateral,
}

impl Channel {
    /// Its id.
    pub fn id(self) -> &'static str {
        match self {
            Channel::Longitudinal => "longitudinal",
            Channel::Lateral => "lateral",
        }
    }
}

/// How often a decision was taken in a class.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DecisionRow {
    /// Class of the labels.
    pub scenario_id: ScenarioId,
    /// Channel.
    pub channel: Channel,
    /// The decision, with its side; `null` for "no change of decision".
    pub decision: Option<String>,
    /// Its name.
    pub name: Bilingual,
    /// Labels.
    pub count: u64,
}

/// All of them.
#[derive(Clone, Debug, Serialize)]
pub struct Decisions {
    /// Which labels.
    pub basis: DecisionBasis,
    /// By class, channel, and number, the most frequent first.
    pub rows: Vec<DecisionRow>,
}

pub(super) fn of(framework: &Framework, inputs: &AnalyticsInputs<'_>) -> Decisions {
    let tasks = inputs.tasks.unwrap_or_default();
    let labels = |accepted_only: bool| -> Vec<&Judgement> {
        let wanted = tasks.iter().filter(|t| {
            !t.superseded
                && (t.stage == LabelStage::Accepted || (!accepted_only && t.stage == LabelStage::Labelled))
        });
        wanted.filter_map(|t| t.label.as_ref()).collect()
    };
    let (accepted, labelled) = (labels(true), labels(false));
    let mut seen = std::collections::BTreeSet::new();
    let samples = inputs.releases.unwrap_or_default().iter().flat_map(|r| &r.samples);
    let samples: Vec<&Judgement> =
        samples.filter(|s| seen.insert(s.sample.as_str())).map(|s| &s.judgement).collect();
    let (basis, judgements) = if !accepted.is_empty() {
        (DecisionBasis::Accepted, accepted)
    } else if !labelled.is_empty() {
        (DecisionBasis::Labelled, labelled)
    } else if !samples.is_empty() {
        (DecisionBasis::Released, samples)
    } else {
        (DecisionBasis::Nothing, vec![])
    };
    Decisions { basis, rows: rows(framework, &judgements) }
}

fn rows(framework: &Framework, judgements: &[&Judgement]) -> Vec<DecisionRow> {
    let mut counts: BTreeMap<(&ScenarioId, Channel, Option<String>), (u64, Bilingual)> = BTreeMap::new();
    for j in judgements {
        let Some(class) = &j.scenario else { continue };
        let along = counts.entry((class, Channel::Longitudinal, longitudinal(j)));
        along.or_insert_with(|| (0, longitudinal_name(framework, j))).0 += 1;
        let across = counts.entry((class, Channel::Lateral, lateral(j)));
        across.or_insert_with(|| (0, lateral_name(framework, j))).0 += 1;
    }
    let mut out: Vec<DecisionRow> = counts
        .into_iter()
        .map(|((class, channel, decision), (count, name))| DecisionRow {
            scenario_id: class.clone(),
            channel,
            decision,
            name,
            count,
        })
        .collect();
    out.sort_by(|a, b| {
        let key = |r: &DecisionRow| (r.scenario_id.clone(), r.channel, std::cmp::Reverse(r.count));
        key(a).cmp(&key(b)).then_with(|| a.decision.cmp(&b.decision))
    });
    out
}

/// The longitudinal decision as one word.
pub(super) fn longitudinal(of: &Judgement) -> Option<String> {
    of.longitudinal.map(|d| d.id().to_owned())
}

/// The lateral decision with its side, as one word.
pub(super) fn lateral(of: &Judgement) -> Option<String> {
    let decision = of.lateral?.id();
    Some(match of.lateral_direction {
        Some(side) => format!("{decision} {side}"),
        None => decision.to_owned(),
    })
}

fn longitudinal_name(framework: &Framework, of: &Judgement) -> Bilingual {
    let sets = &framework.decisions;
    let Some(id) = of.longitudinal else { return sets.null_decision.name.clone() };
    sets.longitudinal(id).map_or_else(|| Bilingual::same(id.id()), |t| t.name.clone())
}

fn lateral_name(framework: &Framework, of: &Judgement) -> Bilingual {
    let sets = &framework.decisions;
    let Some(id) = of.lateral else { return sets.null_decision.name.clone() };
    let name = sets.lateral(id).map_or_else(|| Bilingual::same(id.id()), |t| t.name.clone());
    let (zh, en) = match of.lateral_direction {
        Some(LateralDirection::Left) => ("（左）", " (left)"),
        Some(LateralDirection::Right) => ("（右）", " (right)"),
        Some(LateralDirection::Uturn) => ("（掉头）", " (U-turn)"),
        None => return name,
    };
    Bilingual::new(name.zh + zh, name.en + en)
}
