//! The generated lists in the book's `SUMMARY.md`: leaves by L2 in both languages, and diagnostics.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use whyroad_framework::Framework;

/// Markers are indented, so that they stay inside the list item above them.
const END: &str = "  <!-- end generated -->";

/// `summary` with its lists brought up to date, or the marker that it lacks.
pub(in crate::cmd::taxonomy) fn fill(
    summary: &str,
    framework: &Framework,
    diagnostics: &BTreeMap<String, String>,
) -> Result<String, String> {
    let mut out = summary.to_owned();
    for (name, list) in [("leaves", leaves(framework)), ("diagnostics", codes(diagnostics))] {
        let marker = format!("  <!-- generated: {name} -->\n");
        let start = out.find(&marker).ok_or_else(|| marker.trim().to_owned())? + marker.len();
        let end = out[start..].find(END).ok_or_else(|| END.trim().to_owned())? + start;
        out.replace_range(start..end, &list);
    }
    Ok(out)
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
