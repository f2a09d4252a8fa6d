//! Locations of samples: positions that can be compared between drives, place cells, and which samples are near each
//! other.

use crate::item::Position;
use crate::pose::Pose;
use crate::sample::Sample;
use crate::spec::{Polygon, Split};
use std::collections::HashMap;
use whyroad_model::scene::{DriveMeta, FrameOfReference};

/// Mean radius of the Earth, m.
const EARTH_M: f64 = 6_371_008.8;
/// Frame of positions on the Earth.
pub(crate) const GEO: &str = "geo";

/// The position of a pose; `None` where the drive's frame is not fixed to the ground or is private to the drive.
pub(crate) fn position(meta: &DriveMeta, pose: &Pose) -> Option<Position> {
    if meta.frame_of_reference != FrameOfReference::World {
        return None;
    }
    if let Some(origin) = meta.position {
        let latitude = origin.latitude_deg + (pose.y / EARTH_M).to_degrees();
        let parallel = EARTH_M * origin.latitude_deg.to_radians().cos();
        let longitude = origin.longitude_deg + (pose.x / parallel).to_degrees();
        let (lat, lon) = (latitude.to_radians(), longitude.to_radians());
        let p = [EARTH_M * lat.cos() * lon.cos(), EARTH_M * lat.cos() * lon.sin(), EARTH_M * lat.sin()];
        return Some(Position { frame: GEO.to_owned(), p, plane: [longitude, latitude] });
    }
    let place = meta.place.as_ref()?;
    Some(Position { frame: format!("map:{place}"), p: [pose.x, pose.y, 0.0], plane: [pose.x, pose.y] })
}

/// The position that a sample of a release states.
pub(crate) fn of_sample(sample: &Sample) -> Option<Position> {
    let g = &sample.groups;
    let (frame, &[x, y, z]) = (g.position_frame.clone()?, g.position.as_deref()?) else { return None };
    let plane = match g.longitude_latitude.as_deref() {
        Some(&[longitude, latitude]) if frame == GEO => [longitude, latitude],
        _ => [x, y],
    };
    Some(Position { frame, p: [x, y, z], plane })
}

/// Name of the polygon or grid cell that a position is in.
pub(crate) fn cell(position: &Position, split: &Split) -> String {
    let here = |p: &&Polygon| {
        let frame = p.place.as_ref().map_or_else(|| GEO.to_owned(), |place| format!("map:{place}"));
        frame == position.frame && contains(&p.points, position.plane)
    };
    if let Some(polygon) = split.polygons.iter().find(here) {
        return polygon.name.clone();
    }
    let [x, y] = position.plane;
    if position.frame == GEO {
        // Degrees that are the cell's edge at this latitude; rows of equal latitude share one width.
        let high = (split.place_cell_m / EARTH_M).to_degrees();
        let row = (y / high).floor();
        let wide = high / (row * high).to_radians().cos().max(0.01);
        return format!("geo:{}:{}", row as i64, (x / wide).floor() as i64);
    }
    let index = |v: f64| (v / split.place_cell_m).floor() as i64;
    format!("{}:{}:{}", position.frame, index(x), index(y))
}

/// Whether the closed polygon has the point inside, by the even-odd rule.
pub(crate) fn contains<P: Copy + Into<[f64; 2]>>(points: &[P], [x, y]: [f64; 2]) -> bool {
    let mut inside = false;
    for (i, &a) in points.iter().enumerate() {
        let (a, b): ([f64; 2], [f64; 2]) = (a.into(), points[(i + points.len() - 1) % points.len()].into());
        if (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0] {
            inside = !inside;
        }
    }
    inside
}

/// Points in buckets of one edge length, to find near points.
pub(crate) struct Grid<'a> {
    edge: f64,
    buckets: HashMap<(&'a str, [i64; 3]), Vec<u32>>,
    points: Vec<Option<&'a Position>>,
}

impl<'a> Grid<'a> {
    /// Points by index; those without a position are near no other.
    pub fn new(points: Vec<Option<&'a Position>>, edge: f64) -> Self {
        let mut buckets: HashMap<_, Vec<u32>> = HashMap::new();
        for (i, p) in points.iter().enumerate() {
            if let Some(p) = p {
                buckets.entry((p.frame.as_str(), bucket(p.p, edge))).or_default().push(i as u32);
            }
        }
        Self { edge, buckets, points }
    }

    /// Calls `each` with the points closer than the edge length, until it returns false.
    pub fn near(&self, position: &'a Position, mut each: impl FnMut(u32) -> bool) {
        let [a, b, c] = bucket(position.p, self.edge);
        for i in -1..=1 {
            for j in -1..=1 {
                for k in -1..=1 {
                    let key = (position.frame.as_str(), [a + i, b + j, c + k]);
                    for &other in self.buckets.get(&key).into_iter().flatten() {
                        let Some(q) = self.points[other as usize] else { continue };
                        if distance(position, q) < self.edge && !each(other) {
                            return;
                        }
                    }
                }
            }
        }
    }
}

fn bucket(p: [f64; 3], edge: f64) -> [i64; 3] {
    // The bound keeps the neighbors of the farthest bucket representable.
    p.map(|v| (v / edge).floor().clamp(-1e15, 1e15) as i64)
}

pub(crate) fn distance(a: &Position, b: &Position) -> f64 {
    let d: f64 = a.p.iter().zip(b.p).map(|(p, q)| (p - q) * (p - q)).sum();
    d.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::scene::GeoPosition;

    fn at(x: f64, y: f64, latitude_deg: f64, longitude_deg: f64) -> Position {
        let meta =
            DriveMeta { position: Some(GeoPosition { latitude_deg, longitude_deg }), ..DriveMeta::default() };
        position(&meta, &Pose { x, y, ..Pose::default() }).unwrap()
    }

    #[test]
    fn meters_stay_meters_on_the_earth_and_across_origins() {
        let (a, b) = (at(0.0, 0.0, 40.0, 116.0), at(3.0, 4.0, 40.0, 116.0));
        assert!((distance(&a, &b) - 5.0).abs() < 1e-3, "{}", distance(&a, &b));
        // A second drive whose origin is 1 km to the north: the same location has another y there.
        let north = 40.0 + (1000.0 / EARTH_M).to_degrees();
        assert!(distance(&at(0.0, 1000.0, 40.0, 116.0), &at(0.0, 0.0, north, 116.0)) < 0.01);
    }

    #[test]
    fn polygons_win_over_cells() {
        let split = Split {
            polygons: vec![Polygon {
                name: "north".into(),
                place: Some("p".into()),
                points: vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]],
            }],
            ..crate::spec::Spec::default().split
        };
        let meta = DriveMeta { place: Some("p".into()), ..DriveMeta::default() };
        let cell_at = |x| cell(&position(&meta, &Pose { x, y: 5.0, ..Pose::default() }).unwrap(), &split);
        assert_eq!(cell_at(5.0), "north");
        assert_eq!(cell_at(-5.0), "map:p:-1:0");
        assert_eq!(
            position(&DriveMeta::default(), &Pose::default()).map(|p| p.frame),
            None,
            "no place is known"
        );
    }
}
