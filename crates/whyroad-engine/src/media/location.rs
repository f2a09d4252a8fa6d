//! Where the labeling service finds the images of a drive: in the lake's own folder, or at their original path.

use super::{AddImages, Image, MediaError};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use whyroad_lake::Lake;
use whyroad_model::DriveId;
use whyroad_model::scene::MediaFrame;

/// The path of each image; copies them into the lake first where requested.
pub(super) fn located(
    lake: &Lake,
    id: &DriveId,
    request: &AddImages,
    images: &[Image],
) -> Result<Vec<MediaFrame>, MediaError> {
    let own = lake.media_dir().join(id.as_str());
    let dir = own.join(&request.camera);
    if request.copy {
        fs::create_dir_all(&dir).map_err(MediaError::io(&dir))?;
    }
    let below = own.canonicalize().ok();
    let mut out = Vec::with_capacity(images.len());
    for image in images {
        let inside = below.as_ref().and_then(|own| image.path.strip_prefix(own).ok());
        let uri = match inside {
            // Existing files need no copy.
            Some(inside) => inside.to_string_lossy().into_owned(),
            None if request.copy => {
                // By its time and not by its name: a running service that still has an older table can then never show
                // a later image for an earlier moment.
                let name = format!("{}.{}", image.time.0, image.kind);
                copy(&image.path, &dir.join(&name))?;
                format!("{}/{name}", request.camera)
            }
            None => image.path.to_string_lossy().into_owned(),
        };
        out.push(MediaFrame { camera: request.camera.clone(), time: image.time, uri, index: 0 });
    }
    Ok(out)
}

/// Removes the copies in the lake that the drive's media table named before and does not name now. A file that cannot
/// be removed is found by nobody any more, and goes with the drive.
pub(super) fn remove_replaced(lake: &Lake, id: &DriveId, before: &[MediaFrame], now: &[MediaFrame]) {
    let named: BTreeSet<&str> = now.iter().map(|m| m.uri.as_str()).collect();
    let own = lake.media_dir().join(id.as_str());
    for frame in before.iter().filter(|m| !named.contains(m.uri.as_str())) {
        let path = Path::new(&frame.uri);
        if path.components().all(|part| matches!(part, Component::Normal(_))) {
            let _ = fs::remove_file(own.join(path));
        }
    }
}

/// Copies under another name and renames, so that readers never see a partial image.
fn copy(from: &Path, to: &Path) -> Result<(), MediaError> {
    let part = to.with_added_extension("part");
    fs::copy(from, &part).and_then(|_| fs::rename(&part, to)).map_err(MediaError::io(to))
}

/// The deepest folder that holds all of them.
pub(super) fn folder(images: &[Image]) -> PathBuf {
    let mut dir = images.first().and_then(|p| p.path.parent()).unwrap_or(Path::new("/")).to_owned();
    while !images.iter().all(|p| p.path.starts_with(&dir)) && dir.pop() {}
    dir
}
