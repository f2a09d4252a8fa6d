//! What the files of a simulation are called, and which lie beside a log.

use crate::encodings::compressed::without_ending;
use crate::source::file_label;
use std::fs;
use std::path::{Path, PathBuf};

/// `...fcd....xml`, `...net.xml.gz` and the like.
pub(super) fn is_named(path: &Path, word: &str, ending: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let stem = without_ending(&name).strip_suffix(ending);
    stem.is_some_and(|s| s.split(['.', '_', '-']).any(|part| part == word))
}

/// Files beside `fcd`, and in the folder above, that are named `word`.
pub(super) fn beside(fcd: &Path, words: &[&str]) -> Vec<PathBuf> {
    let near = fcd.parent().into_iter().chain(fcd.parent().and_then(Path::parent));
    let mut out = Vec::new();
    for dir in near {
        let Ok(entries) = fs::read_dir(dir) else { continue };
        let mut here: Vec<PathBuf> = entries
            .flatten()
            .map(|e| e.path())
            .filter(|p| p.is_file() && words.iter().any(|w| is_named(p, w, ".xml")))
            .collect();
        here.sort();
        out.extend(here);
    }
    out
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
