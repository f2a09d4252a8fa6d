//! Data for drawing cases: the relevant signals of a case over time, and the moments that it expects.

use super::file::{CaseFile, CaseKind, CaseText, Reason};
use super::table::{column, frame_of, frames};
use super::trace::{segments, time};
use crate::rule::{OTHER, Rule};
use std::collections::BTreeMap;
use whyroad_model::units::Unit;
use whyroad_model::{Bilingual, Column, FrameRange, ScenarioId, yaml};
use whyroad_signals::Catalog;

/// A case, ready to be drawn.
#[derive(Clone, Debug)]
pub struct DrawnCase {
    /// The class whose rule it is about.
    pub scenario: ScenarioId,
    /// What happens, in English.
    pub name: String,
    /// What it demonstrates.
    pub kind: CaseKind,
    /// Duration, s.
    pub seconds: f64,
    /// Signals that the case states itself, then those that change over time; constant ones of the base are left out.
    pub traces: Vec<DrawnTrace>,
    /// Episodes that must be found, in order.
    pub expect: Vec<DrawnEpisode>,
    /// Signals that the log lacks.
    pub lacks: Vec<String>,
    /// Signals for lack of which it cannot be decided.
    pub not_observable: Vec<String>,
}

/// One signal over a case.
#[derive(Clone, Debug)]
pub struct DrawnTrace {
    /// As written: `target.gap`, or `obstacle.gap` of another object.
    pub name: String,
    /// Unit of the catalog; none for flags, categories and pure numbers.
    pub unit: Option<&'static Unit>,
    /// 10 Hz from the start of the case, numbers in base units.
    pub column: Column,
    /// The frames in which its object is observed; all frames for signals of the ego and the road.
    pub seen: FrameRange,
}

/// An expected episode, s from the start of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnEpisode {
    /// The decision moment.
    pub keyframe: f64,
    /// Start of the time range, where the case states it.
    pub start: Option<f64>,
    /// End of the time range, where the case states it.
    pub end: Option<f64>,
    /// Second keyframe of classes that have two.
    pub second_keyframe: Option<f64>,
}

/// The cases of a `<l2>.cases.yaml`, in order, with the signals that `rules` read. The error is the first case that
/// cannot be read.
pub fn drawn(text: &str, rules: &[Rule], catalog: &Catalog) -> Result<Vec<DrawnCase>, Reason> {
    let file: CaseFile<CaseText> = yaml::from_str(text).map_err(|e| {
        Bilingual::new(format!("用例无法读取：{e}"), format!("the cases cannot be read: {e}"))
    })?;
    let l1 = file.l1.clone().unwrap_or_else(|| OTHER.to_owned());
    let mut out = Vec::new();
    for case in &file.cases {
        let scenario = ScenarioId { l1: l1.clone(), l2: file.l2.clone(), l3: case.leaf.clone() };
        if let Some(rule) = rules.iter().find(|r| r.scenario == scenario) {
            out.push(draw(case, &file.base, scenario, rule, catalog)?);
        }
    }
    Ok(out)
}

fn draw(
    case: &CaseText,
    base: &BTreeMap<String, String>,
    scenario: ScenarioId,
    rule: &Rule,
    catalog: &Catalog,
) -> Result<DrawnCase, Reason> {
    let n = frame_of(time(&case.duration)?);
    let read = rule.signals();
    let mut stated = Vec::new();
    let mut changing = Vec::new();
    let own = case.signals.iter().map(|x| (x, true));
    let inherited = base.iter().filter(|(name, _)| !case.signals.contains_key(*name)).map(|x| (x, false));
    for ((name, text), is_own) in own.chain(inherited) {
        let (object, signal) = match name.split_once('.') {
            Some((object, rest)) if case.objects.contains_key(object) => {
                (Some(object), format!("target.{rest}"))
            }
            _ => (None, name.clone()),
        };
        let Some(def) = catalog.get(&signal) else { continue };
        if !read.contains(&def.name) || case.lacks.contains(&signal) {
            continue;
        }
        let of_object = def.name.starts_with("target.");
        let seen = match object {
            Some(name) => frames(case.objects.get(name).and_then(|o| o.seen.as_ref()), n)?,
            None if of_object => frames(case.seen.as_ref(), n)?,
            None => FrameRange::new(0, n),
        };
        let parts = segments(text)?;
        let constant = parts.len() == 1 && !text.contains(" to ");
        let trace =
            DrawnTrace { name: name.clone(), unit: def.unit, column: column(&parts, &def.kind, n)?, seen };
        if is_own {
            stated.push(trace);
        } else if !constant {
            changing.push(trace);
        }
    }
    stated.extend(changing);
    let seconds = |text: &String| Ok::<f64, Reason>(time(text)?.as_secs_f64());
    let expect = case.expect.iter().map(|x| {
        Ok::<DrawnEpisode, Reason>(DrawnEpisode {
            keyframe: seconds(&x.keyframe)?,
            start: x.start.as_ref().map(seconds).transpose()?,
            end: x.end.as_ref().map(seconds).transpose()?,
            second_keyframe: x.second_keyframe.as_ref().map(seconds).transpose()?,
        })
    });
    Ok(DrawnCase {
        scenario,
        name: case.name.clone(),
        kind: case.kind,
        seconds: time(&case.duration)?.as_secs_f64(),
        traces: stated,
        expect: expect.collect::<Result<_, _>>()?,
        lacks: case.lacks.clone(),
        not_observable: case.not_observable.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rule::RuleSet;
    use whyroad_framework::Framework;

    #[test]
    fn every_leaf_with_a_rule_has_cases_to_draw() {
        let catalog = Catalog::bundled();
        let rules = RuleSet::of_framework(Framework::bundled(), catalog).0.rules;
        let files = Framework::bundled_files();
        let texts = files.iter().filter(|(name, _)| name.ends_with(".cases.yaml"));
        let cases: Vec<DrawnCase> =
            texts.flat_map(|(_, text)| drawn(text, &rules, catalog).unwrap()).collect();
        for rule in rules.iter().filter(|r| r.scenario.l3.is_some()) {
            let of_rule: Vec<_> = cases.iter().filter(|c| c.scenario == rule.scenario).collect();
            assert!(
                of_rule.iter().any(|c| c.kind == CaseKind::Positive && !c.expect.is_empty()),
                "{}",
                rule.scenario
            );
            assert!(of_rule.iter().all(|c| c.seconds > 0.0), "{}", rule.scenario);
        }
        // From cutin.cases.yaml, the first case of urgent: keyframe at 5 s in 3 to 6.5 s, the wheel over the line from
        // 5 s on.
        let urgent =
            cases.iter().find(|c| c.name == "a car comes in close and the ego closes on it").unwrap();
        let expected =
            DrawnEpisode { keyframe: 5.0, start: Some(3.0), end: Some(6.5), second_keyframe: None };
        assert_eq!((urgent.seconds, urgent.expect.as_slice()), (12.0, [expected].as_slice()));
        let wheel = urgent.traces.iter().find(|t| t.name == "target.wheel_over_line").unwrap();
        assert_eq!(
            (wheel.column.flag(49), wheel.column.flag(50)),
            (whyroad_model::Tri::False, whyroad_model::Tri::True)
        );
        // Constant in the base, so left out.
        assert!(urgent.traces.iter().all(|t| t.name != "target.speed"));
    }
}
