//! Generates the structs of the fast reader from `schema/label_fields.yaml`: a label whose texts are borrowed from the
//! document, with the fields, the required keys and the blank texts of the table.
#![allow(clippy::unwrap_used)] // writing to a `String` cannot fail

#[allow(dead_code)]
#[path = "../whyroad-model/build/label_table.rs"]
mod label_table;
#[allow(dead_code, unreachable_pub)]
#[path = "../whyroad-model/src/yaml/tree.rs"]
mod tree;

use label_table::{Field, FieldType, Object, Presence};
use std::fmt::Write as _;
use std::path::Path;

fn main() {
    let objects = label_table::read(Path::new("../../schema/label_fields.yaml"));
    let out = std::env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let path = Path::new(&out).join("lean_label.rs");
    std::fs::write(&path, code(&objects)).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../whyroad-model/build/label_table.rs");
    println!("cargo:rerun-if-changed=../whyroad-model/src/yaml/tree.rs");
}

fn find<'o>(name: &str, objects: &'o [Object]) -> &'o Object {
    objects.iter().find(|o| o.name == name).expect("a named object")
}

/// One struct for each object, and whether a required text in it is blank.
fn code(objects: &[Object]) -> String {
    let mut out = String::new();
    for o in objects {
        let life = if borrows(&FieldType::Object(o.name.clone()), objects) { "<'t>" } else { "" };
        writeln!(
            out,
            "/// {}\n#[derive(Deserialize)]\n#[serde(deny_unknown_fields)]\n\
             #[allow(dead_code)] // every field must have its form; rules do not use each\n\
             pub(in crate::check) struct Lean{}{life} {{",
            o.doc, o.name
        )
        .unwrap();
        for f in &o.fields {
            writeln!(out, "{}    pub {}: {},", attributes(f, objects), f.rust, field_type(f, objects))
                .unwrap();
        }
        out.push_str("}\n");
        let blank: Vec<String> = o.fields.iter().filter_map(|f| blank(f, objects)).collect();
        if !blank.is_empty() {
            let (name, any) = (&o.name, blank.join("\n            || "));
            writeln!(
                out,
                "impl Lean{name}{} {{\n    /// A text that must not be blank is.\n    \
                 pub fn has_blank(&self) -> bool {{\n        {any}\n    }}\n}}",
                life.replace('t', "_")
            )
            .unwrap();
        }
    }
    out
}

/// Whether a value of this type contains text of the document.
fn borrows(kind: &FieldType, objects: &[Object]) -> bool {
    match kind {
        FieldType::Text | FieldType::Records | FieldType::TextsByName => true,
        FieldType::Time | FieldType::Frame | FieldType::Closed(_) => false,
        FieldType::Object(name) => find(name, objects).fields.iter().any(|f| borrows(&f.kind, objects)),
        FieldType::List(of) => borrows(of, objects),
    }
}

fn plain_type(kind: &FieldType, objects: &[Object]) -> String {
    match kind {
        FieldType::Text => "Text<'t>".to_owned(),
        FieldType::Time => "Nanos".to_owned(),
        FieldType::Frame => "u32".to_owned(),
        FieldType::Records => "Records<'t>".to_owned(),
        FieldType::TextsByName => "Texts<'t>".to_owned(),
        FieldType::Closed(name) => format!("Id<{name}>"),
        FieldType::Object(name) if borrows(kind, objects) => format!("Lean{name}<'t>"),
        FieldType::Object(name) => format!("Lean{name}"),
        // Components are not kept one by one: see `form/lean/fields.rs`.
        FieldType::List(of) => match &**of {
            FieldType::Object(name) => format!("Folded{name}s<'t>"),
            of => format!("Vec<{}>", plain_type(of, objects)),
        },
    }
}

fn field_type(f: &Field, objects: &[Object]) -> String {
    let plain = plain_type(&f.kind, objects);
    if f.presence == Presence::Required { plain } else { format!("Option<{plain}>") }
}

fn attributes(f: &Field, objects: &[Object]) -> String {
    let mut of: Vec<String> = Vec::new();
    if borrows(&f.kind, objects) {
        of.push("borrow".to_owned());
    }
    if f.rust != f.name {
        of.push(format!("rename = {:?}", f.name));
    }
    match f.presence {
        Presence::Required => {}
        Presence::Optional => of.push("default".to_owned()),
        Presence::Nullable => of.push("deserialize_with = \"present\"".to_owned()),
    }
    if of.is_empty() { String::new() } else { format!("    #[serde({})]\n", of.join(", ")) }
}

/// The condition under which a field contains a blank text; `None` if it contains no text or may be blank.
fn blank(f: &Field, objects: &[Object]) -> Option<String> {
    if f.blank {
        return None;
    }
    let (one, of_item) = match &f.kind {
        FieldType::Text => ("is_blank", ""),
        FieldType::TextsByName => ("has_blank", ""),
        FieldType::Object(name) => {
            find(name, objects).fields.iter().find_map(|f| blank(f, objects))?;
            ("has_blank", "")
        }
        FieldType::List(of) if **of == FieldType::Text => ("is_blank", ".flatten()"),
        // Folded objects are checked one by one, while they are read.
        _ => return None,
    };
    let at = format!("self.{}", f.rust);
    Some(match (f.presence, of_item) {
        (Presence::Required, "") => format!("{at}.{one}()"),
        (Presence::Required, _) => format!("{at}.iter().any(|v| v.{one}())"),
        (_, flatten) => format!("{at}.iter(){flatten}.any(|v| v.{one}())"),
    })
}
