//! The ego's speed on the same kind of road in fair conditions, on the same drive: the reference for a lower speed in
//! rain, in the dark or on a wet road.

use crate::road::context::Channels;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::catalog::id;

/// Values that count as fair, by kind of context in the log.
const FAIR: [(&str, &str); 3] = [("weather", "clear"), ("surface", "dry"), ("lighting", "day")];
/// Minimum speed of cruising, m/s.
const CRUISING_MPS: f64 = 5.0;
/// Maximum acceleration of cruising, m/s2.
const STEADY_MPS2: f64 = 0.5;
/// A lead within this headway determines the speed, s.
const FREE_HEADWAY_S: f64 = 3.0;
/// Roads whose limits differ by less are of the same kind, m/s.
const SAME_LIMIT_MPS: f64 = 0.5;
/// Minimum number of frames: 3 s at 10 Hz.
const LEAST_FRAMES: usize = 30;

/// Writes `ego.fair_speed` where the log states weather, surface or lighting.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let ego = scene.around.ego;
    let channels = Channels::new(scene.drive);
    let stated: Vec<_> = FAIR.iter().filter(|(kind, _)| channels.has(kind)).collect();
    if stated.is_empty() {
        return;
    }
    let mut fair = vec![true; ego.len()];
    for (kind, wanted) in stated {
        for (flag, value) in fair.iter_mut().zip(channels.values(kind)) {
            *flag &= value == Some(wanted);
        }
    }
    let limits = table.numbers(id::MAP_SPEED_LIMIT).map(<[f64]>::to_vec);
    let headways = table.numbers(id::LEAD_THW).map(<[f64]>::to_vec);
    let limit = |i: usize| limits.as_ref().map_or(f64::NAN, |l| l[i]);
    let free = |i: usize| headways.as_ref().is_none_or(|h| h[i].is_nan() || h[i] > FREE_HEADWAY_S);
    let cruises = |i: &usize| {
        let i = *i;
        fair[i] && ego.speed[i] > CRUISING_MPS && ego.accel[i].abs() < STEADY_MPS2 && free(i)
    };
    let samples: Vec<(f64, f64)> = (0..ego.len()).filter(cruises).map(|i| (limit(i), ego.speed[i])).collect();
    let usual = |limit: f64| {
        let same = |l: f64| (l.is_nan() && limit.is_nan()) || (l - limit).abs() < SAME_LIMIT_MPS;
        let mut speeds: Vec<f64> = samples.iter().filter(|(l, _)| same(*l)).map(|(_, v)| *v).collect();
        speeds.sort_by(f64::total_cmp);
        if speeds.len() < LEAST_FRAMES { f64::NAN } else { speeds[speeds.len() / 2] }
    };
    // One value per limit.
    let mut known: Vec<(f64, f64)> = Vec::new();
    let values = (0..ego.len()).map(|i| {
        let here = limit(i);
        if let Some((_, v)) = known.iter().find(|(l, _)| l.to_bits() == here.to_bits()) {
            return *v;
        }
        let value = usual(here);
        known.push((here, value));
        value
    });
    let values = values.collect();
    table.number(id::EGO_FAIR_SPEED, values);
}
