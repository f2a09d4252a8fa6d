//! `whyroad mine`: episodes out of a lake, by the framework's rules or by a JSON query.

use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_framework::{Framework, Taxonomy};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_mining::engine::{Evaluator, MinedLake, Options, mine_lake_with};
use whyroad_mining::language::Subject;
use whyroad_mining::output::folder::{Question, Summary};
use whyroad_mining::output::write_folder;
use whyroad_mining::rule::OTHER;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::rule::text::compile_text;
use whyroad_model::diagnostic::render_text;
use whyroad_model::messages::CoverageState;
use whyroad_model::{Bilingual, Diagnostic, Lang, ScenarioId, Severity};
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
    /// A rule in one line (docs/rules.md) instead of the framework's rules
    #[arg(long, value_name = "TEXT", conflicts_with = "query")]
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
        (Some(file), _) => of_query(file, &framework, &catalogue)?,
        (None, Some(text)) => of_text(text, args.target.as_deref(), &framework, &catalogue),
        (None, None) => of_rules(&args.scenario, &framework, &catalogue),
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
    let mut mined = mine_lake_with(&lake, &plan.rules, &options, |id| {
        bar.set_message(id.to_string());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let said = say(std::mem::take(&mut mined.diagnostics), global.lang);
    // That the lake could not keep something loses nothing of the results.
    let lost = said.iter().any(|d| d.severity == Severity::Error);
    keep(&mut mined, &plan.questions);
    let classes: Vec<ScenarioId> = plan.rules.rules.iter().map(|r| r.scenario.clone()).collect();
    let summary = write_folder(&args.out, &mined, &plan.questions, &framework.taxonomy, &classes)?;
    output::put(&table(&mined, &summary, &framework.taxonomy, global.lang));
    say!("{}", written(&args.out, global.lang));
    Ok(if lost {
        output::lost_input()
    } else if findings.is_empty() {
        output::FINE
    } else {
        output::FINDINGS
    })
}

/// What to run, and what to answer.
struct Plan {
    rules: RuleSet,
    questions: Vec<Question>,
}

type Planned = Result<(Plan, Vec<Diagnostic>), Vec<Diagnostic>>;

/// All rules are run even when one class is asked for: which episode is primary depends on all of them.
fn of_rules(wanted: &[String], framework: &Framework, catalogue: &Catalogue) -> Planned {
    let (rules, mut found) = RuleSet::of_framework(framework, catalogue);
    let rules = rules.with_decision_moments(catalogue);
    let mut classes = Vec::new();
    for text in wanted {
        match framework.taxonomy.resolve(text) {
            Resolution::Found(id) => classes.push(id),
            Resolution::Ambiguous(ids) => return Err(vec![class_ambiguous(text, &ids)]),
            Resolution::Unknown(near) => {
                let near: Vec<String> = near.iter().map(ToString::to_string).collect();
                return Err(vec![class_not_found(text, &near)]);
            }
        }
    }
    let has_rule = |id: &ScenarioId| rules.rules.iter().any(|r| r.scenario.is_within(id));
    for id in classes.iter().filter(|id| !has_rule(id)) {
        let message = Bilingual::new(format!("{id} 还没有挖掘规则"), format!("{id} has no mining rule yet"));
        found.push(Diagnostic::warning("mine.scenario.no_rule", message));
    }
    if wanted.is_empty() {
        classes = rules.rules.iter().map(|r| r.scenario.clone()).collect();
    } else if !classes.iter().any(has_rule) {
        return Err(found);
    }
    let question = |id: ScenarioId| Question { query_id: format!("rules_{id}"), scenario: id, limit: None };
    Ok((Plan { rules, questions: classes.into_iter().map(question).collect() }, found))
}

/// A question in one line belongs to no class: what it finds is reported as `other`.
fn of_text(text: &str, target: Option<&str>, framework: &Framework, catalogue: &Catalogue) -> Planned {
    let class = ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None };
    let target = target.and_then(Subject::from_word);
    let rule = compile_text(text, target, &class, catalogue, "--rule").map_err(|d| vec![*d])?;
    let question = Question { query_id: "rule".to_owned(), scenario: class, limit: None };
    let (all, _) = RuleSet::of_framework(framework, catalogue);
    let rules = RuleSet { rules: vec![rule], precedence: all.precedence };
    Ok((Plan { rules, questions: vec![question] }, vec![]))
}

fn of_query(file: &Path, framework: &Framework, catalogue: &Catalogue) -> anyhow::Result<Planned> {
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let name = file.display().to_string();
    let query = match parse_query(&text, &name, framework) {
        Ok(q) => q,
        Err(found) => return Ok(Err(found)),
    };
    let rule = match compile_query(&query, catalogue, &text, &name) {
        Ok(r) => r,
        Err(found) => return Ok(Err(found)),
    };
    let stem = file.file_stem().map_or_else(|| "query".to_owned(), |s| s.to_string_lossy().into_owned());
    let question = Question {
        query_id: query.query_id.clone().unwrap_or(stem),
        scenario: query.scenario_id.clone(),
        limit: query.output_limit,
    };
    let (all, _) = RuleSet::of_framework(framework, catalogue);
    let rules = RuleSet { rules: vec![rule], precedence: all.precedence };
    Ok(Ok((Plan { rules, questions: vec![question] }, vec![])))
}

/// Leaves out what nobody asked for.
fn keep(mined: &mut MinedLake, questions: &[Question]) {
    for drive in &mut mined.drives {
        drive.episodes.retain(|e| questions.iter().any(|q| e.record.scenario_id.is_within(&q.scenario)));
    }
}

fn say(found: Vec<Diagnostic>, lang: Lang) -> Vec<Diagnostic> {
    for d in &found {
        tell!("{}", render_text(d, lang));
    }
    found
}

/// What was found, what was searched for in vain, what could not be decided.
fn table(mined: &MinedLake, summary: &Summary, taxonomy: &Taxonomy, lang: Lang) -> String {
    let asked = |id: &ScenarioId| {
        let results = &summary.results;
        results.iter().any(|r| {
            let wanted = &r.mining_result.scenario_id;
            id.is_within(wanted) || wanted.is_within(id)
        })
    };
    let mut out = String::new();
    let head = match lang {
        Lang::Zh => ["类别", "片段", "主要", "已搜行程", "缺少的信号"],
        Lang::En => ["class", "episodes", "primary", "drives searched", "missing signals"],
    };
    let _ = writeln!(out, "{:<52} {:>8} {:>8} {:>15}  {}", head[0], head[1], head[2], head[3], head[4]);
    let rows = summary.coverage.unresolved.iter().chain(&summary.coverage.leaves);
    let mut rows: Vec<_> =
        rows.filter(|l| l.state != CoverageState::NoRule && asked(&l.scenario_id)).collect();
    let order = taxonomy.ids();
    rows.sort_by_key(|l| order.iter().position(|id| *id == l.scenario_id));
    for l in rows {
        let mut missing: Vec<&str> =
            l.gaps.iter().flat_map(|g| g.missing_signals.iter().map(String::as_str)).collect();
        missing.sort_unstable();
        missing.dedup();
        let _ = writeln!(
            out,
            "{:<52} {:>8} {:>8} {:>15}  {}",
            l.scenario_id.to_string(),
            // "0" would claim that there are none.
            if l.state == CoverageState::NotObservable { "-".to_owned() } else { l.episodes.to_string() },
            if l.state == CoverageState::NotObservable {
                "-".to_owned()
            } else {
                l.primary_episodes.to_string()
            },
            format!("{}/{}", l.drives_searched, mined.drives.len()),
            missing.join(", ")
        );
    }
    let count = |s: CoverageState| summary.coverage.leaves.iter().filter(|l| l.state == s).count();
    let (found, none) = (count(CoverageState::Found), count(CoverageState::NotFound));
    let (blind, without) = (count(CoverageState::NotObservable), count(CoverageState::NoRule));
    let episodes: usize = mined.drives.iter().map(|d| d.episodes.len()).sum();
    let _ = match lang {
        Lang::Zh => writeln!(
            out,
            "{} 个行程，{episodes} 个片段；叶子类别：找到 {found}，搜索未见 {none}，不可观测 {blind}，尚无规则 {without}",
            mined.drives.len()
        ),
        Lang::En => writeln!(
            out,
            "{} drives, {episodes} episodes; leaves: {found} found, {none} searched and not found, {blind} not observable, {without} without a rule",
            mined.drives.len()
        ),
    };
    out
}

fn written(out: &Path, lang: Lang) -> String {
    match lang {
        Lang::Zh => format!("结果写入 {}", out.display()),
        Lang::En => format!("results are in {}", out.display()),
    }
}
