//! From any serializable value to block-style YAML, for output that people read. Fields keep their order; any text that
//! could be read as another type is quoted.

use super::tree::{Entry, Node, Scalar, Style, Value, parse};
use serde::Serialize;

/// The YAML text of a value, with a line break at its end.
///
/// # Errors
/// If the value cannot be written as JSON, such as a map with keys that are not text.
pub fn to_string<T: Serialize>(value: &T) -> serde_json::Result<String> {
    // JSON is YAML: its tree has the fields in their order, and texts are distinguished from numbers by their quotes.
    let tree = parse(&serde_json::to_string(value)?);
    let node = tree.map_err(|e| serde::ser::Error::custom(e.message().en))?;
    let mut out = String::new();
    match &node.value {
        Value::List(items) if !items.is_empty() => list(items, 0, &mut out),
        Value::Map(entries) if !entries.is_empty() => map(entries, 0, &mut out),
        other => line(other, &mut out),
    }
    Ok(out)
}

fn indent(depth: usize, out: &mut String) {
    out.extend(std::iter::repeat_n("  ", depth));
}

fn list(items: &[Node], depth: usize, out: &mut String) {
    for item in items {
        indent(depth, out);
        out.push_str("- ");
        // The first line of what is nested starts behind the dash.
        let mut inner = String::new();
        match &item.value {
            Value::Map(entries) if !entries.is_empty() => map(entries, depth + 1, &mut inner),
            Value::List(items) if !items.is_empty() => list(items, depth + 1, &mut inner),
            other => line(other, &mut inner),
        }
        out.push_str(inner.trim_start());
    }
}

fn map(entries: &[Entry], depth: usize, out: &mut String) {
    for Entry { key, node, .. } in entries {
        indent(depth, out);
        out.push_str(&text(key));
        out.push(':');
        match &node.value {
            Value::Map(inner) if !inner.is_empty() => {
                out.push('\n');
                map(inner, depth + 1, out);
            }
            Value::List(items) if !items.is_empty() => {
                out.push('\n');
                list(items, depth, out);
            }
            other => {
                out.push(' ');
                line(other, out);
            }
        }
    }
}

/// A scalar, or an empty list or mapping, and the end of its line.
fn line(value: &Value, out: &mut String) {
    match value {
        Value::Null => out.push_str("null"),
        Value::Scalar(Scalar { text: t, style: Style::Plain }) => out.push_str(t),
        Value::Scalar(s) => out.push_str(&text(&s.text)),
        Value::List(_) => out.push_str("[]"),
        Value::Map(_) => out.push_str("{}"),
    }
    out.push('\n');
}

/// A text without quotes where it is unambiguous; otherwise as a JSON string, which YAML reads too.
fn text(t: &str) -> String {
    let plain = !t.is_empty()
        && t.trim() == t
        && !t.contains(|c: char| c.is_control())
        && !t.contains(": ")
        && !t.contains(" #")
        && !t.ends_with(':')
        && !t.starts_with(|c: char| "-?:,[]{}#&*!|>'\"%@`~.=<+".contains(c) || c.is_ascii_digit())
        && !matches!(
            t.to_ascii_lowercase().as_str(),
            "null" | "true" | "false" | "yes" | "no" | "on" | "off" | "y" | "n"
        );
    if plain { t.to_owned() } else { serde_json::Value::from(t).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::yaml::decode::from_str;
    use serde_json::{Value, json};

    #[test]
    fn what_is_written_is_read_back() {
        let value = json!({
            "name": "a: b", "zh": "切入", "n": 1.5, "none": null, "empty": [], "bare": {}, "flag": true, "like": "1.0",
            "list": [{"a": "x # y", "b": ["-", "null", " s ", "two\nlines"]}, [1, [2, 3]], "plain text"],
        });
        let written = to_string(&value).unwrap();
        assert_eq!(from_str::<Value>(&written).unwrap(), value, "{written}");
        #[derive(Serialize)]
        struct Row {
            id: &'static str,
            count: u32,
        }
        let rows = [Row { id: "cutin", count: 2 }];
        assert_eq!(to_string(&rows).unwrap(), "- id: cutin\n  count: 2\n");
        assert_eq!(to_string(&json!([])).unwrap(), "[]\n");
    }
}
