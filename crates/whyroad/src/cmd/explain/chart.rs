//! An explanation as rows of a chart over time: the whole rule, each of its parts, and the members of each part.

use super::Shown;
use super::text::{Line, lines, mark, verdict, whole};
use whyroad_mining::explain::{Cell, ConditionCourse, Course};
use whyroad_model::Lang;
use whyroad_render::truths::{Curve, TruthChart, TruthRow};

/// Indentation of the members of a condition, px.
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
        times_s: shown.times_s.to_vec(),
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
    out.extend(lines(e, lang).into_iter().map(|Line { depth, text, condition }| TruthRow {
        curve: curve(condition),
        ..row(&condition.course, &text, INDENT * depth, lang)
    }));
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
fn curve(atom: &ConditionCourse) -> Option<Curve> {
    let known = atom.values.iter().any(|v| v.is_finite());
    known.then(|| Curve { values: atom.values.clone(), threshold: atom.threshold })
}
