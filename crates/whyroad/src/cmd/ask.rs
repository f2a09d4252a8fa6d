//! `whyroad ask`: a question in words becomes a mining rule through a model; the rule is shown, explained and run.

use super::mine::{self, rule_name};
use crate::model_args::{ModelArgs, cost, tell_all};
use crate::output::Print;
use crate::{Global, framework_folder, output};
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_chat::ask::{Asked, ask};
use whyroad_mining::rule::Rule;
use whyroad_model::{Bilingual, Diagnostic, Lang, ScenarioId};
use whyroad_signals::Catalog;

/// Arguments of `whyroad ask`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// What to look for, in words
    #[arg(value_name = "QUESTION")]
    question: String,
    /// The model at this address (OpenAI-compatible, https://host/v1)
    #[arg(long, value_name = "URL")]
    model: String,
    /// Lake to search; without it the rule is only shown
    #[arg(long, value_name = "DIR", requires = "out")]
    lake: Option<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "DIR", requires = "lake")]
    out: Option<PathBuf>,
    /// Replace results of another question in that folder
    #[arg(long, requires = "out")]
    force: bool,
    /// Name of the rule; its matches are custom.NAME [default: rule]
    #[arg(long, value_name = "NAME", value_parser = rule_name)]
    name: Option<String>,
    /// Maximum number of times that errors of a rule are sent back to the model
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=10))]
    corrections: u32,
    #[command(flatten)]
    how: ModelArgs,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let cache = args
        .out
        .as_ref()
        .map_or_else(|| PathBuf::from("whyroad-ask.answers"), |o| o.with_extension("answers"));
    let client = args.how.client(&args.model, cache, global.lang)?;
    let scenario = ScenarioId::custom(args.name.as_deref().unwrap_or("rule"));
    let asked =
        ask(&client, (&framework, &catalog), &args.question, &scenario, global.lang, args.corrections);
    let asked = match asked {
        Ok(asked) => asked,
        Err(e) => {
            tell_all(&[e.diagnostic()], global.lang);
            return Ok(output::FINDINGS);
        }
    };
    let Some(rule) = &asked.rule else {
        let faults: Vec<Diagnostic> = asked.attempts.last().map(|a| a.faults.clone()).unwrap_or_default();
        tell_all(&[no_rule(&asked)], global.lang);
        tell_all(&faults, global.lang);
        let report = json!({ "question": args.question, "attempts": asked.attempts, "rule": null, "spent": client.spent() });
        args.print.put(&report, String::new)?;
        return Ok(output::FINDINGS);
    };
    let spent = client.spent();
    let said = shown(&asked, rule, global.lang);
    let last = asked.attempts.last();
    let (text, target) = last.map(|a| (a.rule.clone(), a.target.clone())).unwrap_or_default();
    let mined = match (&args.lake, &args.out) {
        (Some(lake), Some(out)) => {
            let search =
                mine::Args::of_rule(lake.clone(), text.clone(), args.name.clone(), out.clone(), args.force);
            Some(mine::search(global, search.with_target(target.clone()))?)
        }
        _ => None,
    };
    let conditions: Vec<&str> = rule.parts.iter().map(|p| p.text.as_str()).collect();
    let (code, results) = mined.map_or((output::FINE, None), |m| (m.code, m.results));
    let report = json!({
        "question": args.question, "rule": text, "target": target, "conditions": conditions,
        "explanation": last.map(|a| &a.explanation), "attempts": asked.attempts,
        "results": results.as_ref().map(|(json, _)| json), "spent": spent,
    });
    args.print.put(&report, || {
        let found = results.as_ref().map(|(_, text)| format!("\n{text}")).unwrap_or_default();
        format!("{said}{}\n{found}", cost(&spent, global.lang))
    })?;
    Ok(code)
}

/// The rule with the model's words and the program's own reading.
fn shown(asked: &Asked, rule: &Rule, lang: Lang) -> String {
    let mut out = String::new();
    let Some(last) = asked.attempts.last() else { return out };
    let corrections = asked.attempts.len() - 1;
    let target = last.target.as_deref();
    let _ = match lang {
        Lang::Zh => writeln!(
            out,
            "规则：{}\n目标：{}\n模型的说明：{}\n逐项条件：",
            last.rule,
            target.unwrap_or("无"),
            last.explanation
        ),
        Lang::En => writeln!(
            out,
            "rule: {}\ntarget: {}\nexplanation of the model: {}\nconditions:",
            last.rule,
            target.unwrap_or("none"),
            last.explanation
        ),
    };
    for part in &rule.parts {
        let _ = writeln!(out, "  {}", part.text);
    }
    if corrections > 0 {
        let _ = match lang {
            Lang::Zh => writeln!(out, "模型改正了 {corrections} 次"),
            Lang::En => writeln!(out, "corrected by the model {corrections} times"),
        };
    }
    out
}

fn no_rule(asked: &Asked) -> Diagnostic {
    let n = asked.attempts.len();
    let text = asked.attempts.last().map(|a| a.rule.clone()).unwrap_or_default();
    let message = Bilingual::new(
        format!("模型给出的 {n} 条规则都有错误，最后一条：{text}"),
        format!("all {n} rules of the model have errors, the last one is: {text}"),
    );
    Diagnostic::error("ask.rule", message)
}
