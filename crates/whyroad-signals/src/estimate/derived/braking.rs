//! Emergency braking by the system, where the bus does not state it: the car brakes hard and suddenly although the
//! driver's foot is not on the brake. The pedals alone show whether the driver or the system braked hard; the
//! deceleration alone shows that there was no hard braking.

use whyroad_model::Nanos;
use whyroad_model::scene::Ego;

/// The system decelerates by 4 m/s2 and more while it is active (taxonomy, aeb), m/s2.
const HARD_MPS2: f64 = -4.0;
/// Hard braking begins where the deceleration exceeds this, m/s2.
const BRAKES_MPS2: f64 = -2.0;
/// Systems increase the deceleration faster than nearly all drivers, m/s3.
const SUDDEN_MPS3: f64 = -10.0;
/// Time from the beginning of braking in which the jerk is searched, and before it in which the pedals are, s.
const ONSET_S: f64 = 1.0;
/// Minimum throttle position that is pressed, as a share.
const PRESSED: f64 = 0.05;

/// `ego.aeb` by frame: false where the car does not brake hard or the driver does, true where it brakes hard and
/// suddenly with the driver's foot on the throttle or off the brake, otherwise unknown.
pub(super) fn emergency(ego: &Ego, times: &[Nanos]) -> Vec<Option<bool>> {
    let accel = &ego.motion.accel;
    let n = accel.len().min(times.len());
    let mut out: Vec<Option<bool>> =
        (0..n).map(|i| (accel[i].is_finite() && accel[i] > BRAKES_MPS2).then_some(false)).collect();
    let brakes = |j: usize| accel[j] <= BRAKES_MPS2;
    let mut i = 0;
    while i < n {
        if !brakes(i) {
            i += 1;
            continue;
        }
        let end = (i..n).find(|&j| !brakes(j)).unwrap_or(n);
        let hard = accel[i..end].iter().any(|a| *a <= HARD_MPS2);
        let activated = if hard { by_system(ego, times, i..end) } else { Some(false) };
        out[i..end].fill(activated);
        i = end;
    }
    out
}

/// Whether the system began the hard braking in these frames.
fn by_system(ego: &Ego, times: &[Nanos], braking: std::ops::Range<usize>) -> Option<bool> {
    let near = |j: &usize| times[*j].seconds_since(times[braking.start]).abs() <= ONSET_S;
    let accel = &ego.motion.accel;
    let jerk = |j: usize| (accel[j] - accel[j - 1]) / times[j].seconds_since(times[j - 1]).max(1e-3);
    let sudden = (1..braking.end).filter(near).any(|j| jerk(j) <= SUDDEN_MPS3);
    let before = |j: &usize| *j <= braking.start && near(j);
    let on_throttle = ego
        .bus
        .throttle
        .get(braking.start)
        .map(|t| *t > PRESSED)
        .filter(|_| ego.bus.throttle[braking.start].is_finite());
    let brakes_before = (0..braking.end)
        .filter(before)
        .filter_map(|j| ego.bus.brake.get(j).copied().flatten())
        .reduce(|a, b| a || b);
    let never_brakes = {
        let stated: Vec<bool> =
            braking.clone().filter_map(|j| ego.bus.brake.get(j).copied().flatten()).collect();
        (!stated.is_empty()).then(|| stated.iter().all(|pressed| !pressed))
    };
    match (on_throttle, brakes_before, never_brakes) {
        // The foot is still on the throttle, or is never on the brake.
        (Some(true), _, _) | (_, Some(false), Some(true)) => sudden.then_some(true),
        // The driver was braking already.
        (_, Some(true), _) => Some(false),
        _ => None,
    }
}
