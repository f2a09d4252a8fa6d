//! Changes of `mining:` blocks as written. They decide what is found, never whether a label is right: a rule that comes
//! or goes is **minor**, one that changed **patch**.

use super::{Change, ChangeKind};
use crate::Framework;
use crate::version::Step;
use serde_yaml_ng::{Mapping, Value};
use whyroad_model::{Bilingual, ScenarioId};

/// All changes in tree order of B, rules that are gone last.
pub(super) fn changes(a: &Framework, b: &Framework) -> Vec<Change> {
    let mut out = Vec::new();
    let change = |id: &ScenarioId, step| Change::of(ChangeKind::Mining, id.clone(), step);
    for rule in &b.rules {
        let id = &rule.leaf;
        match a.rule(id) {
            None => out.push(change(id, Step::Minor).texts("mining", none(), present())),
            Some(old) => {
                let differences = blocks(&old.rule, &rule.rule);
                out.extend(differences.into_iter().map(|(f, x, y)| change(id, Step::Patch).texts(f, x, y)));
            }
        }
    }
    for rule in a.rules.iter().filter(|r| b.taxonomy.contains(&r.leaf) && b.rule(&r.leaf).is_none()) {
        out.push(change(&rule.leaf, Step::Minor).texts("mining", present(), none()));
    }
    out
}

/// What differs, parameter by parameter and definition by definition, else key by key.
fn blocks(x: &Value, y: &Value) -> Vec<(&'static str, Bilingual, Bilingual)> {
    let empty = Mapping::new();
    let (x, y) = (x.as_mapping().unwrap_or(&empty), y.as_mapping().unwrap_or(&empty));
    let mut out = Vec::new();
    for key in keys(x, y) {
        let (before, after) = (x.get(&key), y.get(&key));
        let field = match key.as_str() {
            Some("parameters") => "mining.parameters",
            Some("define") => "mining.define",
            Some("target") => "mining.target",
            Some("when") => "mining.when",
            Some("require") => "mining.require",
            Some("min_duration") => "mining.min_duration",
            Some("max_duration") => "mining.max_duration",
            Some("merge_gap") => "mining.merge_gap",
            _ => "mining",
        };
        if before == after {
            continue;
        }
        if matches!(field, "mining.parameters" | "mining.define") {
            let (before, after) = (before.and_then(Value::as_mapping), after.and_then(Value::as_mapping));
            let (before, after) = (before.unwrap_or(&empty), after.unwrap_or(&empty));
            for name in keys(before, after) {
                let (x, y) = (before.get(&name), after.get(&name));
                if x != y {
                    let text = |v: Option<&Value>| v.map_or_else(none, |v| named(&name, v, x, y));
                    out.push((field, text(x), text(y)));
                }
            }
        } else {
            let text = |v: Option<&Value>| v.map_or_else(none, |v| Bilingual::same(plain(v)));
            out.push((field, text(before), text(after)));
        }
    }
    out
}

/// Keys of both in the order of B, those that B has no more last.
fn keys(x: &Mapping, y: &Mapping) -> Vec<Value> {
    let gone = x.keys().filter(|k| !y.contains_key(*k));
    y.keys().chain(gone).cloned().collect()
}

/// `name: value`. The reason of a parameter is shown where it is all that changed.
fn named(name: &Value, value: &Value, x: Option<&Value>, y: Option<&Value>) -> Bilingual {
    let part = |v: Option<&Value>, key: &str| v.and_then(|v| v.get(key)).cloned();
    let only_reason = x.is_some() && y.is_some() && part(x, "value") == part(y, "value");
    let shown = match value.get("value") {
        Some(v) if only_reason => {
            format!("{} ({})", plain(v), value.get("reason").map(plain).unwrap_or_default())
        }
        Some(v) => plain(v),
        None => plain(value),
    };
    Bilingual::same(format!("{}: {shown}", plain(name)))
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.trim().to_owned(),
        Value::Sequence(items) => items.iter().map(plain).collect::<Vec<_>>().join("; "),
        other => serde_yaml_ng::to_string(other).unwrap_or_default().trim().to_owned(),
    }
}

fn present() -> Bilingual {
    Bilingual::new("有规则", "a rule")
}

fn none() -> Bilingual {
    Bilingual::new("无", "none")
}
