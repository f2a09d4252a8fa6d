//! Junction areas from the lanes inside junctions, for maps that mark such lanes and name no junctions.

use crate::assemble::geometry::{beside, between, contains, distance, union_outlines};
use std::collections::BTreeMap;
use whyroad_model::RoadMap;
use whyroad_model::road_map::{Area, Lane, Point3};

/// Half the width assumed for a lane where the map states none, m.
const NOMINAL_HALF_WIDTH_M: f64 = 1.75;

/// The ground that a lane covers.
fn area(lane: &Lane) -> Vec<Point3> {
    if lane.left.len() >= 2 && lane.right.len() >= 2 {
        return between(&lane.left, &lane.right);
    }
    let half = lane.width_m.map_or(NOMINAL_HALF_WIDTH_M, |w| w / 2.0);
    between(&beside(&lane.center, half), &beside(&lane.center, -half))
}

/// Junction areas, and on each lane the junction that it belongs to or leads into.
pub(crate) fn add(map: &mut RoadMap) {
    let inside: Vec<usize> = (0..map.lanes.len()).filter(|&i| map.lanes[i].in_junction).collect();
    let shapes: Vec<Vec<Point3>> = inside.iter().map(|&i| area(&map.lanes[i])).collect();
    let outlines = union_outlines(&shapes);
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &i in &inside {
        let center = &map.lanes[i].center;
        let middle = center[center.len() / 2];
        // A lane whose edges cross can have its middle outside; it then goes to the nearest outline.
        let home = outlines.iter().position(|o| contains(o, middle)).or_else(|| {
            let reach = |o: &[Point3]| o.iter().map(|p| distance(*p, middle)).fold(f64::INFINITY, f64::min);
            (0..outlines.len()).min_by(|&a, &b| reach(&outlines[a]).total_cmp(&reach(&outlines[b])))
        });
        if let Some(home) = home {
            members.entry(home).or_default().push(i);
        }
    }
    let mut id_of = vec![None; outlines.len()];
    for (home, lanes) in members {
        // Lanes are ordered by id, so the first member gives a name that does not change with the file's order.
        let id = format!("junction_{}", map.lanes[lanes[0]].id);
        for i in lanes {
            map.lanes[i].junction_id = Some(id.clone());
        }
        id_of[home] = Some(id);
    }
    // An outline without a lane is a sliver of the union.
    map.junctions = outlines
        .into_iter()
        .zip(id_of)
        .filter_map(|(boundary, id)| Some(Area { id: id?, boundary }))
        .collect();
    map.junctions.sort_by(|a, b| a.id.cmp(&b.id));
    for i in 0..map.lanes.len() {
        if !map.lanes[i].in_junction {
            let ahead = map.lanes[i].successors.iter().find_map(|s| {
                map.lane(s)?.junction_id.clone().filter(|_| map.lane(s).is_some_and(|l| l.in_junction))
            });
            map.lanes[i].junction_id = ahead;
        }
    }
}
