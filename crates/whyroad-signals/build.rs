//! States the version of the signals: a hash of the code that derives them and of the catalogue. What a lake keeps of
//! an older version is then derived again, without anybody having to remember to count a number up.

use std::path::{Path, PathBuf};

/// All files below a folder, sorted.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.to_owned()] };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    paths.iter().flat_map(|p| files(p)).collect()
}

fn main() {
    let sources = ["src", "../whyroad-model/src", "../../schema/signals.yaml"];
    // FNV-1a, 64 bits: not against forgers, only against forgetting.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for source in sources {
        println!("cargo:rerun-if-changed={source}");
        for byte in files(Path::new(source)).iter().flat_map(|f| std::fs::read(f).unwrap_or_default()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("cargo:rustc-env=WHYROAD_SIGNALS_VERSION={hash:016x}");
}
