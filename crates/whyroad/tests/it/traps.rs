//! `docs/reference/traps.md` names the tests that hold the known traps of the field: each must exist.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use std::path::Path;

fn sources(dir: &Path, out: &mut String) {
    for entry in std::fs::read_dir(dir).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            *out += &std::fs::read_to_string(&path).unwrap();
        }
    }
}

#[test]
fn every_trap_has_its_tests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/reference/traps.md")).unwrap();
    let mut code = String::new();
    sources(&root.join("crates"), &mut code);
    let cases =
        std::fs::read_to_string(root.join("scenarios/reactive_rule/traffic_light.cases.yaml")).unwrap();
    let mut traps = 0;
    for row in page.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| trap")) {
        let (_, tests) = row.trim_end_matches(" |").rsplit_once(" | ").unwrap();
        traps += 1;
        let mut named = 0;
        for name in tests.split('`').skip(1).step_by(2) {
            let found = if name.contains(' ') {
                cases.contains(&format!("name: {name}"))
            } else {
                code.contains(&format!("#[test]\nfn {name}()"))
                    || code.contains(&format!("#[test]\n    fn {name}("))
            };
            assert!(found, "{name} of {row}");
            named += 1;
        }
        assert!(named > 0, "{row}");
    }
    // DESIGN.md "Known traps" names 28 when its sentences are taken apart.
    assert_eq!(traps, 28);
}
