//! An evaluation as a table for the terminal.

use super::{ClassFigures, Evaluation};
use std::fmt::Write as _;
use whyroad_model::Lang;

/// The table, confusions below it. Classes that are neither in the truth nor judged are left out: they are counted in
/// one line.
pub fn render(evaluation: &Evaluation, lang: Lang) -> String {
    let pick = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    let shown: Vec<_> = evaluation
        .classes
        .iter()
        .filter(|(_, c)| c.truth > 0 || c.spurious > 0)
        .map(|(id, c)| (id.to_string(), c))
        .collect();
    let width = shown.iter().map(|(id, _)| id.len()).max().unwrap_or(0).max(20);
    let _ = writeln!(
        out,
        "{:width$} {:>6} {:>6} {:>6} {:>6} {:>9} {:>7} {:>7} {:>9} {:>7}",
        pick("class", "class"),
        "truth",
        "found",
        "missed",
        "false",
        "precision",
        "recall",
        "F1",
        "median s",
        "p90 s"
    );
    for (id, c) in &shown {
        let _ = writeln!(out, "{id:width$} {}", row(c));
    }
    let _ = writeln!(out, "{:width$} {}", pick("total", "total"), row(&evaluation.total));
    let _ = writeln!(
        out,
        "\n{} {} ({} {})",
        pick("宏平均 F1", "macro F1"),
        figure(evaluation.macro_f1),
        evaluation.macro_classes,
        pick("个出现的类别", "classes that occur"),
    );
    let _ = writeln!(
        out,
        "{} {} s",
        pick("关键帧误差中位数", "median keyframe error"),
        figure(evaluation.keyframe_error_median_s),
    );
    let unjudged = evaluation.total.unjudged;
    if unjudged > 0 {
        let _ = writeln!(
            out,
            "{unjudged} {}",
            pick(
                "个事件的类别在真值中未声明完整，或只对应可选的真值，未作评判",
                "episodes not judged: the truth is not declared complete for their class, or only an optional entry matches"
            ),
        );
    }
    if !evaluation.confusions.is_empty() {
        let _ = writeln!(out, "\n{}", pick("漏检处找到的类别：", "found instead of missed entries:"));
        for c in &evaluation.confusions {
            let _ = writeln!(out, "{:>5}  {} -> {}", c.count, c.truth, c.found);
        }
    }
    out
}

fn row(c: &ClassFigures) -> String {
    format!(
        "{:>6} {:>6} {:>6} {:>6} {:>9} {:>7} {:>7} {:>9} {:>7}",
        c.truth,
        c.matched,
        c.missed,
        c.spurious,
        figure(c.precision),
        figure(c.recall),
        figure(c.f1),
        figure(c.keyframe_error_median_s),
        figure(c.keyframe_error_p90_s),
    )
}

/// Three decimals; `-` without a value.
fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.3}"))
}
