//! `docs/reference/TAXONOMY.md`: the classes as a page, in the form of the TAXONOMY.md that the project was given, with
//! English beside Chinese and every number counted. `markdown` can read it back.

mod overlaps;
mod spec_page;
pub mod wrap;

pub use spec_page::fill_spec_page;

use crate::taxonomy::{L1, L2, L3, TypicalDecisions};
use crate::{Framework, ResolvedSpec};
use overlaps::{Overlaps, anchor};
use std::fmt::Write as _;
use whyroad_model::ScenarioId;

/// The whole page.
pub fn taxonomy_page(f: &Framework) -> String {
    let t = &f.taxonomy;
    let (l1, l2, l3) = t.counts();
    let mut out = String::new();
    let _ = writeln!(
        out,
        "<!-- Written by `whyroad taxonomy docs` from schema/ and scenarios/. Change those, not this page. -->\n\n\
         # 场景分类全集 · Scenario taxonomy\n\n\
         > 版本: {}\n> 总计: {l1}个L1 | {l2}个L2 | {l3}个L3\n\n{}\n\n{}\n",
        t.version, t.description.zh, t.description.en
    );
    statistics(f, &mut out);
    let overlaps = Overlaps::of(t);
    for l1 in &t.l1 {
        section_l1(f, l1, &overlaps, &mut out);
    }
    tree(f, &mut out);
    wrap::wrap_page(&out)
}

/// The tree with counts, as in TAXONOMY.md.
pub fn tree_text(f: &Framework) -> String {
    let t = &f.taxonomy;
    let (n1, n2, n3) = t.counts();
    let mut out = format!("场景分类体系 v{} ({n1} L1 | {n2} L2 | {n3} L3)\n", t.version);
    for (i, l1) in t.l1.iter().enumerate() {
        let (branch, trunk) = if i + 1 == n1 { ("└──", "    ") } else { ("├──", "│   ") };
        let leaves: usize = l1.l2.iter().map(|b| b.l3.len()).sum();
        let _ = writeln!(out, "│\n{branch} {} ({}) [{} L2, {leaves} L3]", l1.id, l1.name.zh, l1.l2.len());
        for (j, l2) in l1.l2.iter().enumerate() {
            let branch = if j + 1 == l1.l2.len() { "└──" } else { "├──" };
            let ids: Vec<&str> = l2.l3.iter().map(|c| c.id.as_str()).collect();
            let _ = writeln!(out, "{trunk}{branch} {} [{}]: {}", l2.id, l2.l3.len(), ids.join(", "));
        }
    }
    out
}

fn statistics(f: &Framework, out: &mut String) {
    let t = &f.taxonomy;
    out.push_str("## 分类统计 · Counts\n\n| L1 | 名称 | Name | L2数量 | L3数量 |\n|----|------|------|--------|--------|\n");
    for a in &t.l1 {
        let leaves: usize = a.l2.iter().map(|b| b.l3.len()).sum();
        let (zh, en) = (cell(&a.name.zh), cell(&a.name.en));
        let _ = writeln!(out, "| `{}` | {zh} | {en} | {} | {leaves} |", a.id, a.l2.len());
    }
    let (_, l2, l3) = t.counts();
    let _ = writeln!(out, "| **总计** | - | Total | **{l2}** | **{l3}** |\n");
}

fn section_l1(f: &Framework, l1: &L1, overlaps: &Overlaps<'_>, out: &mut String) {
    let _ = writeln!(
        out,
        "---\n\n## L1: {} ({})\n\n**{}**\n\n> **定义**: {}\n>\n> **Definition**: {}\n",
        l1.name.zh, l1.id, l1.name.en, l1.definition.zh, l1.definition.en
    );
    for l2 in &l1.l2 {
        section_l2(f, l1, l2, overlaps, out);
    }
}

fn section_l2(f: &Framework, l1: &L1, l2: &L2, overlaps: &Overlaps<'_>, out: &mut String) {
    let _ = writeln!(
        out,
        "<a id=\"{}\"></a>\n\n### L2: {} - {}\n\n**{}**\n\n> **定义**: {}\n>\n> **Definition**: {}\n",
        anchor(&l2.id),
        l2.id,
        l2.name.zh,
        l2.name.en,
        l2.definition.zh,
        l2.definition.en
    );
    let typical = decisions(&l2.typical_decisions);
    if !typical.is_empty() {
        let _ = writeln!(out, "典型决策 · Typical decisions: {typical}\n");
    }
    out.push_str("| L3 ID | 名称 | Name | 条件 | Condition | 标注要求 · Labeling |\n|-------|------|------|------|------|------|\n");
    for l3 in &l2.l3 {
        let spec = f.specs.get(&ScenarioId::leaf(&l1.id, &l2.id, &l3.id));
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} | {} | {} |",
            l3.id,
            cell(&l3.name.zh),
            cell(&l3.name.en),
            cell(&l3.condition.zh),
            cell(&l3.condition.en),
            cell(&labelling(spec))
        );
    }
    out.push('\n');
    for l3 in &l2.l3 {
        definition(l2, l3, out);
    }
    out.push('\n');
    overlaps.section(&ScenarioId { l1: l1.id.clone(), l2: Some(l2.id.clone()), l3: None }, out);
}

/// The definition of a leaf, and its typical decisions where they are not simply those of its L2.
fn definition(l2: &L2, l3: &L3, out: &mut String) {
    let _ = write!(out, "- `{}`: {}<br>{}", l3.id, l3.definition.zh, l3.definition.en);
    if l3.typical_decisions != l2.typical_decisions {
        let _ = write!(out, "<br>典型决策 · Typical decisions: {}", decisions(&l3.typical_decisions));
    }
    out.push('\n');
}

fn decisions(typical: &TypicalDecisions) -> String {
    let ids = typical.longitudinal.iter().map(|d| d.id()).chain(typical.lateral.iter().map(|d| d.id()));
    ids.map(|id| format!("`{id}`")).collect::<Vec<_>>().join(", ")
}

/// Requirements for a labeler besides keyframe, start and end; those are in `whyroad taxonomy show`.
fn labelling(spec: Option<&ResolvedSpec>) -> String {
    let Some(spec) = spec else { return "?".to_owned() };
    let mut parts = vec![format!("keyframe: {}", spec.keyframe.kind)];
    if spec.second_keyframe.is_some() {
        parts.push("双keyframe · two keyframes".to_owned());
    }
    for r in &spec.records {
        let unit = r.unit.as_ref().map(|u| format!(" ({u})")).unwrap_or_default();
        parts.push(format!("`{}`: {} · {}{unit}", r.id, r.name.zh, r.name.en));
    }
    if spec.uncertainty_high {
        parts.push("uncertainty=high".to_owned());
    }
    if let Some(lateral) = spec.lateral {
        parts.push(format!("lateral=`{lateral}`"));
    }
    parts.join("<br>")
}

fn tree(f: &Framework, out: &mut String) {
    let _ = write!(out, "---\n\n## 场景树状图 · Tree\n\n```\n{}```\n", tree_text(f));
}

/// Text that is safe in a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
