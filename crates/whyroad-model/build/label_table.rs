//! The table of `schema/label_fields.yaml`, as the build scripts of whyroad-model and whyroad-label read it.

use crate::tree::{Node, parse};
use std::path::Path;

/// One object of the label.
pub struct Object {
    pub name: String,
    pub doc: String,
    /// The label itself.
    pub root: bool,
    /// Has a `Default`.
    pub default: bool,
    pub fields: Vec<Field>,
}

/// One field of an object.
pub struct Field {
    pub name: String,
    /// Name in Rust.
    pub rust: String,
    pub kind: FieldType,
    pub presence: Presence,
    pub since: Option<String>,
    pub blank: bool,
    pub doc: String,
    /// Chinese and English name on the page.
    pub label: Option<(String, String)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    Required,
    Optional,
    Nullable,
}

#[derive(Clone, PartialEq, Eq)]
pub enum FieldType {
    Text,
    Time,
    Frame,
    Records,
    TextsByName,
    Closed(String),
    Object(String),
    List(Box<FieldType>),
}

/// Reads the table; a fault in it fails the build.
pub fn read(path: &Path) -> Vec<Object> {
    println!("cargo:rerun-if-changed={}", path.display());
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let root = parse(&text).unwrap_or_else(|e| panic!("{}:{}: {:?}", path.display(), e.mark.line, e.cause));
    let nodes = root.get("objects").expect("the table has 'objects'").items();
    let names: Vec<String> = nodes.iter().map(|n| need(n, "name")).collect();
    nodes.iter().map(|n| object(n, &names)).collect()
}

fn need(node: &Node, key: &str) -> String {
    let line = node.mark.line;
    optional(node, key).unwrap_or_else(|| panic!("label_fields.yaml:{line}: '{key}' is missing"))
}

fn optional(node: &Node, key: &str) -> Option<String> {
    node.get(key).and_then(Node::text).map(str::to_owned)
}

fn object(node: &Node, names: &[String]) -> Object {
    let fields = node.get("fields").expect("an object has fields").items();
    Object {
        name: need(node, "name"),
        doc: need(node, "doc"),
        root: optional(node, "root").is_some(),
        default: optional(node, "default").is_some(),
        fields: fields.iter().map(|f| field(f, names)).collect(),
    }
}

fn field(node: &Node, names: &[String]) -> Field {
    let name = need(node, "name");
    Field {
        rust: optional(node, "rust").unwrap_or_else(|| name.clone()),
        kind: kind(&need(node, "type"), names),
        presence: match optional(node, "presence").as_deref() {
            None | Some("required") => Presence::Required,
            Some("optional") => Presence::Optional,
            Some("nullable") => Presence::Nullable,
            Some(other) => panic!("label_fields.yaml:{}: unknown presence '{other}'", node.mark.line),
        },
        since: optional(node, "since"),
        blank: optional(node, "blank").is_some(),
        doc: need(node, "doc"),
        label: optional(node, "zh").zip(optional(node, "en")),
        name,
    }
}

fn kind(text: &str, names: &[String]) -> FieldType {
    if let Some(inner) = text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
        return FieldType::List(Box::new(kind(inner, names)));
    }
    match text {
        "text" => FieldType::Text,
        "time" => FieldType::Time,
        "frame" => FieldType::Frame,
        "records" => FieldType::Records,
        "texts-by-name" => FieldType::TextsByName,
        name if names.iter().any(|n| n == name) => FieldType::Object(name.to_owned()),
        name => FieldType::Closed(name.to_owned()),
    }
}
