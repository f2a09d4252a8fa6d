//! The catalog as a page for readers: `docs/reference/signals.md`, written from `schema/signals.yaml` and checked
//! by a test. The text before the tables is in `src/catalog/preface.md`.

use super::{Catalog, SignalDef, SignalKind, SignalScope};
use std::fmt::Write as _;

fn values(def: &SignalDef) -> String {
    match &def.kind {
        SignalKind::Number(_) if def.unit_symbol().is_empty() => "number".into(),
        SignalKind::Number(_) => def.unit_symbol().into(),
        SignalKind::Flag => "flag".into(),
        SignalKind::Category(names) => names.join(", "),
    }
}

fn row(def: &SignalDef) -> String {
    let ids: Vec<&str> = def.needs.iter().map(|n| n.id()).collect();
    let needs = if ids.is_empty() { "-".to_owned() } else { ids.join(", ") };
    let aliases: String = def.aliases.iter().map(|a| format!("<br>`{a}`")).collect();
    format!(
        "| `{}`{aliases}<br>{}<br>{} | {} | {}<br>{} | {} | {} |\n",
        def.name,
        escape(&def.title.en),
        escape(&def.title.zh),
        values(def),
        escape(&def.meaning.en),
        escape(&def.meaning.zh),
        needs,
        escape(&def.source),
    )
}

/// A vertical bar would end the table cell.
fn escape(text: &str) -> String {
    text.replace('|', "\\|")
}

impl Catalog {
    /// The page in Markdown: the text about all signals, then one table per scope.
    pub fn page(&self) -> String {
        let mut out = format!("{}\n", include_str!("preface.md").trim_end());
        let sections = [
            (SignalScope::Frame, "Signals of the ego, the map, the light and the lead (one value per frame)"),
            (SignalScope::Target, "Signals of each target (one value per target and frame)"),
            (
                SignalScope::Object,
                "Signals of any object (one value per object and frame, the ego included; derived on demand)",
            ),
            (
                SignalScope::Pair,
                "Signals of pairs of objects within 50 m (one value per pair and frame; derived on demand)",
            ),
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
