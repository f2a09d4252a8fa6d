//! The town of this bench: a grid of avenues (two lanes each way) and streets (one), with junctions, turns, crosswalks
//! and parking beside the streets. Its map is written as Argoverse 2 writes maps.

use serde_json::{Value, json};

/// Junctions per side of the grid.
pub const SIDE: usize = 4;
/// From junction to junction, m.
pub const BLOCK_M: f64 = 110.0;
/// From a junction's middle to its border, m.
pub const JUNCTION_M: f64 = 13.0;
/// Width of a lane, m.
pub const LANE_M: f64 = 3.5;

/// A point, m.
pub type Point = (f64, f64);

/// A lane by its center line.
pub struct Lane {
    /// Points of the center line.
    pub line: Vec<Point>,
    /// Arc length at each point, m.
    pub s: Vec<f64>,
    /// Lanes that follow.
    pub next: Vec<usize>,
    /// The lane to the left of the same direction, and to the right.
    pub beside: [Option<usize>; 2],
    /// Inside a junction.
    pub in_junction: bool,
    /// Row and column of the junction that it leads to or is in.
    pub junction: (usize, usize),
    /// True on an avenue, and in a junction when coming from one.
    pub avenue: bool,
    /// The rightmost of its direction.
    pub rightmost: bool,
}

impl Lane {
    fn new(line: Vec<Point>, junction: (usize, usize), avenue: bool, in_junction: bool) -> Self {
        let mut s = vec![0.0];
        for w in line.windows(2) {
            s.push(s[s.len() - 1] + (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1));
        }
        Self { line, s, next: vec![], beside: [None; 2], in_junction, junction, avenue, rightmost: true }
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        self.s[self.s.len() - 1]
    }

    /// Position and heading at an arc length.
    pub fn at(&self, s: f64) -> (Point, f64) {
        let k = self.s.partition_point(|x| *x <= s).clamp(1, self.s.len() - 1);
        let (a, b) = (self.line[k - 1], self.line[k]);
        let share = (s - self.s[k - 1]) / (self.s[k] - self.s[k - 1]);
        ((a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1)), (b.1 - a.1).atan2(b.0 - a.0))
    }
}

/// Directions of travel: east, north, west, south.
const DIRECTIONS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The middle of a junction.
pub fn middle((row, column): (usize, usize)) -> Point {
    (column as f64 * BLOCK_M, row as f64 * BLOCK_M)
}

fn beyond((row, column): (usize, usize), direction: usize) -> Option<(usize, usize)> {
    let (dx, dy) = DIRECTIONS[direction];
    let there = |v: usize, d: i32| v.checked_add_signed(d as isize).filter(|v| *v < SIDE);
    Some((there(row, dy)?, there(column, dx)?))
}

/// A point `along` a direction and `aside` to its right.
fn offset(from: Point, direction: usize, along: f64, aside: f64) -> Point {
    let (dx, dy) = (f64::from(DIRECTIONS[direction].0), f64::from(DIRECTIONS[direction].1));
    (from.0 + along * dx + aside * dy, from.1 + along * dy - aside * dx)
}

fn lane_count(direction: usize) -> usize {
    if direction.is_multiple_of(2) { 2 } else { 1 }
}

/// All lanes of the town.
pub fn lanes() -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    // By junction of departure, direction and number from the left.
    let mut from = vec![[[usize::MAX; 2]; 4]; SIDE * SIDE];
    let mut to = vec![[[usize::MAX; 2]; 4]; SIDE * SIDE];
    let index = |j: (usize, usize)| j.0 * SIDE + j.1;
    let junctions = || (0..SIDE).flat_map(|r| (0..SIDE).map(move |c| (r, c)));
    for start in junctions() {
        for direction in 0..4 {
            let Some(end) = beyond(start, direction) else { continue };
            for k in 0..lane_count(direction) {
                let aside = (k as f64 + 0.5) * LANE_M;
                let steps = 9;
                let along =
                    |i: usize| JUNCTION_M + (BLOCK_M - 2.0 * JUNCTION_M) * i as f64 / f64::from(steps);
                let line = (0..=steps as usize).map(|i| offset(middle(start), direction, along(i), aside));
                let mut lane = Lane::new(line.collect(), end, lane_count(direction) == 2, false);
                lane.rightmost = k + 1 == lane_count(direction);
                if k == 1 {
                    lane.beside[0] = Some(lanes.len() - 1);
                    let at = lanes.len();
                    lanes[at - 1].beside[1] = Some(at);
                }
                from[index(start)][direction][k] = lanes.len();
                to[index(end)][direction][k] = lanes.len();
                lanes.push(lane);
            }
        }
    }
    for here in junctions() {
        for (direction, ending) in to[index(here)].iter().enumerate() {
            for (k, &into) in ending.iter().enumerate().take(lane_count(direction)) {
                if into == usize::MAX {
                    continue;
                }
                // Straight on, left, right; where there are two lanes the left one does not turn right, nor the right
                // one left, unless that is the only way at the town's border.
                let many = lane_count(direction) == 2;
                let usual = |turn: usize| !many || turn == 0 || (turn == 1) == (k == 0);
                let leads = |turn: &usize| from[index(here)][(direction + turn) % 4][0] != usize::MAX;
                let any = [0, 1, 3].iter().any(|t| usual(*t) && leads(t));
                for turn in [0, 1, 3].into_iter().filter(|t| !any || usual(*t)) {
                    let out = (direction + turn) % 4;
                    let last = lane_count(out) - 1;
                    let onto = from[index(here)][out]
                        [if turn == 1 { 0 } else { k.max(usize::from(turn == 3)).min(last) }];
                    if onto == usize::MAX {
                        continue;
                    }
                    let line = curve(&lanes[into], &lanes[onto]);
                    let mut lane = Lane::new(line, here, many, true);
                    lane.next = vec![onto];
                    let at = lanes.len();
                    lanes[into].next.push(at);
                    lanes.push(lane);
                }
            }
        }
    }
    lanes
}

/// A cubic from the end of a lane to the begin of another.
fn curve(from: &Lane, to: &Lane) -> Vec<Point> {
    let ((a, ha), (b, hb)) = (from.at(from.length()), to.at(0.0));
    let pull = 0.4 * (b.0 - a.0).hypot(b.1 - a.1);
    let (p, q) =
        ((a.0 + pull * ha.cos(), a.1 + pull * ha.sin()), (b.0 - pull * hb.cos(), b.1 - pull * hb.sin()));
    let steps = 10;
    (0..=steps)
        .map(|i| {
            let t = f64::from(i) / f64::from(steps);
            let u = 1.0 - t;
            let mix = |a: f64, p: f64, q: f64, b: f64| {
                u * u * u * a + 3.0 * u * u * t * p + 3.0 * u * t * t * q + t * t * t * b
            };
            (mix(a.0, p.0, q.0, b.0), mix(a.1, p.1, q.1, b.1))
        })
        .collect()
}

/// A line moved to its left, m.
fn moved(lane: &Lane, left: f64) -> Vec<Value> {
    let of = |k: usize| {
        let (p, h) = (lane.line[k], lane.at(if k == 0 { 0.0 } else { lane.s[k] - 1e-6 }).1);
        json!({"x": p.0 - left * h.sin(), "y": p.1 + left * h.cos(), "z": 0.0})
    };
    (0..lane.line.len()).map(of).collect()
}

/// The map in the form of Argoverse 2.
pub fn map_json(lanes: &[Lane]) -> Value {
    let mut segments = serde_json::Map::new();
    for (i, lane) in lanes.iter().enumerate() {
        let edge = |side: usize| match (lane.in_junction, lane.beside[side], side) {
            (true, ..) => "NONE",
            (_, Some(_), _) => "DASHED_WHITE",
            (_, None, 0) => "DOUBLE_SOLID_YELLOW",
            _ => "SOLID_WHITE",
        };
        let before: Vec<usize> = (0..lanes.len()).filter(|k| lanes[*k].next.contains(&i)).collect();
        let segment = json!({
            "id": i, "is_intersection": lane.in_junction, "lane_type": "VEHICLE",
            "left_lane_boundary": moved(lane, LANE_M / 2.0), "right_lane_boundary": moved(lane, -LANE_M / 2.0),
            "left_lane_mark_type": edge(0), "right_lane_mark_type": edge(1),
            "successors": lane.next, "predecessors": before,
            "left_neighbor_id": lane.beside[0], "right_neighbor_id": lane.beside[1],
        });
        segments.insert(i.to_string(), segment);
    }
    let mut crossings = serde_json::Map::new();
    let mut areas = serde_json::Map::new();
    let corner = |p: Point| json!({"x": p.0, "y": p.1, "z": 0.0});
    for row in 0..SIDE {
        for column in 0..SIDE {
            let here = (row, column);
            for direction in 0..4 {
                if beyond(here, direction).is_none() {
                    continue;
                }
                let half = lane_count(direction) as f64 * LANE_M;
                let id = (row * SIDE + column) * 4 + direction;
                let edge = |along: f64| {
                    [-half, half].map(|aside| corner(offset(middle(here), direction, along, aside)))
                };
                let crossing = json!({
                    "id": 10_000 + id, "edge1": edge(JUNCTION_M - 4.0), "edge2": edge(JUNCTION_M - 1.0),
                });
                crossings.insert((10_000 + id).to_string(), crossing);
                if direction < 2 {
                    let wide = half + if direction == 1 { 2.5 } else { 0.0 };
                    let ring = [(0.0, -wide), (BLOCK_M, -wide), (BLOCK_M, wide), (0.0, wide)];
                    let ring = ring.map(|(x, y)| corner(offset(middle(here), direction, x, y)));
                    areas
                        .insert((20_000 + id).to_string(), json!({"id": 20_000 + id, "area_boundary": ring}));
                }
            }
        }
    }
    json!({"lane_segments": segments, "pedestrian_crossings": crossings, "drivable_areas": areas})
}
