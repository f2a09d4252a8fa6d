//! Whether a file or the folder of a drive is still the one that was read: names, lengths, times and file numbers.

use std::fs::{self, Metadata};
use std::path::Path;
use std::time::UNIX_EPOCH;

/// The same as long as a file is not replaced; empty where it does not exist.
pub(crate) fn identity(file: &Path) -> String {
    fs::metadata(file).map(|data| of(&data)).unwrap_or_default()
}

/// The same as long as nothing in a drive's folder changes; and its size in bytes. Empty where it does not exist.
pub(super) fn folder(dir: &Path) -> (String, u64) {
    let (mut lines, mut bytes) = (Vec::new(), 0);
    collect(dir, "", &mut lines, &mut bytes);
    if lines.is_empty() {
        return (String::new(), 0);
    }
    lines.sort();
    let hash = blake3::hash(lines.join("\n").as_bytes()).to_hex();
    (hash.chars().take(32).collect(), bytes)
}

fn collect(dir: &Path, prefix: &str, lines: &mut Vec<String>, bytes: &mut u64) {
    for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        let Ok(data) = entry.metadata() else { continue };
        if data.is_dir() {
            lines.push(format!("{name}/"));
            collect(&entry.path(), &format!("{name}/"), lines, bytes);
        } else {
            *bytes += data.len();
            lines.push(format!("{name} {}", of(&data)));
        }
    }
}

fn of(data: &Metadata) -> String {
    let time = data.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
    let nanos = time.map_or(0, |t| t.as_nanos());
    format!("{} {nanos} {}", data.len(), number(data))
}

#[cfg(unix)]
fn number(data: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(data)
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> u64 {
    0
}
