//! The requested signals of a drive. Signals are derived in families, one file each: a family is skipped if none of its
//! signals, nor any signal that depends on them, is requested. Inexpensive families are always derived; they are not
//! listed here.

use std::collections::BTreeSet;
use whyroad_model::catalog::id;
use whyroad_model::signal::is_deviation;
use whyroad_model::{SignalId, SignalTable};

/// Requested signals.
#[derive(Clone, Debug)]
pub struct Wanted(Option<Chosen>);

#[derive(Clone, Debug)]
struct Chosen {
    /// The requested ones.
    asked: BTreeSet<SignalId>,
    /// The same with those on which they depend.
    derived: BTreeSet<SignalId>,
}

impl Wanted {
    /// All signals that the drive supports.
    pub const fn all() -> Self {
        Self(None)
    }

    /// The signals with these names; names that are not signals are ignored.
    pub fn only<'n>(names: impl IntoIterator<Item = &'n str>) -> Self {
        let asked: BTreeSet<SignalId> = names.into_iter().filter_map(SignalId::from_name).collect();
        let (mut derived, mut open) = (asked.clone(), asked.iter().copied().collect::<Vec<_>>());
        while let Some(signal) = open.pop() {
            let sources = FOLLOWS.iter().filter(|(of, _)| *of == signal).flat_map(|(_, from)| *from);
            open.extend(sources.filter(|source| derived.insert(**source)));
        }
        Self(Some(Chosen { asked, derived }))
    }

    /// True if one of these is requested, or a signal that depends on it.
    pub(crate) fn any(&self, family: &[SignalId]) -> bool {
        self.0.as_ref().is_none_or(|some| family.iter().any(|signal| some.derived.contains(signal)))
    }

    /// [`Wanted::any`] for a signal by its name.
    pub(crate) fn has(&self, name: &str) -> bool {
        let derived = |some: &Chosen| SignalId::from_name(name).is_some_and(|id| some.derived.contains(&id));
        self.0.as_ref().is_none_or(derived)
    }

    /// Removes the signals that were not requested from a table.
    pub(crate) fn keep(&self, table: &mut SignalTable) {
        let Some(some) = &self.0 else { return };
        let asked = |name: &str| SignalId::from_name(name).is_some_and(|id| some.asked.contains(&id));
        let of_column = |name: &String| {
            let signal =
                name.rsplit_once('.').filter(|_| is_deviation(name)).map_or(name.as_str(), |(of, _)| of);
            asked(signal)
        };
        table.frame_columns.retain(|name, _| of_column(name));
        table.target_columns.retain(|name, _| of_column(name));
        table.unavailable.retain(|name, _| asked(name));
        table.partial.retain(|name, _| asked(name));
    }
}

/// Signals that are read from the table when a signal or its standard deviation is computed.
const FOLLOWS: &[(SignalId, &[SignalId])] = &[
    (id::TARGET_TTC.id(), &[id::TARGET_GAP.id(), id::TARGET_RELATIVE_SPEED.id()]),
    (id::TARGET_TTC_LANE.id(), &[id::TARGET_GAP.id(), id::TARGET_RELATIVE_SPEED.id()]),
    (id::TARGET_TTC_BOX.id(), &[id::TARGET_GAP.id(), id::TARGET_RELATIVE_SPEED.id()]),
    (id::LEAD_GAP.id(), &[id::TARGET_GAP.id(), id::TARGET_IS_LEAD.id()]),
    (id::LEAD_TTC.id(), &[id::TARGET_TTC.id(), id::TARGET_IS_LEAD.id()]),
    (id::LEAD_THW.id(), &[id::TARGET_THW.id(), id::TARGET_IS_LEAD.id()]),
    (id::LEAD_SPEED.id(), &[id::TARGET_SPEED.id(), id::TARGET_IS_LEAD.id()]),
    (id::LEAD_ACCEL.id(), &[id::TARGET_ACCEL.id(), id::TARGET_IS_LEAD.id()]),
    (id::LEAD_CHANGES_LANE.id(), &[id::TARGET_LANE_CHANGE.id()]),
    (id::EGO_FAIR_SPEED.id(), &[id::MAP_SPEED_LIMIT.id(), id::LEAD_THW.id()]),
    (id::TRAFFIC_CONGESTED.id(), &[id::EGO_MEAN_SPEED.id()]),
    (id::MAP_BENDS_AROUND.id(), &[id::MAP_GRADE.id(), id::EGO_IN_JUNCTION.id()]),
    (id::MAP_SLOPE_LENGTH.id(), &[id::MAP_GRADE.id(), id::EGO_IN_JUNCTION.id()]),
    (id::MAP_MEAN_GRADE.id(), &[id::MAP_GRADE.id(), id::EGO_IN_JUNCTION.id()]),
];

/// Lists of signals, one per family; with `in LIST`, also the list of these families.
macro_rules! families {
    ($(#[$list_doc:meta])* in $list:ident; $($(#[$doc:meta])* $name:ident: $($signal:ident)+;)+) => {
        families! { $($(#[$doc])* $name: $($signal)+;)+ }
        $(#[$list_doc])* pub(crate) const $list: &[&[SignalId]] = &[$($name),+];
    };
    ($($(#[$doc:meta])* $name:ident: $($signal:ident)+;)+) => {
        $($(#[$doc])* pub(crate) const $name: &[SignalId] = &[$(id::$signal.id()),+];)+
    };
}

families! {
    /// Map data ahead of the ego and beside it.
    ROAD_AHEAD: CONTEXT_PAVEMENT EGO_IN_JUNCTION EGO_MOVEMENT EGO_TURN_ANGLE GATE_STATE MAP_CROSSWALK_SIGNALISED
        MAP_DEAD_END_DISTANCE MAP_DISTANCE_TO_ACCIDENT MAP_DISTANCE_TO_BARRIER_GAP MAP_DISTANCE_TO_CONSTRUCTION
        MAP_DISTANCE_TO_CROSSWALK MAP_DISTANCE_TO_DRIVEWAY MAP_DISTANCE_TO_GATE MAP_DISTANCE_TO_JUNCTION
        MAP_DISTANCE_TO_LIMIT_CHANGE MAP_DISTANCE_TO_MERGE MAP_DISTANCE_TO_ROUNDABOUT MAP_DISTANCE_TO_SPEED_BUMP
        MAP_DISTANCE_TO_SPLIT MAP_DISTANCE_TO_STOP_LINE MAP_DISTANCE_TO_TOLL MAP_DISTANCE_TO_TUNNEL
        MAP_DISTANCE_TO_WAITING_AREA MAP_DRIVING_SIDE MAP_FACILITY_CHANGE MAP_GRADE MAP_GRADE_AHEAD
        MAP_IN_CONSTRUCTION MAP_IN_ROUNDABOUT MAP_IN_TUNNEL MAP_IN_WAITING_AREA MAP_JUNCTION_ARMS
        MAP_JUNCTION_EXITS MAP_JUNCTION_IRREGULAR MAP_JUNCTION_SIGNALISED MAP_JUNCTION_STATED MAP_LANE_COUNT_AHEAD
        MAP_BUS_LANE MAP_TIDAL_LANE MAP_VARIABLE_LANE MAP_LANE_ENDS MAP_LANE_KIND MAP_LANE_MARKED MAP_LANE_TURNS MAP_LANE_WIDTH_AHEAD MAP_LEFT_LANE MAP_LEFT_MARK
        MAP_MERGE_ZONE MAP_ON_GUIDANCE MAP_ON_RAMP MAP_OPEN_AREA MAP_OPPOSING_ARM MAP_RIGHT_LANE MAP_RIGHT_MARK
        MAP_ROUNDABOUT_LANES MAP_SPEED_LIMIT MAP_SPEED_LIMIT_AHEAD MAP_TIME_TO_BARRIER_GAP MAP_TIME_TO_CROSSWALK
        MAP_TIME_TO_JUNCTION MAP_TIME_TO_STOP_LINE MAP_TOLL_KIND ROUTE_LANE_FITS SIGN_LANE_ARROW_DISTANCE
        SIGN_PROHIBITION_DISTANCE SIGN_PROHIBITION_KIND SIGN_SPEED_LIMIT_DISTANCE SIGN_STOP_DISTANCE
        SIGN_WARNING_DISTANCE SIGN_WARNING_KIND SIGN_YIELD_DISTANCE;
    /// Position and heading relative to the ego.
    RELATIVE: TARGET_OBSERVED TARGET_CLASS TARGET_LARGE_VEHICLE TARGET_VISIBLE TARGET_TURN_SIGNAL TARGET_LONGITUDINAL
        TARGET_LATERAL TARGET_OPPOSITE_DIRECTION TARGET_HEADING_DIFFERENCE;
    /// Speeds of targets and distances of their boxes: the ego must be on a path, but no target is placed on it.
    UNPLACED: TARGET_SPEED TARGET_ACCEL TARGET_STANDSTILL TARGET_DISTANCE;
    CROSSWALK: TARGET_DISTANCE_TO_CROSSWALK TARGET_IN_JUNCTION TARGET_ON_CROSSWALK TARGET_ON_ROAD;
}

families! {
    /// Families for which targets are placed around the ego, its path and its lane.
    in PLACED;
    /// Free space beside and between targets.
    FREE_WIDTH: MAP_FREE_WIDTH_AHEAD MAP_FREE_WIDTH_LEFT MAP_FREE_WIDTH_RIGHT MAP_MEETING_WIDTH_AHEAD;
    MOTION: TARGET_PATH_LONGITUDINAL TARGET_PATH_LATERAL TARGET_CROSSING_ANGLE;
    RELATIONS: TARGET_IN_EGO_LANE TARGET_IS_LEAD TARGET_IS_FOLLOWER TARGET_RELATION;
    LINE_CROSSING: TARGET_LANE_CENTRE_DISTANCE TARGET_LANE_LATERAL_SPEED TARGET_LATERAL_OFFSET TARGET_WHEEL_OVER_LINE;
    TTC: TARGET_DRAC TARGET_GAP TARGET_THW TARGET_TTC TARGET_TTC_BOX;
    TTC_LANE: TARGET_TTC_LANE;
    LEAD: LEAD_EXISTS LEAD_GAP LEAD_TTC LEAD_THW LEAD_SPEED LEAD_ACCEL;
    SIGHT: MAP_CURVE_HIDDEN MAP_SIGHT_DISTANCE MAP_HIDDEN_BESIDE MAP_HIDDEN_BESIDE_BY MAP_TIME_TO_HIDDEN_BESIDE
        MAP_SIGHT_ANGLE TARGET_EMERGENCE TARGET_EMERGES TARGET_HIDDEN_BY_LEAD TARGET_OCCLUDER TARGET_OCCLUDER_MOVING
        TARGET_VISIBLE_SHARE MAP_CREST_AHEAD;
    PET: TARGET_PET;
    TTC_ACCEL: TARGET_TTC_ACCEL TARGET_TTC_BOX_ACCEL;
    CRITICALITY: TARGET_A_LONG_REQ TARGET_BTN TARGET_DST TARGET_STN TARGET_TET TARGET_TIT;
    CONFLICT_POINT: TARGET_CROSSES_PATH TARGET_EGO_TIME_TO_CONFLICT TARGET_ONCOMING_GAP TARGET_TIME_TO_CONFLICT;
    TIME_TO_LINE: EGO_TIME_TO_LINE TARGET_TIME_TO_LINE;
    LANE_CHANGES: TARGET_LANE_CHANGE TARGET_WEAVES TARGET_WRONG_WAY;
    RAMP: TARGET_ON_RAMP;
    SIDE: TARGET_LANE_SIDE TARGET_MOVES_ALONG TARGET_RELATIVE_SPEED TARGET_SIDE;
    TURNS: TARGET_TURNS;
    DETOUR: TARGET_DETOUR;
    STOPS: EGO_MEAN_SPEED EGO_MOVES_OFF EGO_STOP_AND_GO EGO_STOP_COUNT EGO_TIME_STANDING;
    TARGETS_BY_THEMSELVES: TARGET_BOX_JUMPS TARGET_REVERSES TARGET_STARTS TARGET_SUDDEN_BRAKE TARGET_TIME_STANDING
        TARGET_WAS_PARKED;
    PASSING: TARGET_IN_BAND TARGET_LATERAL_GAP TARGET_PASSING TARGET_PATH_SIDE_DISTANCE;
    OVERTAKING: EGO_PASSED_SLOWER TARGET_OVERTAKEN;
    TRAFFIC: TRAFFIC_CONGESTED TRAFFIC_DENSITY TRAFFIC_MEAN_SPEED TRAFFIC_QUEUE_POSITION;
    LEAD_BEHAVIOR: LEAD_BRAKING LEAD_CHANGES_LANE LEAD_CLASS LEAD_LARGE LEAD_LEFT_LANE LEAD_STOPPED_TIME;
    LANE_CHANGE_PHASE: EGO_LANE_CHANGE_ABORTED EGO_LANE_CHANGE_PHASE;
    SWERVE: EGO_LATERAL_DEVIATION EGO_SWERVE;
    TURNING: EGO_NET_TURN;
    FAIR_SPEED: EGO_FAIR_SPEED;
    RESPONDS: EGO_RESPONDS;
    REFAV: EGO_REFAV_NEAR_INTERSECTION EGO_REFAV_STATIONARY EGO_REFAV_TURNING TARGET_REFAV_CROSSED_BY
        TARGET_REFAV_FOLLOWING TARGET_REFAV_HEADING TARGET_REFAV_NEAR_INTERSECTION TARGET_REFAV_RELATIVE_DIRECTION
        TARGET_REFAV_STATIONARY TARGET_REFAV_TURNING;
}
