//! Reading `schema/signals.yaml` entry by entry, each checked against the signal of that name that is compiled in.

use super::{Catalog, SignalDef, SignalKind};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::catalog::{SignalScope, SignalType};
use whyroad_model::signal::short_meaning;
use whyroad_model::suggest::suggestion_or_known;
use whyroad_model::units::{UNITS, Unit};
use whyroad_model::yaml::{Fields, FileReport, FormCodes, Mark, Node};
use whyroad_model::{Bilingual, Diagnostic, Need, SignalId};

/// Codes of the diagnostics that this crate emits; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "signals.syntax",
    "signals.name",
    "signals.type",
    "signals.needs",
    "signals.unknown",
    "signals.changed",
    "signals.missing",
    "signals.field.missing",
    "signals.field.unknown",
    "signals.field.type",
    "signals.field.duplicate",
    "signals.text.empty",
];

static FORM: FormCodes = FormCodes {
    syntax: "signals.syntax",
    missing: "signals.field.missing",
    unknown: "signals.field.unknown",
    kind: "signals.field.type",
    duplicate: "signals.field.duplicate",
    empty: "signals.text.empty",
};

/// The catalog's file, relative to the framework's folder.
const FILE: &str = "schema/signals.yaml";

/// The usable entries, and the errors of the others.
pub(super) fn read(text: &str) -> (Catalog, Vec<Diagnostic>) {
    let mut report = FileReport::new(FILE, text, &FORM);
    let catalog = report.parse(text).and_then(|root| document(&root, &mut report)).unwrap_or_default();
    (catalog, report.diagnostics)
}

fn document(root: &Node, report: &mut FileReport<'_>) -> Option<Catalog> {
    let mut fields = Fields::open(root, report)?;
    let version = fields.text("version", report).unwrap_or_default();
    let values = fields.get("values").map_or_else(BTreeMap::new, |n| value_names(n, report));
    let signals = fields.need("signals", report);
    fields.close(report);
    let mut catalog = Catalog { version, values, ..Catalog::default() };
    let signals = signals?;
    // An entry with another error is not missing.
    let mut listed: BTreeSet<SignalId> = BTreeSet::new();
    for node in report.items(signals) {
        listed.extend(node.get("name").and_then(Node::text).and_then(|n| SignalId::from_name(n.trim())));
        if let Some((def, mark)) = entry(node, report) {
            catalog.add(def, mark, node, report);
        }
    }
    for id in SignalId::ALL.iter().filter(|id| !listed.contains(id)) {
        let message = Bilingual::new(
            format!("信号目录缺少 '{id}'"),
            format!("the catalog has no entry for the signal '{id}'"),
        );
        let at = Mark { span: 1, ..signals.mark };
        report.push(Diagnostic::error("signals.missing", message), at, &signals.pointer);
    }
    Some(catalog)
}

/// The content of an entry before it is checked against the compiled-in signal.
struct Written<'n> {
    name: String,
    name_node: &'n Node,
    scope: (SignalScope, &'n Node),
    kind: (String, &'n Node),
    unit: Option<(String, &'n Node)>,
    scale: Option<(f64, &'n Node)>,
    least: Option<f64>,
    values: (Vec<String>, Option<&'n Node>),
    needs: (Vec<Need>, &'n Node),
    title: Option<Bilingual>,
    meaning: Bilingual,
    source: String,
    aliases: Vec<String>,
}

fn entry(node: &Node, report: &mut FileReport<'_>) -> Option<(SignalDef, Mark)> {
    let before = report.diagnostics.len();
    let written = written(node, report)?;
    if report.diagnostics.len() > before {
        return None;
    }
    let mark = written.name_node.mark;
    resolve(written, report).map(|def| (def, mark))
}

fn written<'n>(node: &'n Node, report: &mut FileReport<'_>) -> Option<Written<'n>> {
    let mut f = Fields::open(node, report)?;
    let name_node = f.need("name", report);
    let name = name_node.and_then(|n| report.text(n));
    let scope_node = f.need("scope", report);
    let scope = scope_node.and_then(|n| scope(n, report));
    let kind_node = f.need("type", report);
    let kind = kind_node.and_then(|n| report.text(n));
    // The unit of a pure number is the empty text.
    let unit = f.get("unit").and_then(|n| Some((n.text()?.to_owned(), n)));
    let scale = f.get("scale").and_then(|n| Some((scale(n, report)?, n)));
    let least = f.get("least").and_then(|n| least(n, report));
    let values_node = f.get("values");
    let values = values_node.map_or_else(Vec::new, |n| texts(n, report));
    let needs_node = f.need("needs", report);
    let needs = needs_node.map(|n| needs(n, report));
    let title = f.get("title").and_then(|n| bilingual(n, report));
    let meaning = f.need("meaning", report).and_then(|n| bilingual(n, report));
    let source = f.text("source", report);
    let aliases = f.get("aliases").map_or_else(Vec::new, |n| texts(n, report));
    f.close(report);
    Some(Written {
        name: name?,
        name_node: name_node?,
        scope: (scope?, scope_node?),
        kind: (kind?, kind_node?),
        unit,
        scale,
        least,
        values: (values, values_node),
        needs: (needs?, needs_node?),
        title,
        meaning: meaning?,
        source: source?,
        aliases,
    })
}

fn texts(node: &Node, report: &mut FileReport<'_>) -> Vec<String> {
    report.items(node).iter().filter_map(|n| report.text(n)).collect()
}

fn scope(node: &Node, report: &mut FileReport<'_>) -> Option<SignalScope> {
    match report.text(node)?.as_str() {
        "frame" => Some(SignalScope::Frame),
        "target" => Some(SignalScope::Target),
        "object" => Some(SignalScope::Object),
        "pair" => Some(SignalScope::Pair),
        other => {
            let message = Bilingual::new(
                format!("未知的作用域 '{other}'（应为 frame、target、object 或 pair）"),
                format!("unknown scope '{other}' (expected frame, target, object or pair)"),
            );
            report.push(Diagnostic::error("signals.type", message), node.mark, &node.pointer);
            None
        }
    }
}

fn scale(node: &Node, report: &mut FileReport<'_>) -> Option<f64> {
    let text = report.text(node)?;
    let value = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s > 0.0);
    if value.is_none() {
        let (zh, en) =
            (format!("scale '{text}' 不是正数"), format!("the scale '{text}' is not a positive number"));
        report.error("signals.type", node, zh, en);
    }
    value
}

/// `least`: a number in the unit of the signal.
fn least(node: &Node, report: &mut FileReport<'_>) -> Option<f64> {
    let text = report.text(node)?;
    let value = text.parse::<f64>().ok().filter(|v| v.is_finite());
    if value.is_none() {
        let (zh, en) =
            (format!("least '{text}' 不是数"), format!("the least value '{text}' is not a number"));
        report.error("signals.type", node, zh, en);
    }
    value
}

/// `values`: display names of the values of categories.
fn value_names(node: &Node, report: &mut FileReport<'_>) -> BTreeMap<String, Bilingual> {
    let entries = report.entries(node).unwrap_or_default();
    entries.into_iter().filter_map(|e| Some((e.key.clone(), bilingual(&e.node, report)?))).collect()
}

fn bilingual(node: &Node, report: &mut FileReport<'_>) -> Option<Bilingual> {
    let mut f = Fields::open(node, report)?;
    let (zh, en) = (f.text("zh", report), f.text("en", report));
    f.close(report);
    Some(Bilingual::new(zh?, en?))
}

fn needs(node: &Node, report: &mut FileReport<'_>) -> Vec<Need> {
    let mut found = Vec::new();
    for item in report.items(node) {
        let Some(text) = report.text(item) else { continue };
        match Need::from_id(&text) {
            Some(need) => found.push(need),
            None => {
                let message =
                    Bilingual::new(format!("未知的需求 '{text}'"), format!("unknown need '{text}'"));
                let hint = suggestion_or_known(&text, Need::ALL.iter().map(|n| n.id()));
                let d = Diagnostic::error("signals.needs", message).with_hint(hint);
                report.push(d, item.mark, &item.pointer);
            }
        }
    }
    found
}

fn resolve(w: Written<'_>, report: &mut FileReport<'_>) -> Option<SignalDef> {
    let Some(id) = SignalId::from_name(&w.name) else {
        let name = &w.name;
        let message =
            Bilingual::new(format!("没有名为 '{name}' 的信号"), format!("signal '{name}' not found"));
        let hint = suggestion_or_known(name, SignalId::ALL.iter().map(|id| id.name()));
        let d = Diagnostic::error("signals.unknown", message);
        let d = if hint.en.starts_with("did you mean") { d.with_hint(hint) } else { d };
        report.push(d, w.name_node.mark, &w.name_node.pointer);
        return None;
    };
    let (kind, unit) = kind(&w, id, report)?;
    if w.scope.0 != id.scope() {
        changed(report, w.scope.1, id, "scope", id.scope().word());
        return None;
    }
    let stated: BTreeSet<Need> = w.needs.0.iter().copied().collect();
    if stated != id.needs().iter().copied().collect() {
        let fixed: Vec<&str> = id.needs().iter().map(|n| n.id()).collect();
        changed(report, w.needs.1, id, "needs", &format!("[{}]", fixed.join(", ")));
        return None;
    }
    let to_base = unit.map_or(1.0, |u| u.to_base);
    Some(SignalDef {
        id,
        name: w.name,
        scope: w.scope.0,
        kind,
        unit,
        title: w.title.unwrap_or_else(|| beginning(&w.meaning)),
        meaning: w.meaning,
        needs: w.needs.0,
        source: w.source,
        scale: w.scale.map_or(1.0, |(s, _)| s * to_base),
        least: w.least.map(|v| v * to_base),
        aliases: w.aliases,
    })
}

/// A title for a signal without one: the first words of its meaning.
fn beginning(meaning: &Bilingual) -> Bilingual {
    let short = |text: &str| short_meaning(text, |_| None);
    Bilingual::new(short(&meaning.zh), short(&meaning.en))
}

/// The type of the entry, if it is the compiled-in type, with the unit of a number.
fn kind(
    w: &Written<'_>,
    id: SignalId,
    report: &mut FileReport<'_>,
) -> Option<(SignalKind, Option<&'static Unit>)> {
    match (w.kind.0.as_str(), id.kind()) {
        ("number", SignalType::Number(fixed)) => {
            let unit = number_unit(w, report)?;
            let wanted = Unit::parse(fixed)?;
            if unit.dimension != wanted.dimension {
                let node = w.unit.as_ref().map_or(w.kind.1, |(_, n)| n);
                changed(report, node, id, "unit", fixed);
                return None;
            }
            Some((SignalKind::Number(unit.dimension), Some(unit)))
        }
        ("flag", SignalType::Flag) => Some((SignalKind::Flag, None)),
        ("category", SignalType::Category(fixed)) => {
            let (values, node) = &w.values;
            if values != fixed {
                changed(report, node.unwrap_or(w.kind.1), id, "values", &format!("[{}]", fixed.join(", ")));
                return None;
            }
            Some((SignalKind::Category(values.clone().into()), None))
        }
        ("number" | "flag" | "category", fixed) => {
            let word = match fixed {
                SignalType::Number(_) => "number",
                SignalType::Flag => "flag",
                SignalType::Category(_) => "category",
            };
            changed(report, w.kind.1, id, "type", word);
            None
        }
        (other, _) => {
            report.error(
                "signals.type",
                w.kind.1,
                format!("未知的类型 '{other}'（应为 number、flag 或 category）"),
                format!("unknown type '{other}' (expected number, flag or category)"),
            );
            None
        }
    }
}

fn number_unit(w: &Written<'_>, report: &mut FileReport<'_>) -> Option<&'static Unit> {
    let symbol = w.unit.as_ref().map_or("", |(s, _)| s.as_str());
    let node = w.unit.as_ref().map_or(w.kind.1, |(_, n)| n);
    let Some(unit) = Unit::parse(symbol).filter(|_| w.unit.is_some()) else {
        let message = Bilingual::new(
            format!("信号 '{}'：未知或缺失的单位 '{symbol}'", w.name),
            format!("signal '{}': unknown or missing unit '{symbol}'", w.name),
        );
        let known = UNITS.iter().map(|u| u.symbol).filter(|s| !s.is_empty());
        let d = Diagnostic::error("signals.type", message).with_hint(suggestion_or_known(symbol, known));
        report.push(d, node.mark, &node.pointer);
        return None;
    };
    if w.scale.is_none() {
        report.error(
            "signals.type",
            w.kind.1,
            format!("信号 '{}'：数值信号须有正的 scale", w.name),
            format!("signal '{}': a number needs a positive scale", w.name),
        );
        return None;
    }
    Some(unit)
}

/// A framework folder may not change this field, because the code that derives the signal would not follow.
fn changed(report: &mut FileReport<'_>, node: &Node, id: SignalId, field: &str, fixed: &str) {
    let message = Bilingual::new(
        format!("信号 '{id}' 的 {field} 由程序决定，不能更改"),
        format!("the {field} of signal '{id}' is part of the program and cannot be changed"),
    );
    let hint = Bilingual::new(format!("应为 {field}: {fixed}"), format!("expected {field}: {fixed}"));
    report.push(Diagnostic::error("signals.changed", message).with_hint(hint), node.mark, &node.pointer);
}

impl Catalog {
    /// Adds `def`, whose name is at `mark`, unless one of its names is taken.
    fn add(&mut self, def: SignalDef, mark: Mark, node: &Node, report: &mut FileReport<'_>) {
        let names: Vec<String> = std::iter::once(&def.name).chain(&def.aliases).cloned().collect();
        let taken = |n: &&String| {
            self.by_name.contains_key(*n) || (**n != def.name && SignalId::from_name(n).is_some())
        };
        if let Some(taken) = names.iter().find(taken) {
            let message = Bilingual::new(
                format!("信号名 '{taken}' 重复"),
                format!("signal name '{taken}' is used more than once"),
            );
            report.push(Diagnostic::error("signals.name", message), mark, &node.pointer);
            return;
        }
        for name in names {
            self.by_name.insert(name, self.defs.len());
        }
        self.defs.push(def);
    }
}
