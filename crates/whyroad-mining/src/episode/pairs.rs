//! Rules that bind two objects: which pairs are evaluated. A crowded drive has many pairs, and nearly all fail for the
//! target alone (it is not even the lead), which is checked first.

use crate::interpret::{Evaluator, Roles, Series, pair_rows};
use crate::language::program::{NodeId, Op, Program, ValueScope};
use crate::rule::{Rule, SecondRole};
use whyroad_model::signal::TargetSpan;
use whyroad_model::{SignalTable, Tri};

/// The objects that can take the second role beside `target`: others that are observed while it is observed.
pub(crate) fn partners<'a>(
    target: &'a TargetSpan,
    role: &SecondRole,
    table: &'a SignalTable,
) -> impl Iterator<Item = &'a TargetSpan> {
    let subject = role.subject;
    table.targets.iter().filter(move |o| {
        o.first_row != target.first_row
            && subject.admits(o.class)
            && match table.pairs {
                // A rule about pairs considers only those that come near each other.
                Some(_) => pair_rows::span(table, target, o).is_some(),
                None => !o.frames.intersect(target.frames).is_empty(),
            }
    })
}

/// The number of the target's rows when the rule's condition on the target alone (or on the drive) is false at every
/// one: no pair with this target can match, and all these rows are decided. `None` when a pair can match.
pub(super) fn hopeless<'a>(rule: &'a Rule, alone: Roles<'a>, evaluator: &mut Evaluator<'a>) -> Option<usize> {
    let mut parts = Vec::new();
    conjuncts(&rule.program, rule.when, &mut parts);
    parts.retain(|id| matches!(rule.program.node(*id).scope, ValueScope::Frame | ValueScope::Target));
    let mut pass = evaluator.pass_of(alone);
    let n = evaluator.rows(&pass).len();
    let mut open = vec![true; n];
    for id in parts {
        if let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref() {
            open.iter_mut().zip(&t.value).for_each(|(o, v)| *o &= *v != Tri::False);
        }
    }
    (!open.contains(&true)).then_some(n)
}

fn conjuncts(program: &Program, id: NodeId, out: &mut Vec<NodeId>) {
    match &program.node(id).op {
        Op::And(all) => all.iter().for_each(|a| conjuncts(program, *a, out)),
        _ => out.push(id),
    }
}
