//! A problem that the features separate must be learned; the other methods cannot solve it.

use super::compare::compare;
use super::folds::out_of_fold;
use super::*;
use crate::Sample;
use crate::doubtful::find;
use crate::sample::{Object, Trajectory};
use crate::score::Options;
use crate::score::resample::Random;
use whyroad_model::Lang;

/// `n` samples of `drives` drives: with a slow car ahead the ego yields (cut-in), else it follows at speed; every
/// sample has the same last meta action, so that repeating it predicts nothing. Lateral is always "no change".
fn samples(n: usize, drives: usize, seed: u64) -> Vec<Sample> {
    let mut random = Random::new(seed, "samples");
    let mut one = |i: usize| {
        let speed = 10.0 + 5.0 * random.unit() as f32;
        let yields = random.unit() < 0.4;
        let gap = 15.0 + 20.0 * random.unit() as f32;
        let lead = if yields { speed - 4.0 } else { speed + 1.0 } + random.unit() as f32;
        let steps: Vec<f32> = (-20..=0).map(|k| k as f32 / 10.0).collect();
        let all = |v: f32| vec![Some(v); 21];
        Sample {
            sample_id: format!("s{i:05}"),
            weight: 1.0,
            scenario_id: if yields {
                "reactive_agent.cutin.urgent"
            } else {
                "reactive_agent.following.steady"
            }
            .into(),
            longitudinal: Some(if yields { "yield_to_agent" } else { "lead_following" }.into()),
            lineage: crate::sample::Lineage { drive_id: format!("d{}", i % drives), ..Default::default() },
            history: Trajectory {
                t_s: steps.clone(),
                speed: all(speed),
                accel: all(0.0),
                meta_longitudinal: vec![Some("maintain_speed".into()); 21],
                meta_lateral: vec![Some("go_straight".into()); 21],
                ..Trajectory::default()
            },
            objects: vec![Object {
                id: "lead".into(),
                class: "car".into(),
                x: steps.iter().map(|t| Some(gap + (lead - speed) * t)).collect(),
                y: all(0.2),
                vx: all(lead),
                vy: all(0.0),
                t_s: steps,
                ..Object::default()
            }],
            ..Sample::default()
        }
    };
    (0..n).map(&mut one).collect()
}

fn rows_of(samples: &[Sample]) -> Vec<Row> {
    samples.iter().map(Row::of).collect()
}

#[test]
fn a_separable_problem_is_learned_and_the_simple_rules_do_not_solve_it() {
    let (train, val, test) = (samples(400, 20, 1), samples(100, 5, 2), samples(200, 10, 3));
    let model = Model::train("r 1", &rows_of(&train), &rows_of(&val), Settings { rounds: 30, seed: 7 });
    let in_training = BTreeMap::new();
    let (c, predictions) = compare(&model, "r 1", &rows_of(&test), &in_training, Options::default());
    let accuracy = |m: Method| c.methods[&m].overall.longitudinal.unwrap().value;
    assert!(accuracy(Method::Boosted) > 0.98, "{}", accuracy(Method::Boosted));
    // Both name the class of about 60 % of samples.
    assert!((0.5..0.7).contains(&accuracy(Method::Majority)), "{}", accuracy(Method::Majority));
    assert_eq!(accuracy(Method::RepeatLast), accuracy(Method::Majority));
    assert_eq!(c.methods[&Method::Boosted].overall.lateral.unwrap().value, 1.0, "a single class");
    let error = c.reliability[&Target::Longitudinal].error.unwrap();
    assert!(error < 0.05, "expected calibration error {error}");
    assert!(predictions.iter().all(|p| p.lateral == Some(None)));
    // The file gives the same model, and a second training the same bytes.
    let text = model.to_json().unwrap();
    let back: Model = serde_json::from_str(&text).unwrap();
    assert_eq!(back.predict(&rows_of(&test), Method::Boosted), predictions);
    let again = Model::train("r 1", &rows_of(&train), &rows_of(&val), Settings { rounds: 30, seed: 7 });
    assert_eq!(again.to_json().unwrap(), text);
    let html = page::page(&c, Lang::En);
    assert!(
        html.contains("ECE") && html.contains("reactive_agent.cutin.urgent") && html.contains("可靠性图")
    );
}

#[test]
fn nothing_after_t0_and_nothing_of_the_label_is_a_feature() {
    let one = samples(1, 1, 5).remove(0);
    let before = format!("{:?}", features::of(&one));
    let mut other = one.clone();
    other.longitudinal = Some("resume".into());
    other.scenario_id = "x.y.z".into();
    other.lineage.target_id = Some("lead".into());
    other.objects[0].named = true;
    other.objects[0].t_s.push(0.1);
    let lead = &mut other.objects[0];
    for values in [&mut lead.x, &mut lead.y, &mut lead.vx, &mut lead.vy] {
        values.push(Some(99.0));
    }
    other.future =
        Trajectory { t_s: vec![1.0], x: vec![Some(3.0)], y: vec![Some(3.0)], ..Trajectory::default() };
    assert_eq!(format!("{:?}", features::of(&other)), before);
    // The features do react: an object that comes closer before t0 changes them.
    other.objects[0].x[20] = Some(8.0);
    assert_ne!(format!("{:?}", features::of(&other)), before);
}

#[test]
fn unknown_stays_unknown() {
    let empty = features::of(&Sample::default());
    assert_eq!(empty.len(), features::NAMES.len());
    let known: Vec<&str> =
        features::NAMES.iter().zip(&empty).filter(|(_, v)| !v.is_nan()).map(|(n, _)| *n).collect();
    // Objects are a list, not an optional field: an empty list means none, not unknown.
    assert_eq!(known, ["objects_30", "vru_30", "large_30"]);
}

/// Dots of all samples at both ends of both axes: their centers are at (44, 28) and (244, 228), and their radius is 12,
/// so a tick's number ends left of 32 or has its top (9 units above its line) below 240.
#[test]
fn dots_do_not_cover_the_numbers_of_the_axes() {
    let svg = page::diagram(Target::Leaf, &calibration::reliability([(0.0, true)])).into_string();
    let number = |tag: &str, name: &str| -> f64 {
        tag.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let tags =
        |start: &str| svg.split('<').filter(|t| t.starts_with(start)).map(str::to_owned).collect::<Vec<_>>();
    let radius = number(&tags("circle")[0], "r");
    assert_eq!(radius, 12.0);
    let (up, across) = (tags("text text-anchor=\"end\""), tags("text text-anchor=\"middle\""));
    assert_eq!((up.len(), across.len()), (3, 3));
    assert!(up.iter().all(|t| number(t, "x") <= 44.0 - radius), "{svg}");
    assert!(across.iter().all(|t| number(t, "y") - 9.0 >= 228.0 + radius), "{svg}");
}

/// Flips the longitudinal decision of 10 % of samples, seeded; the ids of those.
fn noisy(samples: &mut [Sample]) -> BTreeSet<String> {
    let mut random = Random::new(11, "noise");
    let mut out = BTreeSet::new();
    for s in samples.iter_mut().filter(|_| random.unit() < 0.1) {
        let was = s.longitudinal.as_deref() == Some("yield_to_agent");
        s.longitudinal = Some(if was { "lead_following" } else { "yield_to_agent" }.into());
        out.insert(s.sample_id.clone());
    }
    out
}

#[test]
fn ten_percent_of_wrong_labels_are_found() {
    let mut samples = samples(600, 30, 4);
    let wrong = noisy(&mut samples);
    assert!((40..=80).contains(&wrong.len()), "{}", wrong.len());
    let rows = rows_of(&samples);
    let truth: Vec<_> = rows.iter().map(|r| r.truth.clone()).collect();
    let probabilities = out_of_fold(&rows, Target::Longitudinal, 5, Settings { rounds: 30, seed: 0 });
    assert_eq!(probabilities.rows().count(), 600);
    let (found, lost) = find(&truth, &probabilities, Target::Longitudinal);
    assert!(lost.is_empty());
    let hits = found.labels.iter().filter(|d| wrong.contains(&d.sample_id)).count();
    let (precision, recall) = (hits as f64 / found.labels.len() as f64, hits as f64 / wrong.len() as f64);
    println!(
        "10 % noise: precision {precision:.3}, recall {recall:.3}, {} found, {} wrong",
        found.labels.len(),
        wrong.len()
    );
    assert!(precision > 0.85 && recall > 0.85, "precision {precision}, recall {recall}");
    assert!((found.noise.unwrap() - 0.1).abs() < 0.04, "{:?}", found.noise);
}

#[test]
fn a_drive_is_never_in_training_and_held_out_at_once() {
    // With one drive no drive can be held out, so there are no probabilities.
    let rows = rows_of(&samples(20, 1, 6));
    assert_eq!(out_of_fold(&rows, Target::Longitudinal, 5, Settings::default()).rows().count(), 0);
    // A class that occurs in a single drive gets no probability there: its own samples were not in training.
    let mut samples = samples(60, 6, 6);
    samples
        .iter_mut()
        .filter(|s| s.lineage.drive_id == "d3")
        .for_each(|s| s.longitudinal = Some("resume".into()));
    let p = out_of_fold(&rows_of(&samples), Target::Longitudinal, 6, Settings { rounds: 10, seed: 0 });
    for s in samples.iter().filter(|s| s.lineage.drive_id == "d3") {
        let resume = p.of(&s.sample_id).unwrap().probabilities[&Target::Longitudinal]["resume"];
        assert_eq!(resume, 0.0, "{}", s.sample_id);
    }
}

#[test]
fn temperature_and_reliability_by_hand() {
    // Stated 0.9 but right in 6 of 10: the best temperature moves 0.9 to 0.6, that is ln 9 / T = ln 1.5.
    let rows = vec![vec![0.9, 0.1]; 10];
    let labels = [0, 0, 0, 0, 0, 0, 1, 1, 1, 1];
    let t = temperature(&rows, &labels);
    assert!((t - 9f64.ln() / 1.5f64.ln()).abs() < 1e-3, "{t}");
    assert!((calibration::scaled(&rows[0], t)[0] - 0.6).abs() < 1e-4);
    let r = calibration::reliability(labels.iter().map(|l| (0.9, *l == 0)));
    assert!((r.error.unwrap() - 0.3).abs() < 1e-12);
    assert_eq!(r.bins[9].samples, 10);
    assert_eq!(r.bins[0].right, None);
}
