//! The parser accepts what serde_json accepts, returns the same values, and locates the mistake.

use super::*;
use proptest::prelude::*;
use serde_json::Value;

fn to_value(n: &Node<'_>) -> Value {
    match &n.kind {
        JsonKind::Null => Value::Null,
        JsonKind::Flag(b) => Value::Bool(*b),
        JsonKind::Number(raw) => serde_json::from_str(raw).unwrap(),
        JsonKind::Text(t) => Value::String(t.clone().into_owned()),
        JsonKind::List(items) => items.iter().map(to_value).collect(),
        JsonKind::Map(entries) => {
            Value::Object(entries.iter().map(|e| (e.key.clone().into_owned(), to_value(&e.node))).collect())
        }
    }
}

/// Same verdict and same value as serde_json, which is the reference.
fn agrees(text: &str) {
    match (parse(text), serde_json::from_str::<Value>(text)) {
        (Ok(n), Ok(v)) => assert_eq!(to_value(&n), v, "{text:?}"),
        (Err(_), Err(_)) => {}
        (mine, theirs) => panic!("{text:?}: ours {mine:?}, serde_json {theirs:?}"),
    }
}

const SAMPLE: &str = r#"{"a": [1, -0.5, 1e3, 155], "名": {"x": null, "y": [true, false, {}], "z": "\u4e2d\n\ud83d\ude00/\\"}, "e": [], "k": "左转"}"#;

#[test]
fn values_of_serde_json() {
    agrees(SAMPLE);
    for t in [
        "0",
        "-0",
        "01",
        "-",
        "1.",
        ".5",
        "1e",
        "1e+5",
        "1e999",
        "-1e999",
        "NaN",
        "nul",
        "nulls",
        "\"\\ud800\"",
        "\"\\u12\"",
        "\"\\x\"",
        "\"a\tb\"",
        "[1,]",
        "{\"a\":1,}",
        "[1 2]",
        "{a:1}",
        "{'a':1}",
        "{} {}",
        "",
        " ",
        "\u{feff}{}",
        "\"",
        "\"\\",
        "[1",
        "{\"a\"",
        "{\"a\":",
    ] {
        agrees(t);
    }
    for depth in [126, 127, 128, 129] {
        agrees(&format!("{}{}", "[".repeat(depth), "]".repeat(depth)));
    }
}

#[test]
fn mistakes_are_where_a_reader_would_point() {
    // Columns counted by hand.
    for (text, at, zh) in [
        ("{\"a\": 1,}", 7, "前多了一个逗号"),
        ("{\"a\": 1 \"b\": 2}", 8, "此处应为 ',' 或 '}'，实为 '\"'"),
        ("{\"a\"：1}", 4, "此处应为 ':'，实为 '：'"),
        ("{“a”: 1}", 1, "带双引号的键"),
        ("{\"a\": None}", 6, "'None' 不是 JSON 值"),
        ("{\"a\": 01}", 6, "'01' 不是 JSON 值"),
        ("{\"a\": \"x\ny\"}", 6, "缺少结尾的双引号"),
        ("{\"a\": 1", 6, "JSON 在此处中断"),
    ] {
        let e = parse(text).unwrap_err();
        assert_eq!(e.span.start, at, "{text}: {e:?}");
        assert!(e.message.zh.contains(zh), "{text}: {}", e.message.zh);
    }
}

proptest! {
    #[test]
    fn agrees_with_serde_json_on_mutations(cuts in prop::collection::vec((0usize..200, 0usize..4, prop::sample::select(
        vec!["", "{", "}", "[", "]", ",", ":", "\"", "\\", "1", "-", ".", "e", " ", "\n", "null", "\\u00", "中"])), 1..4)) {
        let mut text: Vec<char> = SAMPLE.chars().collect();
        for (at, delete, insert) in cuts {
            let at = at.min(text.len());
            let end = (at + delete).min(text.len());
            text.splice(at..end, insert.chars());
        }
        let text: String = text.into_iter().collect();
        agrees(&text);
    }
}
