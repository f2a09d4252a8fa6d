//! States the version of how rules are judged: a hash of the code that does it. What a lake keeps of what an
//! older version found is then not used again, without anybody having to remember to count a number up.

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
        "src/comparison.rs",
        "src/deviation.rs",
        "src/interpret",
        "src/interpret.rs",
        "src/fast",
        "src/episode",
        "src/episode.rs",
        "src/language",
    ];
    // FNV-1a, 64 bits: not against forgers, only against forgetting.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for source in sources {
        println!("cargo:rerun-if-changed={source}");
        for byte in files(Path::new(source)).iter().flat_map(|f| std::fs::read(f).unwrap_or_default()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("cargo:rustc-env=WHYROAD_MINING_VERSION={hash:016x}");
}
