//! Labeling: throughput, finish and cost, agreement, corrections, and decisions.

use super::{Align, ClassNames, count, head, number};
use crate::analytics::corrections::SHIFTS_S;
use crate::analytics::forecast::NoForecast;
use crate::analytics::text::hours;
use crate::analytics::{
    Analytics, Channel, Corrections, DecisionBasis, FinishBasis, Measure, Progress, WeekRow,
};
use whyroad_model::Bilingual;
use whyroad_model::display::number as text;
use whyroad_render::charts;
use whyroad_render::markup::Markup;

/// Weeks in a chart.
const WEEKS: usize = 26;

pub(super) fn progress(m: &mut Markup, a: &Analytics) {
    let Some(p) = &a.progress else { return };
    m.raw("<h3>").say("进度与趋势", "Throughput and trends").raw("</h3><ul class=\"plain\"><li>");
    finish(m, p);
    m.raw("</li><li>").say("人工用时：", "Time worked: ").text(&hours(p.worked_h)).raw("</li><li>");
    m.say("每个已接受标注的成本：", "Cost per accepted label: ");
    match &p.cost {
        Some(c) => {
            m.raw("<b>").num(c.per_label, 2).raw(" ").text(&c.currency).raw("</b> (");
            m.say("合计 ", "total ").num(c.total, 2).raw(" ").text(&c.currency).raw(")");
        }
        None => drop(m.say(
            "未知：未提供工时费率，或尚无已接受标注。",
            "unknown: no hourly rate was given, or nothing is accepted yet.",
        )),
    }
    m.raw("</li></ul>");
    let weeks = &p.weeks[p.weeks.len().saturating_sub(WEEKS)..];
    if !weeks.is_empty() {
        m.raw("<div class=\"charts\">");
        let chart = |m: &mut Markup, zh: &str, en: &str, digits, of: fn(&WeekRow) -> Option<f64>| {
            let entries: Vec<(String, Option<f64>)> = weeks.iter().map(|w| (w.week.clone(), of(w))).collect();
            m.piece(&charts::columns(&Bilingual::new(zh, en), &entries, digits));
        };
        chart(m, "每周提交的标注", "Labels submitted per week", 0, |w| Some(w.submitted as f64));
        chart(m, "每周接受的标注", "Labels accepted per week", 0, |w| Some(w.accepted as f64));
        chart(
            m,
            "曾被退回的比例（%，已接受标注）",
            "Returned at least once (% of accepted labels)",
            0,
            |w| (w.accepted > 0).then(|| 100.0 * w.returned as f64 / w.accepted as f64),
        );
        chart(
            m,
            "每个标注平均修改的字段数",
            "Fields changed per accepted label (mean)",
            1,
            |w| w.fields_changed,
        );
        m.raw("</div>");
    }
    if !p.people.is_empty() {
        m.raw("<p class=\"faint\">");
        m.say(
            "按标注人统计标注：返工后再次提交不另计。每个用户的操作次数见看板的“每日产出”。",
            "Labels by author; a label submitted again after rework counts once. \
             The dashboard counts the actions of each user.",
        );
        m.raw("</p><table>");
        head(
            m,
            &[
                ("标注人", "author", Align::Text),
                ("提交的标注", "labels submitted", Align::Number),
                ("其中已接受", "of these accepted", Align::Number),
                ("被退回次数", "times returned", Align::Number),
            ],
        );
        m.raw("<tbody>");
        for row in &p.people {
            m.raw("<tr><th scope=\"row\">").text(&row.name).raw("</th>");
            for n in [row.submitted, row.accepted, row.returned] {
                m.raw("<td class=\"n\">").int(n).raw("</td>");
            }
            m.raw("</tr>");
        }
        m.raw("</tbody></table>");
    }
}

fn finish(m: &mut Markup, p: &Progress) {
    let f = &p.finish;
    m.say("剩余 ", "Remaining: ").raw("<b>").int(f.remaining).raw("</b> ");
    match f.basis {
        FinishBasis::Wanted => m.say("个标注（按目标）。", "labels (against the target). "),
        FinishBasis::Unfinished => m.say(
            "个有任务而尚无已接受标注的事件（未设目标）。",
            "episodes with a task and without an accepted label (no target is set). ",
        ),
    };
    m.say("预计完成：", "Forecast of the finish: ");
    match (&f.date, &f.interval, f.reason) {
        (Some(date), Some((low, high)), _) => {
            m.raw("<b>").text(date).raw("</b> (80 %: ").text(low).raw(" – ");
            match high {
                Some(high) => m.text(high),
                None => m.say("十年以后", "beyond ten years"),
            };
            m.raw(") <span class=\"faint\">");
            m.say(
                "由最近至多 56 天的每日接受数按 7 天分块重抽样（Künsch 1989）",
                "daily accepted labels of at most the last 56 days, resampled in blocks of 7 days (Künsch 1989)",
            )
            .raw("</span>");
        }
        (_, _, Some(NoForecast::Done)) => drop(m.say("已完成。", "done.")),
        (_, _, Some(NoForecast::NoProgress)) => {
            m.say(
                "未知：近 56 天没有接受的标注，或需时超过十年。",
                "unknown: nothing was accepted in the last 56 days, or it would take more than ten years.",
            );
        }
        _ => drop(m.say("未知：至少需要 14 天的记录。", "unknown: at least 14 days of history are needed.")),
    }
}

pub(super) fn agreement(m: &mut Markup, a: &Analytics) {
    if !a.given.tasks {
        return;
    }
    m.raw("<h3>").say("标注一致性", "Agreement").raw("</h3>");
    if a.agreement.is_empty() {
        m.raw("<p>")
            .say("没有由多人独立标注的事件。", "No episode was labeled by more than one person.")
            .raw("</p>");
        return;
    }
    m.raw("<table>");
    head(
        m,
        &[
            ("项目", "measure", Align::Text),
            ("事件", "episodes", Align::Number),
            ("标注对", "pairs", Align::Number),
            ("相同 %", "same %", Align::Number),
            ("Cohen κ", "Cohen κ", Align::Number),
            ("Fleiss κ", "Fleiss κ", Align::Number),
            ("相差中位数 s", "median distance s", Align::Number),
        ],
    );
    m.raw("<tbody>");
    for row in &a.agreement {
        let (zh, en) = row.measure.name();
        m.raw("<tr><th scope=\"row\">").say(zh, en).raw("</th><td class=\"n\">").int(row.episodes);
        m.raw("</td><td class=\"n\">").int(row.pairs).raw("</td><td class=\"n\">");
        number(m, row.same.map(|s| s * 100.0), 0);
        for kappa in [row.cohen, row.fleiss] {
            m.raw("</td><td class=\"n\">");
            match row.measure {
                Measure::Keyframe => drop(m.raw("–")),
                _ => number(m, kappa, 2),
            }
        }
        m.raw("</td><td class=\"n\">");
        match row.measure {
            Measure::Keyframe => number(m, row.median_s, 2),
            _ => drop(m.raw("–")),
        }
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table>");
}

pub(super) fn corrections(m: &mut Markup, a: &Analytics, names: &ClassNames) {
    let Some(c) = &a.corrections else { return };
    m.raw("<h3>").say("人工对草稿的修改", "Changes to drafts").raw("</h3>");
    if c.labels == 0 {
        m.raw("<p>").say("还没有已接受的标注。", "No label is accepted yet.").raw("</p>");
        return;
    }
    m.raw("<p>").say("已比较 ", "Compared with their drafts: ").int(c.labels);
    m.say(" 个已接受标注，其中未修改 ", " accepted labels; unchanged ")
        .int(c.unchanged)
        .say("。", ".")
        .raw("</p>");
    m.raw("<table>");
    head(
        m,
        &[
            ("字段", "field", Align::Text),
            ("被修改的标注", "labels changed", Align::Number),
            ("%", "%", Align::Number),
            ("", "", Align::Bar),
        ],
    );
    m.raw("<tbody>");
    for f in c.fields.iter().filter(|f| f.changed > 0) {
        m.raw("<tr><th scope=\"row\">").both(&f.name).raw("</th><td class=\"n\">").int(f.changed);
        m.raw("</td><td class=\"n\">").num(100.0 * f.changed as f64 / c.labels as f64, 0);
        m.raw("</td><td class=\"bar\">")
            .piece(&charts::bar(f.changed as f64, c.labels as f64))
            .raw("</td></tr>");
    }
    m.raw("</tbody></table>");
    keyframes(m, c, names);
}

fn keyframes(m: &mut Markup, c: &Corrections, names: &ClassNames) {
    let k = &c.keyframes;
    m.raw("<p>")
        .say("关键帧被移动（超过半帧）：", "Keyframes moved (by more than half a frame): ")
        .int(k.moved);
    m.raw(" / ").int(k.labels).say("；移动距离中位数 ", "; median distance ");
    number(m, k.median_distance_s, 2);
    m.say(" s，最大 ", " s, greatest ");
    number(m, k.worst_s, 2);
    m.raw(" s</p>");
    let sign = |v: f64| format!("{}{}", if v > 0.0 { "+" } else { "" }, text(v, 2));
    let entries: Vec<(String, Option<f64>)> = (0..k.histogram.len())
        .map(|i| {
            let name = match i {
                0 => format!("< {}", text(SHIFTS_S[0], 2)),
                i if i == SHIFTS_S.len() => format!("> {}", sign(SHIFTS_S[i - 1])),
                i if SHIFTS_S[i - 1] == -SHIFTS_S[i] => format!("±{}", text(SHIFTS_S[i], 2)),
                i => format!("{}…{}", sign(SHIFTS_S[i - 1]), sign(SHIFTS_S[i])),
            };
            (name, Some(k.histogram[i] as f64))
        })
        .collect();
    let title = Bilingual::new("关键帧移动（秒；负为提前）", "Shift of keyframes (s; negative is earlier)");
    m.raw("<div class=\"charts\">").piece(&charts::columns(&title, &entries, 0)).raw("</div>");
    m.raw("<details><summary>").say("按场景", "By class").raw("</summary><table>");
    head(
        m,
        &[
            ("场景", "class", Align::Text),
            ("标注", "labels", Align::Number),
            ("移动", "moved", Align::Number),
            ("中位数 s", "median s", Align::Number),
            ("距离中位数 s", "median distance s", Align::Number),
            ("最大 s", "greatest s", Align::Number),
        ],
    );
    m.raw("<tbody>");
    for (class, k) in &c.keyframes_by_class {
        m.raw("<tr><th scope=\"row\">").both(&names.get(class)).raw("</th><td class=\"n\">").int(k.labels);
        m.raw("</td><td class=\"n\">").int(k.moved);
        for v in [k.median_s, k.median_distance_s, k.worst_s] {
            m.raw("</td><td class=\"n\">");
            number(m, v, 2);
        }
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table></details>");
}

pub(super) fn decisions(m: &mut Markup, a: &Analytics, names: &ClassNames) {
    m.raw("<h3>").say("各场景的驾驶决策", "Decisions by class").raw("</h3><p class=\"faint\">");
    match a.decisions.basis {
        DecisionBasis::Accepted => m.say("已接受的标注。", "Of accepted labels."),
        DecisionBasis::Labelled => {
            m.say("已提交的标注（尚无已接受的）。", "Of submitted labels (none is accepted yet).")
        }
        DecisionBasis::Released => m.say(
            "发布数据集中的样本（未提供标注任务）。",
            "Of the samples of releases (no tasks were given).",
        ),
        DecisionBasis::Nothing => m.say("还没有标注。", "There are no labels yet."),
    };
    m.raw("</p>");
    if a.decisions.rows.is_empty() {
        return;
    }
    m.raw("<table class=\"decisions\">");
    head(
        m,
        &[
            ("场景", "class", Align::Text),
            ("方向", "channel", Align::Text),
            ("决策", "decision", Align::Text),
            ("标注", "labels", Align::Number),
            ("", "", Align::Bar),
        ],
    );
    m.raw("<tbody>");
    for class in a.decisions.rows.chunk_by(|x, y| x.scenario_id == y.scenario_id) {
        for channel in class.chunk_by(|x, y| x.channel == y.channel) {
            let total: u64 = channel.iter().map(|r| r.count).sum();
            for (i, row) in channel.iter().enumerate() {
                let first = i == 0;
                m.raw(if first {
                    "<tr class=\"first\"><th scope=\"row\">"
                } else {
                    "<tr><th scope=\"row\">"
                });
                if first && row.channel == class[0].channel {
                    m.both(&names.get(&row.scenario_id));
                }
                m.raw("</th><td>");
                if first {
                    match row.channel {
                        Channel::Longitudinal => m.say("纵向", "longitudinal"),
                        Channel::Lateral => m.say("横向", "lateral"),
                    };
                }
                m.raw("</td><td>").both(&row.name).raw("</td><td class=\"n\">");
                count(m, Some(row.count));
                m.raw("</td><td class=\"bar\">")
                    .piece(&charts::bar(row.count as f64, total as f64))
                    .raw("</td></tr>");
            }
        }
    }
    m.raw("</tbody></table>");
}
