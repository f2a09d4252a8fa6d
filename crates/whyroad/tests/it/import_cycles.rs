//! Files of a crate do not import each other in a circle, and the stages of whyroad-signals are only imported forward.
//!
//! An import is a `use` of a path that begins with `crate`, `super` or `self`, or with a module of the file, outside
//! tests. A parent module that re-exports its child (`pub use`) does not thereby depend on it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Circles that are allowed for now: crate and one file of each. Must stay empty.
const ALLOWED: &[(&str, &str)] = &[];

/// The stages of whyroad-signals, each of which may import only those before it and itself.
const STAGES: &[&str] = &[
    "geometry",
    "series",
    "estimate",
    "catalog",
    "needs",
    "wanted",
    "table",
    "ego",
    "road",
    "target",
    "conflict",
    "behavior",
    "refav",
    "sight",
    "object",
    "derive",
    "occluders",
];

/// Module path (`["check", "rules"]`) and source of each file of a crate; tests are left out.
fn modules(src: &Path) -> BTreeMap<Vec<String>, String> {
    let mut out = BTreeMap::new();
    let mut folders: Vec<PathBuf> = vec![src.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && name != "tests" {
                folders.push(path);
            } else if name.ends_with(".rs") && name != "tests.rs" {
                let relative = path.strip_prefix(src).unwrap().with_extension("");
                let mut module: Vec<String> =
                    relative.iter().map(|p| p.to_string_lossy().into_owned()).collect();
                if matches!(module.last().unwrap().as_str(), "mod" | "lib" | "main") {
                    module.pop();
                }
                out.insert(module, std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    out
}

/// A source without comments and without its inline test module.
fn code(source: &str) -> String {
    let lines = source.lines().map(|l| l.split("//").next().unwrap_or(""));
    let text = lines.collect::<Vec<_>>().join("\n");
    text.split("#[cfg(test)]\nmod ").next().unwrap_or("").to_owned()
}

/// The paths of a use tree: `a::{b, c::d as e}` is `a::b` and `a::c::d`.
fn paths(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((head, body)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or("").trim().to_owned()];
    };
    let body = body.strip_suffix('}').unwrap_or(body);
    let (mut depth, mut part, mut parts) = (0, String::new(), Vec::new());
    for c in body.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
    }
    parts.push(part);
    let parts = parts.iter().filter(|p| !p.trim().is_empty());
    parts.flat_map(|p| paths(&format!("{head}{}", p.trim()))).collect()
}

/// The uses of a source: whether public, and the path.
fn uses(source: &str) -> Vec<(bool, String)> {
    let mut out = Vec::new();
    for statement in code(source).split(';') {
        let line = statement.rfind("use ").filter(|&at| {
            let before = statement[..at].trim_end();
            let word = before.rsplit(char::is_whitespace).next().unwrap_or("");
            before.is_empty() || before.ends_with(['{', '}', ']']) || word.starts_with("pub")
        });
        let Some(at) = line else { continue };
        let before = statement[..at].trim_end();
        let public = before.rsplit(char::is_whitespace).next().is_some_and(|w| w.starts_with("pub"));
        let tree = statement[at + 4..].split_whitespace().collect::<Vec<_>>().join(" ");
        out.extend(paths(&tree).into_iter().map(|p| (public, p)));
    }
    out
}

/// The file that `path`, used in `module`, leads to: the longest prefix that is a file of the crate.
fn target(path: &str, module: &[String], files: &BTreeMap<Vec<String>, String>) -> Option<Vec<String>> {
    let mut parts: Vec<&str> = path.split("::").collect();
    let mut base: Vec<String> = module.to_vec();
    let rooted = matches!(parts[0], "crate" | "super" | "self");
    if parts[0] == "crate" {
        base.clear();
        parts.remove(0);
    }
    while matches!(parts.first(), Some(&("super" | "self"))) {
        if parts.remove(0) == "super" {
            base.pop();
        }
    }
    let full: Vec<String> = base.iter().cloned().chain(parts.iter().map(|p| (*p).to_owned())).collect();
    let found = (0..=full.len()).rev().map(|n| full[..n].to_vec()).find(|m| files.contains_key(m))?;
    // `use std::...` leads to no file below this one.
    (rooted || found.len() > module.len()).then_some(found)
}

type Imports = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

fn imports(src: &Path) -> Imports {
    let files = modules(src);
    let mut out = Imports::new();
    for (module, source) in &files {
        let found = out.entry(module.clone()).or_default();
        for (public, path) in uses(source) {
            let Some(to) = target(&path, module, &files) else { continue };
            if to != *module && !(public && to.starts_with(module)) {
                found.insert(to);
            }
        }
    }
    out
}

/// All files that can be reached from `from`.
fn reached(from: &[String], imports: &Imports) -> BTreeSet<Vec<String>> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from.to_vec()];
    while let Some(module) = open.pop() {
        for next in imports.get(&module).into_iter().flatten() {
            if seen.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    seen
}

/// Groups of files that import each other in a circle.
fn circles(imports: &Imports) -> Vec<Vec<String>> {
    let all: BTreeMap<_, _> = imports.keys().map(|m| (m, reached(m, imports))).collect();
    let mut grouped: BTreeSet<&Vec<String>> = BTreeSet::new();
    let mut out = Vec::new();
    for (module, to) in all.iter().filter(|(m, to)| to.contains(**m)) {
        if grouped.contains(module) {
            continue;
        }
        let group: Vec<&Vec<String>> =
            to.iter().filter(|t| all.get(t).is_some_and(|back| back.contains(*module))).collect();
        out.push(group.iter().map(|m| m.join("::")).collect());
        grouped.extend(all.keys().filter(|k| group.contains(*k)));
    }
    out
}

fn crates() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut names: Vec<String> = std::fs::read_dir(crates())
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|n| crates().join(n).join("src").is_dir())
        .collect();
    names.sort();
    assert!(names.len() >= 13, "every crate is here: {names:?}");
    let (mut left, mut used) = (Vec::new(), BTreeSet::new());
    for name in &names {
        let imports = imports(&crates().join(name).join("src"));
        let count: usize = imports.values().map(BTreeSet::len).sum();
        assert!(count > 0 || imports.len() < 5, "{name}: no import was found in {} files", imports.len());
        for circle in circles(&imports) {
            match ALLOWED.iter().find(|(of, file)| of == name && circle.iter().any(|m| m == file)) {
                Some(entry) => {
                    used.insert(*entry);
                }
                None => left.push(format!("{name}: {}", circle.join(", "))),
            }
        }
    }
    assert!(left.is_empty(), "files that import each other:\n{}", left.join("\n"));
    let gone: Vec<_> = ALLOWED.iter().filter(|entry| !used.contains(*entry)).collect();
    assert!(gone.is_empty(), "no circle any more, remove from the list: {gone:?}");
}

#[test]
fn stages_of_the_signals_are_imported_forward_only() {
    let imports = imports(&crates().join("whyroad-signals/src"));
    let stage = |m: &[String]| STAGES.iter().position(|s| m.first().is_some_and(|f| f == s));
    let mut checked = 0;
    for (from, all) in imports.iter().filter(|(m, _)| !m.is_empty()) {
        let own = stage(from).unwrap_or_else(|| panic!("{from:?} is not in the list of stages"));
        for to in all {
            let theirs = stage(to).unwrap_or_else(|| panic!("{from:?} imports {to:?}"));
            assert!(theirs <= own, "{} imports {} of a later stage", from.join("::"), to.join("::"));
            checked += 1;
        }
    }
    assert!(checked > 200, "{checked} imports were checked");
}

#[test]
fn a_circle_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    file("lib.rs", "//! use crate::b;\nmod a;\npub mod b;\npub use b::X;\n");
    file("a.rs", "mod child;\npub use child::C;\nuse crate::b::{X, Y as Z};\npub struct A;\n");
    file("a/child.rs", "use super::A;\nuse std::fmt;\npub struct C;\n");
    file("b.rs", "mod c;\npub struct X;\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\n");
    file("b/c.rs", "use super::X;\n");
    assert!(circles(&imports(dir.path())).is_empty(), "{:?}", imports(dir.path()));
    file("b/c.rs", "use super::X;\nuse crate::{\n    a::A,\n};\n");
    file("b.rs", "mod c;\nuse c::D;\npub struct X;\n");
    assert_eq!(circles(&imports(dir.path())), [["a", "b", "b::c"]]);
}
