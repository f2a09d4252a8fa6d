//! Conditions over time as a self-contained SVG file: one row per condition, green where it is true, gray where it is
//! false, hatched where it is unknown, and a line at one moment. Legible without color (low bars, hatching, and words),
//! on light and dark backgrounds.

use crate::markup::Markup;
use whyroad_model::Tri;

const LEFT: usize = 16;
const PX_PER_FRAME: usize = 3;
const ROW: usize = 22;
/// Height of a curve below its row.
const CURVE: usize = 46;
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
.t { fill: var(--true) } .f { fill: var(--false) } .u { fill: url(#hatch) } .hatch { stroke: var(--unknown) }
.moment { stroke: var(--moment); stroke-width: 2 }
.curve { fill: none; stroke: var(--ink); stroke-width: 1.5 } .threshold { stroke: var(--no); stroke-dasharray: 4 3 }
</style>";

/// The chart.
#[derive(Clone, Debug, Default)]
pub struct TruthChart {
    /// Above the rows, in one or more lines; the first one is the title of the document.
    pub title: String,
    /// Number of frames, at 10 Hz.
    pub frames: usize,
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

impl TruthRow {
    fn height(&self) -> usize {
        if self.curve.is_some() { ROW + CURVE } else { ROW }
    }
}

/// The SVG document.
pub fn render(chart: &TruthChart) -> String {
    let TruthChart { title, rows, .. } = chart;
    let top = 30 + 18 * title.lines().count();
    let right = LEFT + chart.frames * PX_PER_FRAME;
    let bottom = top + rows.iter().map(TruthRow::height).sum::<usize>();
    let row_ends = rows.iter().map(|r| right + 12 + r.indent + text_px(&r.text));
    let width = row_ends.chain(title.lines().map(|l| LEFT + text_px(l))).max().unwrap_or(right) + LEFT;
    let height = bottom + 54;
    let mut m = Markup::new();
    m.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"").int(width).raw("\" height=\"").int(height);
    m.raw("\" viewBox=\"0 0 ").int(width).raw(" ").int(height);
    m.raw("\" font-family=\"sans-serif\" font-size=\"13\" role=\"img\">\n<title>");
    m.text(title.lines().next().unwrap_or_default()).raw("</title>\n").raw(STYLE);
    m.raw("\n<defs><pattern id=\"hatch\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">");
    m.raw("<path d=\"M0 6L6 0\" class=\"hatch\"/></pattern></defs>\n<rect width=\"").int(width);
    m.raw("\" height=\"").int(height).raw("\" class=\"ground\"/>\n");
    for (i, line) in title.lines().enumerate() {
        at(&mut m, LEFT, 20 + 18 * i).raw(">").text(line).raw("</text>\n");
    }
    let mut y = top;
    for row in rows {
        bar(&mut m, &row.cells, y);
        if let Some(curve) = &row.curve {
            draw(&mut m, curve, y + ROW, right);
        }
        let class = match row.truth {
            Tri::True => "yes",
            Tri::False => "no",
            Tri::Unknown => "unknown",
        };
        at(&mut m, right + 12 + row.indent, y + 13).raw(" class=\"").raw(class).raw("\">");
        m.text(&row.text).raw("</text>\n");
        y += row.height();
    }
    for frame in (0..=chart.frames).step_by(FRAMES_PER_TICK) {
        let x = LEFT + frame * PX_PER_FRAME;
        m.raw("<path d=\"M").int(x).raw(" ").int(bottom).raw("v5\" class=\"tick\"/>\n");
        at(&mut m, x, bottom + 18).raw(" text-anchor=\"middle\" font-size=\"11\">").int(frame / 10);
        m.raw(" s</text>\n");
    }
    if let Some(frame) = chart.moment {
        m.raw("<path d=\"M").int(LEFT + frame * PX_PER_FRAME).raw(" ").int(top).raw("V").int(bottom);
        m.raw("\" class=\"moment\"/>\n");
    }
    legend(&mut m, height - 14, chart);
    m.raw("</svg>\n");
    m.into_string()
}

/// Begins a text; its tag is still open.
fn at(m: &mut Markup, x: usize, y: usize) -> &mut Markup {
    m.raw("<text x=\"").int(x).raw("\" y=\"").int(y).raw("\"")
}

/// Meaning of the bars and of the words before the conditions.
fn legend(m: &mut Markup, y: usize, chart: &TruthChart) {
    let mut x = LEFT;
    for (truth, word) in [Tri::True, Tri::False, Tri::Unknown].into_iter().zip(chart.truth_words) {
        stretch(m, x, 24, y - 11, truth);
        x += 30;
        at(m, x, y).raw(" font-size=\"11\">").text(word).raw("</text>\n");
        x += text_px(word) + 16;
    }
    at(m, x, y).raw(" font-size=\"11\">").text(chart.note).raw("</text>\n");
}

/// An upper bound of a text's width.
fn text_px(text: &str) -> usize {
    text.chars().map(|c| if c.is_ascii() { LETTER_PX } else { IDEOGRAPH_PX }).sum()
}

/// Stretches of equal cells.
fn bar(m: &mut Markup, cells: &[Option<Tri>], y: usize) {
    let (mut start, y) = (0, y + 2);
    for equal in cells.chunk_by(|a, b| a == b) {
        let (x, width) = (LEFT + start * PX_PER_FRAME, equal.len() * PX_PER_FRAME);
        start += equal.len();
        if let Some(truth) = equal[0] {
            stretch(m, x, width, y, truth);
        }
    }
}

/// A curve with its threshold, and the numbers at the ends of its scale.
fn draw(m: &mut Markup, curve: &Curve, top: usize, right: usize) {
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
                let x = (LEFT + (frame + k) * PX_PER_FRAME) as f64 + PX_PER_FRAME as f64 / 2.0;
                m.num(x, 1).raw(",").num(y(*v), 1).raw(" ");
            }
            m.raw("\"/>\n");
        }
        frame += run.len();
    }
    if let Some(at) = curve.threshold.filter(|t| t.is_finite()) {
        m.raw("<path class=\"threshold\" d=\"M")
            .int(LEFT)
            .raw(" ")
            .num(y(at), 1)
            .raw("H")
            .int(right)
            .raw("\"/>\n");
    }
    for (value, y) in [(high, top + 8), (low, top + CURVE - 8)] {
        at(m, right + 12, y).raw(" font-size=\"10\">").num(value, 2).raw("</text>\n");
    }
}

/// One stretch: high where true, low where false, hatched where unknown.
fn stretch(m: &mut Markup, x: usize, width: usize, y: usize, truth: Tri) {
    let (class, y, height) = match truth {
        Tri::True => ("t", y, 14_usize),
        Tri::False => ("f", y + 10, 4),
        Tri::Unknown => ("u", y, 14),
    };
    m.raw("<rect x=\"").int(x).raw("\" y=\"").int(y).raw("\" width=\"").int(width);
    m.raw("\" height=\"").int(height).raw("\" class=\"").raw(class).raw("\"/>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_cells_are_one_stretch_and_texts_are_escaped() {
        let cells = [Some(Tri::True); 3].into_iter().chain([None, Some(Tri::False)]).collect();
        let rows =
            vec![TruthRow { text: "a < b".into(), indent: 0, truth: Tri::Unknown, cells, curve: None }];
        let words = ["true", "false", "unknown"];
        let svg = render(&TruthChart {
            title: "x & y\nsecond line".into(),
            frames: 5,
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
    fn a_curve_has_its_threshold_and_breaks_where_nothing_is_known() {
        let curve = Curve { values: vec![0.0, 10.0, f64::NAN, 5.0], threshold: Some(5.0) };
        let cells = vec![Some(Tri::True); 4];
        let row = TruthRow { text: "x".into(), indent: 0, truth: Tri::True, cells, curve: Some(curve) };
        let svg = render(&TruthChart { frames: 4, rows: vec![row], ..TruthChart::default() });
        // 38 px from 10 at y = 52 down to 0 at y = 90, the threshold half way.
        assert!(svg.contains("points=\"17.5,90 20.5,52 \""), "{svg}");
        assert!(svg.contains("points=\"26.5,71 \"") && svg.contains("d=\"M16 71H28\""), "{svg}");
    }
}
