//! Where a moment of the labeling spec lies in one episode.

use crate::interpret::{Evaluator, Pass, Row, Series};
use crate::language::program::{Moment, NodeId};
use whyroad_model::{Nanos, Tri};

/// Moments outside the match are searched within the length of one clip (LABELING.md 4).
pub(crate) const REACH: Nanos = Nanos(20_000_000_000);

/// The sought moment: it decides where a bare condition is searched. `first`, `last`, `least` and `greatest` always
/// refer to the match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    /// The keyframe: within the match.
    Keyframe,
    /// A start: at the keyframe or before, the nearest first.
    Start,
    /// An end: at the keyframe or after, the nearest first.
    End,
}

/// The known parts of the episode so far, as rows of the pass.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// First row of the match.
    pub first: usize,
    /// Last row of the match.
    pub last: usize,
    /// The keyframe's time, once it is known.
    pub keyframe: Option<Nanos>,
}

/// The moment's time, or `None` where the episode has no such moment.
pub fn resolve<'a>(
    moment: &Moment,
    sought: Sought,
    known: Known,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Option<Nanos> {
    let mut inner = |m: &Moment| resolve(m, sought, known, evaluator, pass);
    match moment {
        Moment::Keyframe => known.keyframe,
        Moment::MatchStart => Some(evaluator.rows(pass)[known.first].time),
        Moment::MatchEnd => Some(evaluator.rows(pass)[known.last].end),
        Moment::Offset(of, by) => inner(of).map(|t| t + *by),
        Moment::Earliest(all) => all.iter().map(inner).collect::<Option<Vec<_>>>()?.into_iter().min(),
        Moment::Latest(all) => all.iter().map(inner).collect::<Option<Vec<_>>>()?.into_iter().max(),
        Moment::First(c) => truth_in(*c, Sought::Keyframe, known, evaluator, pass).into_iter().next(),
        Moment::Last(c) => truth_in(*c, Sought::Keyframe, known, evaluator, pass).into_iter().next_back(),
        Moment::Nearest(c) => {
            let all = truth_in(*c, sought, known, evaluator, pass);
            if sought == Sought::Start { all.into_iter().next_back() } else { all.into_iter().next() }
        }
        Moment::Least(x) => extreme(*x, |a, b| a < b, known, evaluator, pass),
        Moment::Greatest(x) => extreme(*x, |a, b| a > b, known, evaluator, pass),
    }
}

/// Rows in which a moment is searched.
fn reach(rows: &[Row], sought: Sought, known: Known) -> std::ops::Range<usize> {
    let Some(keyframe) = known.keyframe.filter(|_| sought != Sought::Keyframe) else {
        return known.first..known.last + 1;
    };
    let (from, to) = match sought {
        Sought::Start => (keyframe - REACH, keyframe),
        _ => (keyframe, keyframe + REACH),
    };
    let start = rows.iter().position(|r| r.time >= from).unwrap_or(rows.len());
    let end = rows.iter().rposition(|r| r.time <= to).map_or(0, |i| i + 1);
    start..end.max(start)
}

/// Times at which the condition is true, in order.
fn truth_in<'a>(
    c: NodeId,
    sought: Sought,
    known: Known,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Vec<Nanos> {
    let series = evaluator.series(c, pass);
    let Series::Truths(t) = series.as_ref() else { return Vec::new() };
    let rows = evaluator.rows(pass);
    reach(rows, sought, known).filter(|&i| t.value[i] == Tri::True).map(|i| rows[i].time).collect()
}

fn extreme<'a>(
    x: NodeId,
    better: fn(f64, f64) -> bool,
    known: Known,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Option<Nanos> {
    let series = evaluator.series(x, pass);
    let Series::Numbers(v) = series.as_ref() else { return None };
    let rows = evaluator.rows(pass);
    let mut best: Option<usize> = None;
    for i in (known.first..=known.last).filter(|&i| !v[i].is_nan()) {
        if best.is_none_or(|b| better(v[i], v[b])) {
            best = Some(i);
        }
    }
    best.map(|i| rows[i].time)
}
