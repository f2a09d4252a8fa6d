//! Camera images beside a log, attached to a drive of a lake, so that the labeling service shows them.

mod error;
mod images;
mod location;

pub use error::MediaError;
pub(crate) use images::kind_by_extension as image_kind_by_extension;

use images::NamedImage;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use whyroad_lake::Lake;
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, DriveId, Nanos};

/// Images of one camera to attach to a drive.
#[derive(Clone, Debug)]
pub struct AddImages {
    /// The camera; see [`camera_name`].
    pub camera: String,
    /// Where the images are.
    pub source: ImageSource,
    /// Copy them into the lake; otherwise the lake stores their paths.
    pub copy: bool,
}

/// Images with their times.
#[derive(Clone, Debug)]
pub enum ImageSource {
    /// A folder of images at a fixed rate, in the order of the numbers in their names.
    Folder {
        /// The folder.
        dir: PathBuf,
        /// When the first was taken.
        start: ImageStart,
        /// Images per second.
        rate_hz: f64,
    },
    /// A CSV file with the columns `name` and `time` (ISO 8601, or seconds from the drive's start).
    List(PathBuf),
}

/// When the first image of a folder was taken.
#[derive(Clone, Copy, Debug)]
pub enum ImageStart {
    /// At a time.
    At(Nanos),
    /// Seconds after the start of the drive; may be negative.
    Offset(f64),
}

/// Result of attaching images.
#[derive(Clone, Debug)]
pub struct AddedImages {
    /// Images that the drive now has of the camera.
    pub added: usize,
    /// Images of the camera that it had before.
    pub replaced: usize,
    /// Images that cannot be shown, with the reason.
    pub rejected: Vec<(PathBuf, Bilingual)>,
    /// The folder of images outside the lake, which must be given to the service.
    pub outside: Option<PathBuf>,
}

/// Attaches images to a drive. Those that it had of the same camera are replaced, other cameras are kept. Images that
/// cannot be shown are left out and reported; if no image can be shown, nothing is changed.
pub fn add_images(lake: &Lake, id: &DriveId, request: &AddImages) -> Result<AddedImages, MediaError> {
    let times = lake.outline(id)?.times;
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Err(MediaError::EmptyDrive(id.clone()));
    };
    let named = match &request.source {
        ImageSource::List(list) => images::of_list(list, first)?,
        ImageSource::Folder { dir, start, rate_hz } => {
            let start = match start {
                ImageStart::At(time) => *time,
                ImageStart::Offset(seconds) => first + Nanos::from_secs_f64(*seconds),
            };
            images::of_folder(dir, start, *rate_hz)?
        }
    };
    let (usable, rejected) = sifted(named, first, last);
    if usable.is_empty() {
        return Err(MediaError::NothingUsable { first, last, rejected });
    }
    let frames = location::located(lake, id, request, &usable)?;
    let (own, others): (Vec<MediaFrame>, Vec<MediaFrame>) =
        lake.media(id)?.into_iter().partition(|m| m.camera == request.camera);
    let (added, replaced) = (frames.len(), own.len());
    let is_outside = frames.iter().any(|f| Path::new(&f.uri).is_absolute());
    let all: Vec<MediaFrame> = others.into_iter().chain(frames).collect();
    lake.write_media(id, &all)?;
    location::remove_replaced(lake, id, &own, &all);
    Ok(AddedImages { added, replaced, rejected, outside: is_outside.then(|| location::folder(&usable)) })
}

/// `text` as the name of a camera, which is also the name of a folder.
pub fn camera_name(text: &str) -> Result<String, Bilingual> {
    let fine = |c: char| c.is_alphanumeric() || " _-.".contains(c);
    let safe = !text.is_empty() && text.len() <= 64 && text.chars().all(fine);
    (safe && !text.starts_with('.') && text.trim() == text).then(|| text.to_owned()).ok_or_else(|| {
        Bilingual::new(
            "相机名称由 1 到 64 个字母、数字、空格、'_'、'-' 和 '.' 组成，不以 '.' 开头",
            "a camera name has 1 to 64 letters, digits, spaces, '_', '-' and '.', and does not begin with '.'",
        )
    })
}

/// An image that can be shown.
struct Image {
    path: PathBuf,
    time: Nanos,
    /// Extension of its kind.
    kind: &'static str,
}

/// Those that can be shown, by time; and the others with the reason.
fn sifted(named: Vec<NamedImage>, first: Nanos, last: Nanos) -> (Vec<Image>, Vec<(PathBuf, Bilingual)>) {
    let (mut usable, mut rejected) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for NamedImage { path, time } in named {
        match check(&path, time, first, last, &mut seen) {
            Ok(image) => usable.push(image),
            Err(why) => rejected.push((path, why)),
        }
    }
    usable.sort_by_key(|p| p.time);
    (usable, rejected)
}

fn check(
    path: &Path,
    time: Result<Nanos, String>,
    first: Nanos,
    last: Nanos,
    seen: &mut BTreeSet<Nanos>,
) -> Result<Image, Bilingual> {
    let time = time.map_err(|text| {
        Bilingual::new(format!("“{text}”不是时间"), format!("'{text}' is not a time (ISO 8601, or seconds)"))
    })?;
    if time < first || time > last {
        return Err(Bilingual::new(
            format!("时间 {time} 不在行程内（{first} 至 {last}）"),
            format!("its time {time} is not within the drive ({first} to {last})"),
        ));
    }
    let kind = images::kind(path)?;
    let path = path
        .canonicalize()
        .map_err(|e| Bilingual::new(format!("无法读取：{e}"), format!("cannot be read: {e}")))?;
    // The service accepts only names that are text.
    if path.to_str().is_none() {
        return Err(Bilingual::new("路径不是 UTF-8", "its path is not UTF-8"));
    }
    if !seen.insert(time) {
        return Err(Bilingual::new(
            format!("时间 {time} 已有图片"),
            format!("an image of {time} already exists"),
        ));
    }
    Ok(Image { path, time, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_name_is_also_a_folder_name() {
        for fine in ["front", "front left", "CAM_FRONT", "前视", "cam.0"] {
            assert_eq!(camera_name(fine).as_deref(), Ok(fine));
        }
        for bad in ["", "..", ".hidden", "a/b", "a\\b", " a", &"x".repeat(65)] {
            assert!(camera_name(bad).is_err(), "{bad}");
        }
    }
}
