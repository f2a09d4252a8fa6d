//! Signals that are asked for alone have the values that they have among all.

use crate::scene::drive;
use crate::whole::full;
use std::collections::BTreeSet;
use whyroad_model::scene::Motion;
use whyroad_model::{Column, Drive, SignalTable};
use whyroad_signals::{Catalog, Wanted, derive, derive_wanted};

/// The same with places that are a few centimeters off and states that have to be estimated.
fn noisy(mut drive: Drive) -> Drive {
    let blur = |m: &mut Motion, seed: f64| {
        for i in 0..m.len() {
            m.x[i] += 0.06 * (17.3 * i as f64 + seed).sin();
            m.y[i] += 0.06 * (29.1 * i as f64 + seed).cos();
            m.heading[i] += 0.01 * (11.7 * i as f64 + seed).sin();
        }
        for states in [&mut m.vx, &mut m.vy, &mut m.accel, &mut m.yaw_rate] {
            states.fill(f64::NAN);
        }
        m.forward.clear();
    };
    if let Some(ego) = &mut drive.ego {
        blur(&mut ego.motion, 0.5);
    }
    for (k, track) in drive.tracks.iter_mut().enumerate() {
        blur(&mut track.motion, 1.0 + k as f64);
    }
    drive
}

/// What is said of a signal: its values and their deviations by their bits, or what it lacks.
fn said(table: &SignalTable, name: &str) -> String {
    let values = |name: &str| {
        let column = table.frame_columns.get(name).or_else(|| table.target_columns.get(name));
        match column {
            Some(Column::Number(v)) => format!("{:?}", v.iter().map(|x| x.to_bits()).collect::<Vec<_>>()),
            other => format!("{other:?}"),
        }
    };
    format!("{} {} {:?}", values(name), values(&format!("{name}.sd")), table.unavailable.get(name))
}

fn names(table: &SignalTable) -> BTreeSet<&str> {
    let columns = table.frame_columns.keys().chain(table.target_columns.keys());
    let signals = columns.map(|name| name.strip_suffix(".sd").unwrap_or(name));
    signals.chain(table.unavailable.keys().map(String::as_str)).collect()
}

#[test]
fn each_signal_alone_is_what_it_is_among_all() {
    let without_ego = Drive { ego: None, ..full() };
    let drives = [full(), noisy(full()), drive(30, |t| (5.0 * t, 0.0, 0.0)), without_ego, Drive::default()];
    let mut deviations = 0;
    for drive in &drives {
        let all = derive(drive);
        deviations +=
            all.target_columns.keys().chain(all.frame_columns.keys()).filter(|n| n.ends_with(".sd")).count();
        let mut count = 0;
        for def in Catalog::bundled().iter().filter(|d| !d.scope.is_on_demand()) {
            let name = def.name.as_str();
            let alone = derive_wanted(drive, &Wanted::only([name]));
            assert_eq!(said(&alone, name), said(&all, name), "{name}");
            assert_eq!(names(&alone), BTreeSet::from([name]));
            assert_eq!((&alone.times, &alone.targets), (&all.times, &all.targets), "{name}");
            count += 1;
        }
        assert_eq!(count, names(&all).len(), "every signal was asked for");
    }
    assert!(deviations > 30, "the noisy drive has estimated signals: {deviations}");
}

#[test]
fn several_signals_are_those_asked_for_and_no_others() {
    let all = derive(&noisy(full()));
    let asked = ["ego.speed", "lead.ttc", "target.pet", "target.refav_following", "no.signal"];
    let some = derive_wanted(&noisy(full()), &Wanted::only(asked));
    assert_eq!(names(&some), asked[..4].iter().copied().collect());
    for name in &asked[..4] {
        assert_eq!(said(&some, name), said(&all, name), "{name}");
    }
    let nothing = derive_wanted(&full(), &Wanted::only([]));
    assert!(names(&nothing).is_empty());
}
