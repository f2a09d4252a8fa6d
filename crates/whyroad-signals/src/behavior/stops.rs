//! Standing and moving off of the ego and of targets: duration, number, end.

use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// Stops are counted over this time, s.
const COUNT_OVER_S: f64 = 60.0;
/// The mean speed is taken over this time, s.
const MEAN_OVER_S: f64 = 20.0;
/// ... with at least this much of it known, s.
const MEAN_LEAST_S: f64 = 1.0;
/// Minimum duration of a standstill that ends in moving off, s.
const STOOD_LEAST_S: f64 = 1.0;
/// Moving off is reported for this long, s.
const PULSE_S: f64 = 1.0;
/// Maximum mean speed of stop and go: 30 km/h (LABELING.md 4).
const CONGESTED_MPS: f64 = 30.0 / 3.6;
/// Maximum time since the last lead for stop and go, s.
const LEAD_WITHIN_S: f64 = 5.0;

/// Standstill over the rows of one actor.
pub struct Standing {
    /// Seconds since it stopped; 0 while it moves, NaN where unknown.
    pub time: Vec<f64>,
    /// Within [`PULSE_S`] after a standstill of at least [`STOOD_LEAST_S`].
    pub moves_off: Vec<Tri>,
    /// The current or last standstill: its duration in seconds (so far), the row's time since its end (0 during it),
    /// and whether it was already in progress in the first row.
    pub last: Vec<Option<(f64, f64, bool)>>,
}

impl Standing {
    /// From the standstill flag over rows at `times` (s).
    pub fn new(times: &[f64], standstill: &[Tri]) -> Self {
        let n = times.len();
        let mut found =
            Self { time: vec![f64::NAN; n], moves_off: vec![Tri::Unknown; n], last: vec![None; n] };
        // Start of the standstill, and whether it had begun by the first row.
        let mut since: Option<(f64, bool)> = None;
        let mut ended: Option<(f64, f64, bool)> = None;
        for i in 0..n {
            match standstill[i] {
                Tri::Unknown => (since, ended) = (None, None),
                Tri::True => {
                    let (from, whole) = *since.get_or_insert((times[i], i == 0));
                    found.time[i] = times[i] - from;
                    found.moves_off[i] = Tri::False;
                    found.last[i] = Some((times[i] - from, 0.0, whole));
                }
                Tri::False => {
                    if let Some((from, whole)) = since.take() {
                        ended = Some((times[i] - from, times[i], whole));
                    }
                    found.time[i] = 0.0;
                    let moved_off = |&(lasted, at, _): &(f64, f64, bool)| {
                        lasted >= STOOD_LEAST_S - 1e-6 && times[i] - at < PULSE_S - 1e-6
                    };
                    found.moves_off[i] = Tri::from(ended.as_ref().is_some_and(moved_off));
                    found.last[i] = ended.map(|(lasted, at, whole)| (lasted, times[i] - at, whole));
                }
            }
        }
        found
    }
}

/// Standstill of all targets.
pub fn targets_standing(scene: &Interaction<'_>) -> Vec<Standing> {
    scene.targets.iter().map(|t| Standing::new(&t.times, &t.standstill)).collect()
}

/// Mean of `values` over the frames of the last `over` seconds, each weighted by the time until the next; NaN where
/// less than [`MEAN_LEAST_S`] of it is known.
fn mean_over(times: &[f64], values: &[f64], over: f64) -> Vec<f64> {
    let mut first = 0;
    (0..times.len())
        .map(|i| {
            while times[i] - times[first] > over {
                first += 1;
            }
            mean_of(&times[first..=i], &values[first..=i])
        })
        .collect()
}

/// Mean of `values`, each weighted by the time until the next; the last one has none.
fn mean_of(times: &[f64], values: &[f64]) -> f64 {
    let (mut sum, mut known) = (0.0, 0.0);
    for (time, value) in times.windows(2).zip(values) {
        let lasts = time[1] - time[0];
        if !value.is_nan() && lasts <= crate::series::GAP_S {
            sum += value * lasts;
            known += lasts;
        }
    }
    if known >= MEAN_LEAST_S - 1e-6 { sum / known } else { f64::NAN }
}

/// Writes `ego.stop_count`, `stop_and_go`, `mean_speed`, `time_standing`, `moves_off`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (ego, times) = (scene.around.ego, scene.times);
    let n = ego.len();
    let standing = Standing::new(times, &ego.standstill);
    let begins: Vec<usize> = (0..n)
        .filter(|&i| ego.standstill[i].is_true() && (i == 0 || !ego.standstill[i - 1].is_true()))
        .collect();
    let recent =
        |i: usize| begins.iter().copied().filter(move |&b| b <= i && times[i] - times[b] <= COUNT_OVER_S);
    let known = |i: usize| ego.standstill[i] != Tri::Unknown;
    let count = |i: usize| if known(i) { recent(i).count() as f64 } else { f64::NAN };
    let with_lead = |i: usize| {
        (0..=i)
            .rev()
            .take_while(|&j| times[i] - times[j] <= LEAD_WITHIN_S)
            .any(|j| scene.near.lead[j].is_some())
    };
    let stop_and_go = |i: usize| {
        if !known(i) {
            return Tri::Unknown;
        }
        let Some(first) = recent(i).next().filter(|_| recent(i).count() >= 2) else { return Tri::False };
        // Stops are counted over the same time as the mean.
        let slow = mean_of(&times[first..=i], &ego.speed[first..=i]) < CONGESTED_MPS;
        Tri::from(slow && with_lead(i))
    };
    table.number(id::EGO_STOP_COUNT, (0..n).map(count).collect());
    table.flag(id::EGO_STOP_AND_GO, (0..n).map(stop_and_go).collect());
    table.number(id::EGO_MEAN_SPEED, mean_over(times, &ego.speed, MEAN_OVER_S));
    table.number(id::EGO_TIME_STANDING, standing.time);
    table.flag(id::EGO_MOVES_OFF, standing.moves_off);
}
