//! The tracked objects in each frame with their boxes, whether they can hide something, and their kinds; the buildings
//! of the map.

use super::scene::Occluder;
use super::scene::Scene;
use super::view::{Owner, SeenBox, View};
use crate::geometry::{OrientedBox, P2, p2};
use crate::target::placement::MOVING_MPS;
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};
use std::cell::RefCell;
use whyroad_model::ObjectClass;

/// Maximum distance from the ego that is examined, m.
const REACH_M: f64 = 150.0;
/// Minimum height of an object that hides something: a driver's eye is at 1.1 to 1.2 m, a child's head is above it.
const LEAST_HEIGHT_M: f64 = 1.0;

/// Kind of an occluder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstacleKind {
    /// Any other motor vehicle.
    Vehicle,
    /// Truck, bus, special vehicle.
    LargeVehicle,
    /// Pedestrian or light two-wheeler.
    Vru,
    /// Any other tracked object.
    Object,
    /// A building of the map.
    Building,
}

fn kind_of(class: ObjectClass) -> ObstacleKind {
    if class.is_large_vehicle() {
        ObstacleKind::LargeVehicle
    } else if class.is_vehicle() {
        ObstacleKind::Vehicle
    } else if class.is_vru() {
        ObstacleKind::Vru
    } else {
        ObstacleKind::Object
    }
}

type Wall = GeomWithData<Line<[f64; 2]>, usize>;

/// A target in one frame.
#[derive(Clone, Copy, Debug)]
pub struct Tracked {
    /// Index of the target.
    pub target: usize,
    /// Row of its track.
    pub row: usize,
    /// Its box, if it is known. A copy: frame by frame, the placements of the targets are far apart in memory.
    pub footprint: Option<OrientedBox>,
    /// In the ego's way.
    pub in_way: bool,
    /// Whether it can hide something.
    hides: bool,
}

/// All tracked objects and all occluders, over the whole drive.
pub struct Obstacles<'a> {
    scene: &'a Scene<'a>,
    by_frame: Vec<Vec<Tracked>>,
    /// The kind of each target.
    kinds: Vec<ObstacleKind>,
    walls: RTree<Wall>,
    /// By target, how its box was seen in the last frame that was looked at.
    seen: RefCell<Vec<Option<SeenBox>>>,
    /// Whether the map has buildings; if not, no area is known to be free of them.
    pub covers_buildings: bool,
}

impl<'a> Obstacles<'a> {
    /// Of this scene.
    pub fn new(scene: &'a Scene<'a>) -> Self {
        let mut counts = vec![0; scene.ego.len()];
        for frame in scene.targets.iter().flat_map(|target| &target.track.frames) {
            counts[*frame as usize] += 1;
        }
        let mut by_frame: Vec<Vec<Tracked>> = counts.into_iter().map(Vec::with_capacity).collect();
        for (k, target) in scene.targets.iter().enumerate() {
            for (row, (&frame, place)) in target.track.frames.iter().zip(&target.places).enumerate() {
                let known = place.as_ref().filter(|p| p.is_sized());
                let low = target.track.height_m[row] < LEAST_HEIGHT_M;
                by_frame[frame as usize].push(Tracked {
                    target: k,
                    row,
                    footprint: known.map(|p| p.footprint),
                    in_way: place.as_ref().is_some_and(|p| p.in_way || p.band.is_some()),
                    hides: known.is_some_and(|p| p.same_level) && !low,
                });
            }
        }
        let map = scene.drive.map.as_ref();
        let buildings = map.into_iter().flat_map(|m| &m.facilities).filter(|f| f.kind == "building");
        let mut walls = Vec::new();
        for (k, building) in buildings.enumerate() {
            let corners: Vec<[f64; 2]> = building.boundary.iter().map(|p| [p.x, p.y]).collect();
            // An outline of two points is one wall.
            let closing = (corners.len() > 2).then(|| (corners[corners.len() - 1], corners[0]));
            let sides = corners.windows(2).map(|w| (w[0], w[1])).chain(closing);
            walls.extend(sides.map(|(a, b)| Wall::new(Line::new(a, b), k)));
        }
        let covers_buildings = map.is_some_and(|m| m.covers("building"));
        let seen = RefCell::new(vec![None; scene.targets.len()]);
        let kinds = scene.targets.iter().map(|target| kind_of(target.track.class)).collect();
        Self { scene, by_frame, kinds, walls: RTree::bulk_load(walls), seen, covers_buildings }
    }

    /// The tracked objects in `frame`, in the order of the targets.
    pub fn tracked(&self, frame: usize) -> &[Tracked] {
        &self.by_frame[frame]
    }

    /// The surroundings of the ego in `frame`; `None` while its pose is unknown.
    pub fn view(&self, frame: usize) -> Option<View> {
        let ego = self.scene.ego;
        if !ego.is_known(frame) {
            return None;
        }
        let eye = ego.position[frame];
        let mut view = View::from(eye, self.by_frame[frame].len());
        let mut seen = self.seen.borrow_mut();
        for tracked in self.by_frame[frame].iter().filter(|t| t.hides) {
            let near = |footprint: &OrientedBox| (footprint.center - eye).is_within(REACH_M);
            if let Some(footprint) = tracked.footprint.filter(near) {
                view.add_box(Owner::Target(tracked.target), footprint, &mut seen[tracked.target]);
            }
        }
        let around =
            AABB::from_corners([eye.x - REACH_M, eye.y - REACH_M], [eye.x + REACH_M, eye.y + REACH_M]);
        let mut walls: Vec<(usize, P2, P2)> = self
            .walls
            .locate_in_envelope_intersecting(&around)
            .map(|w| (w.data, p2(w.geom().from[0], w.geom().from[1]), p2(w.geom().to[0], w.geom().to[1])))
            .collect();
        // The view's order is by building and position, independent of the tree's order.
        walls.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.x.total_cmp(&b.1.x)).then(a.1.y.total_cmp(&b.1.y)));
        for (k, a, b) in walls {
            view.add_wall(Owner::Building(k), a, b);
        }
        Some(view)
    }

    /// The kind of the owner.
    pub fn kind(&self, owner: Owner) -> ObstacleKind {
        match owner {
            Owner::Target(k) => self.kinds[k],
            Owner::Building(_) => ObstacleKind::Building,
        }
    }

    /// The owner by its own id.
    pub fn id(&self, owner: Owner) -> Occluder {
        match owner {
            Owner::Target(k) => Occluder::Track(self.scene.targets[k].track.id.clone()),
            Owner::Building(k) => {
                let map = self.scene.drive.map.as_ref();
                let mut all = map.into_iter().flat_map(|m| &m.facilities).filter(|f| f.kind == "building");
                Occluder::Facility(all.nth(k).map(|f| f.id.clone()).unwrap_or_default())
            }
        }
    }

    /// Whether the owner moves in `frame`; `None` when its speed is unknown or it is not observed then.
    pub fn moves(&self, owner: Owner, frame: usize) -> Option<bool> {
        let Owner::Target(k) = owner else { return Some(false) };
        let target = &self.scene.targets[k];
        let speed = target.speed[target.track.row_at(frame)?];
        (!speed.is_nan()).then_some(speed >= MOVING_MPS)
    }
}
