//! `whyroad mine`: episodes out of a lake, by the framework's rules, by a rule of one's own or by a JSON query.

pub(super) mod plan;
mod table;

use crate::output::render_text;
use crate::{Global, framework_folder, output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_engine::mine::{Evaluator, Options, mine_each};
use whyroad_engine::output::FolderWriter;
use whyroad_lake::Lake;
use whyroad_model::{Diagnostic, Lang, ScenarioId, Severity};
use whyroad_signals::Catalogue;

/// Arguments of `whyroad mine`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Lake to search
    #[arg(long, value_name = "DIR")]
    lake: PathBuf,
    /// Only this class (L1, L2 or leaf; full or unambiguous short id); may be repeated
    #[arg(long, value_name = "ID", conflicts_with_all = ["query", "rule"])]
    scenario: Vec<String>,
    /// A rule in one line (docs/reference/rules.md), or a .yaml file that holds one, instead of the framework's rules
    #[arg(long, value_name = "TEXT|FILE", conflicts_with = "query")]
    rule: Option<String>,
    /// What the target of --rule can be; any object unless said
    #[arg(long, value_name = "KIND", requires = "rule", value_parser = ["vehicle", "large_vehicle", "vru", "any"])]
    target: Option<String>,
    /// A mining_query (JSON) instead of the framework's rules
    #[arg(long, value_name = "FILE")]
    query: Option<PathBuf>,
    /// At most so many clips in each mining_result, the best scores first; totals stay exact
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    /// Drives worked on at once; all cores unless said
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// fast, or the plain reference that it must equal (keeps nothing)
    #[arg(long, hide = true, default_value = "fast", value_parser = ["fast", "reference"])]
    evaluator: String,
    /// Folder for the results; made when it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, faults) = framework_folder::load(global)?;
    let (catalogue, faults_of_signals) = Catalogue::parse(&framework.signals_yaml);
    let mut findings: Vec<Diagnostic> = faults;
    let dir = global.framework.as_deref();
    findings.extend(say(framework_folder::placed(dir, faults_of_signals), global.lang));
    let plan = match (&args.query, &args.rule) {
        (Some(file), _) => plan::of_query(file, &framework, &catalogue)?,
        (None, Some(text)) => plan::of_text(text, args.target.as_deref(), &framework, &catalogue)?,
        (None, None) => plan::of_rules(&args.scenario, &framework, &catalogue),
    };
    let (mut plan, found) = match plan {
        Ok(p) => p,
        Err(found) => {
            say(found, global.lang);
            return Ok(output::FINDINGS);
        }
    };
    findings.extend(say(framework_folder::placed(dir, found), global.lang));

    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            say(vec![e.diagnostic()], global.lang);
            return Ok(output::FINDINGS);
        }
    };
    let bar = output::progress(lake.drive_ids().len());
    if let Some(limit) = args.limit {
        plan.questions.iter_mut().for_each(|q| q.limit = Some(limit));
    }
    let options = Options {
        jobs: args.jobs.map(usize::from),
        evaluator: if args.evaluator == "reference" { Evaluator::Reference } else { Evaluator::Fast },
        lang: global.lang,
    };
    let classes: Vec<ScenarioId> = plan.rules.rules.iter().map(|r| r.scenario.clone()).collect();
    let mut folder = FolderWriter::create(&args.out, &plan.questions, &classes)?;
    let done = |id: &_| {
        bar.set_message(format!("{id}"));
        bar.inc(1);
    };
    let unread = mine_each(&lake, &plan.rules, &options, done, |drive| folder.add(&drive));
    bar.finish_and_clear();
    let said = say(unread?, global.lang);
    // That the lake could not keep something loses nothing of the results.
    let lost = said.iter().any(|d| d.severity == Severity::Error);
    let summary = folder.finish(&framework.taxonomy, plan.searched)?;
    output::put(&table::table(&summary, &plan.questions, plan.searched, &framework.taxonomy, global.lang));
    say!("{}", written(&args.out, global.lang));
    Ok(if lost {
        output::lost_input()
    } else if findings.is_empty() {
        output::FINE
    } else {
        output::FINDINGS
    })
}

fn say(found: Vec<Diagnostic>, lang: Lang) -> Vec<Diagnostic> {
    for d in &found {
        tell!("{}", render_text(d, lang));
    }
    found
}

fn written(out: &Path, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("结果写入 {}", out.display()),
        Lang::En => format!("results are in {}", out.display()),
    }
}
