//! Whether the vehicles of a log drive on the network that is taken for its map: a network of another run is not used,
//! even if the name matches.

use super::fcd::Fcd;
use super::vehicle_types::IsPerson;
use crate::assemble::angles::wrap_angle;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_3;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Lane, LaneKind, Point3};

/// The front of a vehicle lies this near to a lane's center line, m: half a lane, and as much for a change of lane, for
/// overtaking and for stops beside the road.
const NEAR_M: f64 = 4.0;
/// With less than this share of the probes on the network, it belongs to another log. Of the log's own network a
/// quarter may be missing: cyclists ride where it has no lane.
const OWN: f64 = 0.5;
/// With less than this share, some vehicles drive where the network has no lane.
const WHOLE: f64 = 0.98;
/// Fewer probes than this (those of two vehicles) are not enough. `ingest.map.off` still checks the ego.
const LEAST_PROBES: usize = 40;
/// Probes per vehicle, and maximum in total.
const PER_VEHICLE: usize = 20;
const PROBES: usize = 20_000;
/// Size of the cells by which lanes are looked up, m.
const CELL_M: f64 = 20.0;
/// Longest straight piece of road: a longer one has a point far away, an error of the file, m.
const LONGEST_M: f64 = 100_000.0;

/// How far the vehicles of a log drive on a network.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OnNet {
    /// Positions that were looked at.
    pub probes: usize,
    /// Of them, those on a lane that leads as the vehicle drives.
    pub on_lane: usize,
    /// Description of a vehicle that is not on it.
    pub example: Option<String>,
}

impl OnNet {
    /// Share of the probes on the network; 1 if there are too few.
    fn share(&self) -> f64 {
        if self.probes < LEAST_PROBES { 1.0 } else { self.on_lane as f64 / self.probes as f64 }
    }

    /// The network belongs to another log.
    pub fn is_foreign(&self) -> bool {
        self.share() < OWN
    }

    /// Some vehicles drive where the network has no lane.
    pub fn is_partial(&self) -> bool {
        !self.is_foreign() && self.share() < WHOLE
    }
}

type Cell = (i64, i64);

fn cell(x: f64, y: f64) -> Cell {
    ((x / CELL_M).floor() as i64, (y / CELL_M).floor() as i64)
}

/// Segments of lanes by the cells that they come near.
struct Segments<'a> {
    by_cell: HashMap<Cell, Vec<[&'a Point3; 2]>>,
}

impl<'a> Segments<'a> {
    fn new(map: &'a RoadMap) -> Self {
        let mut by_cell: HashMap<Cell, Vec<[&Point3; 2]>> = HashMap::new();
        let rolls = |l: &&Lane| l.kind != LaneKind::Sidewalk;
        for w in map.lanes.iter().filter(rolls).flat_map(|l| l.center.windows(2)) {
            let (a, b) = (&w[0], &w[1]);
            let length = (b.x - a.x).hypot(b.y - a.y);
            if length.is_nan() || length > LONGEST_M {
                continue;
            }
            let pieces = (length / CELL_M).ceil().max(1.0) as usize;
            let at = |k: usize| {
                let share = k as f64 / pieces as f64;
                (a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
            };
            for (from, to) in (0..pieces).map(|k| (at(k), at(k + 1))) {
                let low = cell(from.0.min(to.0) - NEAR_M, from.1.min(to.1) - NEAR_M);
                let high = cell(from.0.max(to.0) + NEAR_M, from.1.max(to.1) + NEAR_M);
                for x in low.0..=high.0 {
                    for y in low.1..=high.1 {
                        by_cell.entry((x, y)).or_default().push([a, b]);
                    }
                }
            }
        }
        Self { by_cell }
    }

    /// True when a lane passes near the point and leads in about this direction.
    fn carries(&self, x: f64, y: f64, heading: f64) -> bool {
        self.by_cell.get(&cell(x, y)).into_iter().flatten().any(|[a, b]| {
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let share = (((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
            let off = (x - a.x - share * dx).hypot(y - a.y - share * dy);
            off <= NEAR_M && wrap_angle(dy.atan2(dx) - heading).abs() <= FRAC_PI_3
        })
    }
}

/// Looks at some positions of every vehicle. People walk beside the road, and vehicles on rails have no lanes on the
/// map.
pub(super) fn on_net(fcd: &Fcd, map: &RoadMap) -> OnNet {
    let segments = Segments::new(map);
    let mut out = OnNet { probes: 0, on_lane: 0, example: None };
    for (id, object) in fcd.objects.iter().filter(|(_, o)| o.is_person == IsPerson::No) {
        if is_on_rails(&object.type_id) {
            continue;
        }
        let step = object.samples.len().div_ceil(PER_VEHICLE).max(1);
        for s in object.samples.iter().step_by(step) {
            if out.probes >= PROBES {
                return out;
            }
            out.probes += 1;
            if segments.carries(s.x, s.y, s.heading) {
                out.on_lane += 1;
            } else {
                let at = || format!("{id} ({:.1}, {:.1}), {:.1} s", s.x, s.y, s.time as f64 / 1e9);
                out.example.get_or_insert_with(at);
            }
        }
    }
    out
}

fn is_on_rails(type_id: &str) -> bool {
    let name = type_id.to_lowercase();
    ["tram", "rail", "subway", "train"].iter().any(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::super::fcd::{Object, Sample};
    use super::*;

    fn map() -> RoadMap {
        let center = [0.0, 200.0].map(|x| Point3 { x, y: 0.0, z: 0.0 }).to_vec();
        RoadMap { lanes: vec![Lane { id: "a".into(), center, ..Lane::default() }], ..RoadMap::default() }
    }

    fn fcd(rows: &[(f64, f64, f64)]) -> Fcd {
        let sample = |(i, &(x, y, heading)): (usize, &(f64, f64, f64))| Sample {
            time: i as i64 * 100_000_000,
            x,
            y,
            z: 0.0,
            heading,
            speed: 10.0,
            accel: 0.0,
            lag: 0,
            signals: None,
            aeb: None,
        };
        let samples: Vec<Sample> = rows.iter().enumerate().map(sample).collect();
        let object = Object { is_person: IsPerson::No, type_id: "car".into(), samples };
        let objects = ["v", "w"].map(|id| (id.to_owned(), object.clone()));
        Fcd { objects: objects.into(), ..Fcd::default() }
    }

    #[test]
    fn vehicles_on_their_network_are_found_on_it() {
        let rows: Vec<_> = (0..20).map(|i| (10.0 * f64::from(i), 1.5, 0.05)).collect();
        let found = on_net(&fcd(&rows), &map());
        assert_eq!((found.probes, found.on_lane), (40, 40));
        assert!(!found.is_foreign() && !found.is_partial());
    }

    #[test]
    fn beside_the_road_or_across_it_is_another_network() {
        let beside: Vec<_> = (0..20).map(|i| (10.0 * f64::from(i), 30.0, 0.0)).collect();
        assert!(on_net(&fcd(&beside), &map()).is_foreign());
        let across: Vec<_> = (0..20).map(|i| (100.0, f64::from(i) - 2.0, 1.57)).collect();
        let found = on_net(&fcd(&across), &map());
        assert!(found.is_foreign());
        assert_eq!(found.example.as_deref(), Some("v (100.0, -2.0), 0.0 s"));
    }

    #[test]
    fn a_few_positions_prove_nothing() {
        let beside: Vec<_> = (0..10).map(|i| (10.0 * f64::from(i), 30.0, 0.0)).collect();
        let found = on_net(&fcd(&beside), &map());
        assert!(!found.is_foreign() && !found.is_partial());
    }

    #[test]
    fn a_vehicle_that_leaves_the_road_at_its_end_is_no_other_network() {
        let rows: Vec<_> = (0..20).map(|i| (11.5 * f64::from(i), 0.0, 0.0)).collect();
        let found = on_net(&fcd(&rows), &map());
        assert_eq!(found.on_lane, 36, "204 m is within 4 m of the end at 200 m, 207 m is not");
        assert!(found.is_partial());
    }
}
