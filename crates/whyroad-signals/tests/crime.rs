//! Gap, time headway and TTC against commonroad-crime 0.4.5 on a scene where its definitions and ours agree
//! (examples/truth/crime: the scene and its values, made by `make.py`; expected values are CriMe's).

mod scene;

use std::path::Path;
use whyroad_model::ObjectClass;

#[test]
fn headway_time_headway_and_ttc_are_crimes() {
    // The scene of make.py: centres, speeds and sizes; the ego's size is the helper's unless set.
    let mut drive = scene::drive(60, |t| (15.0 * t, 0.0, 0.0));
    let ego = drive.ego.as_mut().expect("an ego");
    (ego.length_m, ego.width_m) = (4.6, 1.8);
    scene::add(&mut drive, "200", ObjectClass::Truck, (12.0, 2.4), |t| (45.0 + 10.0 * t, 0.0, 0.0));
    scene::add(&mut drive, "300", ObjectClass::Motorcycle, (2.2, 0.9), |t| (30.0 + 17.0 * t, 0.0, 0.0));
    let table = whyroad_signals::derive(&drive);

    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth/crime/crime.csv");
    let text = std::fs::read_to_string(file).expect("the committed values");
    let mut compared = 0;
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let frame: usize = cells[0].parse().expect("a step");
        let target = table.targets.iter().find(|t| t.id.as_str() == cells[1]).expect("the vehicle");
        let ours =
            |name: &str| table.target_columns[name].number(target.row(frame).expect("seen")).expect("known");
        let theirs = |i: usize| cells[i].parse::<f64>().expect("a number");
        assert!((ours("target.gap") - theirs(2)).abs() < 1e-3, "{line}: {}", ours("target.gap"));
        // CriMe's is the first step of 0.1 s at which the ego is there.
        let late = theirs(3) - ours("target.thw");
        assert!((-1e-6..0.1).contains(&late), "{line}: {}", ours("target.thw"));
        // Infinite on both sides, or equal to CriMe's rounding.
        let ttc = (ours("target.ttc"), theirs(4));
        assert!(ttc.0 == ttc.1 || (ttc.0 - ttc.1).abs() < 0.006, "{line}: {ttc:?}");
        compared += 1;
    }
    assert_eq!(compared, 20);
}
