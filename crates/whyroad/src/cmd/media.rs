//! `whyroad media add`: camera images beside a log, attached to a drive of a lake.

use crate::arguments::time;
use crate::output::Print;
use crate::output::reason::{Reason, cannot_write, reason, stop};
use crate::{Global, output};
use anyhow::{Context as _, bail};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{SystemTime, UNIX_EPOCH};
use whyroad_engine::media::{AddImages, ImageSource, ImageStart, MediaError, add_images, camera_name};
use whyroad_lake::Lake;
use whyroad_model::{Bilingual, DriveId, Lang, Nanos};

/// Rejected images that are named one by one.
const NAMED: usize = 50;

/// Arguments of `whyroad media`.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// Attach the images of one camera; earlier ones of this camera are replaced, other cameras are kept
    Add(Add),
}

#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("source").required(true).args(["pictures", "times", "video"])))]
struct Add {
    /// Lake that has the drive
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Drive
    #[arg(long, value_name = "ID")]
    drive: String,
    /// Name of the camera
    #[arg(long, value_name = "NAME", value_parser = camera)]
    camera: String,
    /// Folder of images (JPEG, PNG, WebP), one per frame, in the order of the numbers in their names
    #[arg(long, value_name = "DIR", requires = "rate")]
    pictures: Option<PathBuf>,
    /// Video file such as mp4; its frames are extracted with ffmpeg, which must be installed, and copied into the lake
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// Images per second; for a video those that are extracted [default for a video: 10]
    #[arg(long, value_name = "HZ", value_parser = rate, conflicts_with = "times")]
    rate: Option<f64>,
    /// When the first image was taken [default: the drive's start]
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "times")]
    start: Option<Nanos>,
    /// The same as seconds from the drive's start
    #[arg(long, value_name = "S", value_parser = seconds, conflicts_with_all = ["start", "times"], allow_negative_numbers = true)]
    offset: Option<f64>,
    /// CSV file with the columns name (from the file's folder) and time (ISO 8601, or seconds from the drive's start)
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Copy the images into LAKE/media/DRIVE/CAMERA; otherwise the lake stores their paths
    #[arg(long)]
    copy: bool,
    #[command(flatten)]
    print: Print,
}

fn camera(text: &str) -> Result<String, Reason> {
    camera_name(text).map_err(Reason::from)
}

fn rate(text: &str) -> Result<f64, Reason> {
    let rate = text.parse().ok().filter(|r: &f64| (0.001..=1e4).contains(r));
    rate.ok_or_else(|| {
        reason("应为每秒图像数，0.001 到 10000", "a rate is a number of images per second, 0.001 to 10000")
    })
}

fn seconds(text: &str) -> Result<f64, Reason> {
    let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && s.abs() < 1e9);
    seconds.ok_or_else(|| reason("应为秒数", "an offset is a number of seconds"))
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    match args.what {
        What::Add(a) => add(global.lang, &a),
    }
}

fn add(lang: Lang, a: &Add) -> anyhow::Result<ExitCode> {
    let lake = Lake::open(&a.lake)?;
    let id = DriveId::from(a.drive.as_str());
    let start = || a.start.map_or(ImageStart::Offset(a.offset.unwrap_or(0.0)), ImageStart::At);
    let rate_hz = a.rate.unwrap_or(VIDEO_RATE_HZ);
    let extracted = a.video.as_ref().map(|video| Extracted::of(video, rate_hz, lang)).transpose()?;
    let source = match (&a.times, &a.pictures, a.rate, &extracted) {
        (Some(list), ..) => ImageSource::List(list.clone()),
        (None, Some(dir), Some(rate_hz), _) => {
            ImageSource::Folder { dir: dir.clone(), start: start(), rate_hz }
        }
        (None, None, _, Some(frames)) => {
            ImageSource::Folder { dir: frames.dir.clone(), start: start(), rate_hz }
        }
        _ => {
            return Err(stop(
                "请给出 --pictures 与 --rate，或 --video，或 --times",
                "give --pictures with --rate, --video, or --times",
            ));
        }
    };
    // Extracted frames exist only during this call.
    let copy = a.copy || extracted.is_some();
    let request = AddImages { camera: a.camera.clone(), source, copy };
    let done = match add_images(&lake, &id, &request) {
        Ok(done) => done,
        Err(e) => {
            if let MediaError::NothingUsable { rejected, .. } = &e {
                say_rejected(rejected, lang);
                say!("{}", e.text().get(lang));
                return Ok(output::FINDINGS);
            }
            bail!(e.text().get(lang).to_owned());
        }
    };
    lake.publish()?;
    say_rejected(&done.rejected, lang);
    let (camera, added, replaced, rejected) = (&a.camera, done.added, done.replaced, done.rejected.len());
    let counts = json!({
        "drive": id.as_str(), "camera": camera, "added": added, "replaced": replaced, "rejected": rejected,
    });
    a.print.put(&counts, || match lang {
        Lang::Zh => {
            format!("行程 {id} 的相机 {camera}：{added} 张图片；替换原有 {replaced}，未采用 {rejected}\n")
        }
        Lang::En => {
            format!("{id}, camera {camera}: {added} images; {replaced} replaced, {rejected} rejected\n")
        }
    })?;
    if let Some(dir) = done.outside {
        match lang {
            Lang::Zh => say!("图片留在原处：请用 `whyroad serve --media {}` 打开", dir.display()),
            Lang::En => {
                say!("the images stay where they are: `whyroad serve --media {}` shows them", dir.display())
            }
        }
    }
    let complaint = extracted.as_ref().and_then(|frames| frames.complaint.as_deref());
    if let Some(said) = complaint {
        match lang {
            Lang::Zh => say!("视频有损坏，可能缺少图片；ffmpeg：{said}"),
            Lang::En => say!("the video is damaged, and images can be missing; ffmpeg: {said}"),
        }
    }
    Ok(if rejected > 0 || complaint.is_some() { output::lost_input() } else { output::FINE })
}

/// Images per second that are taken from a video.
const VIDEO_RATE_HZ: f64 = 10.0;

/// The frames of a video in a folder that is removed when this is dropped.
struct Extracted {
    dir: PathBuf,
    /// What ffmpeg reported as an error while it went on: the file breaks off, or a part cannot be decoded.
    complaint: Option<String>,
}

impl Extracted {
    fn of(video: &Path, rate_hz: f64, lang: Lang) -> anyhow::Result<Self> {
        if !video.is_file() {
            bail!(match lang {
                Lang::Zh => format!("没有文件 {}", video.display()),
                Lang::En => format!("no file {}", video.display()),
            });
        }
        let nanos = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos());
        let dir = std::env::temp_dir().join(format!("whyroad-video-{}-{nanos}", std::process::id()));
        std::fs::create_dir(&dir).with_context(|| cannot_write(dir.display()))?;
        let mut frames = Self { dir, complaint: None };
        let run = Command::new("ffmpeg")
            .args(["-nostdin", "-v", "error", "-i"])
            .arg(video)
            .args(["-vf", &format!("fps={rate_hz}"), "-q:v", "3"])
            .arg(frames.dir.join("%07d.jpg"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .output();
        let out = match run {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => bail!(match lang {
                Lang::Zh => "没有安装 ffmpeg：安装它，或自行抽帧后用 --pictures",
                Lang::En =>
                    "ffmpeg is not installed: install it, or extract the frames yourself and use --pictures",
            }),
            other => other.context(reason("无法运行 ffmpeg", "cannot run ffmpeg"))?,
        };
        let said = String::from_utf8_lossy(&out.stderr);
        if !out.status.success() {
            return Err(stop(format!("ffmpeg 失败：{}", said.trim()), format!("ffmpeg: {}", said.trim())));
        }
        frames.complaint =
            said.lines().find(|line| !line.trim().is_empty()).map(|line| line.trim().to_owned());
        Ok(frames)
    }
}

impl Drop for Extracted {
    fn drop(&mut self) {
        // A leftover temporary folder is harmless.
        let _ = std::fs::remove_dir_all(&self.dir);
    }
}

fn say_rejected(rejected: &[(PathBuf, Bilingual)], lang: Lang) {
    for (path, why) in rejected.iter().take(NAMED) {
        say!("{}: {}", path.display(), why.get(lang));
    }
    match (lang, rejected.len().saturating_sub(NAMED)) {
        (_, 0) => {}
        (Lang::Zh, more) => say!("……另有 {more} 张不可用"),
        (Lang::En, more) => say!("... and {more} more that cannot be used"),
    }
}
