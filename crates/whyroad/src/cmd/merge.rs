//! `whyroad merge`: the parts that workers mined, as one mined folder.

use super::mine::missing::MissingArgs;
use super::mine::{busy, other_question, table::Results};
use crate::output::{Print, render_text};
use crate::{Global, framework_folder, output};
use std::path::PathBuf;
use std::process::ExitCode;
use whyroad_engine::parts::{Expected, Failed, MergeError, Part, merge};
use whyroad_lake::Lake;
use whyroad_lake::mined::PublishError;
use whyroad_mining::RuleSet;
use whyroad_model::{Diagnostic, Lang};
use whyroad_signals::Catalog;

/// Arguments of `whyroad merge`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Parts that `whyroad mine --drives` wrote, or folders of parts
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Lake whose drives must all be in the parts [default: the drives of the plan of the parts]
    #[arg(long, value_name = "DIR")]
    lake: Option<PathBuf>,
    /// Mined folder to write; created or replaced atomically
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace results of another question in that folder
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let lang = global.lang;
    let (framework, _) = framework_folder::load(global)?;
    let (catalog, _) = Catalog::parse(&framework.signals_yaml);
    let rules = RuleSet::of_framework(&framework, &catalog).0;
    let faulty = rules.unusable(&framework);
    let mut parts = Vec::new();
    for dir in &args.parts {
        parts.extend(Part::find(dir)?);
    }
    let lake = match args.lake.as_deref().map(Lake::open).transpose() {
        Ok(lake) => lake,
        Err(e) => return Ok(say(&[e.diagnostic()], lang)),
    };
    let expected = lake.as_ref().map_or(Expected::Plan, Expected::Lake);
    let merged = merge(&parts, expected, (&framework.taxonomy, &rules), &args.out, args.force);
    let merged = match merged {
        Err(MergeError::Publish(PublishError::OtherQuestion(dir))) => {
            say!("{}", other_question(&dir, lang));
            return Ok(output::FINDINGS);
        }
        Err(MergeError::Publish(PublishError::Busy(dir))) => {
            say!("{}", busy(&dir, lang));
            return Ok(output::FINDINGS);
        }
        merged => match merged? {
            Ok(merged) => merged,
            Err(found) => {
                let code = say(&found, lang);
                say!("{}", nothing_written(lang));
                return Ok(code);
            }
        },
    };
    let failed: Vec<Diagnostic> = merged.failed.iter().map(Failed::diagnostic).collect();
    say(&failed, lang);
    let results = Results {
        summary: &merged.summary,
        asked: &merged.request.asked,
        questions: &merged.request.questions,
        searched: merged.request.searched,
        taxonomy: &framework.taxonomy,
        faulty: &faulty,
        lang,
    };
    let missing = args.missing.list(&results, lake.as_ref())?;
    args.print.put(&results.json(), || results.text(missing))?;
    Ok(if failed.is_empty() { output::FINE } else { output::lost_input() })
}

fn say(found: &[Diagnostic], lang: Lang) -> ExitCode {
    for d in found {
        tell!("{}", render_text(d, lang));
    }
    output::FINDINGS
}

fn nothing_written(lang: Lang) -> &'static str {
    match lang {
        Lang::Zh => "未写入任何结果",
        Lang::En => "nothing was written",
    }
}
