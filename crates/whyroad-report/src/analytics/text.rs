//! Summary of the analytics for a terminal. The page and the tables have all numbers.

use super::page::ClassNames;
use super::unseen::Estimate;
use super::{Analytics, MORE_HOURS, StageRow};
use std::fmt::Write as _;
use whyroad_model::display::number;
use whyroad_model::{Lang, messages::CoverageState};

/// Maximum number of listed shortfalls.
const SHORTFALLS: usize = 10;

/// The text.
pub fn render_text(a: &Analytics, lang: Lang) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    let titles = [
        t("挖掘", "mined"),
        t("任务", "tasked"),
        t("标注", "labeled"),
        t("接受", "accepted"),
        t("发布", "released"),
        t("目标", "wanted"),
    ];
    let _ = write!(out, "{}", pad("", 44));
    for title in titles {
        let _ = write!(out, "{}", pad_left(title, 10));
    }
    out.push('\n');
    for row in a.stages.iter().filter(|r| is_shown(r)) {
        let name = match (&row.scenario_id.l2, &row.scenario_id.l3) {
            (None, _) => row.name.get(lang).to_owned(),
            (Some(_), None) => format!("  {}", row.name.get(lang)),
            _ => format!("    {}", row.name.get(lang)),
        };
        let _ = write!(out, "{}", pad(&name, 44));
        for (i, (_, n)) in row.counts.all().into_iter().enumerate() {
            let text = match (i, n, row.state) {
                (0, Some(n), _) if row.secondary.is_some_and(|s| s > 0) => {
                    format!("{n}+{}", row.secondary.unwrap_or(0))
                }
                (_, Some(n), _) => n.to_string(),
                (0, None, Some(CoverageState::NotObservable)) => "?".to_owned(),
                (0, None, Some(CoverageState::NoRule)) => "-".to_owned(),
                _ => "…".to_owned(),
            };
            let _ = write!(out, "{}", pad_left(&text, 10));
        }
        let _ = writeln!(out, "{}", pad_left(&row.wanted.map(|n| n.to_string()).unwrap_or_default(), 10));
    }
    let _ = writeln!(
        out,
        "{}",
        t(
            "0 已搜索未找到，+n 另有次场景事件，? 不可观测，- 没有规则，… 未提供；没有任何数量的 L3 未列出",
            "0 searched, none found; +n secondary episodes besides; ? not observable; - no rule; … not given; leaves \
             without any count are not listed"
        )
    );
    labelling(&mut out, a, lang);
    unseen(&mut out, a, lang);
    shortfalls(&mut out, a, lang);
    out
}

/// Every L1 and L2, and the leaves with any count.
fn is_shown(row: &StageRow) -> bool {
    !row.scenario_id.is_leaf()
        || row.wanted.is_some()
        || row.secondary.is_some_and(|n| n > 0)
        || row.counts.all().iter().any(|(_, n)| n.is_some_and(|n| n > 0))
}

/// Hours as text; less than one as minutes, so that a little work is not shown as zero.
pub(super) fn hours(h: f64) -> String {
    if h < 1.0 { format!("{} min", number(h * 60.0, 1)) } else { format!("{} h", number(h, 1)) }
}

fn labelling(out: &mut String, a: &Analytics, lang: Lang) {
    let Some(p) = &a.progress else { return };
    out.push('\n');
    let unknown = if lang == Lang::Zh { "未知" } else { "unknown" };
    let date = match (&p.finish.date, &p.finish.interval) {
        (Some(date), Some((low, high))) => {
            format!("{date} (80 %: {low} – {})", high.as_deref().unwrap_or("…"))
        }
        _ => unknown.to_owned(),
    };
    let cost =
        p.cost.as_ref().map_or(unknown.to_owned(), |c| format!("{} {}", number(c.per_label, 2), c.currency));
    let _ = match lang {
        Lang::Zh => writeln!(
            out,
            "未完成任务 {}；剩余 {}；预计完成：{date}\n人工用时 {}；每个已接受标注的成本：{cost}",
            p.unfinished,
            p.finish.remaining,
            hours(p.worked_h)
        ),
        Lang::En => writeln!(
            out,
            "unfinished tasks {}; remaining {}; finish: {date}\ntime worked {}; cost per accepted label: {cost}",
            p.unfinished,
            p.finish.remaining,
            hours(p.worked_h)
        ),
    };
    if let Some(c) = a.corrections.as_ref().filter(|c| c.labels > 0) {
        let fields: Vec<String> = c
            .fields
            .iter()
            .filter(|f| f.changed > 0)
            .take(5)
            .map(|f| format!("{} {}", f.name.get(lang), f.changed))
            .collect();
        let (moved, of) = (c.keyframes.moved, c.keyframes.labels);
        let _ = match lang {
            Lang::Zh => writeln!(
                out,
                "已接受 {} 个标注：未修改 {}；修改最多的字段：{}；关键帧移动 {moved}/{of}",
                c.labels,
                c.unchanged,
                fields.join("，")
            ),
            Lang::En => writeln!(
                out,
                "{} accepted labels: unchanged {}; fields changed most: {}; keyframes moved {moved}/{of}",
                c.labels,
                c.unchanged,
                fields.join(", ")
            ),
        };
    }
    for row in &a.agreement {
        let value = |v: Option<f64>| v.map_or(unknown.to_owned(), |v| number(v, 2));
        let (zh, en) = row.measure.name();
        let _ = writeln!(
            out,
            "{} {}: {} {}, Cohen κ {}, Fleiss κ {}",
            if lang == Lang::Zh { "一致性" } else { "agreement" },
            if lang == Lang::Zh { zh } else { en },
            row.pairs,
            if lang == Lang::Zh { "对" } else { "pairs" },
            value(row.cohen),
            value(row.fleiss)
        );
    }
}

fn unseen(out: &mut String, a: &Analytics, lang: Lang) {
    let Some(u) = &a.unseen else { return };
    let text = |e: Estimate, scale: f64, digits| {
        format!(
            "{} ({} – {})",
            number(e.value * scale, digits),
            number(e.low * scale, digits),
            number(e.high * scale, digits)
        )
    };
    let unknown = || if lang == Lang::Zh { "未知".to_owned() } else { "unknown".to_owned() };
    let mass = u.mass.map_or_else(unknown, |e| format!("{} %", text(e, 100.0, 1)));
    let new = u.new_leaves.map_or_else(|| searched_first(u.hours_needed, lang), |e| text(e, 1.0, 1));
    let _ = match lang {
        Lang::Zh => writeln!(
            out,
            "\n已搜索 {} h；可观测 L3 {}，已找到 {}\n未见概率质量（Good-Turing）{mass}；再行驶 {MORE_HOURS} h 的新 L3：{new}",
            number(u.hours, 2),
            u.observable,
            u.found
        ),
        Lang::En => writeln!(
            out,
            "\nsearched {} h; leaves observable {}, found {}\nunseen mass (Good-Turing) {mass}; new leaves in another \
             {MORE_HOURS} h: {new}",
            number(u.hours, 2),
            u.observable,
            u.found
        ),
    };
}

/// An estimate that is unknown until more was searched.
fn searched_first(hours: f64, lang: Lang) -> String {
    let hours = number(hours, 0);
    match lang {
        Lang::Zh => format!("未知（须先搜索 {hours} h）"),
        Lang::En => format!("unknown ({hours} h have to be searched first)"),
    }
}

fn shortfalls(out: &mut String, a: &Analytics, lang: Lang) {
    if a.shortfalls.is_empty() {
        return;
    }
    let names = ClassNames::of(a);
    let _ = match lang {
        Lang::Zh => writeln!(out, "\n缺口：{} 个 L3", a.shortfalls.len()),
        Lang::En => writeln!(out, "\nshortfalls: {} leaves", a.shortfalls.len()),
    };
    for s in a.shortfalls.iter().take(SHORTFALLS) {
        let name = names.get(&s.scenario_id);
        let wanted = s.wanted.map_or(String::new(), |n| format!(" {}/{n}", s.accepted.unwrap_or(0)));
        let _ = writeln!(out, "  {}{wanted}: {}", name.get(lang), s.step.text().get(lang));
    }
    if a.shortfalls.len() > SHORTFALLS {
        let _ = writeln!(out, "  …");
    }
}

/// Columns of a terminal: a Chinese character takes two.
fn width(text: &str) -> usize {
    text.chars().map(|c| if ('\u{2e80}'..='\u{ffef}').contains(&c) { 2 } else { 1 }).sum()
}

fn pad(text: &str, columns: usize) -> String {
    format!("{text}{}", " ".repeat(columns.saturating_sub(width(text))))
}

/// `text` at the right of so many columns of a terminal.
pub(crate) fn pad_left(text: &str, columns: usize) -> String {
    format!("{}{text}", " ".repeat(columns.saturating_sub(width(text))))
}
