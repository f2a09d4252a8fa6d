//! States the version of how results are written down: a hash of the code that does it. The ledger of a mined folder is
//! then not relied on when another version wrote it, without anybody having to remember to count a number up.

use std::path::{Path, PathBuf};

/// All files below a folder, sorted.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.to_owned()] };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    paths.iter().flat_map(|p| files(p)).collect()
}

fn main() {
    let sources = [
        "src/again.rs",
        "src/mine.rs",
        "src/objects.rs",
        "src/output",
        "../whyroad-lake/src/clips.rs",
        "../whyroad-lake/src/mined",
        "../whyroad-mining/src/drive.rs",
        "../whyroad-mining/src/rule",
    ];
    // FNV-1a, 64 bits: not against forgers, only against forgetting.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for source in sources {
        println!("cargo:rerun-if-changed={source}");
        for byte in files(Path::new(source)).iter().flat_map(|f| std::fs::read(f).unwrap_or_default()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("cargo:rustc-env=WHYROAD_ENGINE_VERSION={hash:016x}");
}
