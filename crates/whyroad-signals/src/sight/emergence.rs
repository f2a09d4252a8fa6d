//! When a target comes out from behind an object, and from which kind of object. Writes `target.emerges`, `emergence`,
//! `hidden_by_lead`.

use super::obstacles::Obstacles;
use super::occlusion::{Occlusion, Seen, TRACED_BACK_S};
use super::scene::Scene;
use super::view::Owner;
use crate::table::TableBuilder;
use crate::target::rows::Rows;
use whyroad_model::Tri;
use whyroad_model::catalog::{id, value::TargetEmergence};

/// Minimum visible share of a visible target.
const VISIBLE_SHARE: f64 = 0.2;
/// Maximum visible share of a hidden target.
const HIDDEN_SHARE: f64 = 0.1;
/// Maximum visible share of a target that is hidden by a lead.
const HIDDEN_BY_LEAD_SHARE: f64 = 0.3;
/// Maximum distance for emergence, m.
const REACH_M: f64 = 60.0;
/// Time for which the cause is reported, s.
const HELD_S: f64 = 3.0;
/// An occluder that moved within this time is dynamic, s (TAXONOMY.md vru_emergence: parked means at least 3 s).
const STOOD_S: f64 = 3.0;
/// A vehicle that was the lead at most this long ago counts as lead, s.
const LEAD_S: f64 = 2.0;

/// The three signals of one row.
#[derive(Clone, Copy)]
struct Row {
    emerges: Tri,
    emergence: Option<TargetEmergence>,
    by_lead: Tri,
}

/// Writes the signals of this file.
pub fn write(
    scene: &Scene<'_>,
    occlusion: &Occlusion<'_>,
    obstacles: &Obstacles<'_>,
    table: &mut TableBuilder<'_>,
) {
    let told: Vec<Vec<Row>> =
        (0..scene.targets.len()).map(|k| rows_of(scene, occlusion, obstacles, k)).collect();
    let rows = Rows::new(scene.drive, table);
    let targets = scene.targets;
    table.flag(id::TARGET_EMERGES, rows.spread(targets, Tri::Unknown, |k, r, _| told[k][r].emerges));
    table.category(id::TARGET_EMERGENCE, rows.spread(targets, None, |k, r, _| told[k][r].emergence));
    table.flag(id::TARGET_HIDDEN_BY_LEAD, rows.spread(targets, Tri::Unknown, |k, r, _| told[k][r].by_lead));
}

fn rows_of(scene: &Scene<'_>, occlusion: &Occlusion<'_>, obstacles: &Obstacles<'_>, k: usize) -> Vec<Row> {
    let mut traced = occlusion.traced[k].iter().peekable();
    let mut hidden: Option<Seen> = None;
    let mut emerged: Option<(f64, Option<TargetEmergence>)> = None;
    let mut emerged_before = false;
    let mut out = Vec::with_capacity(occlusion.rows[k].len());
    for (row, seen) in occlusion.rows[k].iter().enumerate() {
        while let Some((_, earlier)) = traced.next_if(|(before, _)| *before <= row) {
            if earlier.share < HIDDEN_SHARE {
                hidden = Some(*earlier);
            }
        }
        let now = scene.times[seen.frame];
        let recent = |h: &Seen| now - scene.times[h.frame] <= TRACED_BACK_S + 1e-6;
        let from = hidden.filter(recent);
        let emerges = emerges(scene, k, row, seen, from.is_some());
        if emerges.is_true() && !emerged_before {
            emerged = Some((now, from.and_then(|h| cause(scene, obstacles, &h))));
        }
        emerged_before = emerges.is_true();
        let held = emerged.filter(|(since, _)| now - since <= HELD_S + 1e-6);
        let emergence = match held {
            Some((_, cause)) => cause,
            None => emerges.known().map(|_| TargetEmergence::None),
        };
        let behind_lead =
            from.filter(|_| emerges.is_true()).is_some_and(|h| is_lead(scene, h.occluder, h.frame));
        let by_lead = Tri::from(behind_lead).or(hidden_by_lead(scene, seen));
        if seen.share < HIDDEN_SHARE {
            hidden = Some(*seen);
        }
        out.push(Row { emerges, emergence, by_lead });
    }
    out
}

fn emerges(scene: &Scene<'_>, k: usize, row: usize, seen: &Seen, was_hidden: bool) -> Tri {
    let Some(place) = &scene.targets[k].places[row] else { return Tri::Unknown };
    if !(place.footprint.center - scene.ego.position[seen.frame]).is_within(REACH_M) {
        return Tri::False;
    }
    if seen.share.is_nan() {
        return Tri::Unknown;
    }
    Tri::from(seen.share >= VISIBLE_SHARE && was_hidden)
}

fn hidden_by_lead(scene: &Scene<'_>, seen: &Seen) -> Tri {
    if seen.share.is_nan() || (seen.share < HIDDEN_BY_LEAD_SHARE && seen.occluder.is_none()) {
        return Tri::Unknown;
    }
    Tri::from(seen.share < HIDDEN_BY_LEAD_SHARE && is_lead(scene, seen.occluder, seen.frame))
}

/// True when `who` is the ego's lead in `frame` or was shortly before.
fn is_lead(scene: &Scene<'_>, who: Option<Owner>, frame: usize) -> bool {
    let Some(Owner::Target(k)) = who else { return false };
    (0..=frame)
        .rev()
        .take_while(|&f| scene.times[frame] - scene.times[f] <= LEAD_S + 1e-6)
        .any(|f| scene.near.lead[f].is_some_and(|(lead, _)| lead == k))
}

/// Whether the occluder was stationary or moved before.
fn cause(scene: &Scene<'_>, obstacles: &Obstacles<'_>, hidden: &Seen) -> Option<TargetEmergence> {
    let owner = hidden.occluder?;
    let known: Vec<bool> = (0..=hidden.frame)
        .rev()
        .take_while(|&f| scene.times[hidden.frame] - scene.times[f] <= STOOD_S + 1e-6)
        .filter_map(|f| obstacles.moves(owner, f))
        .collect();
    if known.is_empty() {
        return None;
    }
    Some(if known.contains(&true) { TargetEmergence::Dynamic } else { TargetEmergence::Static })
}
