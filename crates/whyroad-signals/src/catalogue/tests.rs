//! The bundled catalogue is sound, and broken ones are refused with their own codes.

use super::*;

#[test]
fn the_bundled_catalogue_has_no_errors_and_the_named_signals() {
    let (catalogue, diagnostics) = Catalogue::parse(include_str!("../../../../schema/signals.yaml"));
    assert!(diagnostics.is_empty(), "{diagnostics:#?}");
    // Names and dimensions from issue 2's contract between rules and signals.
    let number = |d| SignalKind::Number(d);
    assert_eq!(catalogue.get("ego.speed").unwrap().kind, number(Dimension::Speed));
    assert_eq!(catalogue.get("ttc").unwrap().name, "target.ttc");
    assert_eq!(catalogue.get("target.lateral_offset").unwrap().kind, number(Dimension::Length));
    let (def, restriction) = catalogue.resolve("target_vehicle.lateral_offset").unwrap();
    assert_eq!((def.name.as_str(), restriction), ("target.lateral_offset", TargetRestriction::Vehicle));
    assert_eq!(catalogue.resolve("target_vru.path_lateral").unwrap().1, TargetRestriction::Vru);
    assert!(catalogue.get("target_vehicle.nothing").is_none());
    assert_eq!(catalogue.similar("ego.sped"), ["ego.speed"]);
    for def in catalogue.iter() {
        assert!(
            !def.meaning.zh.is_empty() && !def.meaning.en.is_empty() && !def.source.is_empty(),
            "{}",
            def.name
        );
    }
}

#[test]
fn broken_entries_are_refused_one_by_one() {
    let entry = |name: &str, rest: &str| {
        format!(
            "  - {{name: {name}, scope: frame, needs: [], source: s, meaning: {{zh: a, en: b}}, {rest}}}\n"
        )
    };
    let cases = [
        ("signals.type", entry("ego.a", "type: number, unit: furlong, scale: 1")),
        ("signals.type", entry("ego.a", "type: number, unit: m")),
        ("signals.type", entry("ego.a", "type: category")),
        ("signals.name", entry("target.a", "type: flag")),
        ("signals.name", entry("ego.good", "type: flag")),
        ("signals.needs", entry("ego.a", "type: flag").replace("needs: []", "needs: [luck]")),
    ];
    for (code, broken) in cases {
        let text = format!("version: '1'\nsignals:\n{}{broken}", entry("ego.good", "type: flag"));
        let (catalogue, diagnostics) = Catalogue::parse(&text);
        assert_eq!(diagnostics.iter().map(|d| d.code).collect::<Vec<_>>(), [code], "{broken}");
        assert!(catalogue.get("ego.good").is_some(), "the sound entry is kept");
    }
    assert_eq!(Catalogue::parse("signals: [").1[0].code, "signals.syntax");
}

#[test]
fn every_code_has_a_page() {
    for code in CODES {
        let page = format!("{}/../../docs/diagnostics/{code}.md", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&page).unwrap_or_else(|e| panic!("{page}: {e}"));
        assert!(text.contains("## 中文"), "{page} lacks its Chinese section");
    }
}

#[test]
fn the_page_is_as_the_catalogue_says() {
    let path = format!("{}/../../docs/reference/signals.md", env!("CARGO_MANIFEST_DIR"));
    let written = std::fs::read_to_string(&path).unwrap();
    let stale = "docs/reference/signals.md is stale: cargo run -p whyroad-signals --example signals_page > docs/reference/signals.md";
    assert!(written == Catalogue::bundled().page(), "{stale}");
}
