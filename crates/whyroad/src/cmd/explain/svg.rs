//! An explanation as a picture: a lane over time for each condition, green where it is true, grey where it is false,
//! hatched where it is unknown, and a line at the moment that is told about.

use super::text::{actual, below, single, text_of, verdict, whole};
use super::{Shown, seconds};
use std::fmt::Write as _;
use whyroad_mining::explain::{AtomCourse, Cell, Course};
use whyroad_model::{Lang, Tri};

const LEFT: usize = 16;
const PX_A_FRAME: usize = 3;
const ROW: usize = 22;
const TEXT_WIDTH: usize = 640;

/// The SVG document.
pub(super) fn render(shown: &Shown<'_>, lang: Lang) -> String {
    let e = shown.explanation;
    let rows = rows(shown, lang);
    let title = verdict(shown, lang);
    let top = 30 + 18 * title.lines().count();
    let frames = e.when.cells.len();
    let right = LEFT + frames * PX_A_FRAME;
    let bottom = top + ROW * rows.len();
    let (width, height) = (right + TEXT_WIDTH, bottom + 30);
    let mut out = format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">
<defs><pattern id="unknown" width="6" height="6" patternUnits="userSpaceOnUse"><path d="M0 6L6 0" stroke="#b8860b"/></pattern></defs>
<rect width="{width}" height="{height}" fill="white"/>
"##
    );
    for (i, line) in title.lines().enumerate() {
        let _ = writeln!(out, r#"<text x="{LEFT}" y="{}">{}</text>"#, 20 + 18 * i, escaped(line));
    }
    for (i, row) in rows.iter().enumerate() {
        let y = top + ROW * i;
        bar(&mut out, row.course, y);
        let colour = match row.course.truth {
            Tri::True => "#1a7f37",
            Tri::False => "#b42318",
            Tri::Unknown => "#8a6d00",
        };
        let (x, y) = (right + 12 + row.indent, y + 13);
        let _ = writeln!(out, r#"<text x="{x}" y="{y}" fill="{colour}">{}</text>"#, escaped(&row.text));
    }
    for frame in (0..=frames).step_by(50) {
        let (x, y, s) = (LEFT + frame * PX_A_FRAME, bottom + 18, seconds(frame));
        let _ = writeln!(out, r#"<path d="M{x} {bottom}v5" stroke="black"/>"#);
        let _ = writeln!(out, r#"<text x="{x}" y="{y}" text-anchor="middle" font-size="11">{s:.0} s</text>"#);
    }
    if let Some(frame) = e.moment {
        let x = LEFT + frame * PX_A_FRAME;
        let _ = writeln!(out, r##"<path d="M{x} {top}V{bottom}" stroke="#1f4fd8" stroke-width="2"/>"##);
    }
    out.push_str("</svg>\n");
    out
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
    let mut out = vec![ChartRow { course: &e.when, text: whole(lang).to_owned(), indent: 0 }];
    for part in &e.parts {
        let text = with_value(text_of(part, lang), single(part), lang);
        out.push(ChartRow { course: &part.course, text, indent: 0 });
        if single(part).is_none() {
            out.extend(below(part).map(|atom| ChartRow {
                course: &atom.course,
                text: with_value(atom.text.clone(), Some(atom), lang),
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
        let fill = match cells[0] {
            Cell::Known(Tri::True) => "#57ab5a",
            Cell::Known(Tri::False) => "#e3e6ea",
            Cell::Known(Tri::Unknown) => "url(#unknown)",
            Cell::Absent => continue,
        };
        let _ = writeln!(out, r#"<rect x="{x}" y="{y}" width="{width}" height="14" fill="{fill}"/>"#);
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
