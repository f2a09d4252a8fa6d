//! The counterfactual model against ground truth from SUMO (`examples/counterfactual`): whether removing a thing
//! changes how far the ego drives.
#![allow(clippy::print_stdout)] // the table is what a reader wants to see

use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::Arc;
use whyroad_label::counterfactual::{Removed, counterfactual};
use whyroad_model::scene::{Ego, Motion, Track};
use whyroad_model::{Column, Drive, Nanos, ObjectClass, SignalTable, Tri};

/// Rows per second of the file, and of a drive.
const FILE_HZ: f64 = 2.0;
const HZ: f64 = 10.0;
/// Additional distance in 8 s from which the ego was affected, m. Values between the two are undecided.
const AFFECTED_M: f64 = 4.0;
const UNAFFECTED_M: f64 = 1.0;

#[derive(Deserialize)]
struct Scene {
    leaf: String,
    driver: String,
    keyframe: usize,
    tracks: BTreeMap<String, Vec<Option<[f64; 2]>>>,
    line: Option<f64>,
    effects: BTreeMap<String, f64>,
}

/// Positions at 10 Hz, m; NaN where unknown.
fn positions(rows: &[Option<[f64; 2]>]) -> Vec<[f64; 2]> {
    let n = ((rows.len() - 1) as f64 / FILE_HZ * HZ) as usize + 1;
    let at = |i: usize| rows.get(i).copied().flatten();
    (0..n)
        .map(|f| {
            let t = f as f64 / HZ * FILE_HZ;
            let (i, k) = (t.floor() as usize, t.fract());
            match (at(i), at(i + 1)) {
                (Some(a), Some(b)) => [0, 1].map(|d| 0.1 * (a[d] + k * (b[d] - a[d]))),
                (Some(a), None) if k == 0.0 => a.map(|x| 0.1 * x),
                _ => [f64::NAN; 2],
            }
        })
        .collect()
}

fn motion(p: &[[f64; 2]]) -> Motion {
    let n = p.len();
    let mut m = Motion::unknown(n);
    for f in 0..n {
        (m.x[f], m.y[f]) = (p[f][0], p[f][1]);
        let (a, b) = (f.saturating_sub(2), (f + 2).min(n - 1));
        let dt = (b - a) as f64 / HZ;
        (m.vx[f], m.vy[f]) = ((p[b][0] - p[a][0]) / dt, (p[b][1] - p[a][1]) / dt);
        let moves = m.vx[f].hypot(m.vy[f]) > 0.3;
        m.heading[f] = if moves { m.vy[f].atan2(m.vx[f]) } else { 0.0 };
    }
    m
}

fn drive(s: &Scene) -> (Drive, SignalTable, usize) {
    let ego = positions(&s.tracks["ego"]);
    let n = ego.len();
    let ego = motion(&ego);
    let times: Vec<Nanos> = (0..n).map(|f| Nanos(f as i64 * 100_000_000)).collect();
    let tracks: Vec<Track> = s
        .tracks
        .iter()
        .filter(|(name, _)| *name != "ego")
        .map(|(name, rows)| {
            let p = positions(rows);
            let known: Vec<usize> = (0..p.len()).filter(|f| !p[*f][0].is_nan()).collect();
            let m = motion(&p);
            let pick = |v: &[f64]| known.iter().map(|f| v[*f]).collect::<Vec<f64>>();
            let person = s.leaf == "crossing" && name != "o3";
            let (length, width) = if person { (0.4, 0.5) } else { (4.5, 1.8) };
            Track {
                id: name.as_str().into(),
                class: if person { ObjectClass::Pedestrian } else { ObjectClass::Car },
                frames: known.iter().map(|f| *f as u32).collect(),
                motion: Motion {
                    x: pick(&m.x),
                    y: pick(&m.y),
                    vx: pick(&m.vx),
                    vy: pick(&m.vy),
                    heading: pick(&m.heading),
                    ..Motion::unknown(known.len())
                },
                length_m: vec![length; known.len()],
                width_m: vec![width; known.len()],
                height_m: vec![1.6; known.len()],
                ..Track::default()
            }
        })
        .collect();
    let speed: Vec<f64> = (0..n).map(|f| ego.speed(f)).collect();
    let mut columns = BTreeMap::from([("ego.speed".to_owned(), Column::Number(speed))]);
    if let Some(line) = s.line {
        // From the front of the ego, 2.3 m before its center.
        let distance = ego.x.iter().map(|x| 0.1 * line - x - 2.3).collect();
        columns.insert("light.distance_to_stop_line".to_owned(), Column::Number(distance));
        let names: Arc<[String]> = vec!["red".to_owned()].into();
        columns.insert("light.state".to_owned(), Column::Category { codes: vec![0; n], names });
    }
    columns.insert("lead.exists".to_owned(), Column::Flag(vec![Tri::Unknown; n]));
    let signals = SignalTable { times: times.clone(), frame_columns: columns, ..SignalTable::default() };
    let keyframe = (s.keyframe as f64 / FILE_HZ * HZ) as usize;
    let ego = Ego { length_m: 4.6, width_m: 1.9, motion: ego, ..Ego::default() };
    (Drive { times, ego: Some(ego), tracks, ..Drive::default() }, signals, keyframe)
}

#[test]
fn agrees_with_the_simulator() {
    let text = include_str!("../../../../examples/counterfactual/pairs.jsonl");
    let mut by_leaf: BTreeMap<String, [usize; 4]> = BTreeMap::new();
    let (mut pairs, mut between, mut ranked, mut rankable) = (0, 0, 0, 0);
    for line in text.lines() {
        let scene: Scene = serde_json::from_str(line).unwrap();
        let (drive, signals, keyframe) = drive(&scene);
        let found = counterfactual(&drive, &signals, keyframe).unwrap();
        let of = |name: &str| {
            let removed = if name == "light" { Removed::Light } else { Removed::Object(name.into()) };
            found.effects.iter().find(|e| e.removed == removed).cloned()
        };
        for (name, farther) in &scene.effects {
            pairs += 1;
            let farther = 0.1 * farther;
            if (UNAFFECTED_M..AFFECTED_M).contains(&farther) {
                between += 1;
                continue;
            }
            let affected = farther >= AFFECTED_M;
            let says = of(name).is_some_and(|e| !e.is_none());
            let row = by_leaf.entry(scene.leaf.clone()).or_default();
            row[2 * usize::from(affected)] += usize::from(says == affected);
            row[2 * usize::from(affected) + 1] += 1;
            if says != affected {
                println!(
                    "{} {} {name}: simulator {farther:.1} m, model {:?}",
                    scene.leaf,
                    scene.driver,
                    of(name)
                );
            }
        }
        let most =
            scene.effects.iter().max_by(|a, b| a.1.total_cmp(b.1)).filter(|(_, m)| **m >= 10.0 * AFFECTED_M);
        if let Some((name, _)) = most {
            rankable += 1;
            let first = found.effects.first().map(|e| e.removed.clone());
            let wanted = if name == "light" { Removed::Light } else { Removed::Object(name.as_str().into()) };
            ranked += usize::from(first == Some(wanted));
        }
    }
    println!("{:<12} {:>12} {:>12}", "leaf", "affected", "unaffected");
    let (mut right, mut all) = (0, 0);
    for (leaf, [u, un, a, an]) in &by_leaf {
        println!("{leaf:<12} {:>12} {:>12}", format!("{a}/{an}"), format!("{u}/{un}"));
        right += u + a;
        all += un + an;
    }
    println!(
        "{right} of {all} ({pairs} pairs, {between} between the bounds); the largest effect ranked first in {ranked} of {rankable}"
    );
    assert!(pairs >= 500, "{pairs}");
    assert!(right as f64 >= 0.95 * all as f64, "{right} of {all}");
    assert!(ranked as f64 >= 0.95 * rankable as f64, "{ranked} of {rankable}");
}
