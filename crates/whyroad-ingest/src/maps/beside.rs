//! A map file beside a drive: cut to the drive's surroundings, and what is checked.

use super::cache::MapBeside;
use super::findings;
use crate::assemble::geometry::{distance, length};
use crate::report::SourceReport;
use std::collections::{BTreeSet, HashSet};
use whyroad_model::road_map::{Area, Point3};
use whyroad_model::scene::FrameOfReference;
use whyroad_model::{Drive, Need, RoadMap};

/// Features farther from the ego's path than this are left out, m.
const REACH_M: f64 = 300.0;
/// Cells in which the surroundings are marked, m, and spacing at which lines are compared with them.
const CELL_M: f64 = 50.0;
/// Vehicles farther from every lane are not on the map, m.
const ON_MAP_M: f64 = 15.0;
/// Fewer vehicles are not enough evidence.
const MIN_VEHICLES: usize = 5;

impl MapBeside {
    /// Hash of a drive's content together with this map.
    pub fn with(&self, content_hash: &str) -> String {
        let both = [content_hash.as_bytes(), self.hash.as_bytes()].concat();
        blake3::hash(&both).to_hex().to_string()
    }

    /// Gives the map to a drive.
    pub fn attach(&self, drive: &mut Drive, report: &mut SourceReport) {
        drive.meta.content_hash = self.with(&drive.meta.content_hash);
        if drive.meta.frame_of_reference == FrameOfReference::Ego || drive.ego.is_none() {
            report.diagnostics.push(findings::no_world(&self.label));
            return;
        }
        report.tables.extend(self.tables.iter().cloned());
        if drive.map.is_some() {
            report.diagnostics.push(findings::replaced(&self.label));
        }
        let near = Surroundings::of(drive).cut(&self.map);
        // A map of another location is kept whole for the check that reports it.
        let map = if near.lanes.is_empty() { self.map.clone() } else { near };
        let of_lights = lights(drive, &map, &self.label, report);
        report.diagnostics.extend(of_lights);
        report.diagnostics.extend(vehicles_off(drive, &map, &self.label));
        drive.map = Some(map);
        drive.meta.map_ref = Some(self.name.clone());
        drive.meta.missing.retain(|need| *need != Need::Map);
    }
}

/// Light states name lanes; those of another map do not apply to this one.
fn lights(
    drive: &mut Drive,
    map: &RoadMap,
    file: &str,
    report: &mut SourceReport,
) -> Option<whyroad_model::Diagnostic> {
    let states = drive.lights.as_mut()?;
    let before = states.len();
    states.retain(|s| map.lane(&s.lane_id).is_some());
    let lost = before - states.len();
    if let Some(count) = report.tables.iter_mut().find(|t| t.table == "lights")
        && let Some(kept) = count.kept.values_mut().find(|kept| **kept >= lost)
    {
        *kept -= lost;
        count.set_aside("no_such_lane", lost);
    }
    if before > 0 && states.is_empty() {
        drive.lights = None;
        drive.meta.lacks(Need::TrafficLights);
    }
    (lost > 0).then(|| findings::lights(file, lost))
}

/// Most vehicles lie off the road: the log or its map is in another frame.
fn vehicles_off(drive: &Drive, map: &RoadMap, file: &str) -> Option<whyroad_model::Diagnostic> {
    let road = Cells::of(map.lanes.iter().map(|l| l.center.as_slice()), ON_MAP_M);
    let places = drive.tracks.iter().filter(|t| t.class.is_vehicle()).filter_map(|t| {
        let row = (0..t.motion.len()).find(|&i| t.motion.x[i].is_finite() && t.motion.y[i].is_finite())?;
        Some((t.motion.x[row], t.motion.y[row]))
    });
    let on: Vec<bool> = places.map(|(x, y)| road.has(x, y)).collect();
    let off = on.iter().filter(|on| !**on).count();
    (on.len() >= MIN_VEHICLES && 2 * off > on.len()).then(|| findings::vehicles_off(file, off, on.len()))
}

/// Ground within some distance of lines, as cells of [`ON_MAP_M`].
struct Cells(HashSet<(i64, i64)>, f64);

impl Cells {
    fn of<'l>(lines: impl Iterator<Item = &'l [Point3]>, size: f64) -> Self {
        let mut cells = HashSet::new();
        for line in lines {
            each_along(line, size / 2.0, &mut |x, y| {
                cells.insert(cell(x, y, size));
            });
        }
        Self(cells, size)
    }

    fn has(&self, x: f64, y: f64) -> bool {
        let (i, j) = cell(x, y, self.1);
        (-1..=1).any(|a| (-1..=1).any(|b| self.0.contains(&(i.saturating_add(a), j.saturating_add(b)))))
    }
}

fn cell(x: f64, y: f64, size: f64) -> (i64, i64) {
    ((x / size).floor() as i64, (y / size).floor() as i64)
}

/// Points of a line, and between them at most `step` apart.
fn each_along(line: &[Point3], step: f64, each: &mut dyn FnMut(f64, f64)) {
    if let [only] = line {
        each(only.x, only.y);
    }
    // A line of more steps than this is not a road.
    if length(line) > 1e6 {
        return;
    }
    for w in line.windows(2) {
        let steps = (distance(w[0], w[1]) / step).ceil().max(1.0) as usize;
        for i in 0..=steps {
            let share = i as f64 / steps as f64;
            each(w[0].x + share * (w[1].x - w[0].x), w[0].y + share * (w[1].y - w[0].y));
        }
    }
}

/// The ground around the ego's path.
struct Surroundings(HashSet<(i64, i64)>);

impl Surroundings {
    fn of(drive: &Drive) -> Self {
        let mut path: BTreeSet<(i64, i64)> = BTreeSet::new();
        if let Some(ego) = &drive.ego {
            for (x, y) in
                ego.motion.x.iter().zip(&ego.motion.y).filter(|(x, y)| x.is_finite() && y.is_finite())
            {
                path.insert(cell(*x, *y, CELL_M));
            }
        }
        let reach = (REACH_M / CELL_M).ceil() as i64;
        let around = |(i, j): (i64, i64)| {
            (-reach..=reach)
                .flat_map(move |a| (-reach..=reach).map(move |b| (i.saturating_add(a), j.saturating_add(b))))
        };
        Self(path.into_iter().flat_map(around).collect())
    }

    fn touches(&self, line: &[Point3]) -> bool {
        let mut found = false;
        each_along(line, CELL_M, &mut |x, y| found |= self.0.contains(&cell(x, y, CELL_M)));
        found
    }

    fn cut(&self, map: &RoadMap) -> RoadMap {
        fn keep<T: Clone>(all: &[T], near: impl Fn(&T) -> bool) -> Vec<T> {
            all.iter().filter(|f| near(f)).cloned().collect()
        }
        let areas = |all: &[Area]| keep(all, |a| self.touches(&a.boundary));
        RoadMap {
            lanes: keep(&map.lanes, |l| self.touches(&l.center)),
            crosswalks: areas(&map.crosswalks),
            junctions: areas(&map.junctions),
            drivable_areas: areas(&map.drivable_areas),
            stop_lines: keep(&map.stop_lines, |s| self.touches(&s.line)),
            signs: keep(&map.signs, |s| self.touches(&[s.position])),
            facilities: keep(&map.facilities, |f| self.touches(&f.boundary)),
            complete_for: map.complete_for.clone(),
            layers: map.layers.clone(),
        }
    }
}
