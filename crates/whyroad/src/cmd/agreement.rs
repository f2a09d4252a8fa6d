//! `whyroad agreement`: agreement of two annotators, or of a judge and people, beyond chance, with intervals.

use crate::output::Print;
use crate::output::reason::{cannot_read, reason, stop};
use crate::{Global, output, store_args};
use anyhow::Context as _;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_chat::judge::{JudgedLabel, PeopleAgreement, agreement_with_people, agreement_with_tasks};
use whyroad_label::agreement::{Agreement, Estimate, Judged, agreement, pair_files, pair_tasks};
use whyroad_model::Lang;
use whyroad_server::service::transfer::{self, ExportFormat};

/// Arguments of `whyroad agreement`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Labels of two annotators (two files of `tasks export`); tasks of several (one file of `tasks export --content
    /// tasks`); or answers of `judge` and of people (or tasks), in this order. Without a file: the store's tasks
    #[arg(value_name = "FILE", num_args = 0..=2)]
    files: Vec<PathBuf>,
    /// Project of the store
    #[arg(long, value_name = "NAME", conflicts_with = "files", required_unless_present = "files")]
    project: Option<String>,
    #[command(flatten)]
    store: store_args::StoreArgs,
    /// Seed of the intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    print: Print,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let files: Vec<(String, Vec<Value>)> =
        args.files.iter().map(|f| Ok((name(f), documents(f)?))).collect::<anyhow::Result<_>>()?;
    let lang = global.lang;
    let judged = match (files.as_slice(), &args.project) {
        ([(_, first), (_, second)], _) if is_judged(first) => {
            return of_judge(&args, first, second, lang);
        }
        ([(a, first), (b, second)], _) => {
            // Two files with the same name are still two raters.
            let b = if a == b { format!("{b} (2)") } else { b.clone() };
            pair_files((a, first), (&b, second))
        }
        ([(_, tasks)], _) => pair_tasks(tasks),
        (_, Some(project)) => pair_tasks(&stored(&args, project, lang)?),
        _ => return Err(stop("请给出一个或两个文件，或 --project", "name one or two files, or --project")),
    };
    if judged.items.is_empty() {
        say!(
            "{}",
            match lang {
                Lang::Zh => "没有任何事件有两份标注",
                Lang::En => "no episode has two labels",
            }
        );
    }
    let of = agreement(&judged.items, args.seed);
    let report = json!({
        "agreement": of, "unmatched_labels": judged.unmatched, "tasks_not_submitted": judged.waiting,
        "tasks_left_out": judged.left_out,
        "unreadable_lines": judged.unreadable,
    });
    args.print.put(&report, || text(&of, &judged, lang))?;
    Ok(match (judged.items.len(), judged.unreadable) {
        (0, _) => output::FINDINGS,
        (_, 0) => output::FINE,
        _ => output::lost_input(),
    })
}

fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// JSON Lines, or one document.
fn documents(path: &Path) -> anyhow::Result<Vec<Value>> {
    let text = std::fs::read_to_string(path).with_context(|| cannot_read(path.display()))?;
    let all: Result<Vec<Value>, _> = serde_json::Deserializer::from_str(&text).into_iter().collect();
    let all = all.with_context(|| {
        reason(format!("{} 不是 JSON Lines", path.display()), format!("{} is not JSON Lines", path.display()))
    })?;
    Ok(match <[Value; 1]>::try_from(all) {
        Ok([Value::Array(items)]) => items,
        Ok([one]) => vec![one],
        Err(all) => all,
    })
}

fn is_judged(documents: &[Value]) -> bool {
    documents.first().is_some_and(|d| d.get("questions").is_some())
}

/// The tasks of a project as `tasks export --content tasks` writes them.
fn stored(args: &Args, project: &str, lang: Lang) -> anyhow::Result<Vec<Value>> {
    let problem = |p| store_args::error(&p, lang);
    let store = args.store.open_existing(lang)?;
    let project = super::tasks::find(&store, project, lang)?;
    let mut out = Vec::new();
    transfer::export_to(&store, &project, &ExportFormat::Tasks, &mut out).map_err(problem)?;
    serde_json::Deserializer::from_slice(&out).into_iter().map(|v| Ok(v?)).collect()
}

fn of_judge(args: &Args, judge: &[Value], people: &[Value], lang: Lang) -> anyhow::Result<ExitCode> {
    let read = |all: &[Value]| -> anyhow::Result<Vec<JudgedLabel>> {
        all.iter()
            .map(|v| serde_json::from_value(v.clone()).context("not a line of `whyroad judge`"))
            .collect()
    };
    let judged = read(judge)?;
    let of = match is_judged(people) {
        true => agreement_with_people(&judged, &read(people)?, args.seed),
        false => agreement_with_tasks(&judged, people, args.seed),
    };
    args.print.put(&of, || judge_text(&of, lang))?;
    Ok(if of.labels == 0 { output::FINDINGS } else { output::FINE })
}

/// `0.74 [0.61, 0.85]`
fn shown(e: &Estimate, digits: usize) -> String {
    let value = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"));
    match (e.low, e.high) {
        (Some(_), Some(_)) => format!("{} [{}, {}]", value(e.value), value(e.low), value(e.high)),
        _ => value(e.value),
    }
}

fn text(of: &Agreement, judged: &Judged, lang: Lang) -> String {
    let mut out = String::new();
    let (episodes, raters) = (of.episodes, of.raters.join(", "));
    let raters = match (raters.is_empty(), lang) {
        (true, _) => raters,
        (false, Lang::Zh) => format!("（{raters}）"),
        (false, Lang::En) => format!(" ({raters})"),
    };
    let (unmatched, unreadable) = (judged.unmatched, judged.unreadable);
    let zh = lang == Lang::Zh;
    let waiting = match (judged.waiting, zh) {
        (0, _) => String::new(),
        (n, true) => format!("；{n} 个任务尚未提交"),
        (n, false) => format!("; {n} tasks not submitted yet"),
    };
    let left_out = match (judged.left_out, zh) {
        (0, _) => String::new(),
        (n, true) => format!("；{n} 个任务已跳过或剔除"),
        (n, false) => format!("; {n} tasks skipped or rejected"),
    };
    let waiting = waiting + &left_out;
    let _ = if zh {
        writeln!(
            out,
            "{episodes} 个事件有两份以上标注{raters}；{unmatched} 份标注没有对应{waiting}；{unreadable} 行无法读取\n"
        )
    } else {
        writeln!(
            out,
            "{episodes} episodes with two or more labels{raters}; {unmatched} labels without a counterpart{waiting}; {unreadable} lines not readable\n"
        )
    };
    let head = if zh {
        ["部分", "一致率", "Cohen κ", "Krippendorff α"]
    } else {
        ["part", "same", "Cohen's kappa", "Krippendorff's alpha"]
    };
    let _ = writeln!(out, "{:<18} {:<20} {:<22} {}", head[0], head[1], head[2], head[3]);
    for p in &of.parts {
        let _ = writeln!(
            out,
            "{:<18} {:<20} {:<22} {}",
            part(p.part, lang),
            shown(&p.same, 2),
            shown(&p.kappa, 2),
            shown(&p.alpha, 2)
        );
    }
    let (k, c) = (&of.keyframe, &of.components);
    let (median, near, alpha, f1) =
        (shown(&k.median_s, 2), shown(&k.within_half_second, 2), shown(&k.alpha, 3), shown(&c.f1, 2));
    let [first, second, common] = c.counts;
    let _ = if zh {
        writeln!(
            out,
            "\n关键帧：中位差 {median} s；相差不超过 0.5 s 的比例 {near}；α（区间尺度）{alpha}\n要素：F1 {f1}（所有标注两两相比：{first} 与 {second} 个，共同 {common} 个）"
        )
    } else {
        writeln!(
            out,
            "\nkeyframe: median difference {median} s; within 0.5 s {near}; alpha (interval scale) {alpha}\ncomponents: F1 {f1} (over all pairs of labels: {first} and {second}, {common} in common)"
        )
    };
    let parts = of.parts.iter().flat_map(|p| [&p.same, &p.kappa, &p.alpha]);
    let mut all = parts.chain([&k.median_s, &k.within_half_second, &k.alpha, &c.f1]);
    if all.any(|e| e.low.is_some()) {
        out.push_str(if zh {
            "方括号内为 95 % 自助法区间\n"
        } else {
            "in brackets: 95 % bootstrap interval over episodes\n"
        });
    }
    out
}

/// The name of a part of a label.
fn part(name: &str, lang: Lang) -> &str {
    match (lang, name) {
        (Lang::Zh, "class") => "场景",
        (Lang::Zh, "l2") => "L2",
        (Lang::Zh, "longitudinal") => "纵向决策",
        (Lang::Zh, "lateral") => "横向决策",
        (Lang::Zh, "lateral_direction") => "横向方向",
        _ => name,
    }
}

fn judge_text(of: &PeopleAgreement, lang: Lang) -> String {
    let mut out = String::new();
    let (labels, unmatched) = (of.labels, of.unmatched);
    let zh = lang == Lang::Zh;
    let _ = if zh {
        writeln!(out, "{labels} 个标注由模型和人都判定过；{unmatched} 个没有对应或没有回答\n")
    } else {
        writeln!(
            out,
            "{labels} labels judged by the model and by people; {unmatched} without a counterpart or an answer\n"
        )
    };
    let head = if zh {
        ["类型", "回答数", "一致率", "Cohen κ", "双方/仅模型/仅人/均未 发现问题"]
    } else {
        ["kind", "answers", "same", "Cohen's kappa", "fault found by both/model/people/none"]
    };
    let _ = writeln!(out, "{:<16} {:>8}  {:<20} {:<22} {}", head[0], head[1], head[2], head[3], head[4]);
    for k in &of.kinds {
        let [both, model, people, none] = k.counts;
        let _ = writeln!(
            out,
            "{:<16} {:>8}  {:<20} {:<22} {both}/{model}/{people}/{none}",
            k.kind,
            k.answers,
            shown(&k.same, 2),
            shown(&k.kappa, 2)
        );
    }
    out
}
