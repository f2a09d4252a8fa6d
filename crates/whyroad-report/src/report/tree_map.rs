//! Coverage as a tree map: every leaf a cell of equal area inside its L2, inside its L1. States differ by fill,
//! by pattern and by the mark in the cell, so that the map can be read without color.

use crate::coverage::{LeafRow, UnresolvedRow, state_name};
use whyroad_model::Bilingual;
use whyroad_model::messages::CoverageState;
use whyroad_render::markup::Markup;

/// Size of the map in CSS pixels; it scales with the page.
const WIDTH: f64 = 1240.0;
const HEIGHT: f64 = 900.0;
const L1_HEADER: f64 = 22.0;
const L2_HEADER: f64 = 15.0;
const GAP: f64 = 2.0;

/// An upright rectangle in map pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) w: f64,
    pub(super) h: f64,
}

impl Rect {
    fn inset(self, top: f64, side: f64) -> Rect {
        Rect {
            x: self.x + side,
            y: self.y + top,
            w: (self.w - 2.0 * side).max(0.0),
            h: (self.h - top - side).max(0.0),
        }
    }
}

/// Divides `area` into rectangles with areas in proportion to `weights`, in order, as square as possible.
///
/// Squarified tree maps: Bruls, Huizing, van Wijk 2000; the order is kept here because the taxonomy has one.
pub(super) fn squarify(weights: &[f64], area: Rect) -> Vec<Rect> {
    let total: f64 = weights.iter().sum();
    let mut out = Vec::with_capacity(weights.len());
    let mut rest = area;
    let mut i = 0;
    let unit = if total > 0.0 { area.w * area.h / total } else { 0.0 };
    while i < weights.len() {
        let side = rest.w.min(rest.h);
        let mut n = 1;
        while i + n < weights.len()
            && worst_ratio(&weights[i..=i + n], unit, side) <= worst_ratio(&weights[i..i + n], unit, side)
        {
            n += 1;
        }
        let strip: f64 = weights[i..i + n].iter().sum::<f64>() * unit;
        if rest.w >= rest.h {
            let w = if rest.h > 0.0 { strip / rest.h } else { 0.0 };
            let mut y = rest.y;
            for weight in &weights[i..i + n] {
                let h = if w > 0.0 { weight * unit / w } else { 0.0 };
                out.push(Rect { x: rest.x, y, w, h });
                y += h;
            }
            rest = Rect { x: rest.x + w, w: rest.w - w, ..rest };
        } else {
            let h = if rest.w > 0.0 { strip / rest.w } else { 0.0 };
            let mut x = rest.x;
            for weight in &weights[i..i + n] {
                let w = if h > 0.0 { weight * unit / h } else { 0.0 };
                out.push(Rect { x, y: rest.y, w, h });
                x += w;
            }
            rest = Rect { y: rest.y + h, h: rest.h - h, ..rest };
        }
        i += n;
    }
    out
}

fn worst_ratio(weights: &[f64], unit: f64, side: f64) -> f64 {
    let strip = weights.iter().sum::<f64>() * unit / side;
    weights
        .iter()
        .map(|w| {
            let length = w * unit / strip;
            (length / strip).max(strip / length)
        })
        .fold(0.0, f64::max)
}

/// The map as SVG.
pub(super) fn render(rows: &[LeafRow<'_>], unresolved: &[UnresolvedRow<'_>]) -> Markup {
    let mut m = Markup::new();
    m.raw("<svg class=\"treemap\" viewBox=\"0 0 ").num(WIDTH, 0).raw(" ").num(HEIGHT, 0);
    m.raw("\" role=\"group\" aria-label=\"coverage\"><defs>");
    m.raw(concat!(
        "<pattern id=\"hatch\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">",
        "<rect width=\"8\" height=\"8\" class=\"hatch-ground\"/><rect width=\"2.5\" height=\"8\" class=\"hatch-line\"/></pattern>",
        "<pattern id=\"dots\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\">",
        "<rect width=\"7\" height=\"7\" class=\"dot-ground\"/><circle cx=\"2\" cy=\"2\" r=\"1\" class=\"dot-mark\"/></pattern></defs>"
    ));
    let l1s = groups(rows, |r| r.l1.id.clone());
    let weights: Vec<f64> = l1s.iter().map(|g| g.len() as f64).collect();
    let whole = Rect { x: 0.0, y: 0.0, w: WIDTH, h: HEIGHT };
    for (group, area) in l1s.iter().zip(squarify(&weights, whole)) {
        let area = area.inset(GAP, GAP);
        m.raw("<g>");
        rect(&mut m, area, "tm-l1");
        m.raw("<text class=\"tm-l1-name\" x=\"")
            .num(area.x + 6.0, 1)
            .raw("\" y=\"")
            .num(area.y + 16.0, 1)
            .raw("\">");
        fitted(&mut m, &group[0].l1.name, area.w - 46.0, 13.5);
        m.raw(" <tspan class=\"faint\">");
        found_of(&mut m, group).raw("</tspan></text>");
        let inner = area.inset(L1_HEADER, 3.0);
        let l2s = groups(group, |r| r.l2.id.clone());
        let weights: Vec<f64> = l2s.iter().map(|g| g.len() as f64).collect();
        for (l2, area) in l2s.iter().zip(squarify(&weights, inner)) {
            let more = unresolved.iter().find(|u| u.l2.id == l2[0].l2.id).map_or(0, |u| u.found.episodes);
            l2_block(&mut m, l2, more, area.inset(1.0, 1.0));
        }
        m.raw("</g>");
    }
    m.raw("</svg>");
    m
}

/// `more`: episodes of the L2 whose variant is not known.
fn l2_block(m: &mut Markup, rows: &[LeafRow<'_>], more: u64, area: Rect) {
    rect(m, area, "tm-l2");
    let name = &rows[0].l2.name;
    m.raw("<text class=\"tm-l2-name\" x=\"")
        .num(area.x + 4.0, 1)
        .raw("\" y=\"")
        .num(area.y + 11.5, 1)
        .raw("\">");
    let room = if more > 0 { 26.0 } else { 6.0 };
    fitted(m, name, area.w - room, 11.0);
    if more > 0 {
        m.raw("<tspan class=\"more\"> +").int(more).raw("</tspan><title>+").int(more);
        m.raw(" 变体未定 / variant not known</title>");
    }
    m.raw("</text>");
    let weights = vec![1.0; rows.len()];
    for (row, cell) in rows.iter().zip(squarify(&weights, area.inset(L2_HEADER, 2.0))) {
        leaf_cell(m, row, cell.inset(0.75, 0.75));
    }
}

fn leaf_cell(m: &mut Markup, row: &LeafRow<'_>, cell: Rect) {
    let id = row.id.to_string();
    m.raw("<a class=\"tm-leaf\" href=\"#leaf-")
        .text(&id)
        .raw("\" data-leaf=\"")
        .text(&id)
        .raw("\" data-state=\"");
    m.text(row.state.id()).raw("\"><title>").text(&id).raw(" · ").text(&row.l3.name.zh).raw(" · ");
    m.text(&row.l3.name.en).raw(" · ");
    let state = state_name(row.state);
    m.text(&state.zh).raw(" / ").text(&state.en);
    let part = row.searched_in_part();
    if let Some((searched, all)) = part {
        m.raw(" · ").int(searched).raw("/").int(all).raw(" 个行程 / drives");
    }
    m.raw("</title>");
    rect(
        m,
        cell,
        match row.state {
            CoverageState::Found => "st-found",
            CoverageState::NotFound => "st-not_found",
            CoverageState::NotObservable => "st-not_observable",
            CoverageState::NoRule => "st-no_rule",
        },
    );
    let name = &row.l3.name;
    for (lang, text) in [("zh", &name.zh), ("en", &name.en)] {
        let lines = wrap(text, cell.w - 5.0, 11.0, ((cell.h - 14.0) / 12.0).floor().max(1.0) as usize);
        for (i, line) in lines.iter().enumerate() {
            m.raw("<text class=\"tm-name\" lang=\"").text(lang).raw("\" x=\"").num(cell.x + 3.5, 1);
            m.raw("\" y=\"").num(cell.y + 12.0 + 12.0 * i as f64, 1).raw("\">").text(line).raw("</text>");
        }
    }
    if let Some((searched, all)) = part {
        m.raw("<text class=\"tm-part\" x=\"")
            .num(cell.x + 3.5, 1)
            .raw("\" y=\"")
            .num(cell.y + cell.h - 4.0, 1);
        m.raw("\">").int(searched).raw("/").int(all).raw("</text>");
    }
    m.raw("<text class=\"tm-mark\" x=\"").num(cell.x + cell.w - 4.0, 1).raw("\" y=\"");
    m.num(cell.y + cell.h - 4.0, 1).raw("\">");
    match row.state {
        CoverageState::Found => m.int(row.episodes),
        CoverageState::NotFound => m.raw("0"),
        CoverageState::NotObservable => m.raw("?"),
        CoverageState::NoRule => m.raw("–"),
    };
    m.raw("</text></a>");
}

fn rect(m: &mut Markup, r: Rect, class: &'static str) {
    m.raw("<rect class=\"").raw(class).raw("\" x=\"").num(r.x, 1).raw("\" y=\"").num(r.y, 1);
    m.raw("\" width=\"").num(r.w, 1).raw("\" height=\"").num(r.h, 1).raw("\"/>");
}

fn found_of<'m>(m: &'m mut Markup, rows: &[LeafRow<'_>]) -> &'m mut Markup {
    let found = rows.iter().filter(|r| r.state == CoverageState::Found).count();
    m.int(found).raw("/").int(rows.len())
}

/// Runs of rows with one key; the rows are in tree order.
fn groups<'r, 'a>(rows: &'r [LeafRow<'a>], key: impl Fn(&LeafRow<'a>) -> String) -> Vec<&'r [LeafRow<'a>]> {
    rows.chunk_by(|a, b| key(a) == key(b)).collect()
}

/// Width of a text in a proportional font of `size`: a Chinese character is as wide as the size, a Latin one
/// a little over half of it.
fn width_px(text: &str, size: f64) -> f64 {
    text.chars().map(|c| if c.is_ascii() { 0.56 * size } else { size }).sum()
}

fn fitted(m: &mut Markup, name: &Bilingual, width: f64, size: f64) {
    for (lang, text) in [("zh", &name.zh), ("en", &name.en)] {
        m.raw("<tspan lang=\"").text(lang).raw("\">").text(&shorten(text, width, size)).raw("</tspan>");
    }
}

fn shorten(text: &str, width: f64, size: f64) -> String {
    if width_px(text, size) <= width {
        return text.to_owned();
    }
    let mut out = String::new();
    for c in text.chars() {
        if width_px(&out, size) + width_px(&c.to_string(), size) + size * 0.8 > width {
            break;
        }
        out.push(c);
    }
    out.trim_end().to_owned() + "…"
}

/// Breaks a name into at most `max_lines` lines, between words where it has any, between characters where not.
fn wrap(text: &str, width: f64, size: f64, max_lines: usize) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for c in text.chars() {
        // A Chinese character may end a line, and so is a separate word.
        match words.last_mut() {
            Some(w) if c.is_ascii() && c != ' ' && w.ends_with(|l: char| l.is_ascii() && l != ' ') => {
                w.push(c)
            }
            Some(w) if c == ' ' => w.push(c),
            _ => words.push(c.to_string()),
        }
    }
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if width_px(line, size) + width_px(word.trim_end(), size) <= width => {
                line.push_str(&word)
            }
            _ => lines.push(word),
        }
    }
    if lines.len() > max_lines {
        let rest: String = lines.drain(max_lines - 1..).collect();
        lines.push(rest);
    }
    lines.iter().map(|l| shorten(l.trim_end(), width, size)).collect()
}

#[cfg(test)]
mod tests;
