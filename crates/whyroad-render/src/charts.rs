//! Small charts for pages: one measure each, the value always shown beside its mark, so that they can be read without
//! color, in print, and by a screen reader. Styles are classes; the page that includes them defines their appearance.

use crate::markup::Markup;
use whyroad_model::Bilingual;
use whyroad_model::display::number;

/// A bar in proportion to `most`, without its value: the cell beside it shows it.
pub fn bar(value: f64, most: f64) -> Markup {
    let share = if most > 0.0 && value.is_finite() { (value / most).clamp(0.0, 1.0) } else { 0.0 };
    let mut m = Markup::new();
    m.raw(
        "<svg class=\"chart-bar\" viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" aria-hidden=\"true\">",
    );
    if share > 0.0 {
        m.raw("<rect x=\"0\" y=\"1\" height=\"8\" width=\"").num(share * 100.0, 2).raw("\"/>");
    }
    m.raw("</svg>");
    m
}

/// An estimate as a dot on the line of its interval, on an axis from 0 to `most`.
pub fn interval(low: f64, value: f64, high: f64, most: f64) -> Markup {
    let x = |v: f64| if most > 0.0 { 2.0 + (v / most).clamp(0.0, 1.0) * 96.0 } else { 2.0 };
    let mut m = Markup::new();
    m.raw("<svg class=\"chart-interval\" viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" aria-hidden=\"true\">");
    m.raw("<path d=\"M").num(x(low), 2).raw(" 5H").num(x(high), 2);
    for end in [low, high] {
        m.raw("M").num(x(end), 2).raw(" 2V8");
    }
    m.raw("\"/><rect y=\"3\" height=\"4\" width=\"1.6\" x=\"").num(x(value) - 0.8, 2).raw("\"/></svg>");
    m
}

/// Size of [`columns`] in user units.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 168.0;
const LEFT: f64 = 8.0;
const BASE: f64 = 132.0;
const TOP: f64 = 26.0;

/// A column per entry, in the order given; an unknown value is a question mark. Values are written above as far as they
/// fit, names below.
pub fn columns(title: &Bilingual, entries: &[(String, Option<f64>)], digits: usize) -> Markup {
    let most = entries.iter().filter_map(|e| e.1).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let step = (WIDTH - 2.0 * LEFT) / entries.len().max(1) as f64;
    // A name needs some 34 units, a value some 26.
    let every = |room: f64| (room / step).ceil().max(1.0) as usize;
    let (name_every, value_every) = (every(62.0), every(24.0));
    let mut m = Markup::new();
    m.raw("<figure class=\"chart\"><figcaption>").both(title).raw("</figcaption>");
    m.raw("<svg class=\"chart-columns\" viewBox=\"0 0 ").num(WIDTH, 0).raw(" ").num(HEIGHT, 0);
    m.raw("\"><path class=\"chart-axis\" d=\"M8 132H632\"/>");
    let last = entries.len().saturating_sub(1);
    for (i, (name, value)) in entries.iter().enumerate() {
        let middle = LEFT + step * (i as f64 + 0.5);
        let height = value.filter(|v| v.is_finite() && most > 0.0).map_or(0.0, |v| (BASE - TOP) * v / most);
        if height > 0.0 {
            let width = (step * 0.72).clamp(1.0, 44.0);
            m.raw("<rect x=\"").num(middle - width / 2.0, 1).raw("\" y=\"").num(BASE - height, 1);
            m.raw("\" width=\"").num(width, 1).raw("\" height=\"").num(height, 1).raw("\"><title>");
            m.text(name).raw(": ").text(&number(value.unwrap_or(f64::NAN), digits)).raw("</title></rect>");
        }
        if (last - i).is_multiple_of(value_every) {
            m.raw("<text class=\"chart-value\" x=\"")
                .num(middle, 1)
                .raw("\" y=\"")
                .num(BASE - height - 4.0, 1);
            m.raw("\">").text(&value.map_or("?".to_owned(), |v| number(v, digits))).raw("</text>");
        }
        if (last - i).is_multiple_of(name_every) {
            m.raw("<text class=\"chart-name\" x=\"").num(middle, 1).raw("\" y=\"").num(BASE + 16.0, 1);
            m.raw("\">").text(name).raw("</text>");
        }
    }
    m.raw("</svg></figure>");
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_in_proportion() {
        assert!(bar(5.0, 10.0).into_string().contains("width=\"50\""));
        assert!(!bar(0.0, 10.0).into_string().contains("<rect"));
        let line = interval(0.0, 5.0, 10.0, 10.0).into_string();
        assert!(line.contains("M2 5H98") && line.contains("x=\"49.2\""), "{line}");
    }

    #[test]
    fn columns_write_values_and_say_what_is_unknown() {
        let entries = [("2026-11-02".to_owned(), Some(4.0)), ("<b>".to_owned(), None)];
        let chart = columns(&Bilingual::new("每周", "per week"), &entries, 1).into_string();
        assert!(chart.contains(">4</text>") && chart.contains(">?</text>"), "{chart}");
        assert!(chart.contains("&lt;b&gt;") && !chart.contains("<b>"));
        assert_eq!(chart.matches("<rect").count(), 1, "unknown has no column");
    }

    #[test]
    fn many_columns_leave_room_between_their_names() {
        let weeks: Vec<(String, Option<f64>)> = (0..60).map(|i| (format!("w{i}"), Some(1.0))).collect();
        let chart = columns(&Bilingual::same("t"), &weeks, 0).into_string();
        let names = chart.matches("chart-name").count();
        assert!((5..=12).contains(&names), "{names}");
        assert!(chart.contains(">w59</text>"), "the newest is named");
    }
}
