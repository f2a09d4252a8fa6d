//! One signal over time as a small line plot: the episode shaded, the keyframe marked, unknown left as a gap.

use crate::markup::Markup;
use std::collections::BTreeMap;
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Column, Displayed, FrameRange, SignalTable, TrackId, Tri};

const WIDTH: f64 = 430.0;
const HEIGHT: f64 = 96.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 424.0;
const TOP: f64 = 8.0;
const BOTTOM: f64 = 78.0;

/// Texts and units of a signal for a plot; from the catalog, which this crate does not read.
#[derive(Clone, Debug, Default)]
pub struct SignalInfo {
    /// Unit in which a number is displayed; `None` for flags and categories.
    pub unit: Option<&'static Unit>,
    /// Its displayed name.
    pub title: Bilingual,
    /// Its meaning.
    pub meaning: Bilingual,
    /// Typical magnitude in the base unit.
    pub scale: f64,
    /// Displayed names of the values of a category.
    pub values: BTreeMap<String, Bilingual>,
}

impl SignalInfo {
    /// The value itself where it has no name.
    fn value_name(&self, value: &str) -> Bilingual {
        self.values.get(value).cloned().unwrap_or_else(|| Bilingual::same(value))
    }
}

/// The frames that a plot shows and marks; frames of the drive.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Shown.
    pub shown: FrameRange,
    /// The episode.
    pub episode: FrameRange,
    /// The keyframe.
    pub keyframe: usize,
}

/// Caption of a signal: its displayed name, or its id where the catalog does not have it.
pub fn caption(infos: &BTreeMap<String, SignalInfo>, name: &str) -> Bilingual {
    let title = infos.get(name).map(|info| &info.title).filter(|title| !title.zh.is_empty());
    title.map_or_else(|| Bilingual::same(name), |t| Bilingual::new(t.zh.clone(), capitalized(&t.en)))
}

fn capitalized(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}

/// The plot of signal `name`, with its value at the keyframe in the caption.
pub fn render(
    infos: &BTreeMap<String, SignalInfo>,
    signals: &SignalTable,
    target: Option<&TrackId>,
    name: &str,
    span: Span,
) -> Markup {
    let mut m = Markup::new();
    let info = infos.get(name).cloned().unwrap_or_default();
    let series = Series::find(signals, target, name, info.unit);
    m.raw("<figure class=\"plot\"><figcaption title=\"")
        .text(&info.meaning.zh)
        .raw(" / ")
        .text(&info.meaning.en);
    m.raw("\">").both(&caption(infos, name)).raw(" ");
    let Some(series) = series else {
        m.raw("<span class=\"faint\">");
        match signals.unavailable.get(name) {
            Some(needs) => {
                m.say("不可观测，缺：", "not observable, needs: ");
                for (i, need) in needs.iter().enumerate() {
                    m.raw(if i == 0 { "" } else { ", " }).both(&need.name());
                }
            }
            None => {
                m.say("没有该目标的数值", "no value for this target");
            }
        }
        m.raw("</span></figcaption></figure>");
        return m;
    };
    m.raw("<b>")
        .both(&series.value_text(span.keyframe, &info))
        .raw("</b><span class=\"faint\">")
        .text(&info.unit.map(|unit| unit.of("")).unwrap_or_default());
    m.raw("</span></figcaption><svg viewBox=\"0 0 ").num(WIDTH, 0).raw(" ").num(HEIGHT, 0).raw("\">");
    frame(&mut m, signals, span);
    match series.column {
        Column::Number(_) => numbers(&mut m, &series, &info, span),
        Column::Flag(_) => flags(&mut m, &series, span),
        Column::Category { .. } => categories(&mut m, &series, &info, span),
    }
    let x = x_of(span, span.keyframe as f64);
    m.raw("<path class=\"keyframe\" d=\"M").num(x, 1).raw(" 8V78\"/></svg></figure>");
    m
}

/// A column with the row of each frame of the drive. Its numbers are read in the unit in which they are displayed.
struct Series<'a> {
    column: &'a Column,
    unit: Option<&'static Unit>,
    first_frame: usize,
    first_row: usize,
    rows: usize,
}

impl<'a> Series<'a> {
    fn find(
        signals: &'a SignalTable,
        target: Option<&TrackId>,
        name: &str,
        unit: Option<&'static Unit>,
    ) -> Option<Self> {
        if let Some(column) = signals.frame_columns.get(name) {
            return Some(Self { column, unit, first_frame: 0, first_row: 0, rows: column.len() });
        }
        let column = signals.target_columns.get(name)?;
        let span = signals.target(target?)?;
        Some(Self {
            column,
            unit,
            first_frame: span.frames.start,
            first_row: span.first_row,
            rows: span.frames.len(),
        })
    }

    fn row(&self, frame: usize) -> Option<usize> {
        let offset = frame.checked_sub(self.first_frame)?;
        (offset < self.rows).then_some(self.first_row + offset)
    }

    /// The value in the unit in which it is displayed.
    fn displayed(&self, base: f64) -> Displayed {
        Displayed::of_base(base, self.unit.unwrap_or(Dimension::Ratio.base()))
    }

    fn number(&self, frame: usize) -> Option<f64> {
        let base = self.row(frame).and_then(|r| self.column.number(r))?;
        Some(self.displayed(base).value())
    }

    fn value_text(&self, frame: usize, info: &SignalInfo) -> Bilingual {
        let text = match (self.row(frame), self.column) {
            (None, _) => None,
            (Some(row), Column::Number(_)) => {
                self.column.number(row).map(|base| Bilingual::same(self.displayed(base).number(2)))
            }
            (Some(row), Column::Flag(_)) => match self.column.flag(row) {
                Tri::True => Some(Bilingual::same("✓")),
                Tri::False => Some(Bilingual::same("✗")),
                Tri::Unknown => None,
            },
            (Some(row), Column::Category { .. }) => {
                self.column.category(row).map(|value| info.value_name(value))
            }
        };
        text.unwrap_or_else(|| Bilingual::same("–"))
    }
}

fn x_of(span: Span, frame: f64) -> f64 {
    let n = span.shown.len().max(2) as f64 - 1.0;
    LEFT + (RIGHT - LEFT) * (frame - span.shown.start as f64) / n
}

/// Shading, axis and the seconds from the keyframe.
fn frame(m: &mut Markup, signals: &SignalTable, span: Span) {
    let shade = span.episode.intersect(span.shown);
    let (x0, x1) = (x_of(span, shade.start as f64), x_of(span, (shade.end.max(shade.start + 1) - 1) as f64));
    m.raw("<rect class=\"shade\" x=\"")
        .num(x0, 1)
        .raw("\" y=\"8\" height=\"70\" width=\"")
        .num((x1 - x0).max(1.0), 1);
    m.raw("\"/><path class=\"axis\" d=\"M46 8V78H424\"/>");
    let time = |f: usize| signals.times.get(f).copied();
    let Some(zero) = time(span.keyframe) else { return };
    let last = span.shown.end.saturating_sub(1);
    let key = x_of(span, span.keyframe as f64);
    // The ends are labeled where they do not overlap the keyframe's label.
    let apart = |f: usize| (x_of(span, f as f64) - key).abs() >= 34.0;
    let ends = [(span.shown.start, "start"), (last, "end")].into_iter().filter(|(f, _)| apart(*f));
    for (frame, anchor) in ends.chain([(span.keyframe, "middle")]) {
        let Some(t) = time(frame) else { continue };
        let x = x_of(span, frame as f64);
        let seconds = t.seconds_since(zero);
        m.raw("<text class=\"tick\" text-anchor=\"")
            .text(anchor)
            .raw("\" y=\"91\" x=\"")
            .num(x, 1)
            .raw("\">");
        if seconds > 0.0 {
            m.raw("+");
        }
        m.num(seconds, 1).raw(" s</text>");
    }
}

fn numbers(m: &mut Markup, series: &Series<'_>, info: &SignalInfo, span: Span) {
    let frames = span.shown.start..span.shown.end;
    let mut finite: Vec<f64> =
        frames.clone().filter_map(|f| series.number(f)).filter(|v| v.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    let (low, high) =
        value_range(&finite, series.number(span.keyframe), series.displayed(info.scale).value());
    let y = |v: f64| BOTTOM - (BOTTOM - TOP) * (v - low) / (high - low);
    let digits = if high - low < 0.2 {
        3
    } else if high - low < 5.0 {
        2
    } else {
        1
    };
    // Without a finite value there is no axis to label.
    let ends = if finite.is_empty() { vec![] } else { vec![(high, TOP + 4.0), (low, BOTTOM)] };
    for (value, at) in ends {
        m.raw("<text class=\"tick\" text-anchor=\"end\" x=\"42\" y=\"")
            .num(at, 0)
            .raw("\">")
            .num(value, digits);
        m.raw("</text>");
    }
    if low < 0.0 && high > 0.0 {
        m.raw("<path class=\"zero\" d=\"M46 ").num(y(0.0), 1).raw("H424\"/>");
    }
    let mut d = Markup::new();
    let mut endless = Markup::new();
    let mut pen_down = false;
    for f in frames {
        let x = x_of(span, f as f64);
        match series.number(f) {
            Some(v) if v.is_finite() => {
                // Beyond the range the line leaves the plot and is cut by its edge.
                let y = y(v).clamp(-300.0, 400.0);
                d.raw(if pen_down { "L" } else { "M" }).num(x, 1).raw(" ").num(y, 1);
                pen_down = true;
            }
            Some(v) if v > 0.0 => {
                endless.raw("M").num(x - 1.5, 1).raw(" 9h3");
                pen_down = false;
            }
            _ => pen_down = false,
        }
    }
    m.raw(
        "<svg x=\"0\" y=\"7\" width=\"430\" height=\"72\" viewBox=\"0 7 430 72\"><path class=\"line\" d=\"",
    )
    .piece(&d)
    .raw("\"/></svg>");
    let endless = endless.into_string();
    if !endless.is_empty() {
        m.raw("<path class=\"endless\" d=\"").text(&endless).raw("\"><title>∞</title></path>");
    }
}

/// The range of the axis: all values, with spikes cut off so that the rest is not flat (at most three times the spread
/// of the middle 90 %), and always the value at the keyframe.
fn value_range(sorted: &[f64], at_keyframe: Option<f64>, scale: f64) -> (f64, f64) {
    let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else { return (0.0, 1.0) };
    let quantile = |q: f64| sorted[((sorted.len() - 1) as f64 * q).round() as usize];
    let (q05, q95) = (quantile(0.05), quantile(0.95));
    let spread = (q95 - q05).max(scale.abs() * 0.2).max(1e-6);
    let (mut low, mut high) = (min.max(q05 - spread), max.min(q95 + spread));
    if let Some(v) = at_keyframe.filter(|v| v.is_finite()) {
        low = low.min(v);
        high = high.max(v);
    }
    let pad = ((high - low) * 0.06).max(spread * 0.1);
    (low - pad, high + pad)
}

fn flags(m: &mut Markup, series: &Series<'_>, span: Span) {
    for (label, y) in [("✓", 26.0), ("✗", 66.0)] {
        m.raw("<text class=\"tick\" text-anchor=\"end\" x=\"40\" y=\"")
            .num(y, 0)
            .raw("\">")
            .text(label)
            .raw("</text>");
    }
    for (frames, value) in runs(span, |f| series.row(f).map(|r| series.column.flag(r)).unwrap_or_default()) {
        let (x0, x1) = run_x(span, frames);
        let (class, y, h) = match value {
            Tri::True => ("flag-true", "14", "16"),
            Tri::False => ("flag-false", "60", "4"),
            Tri::Unknown => continue,
        };
        m.raw("<rect class=\"")
            .text(class)
            .raw("\" x=\"")
            .num(x0, 1)
            .raw("\" y=\"")
            .text(y)
            .raw("\" height=\"")
            .text(h);
        m.raw("\" width=\"").num(x1 - x0, 1).raw("\"/>");
    }
}

fn categories(m: &mut Markup, series: &Series<'_>, info: &SignalInfo, span: Span) {
    let value = |f: usize| series.row(f).and_then(|r| series.column.category(r)).unwrap_or("");
    for (i, (frames, value)) in runs(span, value).into_iter().enumerate() {
        if value.is_empty() {
            continue;
        }
        let name = info.value_name(value);
        let (x0, x1) = run_x(span, frames);
        let class = if i % 2 == 0 { "category" } else { "category odd" };
        m.raw("<g class=\"").text(class).raw("\"><title>").text(&name.zh);
        if name.zh != name.en {
            m.raw(" / ").text(&name.en);
        }
        m.raw("</title><rect x=\"").num(x0, 1);
        m.raw("\" y=\"28\" height=\"30\" width=\"").num((x1 - x0).max(0.8), 1).raw("\"/>");
        for (lang, text, character) in [("zh", &name.zh, 12.0), ("en", &name.en, 6.0)] {
            if x1 - x0 <= character * text.chars().count() as f64 {
                continue;
            }
            m.raw("<text lang=\"").text(lang);
            m.raw("\" class=\"tick\" text-anchor=\"middle\" y=\"46\" x=\"")
                .num((x0 + x1) / 2.0, 1)
                .raw("\">");
            m.text(text).raw("</text>");
        }
        m.raw("</g>");
    }
}

/// Stretches of equal value.
fn runs<T: PartialEq + Copy>(span: Span, value: impl Fn(usize) -> T) -> Vec<(FrameRange, T)> {
    let mut out: Vec<(FrameRange, T)> = Vec::new();
    for f in span.shown.start..span.shown.end {
        let v = value(f);
        match out.last_mut() {
            Some((range, last)) if *last == v => range.end = f + 1,
            _ => out.push((FrameRange::new(f, f + 1), v)),
        }
    }
    out
}

fn run_x(span: Span, frames: FrameRange) -> (f64, f64) {
    let x = |f: f64| x_of(span, f).clamp(LEFT, RIGHT);
    (x(frames.start as f64 - 0.5), x(frames.end as f64 - 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_is_named_by_the_title_of_its_signal() {
        let gap =
            SignalInfo { title: Bilingual::new("净距", "gap to the target"), ..SignalInfo::default() };
        let infos = BTreeMap::from([("target.gap".to_owned(), gap)]);
        assert_eq!(caption(&infos, "target.gap"), Bilingual::new("净距", "Gap to the target"));
        assert_eq!(caption(&infos, "no.such"), Bilingual::same("no.such"));
    }

    #[test]
    fn values_of_a_category_are_shown_by_name() {
        // Names as in schema/signals.yaml.
        let names = [("go_straight", ("直行", "go straight")), ("none", ("无", "none"))];
        let values = names.map(|(id, (zh, en))| (id.to_owned(), Bilingual::new(zh, en))).into();
        let infos =
            BTreeMap::from([("ego.meta_lateral".to_owned(), SignalInfo { values, ..SignalInfo::default() })]);
        let column = Column::Category { codes: vec![0; 40], names: ["go_straight".to_owned()].into() };
        let signals = SignalTable {
            times: (0..40).map(|i| whyroad_model::Nanos(i * 100_000_000)).collect(),
            frame_columns: [("ego.meta_lateral".to_owned(), column)].into(),
            ..SignalTable::default()
        };
        let shown = FrameRange::new(0, 40);
        let span = Span { shown, episode: FrameRange::new(10, 20), keyframe: 12 };
        let plot = render(&infos, &signals, None, "ego.meta_lateral", span).into_string();
        assert!(!plot.contains("go_straight"), "{plot}");
        assert_eq!((plot.matches("直行").count(), plot.matches("go straight").count()), (3, 3), "{plot}");
    }
}
