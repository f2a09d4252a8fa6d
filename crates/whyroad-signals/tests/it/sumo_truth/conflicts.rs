//! TTC, DRAC and PET compared with SUMO's surrogate safety measures, by encounter type. Where SUMO's definition equals
//! ours (following), values are compared frame by frame; where it differs (crossing, merging), per conflict.

use super::errors::Errors;
use super::simulation::{Conflict, Derived, Simulation, Step, Vehicle};
use super::{GRID_RUN, MOTORWAY_RUN, Run, Tally};

/// Maximum time that is compared, s.
const LONGEST_S: f64 = 20.0;
/// A vehicle that turns by more than this within 6 s does not keep its velocity vector, deg.
const TURNING_DEG: f64 = 20.0;

struct Following {
    tally: Tally,
    /// Relative, frame by frame.
    ttc: Errors,
    drac: Errors,
    /// At the extremes of each conflict, s and m/s2.
    min_ttc: Errors,
    max_drac: Errors,
}

fn following(run: &Run) -> Following {
    let s = &run.truth;
    let new = Errors::default;
    let mut f =
        Following { tally: Tally::default(), ttc: new(), drac: new(), min_ttc: new(), max_drac: new() };
    for c in &s.conflicts {
        let d = &run.seen_from[c.ego.as_str()];
        for (i, &step) in c.steps.iter().enumerate().filter(|&(i, _)| c.types[i] == 2) {
            let (Some(ttc), Some(drac)) = (c.ttc[i].filter(|t| *t <= LONGEST_S), c.drac[i]) else { continue };
            let Some(ours) = d.target("target.ttc", &c.foe, step) else {
                f.tally.add("not in the log");
                continue;
            };
            if ours.is_infinite() {
                f.tally.add("theirs only");
                continue;
            }
            f.tally.add("both");
            f.ttc.add((ours - ttc) / ttc);
            f.drac.add(d.target("target.drac", &c.foe, step).unwrap_or(f64::NAN) - drac);
        }
        let at = |name: &str, step: Step| d.target(name, &c.foe, step).unwrap_or(f64::NAN);
        if let Some((step, 2, value)) = c.min_ttc {
            f.min_ttc.add(at("target.ttc", step) - value);
        }
        if let Some((step, 2, value)) = c.max_drac {
            f.max_drac.add(at("target.drac", step) - value);
        }
    }
    println!("following, {}: {}", s.name, f.tally.line());
    println!("  TTC by frame, relative: {}", f.ttc.line());
    println!("  DRAC by frame: {} m/s2", f.drac.line());
    println!("  minTTC by conflict: {} s", f.min_ttc.line());
    println!("  maxDRAC by conflict: {} m/s2", f.max_drac.line());
    f
}

#[test]
fn following_on_the_motorway() {
    let f = following(&MOTORWAY_RUN);
    assert!(f.tally.get("both") > 500 && f.tally.share(&["both"]) > 0.99, "{}", f.tally.line());
    assert!(
        f.ttc.quantile(0.99) < 0.05 && f.drac.quantile(0.99) < 0.05,
        "{} {}",
        f.ttc.line(),
        f.drac.line()
    );
    assert!(f.min_ttc.len() >= 10 && f.min_ttc.quantile(1.0) < 0.1, "{}", f.min_ttc.line());
    assert!(f.max_drac.quantile(1.0) < 0.1, "{}", f.max_drac.line());
}

#[test]
fn following_on_the_grid() {
    let f = following(&GRID_RUN);
    assert!(f.tally.get("both") > 1000 && f.tally.share(&["both"]) > 0.98, "{}", f.tally.line());
    assert!(f.ttc.quantile(0.5) < 0.02 && f.ttc.quantile(0.9) < 0.15, "{}", f.ttc.line());
    assert!(f.drac.quantile(0.9) < 0.15, "{}", f.drac.line());
    assert!(f.min_ttc.len() >= 15 && f.min_ttc.quantile(0.5) < 0.05, "{}", f.min_ttc.line());
}

/// True when the vehicle turns within 6 s.
fn turns(s: &Simulation, id: &str, step: Step) -> bool {
    let Some(now) = s.vehicle(step, id) else { return false };
    let turned = |v: &Vehicle| ((v.angle_deg - now.angle_deg + 540.0).rem_euclid(360.0) - 180.0).abs();
    (step..=step + 60).filter_map(|t| s.vehicle(t, id)).any(|v| turned(v) > TURNING_DEG)
}

/// Whether the two are at the crossing of their paths at the same time when both keep speed and direction: computed
/// here from FCD alone, as two strips that cross. `None` when the paths do not cross.
fn meet_at_constant_speed(s: &Simulation, derived: &Derived, c: &Conflict, step: Step) -> Option<bool> {
    let (a, b) = (s.vehicle(step, &c.ego)?, s.vehicle(step, &c.foe)?);
    let own = derived.drive.ego.as_ref()?;
    let track = derived.drive.track(&whyroad_model::TrackId::from(c.foe.as_str()))?;
    let direction = |v: &Vehicle| v.angle_deg.to_radians().sin_cos();
    let ((ax, ay), (bx, by)) = (direction(a), direction(b));
    let cross = ax * by - ay * bx;
    if cross.abs() < 0.5 {
        return None;
    }
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    // Distance of each front from the point where the paths cross.
    let (to_a, to_b) = ((dx * by - dy * bx) / cross, (dx * ay - dy * ax) / cross);
    let there = |way: f64, speed: f64, length: f64, other_width: f64| {
        let half = other_width / 2.0;
        ((way - half) / speed.max(0.01), (way + half + length) / speed.max(0.01))
    };
    let (a_in, a_out) = there(to_a, a.speed, own.length_m, track.width_m[0]);
    let (b_in, b_out) = there(to_b, b.speed, track.length_m[0], own.width_m);
    Some(a_in.max(b_in) <= a_out.min(b_out) && a_out > 0.0 && b_out > 0.0)
}

/// Our minimum contact time within half a second of SUMO's minimum, along the path or of the boxes.
fn contact(d: &Derived, c: &Conflict, step: Step) -> Option<f64> {
    let values = ["target.ttc_box", "target.ttc"]
        .into_iter()
        .flat_map(|name| (step - 5..=step + 5).filter_map(move |t| d.target(name, &c.foe, t)));
    values.reduce(f64::min)
}

/// By the later motion of the two: both straight and at the crossing together at constant speed, both straight and not
/// together (the simulator predicts its drivers' accelerations), or one of them turning.
const KINDS: [&str; 3] = ["meet at constant speed", "do not meet at constant speed", "one turns or follows"];

#[test]
fn crossing_and_merging_on_the_grid() {
    let s = &GRID_RUN.truth;
    for (name, codes) in [("crossing", &[10, 11, 12, 13][..]), ("merging", &[6, 7][..])] {
        let mut tallies = [Tally::default(), Tally::default(), Tally::default()];
        let mut errors = [Errors::default(), Errors::default(), Errors::default()];
        for c in &s.conflicts {
            let Some((step, _, theirs)) = c.min_ttc.filter(|m| codes.contains(&m.1) && m.2 <= 6.0) else {
                continue;
            };
            let derived = &GRID_RUN.seen_from[c.ego.as_str()];
            let is_turning = turns(s, &c.ego, step) || turns(s, &c.foe, step);
            let kind = match meet_at_constant_speed(s, derived, c, step).filter(|_| !is_turning) {
                Some(true) => 0,
                Some(false) => 1,
                None => 2,
            };
            tallies[kind].add(match contact(derived, c, step) {
                None => "not in the log",
                Some(ours) if ours.is_finite() => {
                    errors[kind].add(ours - theirs);
                    "both"
                }
                Some(_) => "theirs only",
            });
        }
        for (i, kind) in KINDS.iter().enumerate() {
            println!("{name}, {kind}: {}; minTTC by conflict: {} s", tallies[i].line(), errors[i].line());
        }
        if name == "crossing" {
            assert!(
                tallies[0].get("both") >= 8 && tallies[0].share(&["both"]) > 0.9,
                "{}",
                tallies[0].line()
            );
            assert!(errors[0].quantile(0.5) < 0.4 && errors[0].quantile(1.0) < 1.2, "{}", errors[0].line());
        }
        let all: usize = tallies.iter().map(Tally::total).sum();
        assert!(all >= 6, "{name}: only {all} conflicts compared");
    }
}

#[test]
fn post_encroachment_on_the_grid() {
    let (mut tally, mut errors) = (Tally::default(), Errors::default());
    for c in &GRID_RUN.truth.conflicts {
        // Ours ends at 10 s.
        let Some((_, _, theirs)) = c.pet.filter(|p| p.2 <= 9.5) else { continue };
        let d = &GRID_RUN.seen_from[c.ego.as_str()];
        match c.steps.iter().filter_map(|&t| d.target("target.pet", &c.foe, t)).reduce(f64::min) {
            None => tally.add("not in the log"),
            Some(ours) if ours.is_finite() => {
                tally.add("both");
                errors.add(ours - theirs);
            }
            Some(_) => tally.add("theirs only"),
        }
    }
    println!("PET, grid: {}; {} s", tally.line(), errors.line());
    assert!(tally.get("both") >= 10 && tally.share(&["both"]) > 0.9, "{}", tally.line());
    assert!(errors.quantile(0.5) < 0.35 && errors.quantile(1.0) < 1.2, "{}", errors.line());
}
