//! Cases beside the rules (`scenarios/<l1>/<l2>.cases.yaml`): small traces of signals, and the episodes that
//! the rules must find in them. `docs/rules.md` describes the file. They are written by hand; nothing here
//! knows where signals come from.

mod table;
mod trace;

use crate::drive::mine_drive;
use crate::evaluate::STEP;
use crate::rule::RuleSet;
use serde::Deserialize;
use std::collections::BTreeMap;
use table::table;
use whyroad_model::{Bilingual, Diagnostic, Nanos, ObjectClass, Place, ScenarioId};
use whyroad_signals::Catalogue;

/// What a case shows about its rule. Every rule has at least one of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseKind {
    /// It happens.
    Positive,
    /// Something like it happens, but not this.
    Negative,
    /// On the edge of a threshold.
    Boundary,
    /// An input is not known.
    Unknown,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseFile {
    #[serde(rename = "version")]
    _version: String,
    l1: String,
    l2: String,
    /// Signals that the cases have in common.
    #[serde(default)]
    base: BTreeMap<String, String>,
    cases: Vec<CaseText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseText {
    name: String,
    /// L3, or absent for the rule of the L2.
    leaf: Option<String>,
    kind: CaseKind,
    duration: String,
    /// Class of the target.
    target: Option<ObjectClass>,
    /// When the target is seen; all the time unless said.
    seen: Option<[String; 2]>,
    /// Other objects by name: the second role of a rule, or what a count ranges over. Their signals are written
    /// `obstacle.gap`.
    #[serde(default)]
    objects: BTreeMap<String, ObjectText>,
    #[serde(default)]
    signals: BTreeMap<String, String>,
    /// Signals that the log does not have.
    #[serde(default)]
    lacks: Vec<String>,
    expect: Vec<Expectation>,
    /// Signals for lack of which the rule must say that it cannot be decided.
    #[serde(default)]
    not_observable: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectText {
    class: ObjectClass,
    seen: Option<[String; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expectation {
    keyframe: String,
    start: Option<String>,
    end: Option<String>,
    second_keyframe: Option<String>,
}

/// What was run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Cases by rule and kind.
    pub cases: BTreeMap<(ScenarioId, CaseKind), usize>,
    /// One `rule.case` a case that failed or could not be read.
    pub failures: Vec<Diagnostic>,
}

/// Runs all cases of one file against `rules`.
pub fn run_cases(file: &str, text: &str, rules: &RuleSet, catalogue: &Catalogue) -> Tally {
    let mut tally = Tally::default();
    let parsed: CaseFile = match serde_yaml_ng::from_str(text) {
        Ok(f) => f,
        Err(e) => {
            let line = e.location().map(|l| l.line());
            tally.failures.push(failure(file, line, "", &e.to_string()));
            return tally;
        }
    };
    for case in &parsed.cases {
        let scenario =
            ScenarioId { l1: parsed.l1.clone(), l2: Some(parsed.l2.clone()), l3: case.leaf.clone() };
        let line =
            text.lines().position(|l| l.trim_end().ends_with(&format!("name: {}", case.name))).map(|i| i + 1);
        if let Err(reason) = run(case, &parsed.base, &scenario, rules, catalogue) {
            tally.failures.push(failure(file, line, &case.name, &reason));
        }
        *tally.cases.entry((scenario, case.kind)).or_default() += 1;
    }
    tally
}

fn failure(file: &str, line: Option<usize>, name: &str, reason: &str) -> Diagnostic {
    let message =
        Bilingual::new(format!("用例 '{name}' 不成立：{reason}"), format!("case '{name}' fails: {reason}"));
    Diagnostic::error("rule.case", message).at(Place {
        file: Some(file.to_owned()),
        line,
        ..Place::default()
    })
}

fn run(
    case: &CaseText,
    base: &BTreeMap<String, String>,
    scenario: &ScenarioId,
    rules: &RuleSet,
    catalogue: &Catalogue,
) -> Result<(), String> {
    let rule =
        rules.rules.iter().find(|r| r.scenario == *scenario).ok_or(format!("{scenario} has no rule"))?;
    let table = table(case, base, catalogue)?;
    for signal in rule.signals() {
        let said = table.frame_columns.contains_key(&signal)
            || table.target_columns.contains_key(&signal)
            || case.lacks.contains(&signal);
        if !said && rule.subject.is_some_and(|_| case.target.is_some()) {
            return Err(format!("it says nothing of {signal}, which the rule reads"));
        }
    }
    let l2 = ScenarioId { l3: None, ..scenario.clone() };
    let found = mine_drive(&rules.clone().restricted_to(&[l2]), &table);
    let seconds = |frame: usize| frame as f64 * STEP.as_secs_f64();
    let ours: Vec<_> = found.episodes.iter().filter(|e| e.scenario == *scenario).collect();
    let told = || {
        let each = ours.iter().map(|e| {
            format!(
                "keyframe {:.1} s in {:.1} to {:.1} s",
                seconds(e.keyframe),
                seconds(e.range.start),
                seconds(e.range.end)
            )
        });
        let list: Vec<String> = each.collect();
        if list.is_empty() { "nothing".to_owned() } else { list.join("; ") }
    };
    if ours.len() != case.expect.len() {
        return Err(format!("{} expected, found {}", case.expect.len(), told()));
    }
    for (e, x) in ours.iter().zip(&case.expect) {
        let near = |wanted: &str, frame: usize| -> Result<bool, String> {
            let seconds = if frame == usize::MAX { f64::INFINITY } else { seconds(frame) };
            Ok((duration(wanted)?.as_secs_f64() - seconds).abs() < 0.051)
        };
        let mut agrees = near(&x.keyframe, e.keyframe)?;
        let second = e.second_keyframe.unwrap_or(usize::MAX);
        let moments = [(&x.start, e.range.start), (&x.end, e.range.end), (&x.second_keyframe, second)];
        for (wanted, frame) in moments {
            agrees &= wanted.as_ref().map_or(Ok(true), |w| near(w, frame))?;
        }
        if !agrees {
            return Err(format!("keyframe {} expected, found {}", x.keyframe, told()));
        }
    }
    let missing = found.missing.get(scenario).cloned().unwrap_or_default();
    if missing != case.not_observable {
        return Err(format!(
            "not observable for lack of {:?} expected, found {missing:?}",
            case.not_observable
        ));
    }
    Ok(())
}

fn duration(text: &str) -> Result<Nanos, String> {
    match trace::value(text)? {
        trace::Value::Number(seconds) => Ok(Nanos::from_secs_f64(seconds)),
        _ => Err(format!("'{text}' is not a time")),
    }
}
