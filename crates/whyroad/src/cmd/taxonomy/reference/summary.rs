//! The generated lists in the book's `SUMMARY.md`: leaves by L2 in both languages, formats, and diagnostics.

use super::{formats, generated};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_framework::Framework;

/// `summary` with its lists brought up to date, from the texts of the pages of diagnostics and formats by name; the
/// error states what is wrong. The lists and their markers are indented: they belong to the list item above them.
pub(in crate::cmd::taxonomy) fn fill(
    summary: &str,
    framework: &Framework,
    diagnostics: &BTreeMap<String, String>,
    formats: &BTreeMap<String, String>,
) -> Result<String, String> {
    let lists = [
        ("leaves", leaves(framework)),
        ("formats", formats::summary_lines(formats)?),
        ("diagnostics", codes(diagnostics)),
    ];
    lists.iter().try_fold(summary.to_owned(), |text, (name, list)| generated::fill(&text, name, list))
}

fn leaves(framework: &Framework) -> String {
    let mut out = String::new();
    for (l1, l2, l3) in framework.taxonomy.leaves() {
        let id = format!("{}.{}.{}", l1.id, l2.id, l3.id);
        let _ = writeln!(out, "  - [{}.{}](reference/leaves/{id}.md)", l2.id, l3.id);
        let _ = writeln!(out, "    - [{}](reference/leaves/{id}.zh.md)", l3.name.zh);
    }
    out
}

fn codes(pages: &BTreeMap<String, String>) -> String {
    pages.keys().map(|code| format!("  - [{code}](diagnostics/{code}.md)\n")).collect()
}
