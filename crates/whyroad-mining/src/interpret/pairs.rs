//! Pairs of objects that are near each other: their rows, their signals, and counts over those near one object.

use super::objects::enough;
use super::pair_rows::span;
use super::temporal::Truths;
use super::{Evaluator, Pass, Roles, Row, Series, values};
use crate::language::program::{NodeId, PairSide, Subject};
use whyroad_model::signal::{TargetSpan, deviation_name, is_of_object};
use whyroad_model::{SignalTable, Tri};

impl<'a> Evaluator<'a> {
    /// A signal of the pair on the rows of the pass.
    pub(super) fn pair_signal(&self, name: &str, seen_from: PairSide, pass: &Pass<'_>) -> Series {
        let (first, second) = match seen_from {
            PairSide::First => (pass.roles.target, pass.roles.second),
            PairSide::Second => (pass.roles.second, pass.roles.target),
        };
        let rows = self.rows(pass);
        let found = first.zip(second).and_then(|(a, b)| span(self.table, a, b));
        let index = |row: &Row| {
            let (_, span) = found?;
            Some(span.first_row + row.frame?.checked_sub(span.frames.start)?)
        };
        values(found.and_then(|(pairs, _)| pairs.columns.get(name)), rows, index)
    }

    /// Standard deviations of a signal of the pair; `None` where it is exact.
    pub(super) fn noise_of_pair(&self, name: &str, seen_from: PairSide, pass: &Pass<'_>) -> Option<Vec<f64>> {
        let name = deviation_name(name);
        self.table.pairs.as_ref().filter(|p| p.columns.contains_key(&name))?;
        match self.pair_signal(&name, seen_from, pass) {
            Series::Numbers(v) => Some(v),
            _ => None,
        }
    }

    /// At least `count` of the objects that are near the pass's object at the frame meet the condition. Where the
    /// object itself is not observed, it is unknown which objects are near it.
    pub(super) fn at_least_near(
        &mut self,
        of: NodeId,
        (count, subject): (usize, Subject),
        pass: &Pass<'a>,
    ) -> Truths {
        let rows: Vec<Row> = self.rows(pass).to_vec();
        let table = self.table;
        let (Some(own), Some(pairs)) = (pass.roles.target, table.pairs.as_ref()) else {
            return Truths::unknown(rows.len());
        };
        let there = |s: &String| match is_of_object(s) {
            true => table.target_columns.contains_key(s),
            false => !s.starts_with("pair.") || pairs.columns.contains_key(s),
        };
        if !self.program.signals(of).iter().all(there) {
            return Truths::unknown(rows.len());
        }
        let mut cells: Vec<Vec<(Tri, f64)>> = vec![Vec::new(); rows.len()];
        for other in table.targets.iter().filter(|t| subject.admits(t.class)) {
            let Some((_, span)) = span(table, own, other) else { continue };
            let mut of_pair = self.pass_of(Roles { target: Some(own), second: Some(other) });
            of_pair.episode = pass.episode;
            let truths = self.conditions(of, &mut of_pair);
            let begin = self.rows(&of_pair).first().map(|r| r.time);
            let Some(from) = rows.iter().position(|r| Some(r.time) == begin) else { continue };
            for (i, cell) in truths.value.into_iter().zip(truths.margin).enumerate() {
                let near =
                    rows[from + i].frame.is_some_and(|f| pairs.near[span.first_row + f - span.frames.start]);
                if near {
                    cells[from + i].push(cell);
                }
            }
        }
        let mut out = Truths::unknown(rows.len());
        for (i, row) in rows.iter().enumerate() {
            if row.frame.is_some_and(|f| is_seen(table, own, f)) {
                (out.value[i], out.margin[i]) = enough(count, &cells[i]);
            }
        }
        out
    }
}

/// True when the object is observed in a frame that its span covers.
fn is_seen(table: &SignalTable, object: &TargetSpan, frame: usize) -> bool {
    let observed = table.target_columns.get("object.observed");
    observed.is_none_or(|c| object.row(frame).is_some_and(|row| c.flag(row) == Tri::True))
}
