//! Agreement as text: a line per perturbation, then the classes that changed most.

use super::{Change, ClassAgreement, Difference, Robustness};
use std::fmt::Write as _;
use whyroad_model::Lang;

/// What is listed below the line of each perturbation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Classes below this agreement.
    pub floor: f64,
    /// Every class that changed, instead.
    pub classes: bool,
    /// Every episode that is not the same.
    pub episodes: bool,
}

/// The text.
pub fn render(of: &Robustness, lang: Lang, shown: Shown) -> String {
    let t = |zh: &'static str, en: &'static str| if lang == Lang::Zh { zh } else { en };
    let mut out = String::new();
    let _ = match lang {
        Lang::Zh => writeln!(out, "{} 个行程，随机种子 {}", of.drives, of.seed),
        Lang::En => writeln!(out, "{} drives, seed {}", of.drives, of.seed),
    };
    if of.left_out > 0 {
        let _ = match lang {
            Lang::Zh => writeln!(out, "{} 个行程未比较（无法读取或已中断）", of.left_out),
            Lang::En => writeln!(out, "{} drives left out (unreadable, or interrupted)", of.left_out),
        };
    }
    out.push('\n');
    let head = [
        t("一致率", "agreement"),
        t("原有", "before"),
        t("扰动后", "after"),
        t("倍数", "ratio"),
        t("关键帧", "keyframe"),
    ];
    out += &line("", &head.map(str::to_owned));
    for p in &of.perturbations {
        out += &line(&p.name, &cells(&p.all));
    }
    for p in &of.perturbations {
        let floor = if shown.classes { 1.0 } else { shown.floor };
        let mut rows: Vec<_> = p.classes.iter().filter(|(_, c)| c.agreement < floor).collect();
        rows.sort_by(|a, b| {
            a.1.agreement.total_cmp(&b.1.agreement).then(b.1.before.cmp(&a.1.before)).then(a.0.cmp(b.0))
        });
        let episodes = if shown.episodes { &p.differences[..] } else { &[] };
        if rows.is_empty() && episodes.is_empty() {
            continue;
        }
        let _ = writeln!(out, "\n{}: {}", p.name, p.meaning.get(lang));
        for (id, c) in rows {
            out += &line(&format!("  {id}"), &cells(c));
        }
        episodes.iter().for_each(|d| out += &difference(d));
    }
    out
}

/// `-` is only in the original drive, `+` only in the perturbed one.
fn difference(of: &Difference) -> String {
    let sign = if of.change == Change::Lost { '-' } else { '+' };
    let objects: Vec<&str> = of.objects.iter().map(|id| id.as_str()).collect();
    let Difference { drive, scenario, keyframe_s, .. } = of;
    format!("  {sign} {drive}  {keyframe_s:.1} s  {scenario}  {}", objects.join(" ")).trim_end().to_owned()
        + "\n"
}

fn line(name: &str, cells: &[String; 5]) -> String {
    let mut out = format!("{name:<50}");
    for cell in cells {
        // A Chinese character takes two columns.
        let width: usize = cell.chars().map(|c| if c.is_ascii() { 1 } else { 2 }).sum();
        out += &" ".repeat(11usize.saturating_sub(width));
        out += cell;
    }
    out.push('\n');
    out
}

fn cells(c: &ClassAgreement) -> [String; 5] {
    [
        format!("{:.2}", c.agreement),
        c.before.to_string(),
        c.after.to_string(),
        c.ratio.map_or("-".to_owned(), |r| format!("{r:.2}")),
        c.keyframe_shift_s.map_or("-".to_owned(), |s| format!("{s:.1} s")),
    ]
}
