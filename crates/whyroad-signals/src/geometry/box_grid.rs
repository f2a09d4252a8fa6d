//! Finds the bounding boxes that may contain a position: a grid of square cells, each with the boxes that overlap it.
//! Created once per map, queried for every row of every object.

use super::P2;
use std::ops::RangeInclusive;

/// A bounding box: lower left and upper right corner, m.
pub type Bounds = (P2, P2);

/// Length of a cell's side, m; larger if the boxes are far apart.
const CELL_M: f64 = 16.0;
/// Maximum number of cells.
const MOST_CELLS: f64 = 65_536.0;
/// Maximum number of entries in all cells, per box.
const MOST_ENTRIES: usize = 64;
/// Usual maximum number of boxes near a position.
const MOSTLY_NEAR: usize = 32;

/// The boxes by cell. Boxes are numbered in the given order.
#[derive(Clone, Debug, Default)]
pub struct BoxGrid {
    origin: P2,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Index of the first entry of each cell; one more at the end.
    starts: Vec<u32>,
    entries: Vec<u32>,
    boxes: Vec<(u32, Bounds)>,
}

impl BoxGrid {
    /// From boxes with their numbers; corners are finite.
    pub fn new(boxes: impl IntoIterator<Item = (usize, Bounds)>) -> Self {
        let boxes: Vec<(u32, Bounds)> = boxes.into_iter().map(|(k, bounds)| (k as u32, bounds)).collect();
        let (mut low, mut high) = match boxes.first() {
            Some((_, bounds)) => *bounds,
            None => return Self::default(),
        };
        for (_, (from, to)) in &boxes {
            low = P2 { x: low.x.min(from.x), y: low.y.min(from.y) };
            high = P2 { x: high.x.max(to.x), y: high.y.max(to.y) };
        }
        let extent = high - low;
        let mut grid = Self { origin: low, boxes, ..Self::default() };
        let mut cell = CELL_M.max((extent.x * extent.y / MOST_CELLS).sqrt());
        loop {
            let count = |length: f64| ((length / cell) as usize).saturating_add(1);
            (grid.cell, grid.columns, grid.rows) = (cell, count(extent.x), count(extent.y));
            // Boxes at extreme coordinates are checked one by one.
            if !cell.is_finite() || grid.columns.saturating_mul(grid.rows) > 4 * MOST_CELLS as usize {
                (grid.columns, grid.rows) = (1, 1);
            }
            let entries: usize = grid.boxes.iter().map(|(_, bounds)| grid.number_of_cells(bounds)).sum();
            if grid.columns * grid.rows == 1 || entries <= MOST_ENTRIES * grid.boxes.len() {
                break;
            }
            cell *= 2.0;
        }
        grid.fill();
        grid
    }

    fn fill(&mut self) {
        let mut cells: Vec<Vec<u32>> = vec![Vec::new(); self.columns * self.rows];
        for (at, (_, bounds)) in self.boxes.iter().enumerate() {
            for cell in self.cells(bounds) {
                cells[cell].push(at as u32);
            }
        }
        self.starts.push(0);
        for cell in cells {
            self.entries.extend(cell);
            self.starts.push(self.entries.len() as u32);
        }
    }

    /// Column or row of a coordinate; the nearest one if it is outside, the first if it is unknown.
    fn index(&self, along: f64, count: usize) -> usize {
        ((along / self.cell) as usize).min(count - 1)
    }

    /// Columns and rows that a box touches. Despite rounding, [`BoxGrid::index`] never decreases when the coordinate
    /// grows, so that no position in the box is in another cell.
    fn ranges(&self, (low, high): &Bounds) -> [RangeInclusive<usize>; 2] {
        let (from, to) = (*low - self.origin, *high - self.origin);
        [
            self.index(from.x, self.columns)..=self.index(to.x, self.columns),
            self.index(from.y, self.rows)..=self.index(to.y, self.rows),
        ]
    }

    fn number_of_cells(&self, bounds: &Bounds) -> usize {
        self.ranges(bounds).map(|r| (r.end() + 1).saturating_sub(*r.start())).iter().product()
    }

    fn cells(&self, bounds: &Bounds) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = self.ranges(bounds);
        let width = self.columns;
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    fn in_cell(&self, cell: usize) -> impl Iterator<Item = &(u32, Bounds)> {
        let entries = self.starts[cell] as usize..self.starts[cell + 1] as usize;
        self.entries[entries].iter().map(|&at| &self.boxes[at as usize])
    }

    /// Numbers of the boxes that contain `p`, in their order.
    pub fn at(&self, p: P2) -> impl Iterator<Item = usize> {
        let cell = || {
            let from = p - self.origin;
            self.index(from.y, self.rows) * self.columns + self.index(from.x, self.columns)
        };
        let cell = (!self.boxes.is_empty()).then(cell);
        let holds = move |(_, (low, high)): &&(u32, Bounds)| {
            p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y
        };
        cell.into_iter().flat_map(|cell| self.in_cell(cell)).filter(holds).map(|(k, _)| *k as usize)
    }

    /// Numbers of the boxes within `reach` meters of `p` on each axis, ascending, without repetition.
    pub fn near(&self, p: P2, reach: f64) -> Vec<usize> {
        let mut found = Vec::with_capacity(MOSTLY_NEAR);
        self.find_near(p, reach, &mut found);
        found
    }

    /// [`BoxGrid::near`] in a list of the caller, which is emptied first.
    pub fn find_near(&self, p: P2, reach: f64, found: &mut Vec<usize>) {
        found.clear();
        if self.boxes.is_empty() {
            return;
        }
        let (from, to) = (P2 { x: p.x - reach, y: p.y - reach }, P2 { x: p.x + reach, y: p.y + reach });
        for cell in self.cells(&(from, to)) {
            for (k, (low, high)) in self.in_cell(cell) {
                if low.x <= to.x && high.x >= from.x && low.y <= to.y && high.y >= from.y {
                    found.push(*k as usize);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::p2;
    use proptest::prelude::*;

    fn any_box() -> impl Strategy<Value = Bounds> {
        let length = prop_oneof![0.0..30.0_f64, Just(0.0), Just(900.0)];
        (-300.0..300.0_f64, -300.0..300.0_f64, length.clone(), length)
            .prop_map(|(x, y, w, h)| (p2(x, y), p2(x + w, y + h)))
    }

    proptest! {
        #[test]
        fn boxes_are_those_of_asking_each(
            boxes in prop::collection::vec(any_box(), 0..40),
            far in prop_oneof![Just(None), Just(Some(1e9_f64)), Just(Some(1e300))],
            asked in prop::collection::vec((-350.0..350.0_f64, -350.0..350.0_f64, 0.0..60.0_f64), 1..40),
        ) {
            let mut boxes = boxes;
            boxes.extend(far.map(|at| (p2(-at, -at), p2(-at + 1.0, -at + 1.0))));
            let grid = BoxGrid::new(boxes.iter().copied().enumerate());
            let edges = boxes.iter().map(|(low, high)| (low.x, high.y, 0.0));
            for (x, y, reach) in asked.into_iter().chain(edges) {
                let near = |reach: f64| {
                    let meets = |(low, high): &Bounds| {
                        low.x <= x + reach && high.x >= x - reach && low.y <= y + reach && high.y >= y - reach
                    };
                    (0..boxes.len()).filter(|&k| meets(&boxes[k])).collect::<Vec<usize>>()
                };
                prop_assert_eq!(grid.near(p2(x, y), reach), near(reach));
                prop_assert_eq!(grid.at(p2(x, y)).collect::<Vec<usize>>(), near(0.0));
            }
        }
    }

    #[test]
    fn what_is_not_known_is_in_no_box() {
        let grid = BoxGrid::new([(7, (p2(0.0, 0.0), p2(1.0, 1.0)))]);
        assert_eq!(grid.near(p2(0.5, 1.5), 0.5), [7]);
        assert_eq!(grid.at(p2(f64::NAN, 0.0)).count() + grid.near(p2(f64::NAN, f64::NAN), 1.0).len(), 0);
        assert_eq!(BoxGrid::new([]).at(p2(0.0, 0.0)).count(), 0);
    }
}
