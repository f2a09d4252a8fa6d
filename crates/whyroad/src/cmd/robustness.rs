//! `whyroad robustness`: agreement of mining with itself when the log is perturbed.

use crate::arguments::share;
use crate::output::reason::{Reason, cannot_write, possible_values};
use crate::output::{DataFormat, render_text};
use crate::{Global, framework_folder, output};
use anyhow::{Context as _, bail};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use whyroad_engine::drives::map_drives;
use whyroad_engine::mine::episodes_of;
use whyroad_engine::perturb::{Perturbation, perturb};
use whyroad_lake::{Lake, LakeError};
use whyroad_mining::RuleSet;
use whyroad_mining::drive::DriveEpisodes;
use whyroad_mining::fast::Plan;
use whyroad_model::{Drive, DriveId, FrameRange, Lang, Nanos, TrackId};
use whyroad_report::coverage::class_title;
use whyroad_report::robustness::{Occurrence, Robustness, Shown, page, render};
use whyroad_signals::Catalog;

/// Arguments of `whyroad robustness`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake whose drives are perturbed, in memory; nothing in it is changed
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Only this perturbation; may be repeated [default: all]
    #[arg(long, value_name = "NAME", value_parser = perturbation)]
    perturbation: Vec<Perturbation>,
    /// Seed of the perturbations
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Lowest acceptable agreement, 0 to 1: below it for any perturbation, the exit code is 1; classes below are listed
    #[arg(long, value_name = "SHARE", value_parser = share)]
    floor: Option<f64>,
    /// List every class that changed
    #[arg(long)]
    classes: bool,
    /// List every episode that is lost (-) or new (+): drive, time of the keyframe, class, objects
    #[arg(long)]
    episodes: bool,
    /// Also write the perturbed drives, a lake for each perturbation, for `explain` and `signals`
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Also write a page with all classes and perturbations
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
    /// Number of drives processed at once [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// How to print the result
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    format: DataFormat,
}

/// Classes below this agreement are listed where no floor is given.
const LISTED_BELOW: f64 = 0.95;

fn perturbation(name: &str) -> Result<Perturbation, Reason> {
    Perturbation::from_name(name).ok_or_else(|| possible_values(&Perturbation::ALL.map(Perturbation::name)))
}

/// Results of one drive: its original episodes, and those of each perturbation.
struct Compared {
    drive: DriveId,
    start: Nanos,
    before: Vec<Occurrence>,
    after: Vec<Vec<Occurrence>>,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, faults) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let (rules, found) = RuleSet::of_framework(&framework, &catalog);
    let dir = global.framework.as_deref();
    let new = framework_folder::placed(dir, found);
    new.iter().for_each(|d| tell!("{}", render_text(d, global.lang)));
    let faulty = !faults.is_empty() || !new.is_empty();
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            tell!("{}", render_text(&e.diagnostic(), global.lang));
            return Ok(output::FINDINGS);
        }
    };
    let mut how =
        if args.perturbation.is_empty() { Perturbation::ALL.to_vec() } else { args.perturbation.clone() };
    how.sort();
    how.dedup();
    let mut result = Robustness::new(args.seed, how.iter().map(|p| (p.name().to_owned(), p.meaning())));
    let ids = lake.drive_ids();
    let bar = output::progress(ids.len() * (how.len() + 1));
    let stopped = interrupted();
    let plan = Plan::of(&rules);
    let mut kept = Vec::new();
    for p in args.keep.iter().flat_map(|dir| how.iter().map(|p| dir.join(p.name()))) {
        kept.push(Lake::create_or_open(p)?);
    }
    let one = |id: &DriveId| -> Result<Option<Compared>, LakeError> {
        if stopped.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let drive = lake.read_drive(id)?;
        let find = |drive: &Drive| episodes_of(drive, &rules, &plan);
        let before = occurrences(&find(&drive), &drive.times, &|id| id.clone());
        let mut after = Vec::with_capacity(how.len());
        bar.inc(1);
        for (i, &p) in how.iter().enumerate() {
            if stopped.load(Ordering::Relaxed) {
                return Ok(None);
            }
            bar.set_message(format!("{id} {}", p.name()));
            let worse = perturb(&drive, p, args.seed);
            if let Some(lake) = kept.get(i) {
                lake.write_drive(&worse.drive)?;
            }
            let original = |id: &TrackId| worse.original.get(id).unwrap_or(id).clone();
            after.push(occurrences(&find(&worse.drive), &drive.times, &original));
            bar.inc(1);
        }
        let start = drive.times.first().copied().unwrap_or_default();
        Ok(Some(Compared { drive: id.clone(), start, before, after }))
    };
    let mut unreadable = false;
    map_drives(&ids, args.jobs.map(usize::from), one, |compared| {
        match compared {
            Ok(Some(of)) => result.add((&of.drive, of.start), &of.before, &of.after),
            Ok(None) => result.left_out += 1,
            Err(e) => {
                tell!("{}", render_text(&e.diagnostic(), global.lang));
                result.left_out += 1;
                unreadable = true;
            }
        }
        anyhow::Ok(())
    })?;
    bar.finish_and_clear();
    kept.iter().try_for_each(Lake::publish)?;
    result.finish();
    if result.drives == 0 {
        bail!("{}", nothing(global.lang));
    }
    let floor = args.floor.unwrap_or(LISTED_BELOW);
    output::put(&match args.format {
        DataFormat::Text => {
            let shown = Shown { floor, classes: args.classes, episodes: args.episodes };
            render(&result, global.lang, shown)
        }
        DataFormat::Json => format!("{:#}\n", serde_json::to_value(&result)?),
    });
    if let Some(file) = &args.page {
        std::fs::write(file, page(&result, global.lang, floor, |id| class_title(&framework.taxonomy, id)))
            .with_context(|| cannot_write(file.display()))?;
        say!("{}", file.display());
    }
    Ok(if unreadable || result.left_out > 0 {
        output::lost_input()
    } else if args.floor.is_some_and(|f| result.least() < f) || faulty {
        output::FINDINGS
    } else {
        output::FINE
    })
}

fn nothing(lang: Lang) -> &'static str {
    match lang {
        Lang::Zh => "没有可比较的行程",
        Lang::En => "no drive was compared",
    }
}

/// Becomes true on Ctrl-C: results until then are reported. A second Ctrl-C ends the program.
fn interrupted() -> Arc<AtomicBool> {
    let stopped = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stopped);
    std::thread::spawn(move || {
        let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_io().build() else { return };
        for press in 0.. {
            if runtime.block_on(tokio::signal::ctrl_c()).is_err() {
                return;
            }
            if press > 0 {
                std::process::exit(130);
            }
            flag.store(true, Ordering::Relaxed);
        }
    });
    stopped
}

fn occurrences(
    found: &DriveEpisodes,
    times: &[Nanos],
    original: &dyn Fn(&TrackId) -> TrackId,
) -> Vec<Occurrence> {
    let end = |range: FrameRange| times.get(range.end).or(times.last()).copied().unwrap_or_default();
    found
        .episodes
        .iter()
        .map(|e| Occurrence {
            scenario: e.scenario.clone(),
            objects: e.target.iter().chain(e.roles.values()).map(original).collect(),
            start: times[e.range.start],
            keyframe: times[e.keyframe],
            end: end(e.range),
        })
        .collect()
}
