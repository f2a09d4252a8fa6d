//! A bar chart as a separate SVG file: one row per name, the value written beside its bar, so that it can be read
//! in print and without colors.

use crate::markup::Markup;
use whyroad_model::display::number;

/// Height of a row, least width of names, and width of bars, in user units.
const ROW: f64 = 18.0;
const NAMES: f64 = 250.0;
/// Upper bounds of the mean width of a Latin letter and of a Chinese one at 12 units.
const LETTER: f64 = 7.0;
const IDEOGRAPH: f64 = 12.0;
const BARS: f64 = 300.0;

/// The chart; rows in the order given.
pub fn bars(title: &str, rows: &[(String, f64)]) -> String {
    let most = rows.iter().map(|r| r.1).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let name_width =
        |name: &str| name.chars().map(|c| if c.is_ascii() { LETTER } else { IDEOGRAPH }).sum::<f64>();
    // Names end at the bars: a name that is wider than its room would begin left of the chart.
    let names = rows.iter().map(|r| name_width(&r.0) + 14.0).fold(NAMES, f64::max).ceil();
    let (width, height) = (names + BARS + 80.0, 34.0 + ROW * rows.len() as f64);
    let mut m = Markup::new();
    m.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"")
        .num(width, 0)
        .raw("\" height=\"")
        .num(height, 0);
    m.raw("\" viewBox=\"0 0 ")
        .num(width, 0)
        .raw(" ")
        .num(height, 0)
        .raw("\" role=\"img\" font-family=\"sans-serif\" ");
    m.raw("font-size=\"12\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/><title>").text(title);
    m.raw("</title><text x=\"8\" y=\"18\" font-weight=\"bold\">").text(title).raw("</text>");
    for (i, (name, value)) in rows.iter().enumerate() {
        let y = 30.0 + ROW * i as f64;
        m.raw("<text text-anchor=\"end\" x=\"")
            .num(names - 6.0, 0)
            .raw("\" y=\"")
            .num(y + 12.0, 0)
            .raw("\">");
        m.text(name).raw("</text>");
        let length = if most > 0.0 && value.is_finite() { BARS * value / most } else { 0.0 };
        m.raw("<rect x=\"").num(names, 0).raw("\" y=\"").num(y + 2.0, 0).raw("\" height=\"13\" width=\"");
        m.num(length, 1).raw("\" fill=\"#4477aa\" stroke=\"#223355\" stroke-width=\"0.5\"/>");
        m.raw("<text x=\"").num(names + length + 5.0, 1).raw("\" y=\"").num(y + 12.0, 0).raw("\">");
        m.text(&number(*value, 3)).raw("</text>");
    }
    m.raw("</svg>\n");
    m.into_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_in_proportion_and_names_escaped() {
        let svg = bars("a < b", &[("x&y".into(), 10.0), ("z".into(), 5.0)]);
        assert!(svg.contains("a &lt; b") && svg.contains("x&amp;y"));
        assert!(svg.contains("width=\"300\"") && svg.contains("width=\"150\""), "{svg}");
        // Chromium measures 319.8 units for this name in DejaVu Sans (`getComputedTextLength`), a wide font.
        let long = "reactive_agent.intersection_interaction.cross_conflict";
        let svg = bars("t", &[(long.into(), 1.0)]);
        let end: f64 =
            svg.split("text-anchor=\"end\" x=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        assert!(end >= 319.8, "{svg}");
        assert!(bars("empty", &[]).ends_with("</svg>\n"));
    }
}
