//! Where the pictures of a drive are to be found by the labelling service: in the lake's own folder, or where they lie.

use super::{Add, Picture};
use anyhow::Context as _;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_lake::Lake;
use whyroad_model::DriveId;
use whyroad_model::scene::MediaFrame;

/// Where each picture is to be found; copies them first where that was asked for.
pub(super) fn placed(
    lake: &Lake,
    id: &DriveId,
    a: &Add,
    good: &[Picture],
) -> anyhow::Result<Vec<MediaFrame>> {
    let own = lake.dir().join("media").join(id.as_str());
    let dir = own.join(&a.camera);
    if a.copy {
        fs::create_dir_all(&dir).with_context(|| format!("cannot make {}", dir.display()))?;
    }
    let below = own.canonicalize().ok();
    let mut out = Vec::with_capacity(good.len());
    for p in good {
        let inside = below.as_ref().and_then(|own| p.path.strip_prefix(own).ok());
        let uri = match inside {
            // What lies there already needs no copy.
            Some(inside) => inside.to_string_lossy().into_owned(),
            None if a.copy => {
                // By its time and not by its name: a running service that still has an older table can then never show
                // a later picture for an earlier moment.
                let name = format!("{}.{}", p.time.0, p.kind);
                copy(&p.path, &dir.join(&name))?;
                format!("{}/{name}", a.camera)
            }
            None => p.path.to_string_lossy().into_owned(),
        };
        out.push(MediaFrame { camera: a.camera.clone(), time: p.time, uri, index: 0 });
    }
    Ok(out)
}

/// Copies aside and renames, so that nobody sees half a picture.
fn copy(from: &Path, to: &Path) -> anyhow::Result<()> {
    let aside = to.with_added_extension("part");
    fs::copy(from, &aside)
        .and_then(|_| fs::rename(&aside, to))
        .with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))
}

/// The folder that has all of them.
pub(super) fn folder(good: &[Picture]) -> PathBuf {
    let mut dir = good.first().and_then(|p| p.path.parent()).unwrap_or(Path::new("/")).to_owned();
    while !good.iter().all(|p| p.path.starts_with(&dir)) && dir.pop() {}
    dir
}
