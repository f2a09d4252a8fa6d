//! `whyroad dataset build`.

use super::{licences, print, query, refused};
use crate::output::Print;
use crate::output::reason::{cannot_read, cannot_write, folders_only, no_project, stop};
use crate::store_args::{KeyArgs, error as reported};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use whyroad_dataset::{
    Built, DatasetError, Inputs, LabelStream, Media, Stage, Step, build, reason_in_words, spec,
};
use whyroad_engine::label_drives::LabelDrives;
use whyroad_lake::Lake;
use whyroad_model::Lang;
use whyroad_server::blur::Blur;
use whyroad_server::service::projects;
use whyroad_server::service::transfer::{self, ExportFormat};

/// Arguments of `whyroad dataset build`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Spec; `whyroad dataset init` writes one
    #[arg(long, value_name = "FILE")]
    spec: PathBuf,
    /// Labels: a file of JSON lines, a folder of such files or one that `whyroad mine` wrote, the store of the service
    /// (labels.db or postgres://...), or - for stdin. Given several times, all are read: a label takes score and id of
    /// its episode from a mined folder
    #[arg(long, value_name = "SRC", required = true)]
    labels: Vec<String>,
    #[command(flatten)]
    key: KeyArgs,
    /// Project of the service; default: all projects of the store
    #[arg(long, value_name = "NAME")]
    project: Option<String>,
    /// Lake with the drives that the labels name
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Folder for the release; must not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Folder with the camera images that the lake names (may be given more than once)
    #[arg(long, value_name = "DIR")]
    media: Vec<PathBuf>,
    /// Program that makes faces and plates in camera images unreadable, called as `PROGRAM INPUT OUTPUT`; an image for
    /// which it fails is not exported
    #[arg(long, value_name = "PROGRAM", env = "WHYROAD_BLUR")]
    blur: Option<PathBuf>,
    /// Include unchecked drafts, marked, regardless of the spec
    #[arg(long)]
    drafts: bool,
    /// Discard what an interrupted build with other inputs left
    #[arg(long)]
    restart: bool,
    /// Drives worked on at once; default: all cores
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    #[command(flatten)]
    print: Print,
}

/// `media` with camera images that are processed by `program`; its output is kept in `cache`.
fn blurring(media: Media, program: Option<&Path>, cache: &Path, lang: Lang) -> anyhow::Result<Media> {
    let Some(program) = program else { return Ok(media) };
    let blur = Blur::new(program.to_path_buf(), cache.to_path_buf())
        .with_context(|| cannot_write(cache.display()))?;
    let name = program.display().to_string();
    Ok(media.blurred(
        name,
        Arc::new(move |image: &Path| blur.image(image).map_err(|p| p.text.get(lang).to_owned())),
    ))
}

pub(super) fn run(global: &Global, a: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    if framework_folder::is_incomplete(global) {
        return Ok(output::FINDINGS);
    }
    let text = std::fs::read_to_string(&a.spec).with_context(|| cannot_read(a.spec.display()))?;
    let mut spec = match spec::read(&text, &a.spec.display().to_string(), &framework) {
        Ok(spec) => spec,
        Err(found) => {
            print(global, &found);
            return Ok(output::FINDINGS);
        }
    };
    spec.labels.drafts |= a.drafts;
    let licences = licences(global)?;
    folders_only(a.media.iter().chain([&a.out]))?;
    let lake = Lake::open(&a.lake)?;
    let with_cameras = matches!(spec.sample.images, spec::Images::Cameras | spec::Images::CamerasOrBev);
    if lake.stored_images().is_some() && with_cameras && a.media.is_empty() {
        return Err(stop(
            format!(
                "数据集只从文件夹读取相机图片：`aws s3 sync {}/media DIR`，再加 --media DIR",
                lake.name()
            ),
            format!(
                "a release takes camera images from folders only: `aws s3 sync {}/media DIR`, then --media DIR",
                lake.name()
            ),
        ));
    }
    let mut streams = Vec::new();
    for source in &a.labels {
        streams.extend(open((source, &a.key), a.project.as_deref(), global.lang)?);
    }
    let queries = query::Queries::new(&framework);
    // Blurred images stay beside the release until the build succeeds, so that an interrupted one can continue.
    let blurred = PathBuf::from(format!("{}.blurred", a.out.display()));
    let media = blurring(Media::new(lake.dir(), &a.media), a.blur.as_deref(), &blurred, global.lang)?;
    let inputs = Inputs {
        spec,
        spec_text: text,
        framework: &framework,
        licences: &licences,
        lake: &lake,
        recordings: Some(Arc::new(LabelDrives::new(lake.clone(), &framework))),
        media,
        spec_dir: a.spec.parent().unwrap_or(Path::new("")),
        out: &a.out,
        queries: &|class, n| queries.query(class, n),
        restart: a.restart,
    };
    let progress = Progress { lang: global.lang, bars: Mutex::default() };
    let work = || build(&inputs, streams, &|step, done, total| progress.step(step, done, total));
    let built = match a.jobs.and_then(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().ok()) {
        Some(pool) => pool.install(work),
        None => work(),
    };
    progress.finish();
    match built {
        Ok(built) => {
            if a.blur.is_some() {
                // The files in the release are enough.
                let _ = std::fs::remove_dir_all(&blurred);
            }
            print(global, &built.diagnostics);
            a.print.put(&built.manifest, || summary(&built, &a.out, global.lang))?;
            let lost = built.diagnostics.iter().any(|d| {
                matches!(
                    d.code,
                    "dataset.labels.line"
                        | "dataset.labels.invalid"
                        | "dataset.labels.drive"
                        | "dataset.drive.unreadable"
                        | "dataset.image.blur"
                )
            });
            Ok(if lost { output::lost_input() } else { output::FINE })
        }
        Err(e @ DatasetError::Refused(_)) => Ok(refused(global, &e)),
        Err(e) => Ok(refused(global, &e)),
    }
}

/// A bar per step.
struct Progress {
    lang: Lang,
    bars: Mutex<Option<(Step, output::log::Progress)>>,
}

impl Progress {
    fn step(&self, step: Step, done: usize, total: usize) -> bool {
        let Ok(mut held) = self.bars.lock() else { return true };
        if held.as_ref().is_none_or(|(s, _)| *s != step) {
            if let Some((_, bar)) = held.take() {
                bar.finish_and_clear();
            }
            let bar = output::progress(total);
            bar.set_message(match (step, self.lang) {
                (Step::Cut, Lang::Zh) => "切分行程",
                (Step::Cut, Lang::En) => "drives cut",
                (Step::Write, Lang::Zh) => "写文件",
                (Step::Write, Lang::En) => "files written",
            });
            *held = Some((step, bar));
        }
        if let Some((_, bar)) = held.as_ref() {
            bar.set_position(bar.position().max(done as u64));
        }
        true
    }

    fn finish(&self) {
        if let Ok(mut held) = self.bars.lock()
            && let Some((_, bar)) = held.take()
        {
            bar.finish_and_clear();
        }
    }
}

/// The label streams of a source.
fn open(
    (source, key): (&str, &KeyArgs),
    project: Option<&str>,
    lang: Lang,
) -> anyhow::Result<Vec<LabelStream>> {
    if source == "-" {
        let lines = Box::new(BufReader::new(std::io::stdin()));
        return Ok(vec![LabelStream { name: "<stdin>".to_owned(), lines }]);
    }
    let path = Path::new(source);
    let is_database = source.starts_with("postgres://") || source.starts_with("postgresql://");
    if is_database || path.extension().is_some_and(|e| e == "db" || e == "sqlite") {
        return store((source, key), project, lang);
    }
    if path.join("labels.db").is_file() {
        return store((&path.join("labels.db").display().to_string(), key), project, lang);
    }
    let files = if path.is_dir() { files_of(path)? } else { vec![path.to_owned()] };
    files
        .into_iter()
        .map(|path| {
            let file = File::open(&path).with_context(|| cannot_read(path.display()))?;
            Ok(LabelStream { name: path.display().to_string(), lines: Box::new(BufReader::new(file)) })
        })
        .collect()
}

/// The episodes of a mined folder, else all files of JSON lines.
fn files_of(dir: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let episodes = dir.join("episodes.jsonl");
    if episodes.is_file() {
        return Ok(vec![episodes]);
    }
    let entries = std::fs::read_dir(dir).with_context(|| cannot_read(dir.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "jsonl" || e == "ndjson"));
    files.sort();
    if files.is_empty() {
        return Err(stop(
            format!("{} 中没有 .jsonl 文件，也没有 labels.db", dir.display()),
            format!("{} has no .jsonl files and no labels.db", dir.display()),
        ));
    }
    Ok(files)
}

/// Tasks with their history, as `whyroad tasks export --content tasks` writes them.
fn store(
    (source, key): (&str, &KeyArgs),
    project: Option<&str>,
    lang: Lang,
) -> anyhow::Result<Vec<LabelStream>> {
    let store = key.open(source, lang)?;
    let all = store.read(projects::all).map_err(|p| reported(&p, lang))?;
    let wanted: BTreeMap<&str, &str> = all
        .iter()
        .filter(|p| project.is_none_or(|name| p.name == name || p.id == name))
        .map(|p| (p.name.as_str(), p.id.as_str()))
        .collect();
    if let Some(name) = project.filter(|_| wanted.is_empty()) {
        let names: Vec<&str> = all.iter().map(|p| p.name.as_str()).collect();
        return Err(no_project(name, &names));
    }
    wanted
        .into_iter()
        .map(|(name, id)| {
            let text = transfer::export(&store, id, &ExportFormat::Tasks).map_err(|p| reported(&p, lang))?;
            Ok(LabelStream { name: name.to_owned(), lines: Box::new(Cursor::new(text)) })
        })
        .collect()
}

fn summary(built: &Built, out: &Path, lang: Lang) -> String {
    use std::fmt::Write as _;
    let (m, mut t) = (&built.manifest, String::new());
    let by = |split: &str| m.counts.by_split.get(split).copied().unwrap_or(0);
    let (train, val, test) = (by("train"), by("val"), by("test"));
    let n = m.counts.samples;
    let _ = match lang {
        Lang::Zh => writeln!(t, "{n} 个样本：训练 {train}，验证 {val}，测试 {test}；许可 {}", m.licence),
        Lang::En => writeln!(t, "{n} samples: train {train}, val {val}, test {test}; license {}", m.licence),
    };
    for (stage, reasons) in &m.counts.dropped {
        let title = Stage::ALL.iter().find(|s| s.name() == stage).map(|s| s.title());
        let title = title.as_ref().map_or(stage.as_str(), |t| t.get(lang));
        let one = |(id, n): (&String, &usize)| format!("{} {n}", reason_in_words(id).get(lang));
        let list: Vec<String> = reasons.iter().map(one).collect();
        let _ = match lang {
            Lang::Zh => writeln!(t, "  {title}：去除 {}", list.join("、")),
            Lang::En => writeln!(t, "  {title}: dropped {}", list.join(", ")),
        };
    }
    let near = m.split.distances.iter().find(|d| d.within_m == 5.0);
    if let Some(share) = near.and_then(|d| d.share) {
        let _ = match lang {
            Lang::Zh => writeln!(t, "  距训练样本 5 m 以内的验证样本：{:.1} %", share * 100.0),
            Lang::En => {
                writeln!(t, "  validation samples within 5 m of a training sample: {:.1} %", share * 100.0)
            }
        };
    }
    if built.resumed > 0 {
        let _ = match lang {
            Lang::Zh => writeln!(t, "  {} 个行程取自上次中断的构建", built.resumed),
            Lang::En => writeln!(t, "  {} drives were taken from the interrupted build", built.resumed),
        };
    }
    let _ = match lang {
        Lang::Zh => writeln!(t, "说明见 {}", out.join("README.md").display()),
        Lang::En => writeln!(t, "card: {}", out.join("README.md").display()),
    };
    t
}
