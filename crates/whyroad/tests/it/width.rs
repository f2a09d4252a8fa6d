//! Prose is at most 120 columns wide: Markdown, and comments in Rust, TypeScript and YAML. A Chinese character takes
//! two columns. Tables, code blocks and lines that are one link or one word are excepted.

use std::path::{Path, PathBuf};
use whyroad_framework::docs::wrap::{WIDTH, columns};

/// The last three are what our own commands make (see `.gitignore`).
const SKIPPED: &[&str] = &[
    "target",
    "node_modules",
    "dist",
    "assets",
    "generated",
    "snapshots",
    "out",
    "whyroad-data",
    "whyroad-demo",
];

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if !path.is_dir() {
            out.push(path);
        } else if !name.starts_with('.') && !SKIPPED.contains(&name.as_str()) {
            files(&path, out);
        }
    }
}

/// The text of a line that is a comment and nothing else.
fn comment<'a>(line: &'a str, marks: &[&str]) -> Option<&'a str> {
    let line = line.trim_start();
    marks.iter().find_map(|mark| line.strip_prefix(mark)).map(str::trim)
}

/// Whether nothing could be moved to the next line: one word, one link, one image.
fn is_one_piece(text: &str) -> bool {
    let text = text
        .trim()
        .trim_start_matches(['-', '*', '>', ' '])
        .trim_end_matches(['.', ',', ':', ';', '。', '，']);
    let link = (text.starts_with('[') || text.starts_with("![")) && text.ends_with(')');
    !text.contains(' ') && text.is_ascii() || link && text.matches("](").count() == 1
}

/// Numbers of the lines that are too wide; `marks` begin a comment, and without any all of the text is prose.
fn too_wide(text: &str, marks: &[&str]) -> Vec<usize> {
    let mut fenced = false;
    let mut out = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let prose = if marks.is_empty() { Some(line.trim()) } else { comment(line, marks) };
        let Some(prose) = prose else { continue };
        if prose.starts_with("```") {
            fenced = !fenced;
        } else if !fenced && !prose.starts_with('|') && columns(line) > WIDTH && !is_one_piece(prose) {
            out.push(i + 1);
        }
    }
    out
}

#[test]
fn prose_is_at_most_120_columns_wide() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let mut all = Vec::new();
    files(&root, &mut all);
    let (mut found, mut checked) = (Vec::new(), 0);
    for path in all {
        let marks: &[&str] = match path.extension().and_then(|e| e.to_str()) {
            Some("md") => &[],
            Some("rs") => &["///", "//!", "//"],
            Some("ts" | "mjs") => &["//", "/**", "*"],
            Some("yaml" | "yml") => &["#"],
            _ => continue,
        };
        checked += 1;
        let name = path.strip_prefix(&root).unwrap().display().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        found.extend(too_wide(&text, marks).into_iter().map(|line| format!("{name}:{line}")));
    }
    assert!(found.is_empty(), "{} lines are wider than {WIDTH} columns:\n{}", found.len(), found.join("\n"));
    assert!(checked > 1000, "only {checked} files were checked");
}

#[test]
fn what_is_too_wide_is_found() {
    let wide = "word ".repeat(25);
    let link = format!("[{wide}](page.md)");
    let text =
        format!("{wide}\n| {wide} |\n```\n{wide}\n```\n{link}\n{}\n{}\n", "x".repeat(130), "宽".repeat(61));
    assert_eq!(too_wide(&text, &[]), [1, 8]);
    assert_eq!(too_wide(&format!("let x = 1; // {wide}\n    /// {wide}\n# {wide}\n"), &["///", "//"]), [2]);
}
