//! The signals of a rule about any object: derived for this rule alone, together with those that every drive has where
//! the rule reads them too. They are not stored.

use whyroad_lake::LakeError;
use whyroad_mining::language::Subject;
use whyroad_mining::language::program::Op;
use whyroad_mining::rule::{OnDemand, Rule};
use whyroad_model::signal::is_of_object;
use whyroad_model::{Drive, ObjectClass, SignalTable};
use whyroad_signals::{Objects, PairClasses, WithPairs, derive_objects};

/// The signals of a drive for one rule: all that every drive has (`whole`), or, for a rule that uses signals of any
/// object, those that it uses.
///
/// The ego is one of the objects unless the rule reads `target.` signals as well: those are relative to it.
pub fn signals_for(
    rule: &Rule,
    drive: impl FnOnce() -> Result<Drive, LakeError>,
    whole: impl FnOnce() -> Result<SignalTable, LakeError>,
) -> Result<SignalTable, LakeError> {
    match rule.on_demand() {
        None => whole(),
        Some(wanted) => Ok(joined(rule, &wanted, &drive()?, whole)?),
    }
}

/// Classes of the objects that the rule is about, and of those near them that it uses.
fn pair_classes(rule: &Rule) -> PairClasses {
    let counted = rule.program.nodes.iter().filter_map(|n| match n.op {
        Op::AtLeastNear { subject, .. } => Some(subject),
        _ => None,
    });
    let looked_for: Vec<Subject> = counted.chain(rule.second.iter().map(|role| role.subject)).collect();
    let of = |admits: &dyn Fn(ObjectClass) -> bool| {
        ObjectClass::ALL.iter().copied().filter(|class| admits(*class)).collect()
    };
    PairClasses {
        first: of(&|class| rule.subject.is_none_or(|s| s.admits(class))),
        second: of(&|class| looked_for.is_empty() || looked_for.iter().any(|s| s.admits(class))),
    }
}

fn joined(
    rule: &Rule,
    wanted: &OnDemand,
    drive: &Drive,
    whole: impl FnOnce() -> Result<SignalTable, LakeError>,
) -> Result<SignalTable, LakeError> {
    let of_targets = wanted.others.iter().any(|s| is_of_object(s));
    let objects = if of_targets { Objects::Tracks } else { Objects::WithEgo };
    let pairs = if wanted.pairs { WithPairs::Between(pair_classes(rule)) } else { WithPairs::No };
    let mut table = derive_objects(drive, &wanted.signals, objects, pairs);
    if wanted.others.is_empty() {
        return Ok(table);
    }
    let whole = whole()?;
    table.frame_columns = whole.frame_columns;
    table.unavailable.extend(whole.unavailable);
    table.partial = whole.partial;
    table.without_boxes.extend(whole.without_boxes);
    if of_targets {
        // Both have the tracks in the same rows.
        debug_assert_eq!(table.targets, whole.targets);
        table.target_columns.extend(whole.target_columns);
    }
    Ok(table)
}
