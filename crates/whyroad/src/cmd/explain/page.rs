//! An explanation as a page: the scene at the explained moment, and the conditions over time with their numbers.

use whyroad_model::{Drive, Lang, TrackId};
use whyroad_render::birds_eye;
use whyroad_render::markup::Markup;

/// Scene and chart beside each other where there is room for the conditions' texts, which are right of their bars.
const STYLE: &str = "\n\
    .explained { max-width: none; padding: 16px 24px; }\n\
    .explained h1 { font-size: 20px; margin: 0 0 12px; }\n\
    .explained .parts { display: grid; grid-template-columns: minmax(300px, 30rem) minmax(0, 1fr); gap: 24px; align-items: start; }\n\
    .explained .parts > :only-child { grid-column: 1 / -1; }\n\
    .explained .course { overflow-x: auto; }\n\
    .explained .course > svg { max-width: 100%; height: auto; }\n\
    @media (max-width: 1750px) { .explained .parts { grid-template-columns: minmax(0, 1fr); } .explained .scene { max-width: 30rem; } }\n\
    @media (max-width: 900px) { .explained .course > svg { max-width: none; } }\n\
    @media print { .explained .course > svg { max-width: 100%; } .explained .scene { max-width: 20rem; } }\n";

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
    body.raw("</style></head>\n<body>\n<main class=\"explained\">\n<h1>").text(title).raw("</h1>\n");
    body.raw("<div class=\"parts\">\n");
    if let Some(frame) = frame {
        body.raw("<div class=\"scene\">").piece(&birds_eye::render(drive, frame, target));
        body.raw("</div>\n");
    }
    body.raw("<div class=\"course\">");
    let (head, body) = (head.into_string(), body.into_string());
    format!("{head}{}{STYLE}{body}{chart}</div>\n</div>\n</main>\n</body>\n</html>\n", whyroad_report::STYLE)
}
