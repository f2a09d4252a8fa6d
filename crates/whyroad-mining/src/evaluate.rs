//! What a program means: the plain interpreter, row by row, one operation after another. It is the reference
//! that a faster evaluator must equal, so it is written to be checked by eye. Pure: signals in, truth out.
//!
//! Every condition yields, a row, a three-valued truth and a *margin*: by how many typical magnitudes
//! (`scale` in the catalogue) the nearest deciding comparison is fulfilled (positive) or missed (negative).
//! That is the robustness of signal temporal logic, cut off at [`MARGIN_LIMIT`].

mod temporal;
mod timeline;

pub use temporal::{CLOCK_TOLERANCE, Truths};
pub use timeline::{Row, STEP, Timeline};

use crate::language::program::{NodeId, Op, Program, Scope};
use crate::language::syntax::CompareOp;
use std::rc::Rc;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, SignalTable, Tri};

/// Margins are cut off here; flags and categories, which are true or false without degree, have it in full.
pub const MARGIN_LIMIT: f64 = 2.0;

/// The values of a node, one a row.
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
}

/// One question: for which rows, and where the keyframe is once that is known. Keeps what it has computed.
pub struct Pass<'a> {
    target: Option<&'a TargetSpan>,
    keyframe: Option<usize>,
    done: Vec<Option<Rc<Series>>>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator that has computed nothing yet.
    pub fn new(program: &'a Program, table: &'a SignalTable) -> Self {
        let of_drive = vec![None; program.nodes.len()];
        Self { program, table, timeline: Timeline::new(&table.times), of_drive }
    }

    /// A pass over the rows of `target`, or of the whole drive without one.
    pub fn pass(&self, target: Option<&'a TargetSpan>) -> Pass<'a> {
        Pass { target, keyframe: None, done: vec![None; self.program.nodes.len()] }
    }

    /// The same rows with the keyframe set at a frame of the drive.
    pub fn at_keyframe(&self, pass: &Pass<'a>, keyframe: usize) -> Pass<'a> {
        let keep = |i: usize| pass.done[i].clone().filter(|_| !self.program.nodes[i].needs_keyframe);
        let done = (0..self.program.nodes.len()).map(keep).collect();
        Pass { target: pass.target, keyframe: Some(keyframe), done }
    }

    /// The rows that a pass speaks of.
    pub fn rows(&self, pass: &Pass<'_>) -> &[Row] {
        let (from, to) = self.window(pass);
        &self.timeline.rows[from..to]
    }

    fn window(&self, pass: &Pass<'_>) -> (usize, usize) {
        match pass.target {
            Some(span) => self.timeline.window(span.frames),
            None => (0, self.timeline.rows.len()),
        }
    }

    /// Truth and margin of a condition.
    pub fn truths(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Rc<Series> {
        self.series(id, pass)
    }

    /// The values of a node on the rows of the pass.
    pub fn series(&mut self, id: NodeId, pass: &mut Pass<'a>) -> Rc<Series> {
        if let Some(done) = &pass.done[id.0] {
            return done.clone();
        }
        let node = self.program.node(id);
        let result = if node.scope == Scope::Frame && pass.target.is_some() {
            // What does not depend on the target has its meaning over the whole drive, not over the rows in
            // which the target happens to be seen.
            let whole = self.of_whole_drive(id, pass.keyframe);
            let (from, to) = self.window(pass);
            Rc::new(whole.slice(from, to))
        } else if node.scope == Scope::Frame && !node.needs_keyframe {
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

    fn of_whole_drive(&mut self, id: NodeId, keyframe: Option<usize>) -> Rc<Series> {
        let mut pass = self.pass(None);
        pass.keyframe = keyframe;
        self.series(id, &mut pass)
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
            Op::Signal(name) => self.signal(name, pass),
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
                let (value, margin) = a.iter().zip(&b).map(|(a, b)| compare(*op, *a, *b, *scale)).unzip();
                Series::Truths(Truths { value, margin })
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
            Op::Before(a) => Series::Truths(self.conditions(*a, pass).shifted()),
            Op::AtKeyframe(a) => self.at_keyframe_value(*a, pass),
        }
    }

    fn zip(&mut self, a: NodeId, b: NodeId, pass: &mut Pass<'a>, f: fn(f64, f64) -> f64) -> Series {
        let (a, b) = (self.numbers(a, pass), self.numbers(b, pass));
        Series::Numbers(a.into_iter().zip(b).map(|(x, y)| f(x, y)).collect())
    }

    fn at_keyframe_value(&mut self, of: NodeId, pass: &mut Pass<'a>) -> Series {
        let series = self.series(of, pass);
        let n = self.rows(pass).len();
        let row = pass.keyframe.and_then(|k| self.rows(pass).iter().position(|r| r.frame == Some(k)));
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

    /// A signal on the rows of the pass; unknown in the rows of a gap and where the log lacks it.
    fn signal(&self, name: &str, pass: &Pass<'_>) -> Series {
        let rows = self.rows(pass);
        let (column, offset) = match pass.target {
            Some(span) if name.starts_with("target.") => {
                (self.table.target_columns.get(name), Some((span.first_row, span.frames.start)))
            }
            _ => (self.table.frame_columns.get(name), None),
        };
        let index = |row: &Row| {
            row.frame.map(|f| offset.map_or(f, |(first_row, first_frame)| first_row + f - first_frame))
        };
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
            // The type does not matter: everything that reads it finds nothing known.
            None => Series::Numbers(vec![f64::NAN; rows.len()]),
        }
    }
}

/// Truth and margin of one comparison; unknown when a side is NaN.
fn compare(op: CompareOp, a: f64, b: f64, scale: f64) -> (Tri, f64) {
    if a.is_nan() || b.is_nan() {
        return (Tri::Unknown, f64::NAN);
    }
    let (truth, raw) = match op {
        CompareOp::Less => (a < b, b - a),
        CompareOp::LessOrEqual => (a <= b, b - a),
        CompareOp::Greater => (a > b, a - b),
        CompareOp::GreaterOrEqual => (a >= b, a - b),
        CompareOp::Equal => (a == b, if a == b { f64::INFINITY } else { -(a - b).abs() }),
        CompareOp::NotEqual => (a != b, if a == b { f64::NEG_INFINITY } else { (a - b).abs() }),
    };
    // Infinity against infinity: neither is nearer.
    let raw = if raw.is_nan() { 0.0 } else { raw };
    (Tri::from(truth), (raw / scale).clamp(-MARGIN_LIMIT, MARGIN_LIMIT))
}

#[cfg(test)]
mod tests;
