//! `whyroad demo`: every step from recorded drives to checked label drafts, the report, a release of the drafts and an
//! export for a trainer, on drives that are built into this program or on the user's own AV2 logs.

mod drafts;
mod drives;
mod release;
mod summary;

use crate::cmd::report::{self, Found, MAX_CARDS, write_page};
use crate::output::reason::{cannot_make, reason};
use crate::output::render_text;
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_engine::mine::{MinedLake, mine_lake};
use whyroad_engine::output::{Question, Summary, write_folder};
use whyroad_framework::Framework;
use whyroad_ingest::{AdapterRef, LICENCE, Options, av2, sumo};
use whyroad_lake::{Lake, MinedFolder};
use whyroad_mining::RuleSet;
use whyroad_mining::rule::OTHER;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Diagnostic, Lang, ScenarioId, Severity};
use whyroad_report::report::CardChoice;
use whyroad_signals::Catalog;

/// Arguments of `whyroad demo`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder for all results
    #[arg(long, value_name = "DIR", default_value = "whyroad-demo")]
    out: PathBuf,
    /// Use this AV2 sensor log, or the logs below this folder, instead of the built-in simulated drives
    #[arg(long, value_name = "PATH")]
    av2: Option<PathBuf>,
}

/// Reports each step on stderr, and records whether anything was lost.
struct Steps {
    lang: Lang,
    lost: bool,
}

impl Steps {
    fn say(&self, zh: String, en: String) {
        say!("{}", if self.lang == Lang::Zh { zh } else { en });
    }

    /// Notes are printed only by `whyroad ingest`.
    fn findings(&mut self, found: &[Diagnostic]) {
        for d in found.iter().filter(|d| d.severity != Severity::Note) {
            self.lost |= d.severity == Severity::Error;
            tell!("{}", render_text(d, self.lang));
        }
    }
}

/// The bundled drives as a lake in `out`, mined into `out/mined`: what `whyroad serve` shows when nothing else was
/// named.
pub(crate) fn lake_and_episodes(global: &Global, framework: &Framework, out: &Path) -> anyhow::Result<Lake> {
    let mut steps = Steps { lang: global.lang, lost: false };
    std::fs::create_dir_all(out).with_context(|| cannot_make(out.display()))?;
    let lake = ingest(&mut steps, &Args { out: out.to_owned(), av2: None })?;
    let lake = lake.context(reason("无法读取内置行程", "the bundled drives could not be read"))?;
    mine(&mut steps, framework, &lake, out)?;
    Ok(lake)
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let mut steps = Steps { lang: global.lang, lost: false };
    std::fs::create_dir_all(&args.out).with_context(|| cannot_make(args.out.display()))?;

    let Some(lake) = ingest(&mut steps, &args)? else { return Ok(output::FINDINGS) };
    let (mined, result) = mine(&mut steps, &framework, &lake, &args.out)?;
    let episodes: Vec<EpisodeRecord> =
        mined.drives.iter().flat_map(|d| d.episodes.iter().map(|e| e.record.clone())).collect();
    // A person classifies unexplained moments: there is nothing to draft.
    let classified: Vec<EpisodeRecord> =
        episodes.iter().filter(|e| e.scenario_id.l1 != OTHER).cloned().collect();
    let drafts = drafts::write(&framework, &lake, &mined, &classified, &args.out, global.lang)?;
    steps.findings(&drafts.lost);
    steps.say(drafts.summary(Lang::Zh), drafts.summary(Lang::En));

    let released = release::write(&mut steps, &framework, &lake, &args.out)?;

    let page = args.out.join("report.html");
    let chosen = CardChoice::new(MAX_CARDS).choose_all(episodes.iter().cloned());
    let folder = MinedFolder::open(args.out.join("mined"))
        .context(reason("刚写入的挖掘结果不见了", "the mined folder was just written"))?;
    let numbers = report::Numbers::default();
    let analytics = match report::analyze(&framework, &folder, &lake, &numbers, global.lang)? {
        Ok((analytics, lost)) => {
            steps.findings(&lost);
            Some(analytics)
        }
        Err(d) => {
            steps.findings(&[*d]);
            None
        }
    };
    let found = Found {
        framework: &framework,
        lake: &lake,
        coverage: &result.coverage,
        chosen: &chosen,
        analytics: analytics.as_ref(),
    };
    let lost = write_page(&found, &page, global.lang)?;
    steps.findings(&lost);
    let table = summary::table(&framework.taxonomy, &result.coverage, &episodes, &lake, global.lang);
    let next = summary::where_to_look(&page, &lake, &args.out, released, global.lang);
    output::put(&format!("\n{table}\n{next}\n"));
    Ok(if steps.lost { output::lost_input() } else { output::FINE })
}

/// The lake, with every drive that could be read in it; `None` when there is no drive at all.
fn ingest(steps: &mut Steps, args: &Args) -> anyhow::Result<Option<Lake>> {
    // Two lakes, so that a page never mixes bundled drives with the user's drives.
    let (format, path, folder) = match &args.av2 {
        Some(path) => (AdapterRef(&av2::Av2), path.clone(), "lake-av2"),
        None => (AdapterRef(&sumo::Sumo), drives::unpack(&args.out.join("drives"))?, "lake"),
    };
    let (sources, problems) = whyroad_ingest::find_sources(Some(format), &[path]);
    steps.findings(&problems);
    let options = match &args.av2 {
        Some(_) => Options::default(),
        None => Options::default().with(&LICENCE, drives::LICENCE),
    };
    let lake = fresh_lake(&args.out.join(folder))?;
    let mut kept = 0;
    for source in &sources {
        let report = whyroad_ingest::ingest(source, &options, &lake);
        steps.findings(&report.diagnostics);
        let Some(id) = report.drive_id.as_ref().filter(|_| report.outcome.is_some()) else {
            steps.lost = true;
            continue;
        };
        kept += 1;
        let (seconds, tracks) = (report.duration_s, report.tracks);
        steps.say(
            format!("导入  {id}：{seconds:.1} s，{tracks} 个目标"),
            format!("ingest  {id}: {seconds:.1} s, {tracks} objects"),
        );
    }
    Ok((kept > 0).then_some(lake))
}

/// An empty lake. One that an earlier demo left, perhaps of another version, is replaced; any other folder is left
/// alone, and rejected by the lake.
fn fresh_lake(dir: &Path) -> anyhow::Result<Lake> {
    if dir.join("whyroad-lake.json").is_file() {
        std::fs::remove_dir_all(dir).with_context(|| {
            reason(format!("无法清空 {}", dir.display()), format!("cannot clear {}", dir.display()))
        })?;
    }
    Ok(Lake::create_or_open(dir)?)
}

fn mine(
    steps: &mut Steps,
    framework: &Framework,
    lake: &Lake,
    out: &Path,
) -> anyhow::Result<(MinedLake, Summary)> {
    let (catalog, mut found) = Catalog::parse(&framework.signals_yaml);
    let (rules, of_rules) = RuleSet::of_framework(framework, &catalog);
    found.extend(of_rules);
    let rules = rules.with_decision_moments(&catalog);
    steps.findings(&found);
    let mut mined = mine_lake(lake, &rules, steps.lang, |_| ());
    steps.findings(&std::mem::take(&mut mined.diagnostics));
    let classes: Vec<ScenarioId> = rules.rules.iter().map(|r| r.scenario.clone()).collect();
    let questions: Vec<Question> = classes
        .iter()
        .map(|id| Question { query_id: format!("rules_{id}"), scenario: id.clone(), limit: None })
        .collect();
    let summary = write_folder(
        &out.join("mined"),
        &mined,
        &questions,
        &framework.taxonomy,
        &classes,
        &rules.precedence,
    )?;
    let episodes: usize = mined.drives.iter().map(|d| d.episodes.len()).sum();
    let rules = classes.len();
    steps.say(
        format!("挖掘  {rules} 条规则，{episodes} 个片段"),
        format!("mine    {rules} rules, {episodes} episodes"),
    );
    Ok((mined, summary))
}
