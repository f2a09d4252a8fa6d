//! A comparison as one self-contained page: totals, the verdict against accepted labels, a table of classes, examples.

use super::text::{self, name};
use super::{Change, ChangedEpisode, ClassComparison, Comparison};
use crate::coverage::class_title;
use whyroad_framework::Taxonomy;
use whyroad_model::{Bilingual, Lang, ScenarioId};
use whyroad_render::charts;
use whyroad_render::language::LANGUAGE_SCRIPT;
use whyroad_render::markup::Markup;

const STYLE: &str = include_str!("../../assets/report.css");
const CHART_STYLE: &str = include_str!("../../assets/analytics.css");
const SCRIPT: &str = include_str!("../../assets/report.js");

/// Texts of the page besides the comparison.
#[derive(Clone, Copy, Debug)]
pub struct PageHead<'a> {
    /// Name of the first side.
    pub before: &'a str,
    /// Name of the second side.
    pub after: &'a str,
    /// Taxonomies for class names; the first with a name is used.
    pub taxonomies: &'a [Taxonomy],
    /// Language that is shown first; the reader can switch.
    pub lang: Lang,
}

impl PageHead<'_> {
    fn class(&self, id: &ScenarioId) -> Bilingual {
        let known = self.taxonomies.iter().find(|t| t.contains(id)).or(self.taxonomies.first());
        known.map_or_else(|| Bilingual::same(id.to_string()), |t| class_title(t, id))
    }
}

/// The page.
pub fn render_page(c: &Comparison, head: &PageHead<'_>) -> String {
    let mut m = Markup::new();
    m.raw("<!doctype html>\n<html lang=\"").raw(if head.lang == Lang::Zh { "zh" } else { "en" });
    m.raw(concat!(
        "\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">",
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; ",
        "script-src 'unsafe-inline'\"><title>Whyroad</title><style>\n"
    ));
    m.raw(STYLE)
        .raw(CHART_STYLE)
        .raw("</style></head><body><header><div><h1>Whyroad</h1><p class=\"faint\">");
    m.say("比较", "Comparison").raw("</p></div><dl class=\"figures\">");
    for change in c.changes() {
        m.raw("<div><dd>").int(c.total(change)).raw("</dd><dt>").both(&both(change)).raw("</dt></div>");
    }
    m.raw("<div><dd>").int(c.unchanged).raw("</dd><dt>").say("未变", "unchanged").raw("</dt></div></dl>");
    m.raw("<div class=\"right\"><div class=\"switch\" role=\"group\"><button type=\"button\" data-lang=\"zh\">中文");
    m.raw("</button><button type=\"button\" data-lang=\"en\">English</button></div></div></header>");
    m.raw("<main class=\"analytics\"><p>").say("之前：", "Before: ").raw("<code>").text(head.before);
    m.raw("</code><br>").say("之后：", "After: ").raw("<code>").text(head.after).raw("</code></p>");
    scope(&mut m, c);
    verdict(&mut m, c);
    classes(&mut m, c, head);
    examples(&mut m, c, head);
    m.raw("</main><script>\n").raw(LANGUAGE_SCRIPT).raw(SCRIPT).raw("</script></body></html>\n");
    m.into_string()
}

fn both(change: Change) -> Bilingual {
    Bilingual::new(name(change, Lang::Zh), name(change, Lang::En))
}

/// Drives on both sides, and drives on one side only.
fn scope(m: &mut Markup, c: &Comparison) {
    m.raw("<p>").say("两侧都有的行程：", "Drives of both sides: ").int(c.drives);
    for (drives, zh, en) in
        [(&c.only_before, "；仅之前：", "; only before: "), (&c.only_after, "；仅之后：", "; only after: ")]
    {
        if !drives.is_empty() {
            m.say(zh, en).int(drives.len());
        }
    }
    if !(c.only_before.is_empty() && c.only_after.is_empty()) {
        m.say("（不参与比较）", " (not compared)");
    }
    m.raw("</p>");
    if let Some(of) = &c.classes_of_both {
        m.raw("<p class=\"warning\">").both(&text::scope(of)).raw("</p>");
    }
}

fn verdict(m: &mut Markup, c: &Comparison) {
    m.raw("<p>");
    match c.verdict() {
        Some((gains, loses)) => {
            m.say("与已接受的标注相比：新增 ", "Against accepted labels: gains ").raw("<b>").int(gains);
            m.raw("</b>").say("，丢失 ", ", loses ").raw("<b>").int(loses).raw("</b>");
            m.say(" 个经人工接受的时刻。", " that people accepted.");
        }
        None => {
            m.say(
                "未提供已接受的标注（--labels），无法判断变化的对错。",
                "No accepted labels were given (--labels): it is unknown which changes are right.",
            );
        }
    }
    m.raw("</p>");
}

fn classes(m: &mut Markup, c: &Comparison, head: &PageHead<'_>) {
    let changed: Vec<(&ScenarioId, &ClassComparison)> = c.changed_classes().collect();
    m.raw("<h2>").say("各场景的变化", "Changes by class").raw("</h2>");
    if changed.is_empty() {
        m.raw("<p>").say("没有变化。", "Nothing changed.").raw("</p>");
        return;
    }
    m.raw("<table><thead><tr><th scope=\"col\">").say("场景", "class");
    for (zh, en) in [("之前", "before"), ("之后", "after")] {
        m.raw("</th><th scope=\"col\" class=\"n\">").say(zh, en);
    }
    // Only changes that occur have a column.
    let shown: Vec<Change> = Change::ALL.into_iter().filter(|ch| c.total(*ch) > 0).collect();
    for change in &shown {
        m.raw("</th><th scope=\"col\" class=\"n\">").both(&both(*change));
    }
    m.raw("</th></tr></thead><tbody>");
    // One measure per column: each has its own scale.
    let count = |of: &ClassComparison, change| of.changes.get(&change).copied().unwrap_or(0);
    let most = |ch| changed.iter().map(|(_, of)| count(of, ch)).max().unwrap_or(0) as f64;
    for (id, of) in &changed {
        m.raw("<tr><th scope=\"row\" title=\"").text(&id.to_string()).raw("\">").both(&head.class(id));
        m.raw("</th><td class=\"n\">").int(of.before).raw("</td><td class=\"n\">").int(of.after);
        for change in shown.iter().copied() {
            let n = count(of, change);
            m.raw("</td><td class=\"n\">");
            if n == 0 {
                m.raw("·");
                continue;
            }
            m.int(n);
            let accepted = of.accepted.as_ref().and_then(|a| a.get(&change)).copied().unwrap_or(0);
            if accepted > 0 {
                m.raw(" <span class=\"faint\">(✓ ").int(accepted).raw(")</span>");
            }
            m.piece(&charts::bar(n as f64, most(change)));
        }
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table><p class=\"faint\">");
    m.say(
        "改类按之前的场景计；✓ 表示其中经人工接受的时刻。",
        "A reclassified moment counts with its class before; ✓: moments that people accepted.",
    );
    m.raw("</p>");
}

fn examples(m: &mut Markup, c: &Comparison, head: &PageHead<'_>) {
    let any = c.classes.values().any(|of| !of.examples.is_empty());
    if !any {
        return;
    }
    m.raw("<h2>")
        .say("示例", "Examples")
        .raw("</h2><table><thead><tr><th scope=\"col\">")
        .say("场景", "class");
    let detailed = c.classes.values().flat_map(|of| &of.examples).any(is_detailed);
    for (zh, en) in [
        ("变化", "change"),
        ("行程", "drive"),
        ("关键帧", "keyframe"),
        ("说明", "details"),
        ("事件", "episode"),
    ] {
        if detailed || en != "details" {
            m.raw("</th><th scope=\"col\">").say(zh, en);
        }
    }
    m.raw("</th></tr></thead><tbody>");
    for (id, of) in &c.classes {
        for e in &of.examples {
            example(m, id, e, head, detailed);
        }
    }
    m.raw("</tbody></table>");
}

/// The entry has more than the change.
fn is_detailed(e: &ChangedEpisode) -> bool {
    e.class_after.is_some()
        || e.keyframe_shift_s.is_some_and(|s| s.abs() > super::MOVED_S)
        || e.accepted == Some(true)
        || e.accepted_after == Some(true)
}

fn example(m: &mut Markup, id: &ScenarioId, e: &ChangedEpisode, head: &PageHead<'_>, detailed: bool) {
    m.raw("<tr><th scope=\"row\">").both(&head.class(id)).raw("</th><td>").both(&both(e.change));
    m.raw("</td><td><code>")
        .text(e.drive.as_str())
        .raw("</code></td><td class=\"moment\"><code>")
        .text(&e.keyframe.to_string());
    m.raw("</code></td><td>");
    if detailed {
        details(m, e, head);
        m.raw("</td><td>");
    }
    m.raw("<code>").text(e.after.as_deref().or(e.before.as_deref()).unwrap_or_default());
    m.raw("</code></td></tr>");
}

fn details(m: &mut Markup, e: &ChangedEpisode, head: &PageHead<'_>) {
    if let Some(class) = &e.class_after {
        m.raw("→ ").both(&head.class(class)).raw(" ");
    }
    if let Some(shift) = e.keyframe_shift_s.filter(|s| s.abs() > super::MOVED_S) {
        m.raw(if shift > 0.0 { "+" } else { "" }).num(shift, 1).raw(" s ");
    }
    if e.accepted == Some(true) {
        match e.change {
            Change::Gained => m.say("✓ 已接受", "✓ accepted"),
            _ => m.say("✓ 之前的类别已接受", "✓ class before accepted"),
        };
    }
    if e.accepted_after == Some(true) {
        m.say(" ✓ 之后的类别已接受", " ✓ class after accepted");
    }
}
