//! Where a network ends. SUMO's vehicles vanish at its dead ends; those on the border of the modeled area represent
//! roads that continue, those inside it are real dead ends.

use crate::encodings::xml::Element;
use std::collections::BTreeMap;

/// A node this near to the convex hull of all nodes is on the border, m.
const ON_BORDER_M: f64 = 2.0;

type Point = (f64, f64);

/// Places of the nodes, and which of them are dead ends.
#[derive(Default)]
pub(super) struct Border {
    nodes: Vec<Point>,
    dead_ends: BTreeMap<String, Point>,
}

/// Positive when `c` lies left of the line from `a` to `b`.
fn side(a: Point, b: Point, c: Point) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for p in points {
            while chain.len() >= 2 && side(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0 {
                chain.pop();
            }
            chain.push(p);
        }
        chain
    };
    let mut ring = half(&mut points.iter().copied());
    ring.pop();
    ring.extend(half(&mut points.iter().rev().copied()));
    ring
}

impl Border {
    /// Takes note of a `<junction>`.
    pub fn add(&mut self, e: &Element<'_>) {
        let kind = e.get("type");
        let (Some(x), Some(y)) = (e.number("x"), e.number("y")) else { return };
        if kind.as_deref() == Some("internal") {
            return;
        }
        self.nodes.push((x, y));
        if let Some(id) = e.text("id").filter(|_| kind.as_deref() == Some("dead_end")) {
            self.dead_ends.insert(id, (x, y));
        }
    }

    /// Ids of the dead ends at which roads lead out of the network.
    pub fn exits(&self) -> Vec<&str> {
        let ring = hull(self.nodes.clone());
        let near = |p: Point| {
            ring.windows(2).any(|w| {
                let length = (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1);
                length > 0.0 && side(w[0], w[1], p).abs() / length <= ON_BORDER_M
            })
        };
        self.dead_ends.iter().filter(|(_, p)| near(**p)).map(|(id, _)| id.as_str()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_street_that_ends_inside_leads_nowhere() {
        let ends = [
            ("w", (0.0, 0.0)),
            ("e", (100.0, 0.0)),
            ("n", (50.0, 90.0)),
            ("s", (20.0, -40.0)),
            ("yard", (50.0, 30.0)),
        ];
        let border = Border {
            nodes: ends.iter().map(|e| e.1).chain([(50.0, 0.0)]).collect(),
            dead_ends: ends.iter().map(|(id, p)| ((*id).to_owned(), *p)).collect(),
        };
        assert_eq!(border.exits(), ["e", "n", "s", "w"]);
    }
}
