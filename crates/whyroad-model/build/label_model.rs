//! Rust source of the label's typed model, of its pointers and of the table of its fields.

use crate::label_table::{Field, FieldType, Object, Presence};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The structs of the messages, and the step back to format 2.0.
pub fn types(objects: &[Object]) -> String {
    let mut out = String::new();
    for o in objects {
        let eq = if o.root { "" } else { "Eq, " };
        let default = if o.default { "Default, " } else { "" };
        writeln!(
            out,
            "/// {}\n#[derive(Clone, Debug, {default}PartialEq, {eq}Serialize, Deserialize, JsonSchema)]\npub struct {} {{",
            o.doc, o.name
        )
        .unwrap();
        for f in &o.fields {
            let since = f.since.as_ref().map(|v| format!(" Since {v}.")).unwrap_or_default();
            writeln!(out, "    /// {}{since}\n{}    pub {}: {},", f.doc, attributes(f), f.rust, rust_type(f))
                .unwrap();
        }
        out.push_str("}\n");
    }
    let root = objects.iter().find(|o| o.root).expect("one object is the label");
    writeln!(
        out,
        "impl {} {{\n    /// The same in format 2.0.0: without everything that later versions added.\n    #[must_use]\n    \
         pub fn to_2_0(mut self) -> Self {{\n        self.version = Some(\"2.0.0\".to_owned());\n{}        self\n    }}\n}}",
        root.name,
        without_new(root, objects, "self")
    )
    .unwrap();
    out
}

/// Statements that reset every field added after 2.0.
fn without_new(object: &Object, objects: &[Object], at: &str) -> String {
    let mut out = String::new();
    for f in &object.fields {
        let path = format!("{at}.{}", f.rust);
        if f.since.is_some() {
            writeln!(out, "        {path} = Default::default();").unwrap();
            continue;
        }
        let inner = |name: &String| objects.iter().find(|o| o.name == *name).expect("a named object");
        match &f.kind {
            FieldType::Object(name) if f.presence == Presence::Required => {
                out.push_str(&without_new(inner(name), objects, &path));
            }
            FieldType::List(of) => {
                if let FieldType::Object(name) = &**of {
                    let body = without_new(inner(name), objects, "item");
                    if !body.is_empty() {
                        writeln!(out, "        for item in &mut {path} {{\n{body}        }}").unwrap();
                    }
                }
            }
            _ => {}
        }
    }
    out
}

fn plain_type(kind: &FieldType) -> String {
    match kind {
        FieldType::Text => "String".into(),
        FieldType::Time => "Nanos".into(),
        FieldType::Frame => "u32".into(),
        FieldType::Records => "BTreeMap<String, serde_json::Value>".into(),
        FieldType::TextsByName => "BTreeMap<String, String>".into(),
        FieldType::Closed(name) | FieldType::Object(name) => name.clone(),
        FieldType::List(of) => format!("Vec<{}>", plain_type(of)),
    }
}

/// A list or mapping: absent and empty are the same.
fn is_many(kind: &FieldType) -> bool {
    matches!(kind, FieldType::List(_) | FieldType::Records | FieldType::TextsByName)
}

fn rust_type(f: &Field) -> String {
    let plain = plain_type(&f.kind);
    if f.presence == Presence::Required || is_many(&f.kind) { plain } else { format!("Option<{plain}>") }
}

fn attributes(f: &Field) -> String {
    let plain = plain_type(&f.kind);
    let mut out = String::new();
    if f.rust != f.name {
        writeln!(out, "    #[serde(rename = {:?})]", f.name).unwrap();
    }
    match (&f.kind, f.presence) {
        (_, Presence::Required) => {}
        (_, Presence::Nullable) => write!(
            out,
            "    #[serde(deserialize_with = \"present\")]\n    #[schemars(schema_with = \"decision_or_null::<{plain}>\")]\n"
        )
        .unwrap(),
        (FieldType::List(_), _) => write!(
            out,
            "    #[serde(default, deserialize_with = \"none_as_empty\", skip_serializing_if = \"Vec::is_empty\")]\n    \
             #[schemars(with = \"Option<{plain}>\")]\n"
        )
        .unwrap(),
        (FieldType::Records | FieldType::TextsByName, _) => {
            out.push_str("    #[serde(default, skip_serializing_if = \"BTreeMap::is_empty\")]\n");
        }
        _ => out.push_str("    #[serde(default, skip_serializing_if = \"Option::is_none\")]\n"),
    }
    out
}

/// The table of all fields in the order of the message, their pointers as constants and functions, and their names.
pub fn table(objects: &[Object]) -> String {
    let root = objects.iter().find(|o| o.root).expect("one object is the label");
    let (mut rows, mut pointers) = (String::new(), String::new());
    walk(root, objects, "", &mut rows, &mut pointers);
    format!(
        "/// Every field of a label, an object before its own fields, in the order of the message.\n\
         pub const LABEL_FIELDS: &[LabelField] = &[\n{rows}];\n\
         /// JSON pointers of the fields. What is in a list is a function of its position there.\n\
         pub mod pointer {{\n{pointers}}}\n\
         /// Names of the fields in their objects: the last part of a pointer.\n\
         pub mod name {{\n{}}}\n",
        names(objects)
    )
}

/// `frame_idx` as `FRAME_IDX`; a name that several objects use is there once.
fn names(objects: &[Object]) -> String {
    let all: BTreeSet<&str> = objects.iter().flat_map(|o| &o.fields).map(|f| f.name.as_str()).collect();
    let mut out = String::new();
    for name in all {
        writeln!(out, "    /// `{name}`\n    pub const {}: &str = {name:?};", name.to_uppercase()).unwrap();
    }
    out
}

fn walk(object: &Object, objects: &[Object], base: &str, rows: &mut String, pointers: &mut String) {
    for f in &object.fields {
        let at = format!("{base}/{}", f.name);
        let names = match &f.label {
            Some((zh, en)) => format!("Some(({zh:?}, {en:?}))"),
            None => "None".to_owned(),
        };
        let presence = match f.presence {
            Presence::Required => "Required",
            Presence::Optional => "Optional",
            Presence::Nullable => "Nullable",
        };
        let since = f.since.as_deref().unwrap_or("2.0");
        writeln!(
            rows,
            "    LabelField {{ pointer: {at:?}, presence: FieldPresence::{presence}, since: {since:?}, names: {names} }},"
        )
        .unwrap();
        constant(&at, pointers);
        let inner = |name: &String| objects.iter().find(|o| o.name == *name).expect("a named object");
        match &f.kind {
            FieldType::Object(name) => walk(inner(name), objects, &at, rows, pointers),
            FieldType::List(of) => {
                let item = format!("{at}/*");
                constant(&item, pointers);
                if let FieldType::Object(name) = &**of {
                    walk(inner(name), objects, &item, rows, pointers);
                }
            }
            FieldType::Records | FieldType::TextsByName => by_name(&at, pointers),
            _ => {}
        }
    }
}

/// `/keyframe/type` as `KEYFRAME_TYPE`; `/critical_components/*/id` as `critical_components_item_id(0)`.
fn constant(pointer: &str, out: &mut String) {
    let name = pointer[1..].replace("/*", "_item").replace('/', "_");
    let stars = pointer.matches('*').count();
    if stars == 0 {
        writeln!(out, "    /// `{pointer}`\n    pub const {}: &str = {pointer:?};", name.to_uppercase())
            .unwrap();
        return;
    }
    let arguments: Vec<String> = (0..stars).map(|i| format!("n{i}: usize")).collect();
    let format = (0..stars).fold(pointer.to_owned(), |p, i| p.replacen('*', &format!("{{n{i}}}"), 1));
    writeln!(
        out,
        "    /// `{pointer}`\n    pub fn {name}({}) -> String {{\n        format!({format:?})\n    }}",
        arguments.join(", ")
    )
    .unwrap();
}

fn by_name(pointer: &str, out: &mut String) {
    let name = pointer[1..].replace('/', "_");
    writeln!(
        out,
        "    /// `{pointer}/<name>`\n    pub fn {name}_of(name: &str) -> String {{\n        \
         format!(\"{pointer}/{{}}\", name.replace('~', \"~0\").replace('/', \"~1\"))\n    }}"
    )
    .unwrap();
}
