//! The tree of classes with a column per stage: the number, and a bar in proportion to the largest leaf of the column.

use super::count;
use crate::analytics::{Analytics, StageRow};
use whyroad_model::messages::CoverageState;
use whyroad_render::charts;
use whyroad_render::markup::Markup;

const STAGES: [(&str, &str); 5] = [
    ("已挖掘", "mined"),
    ("已建任务", "tasked"),
    ("已标注", "labeled"),
    ("已接受", "accepted"),
    ("已发布", "released"),
];

pub(super) fn write(m: &mut Markup, a: &Analytics) {
    m.raw("<h3>").say("各场景各阶段数量", "Classes by stage").raw("</h3>");
    m.raw("<ul class=\"marks faint\"><li><b>0</b> ")
        .say("已搜索，没有主场景事件", "searched, no primary episode found");
    m.raw("</li><li><b>+1</b> ").say(
        "另有 1 个次场景事件（同一时刻的主场景是别的类）",
        "and 1 secondary episode (the primary class of the moment is another)",
    );
    m.raw("</li><li><b>?</b> ").say("不可观测（缺信号）", "not observable (signals missing)");
    m.raw("</li><li><b>–</b> ").say("没有规则", "no rule");
    m.raw("</li></ul>");
    // Most classes of a lake have no episodes; a table of zeros would hide the others.
    m.raw("<div class=\"stage-box\"><label><input type=\"checkbox\" class=\"every\"> ")
        .say("列出全部场景，包括没有事件的", "List all classes, also those without episodes")
        .raw("</label>");
    m.raw("<table class=\"stages\"><thead><tr><th scope=\"col\">").say("场景", "class").raw("</th>");
    let columns = Columns::of(a);
    for &i in &columns.stages {
        let (zh, en) = STAGES[i];
        m.raw("<th scope=\"col\" class=\"n\">").say(zh, en).raw("</th>");
    }
    if columns.wanted {
        m.raw("<th scope=\"col\" class=\"n\">").say("目标", "wanted").raw("</th>");
    }
    m.raw("</tr></thead><tbody>");
    let leaves = || a.stages.iter().filter(|r| r.scenario_id.is_leaf());
    let most: Vec<f64> = (0..STAGES.len())
        .map(|i| leaves().filter_map(|r| r.counts.all()[i].1).max().unwrap_or(0) as f64)
        .collect();
    for row in &a.stages {
        line(m, row, &columns, &most);
    }
    m.raw("</tbody></table></div>");
}

/// The columns for which there is input: others would be empty.
struct Columns {
    /// Positions in `STAGES`.
    stages: Vec<usize>,
    wanted: bool,
}

impl Columns {
    fn of(a: &Analytics) -> Self {
        let is_given = |i: &usize| a.stages.iter().any(|r| r.counts.all()[*i].1.is_some());
        Self {
            stages: (0..STAGES.len()).filter(is_given).collect(),
            wanted: a.stages.iter().any(|r| r.wanted.is_some()),
        }
    }
}

fn line(m: &mut Markup, row: &StageRow, columns: &Columns, most: &[f64]) {
    let id = row.scenario_id.to_string();
    let counts = row.counts.all().into_iter().map(|(_, n)| n).chain([row.secondary, row.wanted]);
    let has_any = counts.flatten().any(|n| n > 0);
    m.raw(match (&row.scenario_id.l2, &row.scenario_id.l3, has_any) {
        (None, _, _) => "<tr class=\"l1\">",
        (Some(_), None, true) => "<tr class=\"l2\">",
        (Some(_), None, false) => "<tr class=\"l2 nothing\">",
        (_, _, true) => "<tr class=\"l3\">",
        (_, _, false) => "<tr class=\"l3 nothing\">",
    });
    m.raw("<th scope=\"row\" title=\"").text(&id).raw("\">").both(&row.name);
    if !row.in_taxonomy && row.scenario_id.l1 != whyroad_model::ids::OTHER {
        m.raw(" <span class=\"faint\">").say("（不在分类体系中）", "(not in the taxonomy)").raw("</span>");
    }
    m.raw("</th>");
    for &i in &columns.stages {
        let value = row.counts.all()[i].1;
        m.raw("<td class=\"n\">");
        match (i, value, row.state) {
            (0, None, Some(CoverageState::NotObservable)) => drop(m.raw("?")),
            (0, None, Some(CoverageState::NoRule)) => drop(m.raw("–")),
            _ => count(m, value),
        }
        if i == 0
            && let Some(n) = row.secondary.filter(|n| *n > 0)
        {
            m.raw(" <span class=\"faint\">+").int(n).raw("</span>");
        }
        if row.scenario_id.is_leaf()
            && let Some(n) = value
        {
            m.piece(&charts::bar(n as f64, most[i]));
        }
        m.raw("</td>");
    }
    if columns.wanted {
        m.raw("<td class=\"n\">");
        if let Some(wanted) = row.wanted {
            m.int(wanted);
        }
        m.raw("</td>");
    }
    m.raw("</tr>");
}
