//! The ego's way ahead over the lanes of the map: from its lane through the lanes that it takes later, else through the
//! adjacent ones, else the straightest. Where a lane ends and its neighbor continues, the way continues there. A
//! corridor (`corridor.rs`) stays in one lane; the way follows the road.

use crate::road::ego_lane::EgoLane;
use crate::road::network::Road;

/// Length of a way ahead of the lane's start, in addition to the lane's own length, m.
pub const REACH_M: f64 = 320.0;

/// One lane of a way, arc lengths from the start of the way's first lane, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Index into [`Road::lanes`].
    pub lane: usize,
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The way changed here from the adjacent lane, because that one ended.
    pub hopped: bool,
}

/// Lanes ahead, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// At least the lane that it begins on.
    pub steps: Vec<Step>,
    /// Nothing follows the last lane: the way did not end because of its maximum length.
    pub ends: bool,
}

/// The one of the lanes after `last` to take: the first on the later route, else the first beside it, else the
/// straightest.
fn choose(road: &Road, last: usize, coming: &[usize]) -> Option<usize> {
    let rank = |&lane: &usize| {
        let on = coming.iter().position(|&l| l == lane);
        let beside =
            || coming.iter().position(|l| road.lanes[lane].neighbors.iter().flatten().any(|n| n == l));
        match (on, on.map_or_else(beside, |_| None)) {
            (Some(k), _) => (0, k, 0.0),
            (None, Some(k)) => (1, k, 0.0),
            (None, None) => (2, 0, road.turn_of(lane, last)),
        }
    };
    let order =
        |a: &(u8, usize, f64), b: &(u8, usize, f64)| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2));
    road.lanes[last].successors.iter().copied().min_by(|a, b| order(&rank(a), &rank(b)))
}

/// Lanes of the same direction beside `lane`, nearest first, left before right; not `lane` itself.
pub fn beside(road: &Road, lane: usize) -> Vec<usize> {
    let mut sides: [Vec<usize>; 2] = Default::default();
    for (side, found) in sides.iter_mut().enumerate() {
        let mut at = lane;
        // Bounded: in a map whose neighbors form a ring the loop would not end.
        while let Some(next) = road.lanes[at].neighbors[side].filter(|_| found.len() < 16) {
            found.push(next);
            at = next;
        }
    }
    let longest = sides[0].len().max(sides[1].len());
    (0..longest).flat_map(|k| [sides[0].get(k), sides[1].get(k)]).flatten().copied().collect()
}

impl Way {
    /// From the start of `lane` for an actor that is later in the lanes `coming`, in that order.
    pub fn new(road: &Road, lane: usize, coming: &[usize]) -> Self {
        let mut coming = coming;
        let length = |lane: usize| road.lanes[lane].center.length();
        let mut steps = vec![Step { lane, from: 0.0, to: length(lane), hopped: false }];
        let far_enough = length(lane) + REACH_M;
        while let Some(&last) = steps.last().filter(|s| s.to < far_enough) {
            let onward = |lane: usize| choose(road, lane, coming);
            let own = onward(last.lane);
            let found = own.or_else(|| beside(road, last.lane).into_iter().find_map(onward));
            let Some(next) = found else { return Self { steps, ends: true } };
            if let Some(k) = coming.iter().position(|&l| l == next) {
                coming = &coming[k + 1..];
            }
            steps.push(Step { lane: next, from: last.to, to: last.to + length(next), hopped: own.is_none() });
        }
        Self { steps, ends: false }
    }

    /// Index of the step that contains arc length `s`; the last one beyond the end.
    pub fn step_at(&self, s: f64) -> usize {
        self.steps.partition_point(|step| step.to <= s).min(self.steps.len() - 1)
    }
}

/// The way of each frame.
pub struct Ways {
    ways: Vec<Way>,
    by_frame: Vec<Option<(usize, f64)>>,
}

impl Ways {
    /// One way per stay of the ego in a lane.
    pub fn new(road: &Road, lanes: &EgoLane) -> Self {
        let mut stays: Vec<usize> = Vec::new();
        let mut by_frame = Vec::with_capacity(lanes.places.len());
        for place in &lanes.places {
            by_frame.push(place.map(|p| {
                if stays.last() != Some(&p.lane) {
                    stays.push(p.lane);
                }
                (stays.len() - 1, p.s)
            }));
        }
        let ways = (0..stays.len()).map(|k| Way::new(road, stays[k], &stays[k + 1..])).collect();
        Self { ways, by_frame }
    }

    /// The way of the ego in `frame`, and its arc length there.
    pub fn at(&self, frame: usize) -> Option<(&Way, f64)> {
        self.by_frame.get(frame)?.map(|(way, s)| (&self.ways[way], s))
    }
}
