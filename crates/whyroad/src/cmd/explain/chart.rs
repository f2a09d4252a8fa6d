//! An explanation as rows of a chart over time: the whole rule, each of its parts, and the components of each part.

use super::Shown;
use super::text::{actual, below, mark, single, text_of, verdict, whole};
use whyroad_mining::explain::{AtomCourse, Cell, Course};
use whyroad_model::Lang;
use whyroad_render::truths::{Curve, TruthChart, TruthRow};

/// Indentation of the conditions of a part, px.
const INDENT: usize = 18;

/// Input for [`whyroad_render::truths::render`].
pub(super) fn chart(shown: &Shown<'_>, lang: Lang) -> TruthChart {
    let e = shown.explanation;
    let (truth_words, note) = match lang {
        Lang::Zh => (["成立", "不成立", "未知"], "是、否、？ 与 [实际值] 均指竖线处"),
        Lang::En => (["true", "false", "unknown"], "yes, no, ? and [values] are those at the vertical line"),
    };
    TruthChart {
        title: verdict(shown, lang),
        frames: e.when.cells.len(),
        rows: rows(shown, lang),
        moment: e.moment,
        truth_words,
        note,
    }
}

fn rows(shown: &Shown<'_>, lang: Lang) -> Vec<TruthRow> {
    let e = shown.explanation;
    if e.parts.is_empty() {
        return Vec::new();
    }
    let mut out = vec![row(&e.when, whole(lang), 0, lang)];
    for part in &e.parts {
        let text = with_value(text_of(part, lang), single(part), lang);
        out.push(TruthRow { curve: single(part).and_then(curve), ..row(&part.course, &text, 0, lang) });
        if single(part).is_none() {
            out.extend(below(part).map(|atom| {
                let text = with_value(atom.words.get(lang).to_owned(), Some(atom), lang);
                TruthRow { curve: curve(atom), ..row(&atom.course, &text, INDENT, lang) }
            }));
        }
    }
    out
}

fn row(course: &Course, text: &str, indent: usize, lang: Lang) -> TruthRow {
    let cell = |c: &Cell| match c {
        Cell::Known(truth) => Some(*truth),
        Cell::Absent => None,
    };
    TruthRow {
        text: format!("{} {text}", mark(course.truth, lang).trim()),
        indent,
        truth: course.truth,
        cells: course.cells.iter().map(cell).collect(),
        curve: None,
    }
}

/// The number that is compared; none where it is never known.
fn curve(atom: &AtomCourse) -> Option<Curve> {
    let known = atom.values.iter().any(|v| v.is_finite());
    known.then(|| Curve { values: atom.values.clone(), threshold: atom.threshold })
}

fn with_value(text: String, atom: Option<&AtomCourse>, lang: Lang) -> String {
    match atom.and_then(|a| actual(a, lang)) {
        Some(value) => format!("{text}  [{value}]"),
        None => text,
    }
}
