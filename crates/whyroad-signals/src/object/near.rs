//! Which objects come near each other: frame by frame over a grid, so that far ones are never compared.

use super::body::Body;
use crate::geometry::P2;
use std::collections::HashMap;
use whyroad_model::FrameRange;
use whyroad_model::pair::{PAIR_REACH_M, PairSpan};

/// The pairs in the order of a pair table, and by row whether they are near.
pub fn pairs(bodies: &[Body], frames: usize) -> (Vec<PairSpan>, Vec<bool>) {
    let mut met: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    let mut grid = Grid::new(bodies);
    for frame in 0..frames {
        grid.fill(bodies, frame);
        grid.meetings(bodies, frame, |i, k| met.entry((i, k)).or_default().push(frame));
    }
    let mut keys: Vec<(usize, usize)> = met.keys().flat_map(|&(i, k)| [(i, k), (k, i)]).collect();
    keys.sort_unstable();
    let (mut spans, mut near) = (Vec::with_capacity(keys.len()), Vec::new());
    for (first, second) in keys {
        let Some(of) = met.get(&(first.min(second), first.max(second))) else { continue };
        let (Some(&start), Some(&last)) = (of.first(), of.last()) else { continue };
        let span =
            PairSpan { first, second, first_row: near.len(), frames: FrameRange::new(start, last + 1) };
        near.resize(near.len() + span.frames.len(), false);
        for frame in of {
            near[span.first_row + frame - start] = true;
        }
        spans.push(span);
    }
    (spans, near)
}

/// Objects of one frame by square cells that are as wide as the farthest centres of a near pair can be apart.
struct Grid {
    cell_m: f64,
    /// Cell and object, sorted.
    cells: Vec<((i64, i64), usize)>,
}

impl Grid {
    fn new(bodies: &[Body]) -> Self {
        let radius = |b: &Body| {
            let radii = (0..b.length.len()).map(|i| radius_of(b, i));
            radii.fold(0.0, f64::max)
        };
        let largest = bodies.iter().map(radius).fold(0.0, f64::max);
        Self { cell_m: PAIR_REACH_M + 2.0 * largest, cells: Vec::new() }
    }

    fn cell(&self, p: P2) -> (i64, i64) {
        ((p.x / self.cell_m).floor() as i64, (p.y / self.cell_m).floor() as i64)
    }

    fn fill(&mut self, bodies: &[Body], frame: usize) {
        let mut cells = std::mem::take(&mut self.cells);
        cells.clear();
        let there = |(k, b): (usize, &Body)| Some((self.cell(b.position[b.at(frame)?]), k));
        cells.extend(bodies.iter().enumerate().filter_map(there));
        cells.sort_unstable();
        self.cells = cells;
    }

    /// Calls `each` for every two that are near in the frame, the lower index first.
    fn meetings(&self, bodies: &[Body], frame: usize, mut each: impl FnMut(usize, usize)) {
        for &((x, y), i) in &self.cells {
            for dx in -1..=1 {
                let from = self.cells.partition_point(|(c, _)| *c < (x + dx, y - 1));
                let beside = self.cells[from..].iter().take_while(|(c, _)| *c <= (x + dx, y + 1));
                for &(_, k) in beside.filter(|(_, k)| *k > i) {
                    if let (Some(a), Some(b)) = (bodies[i].at(frame), bodies[k].at(frame))
                        && is_near((&bodies[i], a), (&bodies[k], b))
                    {
                        each(i, k);
                    }
                }
            }
        }
    }
}

fn radius_of(body: &Body, i: usize) -> f64 {
    let radius = body.footprint(i).radius();
    if radius.is_finite() { radius } else { 0.0 }
}

/// Box to box within reach; by the centres where a size is unknown.
fn is_near((a, i): (&Body, usize), (b, k): (&Body, usize)) -> bool {
    let centres = (b.position[k] - a.position[i]).norm();
    if centres <= PAIR_REACH_M {
        return true;
    }
    if centres - radius_of(a, i) - radius_of(b, k) > PAIR_REACH_M {
        return false;
    }
    a.footprint(i).distance(&b.footprint(k)) <= PAIR_REACH_M
}
