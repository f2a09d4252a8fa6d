//! The bundled catalog has no errors, and invalid ones are rejected with separate codes.

use super::*;

#[test]
fn the_bundled_catalog_has_no_errors_and_the_named_signals() {
    let (catalog, diagnostics) = Catalog::parse(include_str!("../../../../schema/signals.yaml"));
    assert!(diagnostics.is_empty(), "{diagnostics:#?}");
    // Names and dimensions from issue 2's contract between rules and signals.
    let number = |d| SignalKind::Number(d);
    assert_eq!(catalog.get("ego.speed").unwrap().kind, number(Dimension::Speed));
    assert_eq!(catalog.get("ttc").unwrap().name, "target.ttc");
    assert_eq!(catalog.get("target.lateral_offset").unwrap().kind, number(Dimension::Length));
    let (def, restriction) = catalog.resolve("target_vehicle.lateral_offset").unwrap();
    assert_eq!((def.name.as_str(), restriction), ("target.lateral_offset", TargetRestriction::Vehicle));
    assert_eq!(catalog.resolve("target_vru.path_lateral").unwrap().1, TargetRestriction::Vru);
    assert!(catalog.get("target_vehicle.nothing").is_none());
    assert_eq!(catalog.similar("ego.sped"), ["ego.speed"]);
    for def in catalog.iter() {
        assert!(
            !def.meaning.zh.is_empty() && !def.meaning.en.is_empty() && !def.source.is_empty(),
            "{}",
            def.name
        );
    }
}

/// The bundled text with `from`, which it contains, replaced once by `to`; its errors, and the catalog.
fn changed(from: &str, to: &str) -> (Catalog, Vec<Diagnostic>) {
    let text = include_str!("../../../../schema/signals.yaml");
    assert!(text.contains(from), "{from}");
    Catalog::parse(&text.replacen(from, to, 1))
}

const SPEED: &str = "  - name: ego.speed\n    title: { zh: 自车速度, en: speed of the ego }\n    scope: frame\n    type: number\n    unit: m/s\n    scale: 5.0\n    least: 0\n    needs: [ego pose]\n";

#[test]
fn broken_entries_are_refused_one_by_one_where_they_are() {
    let first =
        include_str!("../../../../schema/signals.yaml").lines().position(|l| l.ends_with("name: ego.speed"));
    let first = first.unwrap() + 1;
    // The change, the code, and the line below that of the name.
    let cases = [
        ("unit: m/s", "unit: furlong", "signals.type", 4),
        ("scale: 5.0", "scale: -1", "signals.type", 5),
        ("    scale: 5.0\n", "", "signals.type", 3),
        ("scope: frame", "scope: world", "signals.type", 2),
        ("type: number", "type: figure", "signals.type", 3),
        ("needs: [ego pose]", "needs: [luck]", "signals.needs", 7),
        ("type: number", "type: flag", "signals.changed", 3),
        ("scope: frame", "scope: target", "signals.changed", 2),
        ("unit: m/s", "unit: m", "signals.changed", 4),
        ("needs: [ego pose]", "needs: [map]", "signals.changed", 7),
        ("scale: 5.0", "scale: 5.0\n    aliases: [ego.accel]", "signals.name", 0),
        ("unit: m/s", "units: m/s", "signals.field.unknown", 4),
        ("    scope: frame\n", "", "signals.field.missing", 0),
        ("needs: [ego pose]", "needs: ego pose", "signals.field.type", 7),
        ("unit: m/s", "unit: m/s\n    unit: m/s", "signals.field.duplicate", 5),
    ];
    for (from, to, code, below) in cases {
        let (catalog, found) = changed(SPEED, &SPEED.replacen(from, to, 1));
        let at: Vec<_> = found.iter().map(|d| (d.code, d.location.line)).collect();
        assert_eq!(at, [(code, Some(first + below))], "{from} -> {to}: {found:#?}");
        assert_eq!(found[0].location.file.as_deref(), Some("schema/signals.yaml"));
        assert!(catalog.get("ego.speed").is_none(), "{to}: a broken entry is left out");
        assert!(catalog.get("ego.jerk").is_some(), "the others are kept");
        assert!(catalog.lacks("ego.speed") && !catalog.lacks("ego.jerk") && !catalog.lacks("ego.sped"));
    }
    let (_, found) = changed("values: [straight, left, right, uturn]", "values: [straight, left, right]");
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["signals.changed"]);
    assert_eq!(Catalog::parse("signals: [").1[0].code, "signals.syntax");
}

#[test]
fn an_unknown_name_is_reported_with_the_nearest_and_the_missing_one() {
    let (_, found) = changed("name: ego.speed", "name: ego.sped");
    let codes: Vec<_> = found.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["signals.unknown", "signals.missing"]);
    assert_eq!(found[0].hint.as_ref().unwrap().en, "did you mean 'ego.speed'?");
    assert!(found[1].message.en.contains("'ego.speed'"), "{:?}", found[1]);
}

#[test]
fn a_folder_may_change_meaning_unit_scale_aliases_and_source() {
    let speed = SPEED.replacen("unit: m/s", "unit: km/h", 1).replacen(
        "scale: 5.0",
        "scale: 36\n    aliases: [ego.v]",
        1,
    );
    let (catalog, found) = changed(SPEED, &speed);
    assert!(found.is_empty(), "{found:#?}");
    let def = catalog.get("ego.v").unwrap();
    assert_eq!(def.id, SignalId::EgoSpeed);
    // 36 km/h are 10 m/s.
    assert!((def.scale - 10.0).abs() < 1e-9);
    assert_eq!(def.displayed(10.0).unwrap().text(1), "36 km/h");
}

#[test]
fn an_angle_is_displayed_in_degrees() {
    let sight = Catalog::bundled().get("map.sight_angle").unwrap();
    assert_eq!((sight.kind.clone(), sight.unit_symbol()), (SignalKind::Number(Dimension::Angle), "deg"));
    // Half a turn is pi rad.
    assert_eq!(sight.displayed(std::f64::consts::PI).unwrap().text(1), "180 deg");
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
fn the_page_is_as_the_catalog_says() {
    let path = format!("{}/../../docs/reference/signals.md", env!("CARGO_MANIFEST_DIR"));
    let written = std::fs::read_to_string(&path).unwrap();
    let stale = "docs/reference/signals.md is stale: run `whyroad taxonomy docs`";
    assert!(written == Catalog::bundled().page(), "{stale}");
}
