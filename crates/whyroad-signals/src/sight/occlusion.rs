//! The visible share of each target and its occluder; also the position that a target must have had before its first
//! observation, to report the object from behind which it appeared. Writes `target.visible_share`, `occluder`,
//! `occluder_moving`.

use super::obstacles::{ObstacleKind, Obstacles, Tracked};
use super::scene::Scene;
use super::view::{Owner, View};
use crate::geometry::OrientedBox;
use crate::table::TableBuilder;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::{id, value::TargetOccluder};

/// Maximum distance of targets that are examined, m.
const REACH_M: f64 = 80.0;
/// Maximum distance of the first observation of targets that are traced back, m.
const TRACED_REACH_M: f64 = 60.0;
/// Time before the first observation for which they are traced back, s.
pub const TRACED_BACK_S: f64 = 1.0;

/// Visibility of a target in one frame.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The frame.
    pub frame: usize,
    /// Visible share; NaN when unknown.
    pub share: f64,
    /// The object that hides most of it; `None` if nothing does, or if `share` is below 1 and the occluder is unknown.
    pub occluder: Option<Owner>,
}

/// A position that a target must have had while it was not observed.
struct Trace {
    target: usize,
    row: usize,
    footprint: OrientedBox,
}

/// Shares and occluders of all targets.
pub struct Occlusion<'a> {
    scene: &'a Scene<'a>,
    /// By target and row.
    pub rows: Vec<Vec<Seen>>,
    /// By target: the row before which it was traced, and the visibility of the position then; frames ascend.
    pub traced: Vec<Vec<(usize, Seen)>>,
    traces: Vec<Vec<Trace>>,
}

impl<'a> Occlusion<'a> {
    /// Before the first frame.
    pub fn new(scene: &'a Scene<'a>) -> Self {
        let unseen = |frame: &u32| Seen { frame: *frame as usize, share: f64::NAN, occluder: None };
        let rows = scene.targets.iter().map(|t| t.track.frames.iter().map(unseen).collect()).collect();
        let mut traces: Vec<Vec<Trace>> = (0..scene.ego.len()).map(|_| Vec::new()).collect();
        (0..scene.targets.len()).for_each(|k| trace_back(scene, k, &mut traces));
        Self { scene, rows, traced: vec![Vec::new(); scene.targets.len()], traces }
    }

    /// Processes all targets of one frame.
    pub fn look(&mut self, frame: usize, view: Option<&View>, obstacles: &Obstacles<'_>) {
        let eye = self.scene.ego.position[frame];
        for &Tracked { target: k, row, footprint, .. } in obstacles.tracked(frame) {
            let near = |footprint: &OrientedBox| (footprint.center - eye).is_within(REACH_M);
            let seen = &mut self.rows[k][row];
            if let (Some(view), Some(footprint)) = (view, footprint.filter(near))
                && let Some(sight) = view.sight(Some(Owner::Target(k)), &footprint)
            {
                (seen.share, seen.occluder) = (sight.share, sight.occluder);
            }
            self.take_told(k, row);
        }
        for trace in &self.traces[frame] {
            let own = Some(Owner::Target(trace.target));
            if let Some(sight) = view.and_then(|v| v.sight(own, &trace.footprint)) {
                let seen = Seen { frame, share: sight.share, occluder: sight.occluder };
                self.traced[trace.target].push((trace.row, seen));
            }
        }
    }

    /// The source's own sensor model has priority over our computation.
    fn take_told(&mut self, k: usize, row: usize) {
        let track = self.scene.targets[k].track;
        let seen = &mut self.rows[k][row];
        let Some(&share) = track.visible_share.get(row).filter(|s| !s.is_nan()) else { return };
        seen.share = share;
        let told = track.occluder.get(row).and_then(Option::as_ref);
        let named = told
            .and_then(|id| self.scene.targets.binary_search_by(|t| t.track.id.cmp(id)).ok())
            .map(Owner::Target);
        seen.occluder = if share >= 1.0 { None } else { named.or(seen.occluder) };
    }

    /// Writes the signals of this file.
    pub fn write(&self, obstacles: &Obstacles<'_>, table: &mut TableBuilder<'_>) {
        let rows = Rows::new(self.scene.drive, table);
        let targets = self.scene.targets;
        table.number(
            id::TARGET_VISIBLE_SHARE,
            rows.spread(targets, f64::NAN, |k, r, _| self.rows[k][r].share),
        );
        let kind = |k: usize, r: usize| -> Option<TargetOccluder> {
            let seen = self.rows[k][r];
            match seen.occluder {
                Some(owner) => Some(code(obstacles.kind(owner))),
                None => (seen.share >= 1.0).then_some(TargetOccluder::None),
            }
        };
        table.category(id::TARGET_OCCLUDER, rows.spread(targets, None, |k, r, _| kind(k, r)));
        let moving = |k: usize, r: usize| {
            let seen = self.rows[k][r];
            match seen.occluder {
                Some(owner) => obstacles.moves(owner, seen.frame).into(),
                None if seen.share >= 1.0 => Tri::False,
                None => Tri::Unknown,
            }
        };
        table.flag(id::TARGET_OCCLUDER_MOVING, rows.spread(targets, Tri::Unknown, |k, r, _| moving(k, r)));
    }
}

/// The value of target.occluder.
fn code(kind: ObstacleKind) -> TargetOccluder {
    match kind {
        ObstacleKind::Vehicle => TargetOccluder::Vehicle,
        ObstacleKind::LargeVehicle => TargetOccluder::LargeVehicle,
        ObstacleKind::Vru => TargetOccluder::Vru,
        ObstacleKind::Object => TargetOccluder::Object,
        ObstacleKind::Building => TargetOccluder::Building,
    }
}

/// The positions that the target must have had in the frames before its observation, from its first velocity: before
/// its first row and in the gaps between rows.
fn trace_back(scene: &Scene<'_>, k: usize, traces: &mut [Vec<Trace>]) {
    let target = &scene.targets[k];
    let frames = &target.track.frames;
    for (row, place) in target.places.iter().enumerate() {
        let before = if row == 0 { 0 } else { frames[row - 1] as usize + 1 };
        let frame = frames[row] as usize;
        let Some(p) = place.as_ref().filter(|p| before < frame && p.is_sized() && p.velocity.is_finite())
        else {
            continue;
        };
        if (p.footprint.center - scene.ego.position[frame]).norm() > TRACED_REACH_M {
            continue;
        }
        for earlier in (before..frame).rev() {
            let ago = scene.times[frame] - scene.times[earlier];
            if ago > TRACED_BACK_S + 1e-6 {
                break;
            }
            let center = p.footprint.center - p.velocity * ago;
            traces[earlier].push(Trace { target: k, row, footprint: p.footprint.moved_to(center) });
        }
    }
}
