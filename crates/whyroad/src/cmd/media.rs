//! `whyroad media add`: camera images beside a log, attached to a drive of a lake.

use crate::output::Print;
use crate::{Global, output};
use anyhow::bail;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
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
    /// Attach the images of one camera; those that it had before are replaced, other cameras stay
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
    /// Folder of images (JPEG, PNG, WebP), one per frame, in the order of the numbers in their names
    #[arg(long, value_name = "DIR", requires = "rate")]
    pictures: Option<PathBuf>,
    /// Images per second
    #[arg(long, value_name = "HZ", value_parser = rate, requires = "pictures")]
    rate: Option<f64>,
    /// When the first image was taken [default: the drive's start]
    #[arg(long, value_name = "TIME", value_parser = Nanos::parse_iso, requires = "pictures")]
    start: Option<Nanos>,
    /// The same as seconds from the drive's start
    #[arg(long, value_name = "S", value_parser = seconds, conflicts_with = "start", requires = "pictures", allow_negative_numbers = true)]
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

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|r: &f64| (0.001..=1e4).contains(r));
    rate.ok_or_else(|| "a rate is a number of images per second, 0.001 to 10000".to_owned())
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
    let source = match (&a.times, &a.pictures, a.rate) {
        (Some(list), ..) => ImageSource::List(list.clone()),
        (None, Some(dir), Some(rate_hz)) => {
            let start = a.start.map_or(ImageStart::Offset(a.offset.unwrap_or(0.0)), ImageStart::At);
            ImageSource::Folder { dir: dir.clone(), start, rate_hz }
        }
        _ => bail!("--pictures with --rate, or --times"),
    };
    let request = AddImages { camera: a.camera.clone(), source, copy: a.copy };
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
    Ok(if rejected > 0 { output::lost_input() } else { output::FINE })
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
