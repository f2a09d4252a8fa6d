//! One drive to its signal table: the families in order, each writing its own signals.

use crate::catalogue::Catalogue;
use crate::context::Channels;
use crate::ego_lane::EgoLane;
use crate::ego_motion::EgoMotion;
use crate::interaction::Interaction;
use crate::on_road::OnRoad;
use crate::path::{Continuation, DrivenPath};
use crate::placement::{Surroundings, Target};
use crate::road::Road;
use crate::rows::{Rows, observed_tracks};
use crate::table::TableBuilder;
use crate::target_lanes::TargetLanes;
use crate::way::Ways;
use crate::{
    bus, context, crosswalk, curvature, ego_lane, ego_motion, interaction, junction, lane_change, lights,
    line_crossing, on_road, pet, relations, route, sight, target_motion, terrain, ttc, ttc_lane,
};
use whyroad_model::{Drive, Need, SignalTable};

/// All signals that `drive` supports; the others are in `unavailable` with what the log lacks.
///
/// Pure, and independent of the order in which anything but time comes: tracks are ordered by id.
pub fn derive(drive: &Drive) -> SignalTable {
    let missing = crate::needs::missing(drive);
    let mut table = TableBuilder::new(Catalogue::bundled(), drive);
    let start = drive.times.first().copied().unwrap_or_default();
    let times: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let road = drive.map.as_ref().filter(|_| !missing.contains(&Need::Map)).map(Road::new);
    let ego =
        drive.ego.as_ref().filter(|_| !missing.contains(&Need::EgoPose)).map(|e| EgoMotion::new(e, &times));

    if let Some(ego) = &drive.ego {
        bus::write(&ego.bus, times.len(), &mut table);
    }
    let channels = Channels::new(drive);
    context::write(&channels, &mut table);
    route::write_stated(drive, &channels, &mut table);
    target_motion::write_relative(drive, ego.as_ref(), &mut table);
    if let Some(road) = &road {
        crosswalk::write(drive, road, &mut table);
    }
    if let Some(ego) = &ego {
        write_with_ego(drive, ego, road.as_ref(), &times, &mut table);
    }
    table.finish(&missing)
}

/// The ego's meta actions (LABELING.md 5), one value per frame of the drive; `None` in a frame is unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MetaActions {
    /// Values of `ego.meta_longitudinal`.
    pub longitudinal: Vec<Option<String>>,
    /// Values of `ego.meta_lateral`.
    pub lateral: Vec<Option<String>>,
}

/// Only the meta actions of [`derive`], without the other signals; `None` when the log has no ego pose.
pub fn meta_actions(drive: &Drive) -> Option<MetaActions> {
    let ego_only = Drive {
        meta: drive.meta.clone(),
        times: drive.times.clone(),
        ego: drive.ego.clone(),
        ..Drive::default()
    };
    let missing = crate::needs::missing(&ego_only);
    let start = drive.times.first().copied().unwrap_or_default();
    let times: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let ego = ego_only.ego.as_ref().filter(|_| !missing.contains(&Need::EgoPose))?;
    let mut table = TableBuilder::new(Catalogue::bundled(), &ego_only);
    crate::meta_actions::write(&EgoMotion::new(ego, &times), &times, &mut table);
    let table = table.finish(&missing);
    let values = |name: &str| {
        let column = table.frame_columns.get(name)?;
        Some((0..times.len()).map(|i| column.category(i).map(str::to_owned)).collect())
    };
    Some(MetaActions { longitudinal: values("ego.meta_longitudinal")?, lateral: values("ego.meta_lateral")? })
}

fn write_with_ego(
    drive: &Drive,
    ego: &EgoMotion,
    road: Option<&Road>,
    times: &[f64],
    table: &mut TableBuilder<'_>,
) {
    ego_motion::write(ego, times, table);
    crate::meta_actions::write(ego, times, table);
    let lanes = road.map(|r| EgoLane::new(r, ego));
    let Some(path) = driven_path(ego, lanes.as_ref(), times) else { return };
    curvature::write(&path, lanes.as_ref(), table);
    if let (Some(road), Some(lanes)) = (road, &lanes) {
        ego_lane::write(lanes, road, ego, table);
        let rows = lane_change::Rows {
            times,
            position: &ego.position,
            velocity: &ego.velocity,
            places: &lanes.places,
        };
        table.category("ego.lane_change", lane_change::changes(road, &rows));
        if let (Some(states), Some(map)) = (&drive.lights, &drive.map) {
            lights::write(states, map, road, lanes, ego, &drive.times, table);
        }
    }

    let around = Surroundings { ego, path: &path, lanes: lanes.as_ref(), road };
    let targets: Vec<Target<'_>> = observed_tracks(drive).map(|t| around.place(t, times)).collect();
    let near = relations::neighbours(&targets, ego.len());
    if let (Some(map), Some(road), Some(lanes)) = (&drive.map, road, &lanes) {
        let encounters = junction::Encounters::new(road, &path, ego);
        junction::write(&encounters, &path, ego, table);
        let ways = Ways::new(road, lanes);
        let on = OnRoad { drive, map, road, path: &path, ego, lanes, encounters: &encounters, times, ways };
        on_road::write(&on, &targets, table);
    }
    terrain::write(&path, table);
    target_motion::write(drive, &targets, table);
    relations::write(drive, &targets, &near, table);
    ttc::write(drive, &around, &targets, table);
    ttc_lane::write(drive, &around, &targets, table);
    relations::write_lead(ego, &near, table);
    line_crossing::write(drive, &targets, table);
    let seen = sight::Scene { drive, ego, path: &path, road, targets: &targets, near: &near, times };
    sight::write(&seen, table);
    let rows = Rows::new(drive, table);
    let sweep = pet::EgoSweep::new(ego, times);
    let pets: Vec<Vec<f64>> = targets.iter().map(|t| sweep.pet(t, times)).collect();
    table.number("target.pet", rows.spread(&targets, f64::NAN, |k, r, _| pets[k][r]));
    let on_lanes = road.map(|r| TargetLanes::new(r, &targets));
    let scene = Interaction {
        drive,
        times,
        around: &around,
        targets: &targets,
        near: &near,
        lanes: on_lanes.as_ref(),
    };
    interaction::write(&scene, table);
}

/// The driven path, continued along the ego's lanes where it has any.
pub(crate) fn driven_path(ego: &EgoMotion, lanes: Option<&EgoLane>, times: &[f64]) -> Option<DrivenPath> {
    let first = (0..ego.len()).find(|&i| ego.is_known(i))?;
    let last = (0..ego.len()).rfind(|&i| ego.is_known(i))?;
    let along = |frame: usize| -> Continuation<'_> {
        lanes.and_then(|l| l.at(frame)).map(|on| (on.corridor, on.s, on.lateral))
    };
    DrivenPath::new(ego, times, along(first), along(last))
}
