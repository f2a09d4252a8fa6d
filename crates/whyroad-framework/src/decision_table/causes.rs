//! Possible causes of decisions (`causes` of `scenarios/decisions.yaml`): kinds of things by decision, and the states
//! that the text must state for them. The classes add their own triggers.

use crate::label_words::{GroupSet, LabelWords, SaidState};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, Longitudinal};

/// The identifier for "every cause fits".
const ANYTHING: &str = "anything";
/// The row of words for where something is, not what it is.
const BACKGROUND: &str = "background";

/// Possible causes of one decision.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CauseKinds {
    /// In any state.
    pub kinds: GroupSet,
    /// Only where the state is stated.
    pub in_state: Vec<(GroupSet, SaidState)>,
    /// Anything can.
    pub anything: bool,
}

/// The rows of all decisions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Causes {
    /// Groups that are not a cause without another thing, unless the row has them.
    pub background: GroupSet,
    by_decision: BTreeMap<&'static str, CauseKinds>,
    written: BTreeMap<String, Vec<String>>,
}

impl Causes {
    /// Possible causes of a decision of either channel, by its id; `None` where the table has no row.
    pub fn of(&self, decision: &str) -> Option<&CauseKinds> {
        self.by_decision.get(decision)
    }

    /// The kinds of each row as written.
    pub fn written(&self) -> &BTreeMap<String, Vec<String>> {
        &self.written
    }

    /// The table as written, and its errors.
    pub(super) fn read(raw: &BTreeMap<String, Vec<String>>, words: &LabelWords) -> (Self, Vec<Bilingual>) {
        let mut out = Self { written: raw.clone(), ..Self::default() };
        let mut problems = Vec::new();
        let decisions: Vec<&str> =
            Longitudinal::ALL.iter().map(|d| d.id()).chain(Lateral::ALL.iter().map(|d| d.id())).collect();
        for (row, names) in raw {
            let kinds = kinds(row, names, words, &mut problems);
            if row == BACKGROUND {
                out.background = kinds.kinds;
            } else if let Some(decision) = decisions.iter().find(|id| *id == row) {
                out.by_decision.insert(decision, kinds);
            } else {
                problems.push(Bilingual::new(
                    format!("causes 中的 '{row}' 不是决策"),
                    format!("'{row}' in causes is not a decision"),
                ));
            }
        }
        problems.extend(decisions.iter().filter(|id| !raw.contains_key(**id)).map(|id| {
            Bilingual::new(
                format!("causes 中没有决策 '{id}'"),
                format!("causes has no row for the decision '{id}'"),
            )
        }));
        (out, problems)
    }
}

fn kinds(row: &str, names: &[String], words: &LabelWords, problems: &mut Vec<Bilingual>) -> CauseKinds {
    let mut out = CauseKinds::default();
    for name in names {
        if name == ANYTHING {
            out.anything = true;
            continue;
        }
        let (kind, state) = name.split_once('@').map_or((name.as_str(), None), |(k, s)| (k, Some(s)));
        match (words.kinds.get(kind), state.map(SaidState::from_id)) {
            (Some(set), None) => out.kinds = out.kinds.with(*set),
            (Some(set), Some(Some(state))) => out.in_state.push((*set, state)),
            // Without words nothing can be compared; their absence has already been reported.
            (None, _) if words.is_empty() => {}
            (None, _) => problems.push(Bilingual::new(
                format!("causes.{row}：schema/label_words.yaml 中没有 '{kind}'"),
                format!("causes.{row}: schema/label_words.yaml has no '{kind}'"),
            )),
            (_, Some(None)) => problems.push(Bilingual::new(
                format!("causes.{row}：'{name}' 中的状态未知"),
                format!("causes.{row}: '{name}' has an unknown state"),
            )),
        }
    }
    out
}
