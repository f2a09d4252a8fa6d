//! Where the nodes of a Lanelet2 map lie in the log's frame.

use super::document::{Document, Node};
use crate::maps::MapFault;
use crate::maps::options::Placement;
use std::collections::HashMap;
use whyroad_model::road_map::Point3;

/// Most points that the features of a file may have.
pub(super) const MAX_POINTS: usize = 8_000_000;

/// Places nodes in the log's frame.
pub(in crate::maps) struct Ground {
    points: HashMap<i64, Point3>,
    left: usize,
}

impl Ground {
    pub fn of(document: &Document, placement: &Placement) -> Result<Self, MapFault> {
        let place = |node: &Node| {
            let z = node.height.unwrap_or(f64::NAN);
            let [x, y] = match placement.projection {
                Some(projection) => {
                    let (lat, lon) =
                        (node.lat.filter(|v| v.abs() < 89.0)?, node.lon.filter(|v| v.abs() <= 180.0)?);
                    let (lat, lon) = placement.datum.to_wgs84(lat, lon);
                    projection.point(lat, lon)
                }
                None => [node.local.0?, node.local.1?],
            };
            [x, y].iter().all(|v| v.abs() < 1e9).then_some(Point3 { x, y, z })
        };
        let points: HashMap<i64, Point3> =
            document.nodes.iter().filter_map(|(id, node)| Some((*id, place(node)?))).collect();
        if points.is_empty() && !document.nodes.is_empty() {
            let why = "its nodes have neither local_x and local_y, nor degrees with a stated origin";
            return Err(MapFault::Unplaced(why.to_owned()));
        }
        Ok(Self { points, left: MAX_POINTS })
    }

    /// The line of a way; `None` when a node of it is not there, or the file has too many points.
    pub fn line(&mut self, nodes: &[i64]) -> Option<Vec<Point3>> {
        self.left = self.left.checked_sub(nodes.len())?;
        nodes.iter().map(|id| self.points.get(id).copied()).collect()
    }
}
