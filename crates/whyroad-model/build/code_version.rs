//! The version of code, for build scripts: a hash of its files. What was stored by another version is then not used
//! again, without anybody having to remember to count a number up.

use std::path::{Path, PathBuf};

/// Hash of files and of all files below folders, by their paths from the crate's folder; asks cargo to run the build
/// script again when one of them changes.
pub fn of(sources: &[&str]) -> String {
    // FNV-1a, 64 bits: not against forgers, only against forgetting.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for source in sources {
        println!("cargo:rerun-if-changed={source}");
        for byte in files(Path::new(source)).iter().flat_map(|f| std::fs::read(f).unwrap_or_default()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}")
}

/// All files below a folder, sorted.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.to_owned()] };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    paths.iter().flat_map(|p| files(p)).collect()
}
