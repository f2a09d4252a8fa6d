//! A junction by its lanes: those inside it, where they enter and leave, and the resulting arms. Arms are distinguished
//! by the position at which they meet the junction and by their direction, not by road names, which maps split
//! arbitrarily.

use crate::geometry::{P2, wrap};
use crate::road::network::Road;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use whyroad_model::road_map::LaneKind;

/// Maximum difference of directions of links to the outside in one arm, rad: 25 deg.
const SAME_ARM_RAD: f64 = 25.0 * PI / 180.0;
/// And their maximum distance: two carriageways with a strip between them, m.
const SAME_ARM_M: f64 = 20.0;
/// Length from which the direction of an arm is computed, m.
const DIRECTION_M: f64 = 10.0;
/// Maximum deviation from a straight line of two opposite arms, rad: 30 deg.
const OPPOSITE_RAD: f64 = 30.0 * PI / 180.0;
/// Minimum angle of an oncoming approach, rad: 115 deg, so that of three arms at equal angles, 120 deg, the other two
/// are oncoming.
const AGAINST_RAD: f64 = 115.0 * PI / 180.0;
/// Maximum angle between adjacent arms at an acute corner, rad: 50 deg.
const ACUTE_RAD: f64 = 50.0 * PI / 180.0;

/// Where a lane outside meets the junction.
#[derive(Clone, Copy, Debug)]
struct Link {
    outside: usize,
    at: P2,
    /// Away from the junction, rad.
    bearing: f64,
}

/// One junction.
pub struct JunctionArms {
    /// Lanes inside, in ascending order.
    pub inside: Vec<usize>,
    /// Lanes outside that lead in.
    pub entries: Vec<usize>,
    /// By arm: the outside lanes of the arm, and its bearing as seen from the junction, rad.
    arms: Vec<(Vec<usize>, f64)>,
}

fn rolls(road: &Road, lane: usize) -> bool {
    matches!(road.lanes[lane].kind, LaneKind::Vehicle | LaneKind::Bus)
}

/// The point [`DIRECTION_M`] before the end of a lane, or after its begin. A lane can be a piece of 2 m that a stop
/// line or a side of the road cuts off: then on the lanes beyond it, where just one follows.
fn reached_along(road: &Road, lane: usize, backward: bool) -> P2 {
    let (mut at, mut left) = (lane, DIRECTION_M);
    for _ in 0..8 {
        let beyond = if backward { &road.lanes[at].predecessors } else { &road.lanes[at].successors };
        let length = road.lanes[at].center.length();
        match beyond[..] {
            [next] if length < left && !road.lanes[next].in_junction => (at, left) = (next, left - length),
            _ => break,
        }
    }
    let line = &road.lanes[at].center;
    line.point_at(if backward { (line.length() - left).max(0.0) } else { left.min(line.length()) })
}

fn links(road: &Road, inside: &[usize]) -> (Vec<Link>, Vec<usize>) {
    let (mut found, mut seen, mut entries) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
    for &lane in inside.iter().filter(|&&l| rolls(road, l)) {
        let outside = |l: &&usize| !road.lanes[**l].in_junction && rolls(road, **l);
        for &l in road.lanes[lane].predecessors.iter().filter(outside) {
            entries.insert(l);
            let line = &road.lanes[l].center;
            let at = line.point_at(line.length());
            let back = reached_along(road, l, true);
            if seen.insert((l, true)) {
                found.push(Link { outside: l, at, bearing: (back - at).heading() });
            }
        }
        for &l in road.lanes[lane].successors.iter().filter(outside) {
            let (at, on) = (road.lanes[l].center.point_at(0.0), reached_along(road, l, false));
            if seen.insert((l, false)) {
                found.push(Link { outside: l, at, bearing: (on - at).heading() });
            }
        }
    }
    (found, entries.into_iter().collect())
}

impl JunctionArms {
    /// From the lanes inside the junction.
    pub fn new(road: &Road, inside: Vec<usize>) -> Self {
        let (links, entries) = links(road, &inside);
        // Single linkage: the lanes of a wide road are connected one by one.
        let mut group: Vec<usize> = (0..links.len()).collect();
        for i in 0..links.len() {
            for j in 0..i {
                let together = wrap(links[i].bearing - links[j].bearing).abs() < SAME_ARM_RAD
                    && (links[i].at - links[j].at).norm() <= SAME_ARM_M;
                if together && group[i] != group[j] {
                    let (from, to) = (group[i], group[j]);
                    group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
                }
            }
        }
        let names: BTreeSet<usize> = group.iter().copied().collect();
        let arms = names
            .into_iter()
            .map(|name| {
                let own = || links.iter().zip(&group).filter(|(_, g)| **g == name).map(|(l, _)| l);
                let sum = own().fold(P2::default(), |sum, l| sum + P2::from_heading(l.bearing));
                (own().map(|l| l.outside).collect(), sum.heading())
            })
            .collect();
        Self { inside, entries, arms }
    }

    /// Number of arms.
    pub fn count(&self) -> usize {
        self.arms.len()
    }

    /// At least 5 arms, or no two opposite arms, or two arms less than 50 deg apart. With two arms it is a bend, or a
    /// crosswalk that the map draws as a junction.
    pub fn is_irregular(&self) -> bool {
        let mut bearings: Vec<f64> = self.arms.iter().map(|a| a.1).collect();
        bearings.sort_by(f64::total_cmp);
        let n = bearings.len();
        let apart = |i: usize, j: usize| wrap(bearings[i] - bearings[j]).abs();
        let pairs = || (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        n >= 5
            || (n >= 3 && !pairs().any(|(i, j)| PI - apart(i, j) <= OPPOSITE_RAD))
            || (n >= 3 && pairs().any(|(i, j)| apart(i, j) < ACUTE_RAD))
    }

    /// Number of arms to which the lanes `from` (of one approach) lead, other than their own arm.
    pub fn reached(&self, road: &Road, from: &[usize]) -> usize {
        let own: BTreeSet<usize> = from.iter().filter_map(|l| self.arm_of(*l)).collect();
        let mut seen: BTreeSet<usize> = BTreeSet::new();
        let mut open: Vec<usize> =
            from.iter().flat_map(|&l| road.lanes[l].successors.iter().copied()).collect();
        let mut reached = BTreeSet::new();
        while let Some(lane) = open.pop() {
            if self.inside.binary_search(&lane).is_ok() {
                if seen.insert(lane) {
                    open.extend(road.lanes[lane].successors.iter().copied());
                }
            } else {
                reached.extend(self.arm_of(lane));
            }
        }
        reached.difference(&own).count()
    }

    /// True when some lane enters in the direction opposite to that of `approach`: there may be oncoming traffic.
    /// Traffic from the arm into which the ego turns (that of its lane `exit`) does not cross its path.
    pub fn is_opposed(&self, road: &Road, approach: usize, exit: Option<usize>) -> bool {
        let into = |lane: usize| {
            let line = &road.lanes[lane].center;
            let before = (line.length() - DIRECTION_M).max(0.0);
            (line.point_at(line.length()) - line.point_at(before)).heading()
        };
        let own = into(approach);
        // A junction of two arms is a bend, in which both directions of the one road meet.
        let left_by = exit.and_then(|e| self.arm_of(e)).filter(|_| self.count() > 2);
        let crosses = |l: usize| {
            // For an ego that goes straight on, its exit arm is the opposite one, which does not limit other turns.
            let against = wrap(into(l) - own).abs();
            against >= AGAINST_RAD
                && (against >= PI - OPPOSITE_RAD || left_by.is_none() || self.arm_of(l) != left_by)
        };
        self.entries.iter().any(|&l| crosses(l))
    }

    fn arm_of(&self, outside: usize) -> Option<usize> {
        self.arms.iter().position(|(lanes, _)| lanes.contains(&outside))
    }
}

/// The junctions of a map by their lanes: those of one stated junction or one junction area, else those that touch.
pub fn groups(road: &Road, stated: impl Fn(usize) -> Option<String>) -> Vec<Vec<usize>> {
    let inside: Vec<usize> = (0..road.lanes.len()).filter(|&l| road.lanes[l].in_junction).collect();
    let mut named: std::collections::BTreeMap<String, Vec<usize>> = Default::default();
    let mut loose: Vec<Vec<usize>> = Vec::new();
    for &lane in &inside {
        let line = &road.lanes[lane].center;
        let middle = line.point_at(line.length() / 2.0);
        let in_area = || road.junctions.iter().position(|j| j.contains(middle)).map(|k| format!("area {k}"));
        match stated(lane).or_else(in_area) {
            Some(name) => named.entry(name).or_default().push(lane),
            None => {
                let touches = |other: &usize| {
                    let bounds = |l: usize| road.lanes[l].area.as_ref().map(|a| a.bounds());
                    bounds(lane).zip(bounds(*other)).is_some_and(|((al, ah), (bl, bh))| {
                        al.x <= bh.x && bl.x <= ah.x && al.y <= bh.y && bl.y <= ah.y
                    })
                };
                let (mut joined, apart): (Vec<_>, Vec<_>) =
                    loose.into_iter().partition(|group: &Vec<usize>| group.iter().any(touches));
                let mut group: Vec<usize> = joined.drain(..).flatten().collect();
                group.push(lane);
                group.sort_unstable();
                loose = apart;
                loose.push(group);
            }
        }
    }
    named.into_values().chain(loose).collect()
}
