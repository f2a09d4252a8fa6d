//! A rule in one line, as given on the command line: a condition, and optionally the kind of its target. It has no
//! labeling spec: its moments are those of the match itself.

use super::source::{DEFAULT_MERGE_GAP, needs_a_match};
use super::{Listed, PartPlace, Rule, RuleParts, TARGET, Timing};
use crate::language::program::Subject;
use crate::language::{Checker, parse};
use whyroad_model::{Diagnostic, Location, Nanos, ScenarioId};
use whyroad_signals::Catalog;

/// The rule of a text. Without a `target`, one that uses `target.*` is about any object. `name` is used as a file's
/// name in diagnostics.
pub fn compile_text(
    text: &str,
    target: Option<Subject>,
    scenario: &ScenarioId,
    catalog: &Catalog,
    name: &str,
) -> Result<Rule, Box<Diagnostic>> {
    let mut checker = Checker::new(catalog);
    let mut described = RuleParts::default();
    let checked = parse::parse(text).and_then(|expr| {
        let when = checker.condition(&expr)?;
        if checker.program.node(when).needs_episode {
            return Err(needs_a_match(text));
        }
        described.add(&mut checker, &expr, PartPlace::When)?;
        Ok(when)
    });
    let place = Location { file: Some(name.to_owned()), line: Some(1), ..Location::default() };
    let when = checked.map_err(|fault| Box::new(fault.about(text, &place)))?;
    let any = checker.is_of_target(when).then_some(Subject::Any);
    Ok(Rule {
        scenario: scenario.clone(),
        subject: target.or(checker.subject).or(any),
        target_role: TARGET.to_owned(),
        second: None,
        when,
        require: vec![],
        response: None,
        atoms: described.atoms,
        parts: described.parts,
        listed: Listed::Holding,
        min_duration: Nanos::default(),
        max_duration: None,
        merge_gap: DEFAULT_MERGE_GAP,
        lengthy: checker.lengthy,
        timing: Timing::of_match(),
        program: checker.program,
    })
}
