//! The fields of a label for the page: `web/src/label/label_fields.generated.ts`, with pointers and names.

use super::LabelField;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// TypeScript source with one constant per pointer (`KEYFRAME_TIMESTAMP`; a function of the positions for list
/// elements: `criticalComponentsItemId(n0)`), and the Chinese and English names of the fields that the page shows.
///
/// # Panics
/// If two objects have a field of the same name that the page shows under different names.
pub fn page_module(fields: &[LabelField]) -> String {
    let mut out = String::from(
        "// Generated from schema/label_fields.yaml: `cargo run -q -p whyroad-model --example label_fields >\n\
         // web/src/label/label_fields.generated.ts`. Do not edit.\n\
         import type { TextPair } from \"../text/screen_texts.ts\";\n\n\
         // JSON pointers (RFC 6901).\n",
    );
    let mut items = BTreeSet::new();
    for field in fields {
        if let Some((list, _)) = field.pointer.rsplit_once("/*/")
            && items.insert(list)
        {
            pointer(&format!("{list}/*"), &mut out);
        }
        pointer(field.pointer, &mut out);
    }
    let (mut top, mut members, mut seen) = (String::new(), String::new(), BTreeMap::new());
    for field in fields {
        let Some((zh, en)) = field.names else { continue };
        let (parent, name) = field.pointer.rsplit_once('/').unwrap_or_default();
        let row = format!("  {name}: [{zh:?}, {en:?}],\n");
        if parent.is_empty() {
            top.push_str(&row);
        } else if *seen.entry(name).or_insert((zh, en)) != (zh, en) {
            panic!("'{name}' has two names on the page");
        } else if !members.contains(&row) {
            members.push_str(&row);
        }
    }
    write!(
        out,
        "\n/** Names of the fields of the label: [Chinese, English]. */\n\
         export const TOP_NAMES = {{\n{top}}} as const satisfies Record<string, TextPair>;\n\n\
         /** Names of the members of these fields: [Chinese, English]. */\n\
         export const MEMBER_NAMES = {{\n{members}}} as const satisfies Record<string, TextPair>;\n"
    )
    .unwrap_or_default();
    out
}

fn pointer(pointer: &str, out: &mut String) {
    let name = pointer[1..].replace("/*", "_item").replace('/', "_");
    let stars = pointer.matches('*').count();
    let line = if stars == 0 {
        format!("export const {} = {pointer:?};", name.to_uppercase())
    } else {
        let arguments: Vec<String> = (0..stars).map(|i| format!("n{i}: number")).collect();
        let text = (0..stars).fold(pointer.to_owned(), |p, i| p.replacen('*', &format!("${{n{i}}}"), 1));
        let mut parts = name.split('_');
        let first = parts.next().unwrap_or_default().to_owned();
        let camel = parts.fold(first, |n, p| {
            let (head, rest) = p.split_at(1.min(p.len()));
            n + &head.to_uppercase() + rest
        });
        format!("export const {camel} = ({}): string => `{text}`;", arguments.join(", "))
    };
    out.push_str(&line);
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::page_module;
    use crate::label_fields::{FieldPresence, LABEL_FIELDS, LabelField};

    #[test]
    fn the_committed_module_of_the_page_is_current() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../web/src/label/label_fields.generated.ts");
        let committed = std::fs::read_to_string(path).unwrap();
        assert!(
            committed == page_module(LABEL_FIELDS),
            "run: cargo run -q -p whyroad-model --example label_fields > web/src/label/label_fields.generated.ts"
        );
    }

    #[test]
    fn pointers_and_names_of_a_list() {
        let field =
            |pointer, names| LabelField { pointer, presence: FieldPresence::Required, since: "2.0", names };
        let text = page_module(&[field("/a_b", Some(("甲", "A"))), field("/a_b/*/c_d", Some(("乙", "c")))]);
        assert!(text.contains("export const A_B = \"/a_b\";\n"), "{text}");
        assert!(text.contains("export const aBItem = (n0: number): string => `/a_b/${n0}`;\n"), "{text}");
        assert!(
            text.contains("export const aBItemCD = (n0: number): string => `/a_b/${n0}/c_d`;\n"),
            "{text}"
        );
        assert!(text.contains("  a_b: [\"甲\", \"A\"],\n} as const"), "{text}");
        assert!(text.contains("  c_d: [\"乙\", \"c\"],\n} as const"), "{text}");
    }
}
