//! The drives that are built into the program: `examples/drives`, simulated by us and free to distribute.

use crate::output::reason::{cannot_make, cannot_write};
use anyhow::Context as _;
use std::fs;
use std::path::{Path, PathBuf};

/// License of the built-in drives (`examples/drives/README.md`).
pub(super) const LICENCE: &str = "Apache-2.0";

macro_rules! drives {
    ($($path:literal),+ $(,)?) => {
        &[$(($path, include_bytes!(concat!("../../../../../examples/drives/", $path)))),+]
    };
}

/// Path below the folder, and content.
const FILES: &[(&str, &[u8])] = drives![
    "types.rou.xml",
    "signal_junction/fcd.xml.gz",
    "signal_junction/net.xml.gz",
    "signal_junction/tls.xml.gz",
    "multilane/fcd.xml.gz",
    "multilane/net.xml.gz",
    "back_street/fcd.xml.gz",
    "back_street/net.xml.gz",
];

/// Writes the drives into `dir`, as files that `whyroad ingest sumo` reads, and returns the folder.
pub(super) fn unpack(dir: &Path) -> anyhow::Result<PathBuf> {
    for (name, content) in FILES {
        let path = dir.join(name);
        let folder = path.parent().unwrap_or(dir);
        fs::create_dir_all(folder).with_context(|| cannot_make(folder.display()))?;
        fs::write(&path, content).with_context(|| cannot_write(path.display()))?;
    }
    Ok(dir.to_owned())
}
