//! A comparison for people: a table of classes with changes, examples, and the verdict against accepted labels.

use super::{Change, ChangedEpisode, ClassComparison, Comparison, SharedClasses};
use crate::analytics::text::pad_left;
use std::fmt::Write as _;
use whyroad_model::{Bilingual, Lang};

/// The text; `examples` adds the ids of changed episodes.
pub fn render(c: &Comparison, lang: Lang, examples: bool) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    let totals: Vec<String> = c.changes().map(|ch| format!("{} {}", name(ch, lang), c.total(ch))).collect();
    let _ = match lang {
        Lang::Zh => writeln!(out, "{} 个行程，未变 {}，{}", c.drives, c.unchanged, totals.join("，")),
        Lang::En => writeln!(out, "{} drives, {} unchanged, {}", c.drives, c.unchanged, totals.join(", ")),
    };
    for (drives, zh, en) in [
        (&c.only_before, "仅前者搜索", "searched only before"),
        (&c.only_after, "仅后者搜索", "searched only after"),
    ] {
        if !drives.is_empty() {
            let names: Vec<String> = drives.iter().take(5).map(ToString::to_string).collect();
            let more = if drives.len() > 5 { ", …" } else { "" };
            let _ = writeln!(out, "{}: {} ({}{more})", t(zh, en), drives.len(), names.join(", "));
        }
    }
    if let Some(of) = &c.classes_of_both {
        let _ = writeln!(out, "{}", scope(of).get(lang));
    }
    if let Some((gained, lost)) = c.verdict() {
        let _ = match lang {
            Lang::Zh => writeln!(out, "与已接受标注相比：新增 {gained} 个、丢失 {lost} 个经人工接受的时刻"),
            Lang::En => {
                writeln!(out, "against accepted labels: gains {gained}, loses {lost} that people accepted")
            }
        };
    }
    let changed: Vec<_> = c.changed_classes().collect();
    if changed.is_empty() {
        return out;
    }
    if c.verdict().is_none() {
        let _ = writeln!(
            out,
            "{}",
            t(
                "未提供已接受的标注（--labels），无法判断变化的对错",
                "no accepted labels were given (--labels): it is unknown which changes are right"
            )
        );
    }
    out.push('\n');
    // As wide as the longest id, which is never cut.
    let ids = changed.iter().map(|(id, _)| id.to_string().len());
    let width = ids.max().unwrap_or(0).max(46) + 2;
    let _ = write!(out, "{:width$}", "");
    for (title, columns) in [(t("前", "before"), 8), (t("后", "after"), 8)] {
        out += &pad_left(title, columns);
    }
    for change in c.changes() {
        out += &pad_left(short(change, lang), 9);
    }
    out.push('\n');
    for (id, of) in changed {
        out += &row(&id.to_string(), width, of, c);
        if examples {
            for e in &of.examples {
                let _ = writeln!(out, "    {}", example(e, lang));
            }
        }
    }
    out
}

/// The classes that are compared, where the sides asked for different ones.
pub(super) fn scope(of: &SharedClasses) -> Bilingual {
    let SharedClasses { compared, left_out_before: before, left_out_after: after } = of;
    let ids: Vec<String> = compared.iter().map(ToString::to_string).collect();
    Bilingual::new(
        format!(
            "两侧查询的类别不同，只比较两侧都查询的：{}；未比较的事件：之前 {before}，之后 {after}",
            if ids.is_empty() { "（无）".to_owned() } else { ids.join("、") }
        ),
        format!(
            "The sides asked for different classes; compared are those of both: {}; episodes left out: {before} before, \
             {after} after",
            if ids.is_empty() { "(none)".to_owned() } else { ids.join(", ") }
        ),
    )
}

fn row(id: &str, width: usize, of: &ClassComparison, c: &Comparison) -> String {
    let mut out = format!("{id:<width$}{:>8}{:>8}", of.before, of.after);
    for change in c.changes() {
        let n = of.changes.get(&change).copied().unwrap_or(0);
        let _ = write!(out, "{:>9}", if n == 0 { "·".to_owned() } else { n.to_string() });
    }
    out.push('\n');
    out
}

fn example(e: &ChangedEpisode, lang: Lang) -> String {
    let mut out = name(e.change, lang).to_owned();
    for id in [&e.before, &e.after].into_iter().flatten() {
        let _ = write!(out, "  {id}");
    }
    if let Some(class) = &e.class_after {
        let _ = write!(out, "  -> {class}");
    }
    if let Some(shift) = e.keyframe_shift_s.filter(|s| s.abs() > super::MOVED_S) {
        let _ = write!(out, "  {shift:+.1} s");
    }
    if e.accepted == Some(true) {
        out += if lang == Lang::Zh { "  （已接受）" } else { "  (accepted)" };
    }
    out
}

/// Displayed name of a change.
pub fn name(change: Change, lang: Lang) -> &'static str {
    let (zh, en) = match change {
        Change::Gained => ("新增", "gained"),
        Change::Lost => ("丢失", "lost"),
        Change::Reclassified => ("改类", "reclassified"),
        Change::Moved => ("关键帧移动", "moved keyframe"),
        Change::Primary => ("主次变化", "changed primary"),
        Change::Relabelled => ("标签改变", "relabelled"),
    };
    if lang == Lang::Zh { zh } else { en }
}

fn short(change: Change, lang: Lang) -> &'static str {
    match (change, lang) {
        (Change::Moved, Lang::Zh) => "移动",
        (Change::Primary, Lang::Zh) => "主次",
        (Change::Reclassified, Lang::En) => "reclass",
        (Change::Relabelled, Lang::Zh) => "标签",
        (Change::Relabelled, Lang::En) => "label",
        (Change::Moved, Lang::En) => "moved",
        (Change::Primary, Lang::En) => "primary",
        _ => name(change, lang),
    }
}
