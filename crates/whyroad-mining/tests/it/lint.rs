//! What is wrong in rules, precedence and labeling expressions is found and shown where it is written.

use whyroad_framework::Framework;
use whyroad_mining::rule::lint::lint;
use whyroad_model::{Diagnostic, Lang, diagnostic};
use whyroad_signals::Catalog;

/// Findings after `from` became `to` in `file` of the built-in framework, and the line (from 1) on which that is.
fn broken(file: &str, from: &str, to: &str) -> (Vec<Diagnostic>, usize) {
    let mut files = Framework::bundled_files();
    let text = files.get_mut(file).unwrap();
    let at = text.find(from).unwrap_or_else(|| panic!("{file} has no {from}"));
    let line = text[..at].matches('\n').count() + 1;
    *text = text.replacen(from, to, 1);
    let (framework, found) = Framework::from_files(&files);
    assert!(found.is_empty(), "the loader, which does not know the language, finds nothing: {found:?}");
    (lint(&framework.unwrap(), Catalog::bundled()), line)
}

#[test]
fn the_bundled_framework_is_free_of_findings() {
    let mut found = lint(Framework::bundled(), Catalog::bundled());
    // A note that a definition could have a name is advice.
    found.retain(|d| d.code != "rule.words");
    let text: String = found.iter().map(|d| diagnostic::render_text(d, Lang::En)).collect();
    assert!(found.is_empty(), "{text}");
    // Every `expr:` line of the files, counted as text.
    let lines: usize = Framework::bundled_files()
        .iter()
        .filter(|(path, _)| path.starts_with("scenarios/") && !path.ends_with(".cases.yaml"))
        .flat_map(|(_, text)| text.lines())
        .filter(|line| line.trim_start().starts_with("expr:") || line.contains(", expr:"))
        .count();
    assert!(lines > 20, "{lines}");
    assert_eq!(Framework::bundled().expressions.len(), lines);
}

#[test]
fn a_misspelled_moment_has_a_suggestion() {
    let (found, line) = broken("scenarios/reactive_rule.yaml", "keyframe - 2 s", "match.strat");
    assert_eq!((found.len(), found[0].location.line), (1, Some(line)), "{found:?}");
    let hint = found[0].hint.as_ref().unwrap();
    assert!(hint.en == "did you mean 'match.start'?" && hint.zh.contains("match.start"), "{hint:?}");
}

#[test]
fn faults_are_shown_where_they_are_written() {
    for (file, from, to, code) in [
        // A rule of a leaf, the start of an L1, an L2 none of whose leaves has a rule for AEB data, the order of
        // precedence.
        ("scenarios/reactive_agent/cutin.yaml", "target.ttc <", "target.tcc <", "rule.signal.unknown"),
        ("scenarios/reactive_rule.yaml", "keyframe - 2 s", "keyframe - 2 m", "rule.unit.mismatch"),
        ("scenarios/safety/aeb.yaml", "rises(ego.aeb)", "rises(ego.aebb)", "rule.signal.unknown"),
        ("schema/precedence.yaml", "- safety.aeb\n", "- safety.abe\n", "rule.precedence"),
    ] {
        let (found, line) = broken(file, from, to);
        assert_eq!(found.len(), 1, "{file}: {found:#?}");
        let place = &found[0].location;
        let shown = (found[0].code, place.file.as_deref(), place.line);
        assert_eq!(shown, (code, Some(file), Some(line)));
        if code == "rule.precedence" {
            assert_eq!(found[0].hint.as_ref().unwrap().en, "did you mean 'safety.aeb'?");
        }
        if code == "rule.signal.unknown" {
            assert!(found[0].hint.as_ref().is_some_and(|h| h.en.contains("did you mean")), "{:?}", found[0]);
            let column = place.column.unwrap();
            let text = place.snippet.as_deref().unwrap();
            assert!(
                text.chars().skip(column - 1).collect::<String>().starts_with(
                    to.split(['(', ' ']).find(|w| w.contains('.')).unwrap().trim_end_matches(')')
                )
            );
        }
    }
}

#[test]
fn a_moment_may_use_the_parameters_of_its_rule() {
    let mut files = Framework::bundled_files();
    let text = files.get_mut("scenarios/reactive_agent/cutin.yaml").unwrap();
    *text = text.replacen("rises(target.wheel_over_line)", "rises(target.longitudinal < reach)", 1);
    assert!(text.contains("    reach:"), "the L2's rule has this parameter");
    let framework = Framework::from_files(&files).0.unwrap();
    assert_eq!(lint(&framework, Catalog::bundled()), vec![]);
}

#[test]
fn an_entry_of_the_signal_catalog_with_a_mistake_is_shown_in_its_file() {
    let text = Framework::bundled().signals_yaml.replacen("name: ego.jerk", "name: ego.accel", 1).replacen(
        "unit: m/s3",
        "unit: m/s2",
        1,
    );
    let (_, found) = Catalog::parse(&text);
    let line = text.lines().enumerate().filter(|(_, l)| l.ends_with("name: ego.accel")).nth(1).unwrap().0 + 1;
    // The entry's own name is missing now.
    assert_eq!(
        found.iter().map(|d| d.code).collect::<Vec<_>>(),
        ["signals.name", "signals.missing"],
        "{found:?}"
    );
    let place = &found[0].location;
    assert_eq!(
        (found[0].code, place.file.as_deref(), place.line),
        ("signals.name", Some("schema/signals.yaml"), Some(line))
    );
}
