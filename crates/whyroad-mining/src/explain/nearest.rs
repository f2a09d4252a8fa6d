//! Which classes a stretch of a drive comes nearest to: those of which most conditions hold together at some moment of
//! it. For moments that no class explains.

use super::{Outcome, Reached, candidates, lasted, reach};
use crate::episode::build::{lacking as lacking_signals, locate, measured_in_words, truth_at};
use crate::interpret::{Evaluator, Pass, Roles, Series};
use crate::language::program::{Atom, NodeId, Op};
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
    /// Conditions that do not hold, or are unknown.
    pub failed: usize,
    /// All conditions of the rule: what must hold together, how long, and what is required at the keyframe. Without a
    /// match the last two are not reached: they are neither among those that hold nor among those that do not. A
    /// conjunction that fails counts as its failing members.
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
    /// It is unknown whether it holds.
    pub is_unknown: bool,
}

/// A class that the drive cannot show: as far as is known, its conditions hold together at some moment.
#[derive(Clone, Debug, PartialEq)]
pub struct UndecidedClass {
    /// The class.
    pub scenario: ScenarioId,
    /// The target for which they do.
    pub target: Option<TrackId>,
    /// Conditions that are known to hold.
    pub held: usize,
    /// Conditions that must hold together.
    pub conditions: usize,
    /// Signals that its rule needs and the drive lacks.
    pub missing: Vec<String>,
    nearness: f64,
}

/// The classes of `rules` that the drive cannot show, for which no condition is known to fail at some moment of
/// `range`: each would be possible with the missing signals. Those of which the rarest conditions hold come first; at
/// most `limit`, and one of each L2.
pub fn undecided(
    rules: &[Rule],
    table: &SignalTable,
    range: FrameRange,
    limit: usize,
) -> Vec<UndecidedClass> {
    let mut all: Vec<_> = rules.iter().filter_map(|rule| undecided_one(rule, table, range)).collect();
    all.sort_by(|a, b| b.nearness.total_cmp(&a.nearness).then_with(|| a.scenario.cmp(&b.scenario)));
    one_of_each_l2(&mut all, |c| &c.scenario);
    all.truncate(limit);
    all
}

fn undecided_one(rule: &Rule, table: &SignalTable, range: FrameRange) -> Option<UndecidedClass> {
    let missing = lacking_signals(rule, table);
    if missing.is_empty() {
        return None;
    }
    let mut evaluator = Evaluator::new(&rule.program, table);
    let together = || rule.parts.iter().filter(|p| p.place == PartPlace::When);
    let mut best: Option<UndecidedClass> = None;
    for roles in candidates(rule, table, range, None) {
        if is_of_another_class(rule, roles, &mut evaluator) {
            continue;
        }
        let mut pass = evaluator.pass_of(roles);
        let series = evaluator.series(rule.when, &mut pass);
        let Series::Truths(when) = series.as_ref() else { continue };
        let parts: Vec<_> = together().map(|p| evaluator.series(p.condition, &mut pass)).collect();
        let weights: Vec<f64> = parts.iter().map(|p| rarity(p.as_ref())).collect();
        let rows = evaluator.rows(&pass).iter().enumerate();
        let open = |i: usize| when.value[i] == Tri::Unknown;
        for (i, _) in rows.filter(|(i, r)| r.frame.is_some_and(|f| range.contains(f)) && open(*i)) {
            let holds = |p: &Series| matches!(p, Series::Truths(t) if t.value[i] == Tri::True);
            let held: Vec<f64> =
                parts.iter().zip(&weights).filter(|(p, _)| holds(p.as_ref())).map(|(_, w)| *w).collect();
            let nearness: f64 = held.iter().sum();
            if nearness >= LIKELY && best.as_ref().is_none_or(|b| nearness > b.nearness) {
                best = Some(UndecidedClass {
                    scenario: rule.scenario.clone(),
                    target: roles.target.map(|t| t.id.clone()),
                    held: held.len(),
                    conditions: parts.len(),
                    missing: missing.iter().cloned().collect(),
                    nearness,
                });
            }
        }
    }
    best
}

/// Keeps the first class of each L2: its variants share most conditions.
fn one_of_each_l2<T>(all: &mut Vec<T>, class: impl Fn(&T) -> &ScenarioId) {
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|c| {
        let id = class(c);
        seen.insert((id.l1.clone(), id.l2.clone()))
    });
}

/// True where a condition on the class of the target alone, which the rule requires, never holds for this one: a car
/// is not nearly an animal.
fn is_of_another_class<'a>(rule: &'a Rule, roles: Roles<'a>, evaluator: &mut Evaluator<'a>) -> bool {
    let mut pass = evaluator.pass_of(roles);
    let mut todo = vec![rule.when];
    while let Some(id) = todo.pop() {
        match &rule.program.node(id).op {
            Op::And(all) => todo.extend(all),
            Op::For(of, _) | Op::Bridge(of, _) => todo.push(*of),
            _ if rule.program.signals(id).iter().eq([TARGET_CLASS]) => {
                let series = evaluator.series(id, &mut pass);
                if matches!(series.as_ref(), Series::Truths(t) if t.value.iter().all(|v| *v == Tri::False)) {
                    return true;
                }
            }
            _ => {}
        }
    }
    false
}

/// Information of the conditions that hold, in bits, for a class to be likely: together they hold half of the time.
const LIKELY: f64 = 1.0;

/// The signal for the class of the target.
const TARGET_CLASS: &str = "target.class";

/// The classes of `rules` by the share of their conditions that hold in `range`, most first, then by how nearly the
/// rest is met; at most `limit`, and one of each L2. Classes without a possible target are left out, and those that the
/// drive cannot show ([`undecided`]).
pub fn nearest(rules: &[Rule], table: &SignalTable, range: FrameRange, limit: usize) -> Vec<NearClass> {
    let mut all: Vec<NearClass> = rules.iter().filter_map(|rule| one(rule, table, range)).collect();
    all.sort_by(|a, b| {
        let by_nearness = b.nearness.total_cmp(&a.nearness).then(b.margin.total_cmp(&a.margin));
        by_nearness.then_with(|| a.scenario.cmp(&b.scenario))
    });
    one_of_each_l2(&mut all, |c| &c.scenario);
    all.truncate(limit);
    all
}

fn one(rule: &Rule, table: &SignalTable, range: FrameRange) -> Option<NearClass> {
    if !lacking_signals(rule, table).is_empty() {
        return None;
    }
    let mut evaluator = Evaluator::new(&rule.program, table);
    let mut best: Option<(Reached, Roles<'_>)> = None;
    for roles in candidates(rule, table, range, None) {
        if is_of_another_class(rule, roles, &mut evaluator) {
            continue;
        }
        let reached = reach(rule, roles, (range, None), &mut evaluator);
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
    let (mut held, mut later, mut unmet) = (0, 0, Vec::new());
    let (mut said, mut all) = (0.0, 0.0);
    for part in &rule.parts {
        if part.place == PartPlace::Require && !at_keyframe {
            later += 1;
            continue;
        }
        let rarity = rarity(evaluator.series(part.condition, &mut pass).as_ref());
        all += rarity;
        let truth = truth_at(part.condition, row, &mut evaluator, &mut pass).0;
        if truth == Tri::True {
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
                let (actual, actual_words) = measured_in_words(atom, row, &mut evaluator, &mut pass);
                let unit = atom.unit.symbol;
                let truth = truth_at(atom.condition, row, &mut evaluator, &mut pass).0;
                let is_unknown = truth == Tri::Unknown;
                unmet.push(UnmetCondition { text, words, actual, actual_words, unit, is_unknown });
            }
            continue;
        }
        let mut failing = part
            .atoms
            .iter()
            .filter(|atom| truth_at(atom.condition, row, &mut evaluator, &mut pass).0 != Tri::True);
        let atom = failing.next().or(part.atoms.first());
        let (actual, actual_words) =
            atom.map_or((Value::Null, None), |a| measured_in_words(a, row, &mut evaluator, &mut pass));
        let unit = atom.map_or("", |a| a.unit.symbol);
        let (text, words) = (part.text.clone(), part.words.clone());
        let is_unknown = truth == Tri::Unknown;
        unmet.push(UnmetCondition { text, words, actual, actual_words, unit, is_unknown });
    }
    // The failing parts of a composite condition count one by one, as they are listed.
    let failed_parts = rule.parts.len() - held - later;
    let more = unmet.len() - failed_parts;
    // How long it must hold is a condition, too.
    let lasts = usize::from(rule.min_duration > Nanos::default());
    held += if at_keyframe { lasts } else { 0 };
    if reached.outcome == Outcome::WrongDuration {
        let held = lasted(rule, row, &mut evaluator, &mut pass);
        let longest = rule.max_duration.filter(|max| held > *max);
        let seconds = longest.unwrap_or(rule.min_duration).0 as f64 / 1e9;
        let held = (held.0 as f64 / 1e7).round() / 1e2;
        let words = match longest {
            Some(_) => Bilingual::new(format!("持续不超过 {seconds} s"), format!("For at most {seconds} s")),
            None => Bilingual::new(format!("持续 {seconds} s"), format!("For {seconds} s")),
        };
        unmet.push(UnmetCondition {
            text: format!("for {seconds} s"),
            words,
            actual: held.into(),
            actual_words: Some(Bilingual::same(format!("{held} s"))),
            unit: "s",
            is_unknown: false,
        });
    }
    Some(NearClass {
        scenario: rule.scenario.clone(),
        outcome: reached.outcome,
        held,
        failed: unmet.len(),
        // One that ends too late has no least duration.
        conditions: (rule.parts.len() + more + lasts).max(held + unmet.len()),
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
    use whyroad_model::signal::TargetSpan;
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
            rule("a.c.most", "ego.speed > 5 m/s and ego.accel > -1 m/s2 and ego.speed > 10 m/s"),
            rule("a.b.none", "ego.accel > 2 m/s2"),
        ];
        let found = nearest(&rules, &table, FrameRange::new(2, 10), 2);
        let names: Vec<String> = found.iter().map(|f| f.scenario.to_string()).collect();
        assert_eq!(names, ["a.c.most", "a.b.half"]);
        assert_eq!((found[0].held, found[0].failed, found[0].conditions, found[0].frame), (2, 1, 3, 9));
        assert_eq!(found[0].unmet[0].text, "ego.speed > 10m/s");
        assert_eq!(found[0].unmet[0].actual, serde_json::json!(9.0));
        // A condition that always holds has no weight: two of the three conditions that hold are always met.
        let rules = [
            rule("a.c.always", "ego.accel > -1 m/s2 and ego.accel < 1 m/s2 and ego.speed > 30 m/s"),
            rule("a.b.rare", "ego.speed > 7 m/s and ego.accel > 1 m/s2"),
        ];
        let found = nearest(&rules, &table, FrameRange::new(2, 10), 2);
        assert_eq!(found[0].scenario.to_string(), "a.b.rare", "{found:?}");
    }

    /// 1 s at 10 Hz with a car; there is no signal of lights.
    fn with_a_car() -> SignalTable {
        let n = 10;
        let mut table =
            SignalTable { times: (0..n).map(|i| Nanos(i * 100_000_000)).collect(), ..SignalTable::default() };
        let speed = [vec![3.0; 7], vec![7.0; 3]].concat();
        table.frame_columns.insert("ego.speed".into(), Column::Number(speed));
        table.frame_columns.insert("ego.accel".into(), Column::Number(vec![f64::NAN; 10]));
        table.targets = vec![TargetSpan {
            id: "t".into(),
            class: whyroad_model::ObjectClass::Car,
            first_row: 0,
            frames: FrameRange::new(0, 10),
        }];
        let names = ["car".to_owned(), "animal".to_owned()].into();
        table.target_columns.insert("target.class".into(), Column::Category { codes: vec![0; 10], names });
        table.target_columns.insert("target.gap".into(), Column::Number(vec![3.0; 10]));
        table
    }

    #[test]
    fn what_the_drive_cannot_show_is_not_near_but_undecided() {
        let table = with_a_car();
        let rules = [
            rule("a.b.light", "ego.speed > 5 m/s and light.state == red"),
            rule("a.c.slow", "ego.speed < 1 m/s and light.state == red"),
            // Holds in every frame: it says nothing.
            rule("a.d.drives", "ego.speed > 1 m/s and light.state == red"),
        ];
        let range = FrameRange::new(0, 10);
        let near = nearest(&rules, &table, range, 5);
        assert!(near.is_empty(), "{near:?}");
        let open = undecided(&rules, &table, range, 5);
        let told: Vec<_> = open.iter().map(|c| (c.scenario.to_string(), c.held, c.conditions)).collect();
        // In `slow` a condition is known to fail.
        assert_eq!(told, [("a.b.light".to_owned(), 1, 2)]);
        assert_eq!(open[0].missing, ["light.state"]);
    }

    #[test]
    fn a_car_is_not_nearly_an_animal_and_unknown_is_not_false() {
        let table = with_a_car();
        let near = |text: &str| nearest(&[rule("a.b.c", text)], &table, FrameRange::new(0, 10), 1);
        assert!(near("target.class == animal and target.gap < 2 m").is_empty());
        let found =
            near("target.class == car and target.gap < 2 m and (ego.accel < 0 m/s2 or target.gap < 1 m)");
        let unmet: Vec<_> = found[0].unmet.iter().map(|u| (u.text.as_str(), u.is_unknown)).collect();
        assert_eq!(unmet, [("target.gap < 2m", false), ("(ego.accel < 0m/s2) or (target.gap < 1m)", true)]);
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
        let counts = |text: &str| {
            let found = nearest(&[rule("a.b.c", text)], &table, FrameRange::new(0, 10), 1);
            (found[0].held, found[0].failed, found[0].conditions, found[0].unmet.len())
        };
        assert_eq!(counts(and), (1, 1, 2, 1));
        // The members of the conjunction that fail are listed, and count, one by one.
        let two = "((ego.speed > 9 m/s and ego.accel > 1 m/s2) for 0.3 s) and ego.yaw_rate < 1 rad/s";
        assert_eq!(counts(two), (1, 2, 3, 2));
        // The first alternative lacks one of its two, the second both.
        let or = "ego.speed > 5 m/s and ego.accel > 1 m/s2 or ego.speed > 9 m/s and ego.accel > 2 m/s2";
        assert_eq!(unmet(or), ["ego.accel > 1m/s2"]);
        let equal = "ego.speed > 9 m/s or ego.accel > 1 m/s2";
        assert_eq!(unmet(equal), ["(ego.speed > 9m/s) or (ego.accel > 1m/s2)"]);
    }
}
