//! The table of all leaves, one line each: state, counts, what is missing. The tree map's cells link here.

use crate::coverage::{LeafRow, UnresolvedRow, counts, state_name};
use std::collections::BTreeMap;
use whyroad_model::messages::CoverageState;
use whyroad_render::markup::Markup;
use whyroad_render::plot::{SignalInfo, caption};

/// Counts by state, with the fill and the mark that the tree map uses: its legend.
pub(super) fn legend(rows: &[LeafRow<'_>]) -> Markup {
    let mut m = Markup::new();
    let counts = counts(rows);
    m.raw("<ul class=\"legend\">");
    for &state in CoverageState::ALL {
        m.raw("<li data-state=\"").text(state.id()).raw("\"><svg viewBox=\"0 0 34 22\" width=\"34\" height=\"22\"><rect width=\"34\" height=\"22\" class=\"");
        m.raw("st-")
            .text(state.id())
            .raw("\"/><text x=\"17\" y=\"15\" class=\"tm-mark middle\">")
            .raw(mark(state));
        m.raw("</text></svg> <b>").int(counts.get(state)).raw("</b> ").both(&state_name(state)).raw("</li>");
    }
    let in_part = rows.iter().filter(|r| r.searched_in_part().is_some()).count();
    if in_part > 0 {
        m.raw("<li>k/n <b>").int(in_part).raw("</b> ");
        m.say("只在 n 个行程中的 k 个上可观测", "observable on k of the n drives only").raw("</li>");
    }
    m.raw("</ul>");
    m
}

fn mark(state: CoverageState) -> &'static str {
    match state {
        CoverageState::Found => "n",
        CoverageState::NotFound => "0",
        CoverageState::NotObservable => "?",
        CoverageState::NoRule => "–",
    }
}

/// The table.
pub(super) fn table(
    rows: &[LeafRow<'_>],
    unresolved: &[UnresolvedRow<'_>],
    signals: &BTreeMap<String, SignalInfo>,
) -> Markup {
    let mut m = Markup::new();
    m.raw("<table class=\"leaves\"><thead><tr><th>").say("场景", "scenario").raw("</th><th>ID</th><th>");
    m.say("状态", "state")
        .raw("</th><th class=\"n\">")
        .say("事件数", "episodes")
        .raw("</th><th class=\"n\">");
    m.say("其中主场景", "primary")
        .raw("</th><th class=\"n\">")
        .say("已搜索行程", "drives searched")
        .raw("</th><th>");
    m.say("缺少的信号", "missing signals").raw("</th></tr></thead>");
    for group in rows.chunk_by(|a, b| a.l1.id == b.l1.id) {
        let c = counts(group);
        m.raw("<tbody><tr class=\"l1\"><th colspan=\"2\">").both(&group[0].l1.name).raw(" <code>");
        m.text(&group[0].l1.id).raw("</code></th><th colspan=\"5\">");
        m.say("已找到 ", "found ").int(c.found).raw(" / ").int(group.len()).raw("</th></tr>");
        for l2 in group.chunk_by(|a, b| a.l2.id == b.l2.id) {
            for row in l2 {
                leaf(&mut m, row, signals);
            }
            for row in unresolved.iter().filter(|u| u.l2.id == l2[0].l2.id && u.found.episodes > 0) {
                without_variant(&mut m, row);
            }
        }
        m.raw("</tbody>");
    }
    m.raw("</table>");
    m
}

fn leaf(m: &mut Markup, row: &LeafRow<'_>, signals: &BTreeMap<String, SignalInfo>) {
    let id = row.id.to_string();
    m.raw("<tr id=\"leaf-").text(&id).raw("\" data-state=\"").text(row.state.id()).raw("\"><td>");
    m.both(&row.l2.name).raw(" · ").both(&row.l3.name).raw("<div class=\"faint definition\">");
    m.both(&row.l3.definition)
        .raw("</div></td><td><code>")
        .text(&id)
        .raw("</code></td><td class=\"state\"><i class=\"dot dot-");
    m.text(row.state.id()).raw("\">").raw(mark_small(row.state)).raw("</i>").both(&state_name(row.state));
    for count in [row.episodes, row.primary_episodes, row.drives_searched] {
        m.raw("</td><td class=\"n\">");
        // Without a rule nothing was counted; a zero would be misleading.
        if row.state != CoverageState::NoRule {
            m.int(count);
        }
    }
    m.raw("</td><td>");
    for (i, signal) in row.missing_signals().iter().enumerate() {
        if i > 0 {
            m.say("；", "; ");
        }
        m.raw("<span title=\"").text(signal).raw("\">").both(&caption(signals, signal)).raw("</span>");
    }
    if let Some((searched, all)) = row.searched_in_part() {
        m.raw(" <span class=\"faint\">")
            .say("（", "(")
            .int(all - searched)
            .say(" 个行程）", " drives)")
            .raw("</span>");
    }
    m.raw("</td></tr>");
}

/// Episodes of an L2 without a variant; not a leaf, and not counted as one.
fn without_variant(m: &mut Markup, row: &UnresolvedRow<'_>) {
    m.raw("<tr class=\"unresolved\"><td>").both(&row.l2.name).raw(" <div class=\"faint definition\">");
    m.say("属于该 L2，但记录不足以判定变体", "of this L2; the recording does not show the variant")
        .raw("</div></td><td><code>");
    m.text(&row.found.scenario_id.to_string())
        .raw("</code></td><td class=\"state faint\">")
        .say("变体未定", "variant not known");
    for count in [row.found.episodes, row.found.primary_episodes, row.found.drives_searched] {
        m.raw("</td><td class=\"n\">").int(count);
    }
    m.raw("</td><td></td></tr>");
}

fn mark_small(state: CoverageState) -> &'static str {
    match state {
        CoverageState::Found => "✓",
        CoverageState::NotFound => "0",
        CoverageState::NotObservable => "?",
        CoverageState::NoRule => "–",
    }
}
