//! Derives the signal table of one drive, in stages: the ego alone, the road under it, the targets placed around it,
//! and pairs. Each stage is a struct that the next one takes.

use crate::catalog::Catalog;
use crate::conflict::{self, pet, ttc, ttc_lane};
use crate::ego::meta_actions::MetaActions;
use crate::ego::motion::EgoMotion;
use crate::ego::{bus, motion};
use crate::estimate::with_possible_sizes;
use crate::estimate::{Deviations, add_derived, estimate, estimated, estimated_at_the_end};
use crate::needs::{missing, missing_in_part};
use crate::road::context::{self, Channels};
use crate::road::ego_lane::{self, EgoLane};
use crate::road::network::Road;
use crate::road::on_road::OnRoad;
use crate::road::path::{DrivenPath, driven_path};
use crate::road::way::Ways;
use crate::road::{self, curvature, junction, lane_change, lights, proven_turns, route, terrain};
use crate::series::seconds;
use crate::table::TableBuilder;
use crate::target::approach;
use crate::target::interaction::Interaction;
use crate::target::placement::{PlacedRows, Surroundings, Target};
use crate::target::relations::{self, Neighbors};
use crate::target::rows::{Rows, observed_tracks};
use crate::target::{self, crosswalk, free_width, line_crossing};
use crate::wanted::{self, Wanted};
use crate::{behavior, refav, sight};
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::catalog::id;
use whyroad_model::{Drive, Need, SignalTable};

/// All signals that `drive` supports; the others are in `unavailable` with the data that the log lacks. Takes the drive
/// as stored in the lake: missing values are estimated here, from this drive alone.
///
/// Pure, and independent of any order except that of time: tracks are ordered by id.
pub fn derive(drive: &Drive) -> SignalTable {
    derive_wanted(drive, &Wanted::all())
}

/// The requested signals of [`derive`], with their standard deviations and the same values. Inputs that only other
/// signals need are not computed.
pub fn derive_wanted(drive: &Drive, wanted: &Wanted) -> SignalTable {
    let mut table = derive_part(drive, Part::All, wanted);
    wanted.keep(&mut table);
    table
}

/// The last frame of [`derive`], with only positions and motion: the ego, the road under it with its lights, and of
/// each target that is observed then the position, the motion and the lines that it crosses. Interactions, which are
/// most of the work, are left out, and so are targets that had disappeared by then. Each value in the last frame is
/// equal to that of [`derive`]; other frames and columns are unspecified.
pub fn derive_last_frame(drive: &Drive) -> SignalTable {
    let table = derive_part(drive, Part::LastFrame, &Wanted::all());
    SignalTable { unavailable: BTreeMap::new(), ..table }
}

/// Extent of a requested table.
#[derive(Clone, Copy)]
enum Part {
    /// See [`derive_last_frame`].
    LastFrame,
    All,
}

fn derive_part(drive: &Drive, part: Part, wanted: &Wanted) -> SignalTable {
    let drive = with_possible_sizes(drive);
    let mut estimated = match part {
        Part::LastFrame => estimated_at_the_end(&drive),
        Part::All => estimated(&drive),
    };
    add_derived(&mut estimated.drive);
    let drive = &*estimated.drive;
    let missing = missing(drive);
    let mut table = TableBuilder::new(Catalog::bundled(), drive, wanted);
    let in_part = missing_in_part(drive, table.without_boxes()).filter(|need| !missing.contains(need));
    let network = drive.map.as_ref().filter(|_| !missing.contains(&Need::Map)).map(Road::new);
    let mut ego = EgoStage::new(drive, &missing);
    if let Some(ego) = &mut ego {
        ego.motion.sd.clone_from(&estimated.ego);
    }
    write_without_ego(drive, ego.as_ref(), network.as_ref(), &mut table);
    if let Some(ego) = &ego {
        ego.write(&mut table);
        if let Some(on_road) = RoadStage::new(ego, network.as_ref()) {
            on_road.write(&mut table);
            if !wanted::PLACED.iter().any(|family| table.asks(family)) {
                on_road.write_ahead(&[], &mut table);
                if table.asks(wanted::UNPLACED) {
                    PlacedStage::new(&on_road, PlacedRows::None).write_unplaced(&mut table);
                }
                let mut table = table.finish(&missing, in_part);
                estimated.complete(&mut table);
                return table;
            }
            let rows = match part {
                Part::LastFrame => PlacedRows::Last,
                Part::All => PlacedRows::All,
            };
            let mut placed = PlacedStage::new(&on_road, rows);
            placed.note_deviations(&estimated.tracks);
            match part {
                Part::LastFrame => placed.write_places(&mut table),
                Part::All => {
                    placed.write(&mut table);
                    write_pairs(&placed, &mut table);
                }
            }
        }
    }
    let mut table = table.finish(&missing, in_part);
    estimated.complete(&mut table);
    table
}

/// Only the meta actions of [`derive`], without the other signals; `None` when the log has no ego pose.
pub fn meta_actions(drive: &Drive) -> Option<MetaActions> {
    let drive = &*estimate(drive);
    EgoStage::new(drive, &missing(drive)).map(|ego| ego.actions)
}

/// Signals that need no pose of the ego: its bus, the context, the targets relative to it.
fn write_without_ego(
    drive: &Drive,
    ego: Option<&EgoStage<'_>>,
    road: Option<&Road>,
    table: &mut TableBuilder<'_>,
) {
    if let Some(ego) = &drive.ego {
        bus::write(&ego.bus, drive.times.len(), table);
    }
    let channels = Channels::new(drive);
    context::write(&channels, table);
    route::write_stated(drive, &channels, table);
    if table.asks(wanted::RELATIVE) {
        target::motion::write_relative(drive, ego.map(|e| &e.motion), table);
    }
    if let Some(road) = road.filter(|_| table.asks(wanted::CROSSWALK)) {
        crosswalk::write(drive, road, table);
    }
}

/// Stage 1: the ego alone.
pub(crate) struct EgoStage<'d> {
    /// The scene tables.
    pub drive: &'d Drive,
    /// Seconds since the first frame.
    pub times: Vec<f64>,
    /// The ego's motion.
    pub motion: EgoMotion,
    /// Its meta actions.
    pub actions: MetaActions,
}

impl<'d> EgoStage<'d> {
    /// `None` if the log has no pose of the ego.
    fn new(drive: &'d Drive, missing: &BTreeSet<Need>) -> Option<Self> {
        let ego = drive.ego.as_ref().filter(|_| !missing.contains(&Need::EgoPose))?;
        Some(Self::of(drive, ego))
    }

    /// Of the ego of `drive`, whatever else the log lacks.
    pub fn of(drive: &'d Drive, ego: &whyroad_model::scene::Ego) -> Self {
        let times = seconds(drive);
        let motion = EgoMotion::new(ego, &times);
        let actions = MetaActions::new(&motion, &times);
        Self { drive, times, motion, actions }
    }

    fn write(&self, table: &mut TableBuilder<'_>) {
        motion::write(&self.motion, &self.times, table);
        self.actions.write(table);
    }
}

/// Stage 2: the road under the ego, and the path that it drives.
pub(crate) struct RoadStage<'a> {
    /// The stage before.
    pub ego: &'a EgoStage<'a>,
    /// The prepared map; `None` without one.
    pub road: Option<&'a Road>,
    /// The ego's lanes; `None` without a map.
    pub lanes: Option<EgoLane>,
    /// The path driven, continued along the lanes.
    pub path: DrivenPath,
}

impl<'a> RoadStage<'a> {
    /// `None` if no pose of the ego is known in any frame.
    pub fn new(ego: &'a EgoStage<'a>, road: Option<&'a Road>) -> Option<Self> {
        let lanes = road.map(|r| EgoLane::new(r, &ego.motion));
        let path = driven_path(&ego.motion, lanes.as_ref(), &ego.times)?;
        Some(Self { ego, road, lanes, path })
    }

    fn write(&self, table: &mut TableBuilder<'_>) {
        let (drive, motion) = (self.ego.drive, &self.ego.motion);
        curvature::write(&self.path, self.lanes.as_ref(), table);
        let (Some(road), Some(lanes)) = (self.road, &self.lanes) else { return };
        ego_lane::write(lanes, road, motion, table);
        let aside = motion.asides();
        let rows = lane_change::Rows {
            times: &self.ego.times,
            position: &motion.position,
            velocity: &motion.velocity,
            places: &lanes.places,
            aside: &aside,
        };
        table.category(id::EGO_LANE_CHANGE, lane_change::changes(road, &rows));
        if let (Some(states), Some(map)) = (&drive.lights, &drive.map) {
            lights::write(states, map, road, lanes, motion, &drive.times, table);
        }
    }
}

impl RoadStage<'_> {
    /// Signals of the road ahead, and of the room that the targets leave on it.
    fn write_ahead(&self, targets: &[Target<'_>], table: &mut TableBuilder<'_>) {
        let Self { ego, road, lanes, path } = self;
        let (drive, times, motion) = (ego.drive, &ego.times[..], &ego.motion);
        let asked = table.asks(wanted::ROAD_AHEAD) || table.asks(wanted::FREE_WIDTH);
        if let (Some(map), Some(road), Some(lanes), true) = (&drive.map, *road, lanes, asked) {
            let encounters = junction::Encounters::new(road, map, path, motion);
            junction::write(&encounters, path, motion, table);
            let ways = Ways::new(road, lanes);
            let entries = road.lanes.iter().map(|lane| map.lane(&lane.id)).collect();
            let encounters = &encounters;
            let on = OnRoad { drive, map, road, path, ego: motion, lanes, encounters, times, ways, entries };
            if table.asks(wanted::ROAD_AHEAD) {
                road::write(&on, table);
            }
            if table.asks(wanted::FREE_WIDTH) {
                free_width::write(&on, targets, table);
            }
        }
        if drive.map.is_none() && table.asks(wanted::ROAD_AHEAD) {
            proven_turns::write(path, motion, table);
        }
        terrain::write(path, table);
    }
}

/// Stage 3: the targets, placed around the ego, its path and its lanes.
pub(crate) struct PlacedStage<'a> {
    /// The stage before.
    pub on_road: &'a RoadStage<'a>,
    /// Their surroundings.
    pub around: Surroundings<'a>,
    /// The targets in the table's order.
    pub targets: Vec<Target<'a>>,
    /// Lead and follower by frame.
    pub near: Neighbors,
}

impl<'a> PlacedStage<'a> {
    /// Places all targets of the drive, in these of their rows.
    pub fn new(on_road: &'a RoadStage<'a>, rows: PlacedRows) -> Self {
        let ego = on_road.ego;
        let around = Surroundings::new(&ego.motion, &on_road.path, on_road.lanes.as_ref(), on_road.road);
        let targets: Vec<Target<'_>> =
            observed_tracks(ego.drive).map(|t| approach::place(&around, t, &ego.times, rows)).collect();
        let near = relations::neighbors(&targets, ego.motion.len());
        Self { on_road, around, targets, near }
    }

    /// Records the accuracy of the states of the targets; one entry per track of the drive.
    fn note_deviations(&mut self, tracks: &'a [Option<Deviations>]) {
        let all = self.on_road.ego.drive.tracks.iter().zip(tracks);
        let observed = all.filter(|(t, _)| !t.frames.is_empty()).map(|(_, sd)| sd.as_ref());
        self.targets.iter_mut().zip(observed).for_each(|(target, sd)| target.sd = sd);
    }

    /// Input of the families on visibility.
    pub fn scene(&self) -> sight::Scene<'_> {
        let RoadStage { ego, road, path, .. } = self.on_road;
        sight::Scene {
            drive: ego.drive,
            ego: &ego.motion,
            path,
            road: *road,
            targets: &self.targets,
            near: &self.near,
            times: &ego.times,
        }
    }

    /// Signals of the targets that depend only on their positions.
    fn write_places(&self, table: &mut TableBuilder<'_>) {
        let drive = self.on_road.ego.drive;
        if table.asks(wanted::MOTION) || table.asks(wanted::UNPLACED) {
            target::motion::write(drive, &self.targets, table);
        }
        if table.asks(wanted::RELATIONS) {
            relations::write(drive, &self.targets, &self.near, table);
        }
        if table.asks(wanted::LINE_CROSSING) {
            line_crossing::write(drive, &self.targets, table);
        }
    }

    /// Signals of the targets that need no placement, of targets without one.
    fn write_unplaced(&self, table: &mut TableBuilder<'_>) {
        let drive = self.on_road.ego.drive;
        target::motion::write_speeds(drive, &self.targets, table);
        ttc::write_distance(drive, &self.around, &self.targets, table);
    }

    fn write(&self, table: &mut TableBuilder<'_>) {
        let EgoStage { drive, times, motion, .. } = self.on_road.ego;
        self.on_road.write_ahead(&self.targets, table);
        self.write_places(table);
        if table.asks(wanted::TTC) || table.asks(wanted::UNPLACED) {
            ttc::write(drive, &self.around, &self.targets, table);
        }
        if table.asks(wanted::TTC_LANE) {
            ttc_lane::write(drive, &self.around, &self.targets, table);
        }
        if table.asks(wanted::LEAD) {
            relations::write_lead(motion, &self.near, table);
        }
        if table.asks(wanted::SIGHT) {
            sight::write(&self.scene(), table);
        }
        if table.asks(wanted::PET) {
            let rows = Rows::new(drive, table);
            let sweep = pet::EgoSweep::new(motion, times);
            let pets: Vec<Vec<f64>> = self.targets.iter().map(|t| sweep.pet(t, times)).collect();
            table.number(id::TARGET_PET, rows.spread(&self.targets, f64::NAN, |k, r, _| pets[k][r]));
        }
    }
}

/// Stage 4: interactions of the ego and the targets.
fn write_pairs(placed: &PlacedStage<'_>, table: &mut TableBuilder<'_>) {
    let ego = placed.on_road.ego;
    let scene = Interaction {
        drive: ego.drive,
        times: &ego.times,
        actions: &ego.actions,
        around: &placed.around,
        targets: &placed.targets,
        near: &placed.near,
        assigned: OnceCell::new(),
    };
    conflict::write(&scene, table);
    target::write(&scene, table);
    behavior::write(&scene, table);
    if table.asks(wanted::REFAV) {
        refav::write(&scene, table);
    }
}
