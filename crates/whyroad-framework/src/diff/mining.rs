//! Changes of `mining:` blocks as written. They affect what is found, never the validity of a label: a rule that is
//! added or removed is **minor**, a changed one **patch**.

use super::{Change, ChangeKind, Moves};
use crate::Framework;
use crate::version::Step;
use whyroad_model::yaml::{Entry, Node, Value};
use whyroad_model::{Bilingual, ScenarioId};

/// All changes in tree order of B, removed rules last.
pub(super) fn changes(a: &Framework, b: &Framework, moves: &Moves) -> Vec<Change> {
    let mut out = Vec::new();
    let change = |id: &ScenarioId, step| Change::of(ChangeKind::Mining, id.clone(), step);
    for rule in &b.rules {
        let id = &rule.leaf;
        match a.rule(moves.before(id)) {
            None => out.push(change(id, Step::Minor).texts("mining", none(), present())),
            Some(old) => {
                let differences = blocks(&old.rule, &rule.rule)
                    .into_iter()
                    .filter(|(_, x, y)| x != y && moves.applied(x) != *y);
                out.extend(differences.map(|(f, x, y)| change(id, Step::Patch).texts(f, x, y)));
            }
        }
    }
    for id in a.rules.iter().map(|rule| moves.after(&rule.leaf)) {
        if b.taxonomy.contains(id) && b.rule(id).is_none() {
            out.push(change(id, Step::Minor).texts("mining", present(), none()));
        }
    }
    out
}

/// The differences, parameter by parameter and definition by definition, else key by key.
fn blocks(x: &Node, y: &Node) -> Vec<(&'static str, Bilingual, Bilingual)> {
    let mut out = Vec::new();
    for key in keys(x.entries(), y.entries()) {
        let (before, after) = (x.get(key), y.get(key));
        let field = match key {
            "parameters" => "mining.parameters",
            "define" => "mining.define",
            "target" => "mining.target",
            "when" => "mining.when",
            "require" => "mining.require",
            "response" => "mining.response",
            "min_duration" => "mining.min_duration",
            "max_duration" => "mining.max_duration",
            "merge_gap" => "mining.merge_gap",
            _ => "mining",
        };
        if same(before, after) {
            continue;
        }
        if matches!(field, "mining.parameters" | "mining.define") {
            let (old, new) = (before.map_or(&[][..], Node::entries), after.map_or(&[][..], Node::entries));
            for name in keys(old, new) {
                let (x, y) = (before.and_then(|n| n.get(name)), after.and_then(|n| n.get(name)));
                if !same(x, y) {
                    let text = |v: Option<&Node>| v.map_or_else(none, |v| named(name, v, x, y));
                    out.push((field, text(x), text(y)));
                }
            }
        } else {
            let text = |v: Option<&Node>| v.map_or_else(none, |v| Bilingual::same(plain(v)));
            out.push((field, text(before), text(after)));
        }
    }
    out
}

/// The same content, regardless of position.
fn same(x: Option<&Node>, y: Option<&Node>) -> bool {
    match (x, y) {
        (Some(x), Some(y)) => x.same_content(y),
        _ => x.is_none() && y.is_none(),
    }
}

/// Keys of both in the order of B, removed keys last.
fn keys<'n>(x: &'n [Entry], y: &'n [Entry]) -> Vec<&'n str> {
    let gone = x.iter().filter(|e| y.iter().all(|o| o.key != e.key));
    y.iter().chain(gone).map(|e| e.key.as_str()).collect()
}

/// `name: value`. The reason of a parameter is shown where only the reason changed.
fn named(name: &str, value: &Node, x: Option<&Node>, y: Option<&Node>) -> Bilingual {
    let part = |v: Option<&'_ Node>, key: &str| v.and_then(|v| v.get(key)).cloned();
    let (before, after) = (part(x, "value"), part(y, "value"));
    let only_reason = x.is_some() && y.is_some() && same(before.as_ref(), after.as_ref());
    let shown = match value.get("value") {
        Some(v) if only_reason => {
            format!("{} ({})", plain(v), value.get("reason").map(plain).unwrap_or_default())
        }
        Some(v) => plain(v),
        None => plain(value),
    };
    Bilingual::same(format!("{name}: {shown}"))
}

fn plain(node: &Node) -> String {
    match &node.value {
        Value::Null => "null".to_owned(),
        Value::Scalar(scalar) => scalar.text.trim().to_owned(),
        Value::List(items) => items.iter().map(plain).collect::<Vec<_>>().join("; "),
        Value::Map(entries) => {
            entries.iter().map(|e| format!("{}: {}", e.key, plain(&e.node))).collect::<Vec<_>>().join("\n")
        }
    }
}

fn present() -> Bilingual {
    Bilingual::new("有规则", "a rule")
}

fn none() -> Bilingual {
    Bilingual::new("无", "none")
}
