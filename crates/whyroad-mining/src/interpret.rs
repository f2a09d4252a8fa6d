//! The meaning of a program: the plain interpreter, row by row, one operation after another. It is the reference
//! that the fast evaluator must equal, so it is written for review by reading. Pure: signals in, truth out.
//!
//! Every condition yields, per row, a three-valued truth and a *margin*: by how many typical magnitudes
//! (`scale` in the catalog) the nearest deciding comparison is fulfilled (positive) or missed (negative).
//! That is the robustness of signal temporal logic, cut off at [`MARGIN_LIMIT`].

mod objects;
pub(crate) mod pair_rows;
mod pairs;
mod temporal;
mod timeline;

pub use crate::comparison::MARGIN_LIMIT;
pub use temporal::{CLOCK_TOLERANCE, Truths};
pub use timeline::{Row, STEP, Timeline};

use crate::comparison::compare;
use crate::deviation::{crossed, has_threshold, of_product, of_sum};
use crate::language::program::{NodeId, Op, Program, ValueScope};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::{TargetSpan, deviation_name, is_of_object};
use whyroad_model::{Column, FrameRange, SignalTable, Tri};

/// The values of a node, one per row.
#[derive(Clone, Debug)]
pub enum Series {
    /// Numbers; NaN is unknown.
    Numbers(Vec<f64>),
    /// Truth and margin.
    Truths(Truths),
    /// Codes into names.
    Categories(Vec<u16>, Arc<[String]>),
}

impl Series {
    fn slice(&self, from: usize, to: usize) -> Series {
        match self {
            Series::Numbers(v) => Series::Numbers(v[from..to].to_vec()),
            Series::Truths(t) => Series::Truths(Truths {
                value: t.value[from..to].to_vec(),
                margin: t.margin[from..to].to_vec(),
            }),
            Series::Categories(c, n) => Series::Categories(c[from..to].to_vec(), n.clone()),
        }
    }
}

/// Evaluates the nodes of one program on one drive.
pub struct Evaluator<'a> {
    program: &'a Program,
    table: &'a SignalTable,
    timeline: Timeline,
    of_drive: Vec<Option<Rc<Series>>>,
    /// Values that pairs share: values over all rows of one object, by node and the object's first row.
    of_object: BTreeMap<(NodeId, usize), Rc<Series>>,
}

/// The objects in the roles of the rule; without any, the rule is about the drive.
#[derive(Clone, Copy, Debug, Default)]
pub struct Roles<'a> {
    /// The target.
    pub target: Option<&'a TargetSpan>,
    /// The object in the second role.
    pub second: Option<&'a TargetSpan>,
}

impl Roles<'_> {
    /// Which nodes have their rows in a pass with these roles.
    fn scope(self) -> ValueScope {
        match (self.target, self.second) {
            (None, None) => ValueScope::Frame,
            (Some(_), None) => ValueScope::Target,
            (None, Some(_)) => ValueScope::Second,
            (Some(_), Some(_)) => ValueScope::Pair,
        }
    }
}

/// The known parts of the episode that is being built, in frames of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moments {
    /// The keyframe.
    pub keyframe: usize,
    /// The match.
    pub matched: FrameRange,
}

/// One evaluation: its rows, and its episode once there is one. Keeps what it has computed.
pub struct Pass<'a> {
    roles: Roles<'a>,
    episode: Option<Moments>,
    done: Vec<Option<Rc<Series>>>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator that has computed nothing yet.
    pub fn new(program: &'a Program, table: &'a SignalTable) -> Self {
        let of_drive = vec![None; program.nodes.len()];
        let of_object = BTreeMap::new();
        Self { program, table, timeline: Timeline::new(&table.times), of_drive, of_object }
    }

    /// A pass over the rows of `target`, or of the whole drive without one.
    pub fn pass(&self, target: Option<&'a TargetSpan>) -> Pass<'a> {
        self.pass_of(Roles { target, second: None })
    }

    /// A pass over the rows in which all objects with a role are observed.
    pub fn pass_of(&self, roles: Roles<'a>) -> Pass<'a> {
        Pass { roles, episode: None, done: vec![None; self.program.nodes.len()] }
    }

    /// The same rows for one of their episodes.
    pub fn at_episode(&self, pass: &Pass<'a>, episode: Moments) -> Pass<'a> {
        let keep = |i: usize| pass.done[i].clone().filter(|_| !self.program.nodes[i].needs_episode);
        let done = (0..self.program.nodes.len()).map(keep).collect();
        Pass { roles: pass.roles, episode: Some(episode), done }
    }

    /// The rows of a pass.
    pub fn rows(&self, pass: &Pass<'_>) -> &[Row] {
        let (from, to) = self.window(pass.roles);
        &self.timeline.rows[from..to]
    }

    fn window(&self, roles: Roles<'_>) -> (usize, usize) {
        match (roles.target, roles.second) {
            (Some(a), Some(b)) => self.timeline.window(pair_rows::frames(self.table, a, b)),
            (Some(one), None) | (None, Some(one)) => self.timeline.window(one.frames),
            (None, None) => (0, self.timeline.rows.len()),
        }
    }

    /// The values of a node on the rows of the pass.
    pub fn series(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Rc<Series> {
        if let Some(done) = &pass.done[id.0] {
            return done.clone();
        }
        let node = self.program.node(id);
        let result = if node.scope != pass.roles.scope() {
            // A node that does not depend on the target is evaluated over the whole drive, not only over the rows in
            // which the target is observed; a node that depends on one object of a pair, over all rows of that object.
            self.of_fewer_roles(id, pass)
        } else if node.scope == ValueScope::Frame && !node.needs_episode {
            match self.of_drive[id.0].clone() {
                Some(done) => done,
                None => {
                    let computed = Rc::new(self.compute(id, pass));
                    self.of_drive[id.0] = Some(computed.clone());
                    computed
                }
            }
        } else {
            Rc::new(self.compute(id, pass))
        };
        pass.done[id.0] = Some(result.clone());
        result
    }

    fn numbers(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Vec<f64> {
        match self.series(id, pass).as_ref() {
            Series::Numbers(v) => v.clone(),
            _ => vec![f64::NAN; self.rows(pass).len()],
        }
    }

    fn conditions(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Truths {
        match self.series(id, pass).as_ref() {
            Series::Truths(t) => t.clone(),
            _ => Truths::unknown(self.rows(pass).len()),
        }
    }

    fn compute(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Series {
        let program = self.program;
        let n = self.rows(pass).len();
        match &program.node(id).op {
            Op::Constant(x) => Series::Numbers(vec![*x; n]),
            Op::Truth(b) => Series::Truths(Truths::of_flags(vec![Tri::from(*b); n])),
            Op::Signal(name) => self.signal(name, pass.roles.target, pass),
            Op::SecondSignal(name) => self.signal(name, pass.roles.second, pass),
            Op::PairSignal { name, seen_from } => self.pair_signal(name, *seen_from, pass),
            Op::Negate(a) => Series::Numbers(self.numbers(*a, pass).into_iter().map(|x| -x).collect()),
            Op::Absolute(a) => Series::Numbers(self.numbers(*a, pass).into_iter().map(f64::abs).collect()),
            Op::Add(a, b) => self.zip(*a, *b, pass, |x, y| x + y),
            Op::Subtract(a, b) => self.zip(*a, *b, pass, |x, y| x - y),
            Op::Multiply(a, b) => self.zip(*a, *b, pass, |x, y| x * y),
            Op::Least(a, d) => {
                let v = self.numbers(*a, pass);
                Series::Numbers(temporal::past_extreme(&v, self.rows(pass), *d, f64::min))
            }
            Op::Greatest(a, d) => {
                let v = self.numbers(*a, pass);
                Series::Numbers(temporal::past_extreme(&v, self.rows(pass), *d, f64::max))
            }
            Op::Share(c, d) => {
                let c = self.conditions(*c, pass);
                Series::Numbers(temporal::past_share(&c, self.rows(pass), *d))
            }
            Op::Compare { op, left, right, scale } => {
                let (a, b) = (self.numbers(*left, pass), self.numbers(*right, pass));
                let (value, margin): (Vec<Tri>, Vec<f64>) =
                    a.iter().zip(&b).map(|(a, b)| compare(*op, *a, *b, *scale)).unzip();
                Series::Truths(match self.deviations_of_both(*left, *right, pass) {
                    Some(noise) if has_threshold(*op) => {
                        let value = crossed(*op, &a, &b, &noise);
                        // A margin never contradicts the truth.
                        let agreeing = value.iter().zip(margin).map(|(t, m)| match t {
                            Tri::True => m.max(0.0),
                            Tri::False => m.min(0.0),
                            Tri::Unknown => f64::NAN,
                        });
                        Truths { margin: agreeing.collect(), value }
                    }
                    _ => Truths { value, margin },
                })
            }
            Op::Member(a, words) => match self.series(*a, pass).as_ref() {
                Series::Categories(codes, names) => {
                    let within = |code: &u16| match names.get(usize::from(*code)) {
                        Some(name) => Tri::from(words.contains(name)),
                        None => Tri::Unknown,
                    };
                    Series::Truths(Truths::of_flags(codes.iter().map(within).collect()))
                }
                _ => Series::Truths(Truths::unknown(n)),
            },
            Op::Known(a) => {
                let known: Vec<bool> = match self.series(*a, pass).as_ref() {
                    Series::Numbers(v) => v.iter().map(|x| !x.is_nan()).collect(),
                    Series::Truths(t) => t.value.iter().map(|t| *t != Tri::Unknown).collect(),
                    Series::Categories(c, _) => c.iter().map(|c| *c != UNKNOWN_CODE).collect(),
                };
                Series::Truths(Truths::of_flags(known.into_iter().map(Tri::from).collect()))
            }
            Op::Not(a) => Series::Truths(self.conditions(*a, pass).negated()),
            Op::And(all) => {
                let all: Vec<Truths> = all.iter().map(|a| self.conditions(*a, pass)).collect();
                Series::Truths(Truths::all(&all, n))
            }
            Op::Or(all) => {
                let all: Vec<Truths> = all.iter().map(|a| self.conditions(*a, pass).negated()).collect();
                Series::Truths(Truths::all(&all, n).negated())
            }
            Op::For(a, d) => {
                let c = self.conditions(*a, pass);
                Series::Truths(temporal::held_for(&c, self.rows(pass), *d))
            }
            Op::Within(a, d) => {
                let c = self.conditions(*a, pass);
                Series::Truths(temporal::within(&c, self.rows(pass), *d))
            }
            Op::Previously(a, d) => {
                let c = self.conditions(*a, pass);
                Series::Truths(temporal::previously(&c, self.rows(pass), *d))
            }
            Op::Since(a, b) => {
                let (a, b) = (self.conditions(*a, pass), self.conditions(*b, pass));
                Series::Truths(temporal::since(&a, &b))
            }
            Op::Until(a, b) => {
                let (a, b) = (self.conditions(*a, pass), self.conditions(*b, pass));
                Series::Truths(temporal::until(&a, &b))
            }
            Op::Bridge(a, d) => {
                let c = self.conditions(*a, pass);
                Series::Truths(temporal::bridged(&c, self.rows(pass), *d))
            }
            Op::AtLeast { of, count, subject } => {
                Series::Truths(self.at_least(*of, *count, *subject, pass.episode))
            }
            Op::AtLeastNear { of, count, subject } => {
                Series::Truths(self.at_least_near(*of, (*count, *subject), pass))
            }
            Op::Before(a) => Series::Truths(self.conditions(*a, pass).shifted()),
            Op::AtKeyframe(a) => self.at_keyframe(*a, pass),
            Op::InMatch(a) => Series::Truths(self.in_match(*a, pass)),
            Op::MatchLeast(a) => self.extreme_in_match(*a, pass, f64::min),
            Op::MatchGreatest(a) => self.extreme_in_match(*a, pass, f64::max),
        }
    }

    /// Standard deviations of the difference of two numbers; `None` where both are exact.
    fn deviations_of_both(&mut self, a: NodeId, b: NodeId, pass: &mut Pass<'a>) -> Option<Vec<f64>> {
        let both = (self.deviations(a, pass), self.deviations(b, pass));
        combined(both, of_sum)
    }

    /// Standard deviations of a number on the rows of the pass; `None` where it is exact. An extreme over a window has
    /// that of the row that has it, a value at the keyframe that of the keyframe; shares of time and extremes of a
    /// match count as exact.
    fn deviations(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Option<Vec<f64>> {
        match &self.program.node(id).op {
            Op::Signal(name) => self.noise_of(name, pass.roles.target, pass),
            Op::SecondSignal(name) => self.noise_of(name, pass.roles.second, pass),
            Op::PairSignal { name, seen_from } => self.noise_of_pair(name, *seen_from, pass),
            Op::Least(..) | Op::Greatest(..) | Op::AtKeyframe(_) => self.deviations_of_moment(id, pass),
            Op::Negate(a) | Op::Absolute(a) => self.deviations(*a, pass),
            Op::Add(a, b) | Op::Subtract(a, b) => self.deviations_of_both(*a, *b, pass),
            Op::Multiply(a, b) => {
                let both = (self.deviations(*a, pass), self.deviations(*b, pass));
                both.0.as_ref().or(both.1.as_ref())?;
                let (x, y) = (self.numbers(*a, pass), self.numbers(*b, pass));
                let of = |sd: &Option<Vec<f64>>, i: usize| sd.as_ref().map_or(0.0, |sd| sd[i]);
                Some(
                    (0..x.len())
                        .map(|i| of_product((x[i], of(&both.0, i)), (y[i], of(&both.1, i))))
                        .collect(),
                )
            }
            _ => None,
        }
    }

    fn noise_of(&self, signal: &str, of: Option<&TargetSpan>, pass: &Pass<'_>) -> Option<Vec<f64>> {
        let name = deviation_name(signal);
        if !self.table.frame_columns.contains_key(&name) && !self.table.target_columns.contains_key(&name) {
            return None;
        }
        match self.signal(&name, of, pass) {
            Series::Numbers(v) => Some(v),
            _ => None,
        }
    }

    fn zip(&mut self, a: NodeId, b: NodeId, pass: &mut Pass<'a>, f: fn(f64, f64) -> f64) -> Series {
        let (a, b) = (self.numbers(a, pass), self.numbers(b, pass));
        Series::Numbers(a.into_iter().zip(b).map(|(x, y)| f(x, y)).collect())
    }

    /// A signal on the rows of the pass; unknown in the rows of a gap and where the log lacks it.
    fn signal(&self, name: &str, of: Option<&TargetSpan>, pass: &Pass<'_>) -> Series {
        let rows = self.rows(pass);
        let (column, offset) = match of {
            Some(span) if is_of_object(name) => {
                (self.table.target_columns.get(name), Some((span.first_row, span.frames.start)))
            }
            _ => (self.table.frame_columns.get(name), None),
        };
        let index = |row: &Row| {
            row.frame.map(|f| offset.map_or(f, |(first_row, first_frame)| first_row + f - first_frame))
        };
        values(column, rows, index)
    }
}

/// A column on these rows, each of which has its value at `index` or, in a gap, none.
fn values(column: Option<&Column>, rows: &[Row], index: impl Fn(&Row) -> Option<usize>) -> Series {
    match column {
        Some(column @ Column::Number(_)) => Series::Numbers(
            rows.iter().map(|r| index(r).and_then(|i| column.number(i)).unwrap_or(f64::NAN)).collect(),
        ),
        Some(column @ Column::Flag(_)) => Series::Truths(Truths::of_flags(
            rows.iter().map(|r| index(r).map_or(Tri::Unknown, |i| column.flag(i))).collect(),
        )),
        Some(Column::Category { codes, names }) => Series::Categories(
            rows.iter()
                .map(|r| index(r).and_then(|i| codes.get(i).copied()).unwrap_or(UNKNOWN_CODE))
                .collect(),
            names.clone(),
        ),
        // The type does not matter: every reader finds only unknown values.
        None => Series::Numbers(vec![f64::NAN; rows.len()]),
    }
}

/// Deviations row by row, where one of the two is not exact.
fn combined(both: (Option<Vec<f64>>, Option<Vec<f64>>), f: impl Fn(f64, f64) -> f64) -> Option<Vec<f64>> {
    Some(match both {
        (None, None) => return None,
        (Some(one), None) | (None, Some(one)) => one.into_iter().map(|d| f(d, 0.0)).collect(),
        (Some(a), Some(b)) => a.into_iter().zip(b).map(|(a, b)| f(a, b)).collect(),
    })
}

#[cfg(test)]
mod tests;
