//! The map prepared for queries: lanes with center line, widths and links by index, areas as polygons, and a spatial
//! index over the lanes. Frame: world, plane.

use crate::geometry::{BoxGrid, P2, Polygon, Polyline, p2, wrap};
use std::f64::consts::{PI, TAU};
use whyroad_model::road_map::{Area, Lane, LaneKind, Point3, RoadMap, STRAIGHT_OVER_RAD};

/// Half width of a lane whose source states neither edges nor width, m: half of 3.5 m.
pub const DEFAULT_HALF_WIDTH_M: f64 = 1.75;
/// Minimum height difference of an object on another level than a lane, m (a level of an interchange has at least 5 m).
pub const LEVEL_M: f64 = 4.0;

/// One lane's geometry and links; indices are into [`Road::lanes`].
#[derive(Clone, Debug)]
pub struct LaneShape {
    /// Id in the map.
    pub id: String,
    /// Center line in driving direction.
    pub center: Polyline,
    /// Distance from the center line to the left edge at each of its points, m.
    pub left_width: Vec<f64>,
    /// The same to the right edge.
    pub right_width: Vec<f64>,
    /// Middle and half of the range of its directions, rad; half a turn where it winds.
    pub directions: (f64, f64),
    /// The map states its width or its edges; otherwise it has the default width.
    pub width_is_known: bool,
    /// The lane's area.
    pub area: Option<Polygon>,
    /// Lowest and highest point of the center line, m; NaN when the map is flat.
    pub height: (f64, f64),
    /// Its users.
    pub kind: LaneKind,
    /// Inside a junction.
    pub in_junction: bool,
    /// Lanes entered at the end.
    pub successors: Vec<usize>,
    /// Lanes that lead here.
    pub predecessors: Vec<usize>,
    /// Adjacent lanes of the same direction, left then right.
    pub neighbors: [Option<usize>; 2],
}

/// Pieces of one way through a junction that are followed.
const MOST_PIECES: usize = 8;
/// Above this half of the range of its directions a lane winds, rad.
const MOST_BENT_RAD: f64 = 1.2;

impl LaneShape {
    /// False if no chord of its center line is turned from `heading` by as little as `most`, rad: by more than rounding
    /// errors.
    pub fn may_lead(&self, heading: f64, most: f64) -> bool {
        let (middle, half) = self.directions;
        wrap(heading - middle).abs() <= half + most + 1e-6
    }

    /// Widths to the left and right edge at arc length `s`, m.
    pub fn widths_at(&self, s: f64) -> (f64, f64) {
        self.center.interpolate_both([&self.left_width, &self.right_width], s)
    }

    /// True for a lane inside a junction that does not lead straight over it: such lanes overlap others and have no
    /// lines.
    pub fn turns_in_junction(&self) -> bool {
        let turn = || wrap(self.center.heading_at(self.center.length()) - self.center.heading_at(0.0));
        self.in_junction && turn().abs() >= STRAIGHT_OVER_RAD
    }

    /// True when an object whose box center has height `z` can be on this lane (or heights are unknown).
    pub fn on_level(&self, z: f64) -> bool {
        is_on_level(z, self.height, LEVEL_M)
    }
}

/// Least and greatest of these heights, m; NaN where none is known.
pub fn heights(points: &[Point3]) -> (f64, f64) {
    let z = |f: fn(f64, f64) -> f64| points.iter().map(|p| p.z).fold(f64::NAN, f);
    (z(f64::min), z(f64::max))
}

/// The height `z` is less than `apart` meters from those of something, or one of them is unknown.
pub fn is_on_level(z: f64, height: (f64, f64), apart: f64) -> bool {
    let known = z.is_finite() && height.0.is_finite();
    !known || (z > height.0 - apart && z < height.1 + apart)
}

/// The map of one drive, prepared for queries.
pub struct Road {
    /// Lanes with usable geometry, in the map's order.
    pub lanes: Vec<LaneShape>,
    /// Junction areas.
    pub junctions: Vec<Polygon>,
    /// Crosswalks.
    pub crosswalks: Vec<Polygon>,
    /// Drivable areas.
    pub drivable: Vec<Polygon>,
    lane_grid: BoxGrid,
    junction_grid: BoxGrid,
    drivable_grid: BoxGrid,
}

fn plane(points: &[Point3]) -> impl Iterator<Item = P2> + '_ {
    points.iter().map(|p| p2(p.x, p.y))
}

fn polygons(areas: &[Area]) -> Vec<Polygon> {
    areas.iter().filter_map(|a| Polygon::new(plane(&a.boundary))).collect()
}

fn grid(areas: &[Polygon]) -> BoxGrid {
    BoxGrid::new(areas.iter().map(Polygon::bounds).enumerate())
}

fn shape(lane: &Lane) -> Option<LaneShape> {
    let center = Polyline::new(plane(&lane.center))?;
    let width = lane.width_m.filter(|w| w.is_finite() && *w > 0.0);
    let stated = width.map_or(DEFAULT_HALF_WIDTH_M, |w| w / 2.0);
    let edges = (Polyline::new(plane(&lane.left)), Polyline::new(plane(&lane.right)));
    let width_is_known = width.is_some() || (edges.0.is_some() && edges.1.is_some());
    let (left_width, right_width, area) = match &edges {
        (Some(left), Some(right)) => {
            let to = |edge: &Polyline| center.points().iter().map(|&p| edge.distance(p)).collect();
            let ring = left.points().iter().chain(right.points().iter().rev()).copied();
            (to(left), to(right), Polygon::new(ring))
        }
        _ => {
            let widths = vec![stated; center.points().len()];
            let side = |sign: f64| {
                center
                    .arc_lengths()
                    .iter()
                    .map(|&s| {
                        center.point_at(s)
                            + P2::from_heading(center.smooth_heading_at(s, 0.5)).left() * (sign * stated)
                    })
                    .collect::<Vec<P2>>()
            };
            let ring = side(1.0).into_iter().chain(side(-1.0).into_iter().rev());
            let area = Polygon::new(ring);
            (widths.clone(), widths, area)
        }
    };
    let (middle, half) = center.range_of_directions();
    Some(LaneShape {
        id: lane.id.clone(),
        directions: (middle, if half < MOST_BENT_RAD { half } else { PI }),
        center,
        left_width,
        right_width,
        width_is_known,
        area,
        height: heights(&lane.center),
        kind: lane.kind,
        in_junction: lane.in_junction,
        successors: Vec::new(),
        predecessors: Vec::new(),
        neighbors: [None, None],
    })
}

/// Both lanes have the same direction at their middle (neighbors in a map may have opposite directions).
fn same_direction(a: &LaneShape, b: &LaneShape) -> bool {
    let middle = a.center.length() / 2.0;
    let there = b.center.project(a.center.point_at(middle));
    let direction = |lane: &LaneShape, s| P2::from_heading(lane.center.smooth_heading_at(s, 1.0));
    direction(a, middle).dot(direction(b, there.s)) > 0.5
}

impl Road {
    /// How far a lane is from the straightest way on for a vehicle that comes from `from`: absolute change of
    /// direction, rad, from its start to its end or, in a junction, to the end of the last piece of one way there
    /// (maps split ways where vehicles wait); a full turn more for lanes in which it may not drive.
    pub fn turn_of(&self, lane: usize, from: usize) -> f64 {
        let mut last = &self.lanes[lane];
        for _ in 0..MOST_PIECES {
            let [next] = last.successors[..] else { break };
            if !last.in_junction || !self.lanes[next].in_junction {
                break;
            }
            last = &self.lanes[next];
        }
        let turn = last.center.heading_at(last.center.length()) - self.lanes[lane].center.heading_at(0.0);
        let no_cars = |lane: usize| {
            matches!(self.lanes[lane].kind, LaneKind::Bike | LaneKind::Sidewalk | LaneKind::Shoulder)
        };
        let is_closed = no_cars(lane) && !no_cars(from);
        wrap(turn).abs() + if is_closed { TAU } else { 0.0 }
    }

    /// From the scene table. Lanes without a center line and links to missing lanes are left out (ingest reports them).
    pub fn new(map: &RoadMap) -> Self {
        let usable: Vec<(&Lane, LaneShape)> = map.lanes.iter().filter_map(|l| Some((l, shape(l)?))).collect();
        // Usable lanes keep the map's order, so they are sorted by id.
        let index = |id: &String| usable.binary_search_by(|(lane, _)| lane.id.cmp(id)).ok();
        let mut links = Vec::with_capacity(usable.len());
        for (i, (lane, shape)) in usable.iter().enumerate() {
            let neighbor = |id: &Option<String>| {
                let j = id.as_ref().and_then(index).filter(|&j| j != i)?;
                same_direction(shape, &usable[j].1).then_some(j)
            };
            let linked = |ids: &[String]| ids.iter().filter_map(index).collect::<Vec<usize>>();
            let neighbors = [neighbor(&lane.left_neighbor), neighbor(&lane.right_neighbor)];
            links.push((linked(&lane.successors), linked(&lane.predecessors), neighbors));
        }
        let mut lanes: Vec<LaneShape> = usable.into_iter().map(|(_, shape)| shape).collect();
        for (lane, (successors, predecessors, neighbors)) in lanes.iter_mut().zip(links) {
            (lane.successors, lane.predecessors, lane.neighbors) = (successors, predecessors, neighbors);
        }
        let bounds = |(i, lane): (usize, &LaneShape)| Some((i, lane.area.as_ref()?.bounds()));
        let (junctions, drivable) = (polygons(&map.junctions), polygons(&map.drivable_areas));
        Self {
            lane_grid: BoxGrid::new(lanes.iter().enumerate().filter_map(bounds)),
            junction_grid: grid(&junctions),
            drivable_grid: grid(&drivable),
            junctions,
            crosswalks: polygons(&map.crosswalks),
            drivable,
            lanes,
        }
    }

    /// Lanes whose bounding box is within `reach` meters of `p` on each axis, in ascending order.
    pub fn lanes_near(&self, p: P2, reach: f64) -> Vec<usize> {
        self.lane_grid.near(p, reach)
    }

    /// [`Road::lanes_near`] in a list of the caller.
    pub fn find_lanes_near(&self, p: P2, reach: f64, found: &mut Vec<usize>) {
        self.lane_grid.find_near(p, reach, found);
    }

    /// Lanes whose bounding box contains `p`.
    pub fn lanes_around(&self, p: P2) -> impl Iterator<Item = usize> {
        self.lane_grid.at(p)
    }

    /// The junction area that contains `p`.
    pub fn junction_at(&self, p: P2) -> Option<&Polygon> {
        self.junction_grid.at(p).map(|j| &self.junctions[j]).find(|area| area.contains(p))
    }

    /// Junction areas whose bounding box is within `reach` meters of `p` on each axis.
    pub fn junctions_near(&self, p: P2, reach: f64) -> impl Iterator<Item = &Polygon> {
        self.junction_grid.near(p, reach).into_iter().map(|j| &self.junctions[j])
    }

    /// The drivable area that contains `p`.
    pub fn drivable_at(&self, p: P2) -> Option<&Polygon> {
        self.drivable_grid.at(p).map(|d| &self.drivable[d]).find(|area| area.contains(p))
    }

    /// The area of a lane that meets `wanted` and contains `p`.
    pub fn lane_at(&self, p: P2, wanted: impl Fn(&LaneShape) -> bool) -> Option<&Polygon> {
        let lanes = self.lane_grid.at(p).map(|l| &self.lanes[l]).filter(|lane| wanted(lane));
        lanes.filter_map(|lane| lane.area.as_ref()).find(|area| area.contains(p))
    }

    /// True when `p` is in a junction area or on a junction lane.
    pub fn in_junction(&self, p: P2) -> bool {
        let crossing = |lane: &LaneShape| lane.in_junction && lane.kind != LaneKind::Sidewalk;
        self.junction_at(p).is_some() || self.lane_at(p, crossing).is_some()
    }

    /// True when `p` is in a drivable area or on a lane for vehicles, buses or bicycles.
    pub fn on_road(&self, p: P2) -> bool {
        self.drivable_at(p).is_some() || self.lane_at(p, |lane| lane.kind.is_driven_on()).is_some()
    }
}
