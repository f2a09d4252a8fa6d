//! Every line of docs/reference/refav.md, evaluated by both evaluators on scenes made by hand, against a plain
//! definition of the function (`plain`), object by object and frame by frame.

mod plain;
mod scene;

use plain::{Answer, Plain};
use std::collections::BTreeMap;
use whyroad_engine::objects::signals_for;
use whyroad_mining::fast::layout::RowSet;
use whyroad_mining::fast::{Evaluation, Plan, Signals};
use whyroad_mining::interpret::{Evaluator, Roles, Series};
use whyroad_mining::rule::Rule;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::{Drive, ScenarioId, SignalTable, Tri};
use whyroad_signals::Catalog;

/// Function, arguments and rule of each row of the table that can be asked.
fn table_of_docs() -> Vec<(String, String, String)> {
    let page = include_str!("../../../../docs/reference/refav.md");
    let cells = |line: &str| -> Vec<String> {
        let parts = line.trim().trim_start_matches('|').split('|');
        parts.map(|c| c.trim().trim_matches('`').to_owned()).collect()
    };
    let rows = page.lines().filter(|l| l.starts_with("| `")).map(cells);
    let asked = rows.filter(|c| !c[2].starts_with("an option") && !c[2].starts_with("cannot"));
    asked.map(|c| (c[0].clone(), c[1].clone(), c[2].clone())).collect()
}

fn compiled(rule: &str, related: &str) -> Rule {
    let text = rule.replace(", R)", &format!(", {related})"));
    let compiled = compile_text(&text, None, &ScenarioId::custom("refav"), Catalog::bundled(), "docs");
    compiled.unwrap_or_else(|d| panic!("{text}: {d:?}"))
}

fn signals(rule: &Rule, drive: &Drive) -> SignalTable {
    let whole = || unreachable!("these rules read no other signals");
    signals_for(rule, || Ok(drive.clone()), whole).unwrap()
}

/// Truth of the rule by object and frame, the same by both evaluators.
fn answers(rule: &Rule, table: &SignalTable) -> BTreeMap<(String, usize), Tri> {
    let plan = Plan::of_rules([rule]);
    let columns = Signals::of_table(table);
    let fast = Evaluation::new(&plan, &columns);
    let mut reference = Evaluator::new(&rule.program, table);
    let mut out = BTreeMap::new();
    for (i, span) in table.targets.iter().enumerate() {
        let mut pass = reference.pass_of(Roles { target: Some(span), second: None });
        let values = match reference.series(rule.when, &mut pass).as_ref() {
            Series::Truths(truths) => truths.value.clone(),
            // A flag that the drive cannot support.
            _ => vec![Tri::Unknown; reference.rows(&pass).len()],
        };
        let of_fast = fast.truth(plan.rules[0].node(rule.when), RowSet::Object(i));
        for (row, value) in values.iter().enumerate() {
            assert_eq!(of_fast.at(row), *value, "{} row {row}", span.id);
            let Some(frame) = reference.rows(&pass)[row].frame else { continue };
            out.insert((span.id.to_string(), frame), *value);
        }
    }
    out
}

#[test]
fn every_line_of_the_table_says_what_its_function_says() {
    let rows = table_of_docs();
    assert_eq!(rows.len(), 30, "{rows:#?}");
    let drives = [scene::street(), scene::crowd(7)];
    let mut wrong = Vec::new();
    for (function, call, text) in &rows {
        let mut found = [0usize; 2];
        for drive in &drives {
            for related in ["vehicle", "pedestrian", "any"] {
                let rule = compiled(text, related);
                let got = answers(&rule, &signals(&rule, drive));
                let plain = Plain::new(drive, related);
                for ((id, frame), truth) in &got {
                    let expected = plain.answer(function, call, id, *frame);
                    let fits = match expected {
                        Answer::Open => true,
                        Answer::Is(value) => *truth == Tri::from(value),
                        Answer::Unseen => *truth == Tri::Unknown,
                    };
                    if !fits {
                        let who = format!("{} of {id} at {frame}, R = {related}", drive.meta.drive_id);
                        wrong.push(format!("{function}({call}) in {who}: {truth:?}, not {expected:?}"));
                    }
                    if let Answer::Is(value) = expected {
                        found[usize::from(value)] += 1;
                    }
                }
                if !text.contains(", R)") {
                    break;
                }
            }
        }
        // A definition that is never or always true compares nothing.
        if found.iter().any(|n| *n < 9) {
            wrong.push(format!("{function}({call}): compared only {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} differences, such as\n{}", wrong.len(), some_of_each(&wrong).join("\n"));
}

/// The first few of each function.
fn some_of_each(wrong: &[String]) -> Vec<String> {
    let mut shown: BTreeMap<String, usize> = BTreeMap::new();
    let mut few = |line: &&String| {
        let count = shown.entry(line.split(" of ").next().unwrap_or_default().to_owned()).or_default();
        *count += 1;
        *count <= 4
    };
    wrong.iter().filter(|line| few(line)).cloned().collect()
}
