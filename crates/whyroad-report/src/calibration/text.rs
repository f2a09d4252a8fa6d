//! The table as text.

use super::CalibrationError;
use std::fmt::Write as _;
use whyroad_framework::Calibration;
use whyroad_model::Lang;

/// The table, uncalibrated classes last, with the held-out errors of shares and margin scores.
pub fn render(
    table: &Calibration,
    errors: Option<&(CalibrationError, CalibrationError)>,
    lang: Lang,
) -> String {
    let zh = lang == Lang::Zh;
    let mut out = String::new();
    let head = if zh {
        ["场景", "判定", "正确", "95 % 区间", "得分：正确比例（判定数）"]
    } else {
        ["class", "judged", "right", "95 % interval", "share by margin score (judged)"]
    };
    let width = table.classes.iter().map(|c| c.id.to_string().len()).max().unwrap_or(0).max(head[0].len());
    let _ =
        writeln!(out, "{:<width$}  {:>6}  {:>6}  {:>13}  {}", head[0], head[1], head[2], head[3], head[4]);
    let (usable, rest): (Vec<_>, Vec<_>) = table.classes.iter().partition(|c| c.is_usable());
    for c in usable.iter().chain(&rest) {
        let steps: Vec<String> = c
            .steps
            .iter()
            .map(|s| format!("{:.1}: {:.0} % ({})", s.from, s.share * 100.0, s.judged))
            .collect();
        let steps = match (c.is_usable(), zh) {
            (true, _) => steps.join(", "),
            (false, true) => "判定过少，不校准".to_owned(),
            (false, false) => "too few, not calibrated".to_owned(),
        };
        let interval = format!("{:.0} - {:.0} %", c.interval[0] * 100.0, c.interval[1] * 100.0);
        let _ = writeln!(
            out,
            "{:<width$}  {:>6}  {:>6}  {interval:>13}  {steps}",
            c.id.to_string(),
            c.judged,
            c.right
        );
    }
    let (judged, right) = table.totals();
    let _ = if zh {
        writeln!(out, "\n{} 个已校准类别；{judged} 个判定事件中 {right} 个正确", usable.len())
    } else {
        writeln!(out, "\n{} classes calibrated; {right} of {judged} judged episodes are right", usable.len())
    };
    if let Some((shares, margins)) = errors {
        let _ = if zh {
            writeln!(
                out,
                "在未参与拟合的行程上（5 折，{} 个事件）：期望校准误差 {:.3}，Brier {:.3}；直接用条件余量得分：{:.3}，{:.3}",
                shares.episodes, shares.expected, shares.brier, margins.expected, margins.brier
            )
        } else {
            writeln!(
                out,
                "on drives held out (5 folds, {} episodes): expected calibration error {:.3}, Brier {:.3}; margin scores: {:.3}, {:.3}",
                shares.episodes, shares.expected, shares.brier, margins.expected, margins.brier
            )
        };
    }
    out
}
