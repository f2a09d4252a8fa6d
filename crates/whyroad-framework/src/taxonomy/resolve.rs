//! From user input to a class: a full id, a prefix of one, or a short id that only one class has.

use super::Taxonomy;
use whyroad_model::ScenarioId;
use whyroad_model::suggest::similarity;

/// The class that a text names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// Exactly one class.
    Found(ScenarioId),
    /// Several classes share this short id; in tree order.
    Ambiguous(Vec<ScenarioId>),
    /// No class; the nearest ids, best first, for "did you mean".
    Unknown(Vec<ScenarioId>),
}

impl Taxonomy {
    /// The class that `text` names: `l1`, `l1.l2`, `l1.l2.l3`, or the end of such an id (`urgent`,
    /// `cutin`, `cutin.urgent`) where only one class has this ending.
    pub fn resolve(&self, text: &str) -> Resolution {
        let ids = self.ids();
        if let Some(id) = ids.iter().find(|id| id.to_string() == text) {
            return Resolution::Found(id.clone());
        }
        let suffix = format!(".{text}");
        let mut hits: Vec<ScenarioId> =
            ids.iter().filter(|id| id.to_string().ends_with(&suffix)).cloned().collect();
        match hits.len() {
            0 => Resolution::Unknown(self.nearest(text)),
            1 => Resolution::Found(hits.remove(0)),
            _ => Resolution::Ambiguous(hits),
        }
    }

    /// At most three classes whose full or short id looks like `text`, best first.
    pub fn nearest(&self, text: &str) -> Vec<ScenarioId> {
        let mut scored: Vec<(f64, ScenarioId)> = self
            .ids()
            .into_iter()
            .map(|id| {
                let full = id.to_string();
                // Every tail of the id counts, so that `urgnt`, `cutin.urgnt` and the full id are all found.
                let tails = full.match_indices('.').map(|(i, _)| &full[i + 1..]);
                let best = tails.map(|t| similarity(text, t)).fold(similarity(text, &full), f64::max);
                (best, id)
            })
            .filter(|(score, _)| *score > 0.6)
            .collect();
        // Stable sort: equal ones stay in tree order.
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Much worse candidates would only distract.
        let floor = scored.first().map_or(0.0, |(s, _)| s - 0.15);
        scored.into_iter().take_while(|(s, _)| *s >= floor).take(3).map(|(_, id)| id).collect()
    }
}
