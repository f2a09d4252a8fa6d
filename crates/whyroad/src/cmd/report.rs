//! `whyroad report`: counts by class and stage, shortfalls, and mining results, as one self-contained page; the same
//! numbers as text, JSON and tables.

use crate::cmd::dataset::query::Queries;
use crate::output::reason::{Reason, cannot_make, cannot_write, folders_only, reason, stop};
use crate::output::{Print, render_text};
use crate::store_args::KeyArgs;
use crate::{Global, analytics, framework_folder, output};
use anyhow::Context as _;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_engine::drives::{map_drives, signals_of};
use whyroad_framework::Framework;
use whyroad_lake::mined::MinedFile;
use whyroad_lake::{Lake, LakeError, MinedFolder};
use whyroad_model::messages::Coverage;
use whyroad_model::{Diagnostic, DriveId, Lang, Nanos, ScenarioId, SignalTable};
use whyroad_report::analytics::{
    Analytics, AnalyticsInputs, HourlyRate, render_text as render_analytics, tables,
};
use whyroad_report::report::{
    CardChoice, ChosenEpisodes, DrivePart, ReportBuilder, ReportContext, SignalInfo,
};
use whyroad_signals::{Catalog, SignalKind};

/// Arguments of `whyroad report`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake that was mined
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Folder that `whyroad mine` wrote
    #[arg(long, value_name = "DIR")]
    mined: PathBuf,
    /// The page
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,
    #[command(flatten)]
    numbers: Numbers,
    /// Maximum number of episodes with an image, primary ones first; the rest is counted
    #[arg(long, value_name = "N", default_value_t = MAX_CARDS)]
    max_episodes: usize,
    #[command(flatten)]
    print: Print,
}

/// Inputs of the numbers besides the mined folder, and their outputs.
#[derive(clap::Args, Default)]
pub(crate) struct Numbers {
    /// Store of the labeling service: labels.db, the folder with it, or postgres://...
    #[arg(long, value_name = "STORE")]
    labels: Option<String>,
    #[command(flatten)]
    key: KeyArgs,
    /// Only this project of the store [default: all projects together]
    #[arg(long, value_name = "NAME", requires = "labels")]
    project: Option<String>,
    /// Release whose samples are counted; may be repeated
    #[arg(long, value_name = "DIR")]
    release: Vec<PathBuf>,
    /// Required accepted labels per leaf [default: the quota of the project]
    #[arg(long, value_name = "N")]
    target: Option<u64>,
    /// Cost of an hour of work [default: cost per label is unknown]
    #[arg(long, value_name = "AMOUNT", requires = "labels")]
    rate: Option<f64>,
    /// Currency of --rate
    #[arg(long, value_name = "CODE", default_value = "CNY")]
    currency: String,
    /// Day that ages and forecasts count from, YYYY-MM-DD [default: that of the last change of a task]
    #[arg(long, value_name = "DATE", value_parser = day)]
    as_of: Option<Nanos>,
    /// Shift of hours of the day from UTC, h
    #[arg(long, value_name = "H", default_value_t = 0, allow_hyphen_values = true,
        value_parser = clap::value_parser!(i8).range(-14..=14))]
    utc_offset: i8,
    /// Folder for the numbers as CSV and Parquet, and for the queries of shortfalls
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// Also print the numbers as text; `--format json` always includes them
    #[arg(long)]
    summary: bool,
}

/// The end of a day: everything of it counts.
fn day(text: &str) -> Result<Nanos, Reason> {
    Nanos::parse_iso(&format!("{text}T23:59:59Z"))
        .map_err(|_| reason("应为日期 YYYY-MM-DD", "expected a day, YYYY-MM-DD"))
}

/// About 30 kB per episode: a size that a browser still scrolls smoothly.
pub(crate) const MAX_CARDS: usize = 400;

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, faults) = framework_folder::load(global)?;
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => return Ok(refuse(&e.diagnostic(), global.lang)),
    };
    folders_only([&args.mined, &args.out])?;
    let Some(mined) = MinedFolder::open(&args.mined) else {
        let (dir, file) = (args.mined.display(), MinedFile::Episodes.name());
        return Err(stop(
            format!("{dir} 中没有 {file}；用 `whyroad mine --out DIR` 生成"),
            format!("{dir} has no {file}; `whyroad mine --out DIR` writes it"),
        ));
    };
    let coverage = match mined.coverage() {
        Ok(coverage) => coverage,
        Err(d) => return Ok(refuse(&d, global.lang)),
    };
    let mut lost = Vec::new();
    let readable = mined.episodes()?.filter_map(|line| line.map_err(|d| lost.push(*d)).ok());
    let chosen = CardChoice::new(args.max_episodes).choose_all(readable);
    // Without the numbers the page is still useful.
    let (analytics, of_analytics) = match analyze(&framework, &mined, &lake, &args.numbers, global.lang)? {
        Ok((made, lost)) => (Some(made), lost),
        Err(d) => (None, vec![*d]),
    };
    lost.extend(of_analytics);
    let found = Found {
        framework: &framework,
        lake: &lake,
        coverage: &coverage,
        chosen: &chosen,
        analytics: analytics.as_ref(),
    };
    lost.extend(write_page(&found, &args.out, global.lang)?);
    if let (Some(dir), Some(analytics)) = (&args.numbers.tables, &analytics) {
        write_tables(analytics, dir)?;
    }
    for d in &lost {
        tell!("{}", render_text(d, global.lang));
    }
    let not_mined = not_mined(&lake, &coverage);
    if let Some(text) = unsearched(coverage.left_out.len(), not_mined, global.lang) {
        say!("{text}");
    }
    super::inspect::keep(&lake, global);
    let written = json!({
        "page": args.out, "drives": coverage.drives.len(), "unreadable": lost.len(),
        "left_out": coverage.left_out, "not_mined": not_mined, "analytics": analytics,
    });
    args.print.put(&written, || {
        let numbers = match analytics.as_ref().filter(|_| args.numbers.summary) {
            Some(analytics) => render_analytics(analytics, global.lang) + "\n",
            None => String::new(),
        };
        format!("{numbers}{}\n", args.out.display())
    })?;
    Ok(if !lost.is_empty() || !coverage.left_out.is_empty() {
        output::lost_input()
    } else if faults.is_empty() {
        output::FINE
    } else {
        output::FINDINGS
    })
}

/// Number of the lake's drives that the run did not have: they were ingested after it.
fn not_mined(lake: &Lake, coverage: &Coverage) -> usize {
    let searched = coverage.drives.iter().chain(coverage.left_out.iter().map(|d| &d.drive_id));
    let searched: BTreeSet<&DriveId> = searched.collect();
    lake.drive_ids().iter().filter(|id| !searched.contains(id)).count()
}

/// Drives of which the report says nothing; `None` where it has all.
fn unsearched(left_out: usize, not_mined: usize, lang: Lang) -> Option<String> {
    let pick = |zh: String, en: String| if lang == Lang::Zh { zh } else { en };
    let parts = [
        (left_out > 0).then(|| {
            pick(
                format!("挖掘时有 {left_out} 个行程无法读取，其内容未知（coverage.json 的 left_out）"),
                format!(
                    "{left_out} drives could not be mined: what happened in them is unknown (left_out in coverage.json)"
                ),
            )
        }),
        (not_mined > 0).then(|| {
            pick(
                format!("数据湖中有 {not_mined} 个行程不在该挖掘结果中：请再次运行 `whyroad mine`"),
                format!("{not_mined} drives of the lake are not in the mined folder: run `whyroad mine` again"),
            )
        }),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("\n"))
}

fn refuse(d: &Diagnostic, lang: Lang) -> ExitCode {
    tell!("{}", render_text(d, lang));
    output::FINDINGS
}

/// The analytics with the unreadable inputs, or why there are none.
pub(crate) type Analyzed = Result<(Analytics, Vec<Diagnostic>), Box<Diagnostic>>;

pub(crate) fn analyze(
    framework: &Framework,
    folder: &MinedFolder,
    lake: &Lake,
    numbers: &Numbers,
    lang: Lang,
) -> anyhow::Result<Analyzed> {
    let (mined, lost) = match analytics::mined(folder, lake) {
        Ok(read) => read,
        Err(d) => return Ok(Err(d)),
    };
    let project = numbers.project.as_deref();
    let labelling = numbers
        .labels
        .as_deref()
        .map(|s| analytics::labelling((s, &numbers.key), project, lang))
        .transpose()?;
    let releases =
        (!numbers.release.is_empty()).then(|| analytics::releases(&numbers.release)).transpose()?;
    let wanted = match numbers.target {
        Some(n) => {
            framework.taxonomy.ids().into_iter().filter(ScenarioId::is_leaf).map(|id| (id, n)).collect()
        }
        None => labelling.as_ref().map(|l| l.wanted.clone()).unwrap_or_default(),
    };
    let rate = numbers.rate.map(|amount| HourlyRate { amount, currency: numbers.currency.clone() });
    let queries = Queries::new(framework);
    let inputs = AnalyticsInputs {
        mined: Some(&mined),
        tasks: labelling.as_ref().map(|l| &l.tasks[..]),
        releases: releases.as_deref(),
        wanted: &wanted,
        rate: rate.as_ref(),
        as_of: numbers.as_of,
        utc_offset_h: numbers.utc_offset,
        query: &|class, n| queries.query(class, n),
    };
    Ok(Ok((Analytics::new(framework, &inputs), lost)))
}

/// Tables as CSV and Parquet, and `queries/<class>.json`. Outdated queries of an earlier run are removed.
fn write_tables(analytics: &Analytics, dir: &Path) -> anyhow::Result<()> {
    for sheet in tables(analytics) {
        sheet.write(dir)?;
    }
    let queries = dir.join("queries");
    std::fs::create_dir_all(&queries).with_context(|| cannot_make(queries.display()))?;
    for old in
        std::fs::read_dir(&queries)?.flatten().filter(|f| f.path().extension().is_some_and(|e| e == "json"))
    {
        std::fs::remove_file(old.path())?;
    }
    for s in &analytics.shortfalls {
        if let Some(query) = &s.query {
            let path = queries.join(format!("{}.json", s.scenario_id));
            let text = serde_json::to_string_pretty(query)?;
            std::fs::write(&path, text + "\n").with_context(|| cannot_write(path.display()))?;
        }
    }
    Ok(())
}

/// Inputs of a page.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    pub framework: &'a Framework,
    pub lake: &'a Lake,
    pub coverage: &'a Coverage,
    pub chosen: &'a BTreeMap<DriveId, ChosenEpisodes>,
    /// The numbers; without them the page has only coverage and episodes.
    pub analytics: Option<&'a Analytics>,
}

/// Writes the page, drives on all cores; a drive that cannot be read is reported and left out.
pub(crate) fn write_page(found: &Found<'_>, out: &Path, lang: Lang) -> anyhow::Result<Vec<Diagnostic>> {
    let (catalog, _) = Catalog::parse(&found.framework.signals_yaml);
    let signals: BTreeMap<String, SignalInfo> = catalog
        .iter()
        .map(|d| {
            let values: &[String] = match &d.kind {
                SignalKind::Category(values) => values,
                _ => &[],
            };
            let info = SignalInfo {
                values: values.iter().map(|v| (v.clone(), catalog.value_name(v))).collect(),
                unit: d.unit,
                title: d.title.clone(),
                meaning: d.meaning.clone(),
                scale: d.scale,
            };
            (d.name.clone(), info)
        })
        .collect();
    let (framework, coverage) = (found.framework, found.coverage);
    let context = ReportContext { framework, coverage, signals: &signals, lang };
    let part = |id: &DriveId| -> Result<DrivePart, LakeError> {
        let drive = found.lake.read_drive(id)?;
        let tracks = drive.tracks.len();
        let drive = whyroad_engine::estimated(drive);
        let none = ChosenEpisodes::default();
        let chosen = found.chosen.get(id).unwrap_or(&none);
        // Only cards show signals.
        let signals = match chosen.cards.is_empty() {
            true => SignalTable::default(),
            false => signals_of(found.lake, id)?,
        };
        Ok(DrivePart::new(&context, &drive, tracks, &signals, chosen))
    };
    let mut page = ReportBuilder::new(context);
    if let Some(analytics) = found.analytics {
        page.put_analytics(whyroad_report::analytics::page::fragment(analytics));
    }
    let mut lost = Vec::new();
    let bar = output::progress(coverage.drives.len());
    let part = |id: &DriveId| {
        let part = part(id);
        bar.set_message(format!("{id}"));
        bar.inc(1);
        part
    };
    map_drives(&coverage.drives, None, part, |part| {
        match part {
            Ok(part) => page.add(part),
            Err(e) => lost.push(e.diagnostic()),
        }
        anyhow::Ok(())
    })?;
    bar.finish_and_clear();
    if let Some(dir) = out.parent().filter(|d| !d.as_os_str().is_empty()) {
        std::fs::create_dir_all(dir).with_context(|| cannot_make(dir.display()))?;
    }
    std::fs::write(out, page.finish()).with_context(|| cannot_write(out.display()))?;
    Ok(lost)
}
