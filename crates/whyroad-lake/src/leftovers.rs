//! What a killed process left partly written (`.new-<pid>-<drive>`, `.signals.<n>-<pid>-<drive>`, files such as
//! `.found.json-<pid>-<drive>`), moved aside (`.old-<pid>-<drive>`) or had not yet removed (`.gone-<pid>-<drive>`),
//! in a folder beside the drives: among them, it would be read by other tools' patterns (`drives/*/tracks.parquet`).

use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// What was touched more recently is left alone: a lake on shared storage may be written from another machine or
/// container, whose processes cannot be seen from here.
const QUIET: Duration = Duration::from_secs(600);

/// The folder beside `drives` that has what is being written; it need not exist.
pub(crate) const UNFINISHED: &str = "unfinished";
/// Where leftovers are: earlier builds wrote among the drives.
pub(crate) const FOLDERS: [&str; 2] = [UNFINISHED, "drives"];

/// Removes half-written drives, signals and files whose process is gone. A drive that was moved aside for a replacement
/// that was never completed is restored. Where processes cannot be looked up (no `/proc`) nothing is done; what cannot
/// be removed stays, as it harms no reader.
pub(crate) fn remove(lake: &Path) {
    if !Path::new("/proc/self").exists() {
        return;
    }
    for entry in FOLDERS.iter().flat_map(|name| fs::read_dir(lake.join(name))).flatten().flatten() {
        let name = entry.file_name();
        let Some((kind, pid, drive)) = name.to_str().and_then(parts) else { continue };
        let path = entry.path();
        if Path::new("/proc").join(pid.to_string()).exists() || !is_quiet(&path) {
            continue;
        }
        let target = lake.join("drives").join(drive);
        let _ = match kind {
            // A drive that is in a pack, too, is restored as a loose one, which overrides the pack.
            "old" if !target.exists() => fs::rename(&path, &target),
            _ if path.is_dir() => fs::remove_dir_all(&path),
            _ => fs::remove_file(&path),
        };
    }
}

/// Kind, process id and drive of a name such as `.new-4711-drive`.
fn parts(name: &str) -> Option<(&str, u32, &str)> {
    let (kind, rest) = name.strip_prefix('.')?.split_once('-')?;
    let (pid, drive) = rest.split_once('-')?;
    (is_ours(kind) && !drive.is_empty()).then_some((kind, pid.parse().ok()?, drive))
}

/// What [`Lake::aside`](crate::Lake) is called with: a folder of a drive or of its signals, or a file in it.
fn is_ours(kind: &str) -> bool {
    matches!(kind, "new" | "old" | "gone" | "signals")
        || kind.starts_with("signals.")
        || kind.ends_with(".json")
        || kind.ends_with(".parquet")
}

fn is_quiet(path: &Path) -> bool {
    let touched = fs::metadata(path).and_then(|m| m.modified());
    touched.is_ok_and(|t| SystemTime::now().duration_since(t).is_ok_and(|age| age >= QUIET))
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use crate::{CompactionOptions, Lake};
    use std::fs::{self, File};
    use std::path::PathBuf;
    use std::time::{Duration, SystemTime};

    fn long_ago(minutes: u64) -> SystemTime {
        SystemTime::now() - Duration::from_secs(60 * minutes)
    }

    #[test]
    fn only_what_a_process_that_is_gone_left_long_ago_is_removed() {
        let dir = tempfile::tempdir().unwrap();
        let drives = Lake::create_or_open(dir.path()).unwrap().dir().join("drives");
        let unfinished = dir.path().join("unfinished");
        fs::create_dir(&unfinished).unwrap();
        // A process that has ended and been waited for: its id names no process.
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let gone = child.id();
        child.wait().unwrap();
        let here = std::process::id();
        let make = |name: String, minutes: u64| -> PathBuf {
            let path = unfinished.join(name);
            fs::create_dir_all(&path).unwrap();
            fs::write(path.join("tracks.parquet"), "half").unwrap();
            File::open(&path).unwrap().set_modified(long_ago(minutes)).unwrap();
            path
        };
        let kept = [
            make(format!(".new-{here}-a"), 60),
            make(format!(".signals-{here}-a-drive"), 60),
            make(format!(".signals-{gone}-recent"), 1),
            make(format!(".new-{gone}-recent"), 1),
            make("../drives/a-drive".into(), 60),
            make(".new-x-b".into(), 60),
            // Somebody's own, although it has the form.
            make(format!(".backup-{gone}-11-30"), 60),
        ];
        let file = unfinished.join(format!(".found.json-{gone}-a-drive"));
        fs::write(&file, "half").unwrap();
        File::options().append(true).open(&file).unwrap().set_modified(long_ago(60)).unwrap();
        let removed = [
            make(format!(".new-{gone}-b-c"), 60),
            // Of an earlier build.
            make(format!("../drives/.new-{gone}-b-c"), 60),
            make(format!(".old-{gone}-a-drive"), 60),
            make(format!(".signals-{gone}-a-drive"), 60),
            file,
        ];
        let put_away = make(format!(".old-{gone}-lost"), 60);
        // Opening to read changes nothing.
        Lake::open(dir.path()).unwrap();
        assert!(removed.iter().chain([&put_away]).all(|p| p.exists()));
        Lake::create_or_open(dir.path()).unwrap();
        assert!(kept.iter().all(|p| p.exists()));
        assert!(removed.iter().chain([&put_away]).all(|p| !p.exists()));
        assert!(drives.join("lost/tracks.parquet").exists(), "a drive put away comes back");
        // So does compaction, which opens the lake as readers do.
        let left = make(format!(".new-{gone}-b-c"), 60);
        Lake::open(dir.path()).unwrap().compact(&CompactionOptions::default(), |_, _| ()).unwrap();
        assert!(!left.exists());
    }
}
