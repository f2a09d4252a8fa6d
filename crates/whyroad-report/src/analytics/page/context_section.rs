//! Place, hour, weather, source: a table each, with a bar for the hours driven, or for the labels where no drives were
//! given.

use super::{Align, count, head, hours};
use crate::analytics::{Analytics, ContextRow, Dimension};
use whyroad_render::charts;
use whyroad_render::markup::Markup;

/// Values shown of a dimension; the table `contexts` has all.
const VALUES: usize = 24;

pub(super) fn write(m: &mut Markup, a: &Analytics) {
    if a.contexts.is_empty() {
        return;
    }
    m.raw("<h3>")
        .say("地点、时段、天气、来源", "Place, hour, weather, source")
        .raw("</h3><div class=\"charts\">");
    for dimension in Dimension::ALL {
        let rows: Vec<&ContextRow> = a.contexts.iter().filter(|r| r.dimension == dimension).collect();
        if !rows.is_empty() {
            table(m, dimension, &rows, a.utc_offset_h);
        }
    }
    m.raw("</div>");
}

fn table(m: &mut Markup, dimension: Dimension, rows: &[&ContextRow], utc_offset_h: i8) {
    // The bar is of one measure: the first that is given.
    type Measure = fn(&ContextRow) -> Option<f64>;
    let measures: [Measure; 4] = [
        |r| r.hours,
        |r| r.mined.map(|n| n as f64),
        |r| r.accepted.map(|n| n as f64),
        |r| r.released.map(|n| n as f64),
    ];
    let measure = measures.into_iter().find(|of| rows.iter().any(|r| of(r).is_some()));
    let most = measure.map_or(0.0, |of| rows.iter().filter_map(|r| of(r)).fold(0.0, f64::max));
    m.raw("<figure class=\"chart\"><figcaption>");
    match dimension {
        Dimension::Place => m.say("地点", "Place"),
        Dimension::Hour => m.say("时段", "Hour of the day"),
        Dimension::Weather => m.say("天气", "Weather"),
        Dimension::Source => m.say("来源", "Source"),
    };
    if dimension == Dimension::Hour {
        m.raw(if utc_offset_h < 0 { " (UTC−" } else { " (UTC+" }).int(utc_offset_h.unsigned_abs()).raw(")");
    }
    m.raw("</figcaption><table>");
    head(
        m,
        &[
            ("", "", Align::Text),
            ("行驶 h", "driven h", Align::Number),
            ("", "", Align::Bar),
            ("已挖掘", "mined", Align::Number),
            ("已接受", "accepted", Align::Number),
            ("已发布", "released", Align::Number),
        ],
    );
    m.raw("<tbody>");
    for row in rows.iter().take(VALUES) {
        m.raw("<tr><th scope=\"row\">");
        match &row.value {
            Some(value) if dimension == Dimension::Hour => drop(m.text(value).raw(":00")),
            Some(value) => value_name(m, dimension, value),
            None => drop(m.say("未注明", "not stated")),
        }
        m.raw("</th><td class=\"n\">");
        match row.hours {
            Some(value) => hours(m, value, 2),
            None => drop(m.raw("…")),
        }
        m.raw("</td><td class=\"bar\">");
        if let Some(value) = measure.and_then(|of| of(row)) {
            m.piece(&charts::bar(value, most));
        }
        for n in [row.mined, row.accepted, row.released] {
            m.raw("</td><td class=\"n\">");
            count(m, n);
        }
        m.raw("</td></tr>");
    }
    m.raw("</tbody></table>");
    if rows.len() > VALUES {
        m.raw("<p class=\"faint\">")
            .say("另有 ", "and ")
            .int(rows.len() - VALUES)
            .say(" 个", " more")
            .raw("</p>");
    }
    m.raw("</figure>");
}

/// Places and sources have the names that their drives state; the words for weather are those of the signal catalog.
fn value_name(m: &mut Markup, dimension: Dimension, value: &str) {
    let zh = match (dimension, value) {
        (Dimension::Weather, "clear") => "晴",
        (Dimension::Weather, "cloudy") => "多云",
        (Dimension::Weather, "rain") => "雨",
        (Dimension::Weather, "heavy_rain") => "大雨",
        (Dimension::Weather, "snow") => "雪",
        (Dimension::Weather, "fog") => "雾",
        _ => "",
    };
    if zh.is_empty() {
        m.text(value);
        return;
    }
    m.both(&whyroad_model::Bilingual::new(zh, value.replace('_', " ")));
}
