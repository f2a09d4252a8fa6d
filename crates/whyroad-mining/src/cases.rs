//! Cases beside the rules (`scenarios/<l1>/<l2>.cases.yaml`): small traces of signals, and the episodes that
//! the rules must find in them. `docs/reference/rules.md` describes the file. They are written by hand; nothing here
//! knows where signals come from.

pub mod drawing;
mod file;
mod table;
mod trace;

pub use file::{CaseKind, Reason};

use crate::drive::DriveEpisodes;
use crate::episode::Episode;
use crate::fast::{Plan, mine_planned};
use crate::interpret::STEP;
use crate::rule::{OTHER, Rule, RuleSet};
use file::{CaseFile, CaseText};
use std::collections::{BTreeMap, BTreeSet};
use table::{fault_of_base, lacks_signals, table};
use whyroad_framework::{Framework, yaml_text};
use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::yaml::{self, DecodeError, Node};
use whyroad_model::{Bilingual, Diagnostic, Location, ScenarioId, SignalTable};
use whyroad_signals::Catalog;

/// The cases that were run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Cases by rule and kind.
    pub cases: BTreeMap<(ScenarioId, CaseKind), usize>,
    /// One `rule.case` for each case that failed or could not be read.
    pub failures: Vec<Diagnostic>,
    /// Files whose cases could not be read at all: they may have cases of any kind.
    pub unread: BTreeSet<String>,
}

/// Inputs for the cases of a framework.
#[derive(Clone, Copy, Debug)]
pub struct CaseRunner<'a> {
    /// The rules in force.
    pub rules: &'a RuleSet,
    /// The signals that the cases may state.
    pub catalog: &'a Catalog,
    /// Rule files with reported errors. Cases of a rule that could not be made are skipped: their failure would only
    /// repeat the error.
    pub faulty: &'a BTreeSet<String>,
}

/// Cases of one class that has no usable rule.
struct Unruled {
    cases: usize,
    first_line: Option<usize>,
}

impl Tally {
    /// One warning for each of the rules that lacks a kind of case, at the rule. `framework` has their positions.
    pub fn missing(&self, rules: &RuleSet, framework: &Framework) -> Vec<Diagnostic> {
        let of_rule = |rule: &Rule| {
            let lacks = |kind: &CaseKind| !self.cases.contains_key(&(rule.scenario.clone(), *kind));
            let missing: Vec<CaseKind> = CaseKind::ALL.into_iter().filter(lacks).collect();
            if missing.is_empty() {
                return None;
            }
            let (class, names) = (&rule.scenario, missing.iter().map(|k| k.id()).collect::<Vec<_>>());
            let message = Bilingual::new(
                format!("{class} 的挖掘规则缺少用例：{}", names.join("、")),
                format!("the mining rule of {class} has no case of these kinds: {}", names.join(", ")),
            );
            let source = framework.rule(class)?;
            let beside = source.file.replace(".yaml", CASES_EXTENSION);
            if self.unread.contains(&beside) {
                return None;
            }
            let hint = Bilingual::new(
                format!("在 {beside} 中为每一类各写至少一个用例（kind）"),
                format!("write at least one case of each kind in {beside}"),
            );
            let at = yaml_text::location(&source.file, &source.text, source.mark);
            Some(Diagnostic::warning("rule.case.missing", message).with_hint(hint).at(at))
        };
        rules.rules.iter().filter_map(of_rule).collect()
    }
}

impl CaseRunner<'_> {
    /// Runs the cases of every `scenarios/**/*.cases.yaml` among the texts of a framework, by relative path.
    pub fn run_all(&self, files: &BTreeMap<String, String>) -> Tally {
        let mut all = Tally::default();
        let beside =
            files.iter().filter(|(p, _)| p.starts_with("scenarios/") && p.ends_with(CASES_EXTENSION));
        for (path, text) in beside {
            let tally = self.run(path, text);
            all.failures.extend(tally.failures);
            all.unread.extend(tally.unread);
            for (key, n) in tally.cases {
                *all.cases.entry(key).or_default() += n;
            }
        }
        all
    }

    /// Runs all cases of one file.
    pub fn run(&self, file: &str, text: &str) -> Tally {
        let mut tally = Tally::default();
        let what = Bilingual::new("用例文件", "the file of cases");
        let (parsed, root): (CaseFile, Node) = match yaml_text::read("rule.case", file, text, what) {
            Ok(read) => read,
            Err(finding) => {
                tally.failures.push(*finding);
                tally.unread.insert(file.to_owned());
                return tally;
            }
        };
        let nodes = root.get("cases").map_or(&[][..], |n| n.items());
        if let Some(failures) = self.faults_of_base(file, text, &root, nodes.len()) {
            tally.failures = failures;
            tally.unread.insert(file.to_owned());
            return tally;
        }
        let l1 = parsed.l1.unwrap_or_else(|| OTHER.to_owned());
        let l2 = ScenarioId { l1, l2: parsed.l2, l3: None };
        let rules = self.rules.restricted_to(std::slice::from_ref(&l2));
        let plan = Plan::of(&rules);
        let mut unruled: BTreeMap<ScenarioId, Unruled> = BTreeMap::new();
        let mut of_l2 = Vec::new();
        for node in nodes {
            let case: CaseText = match yaml::from_node(node) {
                Ok(case) => case,
                Err(e) => {
                    tally.failures.push(unreadable(file, text, node, &e));
                    continue;
                }
            };
            let case = &case;
            let scenario = ScenarioId { l3: case.leaf.clone(), ..l2.clone() };
            let line = Some(node.get("name").unwrap_or(node).mark.line);
            let Some(rule) = rules.rules.iter().find(|r| r.scenario == scenario) else {
                unruled.entry(scenario).or_insert(Unruled { cases: 0, first_line: line }).cases += 1;
                continue;
            };
            *tally.cases.entry((scenario, case.kind)).or_default() += 1;
            if lacks_signals(case, &parsed.base, self.catalog) {
                continue;
            }
            let read = table(case, &parsed.base, self.catalog).and_then(|table| {
                stated(case, rule, &table)?;
                Ok(table)
            });
            let held = match &read {
                Ok(table) => {
                    expected(case, rule, &mine_planned(&rules, &plan, table)).map_err(|r| (r, decide()))
                }
                Err(reason) => Err((reason.clone(), correct_the_value())),
            };
            if let Err((reason, hint)) = held {
                let failed = failure(file, line, &case.name, &reason).with_hint(hint);
                if case.leaf.is_none() { &mut of_l2 } else { &mut tally.failures }.push(failed);
            }
        }
        let for_leaves = self.is_faulty(file) && unruled.keys().any(ScenarioId::is_leaf);
        match of_l2.first() {
            Some(first) if for_leaves => {
                tally.failures.push(unsettled(file, first.location.line, of_l2.len(), &l2))
            }
            _ => tally.failures.extend(of_l2),
        }
        tally.failures.extend(self.unruled(file, &unruled));
        tally
    }

    /// Errors of the values that all cases have in common, each where it is written, and a note that no case was run.
    fn faults_of_base(&self, file: &str, text: &str, root: &Node, cases: usize) -> Option<Vec<Diagnostic>> {
        let entries = root.get("base").map_or(&[][..], Node::entries);
        let mut found: Vec<Diagnostic> = Vec::new();
        for entry in entries {
            let reason = fault_of_base(&entry.key, entry.node.text().unwrap_or_default(), self.catalog);
            let Some(reason) = reason else { continue };
            let message = Bilingual::new(format!("base：{}", reason.zh), format!("base: {}", reason.en));
            let at = yaml_text::location(file, text, entry.node.mark);
            found.push(Diagnostic::error("rule.case", message).with_hint(correct_the_value()).at(at));
        }
        if found.is_empty() {
            return None;
        }
        let message = Bilingual::new(
            format!("{cases} 个用例未运行，因为它们共有的值（base）有错误"),
            format!("{} not run, because values that they have in common (base) have errors", counted(cases)),
        );
        found.push(Diagnostic::note("rule.case.skipped", message).in_file(file));
        Some(found)
    }

    /// The rule file beside a file of cases has errors.
    fn is_faulty(&self, file: &str) -> bool {
        file.strip_suffix(CASES_EXTENSION).is_some_and(|stem| self.faulty.contains(&format!("{stem}.yaml")))
    }

    /// One note for all cases that are not run because of faulty rules; else an error for each class that has no rule.
    fn unruled(&self, file: &str, unruled: &BTreeMap<ScenarioId, Unruled>) -> Vec<Diagnostic> {
        if !self.is_faulty(file) {
            let one = |(class, u): (&ScenarioId, &Unruled)| {
                let n = u.cases;
                let zh = format!("{class} 没有挖掘规则，它的 {n} 个用例未运行");
                let en = format!("{class} has no mining rule; {} not run", counted(n));
                let known = self.rules.rules.iter().map(|r| r.scenario.to_string()).collect::<Vec<_>>();
                let near = did_you_mean(&class.to_string(), known.iter().map(String::as_str)).map(suggestion);
                Diagnostic { hint: near, ..said(file, u.first_line, Bilingual::new(zh, en)) }
            };
            return unruled.iter().map(one).collect();
        }
        let cases: usize = unruled.values().map(|u| u.cases).sum();
        if cases == 0 {
            return vec![];
        }
        let classes: Vec<String> = unruled.keys().map(ToString::to_string).collect();
        let message = Bilingual::new(
            format!("{cases} 个用例未运行，因为所属规则有错误：{}", classes.join("、")),
            format!("{} not run, because the rule has errors: {}", counted(cases), classes.join(", ")),
        );
        vec![Diagnostic::note("rule.case.skipped", message).in_file(file)]
    }
}

const CASES_EXTENSION: &str = ".cases.yaml";

fn counted(cases: usize) -> String {
    if cases == 1 { "1 case was".to_owned() } else { format!("{cases} cases were") }
}

/// The note for cases of an L2 that fail while a leaf below it has no rule: the L2's own rule is silent only where a
/// leaf knows the variant.
fn unsettled(file: &str, line: Option<usize>, cases: usize, l2: &ScenarioId) -> Diagnostic {
    let en = if cases == 1 { "1 case".to_owned() } else { format!("{cases} cases") };
    let message = Bilingual::new(
        format!("{l2} 有 {cases} 个用例无法判断：它下面的 L3 场景的规则有错误"),
        format!("{en} of {l2} cannot be judged: rules of leaves below it have errors"),
    );
    let at = Location { file: Some(file.to_owned()), line, ..Location::default() };
    Diagnostic::note("rule.case.skipped", message).at(at)
}

/// The finding for a case with a value that it cannot have.
fn unreadable(file: &str, text: &str, node: &Node, e: &DecodeError) -> Diagnostic {
    let what = match node.get("name").and_then(Node::text) {
        Some(name) => Bilingual::new(format!("用例 '{name}' "), format!("case '{name}'")),
        None => Bilingual::new("没有名称的用例", "a case without a name"),
    };
    yaml_text::decoding("rule.case", file, text, what, e)
}

/// The remedy where rule and case differ.
fn decide() -> Bilingual {
    Bilingual::new(
        "依据类别定义与标注规格判断哪一个正确，修改另一个",
        "decide from the class and its labeling spec which of the two is right, and change the other",
    )
}

/// The remedy where the case cannot be read.
fn correct_the_value() -> Bilingual {
    Bilingual::new(
        "按信号的类型写：数带单位（10 m/s），标志写 true 或 false，类别写其取值；`whyroad signals show` 显示该信号",
        "write it as the signal is: a number with its unit (10 m/s), true or false, or a value of the category; \
         `whyroad signals show` shows the signal",
    )
}

fn failure(file: &str, line: Option<usize>, name: &str, reason: &Reason) -> Diagnostic {
    let message = Bilingual::new(
        format!("用例 '{name}' 不成立：{}", reason.zh),
        format!("case '{name}' fails: {}", reason.en),
    );
    said(file, line, message)
}

fn said(file: &str, line: Option<usize>, message: Bilingual) -> Diagnostic {
    Diagnostic::error("rule.case", message).at(Location {
        file: Some(file.to_owned()),
        line,
        ..Location::default()
    })
}

/// The case gives every signal that the rule reads.
fn stated(case: &CaseText, rule: &Rule, table: &SignalTable) -> Result<(), Reason> {
    for signal in rule.signals() {
        let said = table.frame_columns.contains_key(&signal)
            || table.target_columns.contains_key(&signal)
            || case.lacks.contains(&signal);
        if !said && rule.subject.is_some_and(|_| case.target.is_some()) {
            return Err(Bilingual::new(
                format!("没有说明规则所用的 {signal}"),
                format!("{signal}, which the rule reads, is not given"),
            ));
        }
    }
    Ok(())
}

/// The rule found what the case expects, where it expects it.
fn expected(case: &CaseText, rule: &Rule, found: &DriveEpisodes) -> Result<(), Reason> {
    let scenario = &rule.scenario;
    let ours: Vec<_> = found.episodes.iter().filter(|e| e.scenario == *scenario).collect();
    let shown = found_text(&ours);
    if ours.len() != case.expect.len() {
        let n = case.expect.len();
        return Err(Bilingual::new(
            format!("应有 {n} 个，实际{}", shown.zh),
            format!("{n} expected, found {}", shown.en),
        ));
    }
    for (e, x) in ours.iter().zip(&case.expect) {
        let second = e.second_keyframe.unwrap_or(usize::MAX);
        let moments = [
            (Some(&x.keyframe), e.keyframe),
            (x.start.as_ref(), e.range.start),
            (x.end.as_ref(), e.range.end),
            (x.second_keyframe.as_ref(), second),
        ];
        for (wanted, frame) in moments {
            if let Some(text) = wanted
                && !is_at(text, frame)?
            {
                return Err(Bilingual::new(
                    format!("应在 {text}，实际{}", shown.zh),
                    format!("{text} expected, found {}", shown.en),
                ));
            }
        }
    }
    let missing = found.missing.get(scenario).cloned().unwrap_or_default();
    if missing != case.not_observable {
        let is_observable = missing.is_empty();
        let (wanted, missing) = (case.not_observable.join(", "), missing.join(", "));
        return Err(match (case.not_observable.is_empty(), is_observable) {
            (true, _) => Bilingual::new(
                format!("应可观测，实际缺少 [{missing}]"),
                format!("observable expected, but it lacks [{missing}]"),
            ),
            (_, true) => Bilingual::new(
                format!("应因缺少 [{wanted}] 而不可观测，实际可观测"),
                format!("not observable for lack of [{wanted}] expected, but it is observable"),
            ),
            _ => Bilingual::new(
                format!("应因缺少 [{wanted}] 而不可观测，实际缺少 [{missing}]"),
                format!("not observable for lack of [{wanted}] expected, found [{missing}]"),
            ),
        });
    }
    Ok(())
}

fn seconds(frame: usize) -> f64 {
    frame as f64 * STEP.as_secs_f64()
}

fn is_at(wanted: &str, frame: usize) -> Result<bool, Reason> {
    // `usize::MAX`: no second keyframe was found.
    let at = if frame == usize::MAX { f64::INFINITY } else { seconds(frame) };
    Ok((trace::time(wanted)?.as_secs_f64() - at).abs() < 0.051)
}

/// Description of what was found.
fn found_text(found: &[&Episode]) -> Bilingual {
    if found.is_empty() {
        return Bilingual::new("没有找到", "nothing");
    }
    let each = |one: &dyn Fn(&Episode) -> String| found.iter().map(|e| one(e)).collect::<Vec<_>>();
    let second = |e: &Episode, word: &str| match e.second_keyframe {
        Some(frame) => format!("{word}{:.1} s", seconds(frame)),
        None => String::new(),
    };
    let zh = each(&|e| {
        let (from, to) = (seconds(e.range.start), seconds(e.range.end));
        format!("关键帧 {:.1} s{}，范围 {from:.1} 至 {to:.1} s", seconds(e.keyframe), second(e, "，第二个 "))
    });
    let en = each(&|e| {
        let (from, to) = (seconds(e.range.start), seconds(e.range.end));
        format!("keyframe {:.1} s{} in {from:.1} to {to:.1} s", seconds(e.keyframe), second(e, ", second "))
    });
    Bilingual::new(zh.join("；"), en.join("; "))
}

#[cfg(test)]
mod tests;
