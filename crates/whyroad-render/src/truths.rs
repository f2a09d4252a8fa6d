//! Conditions over time as a self-contained SVG file: one row per condition, green where it is true, gray where it is
//! false, hatched where it is unknown, and a line at one moment. Legible without color (low bars, hatching, and words),
//! on light and dark backgrounds.

use crate::markup::Markup;
use whyroad_model::Tri;
use whyroad_model::scene::FRAME_RATE_HZ;

const LEFT: usize = 16;
const PX_PER_FRAME: f64 = 3.0;
const ROW: usize = 22;
/// Height of a curve below its row.
const CURVE: usize = 46;
/// Height of a line of text above a bar.
const LINE: usize = 17;
/// Width of the narrow arrangement: a phone's.
const NARROW: usize = 340;
/// Frames between two marks of the time axis.
const FRAMES_PER_TICK: usize = 50;
/// Room for the longest text: upper bounds of the mean width of a Latin letter and of a Chinese one at 13 px.
const LETTER_PX: usize = 7;
const IDEOGRAPH_PX: usize = 13;

/// Colors by meaning, for light and dark backgrounds.
const STYLE: &str = "<style>
svg { --ground: #ffffff; --ink: #1f2328; --yes: #1a7f37; --no: #b42318; --unknown: #8a6d00; --true: #57ab5a; --false: #d0d5db; --moment: #1f4fd8 }
@media (prefers-color-scheme: dark) {
svg { --ground: #15181c; --ink: #e6e8ea; --yes: #6fdc8c; --no: #ff8f84; --unknown: #e3b341; --true: #3f9950; --false: #4a525b; --moment: #7aa2ff }
}
.ground { fill: var(--ground) } text { fill: var(--ink) } .tick { stroke: var(--ink) }
.yes { fill: var(--yes) } .no { fill: var(--no) } .unknown { fill: var(--unknown) }
.t { fill: var(--true) } .f { fill: var(--false) } .hatch { stroke: var(--unknown) }
.moment { stroke: var(--moment); stroke-width: 2 }
.curve { fill: none; stroke: var(--ink); stroke-width: 1.5 } .threshold { stroke: var(--no); stroke-dasharray: 4 3 }
</style>";

/// The chart.
#[derive(Clone, Debug, Default)]
pub struct TruthChart {
    /// Above the rows, in one or more lines; the first one is the title of the document.
    pub title: String,
    /// Seconds of each frame.
    pub times_s: Vec<f64>,
    /// From top to bottom.
    pub rows: Vec<TruthRow>,
    /// The marked frame.
    pub moment: Option<usize>,
    /// Names of true, false and unknown in the legend.
    pub truth_words: [&'static str; 3],
    /// The rest of the legend.
    pub note: &'static str,
}

/// One condition.
#[derive(Clone, Debug)]
pub struct TruthRow {
    /// Beside the bar.
    pub text: String,
    /// How far the text is moved to the right, px.
    pub indent: usize,
    /// Truth at the marked moment.
    pub truth: Tri,
    /// Truth by frame; `None` where there is no value.
    pub cells: Vec<Option<Tri>>,
    /// The compared values, drawn below the bar.
    pub curve: Option<Curve>,
}

/// A number over time.
#[derive(Clone, Debug)]
pub struct Curve {
    /// By frame; values that are not finite are not drawn.
    pub values: Vec<f64>,
    /// Drawn as a dashed line.
    pub threshold: Option<f64>,
}

/// Arrangement of a chart.
struct Layout {
    px_per_frame: f64,
    /// Texts are above their bars, in lines of at most so many px; `None`: beside the bars.
    text_px: Option<usize>,
    /// Id of the hatching: unique in a page that holds both arrangements.
    hatch: &'static str,
}

impl Layout {
    fn x(&self, frame: usize) -> f64 {
        LEFT as f64 + frame as f64 * self.px_per_frame
    }

    /// Lines of a text that is moved to the right by `indent` px.
    fn lines(&self, text: &str, indent: usize) -> Vec<String> {
        match self.text_px {
            Some(room) => wrapped(text, room.saturating_sub(indent)),
            None => vec![text.to_owned()],
        }
    }

    /// Height of a row's texts where they are above the bar.
    fn text_height(&self, row: &TruthRow) -> usize {
        if self.text_px.is_some() { LINE * self.lines(&row.text, row.indent).len() + 2 } else { 0 }
    }

    fn height(&self, row: &TruthRow) -> usize {
        self.text_height(row) + if row.curve.is_some() { ROW + CURVE } else { ROW }
    }
}

/// The SVG document: texts beside their bars.
pub fn render(chart: &TruthChart) -> String {
    arranged(chart, &Layout { px_per_frame: PX_PER_FRAME, text_px: None, hatch: "hatch" })
}

/// The same for the width of a phone: texts above their bars.
pub fn render_narrow(chart: &TruthChart) -> String {
    let room = NARROW - 2 * LEFT;
    let px_per_frame = (room as f64 / chart.times_s.len().max(1) as f64).min(PX_PER_FRAME);
    arranged(chart, &Layout { px_per_frame, text_px: Some(room), hatch: "hatch-narrow" })
}

fn arranged(chart: &TruthChart, layout: &Layout) -> String {
    let rows = &chart.rows;
    let title: Vec<String> = chart.title.lines().flat_map(|l| layout.lines(l, 0)).collect();
    let top = 30 + 18 * title.len();
    let right = layout.x(chart.times_s.len());
    let beside = right as usize + 12;
    let bottom = top + rows.iter().map(|r| layout.height(r)).sum::<usize>();
    let width = if layout.text_px.is_some() {
        NARROW
    } else {
        let row_ends = rows.iter().map(|r| beside + r.indent + text_px(&r.text));
        row_ends.chain(title.iter().map(|l| LEFT + text_px(l))).max().unwrap_or(beside) + LEFT
    };
    let note = layout.lines(chart.note, 0);
    let height = bottom + 54 + if layout.text_px.is_some() { LINE * note.len() } else { 0 };
    let mut m = Markup::new();
    m.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"").int(width).raw("\" height=\"").int(height);
    m.raw("\" viewBox=\"0 0 ").int(width).raw(" ").int(height);
    m.raw("\" font-family=\"sans-serif\" font-size=\"13\" role=\"img\">\n<title>");
    m.text(chart.title.lines().next().unwrap_or_default()).raw("</title>\n").raw(STYLE);
    m.raw("\n<defs><pattern id=\"").raw(layout.hatch);
    m.raw("\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">");
    m.raw("<path d=\"M0 6L6 0\" class=\"hatch\"/></pattern></defs>\n<rect width=\"").int(width);
    m.raw("\" height=\"").int(height).raw("\" class=\"ground\"/>\n");
    for (i, line) in title.iter().enumerate() {
        at(&mut m, LEFT as f64, 20 + 18 * i).raw(">").text(line).raw("</text>\n");
    }
    let mut y = top;
    for row in rows {
        let class = match row.truth {
            Tri::True => "yes",
            Tri::False => "no",
            Tri::Unknown => "unknown",
        };
        let bar_y = y + layout.text_height(row);
        let x = (if layout.text_px.is_some() { LEFT } else { beside } + row.indent) as f64;
        bar(&mut m, &row.cells, bar_y, layout);
        if let Some(curve) = &row.curve {
            draw(&mut m, curve, bar_y + ROW, layout, right);
        }
        for (i, line) in layout.lines(&row.text, row.indent).iter().enumerate() {
            at(&mut m, x, y + 13 + LINE * i).raw(" class=\"").raw(class).raw("\">");
            m.text(line).raw("</text>\n");
        }
        y += layout.height(row);
    }
    for (frame, seconds) in ticks(&chart.times_s) {
        m.raw("<path d=\"M").num(layout.x(frame), 1).raw(" ").int(bottom).raw("v5\" class=\"tick\"/>\n");
        at(&mut m, layout.x(frame), bottom + 18).raw(" text-anchor=\"middle\" font-size=\"11\">");
        m.num(seconds, 1).raw(" s</text>\n");
    }
    if let Some(frame) = chart.moment {
        m.raw("<path d=\"M").num(layout.x(frame), 1).raw(" ").int(top).raw("V").int(bottom);
        m.raw("\" class=\"moment\"/>\n");
    }
    let x = legend(&mut m, bottom + 40, chart, layout);
    for (i, line) in note.iter().enumerate() {
        let (x, y) =
            if layout.text_px.is_some() { (LEFT, bottom + 40 + LINE * (i + 1)) } else { (x, bottom + 40) };
        at(&mut m, x as f64, y).raw(" font-size=\"11\">").text(line).raw("</text>\n");
    }
    m.raw("</svg>\n");
    m.into_string()
}

/// Frames with a mark of the time axis, and their times; the end of the last frame may be one.
fn ticks(times_s: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    let end = times_s.last().map(|last| last + 1.0 / FRAME_RATE_HZ);
    times_s.iter().copied().chain(end).enumerate().step_by(FRAMES_PER_TICK)
}

/// Begins a text; its tag is still open.
fn at(m: &mut Markup, x: f64, y: usize) -> &mut Markup {
    m.raw("<text x=\"").num(x, 1).raw("\" y=\"").int(y).raw("\"")
}

/// Meaning of the bars and of the words before the conditions; returns where it ends.
fn legend(m: &mut Markup, y: usize, chart: &TruthChart, layout: &Layout) -> usize {
    let mut x = LEFT;
    for (truth, word) in [Tri::True, Tri::False, Tri::Unknown].into_iter().zip(chart.truth_words) {
        stretch(m, (x as f64, 24.0), y - 11, truth, layout);
        x += 30;
        at(m, x as f64, y).raw(" font-size=\"11\">").text(word).raw("</text>\n");
        x += text_px(word) + 16;
    }
    x
}

/// An upper bound of a text's width.
fn text_px(text: &str) -> usize {
    text.chars().map(letter_px).sum()
}

fn letter_px(c: char) -> usize {
    if c.is_ascii() { LETTER_PX } else { IDEOGRAPH_PX }
}

/// `text` in lines of at most `room` px, broken at spaces, or within a word that is longer than a line or has none.
fn wrapped(text: &str, room: usize) -> Vec<String> {
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split_inclusive(' ') {
        if !line.is_empty() && text_px(&line) + text_px(word.trim_end()) > room {
            lines.push(std::mem::take(&mut line).trim_end().to_owned());
        }
        for c in word.chars() {
            if !line.is_empty() && !c.is_whitespace() && text_px(&line) + letter_px(c) > room {
                lines.push(std::mem::take(&mut line).trim_end().to_owned());
            }
            line.push(c);
        }
    }
    lines.push(line.trim_end().to_owned());
    lines
}

/// Stretches of equal cells.
fn bar(m: &mut Markup, cells: &[Option<Tri>], y: usize, layout: &Layout) {
    let (mut start, y) = (0, y + 2);
    for equal in cells.chunk_by(|a, b| a == b) {
        let (x, width) = (layout.x(start), equal.len() as f64 * layout.px_per_frame);
        start += equal.len();
        if let Some(truth) = equal[0] {
            stretch(m, (x, width), y, truth, layout);
        }
    }
}

/// A curve with its threshold, and the numbers at the ends of its scale.
fn draw(m: &mut Markup, curve: &Curve, top: usize, layout: &Layout, right: f64) {
    let all = || curve.values.iter().copied().chain(curve.threshold).filter(|v| v.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    if !low.is_finite() {
        return;
    }
    let span = if high > low { high - low } else { 1.0 };
    let room = (CURVE - 8) as f64;
    let y = |v: f64| top as f64 + room * (1.0 - (v - low) / span);
    let mut frame = 0;
    for run in curve.values.chunk_by(|a, b| a.is_finite() == b.is_finite()) {
        if run[0].is_finite() {
            m.raw("<polyline class=\"curve\" points=\"");
            for (k, v) in run.iter().enumerate() {
                let x = layout.x(frame + k) + layout.px_per_frame / 2.0;
                m.num(x, 1).raw(",").num(y(*v), 1).raw(" ");
            }
            m.raw("\"/>\n");
        }
        frame += run.len();
    }
    if let Some(at) = curve.threshold.filter(|t| t.is_finite()) {
        m.raw("<path class=\"threshold\" d=\"M").int(LEFT).raw(" ").num(y(at), 1).raw("H").num(right, 1);
        m.raw("\"/>\n");
    }
    for (value, y) in [(high, top + 8), (low, top + CURVE - 8)] {
        match layout.text_px {
            Some(_) => at(m, right, y).raw(" text-anchor=\"end\""),
            None => at(m, right + 12.0, y),
        };
        m.raw(" font-size=\"10\">").num(value, 2).raw("</text>\n");
    }
}

/// One stretch: high where true, low where false, hatched where unknown.
fn stretch(m: &mut Markup, (x, width): (f64, f64), y: usize, truth: Tri, layout: &Layout) {
    let (class, y, height) = match truth {
        Tri::True => ("t", y, 14_usize),
        Tri::False => ("f", y + 10, 4),
        Tri::Unknown => ("u", y, 14),
    };
    m.raw("<rect x=\"").num(x, 1).raw("\" y=\"").int(y).raw("\" width=\"").num(width, 1);
    m.raw("\" height=\"").int(height).raw("\" class=\"").raw(class);
    if truth == Tri::Unknown {
        m.raw("\" fill=\"url(#").raw(layout.hatch).raw(")");
    }
    m.raw("\"/>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(frames: u32) -> Vec<f64> {
        (0..frames).map(|f| f64::from(f) / 10.0).collect()
    }

    #[test]
    fn the_axis_shows_the_times_of_frames_also_behind_a_gap() {
        // 60 frames, then 3.2 s without any, then 40: the frame with index 50 is at 5 s, that with index 100 ends the
        // chart 3.2 s later than 10 s.
        let times_s =
            times(100).into_iter().enumerate().map(|(f, t)| if f < 60 { t } else { t + 3.2 }).collect();
        let svg = render(&TruthChart { times_s, ..TruthChart::default() });
        let labels: Vec<&str> = svg.split(" s</text>").map(|t| t.rsplit('>').next().unwrap()).collect();
        assert_eq!(labels[..3], ["0", "5", "13.2"], "{svg}");
    }

    #[test]
    fn equal_cells_are_one_stretch_and_texts_are_escaped() {
        let cells = [Some(Tri::True); 3].into_iter().chain([None, Some(Tri::False)]).collect();
        let rows =
            vec![TruthRow { text: "a < b".into(), indent: 0, truth: Tri::Unknown, cells, curve: None }];
        let words = ["true", "false", "unknown"];
        let svg = render(&TruthChart {
            title: "x & y\nsecond line".into(),
            times_s: times(5),
            rows,
            moment: Some(2),
            truth_words: words,
            note: "",
        });
        assert!(
            svg.contains("<title>x &amp; y</title>") && svg.contains("class=\"unknown\">a &lt; b</text>")
        );
        // Three true frames from 16 px on, one without a cell, one false.
        assert!(svg.contains("<rect x=\"16\" y=\"68\" width=\"9\" height=\"14\" class=\"t\"/>"), "{svg}");
        assert!(svg.contains("<rect x=\"28\" y=\"78\" width=\"3\" height=\"4\" class=\"f\"/>"), "{svg}");
        assert!(svg.contains("<path d=\"M22 66V88\" class=\"moment\"/>"), "{svg}");
    }

    #[test]
    fn on_a_phone_every_text_is_above_its_bar_and_within_the_width() {
        let text = "lateral distance of the nearest corner of the target to the ego's lane < 0.5 m [1.25 m]";
        let zh =
            "目标最近的角点到自车车道的横向距离小于零点五米，并且目标没有完全位于自车车道之内，两者同时成立";
        let row = |text: &str| TruthRow {
            text: text.into(),
            indent: 36,
            truth: Tri::True,
            cells: vec![Some(Tri::Unknown); 201],
            curve: None,
        };
        let svg = render_narrow(&TruthChart {
            times_s: times(201),
            rows: vec![row(text), row(zh)],
            ..TruthChart::default()
        });
        assert!(svg.contains("width=\"340\""), "{svg}");
        let (mut shown, mut last_text, mut bars) = (String::new(), 0.0, 0);
        for tag in svg.split('<') {
            let number = |name: &str| -> f64 {
                tag.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            };
            if tag.starts_with("text") && tag.contains("class=") {
                let words = tag.split('>').nth(1).unwrap().replace("&lt;", "<").replace("&#39;", "'");
                // At most 7 px for a Latin letter and 13 px for a Chinese one, as the constants say.
                let px: f64 = words.chars().map(|c| if c.is_ascii() { 7.0 } else { 13.0 }).sum();
                assert!(number("x") + px <= 340.0, "{words}");
                shown.push_str(&words);
                last_text = number("y");
            } else if tag.starts_with("rect") && tag.contains("class=\"u\"") && number("width") > 24.0 {
                assert!(number("y") > last_text && number("x") + number("width") <= 340.0, "{tag}");
                bars += 1;
            }
        }
        assert_eq!(bars, 2);
        let letters = |text: &str| text.replace(' ', "");
        assert_eq!(letters(&shown), letters(&format!("{text}{zh}")), "nothing is cut");
        assert!(svg.contains("url(#hatch-narrow)") && !svg.contains("url(#hatch)"));
    }

    #[test]
    fn a_curve_has_its_threshold_and_breaks_where_nothing_is_known() {
        let curve = Curve { values: vec![0.0, 10.0, f64::NAN, 5.0], threshold: Some(5.0) };
        let cells = vec![Some(Tri::True); 4];
        let row = TruthRow { text: "x".into(), indent: 0, truth: Tri::True, cells, curve: Some(curve) };
        let svg = render(&TruthChart { times_s: times(4), rows: vec![row], ..TruthChart::default() });
        // 38 px from 10 at y = 52 down to 0 at y = 90, the threshold half way.
        assert!(svg.contains("points=\"17.5,90 20.5,52 \""), "{svg}");
        assert!(svg.contains("points=\"26.5,71 \"") && svg.contains("d=\"M16 71H28\""), "{svg}");
    }
}
