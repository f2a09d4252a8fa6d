//! The book in `docs/`: `SUMMARY.md` lists every page, every link resolves, and guides come in both languages.
//! What is checked is the text itself, so neither mdBook nor a network is needed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Files with `extension` in `folder` and below it.
fn files(folder: &Path, extension: &str, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() && !name.starts_with('.') && !["target", "node_modules"].contains(&name) {
            files(&path, extension, out);
        } else if path.extension().is_some_and(|e| e == extension) {
            out.push(path);
        }
    }
}

fn markdown(folders: &[&str]) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for folder in folders {
        files(&root().join(folder), "md", &mut out);
    }
    out.sort();
    out
}

/// Lines outside fenced code blocks, numbered from 1.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut out = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            out.push((i + 1, line));
        }
    }
    out
}

/// A line without its inline code, in which a bracket is no link.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("``")
}

/// Targets of the links and images of a line.
fn links(line: &str) -> Vec<String> {
    let line = without_code(line);
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next()).map(str::to_owned).collect()
}

/// The anchor of a heading, as GitHub and mdBook both form it.
fn slug(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    let mut out = BTreeSet::new();
    let mut seen = BTreeMap::<String, usize>::new();
    for (_, line) in prose(text) {
        if let Some(heading) = line.strip_prefix('#') {
            let heading = slug(heading.trim_start_matches('#'));
            let n = seen.entry(heading.clone()).or_default();
            out.insert(if *n == 0 { heading } else { format!("{heading}-{n}") });
            *n += 1;
        }
        out.extend(line.split("<a id=\"").skip(1).filter_map(|r| r.split('"').next()).map(str::to_owned));
    }
    out
}

/// `path` without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    out
}

#[test]
fn every_link_resolves() {
    let root = root();
    let mut pages = markdown(&["docs", "examples"]);
    for entry in std::fs::read_dir(&root).unwrap() {
        let path = entry.unwrap().path();
        pages.extend(path.extension().is_some_and(|e| e == "md").then_some(path));
    }
    let mut anchors_of = BTreeMap::<PathBuf, BTreeSet<String>>::new();
    let (mut broken, mut checked) = (Vec::new(), 0);
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for (number, line) in prose(&text) {
            for link in links(line) {
                if link.contains("://") || link.starts_with("mailto:") {
                    continue;
                }
                checked += 1;
                let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
                let target =
                    if path.is_empty() { page.clone() } else { normal(&page.parent().unwrap().join(path)) };
                let mut found = target.exists();
                if found && !anchor.is_empty() && target.extension().is_some_and(|e| e == "md") {
                    let known = anchors_of
                        .entry(target.clone())
                        .or_insert_with(|| anchors(&std::fs::read_to_string(&target).unwrap()));
                    found = known.contains(anchor);
                }
                if !found {
                    broken.push(format!("{}:{number}: {link}", page.strip_prefix(&root).unwrap().display()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{} broken links:\n{}", broken.len(), broken.join("\n"));
    assert!(checked > 500, "only {checked} links were checked");
}

#[test]
fn the_summary_lists_every_page_once() {
    let docs = root().join("docs");
    let text = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed: Vec<String> = text.lines().flat_map(links).filter(|l| !l.is_empty()).collect();
    let once: BTreeSet<&str> = listed.iter().map(String::as_str).collect();
    assert_eq!(once.len(), listed.len(), "a page is listed twice");
    let pages = markdown(&["docs"]);
    let pages: BTreeSet<&str> =
        pages.iter().map(|p| p.strip_prefix(&docs).unwrap().to_str().unwrap()).collect();
    let there: BTreeSet<&str> = pages.into_iter().filter(|p| *p != "SUMMARY.md").collect();
    let missing: Vec<_> = there.difference(&once).collect();
    let absent: Vec<_> = once.difference(&there).collect();
    assert!(missing.is_empty() && absent.is_empty(), "not listed: {missing:?}\nno such page: {absent:?}");
}

#[test]
fn pages_that_people_work_by_are_in_both_languages() {
    let docs = root().join("docs");
    for folder in ["tutorial", "how-to"] {
        let pages = markdown(&[&format!("docs/{folder}")]);
        assert!(!pages.is_empty(), "{folder}");
        for page in pages {
            let name = page.strip_prefix(&docs).unwrap().to_str().unwrap().to_owned();
            let stem = name.strip_suffix(".md").unwrap();
            let other = stem.strip_suffix(".zh").map_or(format!("{stem}.zh.md"), |s| format!("{s}.md"));
            assert!(docs.join(&other).is_file(), "{name} has no {other}");
            let text = std::fs::read_to_string(&page).unwrap();
            let file = other.rsplit('/').next().unwrap();
            assert!(text.contains(&format!("({file})")), "{name} does not link to {other}");
        }
    }
}

#[test]
fn the_checks_can_fail() {
    assert_eq!(slug("2.1 纵向 Longitudinal"), "21-纵向-longitudinal");
    assert_eq!(slug("av2: Argoverse 2 sensor logs"), "av2-argoverse-2-sensor-logs");
    let page = "# A\n\n## Same\n\n```\n# not a heading\n```\n\n## Same\n\n<a id=\"x\"></a>\n";
    assert_eq!(anchors(page).into_iter().collect::<Vec<_>>(), ["a", "same", "same-1", "x"]);
    assert_eq!(links("[a](b.md#c), `[no](link)` and ![d](e.png)"), ["b.md#c", "e.png"]);
    assert_eq!(normal(Path::new("/a/b/../c/./d")), Path::new("/a/c/d"));
}

#[test]
fn every_format_has_a_page() {
    let folder = root().join("docs/formats");
    let pages: BTreeSet<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_str().unwrap().trim_end_matches(".md").to_owned())
        .collect();
    let formats: BTreeSet<String> =
        whyroad_ingest::formats::ALL.iter().map(|f| f.0.name().to_owned()).collect();
    assert_eq!(pages, formats);
}
