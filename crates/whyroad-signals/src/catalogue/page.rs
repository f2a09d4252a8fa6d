//! The catalogue as a page for readers: `docs/reference/signals.md`, written from `schema/signals.yaml` and held to it by a
//! test. The words before the tables are in `src/catalogue/preface.md`.

use super::{Catalogue, Scope, SignalDef, SignalKind};
use std::fmt::Write as _;

fn values(def: &SignalDef) -> String {
    match &def.kind {
        SignalKind::Number(_) if def.unit.is_empty() => "number".into(),
        SignalKind::Number(_) => def.unit.clone(),
        SignalKind::Flag => "flag".into(),
        SignalKind::Category(names) => names.join(", "),
    }
}

fn row(def: &SignalDef) -> String {
    let needs = if def.needs.is_empty() { "-".to_owned() } else { def.needs.join(", ") };
    let aliases: String = def.aliases.iter().map(|a| format!("<br>`{a}`")).collect();
    format!(
        "| `{}`{aliases} | {} | {}<br>{} | {} | {} |\n",
        def.name,
        values(def),
        escape(&def.meaning.en),
        escape(&def.meaning.zh),
        needs,
        escape(&def.source),
    )
}

/// A vertical bar would end the cell.
fn escape(text: &str) -> String {
    text.replace('|', "\\|")
}

impl Catalogue {
    /// The page in Markdown: what holds for all signals, then one table a scope.
    pub fn page(&self) -> String {
        let mut out = format!("{}\n", include_str!("preface.md").trim_end());
        let sections = [
            (Scope::Frame, "Signals of the ego, the map, the light and the lead (one value a frame)"),
            (Scope::Target, "Signals of each target (one value a target and frame)"),
        ];
        for (scope, title) in sections {
            let defs: Vec<&SignalDef> = self.iter().filter(|d| d.scope == scope).collect();
            let _ = write!(out, "\n## {title}\n\n{} signals.\n\n", defs.len());
            out.push_str("| name | values | meaning | needs | source |\n|---|---|---|---|---|\n");
            out.extend(defs.into_iter().map(row));
        }
        out
    }
}
