//! Rules that decide between overlapping classes, each rule once. In the taxonomy a rule is stated on both sides, and
//! siblings often share one; on the page it is in the section of the first of the classes, and the other sections refer
//! there.

use crate::Taxonomy;
use std::fmt::Write as _;
use whyroad_model::{Bilingual, ScenarioId};

/// One rule with all pairs that it decides.
struct Overlap<'t> {
    rule: &'t Bilingual,
    /// The earlier class of the tree first.
    pairs: Vec<(ScenarioId, ScenarioId)>,
}

/// All rules, and where each is printed.
pub(super) struct Overlaps<'t> {
    all: Vec<Overlap<'t>>,
}

impl<'t> Overlaps<'t> {
    pub(super) fn of(taxonomy: &'t Taxonomy) -> Self {
        let order = taxonomy.ids();
        let rank = |id: &ScenarioId| order.iter().position(|o| o == id);
        let mut all: Vec<Overlap<'t>> = Vec::new();
        for a in &taxonomy.l1 {
            for b in &a.l2 {
                let l2 = ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None };
                let leaves = b.l3.iter().map(|c| (ScenarioId::leaf(&a.id, &b.id, &c.id), &c.decides));
                for (id, decides) in std::iter::once((l2, &b.decides)).chain(leaves) {
                    for d in decides {
                        let mut pair = (id.clone(), d.against.clone());
                        if rank(&pair.1) < rank(&pair.0) {
                            pair = (pair.1, pair.0);
                        }
                        // Siblings that share a rule share the entry; the same words about other classes are another
                        // rule.
                        let known = all
                            .iter_mut()
                            .find(|o| *o.rule == d.rule && o.pairs.iter().any(|(x, _)| same_l2(x, &pair.0)));
                        match known {
                            Some(o) if o.pairs.contains(&pair) => {}
                            Some(o) => o.pairs.push(pair),
                            None => all.push(Overlap { rule: &d.rule, pairs: vec![pair] }),
                        }
                    }
                }
            }
        }
        Self { all }
    }

    /// The entries of one L2, and links to the sections of others that mention it.
    pub(super) fn section(&self, l2: &ScenarioId, out: &mut String) {
        let here: Vec<&Overlap<'_>> = self.all.iter().filter(|o| same_l2(&o.pairs[0].0, l2)).collect();
        let mut elsewhere: Vec<&str> = Vec::new();
        for (first, second) in self.all.iter().flat_map(|o| &o.pairs) {
            let home = first.l2.as_deref().unwrap_or_default();
            if same_l2(second, l2) && !same_l2(first, l2) && !elsewhere.contains(&home) {
                elsewhere.push(home);
            }
        }
        if here.is_empty() && elsewhere.is_empty() {
            return;
        }
        out.push_str("易混类别的判定 · What decides between overlapping classes:\n\n");
        for overlap in here {
            let pairs: Vec<String> = overlap
                .pairs
                .iter()
                .map(|(x, y)| format!("`{}` / `{}`", short(x, l2), short(y, l2)))
                .collect();
            let Bilingual { zh, en } = overlap.rule;
            let _ = writeln!(out, "- {}: {zh}<br>{en}", pairs.join(", "));
        }
        if !elsewhere.is_empty() {
            let links: Vec<String> =
                elsewhere.iter().map(|id| format!("[`{id}`](#{})", anchor(id))).collect();
            let _ = writeln!(out, "- 另见 · See also: {}", links.join(", "));
        }
        out.push('\n');
    }
}

/// The anchor of an L2's section. L2 ids are unique.
pub(super) fn anchor(l2: &str) -> String {
    format!("l2-{l2}")
}

fn same_l2(x: &ScenarioId, y: &ScenarioId) -> bool {
    (&x.l1, &x.l2) == (&y.l1, &y.l2)
}

/// Classes of the section's own L2 by their last part.
fn short(id: &ScenarioId, l2: &ScenarioId) -> String {
    match (&id.l3, same_l2(id, l2)) {
        (Some(l3), true) => l3.clone(),
        (None, true) => id.l2.clone().unwrap_or_default(),
        _ => id.to_string(),
    }
}
