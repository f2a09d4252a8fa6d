use std::path::Path;

#[test]
fn every_code_has_a_page() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    for code in super::CODES {
        assert!(docs.join(format!("{code}.md")).is_file(), "{code} has no page");
    }
}
