use super::*;
use whyroad_model::scene::Ego;
use whyroad_model::{DriveId, Nanos, ObjectClass};

/// 100 s at 10 Hz: the ego and twenty objects at 10 m/s, each in its own lane.
fn drive() -> Drive {
    let n = 1000;
    let motion = |y: f64| Motion {
        x: (0..n).map(|i| i as f64).collect(),
        y: vec![y; n],
        z: vec![0.0; n],
        heading: vec![0.0; n],
        vx: vec![10.0; n],
        vy: vec![0.0; n],
        ..Motion::unknown(n)
    };
    let track = |k: usize| Track {
        id: TrackId::from(format!("t{k:02}").as_str()),
        class: ObjectClass::Car,
        frames: (0..n as u32).collect(),
        motion: motion(k as f64 * 3.5),
        length_m: vec![4.5; n],
        width_m: vec![1.8; n],
        height_m: vec![1.5; n],
        interior_points: vec![f64::NAN; n],
        ..Track::default()
    };
    let mut out = Drive {
        times: (0..n as i64).map(|i| Nanos(i * 100_000_000)).collect(),
        ego: Some(Ego { length_m: 4.5, width_m: 1.8, motion: motion(-3.5), ..Ego::default() }),
        tracks: (0..20).map(track).collect(),
        ..Drive::default()
    };
    out.meta.drive_id = DriveId::from("d");
    out
}

fn sd(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    f64::sqrt(sum / n)
}

#[test]
fn noise_has_the_stated_size_and_correlation() {
    let clean = drive();
    for (how, over_a_frame) in [(Perturbation::White, 0.0), (Perturbation::Correlated, (-0.1f64).exp())] {
        let noisy = perturb(&clean, how, 1).drive;
        let off: Vec<f64> =
            noisy.tracks.iter().flat_map(|t| t.motion.y.iter().map(|y| y - t.motion.y[0])).collect();
        assert!(off.iter().any(|v| *v != 0.0));
        let mut own = Vec::new();
        let mut products = Vec::new();
        for (a, b) in noisy.tracks.iter().zip(&clean.tracks) {
            let e: Vec<f64> = a.motion.x.iter().zip(&b.motion.x).map(|(a, b)| a - b).collect();
            products.extend(e.windows(2).map(|w| w[0] * w[1] / (POSITION_M * POSITION_M)));
            own.extend(e);
        }
        assert!((sd(own.into_iter()) - POSITION_M).abs() < 0.02, "{how:?}");
        let mean = products.iter().sum::<f64>() / products.len() as f64;
        assert!((mean - over_a_frame).abs() < 0.1, "{how:?}: {mean}");
        let heading = sd(noisy.tracks.iter().flat_map(|t| t.motion.heading.iter().copied()));
        assert!((heading - HEADING_RAD).abs() < 0.004, "{heading}");
        let speed = sd(noisy.tracks.iter().flat_map(|t| t.motion.vx.iter().map(|v| v - 10.0)));
        assert!((speed - VELOCITY_MPS).abs() < 0.03, "{speed}");
        assert_eq!(noisy.ego.unwrap().motion.x, clean.ego.as_ref().unwrap().motion.x, "the ego is as it was");
    }
    let of_ego = perturb(&clean, Perturbation::EgoWhite, 1).drive;
    assert_eq!(of_ego.tracks[3].motion.x, clean.tracks[3].motion.x);
    assert_ne!(of_ego.ego.unwrap().motion.x, clean.ego.unwrap().motion.x);
}

#[test]
fn rows_are_lost_and_ids_break_at_the_stated_rates() {
    let clean = drive();
    let dropped = perturb(&clean, Perturbation::Drops, 1).drive;
    let rows: usize = dropped.tracks.iter().map(|t| t.frames.len()).sum();
    assert!((rows as f64 / 20_000.0 - 0.9).abs() < 0.01, "{rows}");
    let t = &dropped.tracks[0];
    assert!(
        t.frames.iter().zip(&t.motion.x).all(|(f, x)| f64::from(*f) == *x),
        "rows stay with their frames"
    );

    let broken = perturb(&clean, Perturbation::IdBreaks, 1);
    // Twenty objects for 100 s, 0.1 breaks a second: 200, except for rows lost at breaks.
    let breaks = broken.drive.tracks.len() - 20;
    assert!((150..=230).contains(&breaks), "{breaks}");
    assert_eq!(broken.original.len(), breaks);
    assert!(broken.drive.tracks.windows(2).all(|w| w[0].id < w[1].id), "ordered by id");
    assert!(broken.original.values().all(|id| clean.track(id).is_some()));
}

#[test]
fn a_lower_rate_is_what_ingest_makes_of_it() {
    let mut clean = drive();
    // Braking at 2 m/s2 along x: between samples the line lies below the parabola.
    let x = |f: f64| 20.0 * f - 0.01 * f * f;
    clean.tracks[0].motion.x = (0..1000).map(|i| x(f64::from(i))).collect();
    let slow = perturb(&clean, Perturbation::TwoHertz, 1).drive;
    let at = |f: usize| slow.tracks[0].motion.x[f];
    assert_eq!(at(10), x(10.0));
    assert!((at(12) - (0.6 * x(10.0) + 0.4 * x(15.0))).abs() < 1e-9);
    assert_eq!(slow.tracks[0].frames.last(), Some(&995), "nothing after the last sample");
}

#[test]
fn the_same_seed_gives_the_same_drive_and_another_seed_another() {
    let clean = drive();
    for how in Perturbation::ALL {
        let text = |seed| format!("{:?}", perturb(&clean, how, seed).drive.tracks);
        assert_eq!(text(7), text(7), "{how:?}");
        assert_eq!(Perturbation::from_name(how.name()), Some(how));
    }
    let text = |seed| format!("{:?}", perturb(&clean, Perturbation::White, seed).drive.tracks);
    assert_ne!(text(7), text(8));
    // The numbers drawn for an object do not depend on the other objects.
    let mut alone = clean.clone();
    alone.tracks.truncate(1);
    let [a, b] =
        [&clean, &alone].map(|d| perturb(d, Perturbation::White, 7).drive.tracks[0].motion.x.clone());
    assert_eq!(a, b);
}
