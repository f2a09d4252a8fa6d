//! `whyroad mine --plan` and `--drives`: a lake divided among workers, and the work of one of them.

use super::plan::Plan;
use super::{Args, say};
use crate::output::DataFormat;
use crate::output::reason::cannot_write;
use crate::text_table::{Align, aligned};
use crate::{Global, output};
use anyhow::{Context as _, anyhow};
use serde_json::json;
use std::io::Read as _;
use std::path::Path;
use std::process::ExitCode;
use whyroad_engine::mine::MineOptions;
use whyroad_engine::output::query::{self, ClassQuery};
use whyroad_engine::parts::{PartError, PartOptions, Request, Versions, WorkList, plan, work};
use whyroad_framework::Framework;
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_model::{Lang, ScenarioId};
use whyroad_signals::Catalog;

/// Prints the work lists of a lake, one JSON document per line, or writes them to files.
pub(super) fn print_plan(global: &Global, args: &Args, lists: usize) -> anyhow::Result<ExitCode> {
    let lake = match Lake::open(&args.lake) {
        Ok(lake) => lake,
        Err(e) => {
            say(vec![e.diagnostic()], global.lang);
            return Ok(output::FINDINGS);
        }
    };
    let lists = plan(&lake, lists);
    let Some(out) = &args.out else {
        match args.print.format {
            DataFormat::Json => output::put_json(&lists)?,
            DataFormat::Text => {
                for list in &lists {
                    output::put(&format!("{}\n", serde_json::to_string(list)?));
                }
            }
        }
        return Ok(output::FINE);
    };
    std::fs::create_dir_all(out).with_context(|| cannot_write(out.display()))?;
    let head = match global.lang {
        Lang::Zh => ["清单", "行程", "行数"],
        Lang::En => ["list", "drives", "rows"],
    };
    let mut rows = vec![head.map(str::to_owned)];
    for list in &lists {
        let path = out.join(format!("list-{}.json", list.list));
        let text = serde_json::to_string(list)? + "\n";
        std::fs::write(&path, text).with_context(|| cannot_write(path.display()))?;
        rows.push([path.display().to_string(), list.drives.len().to_string(), list.rows().to_string()]);
    }
    let summary: Vec<_> =
        lists.iter().map(|l| json!({"list": l.list, "drives": l.drives.len(), "rows": l.rows()})).collect();
    args.print.put(&summary, || aligned([Align::Left, Align::Right, Align::Right], &rows))?;
    Ok(output::FINE)
}

/// Inputs of a worker.
pub(super) struct Work<'a> {
    pub list: &'a Path,
    pub out: &'a Path,
    pub lake: &'a Lake,
    pub plan: Plan,
    pub classes: Vec<ScenarioId>,
    pub framework: &'a Framework,
    pub catalog: &'a Catalog,
}

/// Mines the drives of a work list into a part.
pub(super) fn mine(global: &Global, args: &Args, of: Work<'_>) -> anyhow::Result<ExitCode> {
    let lang = global.lang;
    let list = if of.list == Path::new("-") {
        let mut text = String::new();
        std::io::stdin().read_to_string(&mut text)?;
        WorkList::parse(&text, Path::new("<stdin>"))?
    } else {
        WorkList::read(of.list)?
    };
    let Plan { rules, questions, searched, asked, query } = of.plan;
    let request = Request { asked, questions, classes: of.classes, searched, lang, clips: args.clips.cut() };
    let options = PartOptions {
        mine: MineOptions {
            jobs: args.jobs.map(usize::from),
            lang,
            clips: args.clips.cut(),
            once: args.once,
            ..MineOptions::default()
        },
        deaths: usize::from(args.deaths),
        restart: args.force,
    };
    let (all, _) = RuleSet::of_framework(of.framework, of.catalog);
    let versions = Versions::of(&of.framework.taxonomy, &all, &rules);
    let bar = output::progress(list.drives.len());
    let done = |id: &_| {
        bar.set_message(format!("{id}"));
        bar.inc(1);
    };
    let query = query.as_ref().map(|class| ClassQuery::new(class, &rules, of.lake, lang));
    let answer = |drive| match &query {
        Some(query) => query::answer(&drive, query),
        None => drive,
    };
    let worked = work(of.lake, &rules, (versions, request, list), &options, of.out, done, answer);
    bar.finish_and_clear();
    let worked = match worked {
        Err(PartError::OtherWork(dir)) => return Err(anyhow!(other_work(&dir, lang))),
        Err(PartError::Busy(dir)) => return Err(anyhow!(busy(&dir, lang))),
        worked => worked?,
    };
    let mut found: Vec<_> = worked.failed.iter().map(whyroad_engine::parts::Failed::diagnostic).collect();
    found.extend(worked.diagnostics);
    say(found, lang);
    let (n, resumed, failed) = (worked.drives, worked.resumed, worked.failed.len());
    let ids: Vec<_> = worked.failed.iter().map(|f| &f.drive_id).collect();
    args.print.put(&json!({"drives": n, "resumed": resumed, "failed": ids}), || match lang {
        Lang::Zh => format!("{n} 个行程已完成（其中 {resumed} 个由先前的进程完成），{failed} 个搁置\n"),
        Lang::En => format!("{n} drives done ({resumed} by an earlier worker), {failed} set aside\n"),
    })?;
    Ok(if failed > 0 { output::lost_input() } else { output::FINE })
}

fn other_work(dir: &Path, lang: Lang) -> String {
    let dir = dir.display();
    match lang {
        Lang::Zh => {
            format!("{dir} 中是另一清单、查询或版本的分片，未作改动；请换一个文件夹，或用 --force 重新开始")
        }
        Lang::En => format!(
            "{dir} holds a part of another list, question or version and was left unchanged; choose another folder, or \
             begin again with --force"
        ),
    }
}

fn busy(dir: &Path, lang: Lang) -> String {
    let dir = dir.display();
    match lang {
        Lang::Zh => format!("另一进程正在写入 {dir}"),
        Lang::En => format!("another worker is writing {dir}"),
    }
}
