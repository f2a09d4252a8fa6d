//! Which classes a stretch of a drive comes nearest to: those of which most conditions hold together at some moment of
//! it. For moments that no class explains.

use super::{Outcome, Reached, candidates, reach};
use crate::episode::build::{locate, measured, truth_at};
use crate::interpret::{Evaluator, Pass, Roles, Series};
use crate::language::program::{Atom, NodeId, Op, truth_in_words};
use crate::rule::{PartPlace, Rule};
use serde_json::Value;
use whyroad_model::{Bilingual, FrameRange, Nanos, ScenarioId, SignalTable, TrackId, Tri};

/// A class, and its unmet conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct NearClass {
    /// The class.
    pub scenario: ScenarioId,
    /// How far its rule was met.
    pub outcome: Outcome,
    /// Conditions that hold at the moment.
    pub held: usize,
    /// All conditions of the rule: what must hold together, how long, and what is required at the keyframe.
    pub conditions: usize,
    /// The target for which most of them hold.
    pub target: Option<TrackId>,
    /// Frame of the drive.
    pub frame: usize,
    /// Conditions that do not hold or are unknown, among those that must hold together and those reached at the
    /// keyframe.
    pub unmet: Vec<UnmetCondition>,
    /// Share of the conditions that hold, each by how rarely it does.
    nearness: f64,
    margin: f64,
}

/// A condition that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct UnmetCondition {
    /// As written, names replaced by their definitions.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// The measured value, in `unit`; null where nothing is measured, or it is unknown.
    pub actual: Value,
    /// The same as text, with its unit.
    pub actual_words: Option<Bilingual>,
    /// Symbol of the unit.
    pub unit: &'static str,
}

/// The classes of `rules` by the share of their conditions that hold in `range`, most first, then by how nearly the
/// rest is met; at most `limit`. Classes without a possible target, or that cannot be decided, are left out.
pub fn nearest(rules: &[Rule], table: &SignalTable, range: FrameRange, limit: usize) -> Vec<NearClass> {
    let mut all: Vec<NearClass> = rules.iter().filter_map(|rule| one(rule, table, range)).collect();
    all.sort_by(|a, b| {
        let by_nearness = b.nearness.total_cmp(&a.nearness).then(b.margin.total_cmp(&a.margin));
        by_nearness.then_with(|| a.scenario.cmp(&b.scenario))
    });
    all.truncate(limit);
    all
}

fn one(rule: &Rule, table: &SignalTable, range: FrameRange) -> Option<NearClass> {
    let mut evaluator = Evaluator::new(&rule.program, table);
    let mut best: Option<(Reached, Roles<'_>)> = None;
    for roles in candidates(rule, table, range, None) {
        let reached = reach(rule, roles, range, &mut evaluator);
        if best.as_ref().is_none_or(|(b, _)| reached.beats(b)) {
            best = Some((reached, roles));
        }
    }
    let (reached, roles) = best?;
    let row = reached.row?;
    let mut pass = evaluator.pass_of(roles);
    let mut at_keyframe = false;
    if let Some(located) = reached.matched.and_then(|m| locate(rule, m, &mut evaluator, &mut pass)) {
        pass = located.at;
        at_keyframe = true;
    }
    let (mut held, mut unmet) = (0, Vec::new());
    let (mut said, mut all) = (0.0, 0.0);
    for part in &rule.parts {
        if part.place == PartPlace::Require && !at_keyframe {
            continue;
        }
        let rarity = rarity(evaluator.series(part.condition, &mut pass).as_ref());
        all += rarity;
        if truth_at(part.condition, row, &mut evaluator, &mut pass).0 == Tri::True {
            held += 1;
            said += rarity;
            continue;
        }
        let lacking = lacking(rule, part.condition, row, &mut evaluator, &mut pass);
        let of_part = |id: &NodeId| part.atoms.iter().find(|a| a.condition == *id);
        // The failing parts of a composite condition; the whole condition where these have no text.
        let failing = lacking.iter().map(of_part).collect::<Option<Vec<&Atom>>>();
        if let Some(failing) = failing.filter(|_| lacking != [part.condition]) {
            for atom in failing {
                let (text, words) = (atom.text.clone(), atom.words.clone());
                let actual = measured(atom, row, &mut evaluator, &mut pass);
                let (actual_words, unit) = (atom.value_in_words(&actual), atom.unit.symbol);
                unmet.push(UnmetCondition { text, words, actual, actual_words, unit });
            }
            continue;
        }
        let mut failing = part
            .atoms
            .iter()
            .filter(|atom| truth_at(atom.condition, row, &mut evaluator, &mut pass).0 != Tri::True);
        let atom = failing.next().or(part.atoms.first());
        let actual = atom.map_or(Value::Null, |a| measured(a, row, &mut evaluator, &mut pass));
        let unit = atom.map_or("", |a| a.unit.symbol);
        let actual_words = atom.and_then(|a| a.value_in_words(&actual));
        let (text, words) = (part.text.clone(), part.words.clone());
        unmet.push(UnmetCondition { text, words, actual, actual_words, unit });
    }
    // How long it must hold is a condition, too.
    let lasts = usize::from(rule.min_duration > Nanos::default());
    held += if at_keyframe { lasts } else { 0 };
    if reached.outcome == Outcome::WrongDuration {
        let seconds = rule.min_duration.0 as f64 / 1e9;
        unmet.push(UnmetCondition {
            text: format!("for {seconds} s"),
            words: Bilingual::new(format!("持续 {seconds} s"), format!("For {seconds} s")),
            actual: Value::Bool(false),
            actual_words: Some(truth_in_words(false)),
            unit: "",
        });
    }
    Some(NearClass {
        scenario: rule.scenario.clone(),
        outcome: reached.outcome,
        held,
        conditions: rule.parts.len() + lasts,
        target: roles.target.map(|t| t.id.clone()),
        frame: evaluator.rows(&pass)[row].frame?,
        unmet,
        nearness: if all > 0.0 { said / all } else { 0.0 },
        margin: reached.margin,
    })
}

/// The parts because of which a condition fails at `row`: the failing members of a conjunction, also of one with a
/// duration; for a disjunction, those of the alternative with the fewest. If alternatives have equally many, the
/// disjunction itself; otherwise the condition itself.
fn lacking<'a>(
    rule: &'a Rule,
    id: NodeId,
    row: usize,
    evaluator: &mut Evaluator<'a>,
    pass: &mut Pass<'a>,
) -> Vec<NodeId> {
    if truth_at(id, row, evaluator, pass).0 == Tri::True {
        return Vec::new();
    }
    match &rule.program.node(id).op {
        Op::And(all) => all.iter().flat_map(|of| lacking(rule, *of, row, evaluator, pass)).collect(),
        // If it holds at the moment, but not long enough, the condition itself.
        Op::For(of, _) | Op::Bridge(of, _) => match lacking(rule, *of, row, evaluator, pass) {
            none if none.is_empty() => vec![id],
            some => some,
        },
        Op::Or(all) => {
            let mut each: Vec<_> = all.iter().map(|of| lacking(rule, *of, row, evaluator, pass)).collect();
            each.sort_by_key(Vec::len);
            match &each[..] {
                [first, second, ..] if first.len() == second.len() => vec![id],
                _ => each.swap_remove(0),
            }
        }
        _ => vec![id],
    }
}

/// Information of a condition that holds, in bits: zero where it holds in every row, largest where it never does (its
/// share by the rule of succession).
fn rarity(condition: &Series) -> f64 {
    let Series::Truths(truths) = condition else { return 0.0 };
    let held = truths.value.iter().filter(|t| **t == Tri::True).count() as f64;
    ((truths.value.len() as f64 + 2.0) / (held + 1.0)).log2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rule::text::compile_text;
    use whyroad_model::{Column, Nanos};
    use whyroad_signals::Catalog;

    fn rule(class: &str, text: &str) -> Rule {
        compile_text(text, None, &class.parse().unwrap(), Catalog::bundled(), "t").unwrap()
    }

    #[test]
    fn the_class_with_most_conditions_comes_first() {
        let n = 10;
        let speed: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let mut table =
            SignalTable { times: (0..n).map(|i| Nanos(i * 100_000_000)).collect(), ..SignalTable::default() };
        table.frame_columns.insert("ego.speed".into(), Column::Number(speed));
        table.frame_columns.insert("ego.accel".into(), Column::Number(vec![0.0; 10]));
        let rules = [
            rule("a.b.half", "ego.speed > 5 m/s and ego.accel > 1 m/s2"),
            rule("a.b.most", "ego.speed > 5 m/s and ego.accel > -1 m/s2 and ego.speed > 10 m/s"),
            rule("a.b.none", "ego.accel > 2 m/s2"),
        ];
        let found = nearest(&rules, &table, FrameRange::new(2, 10), 2);
        let names: Vec<String> = found.iter().map(|f| f.scenario.to_string()).collect();
        assert_eq!(names, ["a.b.most", "a.b.half"]);
        assert_eq!((found[0].held, found[0].conditions, found[0].frame), (2, 3, 9));
        assert_eq!(found[0].unmet[0].text, "ego.speed > 10m/s");
        assert_eq!(found[0].unmet[0].actual, serde_json::json!(9.0));
        // A condition that always holds has no weight: two of the three conditions that hold are always met.
        let rules = [
            rule("a.b.always", "ego.accel > -1 m/s2 and ego.accel < 1 m/s2 and ego.speed > 30 m/s"),
            rule("a.b.rare", "ego.speed > 7 m/s and ego.accel > 1 m/s2"),
        ];
        let found = nearest(&rules, &table, FrameRange::new(2, 10), 2);
        assert_eq!(found[0].scenario.to_string(), "a.b.rare", "{found:?}");
    }

    #[test]
    fn of_a_condition_made_of_others_the_one_that_fails_is_named() {
        let n = 10;
        let mut table =
            SignalTable { times: (0..n).map(|i| Nanos(i * 100_000_000)).collect(), ..SignalTable::default() };
        for (name, value) in [("ego.speed", 7.0), ("ego.accel", 0.0), ("ego.yaw_rate", 0.1)] {
            table.frame_columns.insert(name.into(), Column::Number(vec![value; 10]));
        }
        // The columns are constant: so truth is the same at all frames and known by hand.
        let unmet = |text: &str| -> Vec<String> {
            let found = nearest(&[rule("a.b.c", text)], &table, FrameRange::new(0, 10), 1);
            found[0].unmet.iter().map(|u| u.text.clone()).collect()
        };
        let and = "((ego.speed > 5 m/s and ego.accel > 1 m/s2) for 0.3 s) and ego.yaw_rate < 1 rad/s";
        assert_eq!(unmet(and), ["ego.accel > 1m/s2"]);
        // The first alternative lacks one of its two, the second both.
        let or = "ego.speed > 5 m/s and ego.accel > 1 m/s2 or ego.speed > 9 m/s and ego.accel > 2 m/s2";
        assert_eq!(unmet(or), ["ego.accel > 1m/s2"]);
        let equal = "ego.speed > 9 m/s or ego.accel > 1 m/s2";
        assert_eq!(unmet(equal), ["(ego.speed > 9m/s) or (ego.accel > 1m/s2)"]);
    }
}
