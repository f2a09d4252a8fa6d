//! Gaps: shortfalls with their queries, unseen classes, and the expected results of more driving.

use super::{Align, ClassNames, count, head, hours};
use crate::analytics::unseen::Estimate;
use crate::analytics::{Analytics, MORE_HOURS, Shortfall};
use whyroad_model::Bilingual;
use whyroad_render::charts;
use whyroad_render::markup::Markup;

/// Leaves shown at once of shortfalls and of the outlook; the tables have all.
const LEAVES: usize = 25;

pub(super) fn shortfalls(m: &mut Markup, a: &Analytics, names: &ClassNames) {
    m.raw("<h3>").say("缺口", "Shortfalls").raw("</h3>");
    if a.shortfalls.is_empty() {
        m.raw("<p>").say("没有缺口。", "There are no shortfalls.").raw("</p>");
        return;
    }
    m.raw("<p>").int(a.shortfalls.len()).say(" 个 L3 场景", " classes").raw("</p>");
    let (first, rest) = a.shortfalls.split_at(a.shortfalls.len().min(LEAVES));
    shortfall_table(m, first, names);
    if !rest.is_empty() {
        m.raw("<details><summary>").say("其余 ", "the other ").int(rest.len()).raw("</summary>");
        shortfall_table(m, rest, names);
        m.raw("</details>");
    }
    m.raw("<p class=\"faint\">");
    m.say("查询可保存为文件并运行 ", "Save a query to a file and run ")
        .raw("<code>whyroad mine --query FILE</code>");
    m.say(
        "。预计行驶时间按目前的发现率计算。",
        ". Expected driving time follows from the rate of finds so far.",
    )
    .raw("</p>");
}

/// A column of numbers: its title, and the value of a row.
type NumberColumn = (&'static str, &'static str, fn(&Shortfall) -> Option<u64>);

/// Columns of numbers; those that no row has are left out.
const NUMBERS: [NumberColumn; 5] = [
    ("目标", "wanted", |s| s.wanted),
    ("已接受", "accepted", |s| s.accepted),
    ("进行中", "in progress", |s| s.in_progress),
    ("未建任务", "without a task", |s| s.untasked),
    ("须再挖掘", "still to mine", |s| s.missing),
];

fn shortfall_table(m: &mut Markup, rows: &[Shortfall], names: &ClassNames) {
    let numbers: Vec<_> = NUMBERS.iter().filter(|(.., of)| rows.iter().any(|s| of(s).is_some())).collect();
    let mut columns = vec![("场景", "class", Align::Text), ("下一步", "next step", Align::Text)];
    columns.extend(numbers.iter().map(|(zh, en, _)| (*zh, *en, Align::Number)));
    columns.push(("预计需行驶", "driving expected", Align::Number));
    columns.push(("查询", "query", Align::Text));
    m.raw("<table>");
    head(m, &columns);
    m.raw("<tbody>");
    for s in rows {
        shortfall(m, s, &names.get(&s.scenario_id), numbers.iter().map(|(.., of)| of(s)));
    }
    m.raw("</tbody></table>");
}

fn shortfall(m: &mut Markup, s: &Shortfall, name: &Bilingual, numbers: impl Iterator<Item = Option<u64>>) {
    m.raw("<tr><th scope=\"row\" title=\"").text(&s.scenario_id.to_string()).raw("\">").both(name);
    m.raw("</th><td class=\"step\">").both(&s.step.text());
    for n in numbers {
        m.raw("</td><td class=\"n\">");
        count(m, n);
    }
    m.raw("</td><td class=\"n\">");
    match s.hours {
        Some(value) => {
            hours(m, value, if value < 10.0 { 1 } else { 0 });
            m.raw(" h");
        }
        None => drop(m.say("未知", "unknown")),
    }
    m.raw("</td><td>");
    match s.query.as_ref().and_then(|q| serde_json::to_string_pretty(q).ok()) {
        Some(query) => {
            m.raw("<details><summary>").say("查看", "show").raw("</summary><pre>").text(&query);
            m.raw("</pre></details>");
        }
        None => drop(m.raw("–")),
    }
    m.raw("</td></tr>");
}

pub(super) fn unseen(m: &mut Markup, a: &Analytics, names: &ClassNames) {
    let Some(u) = &a.unseen else { return };
    m.raw("<h3>").say("尚未见到的场景", "Unseen classes").raw("</h3><ul class=\"plain\"><li>");
    m.say("已搜索 ", "Searched ");
    hours(m, u.hours, 2);
    m.say(" h，", " h, ").int(u.drives).say(" 个行程；", " drives; ");
    m.say("可观测的 L3 场景 ", "leaves that they can show ").int(u.observable);
    m.say("，其中已找到 ", ", of these found ").int(u.found).say("。", ".").raw("</li><li>");
    m.say(
        "下一次发现属于未见场景的概率（Good-Turing）：",
        "Probability that the next find is of an unseen leaf (Good-Turing): ",
    );
    match u.mass {
        Some(e) => percent(m, e),
        None => drop(m.say("未知：还没有任何发现。", "unknown: nothing was found.")),
    }
    m.raw("</li><li>");
    m.say("再行驶 ", "New leaves in another ").num(MORE_HOURS, 0);
    m.say(" h 将新发现的场景数（Good-Toulmin）：", " h (Good-Toulmin): ");
    match u.new_leaves {
        Some(e) => estimate(m, e, 1),
        None => {
            m.say("未知：超出可外推范围，须先搜索约 ", "unknown: beyond the range of the estimator; about ");
            m.num(u.hours_needed, 0).say(" h。", " h have to be searched first.");
        }
    }
    m.raw("</li></ul>");
    outlook(m, a, names);
    m.raw("<p class=\"faint\">");
    m.say(
        "区间为 95 %。前提：新行程与现有行程同类；一个行程中同一场景只计一次（事件数除外）。方法见文档 analytics。",
        "Intervals are 95 %. They hold for more drives of the same kind; a drive counts a leaf once (episodes apart). \
         Methods: documentation page analytics.",
    )
    .raw("</p>");
}

/// Percent with its interval.
fn percent(m: &mut Markup, e: Estimate) {
    m.raw("<b>").num(e.value * 100.0, 1).raw(" %</b> (").num(e.low * 100.0, 1).raw(" – ");
    m.num(e.high * 100.0, 1).raw(" %)");
}

fn estimate(m: &mut Markup, e: Estimate, digits: usize) {
    m.raw("<b>")
        .num(e.value, digits)
        .raw("</b> (")
        .num(e.low, digits)
        .raw(" – ")
        .num(e.high, digits)
        .raw(")");
}

fn outlook(m: &mut Markup, a: &Analytics, names: &ClassNames) {
    let Some(u) = &a.unseen else { return };
    let mut leaves: Vec<_> = u.leaves.iter().filter_map(|l| Some((l, l.coming?))).collect();
    // The rarest matter most here.
    leaves
        .sort_by(|a, b| a.1.value.total_cmp(&b.1.value).then_with(|| a.0.scenario_id.cmp(&b.0.scenario_id)));
    if leaves.is_empty() {
        return;
    }
    let shown = &leaves[..leaves.len().min(LEAVES)];
    let most = shown.iter().map(|l| l.1.high).fold(0.0, f64::max);
    m.raw("<details><summary>").say("再行驶 ", "Episodes in another ").num(MORE_HOURS, 0);
    m.say(" h 各场景的事件数，最少的在前", " h by leaf, rarest first").raw("</summary><table>");
    head(
        m,
        &[
            ("场景", "class", Align::Text),
            ("其中已挖掘", "mined there", Align::Number),
            ("已搜索行程", "drives searched", Align::Number),
            ("已搜索时长 h", "h searched", Align::Number),
            ("预计", "expected", Align::Number),
            ("区间", "interval", Align::Number),
            ("", "", Align::Bar),
        ],
    );
    m.raw("<tbody>");
    for (leaf, e) in shown {
        m.raw("<tr><th scope=\"row\">").both(&names.get(&leaf.scenario_id)).raw("</th><td class=\"n\">");
        m.int(leaf.episodes).raw("</td><td class=\"n\">");
        m.int(leaf.drives).raw("</td><td class=\"n\">");
        hours(m, leaf.hours, 2);
        m.raw("</td><td class=\"n\">");
        m.num(e.value, 1).raw("</td><td class=\"n\">").num(e.low, 1).raw(" – ").num(e.high, 1);
        m.raw("</td><td class=\"bar\">")
            .piece(&charts::interval(e.low, e.value, e.high, most))
            .raw("</td></tr>");
    }
    m.raw("</tbody></table></details>");
}
