//! Operations that look beyond the rows of their own pass: the parts of a pair, counts over all objects, and values
//! taken from an episode (its keyframe, its match).

use super::temporal::{Truths, past_extreme_rows};
use super::{Evaluator, MARGIN_LIMIT, Moments, Pass, Roles, Series};
use crate::language::program::{NodeId, Op, Subject, ValueScope};
use std::rc::Rc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::is_of_object;
use whyroad_model::{FrameRange, Tri};

impl<'a> Evaluator<'a> {
    /// A node that depends on fewer roles than the pass has, over all its own rows, cut to those of the pass.
    pub(super) fn of_fewer_roles(&mut self, id: NodeId, pass: &Pass<'a>) -> Rc<Series> {
        let Some(roles) = self.own_roles(id, pass) else {
            // No object has the role in the pass: nothing is known.
            let n = self.rows(pass).len();
            return Rc::new(Series::Numbers(vec![f64::NAN; n]));
        };
        let whole = self.over(id, roles, pass.episode);
        let (own, _) = self.window(roles);
        let (from, to) = self.window(pass.roles);
        Rc::new(whole.slice(from - own, to - own))
    }

    /// Standard deviations of a number taken from some row, such as an extreme: over the node's own rows, cut to those
    /// of the pass.
    pub(super) fn deviations_of_moment(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Option<Vec<f64>> {
        let roles = self.own_roles(id, pass)?;
        let mut own = self.pass_of(roles);
        own.episode = pass.episode;
        let n = self.rows(&own).len();
        let (of, rows): (NodeId, Vec<Option<usize>>) = match &self.program.node(id).op {
            Op::Least(a, d) => {
                let v = self.numbers(*a, &mut own);
                (*a, past_extreme_rows(&v, self.rows(&own), *d, f64::min))
            }
            Op::Greatest(a, d) => {
                let v = self.numbers(*a, &mut own);
                (*a, past_extreme_rows(&v, self.rows(&own), *d, f64::max))
            }
            Op::AtKeyframe(a) => {
                let keyframe = own.episode.map(|e| e.keyframe);
                let row = self.rows(&own).iter().position(|r| r.frame.is_some() && r.frame == keyframe);
                (*a, vec![row; n])
            }
            _ => return None,
        };
        let deviations = self.deviations(of, &mut own)?;
        let of_rows: Vec<f64> = rows.into_iter().map(|r| r.map_or(f64::NAN, |r| deviations[r])).collect();
        let ((begin, _), (from, to)) = (self.window(roles), self.window(pass.roles));
        Some(of_rows[from - begin..to - begin].to_vec())
    }

    /// The roles of the pass that a node refers to; `None` where one of them is not taken.
    fn own_roles(&self, id: NodeId, pass: &Pass<'a>) -> Option<Roles<'a>> {
        let scope = self.program.node(id).scope;
        let roles = match scope {
            ValueScope::Frame => Roles::default(),
            ValueScope::Target => Roles { second: None, ..pass.roles },
            ValueScope::Second => Roles { target: None, ..pass.roles },
            ValueScope::Pair => pass.roles,
        };
        (roles.scope() == scope).then_some(roles)
    }

    /// A node over all rows of these roles; kept where it belongs to one object and to no episode.
    pub(super) fn over(&mut self, id: NodeId, roles: Roles<'a>, episode: Option<Moments>) -> Rc<Series> {
        // Values of a pair are used once.
        let object = match roles {
            Roles { target: Some(_), second: Some(_) } => None,
            Roles { target, second } => target.or(second),
        };
        let key = object.filter(|_| !self.program.node(id).needs_episode).map(|o| (id, o.first_row));
        if let Some(done) = key.and_then(|k| self.of_object.get(&k)) {
            return done.clone();
        }
        let mut pass = self.pass_of(roles);
        pass.episode = episode;
        let computed = self.series(id, &mut pass);
        if let Some(key) = key {
            self.of_object.insert(key, computed.clone());
        }
        computed
    }

    /// At least `count` of the objects that are seen at a frame meet the condition. An object with an unknown condition
    /// may or may not meet it: unknown where such objects decide. In a gap nothing is observed, so nothing is known.
    pub(super) fn at_least(
        &mut self,
        of: NodeId,
        count: usize,
        subject: Subject,
        episode: Option<Moments>,
    ) -> Truths {
        let n = self.timeline.rows.len();
        let signals = self.program.signals(of);
        if signals.iter().filter(|s| is_of_object(s)).any(|s| !self.table.target_columns.contains_key(s)) {
            // Even the absence of objects is unknown.
            return Truths::unknown(n);
        }
        let mut seen: Vec<Vec<(Tri, f64)>> = vec![Vec::new(); n];
        let table = self.table;
        for span in table.targets.iter().filter(|t| subject.admits(t.class)) {
            let roles = Roles { target: Some(span), second: None };
            let Series::Truths(t) = self.over(of, roles, episode).as_ref().clone() else { continue };
            let (from, _) = self.window(roles);
            for (i, cell) in t.value.into_iter().zip(t.margin).enumerate() {
                seen[from + i].push(cell);
            }
        }
        let mut out = Truths::unknown(n);
        for (i, cells) in seen.iter().enumerate().filter(|(i, _)| self.timeline.rows[*i].frame.is_some()) {
            (out.value[i], out.margin[i]) = enough(count, cells);
        }
        out
    }

    /// The value at the keyframe, in every row; unknown where the keyframe is not among the rows.
    pub(super) fn at_keyframe(&mut self, of: NodeId, pass: &mut Pass<'a>) -> Series {
        let series = self.series(of, pass);
        let n = self.rows(pass).len();
        let row = pass.episode.and_then(|e| self.rows(pass).iter().position(|r| r.frame == Some(e.keyframe)));
        match series.as_ref() {
            Series::Numbers(v) => Series::Numbers(vec![row.map_or(f64::NAN, |r| v[r]); n]),
            Series::Truths(t) => {
                let (value, margin) = row.map_or((Tri::Unknown, f64::NAN), |r| (t.value[r], t.margin[r]));
                Series::Truths(Truths { value: vec![value; n], margin: vec![margin; n] })
            }
            Series::Categories(c, names) => {
                Series::Categories(vec![row.map_or(UNKNOWN_CODE, |r| c[r]); n], names.clone())
            }
        }
    }

    /// True at some row of the match; false when it is false at all of them.
    pub(super) fn in_match(&mut self, of: NodeId, pass: &mut Pass<'a>) -> Truths {
        let c = self.conditions(of, pass);
        let n = c.value.len();
        let Some((from, to)) = self.match_rows(pass) else { return Truths::unknown(n) };
        let truth = c.value[from..to].iter().fold(Tri::False, |a, b| a.or(*b));
        let margin = c.margin[from..to].iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let margin = match truth {
            Tri::True => margin.max(0.0),
            Tri::False => margin.min(0.0),
            Tri::Unknown => f64::NAN,
        };
        Truths { value: vec![truth; n], margin: vec![margin; n] }
    }

    /// Extreme of the known values in the match; NaN without any.
    pub(super) fn extreme_in_match(
        &mut self,
        of: NodeId,
        pass: &mut Pass<'a>,
        pick: fn(f64, f64) -> f64,
    ) -> Series {
        let v = self.numbers(of, pass);
        let known = |(from, to): (usize, usize)| v[from..to].iter().copied().filter(|x| !x.is_nan());
        let value = self.match_rows(pass).and_then(|rows| known(rows).reduce(pick)).unwrap_or(f64::NAN);
        Series::Numbers(vec![value; v.len()])
    }

    /// Rows of the pass from the first to the last frame of the match; `None` without an episode, and where the
    /// match is not wholly within the rows.
    fn match_rows(&self, pass: &Pass<'_>) -> Option<(usize, usize)> {
        let FrameRange { start, end } = pass.episode?.matched;
        let rows = self.rows(pass);
        let from = rows.iter().position(|r| r.frame == Some(start))?;
        let to = rows.iter().rposition(|r| r.frame.is_some_and(|f| f + 1 == end))?;
        (from <= to).then_some((from, to + 1))
    }
}

/// At least `count` of these, each with its truth and margin; unknown where unknown ones decide.
pub(super) fn enough(count: usize, cells: &[(Tri, f64)]) -> (Tri, f64) {
    let sure = cells.iter().filter(|(t, _)| *t == Tri::True).count();
    let possible = cells.iter().filter(|(t, _)| *t != Tri::False).count();
    let mut margins: Vec<f64> = cells.iter().map(|(_, m)| *m).filter(|m| !m.is_nan()).collect();
    margins.sort_by(|a, b| b.total_cmp(a));
    // The object that is needed last to reach the number; with too few objects, none is near.
    let deciding = match count.checked_sub(1) {
        None => MARGIN_LIMIT,
        Some(last) => margins.get(last).copied().unwrap_or(-MARGIN_LIMIT),
    };
    if sure >= count {
        (Tri::True, deciding.max(0.0))
    } else if possible < count {
        (Tri::False, deciding.min(0.0))
    } else {
        (Tri::Unknown, f64::NAN)
    }
}
