//! Images of a sample: files of the cameras, or bird's-eye images rendered from the tables, each at or before t0.

use super::Cutter;
use super::motion::Window;
use crate::item::{Dropped, Stage, hex};
use crate::sample::Image;
use crate::spec::{Cut, Images};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_model::scene::MediaFrame;
use whyroad_model::{DriveId, Nanos};
use whyroad_render::raster::{Raster, birds_eye};

/// File types that are images; a frame inside a video is not used.
const TYPES: &[&str] = &["jpg", "jpeg", "png", "webp"];
/// A camera frame may be this much older than the requested time, s.
const OLDEST_S: f64 = 0.25;
/// A frame this near to a time is at it, s.
const SAME_S: f64 = 1e-3;

/// Returns the file to be exported in place of a camera image, with faces and plates made unreadable, or an error
/// message.
pub type Blurring = Arc<dyn Fn(&Path) -> Result<PathBuf, String> + Send + Sync>;

/// Folders with the images that the lake names, and the processing of camera images before export.
#[derive(Clone, Default)]
pub struct Media {
    roots: Vec<PathBuf>,
    blurring: Option<(String, Blurring)>,
}

impl std::fmt::Debug for Media {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Media").field("roots", &self.roots).field("blurring", &self.blurring_name()).finish()
    }
}

impl Media {
    /// The lake's own `media` folder and further ones.
    pub fn new(lake: &Path, more: &[PathBuf]) -> Self {
        let all = more.iter().cloned().chain([lake.join("media")]);
        Self { roots: all.filter_map(|d| d.canonicalize().ok()).collect(), blurring: None }
    }

    /// Every camera image goes through `blurring` before it is exported; where that fails the sample is dropped, never
    /// exported as it is. `name` identifies it: a build with another one does not reuse these images.
    #[must_use]
    pub fn blurred(mut self, name: impl Into<String>, blurring: Blurring) -> Self {
        self.blurring = Some((name.into(), blurring));
        self
    }

    /// Processing applied to camera images.
    pub fn blurring_name(&self) -> Option<&str> {
        self.blurring.as_ref().map(|(name, _)| name.as_str())
    }

    /// The file to export in place of `path`.
    fn exported(&self, path: PathBuf) -> Result<PathBuf, String> {
        self.blurring.as_ref().map_or(Ok(path.clone()), |(_, blurring)| blurring(&path))
    }

    /// The file of a camera frame; a name never leads out of the folders.
    fn find(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        let candidates = self.roots.iter().flat_map(|root| {
            [root.join(drive.as_str()).join(&frame.uri), root.join(&frame.uri)].map(|p| (root, p))
        });
        candidates
            .filter_map(|(root, path)| Some((root, path.canonicalize().ok()?)))
            .find(|(root, path)| path.starts_with(root) && path.is_file())
            .map(|(_, path)| path)
    }
}

/// The images that the spec requests.
pub(super) fn of(cutter: &Cutter<'_>, window: &Window, frame: usize) -> Result<Vec<Image>, Dropped> {
    let cut = &cutter.spec.sample;
    match cut.images {
        Images::None => Ok(Vec::new()),
        Images::Bev => bev(cutter, cut, frame),
        Images::Cameras => cameras(cutter, cut, window.time()),
        Images::CamerasOrBev if cutter.drive.media.as_ref().is_some_and(|m| !m.is_empty()) => {
            cameras(cutter, cut, window.time())
        }
        Images::CamerasOrBev => bev(cutter, cut, frame),
    }
}

/// The last frame of each camera at or before each time.
fn cameras(cutter: &Cutter<'_>, cut: &Cut, t0: Nanos) -> Result<Vec<Image>, Dropped> {
    let drop = |reason: &'static str, detail: String| Dropped::with(Stage::Sample, reason, detail);
    let media = cutter.drive.media.as_deref().unwrap_or_default();
    let wanted = |camera: &str| cut.cameras.is_empty() || cut.cameras.iter().any(|c| c == camera);
    let names: BTreeSet<&str> = media.iter().map(|m| m.camera.as_str()).filter(|c| wanted(c)).collect();
    let missing: Vec<&str> = cut.cameras.iter().map(String::as_str).filter(|c| !names.contains(c)).collect();
    if names.is_empty() || !missing.is_empty() {
        return Err(drop("camera_missing", missing.join(", ")));
    }
    let mut out = Vec::new();
    for camera in names {
        for at in &cut.image_times_s {
            let time = t0.plus_secs(*at);
            if is_before(cutter, time) {
                return Err(drop("image_before_drive", format!("{camera} at {at} s")));
            }
            let before = media.iter().filter(|m| m.camera == camera && m.time <= time);
            let Some(frame) = before.max_by_key(|m| m.time) else {
                return Err(drop("image_missing", format!("{camera} at {at} s")));
            };
            if frame.time.seconds_since(time) < -OLDEST_S {
                return Err(drop("image_missing", format!("{camera} at {at} s: the last frame is older")));
            }
            let kind = Path::new(&frame.uri)
                .extension()
                .map(|e| e.to_string_lossy().to_lowercase())
                .unwrap_or_default();
            if !TYPES.contains(&kind.as_str()) {
                return Err(drop("image_in_video", frame.uri.clone()));
            }
            let bytes = cutter
                .media
                .find(&cutter.drive.meta.drive_id, frame)
                .ok_or_else(|| drop("image_file_missing", frame.uri.clone()))
                .and_then(|path| cutter.media.exported(path).map_err(|why| drop("image_not_blurred", why)))
                .and_then(|path| {
                    std::fs::read(path).map_err(|_| drop("image_file_missing", frame.uri.clone()))
                })?;
            let format = if kind == "jpeg" { "jpg".to_owned() } else { kind };
            out.push(image(camera, frame.time.seconds_since(t0), format, bytes));
        }
    }
    Ok(out)
}

/// Rendered from measurements up to each time: the frame of the drive at or before it.
fn bev(cutter: &Cutter<'_>, cut: &Cut, frame: usize) -> Result<Vec<Image>, Dropped> {
    let raster = Raster { size_px: cut.bev_size_px, m_per_px: cut.bev_m_per_px };
    let times = &cutter.drive.times;
    let t0 = times[frame];
    let mut out = Vec::new();
    for at in &cut.image_times_s {
        let time = t0.plus_secs(*at);
        let after = times.partition_point(|t| t.seconds_since(time) <= SAME_S);
        let drop = |reason, detail: String| Dropped::with(Stage::Sample, reason, detail);
        let fault = |why: &str| drop("image_not_rendered", format!("bev at {at} s: {why}"));
        let index =
            after.checked_sub(1).ok_or_else(|| drop("image_before_drive", format!("bev at {at} s")))?;
        if times[index].seconds_since(time) < -OLDEST_S {
            return Err(fault("the last frame is older"));
        }
        let png = birds_eye(cutter.drive, index, &raster).ok_or_else(|| fault("no ego pose"))?;
        out.push(image("bev", times[index].seconds_since(t0), "png".into(), png));
    }
    Ok(out)
}

/// No frame of the drive is that early.
fn is_before(cutter: &Cutter<'_>, time: Nanos) -> bool {
    cutter.drive.times.first().is_some_and(|first| first.seconds_since(time) > SAME_S)
}

fn image(camera: &str, t_s: f64, format: String, bytes: Vec<u8>) -> Image {
    let sha256 = hex(&Sha256::digest(&bytes));
    Image { camera: camera.to_owned(), t_s: t_s as f32, format, sha256, bytes }
}
