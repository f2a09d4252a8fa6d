//! An explanation as a picture: a lane over time for each condition, green where it is true, grey where it is false,
//! hatched where it is unknown, and a line at the moment that is told about. Legible without colour (low bars,
//! hatching, and words), on light and on dark ground.

use super::text::{actual, below, mark, single, text_of, verdict, whole};
use super::{Shown, seconds};
use std::fmt::Write as _;
use whyroad_mining::explain::{AtomCourse, Cell, Course};
use whyroad_model::{Lang, Tri};

const LEFT: usize = 16;
const PX_A_FRAME: usize = 3;
const ROW: usize = 22;
/// Room for the longest text: at 13 px a Latin letter of a usual face is at most so wide on average, a Chinese one 13.
const LETTER_PX: usize = 7;
const IDEOGRAPH_PX: usize = 13;

/// Colours by what they mean, for light and dark ground.
const STYLE: &str = "<style>
svg { --ground: #ffffff; --ink: #1f2328; --yes: #1a7f37; --no: #b42318; --unknown: #8a6d00; --true: #57ab5a; --false: #d0d5db; --moment: #1f4fd8 }
@media (prefers-color-scheme: dark) {
svg { --ground: #15181c; --ink: #e6e8ea; --yes: #6fdc8c; --no: #ff8f84; --unknown: #e3b341; --true: #3f9950; --false: #4a525b; --moment: #7aa2ff }
}
.ground { fill: var(--ground) } text { fill: var(--ink) } .tick { stroke: var(--ink) }
.yes { fill: var(--yes) } .no { fill: var(--no) } .unknown { fill: var(--unknown) }
.t { fill: var(--true) } .f { fill: var(--false) } .u { fill: url(#hatch) } .hatch { stroke: var(--unknown) }
.moment { stroke: var(--moment); stroke-width: 2 }
</style>";

/// The SVG document.
pub(super) fn render(shown: &Shown<'_>, lang: Lang) -> String {
    let e = shown.explanation;
    let rows = rows(shown, lang);
    let title = verdict(shown, lang);
    let top = 30 + 18 * title.lines().count();
    let frames = e.when.cells.len();
    let right = LEFT + frames * PX_A_FRAME;
    let bottom = top + ROW * rows.len();
    let of_rows = rows.iter().map(|r| right + 12 + r.indent + text_px(&r.text));
    let width = of_rows.chain(title.lines().map(|l| LEFT + text_px(l))).max().unwrap_or(right) + LEFT;
    let height = bottom + 54;
    let mut out = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13" role="img">
<title>{}</title>
{STYLE}
<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse"><path d="M0 6L6 0" class="hatch"/></pattern></defs>
<rect width="{width}" height="{height}" class="ground"/>
"##,
        escaped(title.lines().next().unwrap_or_default())
    );
    for (i, line) in title.lines().enumerate() {
        let _ = writeln!(out, r#"<text x="{LEFT}" y="{}">{}</text>"#, 20 + 18 * i, escaped(line));
    }
    for (i, row) in rows.iter().enumerate() {
        let y = top + ROW * i;
        bar(&mut out, row.course, y);
        let class = match row.course.truth {
            Tri::True => "yes",
            Tri::False => "no",
            Tri::Unknown => "unknown",
        };
        let (x, y) = (right + 12 + row.indent, y + 13);
        let _ = writeln!(out, r#"<text x="{x}" y="{y}" class="{class}">{}</text>"#, escaped(&row.text));
    }
    for frame in (0..=frames).step_by(50) {
        let (x, y, s) = (LEFT + frame * PX_A_FRAME, bottom + 18, seconds(frame));
        let _ = writeln!(out, r#"<path d="M{x} {bottom}v5" class="tick"/>"#);
        let _ = writeln!(out, r#"<text x="{x}" y="{y}" text-anchor="middle" font-size="11">{s:.0} s</text>"#);
    }
    if let Some(frame) = e.moment {
        let x = LEFT + frame * PX_A_FRAME;
        let _ = writeln!(out, r#"<path d="M{x} {top}V{bottom}" class="moment"/>"#);
    }
    legend(&mut out, height - 14, lang);
    out.push_str("</svg>\n");
    out
}

/// What the bars and the words before the conditions mean.
fn legend(out: &mut String, y: usize, lang: Lang) {
    let mut x = LEFT;
    let words = match lang {
        Lang::Zh => ["成立", "不成立", "未知", "是、否、？ 与 [实际值] 均指竖线处"],
        Lang::En => ["true", "false", "unknown", "yes, no, ? and [values] are those at the upright line"],
    };
    for (cell, word) in [Tri::True, Tri::False, Tri::Unknown].into_iter().zip(words) {
        stretch(out, x, 24, y - 11, cell);
        x += 30;
        let _ = writeln!(out, r#"<text x="{x}" y="{y}" font-size="11">{word}</text>"#);
        x += text_px(word) + 16;
    }
    let _ = writeln!(out, r#"<text x="{x}" y="{y}" font-size="11">{}</text>"#, words[3]);
}

/// An upper bound of a text's width.
fn text_px(text: &str) -> usize {
    text.chars().map(|c| if c.is_ascii() { LETTER_PX } else { IDEOGRAPH_PX }).sum()
}

struct ChartRow<'a> {
    course: &'a Course,
    text: String,
    indent: usize,
}

fn rows<'a>(shown: &Shown<'a>, lang: Lang) -> Vec<ChartRow<'a>> {
    let e = shown.explanation;
    if e.parts.is_empty() {
        return Vec::new();
    }
    let marked = |course: &Course, text: String| format!("{} {text}", mark(course.truth, lang).trim());
    let text = marked(&e.when, whole(lang).to_owned());
    let mut out = vec![ChartRow { course: &e.when, text, indent: 0 }];
    for part in &e.parts {
        let text = with_value(text_of(part, lang), single(part), lang);
        out.push(ChartRow { course: &part.course, text: marked(&part.course, text), indent: 0 });
        if single(part).is_none() {
            out.extend(below(part).map(|atom| ChartRow {
                course: &atom.course,
                text: marked(&atom.course, with_value(atom.text.clone(), Some(atom), lang)),
                indent: 18,
            }));
        }
    }
    out
}

fn with_value(text: String, atom: Option<&AtomCourse>, lang: Lang) -> String {
    match atom.and_then(|a| actual(a, lang)) {
        Some(value) => format!("{text}  [{value}]"),
        None => text,
    }
}

/// Stretches of equal cells.
fn bar(out: &mut String, course: &Course, y: usize) {
    let (mut start, y) = (0, y + 2);
    for cells in course.cells.chunk_by(|a, b| a == b) {
        let (x, width) = (LEFT + start * PX_A_FRAME, cells.len() * PX_A_FRAME);
        start += cells.len();
        if let Cell::Known(truth) = cells[0] {
            stretch(out, x, width, y, truth);
        }
    }
}

/// One stretch: high where true, low where false, hatched where unknown.
fn stretch(out: &mut String, x: usize, width: usize, y: usize, truth: Tri) {
    let (class, y, height) = match truth {
        Tri::True => ("t", y, 14),
        Tri::False => ("f", y + 10, 4),
        Tri::Unknown => ("u", y, 14),
    };
    let _ = writeln!(out, r#"<rect x="{x}" y="{y}" width="{width}" height="{height}" class="{class}"/>"#);
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
