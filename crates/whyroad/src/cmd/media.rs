//! `whyroad media add`: camera pictures that somebody has beside a log, attached to a drive of a lake, so that the labelling
//! service shows them.

mod pictures;
mod place;

use crate::{Global, output};
use anyhow::bail;
use pictures::Named;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_lake::Lake;
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, DriveId, Lang, Nanos};

/// Pictures that cannot be used and are named one by one.
const TOLD: usize = 50;

/// Arguments of `whyroad media`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Attach the pictures of one camera; those that it had before are replaced, other cameras stay
    Add(Add),
}

#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("source").required(true).args(["pictures", "times"])))]
struct Add {
    /// Lake that has the drive
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Drive
    #[arg(long, value_name = "ID")]
    drive: String,
    /// Name of the camera
    #[arg(long, value_name = "NAME", value_parser = camera_name)]
    camera: String,
    /// Folder of pictures (JPEG, PNG, WebP), one a frame, in the order of the numbers in their names
    #[arg(long, value_name = "DIR", requires = "rate")]
    pictures: Option<PathBuf>,
    /// Pictures a second
    #[arg(long, value_name = "HZ", value_parser = rate, requires = "pictures")]
    rate: Option<f64>,
    /// When the first picture was taken; the drive's start unless said
    #[arg(long, value_name = "TIME", value_parser = Nanos::parse_iso, requires = "pictures")]
    start: Option<Nanos>,
    /// The same as seconds from the drive's start
    #[arg(long, value_name = "S", value_parser = seconds, conflicts_with = "start", requires = "pictures", allow_negative_numbers = true)]
    offset: Option<f64>,
    /// CSV file with the columns name (from the file's folder) and time (ISO 8601, or seconds from the drive's start)
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Copy the pictures into LAKE/media/DRIVE/CAMERA; else they stay and are named by their path
    #[arg(long)]
    copy: bool,
}

/// A name that is also a folder's.
fn camera_name(text: &str) -> Result<String, String> {
    let fine = |c: char| c.is_alphanumeric() || " _-.".contains(c);
    let safe = !text.is_empty() && text.len() <= 64 && text.chars().all(fine);
    let told =
        "a camera's name has letters, digits, spaces, '_', '-' and '.', begins with no '.', and is short";
    (safe && !text.starts_with('.') && text.trim() == text).then(|| text.to_owned()).ok_or(told.to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|r: &f64| (0.001..=1e4).contains(r));
    rate.ok_or_else(|| "a rate is a number of pictures a second, 0.001 to 10000".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && s.abs() < 1e9);
    seconds.ok_or_else(|| "an offset is a number of seconds".to_owned())
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Add(a) => add(global.lang, &a),
    }
}

fn add(lang: Lang, a: &Add) -> anyhow::Result<ExitCode> {
    let lake = Lake::open(&a.lake)?;
    let id = DriveId::from(a.drive.as_str());
    let times = lake.outline(&id)?.times;
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        bail!("drive '{id}' has no frames");
    };
    let named = match (&a.times, &a.pictures, a.rate) {
        (Some(list), ..) => pictures::of_list(list, first)?,
        (None, Some(dir), Some(rate)) => {
            let start = a.start.unwrap_or(first + Nanos::from_secs_f64(a.offset.unwrap_or(0.0)));
            pictures::of_folder(dir, start, rate, lang)?
        }
        _ => bail!("--pictures with --rate, or --times"),
    };
    let (good, bad) = sifted(named, first, last);
    tell_bad(&bad, lang);
    if good.is_empty() {
        say!("{}", nothing(first, last, bad.len()).get(lang));
        return Ok(output::FINDINGS);
    }
    let frames = place::placed(&lake, &id, a, &good)?;
    let (own, others): (Vec<MediaFrame>, Vec<MediaFrame>) =
        lake.media(&id)?.into_iter().partition(|m| m.camera == a.camera);
    let (added, replaced, left_out) = (frames.len(), own.len(), bad.len());
    let outside = frames.iter().any(|f| Path::new(&f.uri).is_absolute());
    lake.write_media(&id, &others.into_iter().chain(frames).collect::<Vec<_>>())?;
    let camera = &a.camera;
    output::put(&match lang {
        Lang::Zh => {
            format!("行程 {id} 的相机 {camera}：{added} 张图片；替换原有 {replaced}，未采用 {left_out}\n")
        }
        Lang::En => {
            format!(
                "{id}, camera {camera}: {added} pictures; {replaced} before replaced, {left_out} left out\n"
            )
        }
    });
    if outside {
        let dir = place::folder(&good);
        match lang {
            Lang::Zh => say!("图片留在原处：请用 `whyroad serve --media {}` 打开", dir.display()),
            Lang::En => {
                say!("the pictures stay where they are: `whyroad serve --media {}` shows them", dir.display())
            }
        }
    }
    Ok(if left_out > 0 { output::lost_input() } else { output::FINE })
}

fn tell_bad(bad: &[(PathBuf, Bilingual)], lang: Lang) {
    for (path, why) in bad.iter().take(TOLD) {
        say!("{}: {}", path.display(), why.get(lang));
    }
    match (lang, bad.len().saturating_sub(TOLD)) {
        (_, 0) => {}
        (Lang::Zh, more) => say!("……另有 {more} 张不可用"),
        (Lang::En, more) => say!("... and {more} more that cannot be used"),
    }
}

fn nothing(first: Nanos, last: Nanos, bad: usize) -> Bilingual {
    Bilingual::new(
        format!("没有可用的图片（{bad} 张不可用）；行程从 {first} 到 {last}；数据湖未改动"),
        format!(
            "no picture can be used ({bad} bad); the drive is from {first} to {last}; the lake is as it was"
        ),
    )
}

/// A picture that can be shown.
struct Picture {
    path: PathBuf,
    time: Nanos,
    /// Ending of its kind.
    kind: &'static str,
}

/// Those that can be shown, by time; and the others with the reason.
fn sifted(named: Vec<Named>, first: Nanos, last: Nanos) -> (Vec<Picture>, Vec<(PathBuf, Bilingual)>) {
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for Named { path, time } in named {
        match usable(&path, time, first, last, &mut seen) {
            Ok((path, time, kind)) => good.push(Picture { path, time, kind }),
            Err(why) => bad.push((path, why)),
        }
    }
    good.sort_by_key(|p| p.time);
    (good, bad)
}

fn usable(
    path: &Path,
    time: Result<Nanos, String>,
    first: Nanos,
    last: Nanos,
    seen: &mut BTreeSet<Nanos>,
) -> Result<(PathBuf, Nanos, &'static str), Bilingual> {
    let time = time.map_err(|text| {
        Bilingual::new(format!("“{text}”不是时间"), format!("'{text}' is no time (ISO 8601, or seconds)"))
    })?;
    if time < first || time > last {
        return Err(Bilingual::new(
            format!("时间 {time} 不在行程内（{first} 至 {last}）"),
            format!("its time {time} is not within the drive ({first} to {last})"),
        ));
    }
    let kind = pictures::kind(path)?;
    let real = path
        .canonicalize()
        .map_err(|e| Bilingual::new(format!("无法读取：{e}"), format!("cannot be read: {e}")))?;
    // The service takes no name that is not text.
    if real.to_str().is_none() {
        return Err(Bilingual::new("路径不是 UTF-8", "its path is not UTF-8"));
    }
    if !seen.insert(time) {
        return Err(Bilingual::new(
            format!("时间 {time} 已有图片"),
            format!("there is a picture of {time} already"),
        ));
    }
    Ok((real, time, kind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_named_so_that_a_folder_can_be() {
        for fine in ["front", "front left", "CAM_FRONT", "前视", "cam.0"] {
            assert_eq!(camera_name(fine).as_deref(), Ok(fine));
        }
        for bad in ["", "..", ".hidden", "a/b", "a\\b", " a", &"x".repeat(65)] {
            assert!(camera_name(bad).is_err(), "{bad}");
        }
    }
}
