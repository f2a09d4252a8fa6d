//! An explanation as a page: the scene at the explained moment, and the conditions over time with their numbers.

use whyroad_model::{Drive, Lang, TrackId};
use whyroad_render::birds_eye;
use whyroad_render::markup::Markup;
use whyroad_render::truths::{self, TruthChart};

/// Scene and chart beside each other where there is room for the conditions' texts, which are right of their bars.
const STYLE: &str = "\n\
    .explained { max-width: none; padding: 16px 24px; }\n\
    .explained h1 { font-size: 20px; margin: 0 0 12px; }\n\
    .explained .parts { display: grid; grid-template-columns: minmax(min(300px, 100%), 30rem) minmax(0, 1fr); gap: 24px; align-items: start; }\n\
    .explained .parts > :only-child { grid-column: 1 / -1; }\n\
    .explained figure { margin: 0 0 16px; }\n\
    .explained figcaption { font-weight: 600; margin-bottom: 4px; }\n\
    .explained pre { white-space: pre-wrap; font: inherit; }\n\
    .explained .course { overflow-x: auto; }\n\
    .explained .course > svg { max-width: 100%; height: auto; }\n\
    @media (max-width: 1750px) { .explained .parts { grid-template-columns: minmax(0, 1fr); } .explained .scene { max-width: 30rem; } }\n\
    .explained .narrow { display: none; }\n\
    @media screen and (max-width: 900px) { .explained { padding: 16px; } .explained .course > svg { display: none; } .explained .course > .narrow { display: block; } .explained .narrow svg { max-width: 100%; height: auto; } }\n\
    @media print { .explained .course > svg { max-width: 100%; } .explained .scene { max-width: 20rem; } }\n";

/// A moment that is drawn.
pub(super) struct Scene<'a> {
    /// Frame of the drive.
    pub frame: usize,
    pub target: Option<&'a TrackId>,
    /// Text above the scene; empty if there is only one.
    pub caption: String,
}

/// The document. `text` is shown below the chart, which is in the page twice: for wide and for narrow windows.
pub(super) fn page(
    title: &str,
    drive: &Drive,
    scenes: &[Scene<'_>],
    (chart, text): (&TruthChart, &str),
    lang: Lang,
) -> String {
    let mut head = Markup::new();
    head.raw("<!doctype html>\n<html lang=\"").raw(if lang == Lang::Zh { "zh" } else { "en" });
    head.raw("\">\n<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>").text(title).raw("</title>\n<style>");
    let mut body = Markup::new();
    body.raw("</style></head>\n<body>\n<main class=\"explained\">\n<h1>").text(title).raw("</h1>\n");
    body.raw("<div class=\"parts\">\n");
    if !scenes.is_empty() {
        body.raw("<div class=\"scene\">");
        for Scene { frame, target, caption } in scenes {
            body.raw("<figure>");
            if !caption.is_empty() {
                body.raw("<figcaption>").text(caption).raw("</figcaption>");
            }
            body.piece(&birds_eye::render(drive, *frame, *target)).raw("</figure>");
        }
        body.raw("</div>\n");
    }
    body.raw("<div class=\"course\">");
    let mut tail = Markup::new();
    tail.raw("\n");
    if !text.is_empty() {
        tail.raw("<pre>").text(text.trim()).raw("</pre>");
    }
    let (head, body, tail) = (head.into_string(), body.into_string(), tail.into_string());
    let style = whyroad_report::STYLE;
    let (wide, narrow) = (truths::render(chart), truths::render_narrow(chart));
    format!(
        "{head}{style}{STYLE}{body}{wide}<div class=\"narrow\">{narrow}</div>{tail}</div>\n</div>\n</main>\n</body>\n</html>\n"
    )
}
