//! `whyroad mine`: finds episodes in a lake by the framework's rules, by a custom rule or by a JSON query.

pub(super) mod missing;
mod part;
pub(super) mod plan;
mod sequences;
pub(super) mod table;

use crate::output::reason::{folders_only, stop};
use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use missing::MissingArgs;
use plan::CustomRule;
pub(super) use plan::rule_name;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use table::Results;
use whyroad_engine::again;
use whyroad_engine::mine::{Evaluator, MineOptions, MinedDrive};
use whyroad_engine::output::{FolderWriter, query};
use whyroad_engine::parts::Request;
use whyroad_lake::Lake;
use whyroad_lake::mined::{Existing, FolderLock, MinedWriteError, PublishError};
use whyroad_mining::rule::Rule;
use whyroad_model::{ClipCut, Diagnostic, Lang, ScenarioId, Severity};
use whyroad_signals::Catalog;

/// Crashes of a worker after which a drive in work is set aside.
const DEATHS: u16 = 3;

/// Arguments of `whyroad mine`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake to search
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Only this class (L1, L2 or leaf; full or unambiguous short id); may be repeated
    #[arg(long, value_name = "ID", conflicts_with_all = ["query", "rule"])]
    scenario: Vec<String>,
    /// A custom rule instead of the framework's: its text, or a .yaml file that holds one
    #[arg(long, value_name = "TEXT|FILE", conflicts_with = "query")]
    rule: Option<String>,
    /// Name of the custom rule; its matches are custom.NAME [default: the stem of its file, or rule]
    #[arg(long, value_name = "NAME", requires = "rule", value_parser = rule_name)]
    name: Option<String>,
    /// Kind of the target of --rule: vehicle, large_vehicle, vru, any, or a class such as bicycle [default: any]
    #[arg(long, value_name = "KIND", requires = "rule", value_parser = plan::target_kind)]
    target: Option<String>,
    /// Also write the results of --rule in the format of the Argoverse 2 scenario-mining challenge: .pkl for its
    /// evaluator, or .jsonl
    #[arg(long, value_name = "FILE", requires = "rule", conflicts_with = "drives",
        value_parser = sequences::file)]
    sequences: Option<PathBuf>,
    /// Prompt to write with --sequences [default: the name of the rule]
    #[arg(long, value_name = "TEXT", requires = "sequences")]
    prompt: Option<String>,
    /// A mining_query (JSON) instead of the framework's rules
    #[arg(long, value_name = "FILE")]
    query: Option<PathBuf>,
    /// Maximum number of clips in each mining_result, the best scores first; totals stay exact
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    /// Which clips episodes belong to
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    clips: Clips,
    /// Number of drives processed at once [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// fast, or the plain reference with identical results (keeps nothing)
    #[arg(long, hide = true, default_value = "fast", value_parser = ["fast", "reference"])]
    evaluator: String,
    /// Divide the drives among N workers: print N work lists, or write them to --out; mines nothing
    #[arg(long, value_name = "N", conflicts_with = "drives", value_parser = clap::value_parser!(u16).range(1..))]
    plan: Option<u16>,
    /// Mine only the drives of this work list (or of a file with one drive id per line; - is standard input), and
    /// write a part for `whyroad merge`
    #[arg(long, value_name = "FILE")]
    drives: Option<PathBuf>,
    /// With --drives: set a drive aside after N crashes of a worker that was working on it
    #[arg(long, value_name = "N", default_value_t = DEATHS, requires = "drives",
          value_parser = clap::value_parser!(u16).range(1..))]
    deaths: u16,
    /// Folder for the results; created if it does not exist
    #[arg(long, value_name = "DIR", required_unless_present = "plan")]
    out: Option<PathBuf>,
    /// Replace results of another question in that folder, or make a part again from the start
    #[arg(long)]
    force: bool,
    /// Derive only the signals that the rules need and store none: for a single question of drives without stored
    /// signals
    #[arg(long)]
    once: bool,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    print: Print,
}

/// `--clips`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Clips {
    /// The drive divided into stretches of 20 s from its start
    #[default]
    Fixed,
    /// Also 20 s around the keyframe of each primary episode; episodes and pre-labels are those of these clips
    Keyframe,
}

impl Clips {
    fn cut(self) -> ClipCut {
        match self {
            Self::Fixed => ClipCut::Fixed,
            Self::Keyframe => ClipCut::Keyframe,
        }
    }
}

/// What a run found, for printing; `None` where there was nothing to search.
pub(super) struct Mined {
    /// For programs and for people.
    pub results: Option<(Value, String)>,
    /// The command's exit code.
    pub code: ExitCode,
}

impl Mined {
    fn failed() -> Self {
        Self { results: None, code: output::FINDINGS }
    }
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    if let Some(lists) = args.plan {
        return part::print_plan(global, &args, usize::from(lists));
    }
    let print = args.print;
    let mined = search(global, args)?;
    if let Some((json, text)) = mined.results {
        print.put(&json, || text)?;
    }
    Ok(mined.code)
}

impl Args {
    /// A search for a custom rule.
    pub(super) fn of_rule(
        lake: PathBuf,
        rule: String,
        name: Option<String>,
        out: PathBuf,
        force: bool,
    ) -> Self {
        Self {
            lake,
            scenario: Vec::new(),
            rule: Some(rule),
            name,
            target: None,
            sequences: None,
            prompt: None,
            query: None,
            limit: None,
            clips: Clips::Fixed,
            jobs: None,
            evaluator: "fast".to_owned(),
            plan: None,
            drives: None,
            deaths: DEATHS,
            out: Some(out),
            force,
            once: false,
            missing: MissingArgs::default(),
            print: Print { format: Default::default() },
        }
    }

    /// The same with the kinds of the target.
    pub(super) fn with_target(self, target: Option<String>) -> Self {
        Self { target, ..self }
    }
}

/// Mines, and writes the folder.
pub(super) fn search(global: &Global, args: Args) -> anyhow::Result<Mined> {
    let Some(out) = &args.out else { return Err(stop("缺少 --out", "--out is missing")) };
    folders_only([out])?;
    let (framework, faults) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let mut findings: Vec<Diagnostic> = faults;
    let dir = global.framework.as_deref();
    let plan = match (&args.query, &args.rule) {
        (Some(file), _) => plan::of_query(file, &framework, &catalog)?,
        (None, Some(rule)) => {
            let custom = CustomRule { rule, name: args.name.as_deref(), target: args.target.as_deref() };
            plan::of_custom(&custom, &framework, &catalog)?
        }
        (None, None) => plan::of_rules(&args.scenario, &framework, &catalog),
    };
    let (mut plan, found) = match plan {
        Ok(p) => p,
        Err(found) => {
            say(found, global.lang);
            return Ok(Mined::failed());
        }
    };
    findings.extend(say(framework_folder::placed(dir, found), global.lang));

    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            say(vec![e.diagnostic()], global.lang);
            return Ok(Mined::failed());
        }
    };
    if let Some(limit) = args.limit {
        plan.questions.iter_mut().for_each(|q| q.limit = Some(limit));
    }
    let options = MineOptions {
        jobs: args.jobs.map(usize::from),
        evaluator: if args.evaluator == "reference" { Evaluator::Reference } else { Evaluator::Fast },
        lang: global.lang,
        clips: args.clips.cut(),
        once: args.once,
    };
    let asked_for = |r: &&Rule| plan.query.as_ref().is_none_or(|class| r.scenario.is_within(class));
    let classes: Vec<ScenarioId> =
        plan.rules.rules.iter().filter(asked_for).map(|r| r.scenario.clone()).collect();
    if let Some(list) = &args.drives {
        let work =
            part::Work { list, out, lake: &lake, plan, classes, framework: &framework, catalog: &catalog };
        return Ok(Mined { results: None, code: part::mine(global, &args, work)? });
    }
    // Two runs would write the same files: also the results of the first one would be lost.
    let _lock = match FolderLock::take(out) {
        Err(PublishError::Busy(dir)) => {
            say!("{}", busy(&dir, global.lang));
            return Ok(Mined::failed());
        }
        lock => lock?,
    };
    let request = Request {
        asked: plan.asked.clone(),
        questions: plan.questions.clone(),
        classes: classes.clone(),
        searched: plan.searched,
        lang: global.lang,
        clips: args.clips.cut(),
    };
    let state = again::state(&request, &framework.taxonomy, &plan.rules);
    // Without trusting anything, for sequences (all episodes are needed) and to compare evaluators.
    let from_scratch = args.force || args.sequences.is_some() || options.evaluator == Evaluator::Reference;
    let earlier = if from_scratch { None } else { again::earlier(out, &state) };
    let existing = if args.force { Existing::Replace } else { Existing::ReplaceSameQuestion };
    let precedence = &plan.rules.precedence;
    let folder = FolderWriter::create(out, plan.asked, existing, &plan.questions, &classes, precedence);
    let mut folder = match folder {
        Err(MinedWriteError::OtherQuestion { dir, .. }) => {
            say!("{}", other_question(&dir, global.lang));
            return Ok(Mined::failed());
        }
        folder => folder?,
    };
    let bar = output::progress(lake.drive_ids().len());
    let done = |id: &_| {
        bar.set_message(format!("{id}"));
        bar.inc(1);
    };
    let referred = Mutex::new(Vec::new());
    folder.keep_ledger(&state)?;
    let query =
        plan.query.as_ref().map(|class| query::ClassQuery::new(class, &plan.rules, &lake, global.lang));
    let answer = |drive: MinedDrive| match &query {
        Some(query) => query::answer(&drive, query),
        None => {
            if args.sequences.is_some() {
                let episodes: Vec<_> = drive.episodes.iter().map(|e| e.record.clone()).collect();
                let mut referred = referred.lock().unwrap_or_else(PoisonError::into_inner);
                referred.push((drive.drive_id.clone(), episodes));
            }
            drive
        }
    };
    let of = (&lake, &plan.rules, &options);
    let mined = again::mine_into(&mut folder, earlier.as_ref(), of, done, answer);
    drop(earlier);
    bar.finish_and_clear();
    let mut referred = referred.into_inner().unwrap_or_else(PoisonError::into_inner);
    referred.sort_by(|a, b| a.0.cmp(&b.0));
    if let Some(file) = &args.sequences {
        let name = plan.questions.first().map(|q| q.query_id.as_str()).unwrap_or_default();
        sequences::write(file, &lake, args.prompt.as_deref().unwrap_or(name), &referred)?;
    }
    let mined = mined?;
    let said = say(mined.diagnostics, global.lang);
    // The results are complete even if the lake could not keep them.
    let lost = said.iter().any(|d| d.severity == Severity::Error);
    let summary = folder.finish(&framework.taxonomy, plan.searched)?;
    let faulty = plan.rules.unusable(&framework);
    let results = Results {
        summary: &summary,
        asked: &request.asked,
        questions: &plan.questions,
        searched: plan.searched,
        taxonomy: &framework.taxonomy,
        faulty: &faulty,
        lang: global.lang,
    };
    let missing = args.missing.list(&results, Some(&lake))?;
    let results = Some((results.json(), results.text(missing)));
    if mined.same > 0 {
        say!("{}", unchanged(mined.same, summary.drives, global.lang));
    }
    say!("{}", written(out, global.lang));
    let code = if lost {
        output::lost_input()
    } else if findings.iter().all(|d| d.severity != Severity::Error) {
        output::FINE
    } else {
        output::FINDINGS
    };
    Ok(Mined { results, code })
}

fn say(found: Vec<Diagnostic>, lang: Lang) -> Vec<Diagnostic> {
    for d in &found {
        tell!("{}", render_text(d, lang));
    }
    found
}

fn unchanged(same: usize, drives: usize, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("{drives} 个行程中 {same} 个未变，沿用上次的结果"),
        Lang::En => format!("{same} of {drives} drives have not changed: their earlier results are kept"),
    }
}

fn written(out: &Path, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("结果写入 {}", out.display()),
        Lang::En => format!("results are in {}", out.display()),
    }
}

/// The folder is written by another process.
pub(super) fn busy(dir: &Path, lang: Lang) -> String {
    let dir = dir.display();
    match lang {
        Lang::Zh => {
            format!("错误：另一进程正在写入 {dir}，未作改动；请等它结束，或用 --out 指定其他文件夹")
        }
        Lang::En => format!(
            "error: another process is writing {dir}, which was left unchanged; wait until it has finished, or choose \
             another folder with --out"
        ),
    }
}

pub(super) fn other_question(dir: &Path, lang: Lang) -> String {
    let dir = dir.display();
    match lang {
        Lang::Zh => format!(
            "错误：{dir} 中是另一次查询的结果，未作改动；请用 --out 指定其他文件夹，或用 --force 覆盖"
        ),
        Lang::En => format!(
            "error: {dir} holds the results of another question and was left unchanged; choose another folder with \
             --out, or replace them with --force"
        ),
    }
}
