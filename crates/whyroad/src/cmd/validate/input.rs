//! Where documents come from: files, folders, standard input. Reads in chunks; holds one document at a time.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use whyroad_framework::check::{Layout, Piece, Splitter};

/// Bytes read at a time; also what the layout is guessed from.
const CHUNK: usize = 1 << 18;

/// One thing to read.
pub(super) enum Source {
    /// A file, or standard input where there is no path.
    File { name: String, path: Option<PathBuf>, how: How },
    /// A folder without any JSON in it.
    Nothing { name: String },
    /// An input that could not be opened.
    Unreadable { name: String, error: io::Error },
}

/// Why a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    /// The user named it, so everything in it is checked.
    Named,
    /// It was found in a folder, which may contain JSON of other programs.
    InFolder,
}

/// All sources that the arguments name, folders opened, sorted within each.
pub(super) struct Sources;

impl Sources {
    pub fn of(paths: &[PathBuf]) -> Vec<Source> {
        let mut out = Vec::new();
        for path in paths {
            let name = path.display().to_string();
            if path == Path::new("-") {
                out.push(Source::File { name: "<stdin>".to_owned(), path: None, how: How::Named });
                continue;
            }
            match fs::metadata(path) {
                Ok(m) if m.is_dir() => {
                    let before = out.len();
                    folder(path, &mut out);
                    if out.len() == before {
                        out.push(Source::Nothing { name });
                    }
                }
                Ok(_) => out.push(Source::File { name, path: Some(path.clone()), how: How::Named }),
                Err(error) => out.push(Source::Unreadable { name, error }),
            }
        }
        out
    }
}

fn folder(dir: &Path, out: &mut Vec<Source>) {
    let entries = fs::read_dir(dir).and_then(|entries| entries.collect::<io::Result<Vec<_>>>());
    let mut entries = match entries {
        Ok(entries) => entries,
        Err(error) => return out.push(Source::Unreadable { name: dir.display().to_string(), error }),
    };
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        match entry.file_type() {
            // A link to a folder may lead back up, so folders are entered by their own name only.
            Ok(t) if t.is_dir() => folder(&path, out),
            Ok(_) if is_json(&path) => {
                let name = path.display().to_string();
                out.push(Source::File { name, path: Some(path), how: How::InFolder });
            }
            Ok(_) => {}
            Err(error) => out.push(Source::Unreadable { name: path.display().to_string(), error }),
        }
    }
}

fn is_json(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["json", "jsonl", "ndjson"].iter().any(|e| extension.eq_ignore_ascii_case(e))
}

/// Passes the pieces of a file (of standard input where there is no path) to `sink` until it returns false.
pub(super) fn pieces(path: Option<&Path>, sink: &mut dyn FnMut(Piece<'_>) -> bool) -> io::Result<()> {
    let mut reader: Box<dyn Read> = match path {
        Some(path) => Box::new(File::open(path)?),
        None => Box::new(io::stdin().lock()),
    };
    let mut chunk = vec![0; CHUNK];
    let mut go_on = true;
    let mut n = fill(&mut *reader, &mut chunk)?;
    let mut splitter = Splitter::new(Layout::guess(&chunk[..n]));
    while n > 0 && go_on {
        splitter.feed(&chunk[..n], &mut |piece| go_on = go_on && sink(piece));
        n = fill(&mut *reader, &mut chunk)?;
    }
    if go_on {
        splitter.finish(&mut |piece| go_on = go_on && sink(piece));
    }
    Ok(())
}

/// Reads until the buffer is full or the input ends; pipes return less than requested.
fn fill(reader: &mut dyn Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut n = 0;
    while n < buffer.len() {
        match reader.read(&mut buffer[n..]) {
            Ok(0) => break,
            Ok(more) => n += more,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(n)
}
