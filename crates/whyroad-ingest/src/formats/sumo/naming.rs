//! What the files of a simulation are called, and which lie beside a log.

use crate::encodings::compressed::without_ending;
use crate::source::file_label;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// `...fcd....xml`, `...net.xml.gz` and the like.
pub(super) fn is_named(path: &Path, word: &str, ending: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let stem = without_ending(&name).strip_suffix(ending);
    stem.is_some_and(|s| s.split(['.', '_', '-']).any(|part| part == word))
}

/// The folder of a log and the one above, spelled as `own` is, so that a file beside the log has its parent. The parent
/// of a bare name is "", and that of `..` is not the folder above: these are asked of the system.
fn folders(own: &Path) -> Vec<PathBuf> {
    let is_name = matches!(own.components().next_back(), Some(Component::Normal(_)));
    let above = match own.parent().filter(|p| is_name && !p.as_os_str().is_empty()) {
        Some(above) => Some(above.to_owned()),
        None => real(own).canonicalize().ok().and_then(|p| Some(p.parent()?.to_owned())),
    };
    std::iter::once(own.to_owned()).chain(above).collect()
}

/// Files beside `fcd`, and in the folder above, that are named `word`.
pub(super) fn beside(fcd: &Path, words: &[&str]) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for dir in fcd.parent().map(folders).unwrap_or_default() {
        let Ok(entries) = fs::read_dir(real(&dir)) else { continue };
        let mut here: Vec<PathBuf> = entries
            .flatten()
            .map(|e| dir.join(e.file_name()))
            .filter(|p| p.is_file() && words.iter().any(|w| is_named(p, w, ".xml")))
            .collect();
        here.sort();
        out.extend(here);
    }
    out
}

/// A folder as the system opens it: the parent of a bare name is "".
fn real(dir: &Path) -> &Path {
    if dir.as_os_str().is_empty() { Path::new(".") } else { dir }
}

/// The name of a run: the file's without its endings, or the folder's when the file is just called `fcd`.
pub(super) fn run_name(path: &Path) -> String {
    let name = file_label(path);
    let stem = without_ending(&name);
    let stem = stem.strip_suffix(".xml").or_else(|| stem.strip_suffix(".csv")).unwrap_or(stem);
    // `crossroads.fcd.xml` is the run `crossroads`.
    let stem = [".fcd", "_fcd", "-fcd"].iter().find_map(|e| stem.strip_suffix(e)).unwrap_or(stem).to_owned();
    let folder = path.canonicalize().ok().and_then(|p| Some(file_label(p.parent()?)));
    if stem.eq_ignore_ascii_case("fcd") { folder.unwrap_or(stem) } else { stem }
}

/// A file that belongs to a log.
#[derive(Debug, PartialEq)]
pub(super) enum Companion {
    None,
    File(PathBuf),
    /// Several match, and their names do not decide.
    Several(Vec<PathBuf>),
}

/// The name without endings and without the parts that say what the file is: `town` of `town_fcd.xml.gz`.
fn base(path: &Path) -> String {
    let name = file_label(path).to_lowercase();
    let stem = without_ending(&name);
    let stem = stem.strip_suffix(".xml").or_else(|| stem.strip_suffix(".csv")).unwrap_or(stem);
    let parts = stem.split(['.', '_', '-']).filter(|p| !["fcd", "net", "tls", "lights"].contains(p));
    parts.collect::<Vec<_>>().join(".")
}

/// The file named `word` that belongs to `fcd`: of the same name; else the one whose name begins that of the log; else
/// the only one. Files beside the log take precedence over files in the parent folder.
pub(super) fn companion(fcd: &Path, word: &str) -> Companion {
    let own = base(fcd);
    let found = beside(fcd, &[word]);
    let (beside, above): (Vec<PathBuf>, Vec<PathBuf>) =
        found.into_iter().partition(|p| p.parent() == fcd.parent());
    for files in [beside, above] {
        let begins = |p: &PathBuf| {
            let name = base(p);
            !name.is_empty() && (own == name || own.starts_with(&format!("{name}.")))
        };
        let longest = files.iter().filter(|p| begins(p)).map(|p| base(p).len()).max();
        let mut named: Vec<PathBuf> =
            files.iter().filter(|p| begins(p) && Some(base(p).len()) == longest).cloned().collect();
        if named.is_empty() {
            named = files;
        }
        match named.len() {
            0 => {}
            1 => return Companion::File(named.swap_remove(0)),
            _ => return Companion::Several(named),
        }
    }
    Companion::None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(files: &[&str], fcd: &str, word: &str) -> Option<String> {
        let dir = tempfile::tempdir().unwrap();
        for file in files {
            let path = dir.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        match companion(&dir.path().join(fcd), word) {
            Companion::None => Some("none".into()),
            Companion::File(path) => Some(file_label(&path)),
            Companion::Several(_) => None,
        }
    }

    /// sumo.md: types beside the log or in the folder above. A relative name without a folder has the parent "".
    #[test]
    fn the_folder_above_a_bare_name_is_the_working_folder() {
        let here = Path::new("src");
        let log = |path: &str| here.join(path).join("fcd.xml");
        // Tests run in the folder of the crate: above `src`, and above `src/formats` given with dots, is a Cargo.toml.
        let found = |fcd: &Path| -> Vec<PathBuf> {
            let Some(own) = fcd.parent() else { return vec![] };
            folders(own).into_iter().map(|dir| real(&dir).canonicalize().unwrap()).collect()
        };
        let root = Path::new(".").canonicalize().unwrap();
        assert_eq!(found(&log("")), [root.join("src"), root.clone()]);
        assert_eq!(found(Path::new("fcd.xml")), [root.clone(), root.parent().unwrap().to_owned()]);
        assert_eq!(found(&log("..")), [root.clone(), root.parent().unwrap().to_owned()]);
        assert_eq!(found(&root.join("src/fcd.xml")), [root.join("src"), root]);
    }

    #[test]
    fn the_network_of_the_same_name_is_taken_and_two_others_are_refused() {
        let nets = ["runs/town.net.xml", "runs/motorway.net.xml.gz", "runs/x.fcd.xml"];
        assert_eq!(chosen(&nets, "runs/town.fcd.xml", "net").as_deref(), Some("town.net.xml"));
        assert_eq!(chosen(&nets, "runs/town_2.fcd.xml.gz", "net").as_deref(), Some("town.net.xml"));
        assert_eq!(chosen(&nets, "runs/motorway_fcd.csv", "net").as_deref(), Some("motorway.net.xml.gz"));
        assert_eq!(chosen(&nets, "runs/x.fcd.xml", "net"), None, "either could be meant");
        assert_eq!(chosen(&["a/fcd.xml", "net.xml"], "a/fcd.xml", "net").as_deref(), Some("net.xml"));
        assert_eq!(chosen(&["a/fcd.xml"], "a/fcd.xml", "net").as_deref(), Some("none"));
        let beside_first = ["a/one.net.xml", "two.net.xml", "a/fcd.xml"];
        assert_eq!(chosen(&beside_first, "a/fcd.xml", "net").as_deref(), Some("one.net.xml"));
    }
}
