//! An explanation as a page: the scene at the explained moment, and the conditions over time with their numbers.

use whyroad_model::{Drive, Lang, TrackId};
use whyroad_render::birds_eye;
use whyroad_render::markup::Markup;

/// The document. `chart` is an SVG of [`whyroad_render::truths::render`].
pub(super) fn page(
    title: &str,
    drive: &Drive,
    frame: Option<usize>,
    target: Option<&TrackId>,
    chart: &str,
    lang: Lang,
) -> String {
    let mut head = Markup::new();
    head.raw("<!doctype html>\n<html lang=\"").raw(if lang == Lang::Zh { "zh" } else { "en" });
    head.raw("\">\n<head><meta charset=\"utf-8\">\n<title>").text(title).raw("</title>\n<style>");
    let mut body = Markup::new();
    body.raw("</style></head>\n<body>\n<h1>").text(title).raw("</h1>\n");
    if let Some(frame) = frame {
        body.raw("<div style=\"max-width: 32rem\">").piece(&birds_eye::render(drive, frame, target));
        body.raw("</div>\n");
    }
    format!("{}{}{}{chart}</body>\n</html>\n", head.into_string(), whyroad_report::STYLE, body.into_string())
}
