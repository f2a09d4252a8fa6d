//! Against the challenge's own evaluation (PyPI av2 with trackeval): `examples/truth/scenario_mining/make.py` made the
//! sequences and the expected figures.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use super::assignment::best_assignment;
use super::*;
use proptest::prelude::*;

fn file(name: &str) -> String {
    let path = format!("{}/../../examples/truth/scenario_mining/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn figures_are_those_of_the_challenge() {
    let read = |name: &str| {
        let (sequences, problems) = sequence::read(&file(name), name);
        assert!(problems.is_empty(), "{problems:?}");
        sequences
    };
    let scores = score(&read("truth.jsonl"), &read("predictions.jsonl")).unwrap();
    let expected: serde_json::Value = serde_json::from_str(&file("expected.json")).unwrap();
    let found: serde_json::Value = serde_json::to_value(&scores).unwrap();
    let mut compared = 0;
    for figure in ["hota_temporal", "hota_track", "timestamp_balanced_accuracy", "log_balanced_accuracy"] {
        for (prompt, value) in expected[figure].as_object().unwrap() {
            let (a, b) = (found["prompts"][prompt][figure].as_f64().unwrap(), value.as_f64().unwrap());
            assert!((a - b).abs() < 1e-9, "{figure} of {prompt:?}: {a} against {b}");
            compared += 1;
        }
    }
    assert_eq!(compared, 16);
    assert!((scores.mean.unwrap().hota_temporal - expected["mean"][0].as_f64().unwrap()).abs() < 1e-9);
}

#[test]
fn a_truth_compared_with_itself_is_perfect_where_there_is_something() {
    let (truth, _) = sequence::read(&file("truth.jsonl"), "truth.jsonl");
    let scores = score(&truth, &truth).unwrap();
    for (prompt, f) in &scores.prompts {
        let hota = if prompt == "nobody at all" { 0.0 } else { 1.0 };
        assert!((f.hota_temporal - hota).abs() < 1e-9 && (f.hota_track - hota).abs() < 1e-9, "{prompt}");
        assert!((f.timestamp_balanced_accuracy - 1.0).abs() < 1e-9, "{prompt}");
    }
}

#[test]
fn sequences_without_a_counterpart_are_named() {
    let one = |log: &str, times: &[i64]| Sequence {
        log_id: log.into(),
        prompt: "p".into(),
        frames: times.iter().map(|&timestamp_ns| Frame { timestamp_ns, ..Frame::default() }).collect(),
    };
    assert!(matches!(score(&[one("a", &[1])], &[one("b", &[1])]), Err(Mismatch::NoPrediction { .. })));
    assert!(matches!(score(&[one("a", &[1])], &[one("a", &[2])]), Err(Mismatch::Frames { .. })));
}

/// A mean over nothing is unknown; and a file of sequences given as a truth file says what it is for.
#[test]
fn nothing_compared_has_no_mean() {
    let none = score(&[], &[]).unwrap();
    assert_eq!(none.mean, None);
    assert!(serde_json::to_value(&none).unwrap()["mean"].is_null());
    let mut truth = crate::evaluation::truth::TruthSet::default();
    let found = truth.read(&file("truth.jsonl"), "truth.jsonl", &|_| true);
    assert!(!found.is_empty() && truth.entries.is_empty());
    for d in found {
        let hint = d.hint.unwrap();
        assert!(hint.zh.contains("--predictions") && hint.en.contains("--predictions"), "{hint:?}");
    }
}

#[test]
fn null_is_not_absent() {
    let text = r#"{"log_id":"l","prompt":"p","frames":[{"timestamp_ns":1,"ego":[0,0],"is_positive":null,"objects":[]},{"timestamp_ns":2,"ego":[0,0],"objects":[]}]}"#;
    let (sequences, problems) = sequence::read(&format!("{text}\nnonsense\n"), "s.jsonl");
    assert_eq!(sequences[0].frames.iter().map(|f| f.is_positive).collect::<Vec<_>>(), [Some(None), None]);
    assert_eq!((problems.len(), problems[0].location.line), (1, Some(2)));
    assert_eq!(
        sequence::write(&sequences).unwrap().replace(",\"score\":1.0", ""),
        format!("{}\n", text.replace("[0,0]", "[0.0,0.0]"))
    );
}

/// By trying every assignment.
fn brute(weight: &[Vec<f64>], row: usize, used: u32) -> f64 {
    let Some(w) = weight.get(row) else { return 0.0 };
    let pairs_left = w.len() - used.count_ones() as usize;
    let skip = if weight.len() - row > pairs_left { brute(weight, row + 1, used) } else { f64::NEG_INFINITY };
    (0..w.len())
        .filter(|c| used & (1 << c) == 0)
        .map(|c| w[c] + brute(weight, row + 1, used | (1 << c)))
        .fold(skip, f64::max)
}

proptest! {
    #[test]
    fn no_assignment_is_better(rows in 1..5usize, columns in 1..5usize, values in proptest::collection::vec(0.0..1.0f64, 25)) {
        let weight: Vec<Vec<f64>> = (0..rows).map(|r| (0..columns).map(|c| values[r * 5 + c]).collect()).collect();
        let found = best_assignment(&weight);
        prop_assert_eq!(found.len(), rows.min(columns));
        let sum: f64 = found.iter().map(|&(r, c)| weight[r][c]).sum();
        prop_assert!((sum - brute(&weight, 0, 0)).abs() < 1e-9, "{} {}", sum, brute(&weight, 0, 0));
    }
}
