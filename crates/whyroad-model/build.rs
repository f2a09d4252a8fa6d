//! Generates Rust types from the data files of `schema/`, so that a name that the code relies on is checked by the
//! compiler: `SignalId`, typed ids and the enums of category signals from `signals.yaml`, `Need` from `needs.yaml`.
//! Fails the build if a file is not as it must be; whyroad-signals reports such faults of other files with their
//! location.
#![allow(clippy::unwrap_used)] // writing to a `String` cannot fail

#[allow(dead_code, unreachable_pub)]
#[path = "src/yaml/tree.rs"]
mod tree;

#[allow(dead_code)]
#[path = "build/label_model.rs"]
mod label_model;
#[allow(dead_code)]
#[path = "build/label_table.rs"]
mod label_table;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use tree::Node;

fn main() {
    let out = std::env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let needs = read("needs.yaml");
    let needs = needs.get("needs").expect("needs.yaml has 'needs'").items();
    write(&out, "needs.rs", &needs_code(needs));
    let signals = read("signals.yaml");
    let signals = signals.get("signals").expect("signals.yaml has 'signals'").items();
    write(&out, "signals.rs", &signals_code(signals));
    let objects = label_table::read(Path::new("../../schema/label_fields.yaml"));
    write(&out, "label_types.rs", &label_model::types(&objects));
    write(&out, "label_fields.rs", &label_model::table(&objects));
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-changed=src/yaml/tree.rs");
}

fn read(name: &str) -> Node {
    let path = Path::new("../../schema").join(name);
    println!("cargo:rerun-if-changed={}", path.display());
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    tree::parse(&text).unwrap_or_else(|e| panic!("{}:{}: {:?}", path.display(), e.mark.line, e.cause))
}

fn write(out: &str, name: &str, code: &str) {
    let path = Path::new(out).join(name);
    std::fs::write(&path, code).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

/// The text of a required field.
fn text<'n>(node: &'n Node, key: &str) -> &'n str {
    let found = node.get(key).and_then(Node::text);
    found.unwrap_or_else(|| panic!("schema: line {}: '{key}' is missing or not text", node.mark.line))
}

/// `ego.meta_lateral`, `left_uturn` and `ego pose` as names of types and variants.
fn camel(name: &str) -> String {
    let parts = name.split(['.', '_', ' ']).filter(|p| !p.is_empty());
    parts.map(|p| p[..1].to_uppercase() + &p[1..]).collect()
}

/// Rust source of the type `Need`.
fn needs_code(needs: &[Node]) -> String {
    let (mut variants, mut all, mut rows) = (String::new(), String::new(), String::new());
    for need in needs {
        let (id, zh) = (text(need, "id"), text(need, "zh"));
        let en = need.get("en").and_then(Node::text).unwrap_or(id);
        let variant = camel(id);
        writeln!(variants, "    /// {en}\n    {variant},").unwrap();
        write!(all, "Need::{variant}, ").unwrap();
        writeln!(rows, "    ({id:?}, {zh:?}, {en:?}),").unwrap();
    }
    format!(
        "/// A part of a log that can be absent: what a signal needs, or what an adapter did not find. Generated from\n\
         /// `schema/needs.yaml`, in its order.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]\npub enum Need {{\n{variants}}}\n\
         impl Need {{\n    /// Every need, in the file's order.\n    pub const ALL: &'static [Need] = &[{all}];\n}}\n\
         /// Id, Chinese and English name by need.\nconst NAMES: &[(&str, &str, &str)] = &[\n{rows}];\n"
    )
}

/// Rust source of `SignalId`, of the typed ids and of the enums of category values.
fn signals_code(signals: &[Node]) -> String {
    let mut sorted: Vec<&Node> = signals.iter().collect();
    // Ids compare as their names do.
    sorted.sort_by_key(|s| text(s, "name"));
    let (mut variants, mut all, mut rows) = (String::new(), String::new(), String::new());
    for signal in &sorted {
        let name = text(signal, "name");
        writeln!(variants, "    /// `{name}`\n    {},", camel(name)).unwrap();
        write!(all, "SignalId::{}, ", camel(name)).unwrap();
        writeln!(rows, "    {},", row(signal)).unwrap();
    }
    let (ids, values) = typed(signals);
    format!(
        "/// A signal of the catalog. Generated from `schema/signals.yaml`; ordered as the names are.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]\n#[repr(u16)]\n\
         pub enum SignalId {{\n{variants}}}\n\
         impl SignalId {{\n    /// Every signal, ordered by name.\n    pub const ALL: &'static [SignalId] = &[{all}];\n}}\n\
         /// Facts by signal, in the order of [`SignalId`].\nstatic FACTS: &[SignalFacts] = &[\n{rows}];\n\
         /// Every signal as a constant that carries its scope and type.\npub mod id {{\n    use super::*;\n{ids}}}\n\
         /// The values of category signals. Signals with the same values share one enum under several names.\n\
         pub mod value {{\n    use super::CategoryValue;\n{values}}}\n"
    )
}

/// One row of `FACTS`.
fn row(signal: &Node) -> String {
    let name = text(signal, "name");
    let scope = match text(signal, "scope") {
        "frame" => "Frame",
        "target" => "Target",
        "object" => "Object",
        "pair" => "Pair",
        other => panic!("schema/signals.yaml: {name}: unknown scope '{other}'"),
    };
    let kind = match text(signal, "type") {
        "number" => format!("SignalType::Number({:?})", text(signal, "unit")),
        "flag" => "SignalType::Flag".to_owned(),
        "category" => format!("SignalType::Category(value::{}::NAMES)", camel(name)),
        other => panic!("schema/signals.yaml: {name}: unknown type '{other}'"),
    };
    let needs = signal.get("needs").map(Node::items).unwrap_or_default().iter();
    let needs: String =
        needs.map(|n| format!("Need::{}, ", camel(n.text().expect("a need is text")))).collect();
    format!("SignalFacts {{ name: {name:?}, scope: SignalScope::{scope}, kind: {kind}, needs: &[{needs}] }}")
}

/// The typed ids, and the enums.
fn typed(signals: &[Node]) -> (String, String) {
    let (mut ids, mut values) = (String::new(), String::new());
    let mut enums: BTreeMap<Vec<&str>, String> = BTreeMap::new();
    for signal in signals {
        let name = text(signal, "name");
        let kind = match text(signal, "type") {
            "number" => "Number".to_owned(),
            "flag" => "Flag".to_owned(),
            _ => format!("Category<value::{}>", camel(name)),
        };
        let scope = match text(signal, "scope") {
            "target" => "PerTarget",
            "object" => "PerObject",
            "pair" => "PerPair",
            _ => "PerFrame",
        };
        let constant = name.replace('.', "_").to_uppercase();
        let id = camel(name);
        writeln!(
            ids,
            "    /// `{name}`\n    pub const {constant}: Signal<{scope}, {kind}> = Signal::new(SignalId::{id});"
        )
        .unwrap();
        let listed = signal.get("values").map(Node::items).unwrap_or_default();
        let names: Vec<&str> = listed.iter().map(|v| v.text().expect("a value is text")).collect();
        if names.is_empty() {
            continue;
        }
        if let Some(first) = enums.get(&names) {
            writeln!(values, "    /// Values of `{name}`.\n    pub type {id} = {first};").unwrap();
        } else {
            values += &enum_code(&id, name, &names);
            enums.insert(names, id);
        }
    }
    (ids, values)
}

fn enum_code(id: &str, signal: &str, names: &[&str]) -> String {
    let (mut variants, mut all) = (String::new(), String::new());
    for name in names {
        let variant = camel(name);
        writeln!(variants, "        /// `{name}`\n        {variant},").unwrap();
        write!(all, "Self::{variant}, ").unwrap();
    }
    format!(
        "    /// Values of `{signal}`.\n\
         \x20   #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]\n    #[repr(u16)]\n\
         \x20   pub enum {id} {{\n{variants}    }}\n\
         \x20   impl {id} {{\n\
         \x20       /// The values' names, in the catalog's order.\n\
         \x20       pub const NAMES: &'static [&'static str] = &{names:?};\n    }}\n\
         \x20   impl CategoryValue for {id} {{\n\
         \x20       const ALL: &'static [Self] = &[{all}];\n\
         \x20       const NAMES: &'static [&'static str] = Self::NAMES;\n\
         \x20       fn code(self) -> u16 {{\n            self as u16\n        }}\n    }}\n"
    )
}
