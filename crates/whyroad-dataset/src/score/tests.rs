//! Expected figures are computed by hand from the few samples.

use super::predictions::{PredictedTrajectory, Prediction, Predictions, Vocabulary};
use super::resample::{Random, estimate};
use super::truth::Truth;
use super::*;

/// Four samples of two drives: decisions yield, yield, follow, none; leaves a.b.c twice, a.b.d, x.y.z.
fn truth() -> Vec<Truth> {
    let row = |i: usize, drive: &str, longitudinal: &str, leaf: &str| Truth {
        sample_id: format!("s{i}"),
        drive: drive.into(),
        place: (i != 3).then(|| "town".to_owned()),
        leaf: leaf.into(),
        longitudinal: Some(longitudinal.into()),
        lateral: Some("lane_keeping".into()),
        future: (1..=4).map(|k| [k as f32 * 0.5, k as f32 * 5.0, 0.0]).collect(),
        future_complete: true,
    };
    vec![
        row(0, "d0", "yield_to_agent", "a.b.c"),
        row(1, "d0", "yield_to_agent", "a.b.c"),
        row(2, "d1", "lead_following", "a.b.d"),
        row(3, "d1", NO_CHANGE, "x.y.z"),
    ]
}

fn prediction(i: usize, longitudinal: Option<&str>, leaf: &str) -> Prediction {
    Prediction {
        sample_id: format!("s{i}"),
        longitudinal: Some(longitudinal.map(str::to_owned)),
        scenario_id: Some(leaf.into()),
        ..Prediction::default()
    }
}

fn scored(predictions: Vec<Prediction>) -> (Score, Vec<Diagnostic>) {
    let in_training = BTreeMap::from([("a.b.c", 120), ("a.b.d", 9)]);
    score_truth("r 1", &truth(), &in_training, &Predictions::new(predictions), Options::default())
}

#[test]
fn decisions_and_leaf_by_hand() {
    let (s, found) = scored(vec![
        prediction(0, Some("yield_to_agent"), "a.b.c"),
        prediction(1, Some("lead_following"), "a.b.d"),
        prediction(2, Some("lead_following"), "a.b.d"),
        prediction(3, None, "a.b.c"),
    ]);
    assert!(found.is_empty(), "{found:?}");
    // Three of four decisions: s0, s2, and s3 whose null is "no change".
    assert_eq!(s.overall.longitudinal.unwrap().value, 0.75);
    // Leaves: s0 and s2. L2: also s1, which is a.b either way.
    assert_eq!(s.overall.leaf.unwrap().value, 0.5);
    assert_eq!(s.overall.l2.unwrap().value, 0.75);
    assert!(s.overall.lateral.is_none() && s.overall.decisions.is_none(), "lateral is not predicted");
    assert!(s.overall.ade_m.is_none());
    // F1: yield 2*1/(2+1), follow 2*1/(1+2), no change 2*1/(1+1); mean (2/3 + 2/3 + 1) / 3 = 7/9.
    let f1 = s.classes[&Target::Longitudinal].macro_f1.unwrap();
    assert!((f1.value - 7.0 / 9.0).abs() < 1e-12, "{f1:?}");
    let following = s.classes[&Target::Longitudinal].by_class["lead_following"];
    assert_eq!((following.precision, following.recall), (Some(0.5), Some(1.0)));
    assert_eq!(s.by_leaf["a.b.c"].leaf.unwrap().value, 0.5);
    assert_eq!(s.by_place["unknown"].samples, 1);
    let groups: Vec<(Rarity, usize)> = s.by_rarity.iter().map(|(k, f)| (*k, f.samples)).collect();
    assert_eq!(groups, [(Rarity::Unseen, 1), (Rarity::Few, 1), (Rarity::Many, 2)]);
    // Drives d0 and d1 have 1/2 and 2/2 right decisions: resamples are 0.5, 0.75 and 1.
    let e = s.overall.longitudinal.unwrap();
    assert_eq!((e.low, e.high), (Some(0.5), Some(1.0)));
    // One drive alone gives no interval.
    assert_eq!(s.by_leaf["a.b.c"].leaf.unwrap().low, None);
}

#[test]
fn an_unknown_decision_is_neither_right_nor_wrong() {
    // As `whyroad labels import` makes it: null decisions, and no component that is their cause.
    let imported = Truth::of(&crate::Sample { sample_id: "s9".into(), ..crate::Sample::default() });
    assert_eq!([Target::Longitudinal, Target::Lateral].map(|t| imported.class(t)), [None, None]);
    let mut truth = truth();
    truth.push(Truth { drive: "d1".into(), leaf: "a.b.c".into(), ..imported });
    let rows = [
        prediction(0, Some("yield_to_agent"), "a.b.c"),
        prediction(1, Some("yield_to_agent"), "a.b.c"),
        prediction(2, None, "a.b.d"),
        prediction(3, None, "x.y.z"),
        prediction(9, None, "a.b.c"),
    ];
    let (s, found) =
        score_truth("r 1", &truth, &BTreeMap::new(), &Predictions::new(rows), Options::default());
    // Of the four that are known, s2 is wrong; the class of all five is known.
    assert_eq!(s.overall.longitudinal.unwrap().value, 0.75);
    assert_eq!(s.overall.leaf.unwrap().value, 1.0);
    let none = s.classes[&Target::Longitudinal].by_class[NO_CHANGE];
    assert_eq!((none.samples, none.predicted, none.right), (1, 2, 1));
    let left_out: Vec<&str> = found.iter().map(|d| d.code).collect();
    assert_eq!(left_out, ["score.decision.unknown"]);
    assert!(found[0].message.en.contains("of 1 sample"), "{}", found[0].message.en);
}

#[test]
fn a_sample_without_prediction_counts_as_wrong_and_is_reported() {
    let (s, found) =
        scored(vec![prediction(0, Some("yield_to_agent"), "a.b.c"), prediction(9, None, "a.b.c")]);
    assert_eq!((s.samples, s.predicted), (4, 1));
    assert_eq!(s.overall.longitudinal.unwrap().value, 0.25);
    let codes: Vec<&str> = found.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["score.sample.unknown", "score.sample.missing"]);
    assert!(found[1].message.en.starts_with("3 samples"), "{:?}", found[1].message);
}

#[test]
fn displacement_by_hand() {
    // Truth: 10 m/s for 2 s, at 0.5, 1, 1.5, 2 s. Predicted: 3 m to the left and the same speed, given at 1 and 2 s
    // only, so that y is 1.5, 3, 3, 3 m off: ADE 2.625, FDE 3.
    let path =
        |end: f64| PredictedTrajectory { t_s: vec![1.0, end], x: vec![10.0, 10.0 * end], y: vec![3.0, 3.0] };
    let with =
        |i: usize, end: f64| Prediction { trajectory: Some(path(end)), ..prediction(i, None, "a.b.c") };
    let (s, found) =
        scored(vec![with(0, 2.0), with(1, 1.9), prediction(2, None, "a.b.c"), prediction(3, None, "a.b.c")]);
    let (ade, fde) = (s.overall.ade_m.unwrap(), s.overall.fde_m.unwrap());
    assert!((ade.value - 2.625).abs() < 1e-6 && (fde.value - 3.0).abs() < 1e-6, "{ade:?} {fde:?}");
    assert_eq!(ade.samples, 1, "the one that ends at 1.9 s is left out");
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["score.trajectory.short"]);
}

#[test]
fn groups_of_the_same_samples_have_the_same_intervals() {
    // Nine drives whose path is missed by 0, 1, 4, ... 64 m: every draw of drives has another mean.
    let truth: Vec<Truth> = (0..9)
        .map(|i| Truth { sample_id: format!("s{i}"), drive: format!("d{i}"), ..truth()[0].clone() })
        .collect();
    let predictions = (0..9).map(|i| {
        let y = (i * i) as f64;
        let trajectory = PredictedTrajectory { t_s: vec![0.5, 2.0], x: vec![5.0, 20.0], y: vec![y, y] };
        let leaf = if i % 3 == 0 { "a.b.c" } else { "x.y.z" };
        Prediction { trajectory: Some(trajectory), ..prediction(i, None, leaf) }
    });
    let predictions = Predictions::new(predictions);
    let (s, _) =
        score_truth("r 1", &truth, &BTreeMap::from([("a.b.c", 9)]), &predictions, Options::default());
    assert!(s.overall.ade_m.unwrap().low < s.overall.ade_m.unwrap().high);
    for of_all in [&s.by_rarity[&Rarity::Few], &s.by_place["town"], &s.by_leaf["a.b.c"]] {
        assert_eq!(of_all, &s.overall);
    }
}

#[test]
fn lines_that_are_not_predictions_are_reported_with_their_line() {
    let text = concat!(
        "{\"sample_id\":\"s0\",\"longitudinal\":null,\"scenario_id\":\"a.b.c\"}\n",
        "{\"sample_id\":\"s0\",\"longitudinal\":\"resume\"}\n",
        "{\"sample_id\":\"s1\",\"longitudnal\":\"resume\"}\n",
        "\n",
        "{\"sample_id\":\"s2\",\"longitudinal\":\"jump\"}\n",
        "{\"sample_id\":\"s3\",\"trajectory\":{\"t_s\":[1,1],\"x\":[0,0],\"y\":[0,0]}}\n",
        "{\"sample_id\":\"s4\",\"probabilities\":{\"leaf\":{\"a.b.c\":0.7,\"a.b.d\":0.7}}}\n",
    );
    let known = Vocabulary(BTreeMap::from([(Target::Longitudinal, ["resume".to_owned()].into())]));
    let (p, found) = Predictions::read(text.as_bytes(), "p.jsonl", &known).unwrap();
    let at: Vec<(&str, Option<usize>)> = found.iter().map(|d| (d.code, d.location.line)).collect();
    assert_eq!(
        at,
        [
            ("score.prediction.repeated", Some(2)),
            ("score.prediction.line", Some(3)),
            ("score.class.unknown", Some(5)),
            ("score.prediction.line", Some(6)),
            ("score.prediction.line", Some(7)),
        ]
    );
    assert_eq!(p.of("s0").unwrap().class(Target::Longitudinal), Some(NO_CHANGE));
    assert_eq!(p.of("s0").unwrap().class(Target::Lateral), None);
    assert_eq!(p.rows().count(), 2);
}

#[test]
fn the_interval_covers_the_true_mean_about_as_often_as_it_says() {
    // 200 data sets of 40 drives, one number each from [0, 1): the mean 0.5 lies inside about 95 % of the intervals.
    let mut random = Random::new(1, "data");
    let inside = (0..200).filter(|i| {
        let drives: Vec<f64> = (0..40).map(|_| random.unit()).collect();
        let mean = |d: &[&f64]| Some(d.iter().copied().sum::<f64>() / d.len() as f64);
        let e = estimate(&drives, 40, 300, Random::new(2, &i.to_string()), mean).unwrap();
        e.low.unwrap() <= 0.5 && 0.5 <= e.high.unwrap()
    });
    let inside = inside.count();
    assert!((180..=198).contains(&inside), "{inside} of 200");
}

#[test]
fn the_page_escapes_names_and_has_both_languages() {
    let (mut s, _) = scored(vec![prediction(0, None, "a.b.c")]);
    s.release = "<r>".into();
    let html = page::page(&s, Lang::Zh);
    assert!(html.contains("&lt;r&gt;") && !html.contains("<r>"));
    assert!(html.contains("模型评分") && html.contains("Model score") && html.ends_with("</html>\n"));
    assert_eq!(html, page::page(&scored_named("<r>"), Lang::Zh), "the same bytes again");
}

fn scored_named(name: &str) -> Score {
    let (mut s, _) = scored(vec![prediction(0, None, "a.b.c")]);
    s.release = name.into();
    s
}

use whyroad_model::Lang;
