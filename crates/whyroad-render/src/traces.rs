//! Signals over time as a self-contained SVG file: one panel per case, one row per signal, the expected time range
//! shaded and keyframes marked. Unknown is a gap, infinite a dotted line at the top.

use crate::markup::Markup;
use whyroad_model::display::number;
use whyroad_model::{Column, FrameRange, Tri};

/// Frames per second of the drawn data.
const RATE: f64 = 10.0;
const LEFT: f64 = 300.0;
const RIGHT: f64 = 748.0;
const ROW: f64 = 26.0;
const HEAD: f64 = 22.0;
const FOOT: f64 = 24.0;

/// One panel.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Above the panel.
    pub title: String,
    /// Length of the time axis, s.
    pub seconds: f64,
    /// Shaded time ranges, s.
    pub ranges: Vec<(f64, f64)>,
    /// Marked moments, s.
    pub keyframes: Vec<f64>,
    /// Signals, from top to bottom.
    pub rows: Vec<Row>,
}

/// One signal.
#[derive(Clone, Debug)]
pub struct Row {
    /// Displayed name.
    pub name: String,
    /// Displayed unit; empty where there is none.
    pub unit: String,
    /// Factor from the base unit to `unit`, for numbers.
    pub per_base_unit: f64,
    /// 10 Hz from the start of the panel.
    pub column: Column,
    /// The frames that are drawn.
    pub shown: FrameRange,
}

/// The panels below one another, as a file.
pub fn render(panels: &[Panel]) -> String {
    let height: f64 = panels.iter().map(panel_height).sum();
    let mut m = Markup::new();
    m.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 ")
        .num(height, 0)
        .raw("\" width=\"760\">");
    m.raw(
        "<style>text{font:11px sans-serif;fill:#222}.n{font-family:monospace}.t{font-weight:bold}.s{fill:#777;font-size:9px}\
         .a{stroke:#bbb;fill:none}.l{stroke:#1f5fa8;fill:none;stroke-width:1.5}.f{fill:#1f5fa8}.g{stroke:#1f5fa8}.c{fill:#dbe7f5}\
         .k{stroke:#c0392b;stroke-width:1.5}.r{fill:#fdf0c4}.i{stroke:#1f5fa8;stroke-dasharray:2 3}</style>",
    );
    m.raw("<rect width=\"760\" height=\"").num(height, 0).raw("\" fill=\"#fff\"/>\n");
    let mut y = 0.0;
    for panel in panels {
        draw(&mut m, panel, y);
        y += panel_height(panel);
    }
    m.raw("</svg>\n");
    m.into_string()
}

fn panel_height(panel: &Panel) -> f64 {
    HEAD + ROW * panel.rows.len() as f64 + FOOT
}

fn draw(m: &mut Markup, panel: &Panel, top: f64) {
    let x = |seconds: f64| LEFT + (RIGHT - LEFT) * (seconds / panel.seconds.max(0.1)).clamp(0.0, 1.0);
    let (upper, lower) = (top + HEAD, top + HEAD + ROW * panel.rows.len() as f64);
    m.raw("<text class=\"t\" x=\"8\" y=\"").num(top + 15.0, 1).raw("\">").text(&panel.title).raw("</text>\n");
    for &(from, to) in &panel.ranges {
        m.raw("<rect class=\"r\" x=\"").num(x(from), 1).raw("\" y=\"").num(upper, 1);
        m.raw("\" width=\"")
            .num((x(to) - x(from)).max(1.0), 1)
            .raw("\" height=\"")
            .num(lower - upper, 1)
            .raw("\"/>\n");
    }
    for (i, row) in panel.rows.iter().enumerate() {
        draw_row(m, row, upper + ROW * i as f64, &x);
    }
    for &at in &panel.keyframes {
        m.raw("<path class=\"k\" d=\"M")
            .num(x(at), 1)
            .raw(" ")
            .num(upper - 3.0, 1)
            .raw("V")
            .num(lower, 1)
            .raw("\"/>\n");
    }
    m.raw("<path class=\"a\" d=\"M").num(LEFT, 0).raw(" ").num(lower, 1).raw("H").num(RIGHT, 0).raw("\"/>\n");
    let step = [1.0, 2.0, 5.0, 10.0, 20.0].into_iter().find(|s| panel.seconds / s <= 8.0).unwrap_or(60.0);
    let mut at = 0.0;
    while at <= panel.seconds + 1e-9 {
        m.raw("<text class=\"s\" text-anchor=\"middle\" x=\"")
            .num(x(at), 1)
            .raw("\" y=\"")
            .num(lower + 11.0, 1);
        m.raw("\">").num(at, 0).raw(" s</text>");
        at += step;
    }
    m.raw("\n");
}

fn draw_row(m: &mut Markup, row: &Row, top: f64, x: &dyn Fn(f64) -> f64) {
    let bottom = top + ROW;
    m.raw("<path class=\"a\" d=\"M8 ").num(bottom, 1).raw("H").num(RIGHT, 0).raw("\" opacity=\".4\"/>");
    m.raw("<text class=\"n\" x=\"8\" y=\"").num(top + 17.0, 1).raw("\">").text(&row.name).raw("</text>");
    let at = |frame: usize| x(frame as f64 / RATE);
    match &row.column {
        Column::Number(values) => numbers(m, row, values, top, &at),
        Column::Flag(_) => {
            for (frames, value) in runs(row.shown, |f| row.column.flag(f)) {
                let (y, height, class) = match value {
                    Tri::True => (top + 5.0, ROW - 9.0, "f"),
                    Tri::False => (bottom - 5.0, 1.0, "f"),
                    Tri::Unknown => continue,
                };
                block(m, class, (at(frames.start), at(frames.end)), (y, height));
            }
        }
        Column::Category { .. } => {
            for (frames, value) in runs(row.shown, |f| row.column.category(f)) {
                let Some(word) = value else { continue };
                let (x0, x1) = (at(frames.start), at(frames.end));
                block(m, "c", (x0, x1 - 1.0), (top + 4.0, ROW - 8.0));
                if x1 - x0 > 6.0 * word.len() as f64 {
                    m.raw("<text class=\"s\" x=\"").num(x0 + 4.0, 1).raw("\" y=\"").num(top + 16.0, 1);
                    m.raw("\">").text(word).raw("</text>");
                }
            }
        }
    }
    m.raw("\n");
}

fn block(m: &mut Markup, class: &'static str, (x0, x1): (f64, f64), (y, height): (f64, f64)) {
    m.raw("<rect class=\"").raw(class).raw("\" x=\"").num(x0, 1).raw("\" y=\"").num(y, 1);
    m.raw("\" width=\"").num((x1 - x0).max(0.8), 1).raw("\" height=\"").num(height, 1).raw("\"/>");
}

fn numbers(m: &mut Markup, row: &Row, values: &[f64], top: f64, at: &dyn Fn(usize) -> f64) {
    let shown =
        || (row.shown.start..row.shown.end).filter_map(|f| values.get(f).map(|v| (f, v * row.per_base_unit)));
    let finite = || shown().map(|(_, v)| v).filter(|v| v.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let (head, foot) = (top + 5.0, top + ROW - 5.0);
    let y = |v: f64| {
        if high > low { foot - (foot - head) * (v - low) / (high - low) } else { (head + foot) / 2.0 }
    };
    if low.is_finite() {
        let mut range = number(low, 2);
        if high > low {
            range = format!("{range} … {}", number(high, 2));
        }
        m.raw("<text class=\"s\" text-anchor=\"end\" x=\"")
            .num(LEFT - 6.0, 0)
            .raw("\" y=\"")
            .num(top + 17.0, 1);
        m.raw("\">").text(&range).raw(" ").text(&row.unit).raw("</text>");
    }
    // A point where the line changes direction; the others lie on it.
    let mut line = Markup::new();
    let mut pen: Option<(f64, f64)> = None;
    let mut pending: Option<(f64, f64)> = None;
    for (frame, value) in shown().chain([(row.shown.end, f64::NAN)]) {
        if !value.is_finite() {
            if let Some((px, py)) = pending.take() {
                line.raw("L").num(px, 1).raw(" ").num(py, 1);
            }
            pen = None;
            continue;
        }
        let point = (at(frame), y(value));
        let Some(last) = pen else {
            line.raw("M").num(point.0, 1).raw(" ").num(point.1, 1);
            pen = Some(point);
            continue;
        };
        if let Some(p) = pending {
            let turn = (p.0 - last.0) * (point.1 - last.1) - (p.1 - last.1) * (point.0 - last.0);
            if turn.abs() > 0.5 {
                line.raw("L").num(p.0, 1).raw(" ").num(p.1, 1);
                pen = Some(p);
            }
        }
        pending = Some(point);
    }
    m.raw("<path class=\"l\" d=\"").piece(&line).raw("\"/>");
    let mut endless = Markup::new();
    for (frames, infinite) in runs(row.shown, |f| values.get(f) == Some(&f64::INFINITY)) {
        if infinite {
            endless
                .raw("M")
                .num(at(frames.start), 1)
                .raw(" ")
                .num(head - 2.0, 1)
                .raw("H")
                .num(at(frames.end), 1);
        }
    }
    let endless = endless.into_string();
    if !endless.is_empty() {
        m.raw("<path class=\"i\" d=\"").text(&endless).raw("\"><title>∞</title></path>");
    }
}

/// Stretches of equal value.
fn runs<T: PartialEq>(shown: FrameRange, value: impl Fn(usize) -> T) -> Vec<(FrameRange, T)> {
    let mut out: Vec<(FrameRange, T)> = Vec::new();
    for f in shown.start..shown.end {
        let v = value(f);
        match out.last_mut() {
            Some((range, last)) if *last == v => range.end = f + 1,
            _ => out.push((FrameRange::new(f, f + 1), v)),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(column: Column, n: usize) -> Panel {
        let row = Row {
            name: "a<b".into(),
            unit: "deg".into(),
            per_base_unit: 2.0,
            column,
            shown: FrameRange::new(0, n),
        };
        Panel { title: "1".into(), seconds: n as f64 / RATE, rows: vec![row], ..Panel::default() }
    }

    #[test]
    fn a_straight_line_needs_two_points_and_unknown_breaks_it() {
        let straight = render(&[panel(Column::Number((0..50).map(f64::from).collect()), 50)]);
        let path = straight.split("class=\"l\" d=\"").nth(1).unwrap().split('"').next().unwrap();
        assert_eq!((path.matches('M').count(), path.matches('L').count()), (1, 1), "{path}");
        // Shown in the unit: 49 base units are 98 deg.
        assert!(straight.contains("0 … 98 deg") && straight.contains("a&lt;b"));
        let mut values = vec![1.0; 20];
        values[10] = f64::NAN;
        let broken = render(&[panel(Column::Number(values), 20)]);
        let path = broken.split("class=\"l\" d=\"").nth(1).unwrap().split('"').next().unwrap();
        assert_eq!(path.matches('M').count(), 2, "{path}");
    }

    #[test]
    fn a_flag_is_a_block_while_true_and_nothing_while_unknown() {
        let flags = [vec![Tri::False; 5], vec![Tri::True; 5], vec![Tri::Unknown; 5]].concat();
        let svg = render(&[panel(Column::Flag(flags), 15)]);
        assert_eq!(svg.matches("<rect class=\"f\"").count(), 2);
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    }
}
