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
