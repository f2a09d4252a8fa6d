//! The tree of classes with counts by stage: mined, tasked, labeled, accepted, released. An episode counts once,
//! regardless of how many people label it.

use super::input::AnalyticsInputs;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::Framework;
use whyroad_label::facts::{LabelStage, TaskFacts};
use whyroad_model::ids::OTHER;
use whyroad_model::messages::{Coverage, CoverageState};
use whyroad_model::{Bilingual, ScenarioId};

/// Counts of a class; `None` where the input of a stage was not given, or the drives cannot show the class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StageCounts {
    /// Primary episodes.
    pub mined: Option<u64>,
    /// Episodes with a task, those left out included.
    pub tasked: Option<u64>,
    /// Episodes whose label was submitted.
    pub labelled: Option<u64>,
    /// Episodes with an accepted label.
    pub accepted: Option<u64>,
    /// Samples in releases, each once.
    pub released: Option<u64>,
}

impl StageCounts {
    /// The stages in order, each with its name in tables.
    pub fn all(&self) -> [(&'static str, Option<u64>); 5] {
        [
            ("mined", self.mined),
            ("tasked", self.tasked),
            ("labelled", self.labelled),
            ("accepted", self.accepted),
            ("released", self.released),
        ]
    }

    fn add(&mut self, other: &Self) {
        let sum = |a: &mut Option<u64>, b: Option<u64>| *a = b.map(|n| a.unwrap_or(0) + n).or(*a);
        sum(&mut self.mined, other.mined);
        sum(&mut self.tasked, other.tasked);
        sum(&mut self.labelled, other.labelled);
        sum(&mut self.accepted, other.accepted);
        sum(&mut self.released, other.released);
    }
}

/// One class.
#[derive(Clone, Debug, Serialize)]
pub struct StageRow {
    /// L1, L2 or leaf; `other` for moments that no class explains.
    pub scenario_id: ScenarioId,
    /// Its name.
    pub name: Bilingual,
    /// Mining state; `None` without mining. Of an L1 or L2: the best state of what belongs to it (found, searched, not
    /// observable, no rule).
    pub state: Option<CoverageState>,
    /// Counts; for an L1 or L2, everything below it and episodes known to be of the L2 without a variant.
    pub counts: StageCounts,
    /// Episodes known to be of this L2 without a known variant; part of `counts`.
    pub without_variant: StageCounts,
    /// Secondary episodes of the class and everything below it: found beside a primary one of another class. Not part
    /// of `counts.mined`, so that a moment counts once.
    pub secondary: Option<u64>,
    /// Tasks that were skipped or rejected.
    pub left_out: Option<u64>,
    /// Required accepted labels.
    pub wanted: Option<u64>,
    /// The class is in the taxonomy; others are of another version or of a custom rule.
    pub in_taxonomy: bool,
}

/// Counts of exactly these classes.
#[derive(Default)]
struct Tally {
    counts: BTreeMap<ScenarioId, StageCounts>,
    left_out: BTreeMap<ScenarioId, u64>,
    secondary: BTreeMap<ScenarioId, u64>,
}

impl Tally {
    /// Whether episodes of the class, or of one below it, were mined.
    fn has_episodes(&self, id: &ScenarioId) -> bool {
        let mined =
            self.counts.iter().filter(|(_, c)| c.mined.is_some_and(|n| n > 0)).map(|(class, _)| class);
        mined.chain(self.secondary.keys()).any(|class| class.is_within(id))
    }
}

/// Every class in tree order, then classes that the taxonomy does not have.
pub(super) fn rows(framework: &Framework, inputs: &AnalyticsInputs<'_>) -> Vec<StageRow> {
    let tally = tally(inputs);
    let states: BTreeMap<&ScenarioId, CoverageState> = inputs
        .mined
        .map(|m| m.coverage.leaves.iter().map(|l| (&l.scenario_id, l.state)).collect())
        .unwrap_or_default();
    let zero = StageCounts {
        mined: inputs.mined.map(|_| 0),
        tasked: inputs.tasks.map(|_| 0),
        labelled: inputs.tasks.map(|_| 0),
        accepted: inputs.tasks.map(|_| 0),
        released: inputs.releases.map(|_| 0),
    };
    let own = |id: &ScenarioId| {
        let mut counts = zero;
        if let Some(found) = tally.counts.get(id) {
            counts.add(found);
        }
        counts
    };
    let mut out = Vec::new();
    for id in framework.taxonomy.ids() {
        let mut counts = own(&id);
        let mut secondary = inputs.mined.map(|_| sum_below(&tally.secondary, &id).unwrap_or(0));
        let without_variant = if id.is_leaf() { StageCounts::default() } else { counts };
        let state = inputs.mined.map(|_| best_state(&id, &states, &tally));
        if id.is_leaf() && matches!(state, Some(CoverageState::NotObservable | CoverageState::NoRule)) {
            // Unobservable classes were not counted, unless something was found anyway.
            counts.mined = counts.mined.filter(|n| *n > 0);
            secondary = secondary.filter(|n| *n > 0);
        }
        if !id.is_leaf() {
            let below = tally.counts.iter().filter(|(other, _)| other.is_within(&id) && **other != id);
            below.for_each(|(_, c)| counts.add(c));
            // Where no leaf below is observable, nothing was searched: unknown, not zero.
            let searched = states.iter().any(|(leaf, s)| {
                leaf.is_within(&id) && matches!(s, CoverageState::Found | CoverageState::NotFound)
            });
            counts.mined = counts.mined.filter(|n| *n > 0 || searched);
            secondary = secondary.filter(|n| *n > 0 || searched);
        }
        let wanted = sum_below(inputs.wanted, &id);
        let left_out = sum_below(&tally.left_out, &id).unwrap_or(0);
        out.push(StageRow {
            name: name(framework, &id),
            state,
            counts,
            without_variant,
            secondary,
            left_out: inputs.tasks.map(|_| left_out),
            wanted,
            in_taxonomy: true,
            scenario_id: id,
        });
    }
    for (id, counts) in tally.counts.iter().filter(|(id, _)| !framework.taxonomy.contains(id)) {
        let state = inputs.mined.map(|m| state_outside(id, &m.coverage, &tally));
        let is_counted = !matches!(state, Some(CoverageState::NotObservable | CoverageState::NoRule));
        let of_class = own(id);
        out.push(StageRow {
            name: name(framework, id),
            state,
            counts: StageCounts { mined: of_class.mined.filter(|_| is_counted), ..of_class },
            without_variant: *counts,
            secondary: state.filter(|_| is_counted).map(|_| tally.secondary.get(id).copied().unwrap_or(0)),
            left_out: inputs.tasks.map(|_| tally.left_out.get(id).copied().unwrap_or(0)),
            wanted: inputs.wanted.get(id).copied(),
            in_taxonomy: false,
            scenario_id: id.clone(),
        });
    }
    out
}

/// The state of a leaf; of an L1 or L2, whose own episodes and leaves count, the best.
fn best_state(
    id: &ScenarioId,
    states: &BTreeMap<&ScenarioId, CoverageState>,
    tally: &Tally,
) -> CoverageState {
    if let (true, Some(state)) = (id.is_leaf(), states.get(id)) {
        return *state;
    }
    if !id.is_leaf() && tally.has_episodes(id) {
        return CoverageState::Found;
    }
    let below = states.iter().filter(|(leaf, _)| leaf.is_within(id)).map(|(_, state)| *state);
    below.min_by_key(|state| rank(*state)).unwrap_or(CoverageState::NoRule)
}

fn rank(state: CoverageState) -> u8 {
    match state {
        CoverageState::Found => 0,
        CoverageState::NotFound => 1,
        CoverageState::NotObservable => 2,
        CoverageState::NoRule => 3,
    }
}

/// The state of a class that the taxonomy does not have.
fn state_outside(id: &ScenarioId, coverage: &Coverage, tally: &Tally) -> CoverageState {
    let searched = coverage.leaves.iter().chain(&coverage.unresolved).find(|l| l.scenario_id == *id);
    match searched {
        _ if tally.has_episodes(id) => CoverageState::Found,
        Some(found) => found.state,
        None => CoverageState::NoRule,
    }
}

fn sum_below(of: &BTreeMap<ScenarioId, u64>, id: &ScenarioId) -> Option<u64> {
    let mut below = of.iter().filter(|(other, _)| other.is_within(id)).map(|(_, n)| *n).peekable();
    below.peek().is_some().then(|| below.sum())
}

/// Displayed name of a class in the tree.
fn name(framework: &Framework, id: &ScenarioId) -> Bilingual {
    let taxonomy = &framework.taxonomy;
    if let Some((_, _, l3)) = taxonomy.leaf(id) {
        return l3.name.clone();
    }
    if id.l1 == OTHER {
        return Bilingual::new("其他（没有类别能解释）", "Other (no class explains it)");
    }
    let known = match (&id.l2, &id.l3) {
        (None, _) => taxonomy.l1(&id.l1).map(|l| l.name.clone()),
        (Some(l2), None) => taxonomy.l2(&id.l1, l2).map(|(_, l)| l.name.clone()),
        _ => None,
    };
    known.unwrap_or_else(|| Bilingual::same(id.to_string()))
}

fn tally(inputs: &AnalyticsInputs<'_>) -> Tally {
    let mut out = Tally::default();
    for (id, drives) in inputs.mined.iter().flat_map(|m| &m.episodes.by_class) {
        let (all, primary) = drives.values().fold((0, 0), |sum, n| (sum.0 + n.0, sum.1 + n.1));
        out.counts.entry(id.clone()).or_default().mined = Some(primary);
        if all > primary {
            out.secondary.insert(id.clone(), all - primary);
        }
    }
    tasks(&mut out, inputs.tasks.unwrap_or_default());
    let mut samples: BTreeMap<&str, Option<&ScenarioId>> = BTreeMap::new();
    for sample in inputs.releases.iter().flat_map(|r| r.iter()).flat_map(|r| &r.samples) {
        samples.insert(&sample.sample, sample.judgement.scenario.as_ref());
    }
    for class in samples.into_values().flatten() {
        *out.counts.entry(class.clone()).or_default().released.get_or_insert(0) += 1;
    }
    out
}

fn tasks(out: &mut Tally, tasks: &[TaskFacts]) {
    // Episodes by stage and class: a set, since several people may label one.
    let mut seen: BTreeMap<LabelStage, BTreeSet<(&ScenarioId, &str)>> = BTreeMap::new();
    for t in tasks {
        let episode = t.episode.as_str();
        seen.entry(LabelStage::Waiting).or_default().insert((&t.scenario, episode));
        if t.stage == LabelStage::LeftOut {
            *out.left_out.entry(t.scenario.clone()).or_default() += 1;
            continue;
        }
        if t.stage == LabelStage::Waiting || t.superseded {
            continue;
        }
        // People may have given it another class.
        let class = t.label.as_ref().and_then(|l| l.scenario.as_ref()).unwrap_or(&t.scenario);
        seen.entry(LabelStage::Labelled).or_default().insert((class, episode));
        if t.stage == LabelStage::Accepted {
            seen.entry(LabelStage::Accepted).or_default().insert((class, episode));
        }
    }
    for (stage, episodes) in seen {
        for (class, _) in episodes {
            let counts = out.counts.entry(class.clone()).or_default();
            let n = match stage {
                LabelStage::Waiting => &mut counts.tasked,
                LabelStage::Labelled => &mut counts.labelled,
                LabelStage::Accepted => &mut counts.accepted,
                LabelStage::LeftOut => continue,
            };
            *n.get_or_insert(0) += 1;
        }
    }
}
