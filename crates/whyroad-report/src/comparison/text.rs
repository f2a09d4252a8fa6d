//! A comparison for people: a table of classes with changes, examples, and the verdict against accepted labels.

use super::{Change, ChangedEpisode, ClassComparison, Comparison};
use std::fmt::Write as _;
use whyroad_model::Lang;

/// The text; `examples` adds the ids of changed episodes.
pub fn render(c: &Comparison, lang: Lang, examples: bool) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    let totals: Vec<String> =
        Change::ALL.iter().map(|ch| format!("{} {}", name(*ch, lang), c.total(*ch))).collect();
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
    if let Some((gained, lost)) = c.verdict() {
        let _ = match lang {
            Lang::Zh => writeln!(out, "与已接受标注相比：新增 {gained} 个、丢失 {lost} 个经人工接受的时刻"),
            Lang::En => {
                writeln!(out, "against accepted labels: gains {gained}, loses {lost} that people accepted")
            }
        };
    }
    let changed: Vec<_> = c.classes.iter().filter(|(_, of)| !of.changes.is_empty()).collect();
    if changed.is_empty() {
        return out;
    }
    out.push('\n');
    let _ = write!(out, "{:<48}{:>8}{:>8}", "", t("前", "before"), t("后", "after"));
    for change in Change::ALL {
        let _ = write!(out, "{:>9}", short(change, lang));
    }
    out.push('\n');
    for (id, of) in changed {
        out += &row(&id.to_string(), of);
        if examples {
            for e in &of.examples {
                let _ = writeln!(out, "    {}", example(e, lang));
            }
        }
    }
    out
}

fn row(id: &str, of: &ClassComparison) -> String {
    let mut out = format!("{id:<48}{:>8}{:>8}", of.before, of.after);
    for change in Change::ALL {
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
    };
    if lang == Lang::Zh { zh } else { en }
}

fn short(change: Change, lang: Lang) -> &'static str {
    match (change, lang) {
        (Change::Moved, Lang::Zh) => "移动",
        (Change::Primary, Lang::Zh) => "主次",
        (Change::Reclassified, Lang::En) => "reclass",
        (Change::Moved, Lang::En) => "moved",
        (Change::Primary, Lang::En) => "primary",
        _ => name(change, lang),
    }
}
