//! Hidden share of the ground beside the path ahead, the object that hides it, and the time until the ego is there.
//! Writes `map.hidden_beside`, `map.hidden_beside_by` and `map.time_to_hidden_beside`.

use super::obstacles::{ObstacleKind, Obstacles};
use super::scene::Scene;
use super::view::{Owner, View};
use crate::geometry::P2;
use crate::road::on_road::time_to;
use crate::table::TableBuilder;
use whyroad_model::catalog::{CategoryValue, id, value::MapHiddenBesideBy};

/// Length of the strip from the front bumper on, m.
const LENGTH_M: f64 = 30.0;
/// Its width, outwards from the edge of the band that the ego sweeps, m.
const WIDTH_M: f64 = 4.0;
/// Margin of the band beside the ego, m; as for `target.gap`.
const MARGIN_M: f64 = 0.3;
/// Sampling step, m.
const STEP_M: f64 = 1.0;
/// Limits of the search for hidden ground ahead, by time and distance, s and m.
const AHEAD_S: f64 = 10.0;
const AHEAD_M: f64 = 100.0;
/// Minimum hidden share for reporting an occluder.
const LEAST_SHARE: f64 = 0.05;

/// What is hidden beside the path by frame.
#[derive(Default)]
pub struct Beside {
    share: Vec<f64>,
    by: Vec<Option<MapHiddenBesideBy>>,
    time: Vec<f64>,
}

impl Beside {
    /// Processes one frame; frames come in order.
    pub fn look(&mut self, frame: usize, view: Option<&View>, scene: &Scene<'_>, obstacles: &Obstacles<'_>) {
        let s = scene.path.ego_s[frame];
        let (length, width) = (scene.ego.length, scene.ego.width);
        let Some(view) = view.filter(|_| s.is_finite() && length.is_finite() && width.is_finite()) else {
            self.share.push(f64::NAN);
            self.by.push(None);
            self.time.push(f64::NAN);
            return;
        };
        let code = |owner: Owner| match obstacles.kind(owner) {
            ObstacleKind::Vehicle => Some(MapHiddenBesideBy::Vehicle),
            ObstacleKind::LargeVehicle => Some(MapHiddenBesideBy::LargeVehicle),
            ObstacleKind::Object => Some(MapHiddenBesideBy::Object),
            ObstacleKind::Building => Some(MapHiddenBesideBy::Building),
            ObstacleKind::Vru => None,
        };
        let (long, wide) = ((LENGTH_M / STEP_M) as usize, (WIDTH_M / STEP_M) as usize);
        let places = (long * wide) as f64;
        let speed = scene.ego.forward_speed[frame];
        let far = (AHEAD_M.min(AHEAD_S * speed.max(0.0)) / STEP_M) as usize;
        // Both sides are sampled at the same positions of the path.
        let mut stations: Vec<Option<(P2, P2)>> = vec![None; long.max(far)];
        let mut station = |i: usize| {
            let at = s + length / 2.0 + (i as f64 + 0.5) * STEP_M;
            let place = || (scene.path.line.point_at(at), scene.path.direction_at(at).left());
            *stations[i].get_or_insert_with(place)
        };
        let counting = view.counting(|owner| code(owner).is_some());
        let mut first_hidden = f64::INFINITY;
        let mut worst = (0.0, MapHiddenBesideBy::None);
        for side in [1.0, -1.0] {
            let mut counts = [0_usize; 5];
            for i in 0..long.max(far) {
                // Beyond the strip only the first hidden position counts, to 2 m.
                if i >= long && (i as f64) * STEP_M >= first_hidden {
                    break;
                }
                if i >= long && i % 2 == 1 {
                    continue;
                }
                let (on, left) = station(i);
                for j in 0..wide {
                    let away = width / 2.0 + MARGIN_M + (j as f64 + 0.5) * STEP_M;
                    let first = counting.before(on + left * (side * away));
                    if let Some(code) = first.and_then(code) {
                        first_hidden = first_hidden.min(i as f64 * STEP_M);
                        counts[usize::from(code.code())] += usize::from(i < long);
                    }
                }
            }
            let share = counts.iter().sum::<usize>() as f64 / places;
            let most = [
                MapHiddenBesideBy::Building,
                MapHiddenBesideBy::Object,
                MapHiddenBesideBy::LargeVehicle,
                MapHiddenBesideBy::Vehicle,
            ]
            .into_iter()
            .max_by_key(|c| counts[usize::from(c.code())]);
            if share > worst.0 {
                worst = (share, most.unwrap_or(MapHiddenBesideBy::None));
            }
        }
        self.time.push(time_to(first_hidden, speed));
        self.share.push(worst.0);
        self.by.push(Some(if worst.0 < LEAST_SHARE { MapHiddenBesideBy::None } else { worst.1 }));
    }

    /// Writes the signals of this file.
    pub fn write(self, table: &mut TableBuilder<'_>) {
        table.number(id::MAP_HIDDEN_BESIDE, self.share);
        table.category(id::MAP_HIDDEN_BESIDE_BY, self.by);
        table.number(id::MAP_TIME_TO_HIDDEN_BESIDE, self.time);
    }
}
