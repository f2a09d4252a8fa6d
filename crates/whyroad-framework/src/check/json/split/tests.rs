//! Cutting: the output, the stated positions, and independence of the chunk size.

use super::*;

/// The whole output, as text: `line:column[/element] bytes`, or the problem's name.
fn cut(layout: Layout, text: &str, chunk: usize) -> Vec<String> {
    let mut out = Vec::new();
    let mut sink = |p: Piece<'_>| {
        out.push(match p {
            Piece::Document(d) => {
                let element = d.origin.element.map(|i| format!("/{i}")).unwrap_or_default();
                format!("{}:{}{element} {}", d.origin.line, d.origin.column, String::from_utf8_lossy(d.bytes))
            }
            Piece::Problem(p, o) => format!("{}:{} {p:?}", o.line, o.column),
        });
    };
    let mut s = Splitter::new(layout);
    for part in text.as_bytes().chunks(chunk.max(3)) {
        s.feed(part, &mut sink);
    }
    s.finish(&mut sink);
    out
}

fn values(text: &str) -> Vec<String> {
    let whole = cut(Layout::Values, text, usize::MAX);
    for chunk in [3, 4, 7, 16] {
        assert_eq!(cut(Layout::Values, text, chunk), whole, "chunks of {chunk}: {text}");
    }
    whole
}

#[test]
fn lines_are_documents_and_blank_ones_are_not() {
    let text = "{\"a\":1}\n\n  {\"b\":2}\r\nbroken {\n{\"c\":3}";
    let expected = ["1:1 {\"a\":1}", "3:3 {\"b\":2}", "4:1 broken {", "5:1 {\"c\":3}"];
    for chunk in [3, 5, 1000] {
        assert_eq!(cut(Layout::Lines, text, chunk), expected);
    }
}

#[test]
fn arrays_give_their_elements_with_places() {
    assert_eq!(
        values("[\n  {\"名\": \"[}\\\"\"},\n  {\"b\": [1, {\"c\": 2}]}, 3, \"x\"\n]\n"),
        ["2:3/0 {\"名\": \"[}\\\"\"}", "3:3/1 {\"b\": [1, {\"c\": 2}]}", "3:25/2 3", "3:28/3 \"x\""]
    );
    assert_eq!(values("{\"名\":1} {\"b\":2}\n{\n}"), ["1:1 {\"名\":1}", "1:9 {\"b\":2}", "2:1 {\n}"]);
}

#[test]
fn a_broken_document_does_not_swallow_the_next() {
    // A bracket forgotten inside, a brace forgotten at the end, a quote forgotten.
    assert_eq!(values("[{\"a\":[1,2}, {\"b\":1}]"), ["1:2/0 {\"a\":[1,2}", "1:14/1 {\"b\":1}"]);
    assert_eq!(values("[{\"a\":{\"b\":1},\n{\"c\":2}]"), ["1:2/0 {\"a\":{\"b\":1}", "2:1/1 {\"c\":2}"]);
    assert_eq!(values("{\"a\":1,\n{\"c\":2}"), ["1:1 {\"a\":1", "2:1 {\"c\":2}"]);
    assert_eq!(values("[{\"a\":\"x},\n{\"c\":2}]"), ["1:2/0 {\"a\":\"x}", "2:1/1 {\"c\":2}"]);
    assert_eq!(values("[{\"a\":1}"), ["1:2/0 {\"a\":1}", "1:9 ArrayOpen"]);
    assert_eq!(values("{\"a\":1"), ["1:1 {\"a\":1"]);
}

#[test]
fn commas_of_an_array_are_checked() {
    assert_eq!(values("[{} {},]"), ["1:2/0 {}", "1:5 CommaMissing", "1:5/1 {}", "1:8 CommaTooMany"]);
    assert_eq!(values("[,{}]"), ["1:2 CommaTooMany", "1:3/0 {}"]);
}

#[test]
fn what_is_not_json_is_given_up() {
    let csv = "a,b,c\n".repeat(1000);
    assert_eq!(values(&csv).len(), 22);
    assert_eq!(values("\u{FEFF}{}"), ["1:1 ByteOrderMark", "1:1 {}"]);
    let mut out = Vec::new();
    Splitter::new(Layout::Lines).feed(b"\xFF\xFE{\0", &mut |p| out.push(format!("{p:?}")));
    assert!(out.len() == 1 && out[0].contains("Utf16"), "{out:?}");
}

#[test]
fn the_layout_shows_in_the_first_lines() {
    for (text, layout) in [
        ("{\"a\":1}\n{\"b\":2}\n", Layout::Lines),
        ("{\"a\":1}\n", Layout::Lines),
        ("{\"a\":\n{\"b\":2}\n", Layout::Lines),
        ("{\n  \"a\": 1\n}\n", Layout::Values),
        ("[\n{}\n]", Layout::Values),
        ("[{},{}]\n", Layout::Values),
        ("{\"a\": {\n", Layout::Values),
        ("{\"a\":1}", Layout::Values),
        ("", Layout::Lines),
        ("id,name\n", Layout::Lines),
    ] {
        assert_eq!(Layout::guess(text.as_bytes()), layout, "{text:?}");
    }
}
