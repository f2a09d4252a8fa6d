//! The closed sets of driving decisions (LABELING.md 2). Names and meanings for people are in
//! `schema/driving_decisions.yaml`; a test in whyroad-framework keeps the two equal.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

macro_rules! closed_set {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $id:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[schemars(inline)]
        pub enum $name { $($(#[$vdoc])* #[serde(rename = $id)] $variant),+ }

        impl $name {
            /// All members, in the order of the specification.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];
            /// The identifier used in messages.
            pub fn id(self) -> &'static str { match self { $($name::$variant => $id),+ } }
            /// The member with identifier `id`.
            pub fn from_id(id: &str) -> Option<Self> { match id { $($id => Some($name::$variant),)+ _ => None } }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result { f.write_str(self.id()) }
        }
    };
}
pub(crate) use closed_set;

closed_set!(
    /// What the ego does along its path, first after the keyframe.
    Longitudinal {
        /// Hold or reach a target speed, unconstrained.
        SetSpeedTracking = "set_speed_tracking",
        /// Keep a safe time gap to the in-path lead.
        LeadFollowing = "lead_following",
        /// Slow for a road feature.
        RoadSpeedAdaptation = "road_speed_adaptation",
        /// Fit or create a gap for a lateral maneuver.
        GapMatching = "gap_matching",
        /// Speed up to pass a slower lead.
        AccelerationForPassing = "acceleration_for_passing",
        /// Give way to particular agents.
        YieldToAgent = "yield_to_agent",
        /// Hold at a control point.
        StopForRegulation = "stop_for_regulation",
        /// Stop for an obstacle ahead.
        StopForObstacle = "stop_for_obstacle",
        /// Start from standstill.
        Resume = "resume",
    }
);

closed_set!(
    /// What the ego does across its path, first after the keyframe.
    Lateral {
        /// Stay within the lane.
        LaneKeeping = "lane_keeping",
        /// Offset within the lane.
        InLaneNudge = "in_lane_nudge",
        /// Brief line crossing, back to the same lane.
        OutOfLaneNudge = "out_of_lane_nudge",
        /// Full move to the adjacent lane.
        LaneChange = "lane_change",
        /// Between facilities.
        MergeOrSplit = "merge_or_split",
        /// Onto another road.
        Turn = "turn",
        /// Towards the edge or a stop area.
        PullOver = "pull_over",
        /// Cancel a lateral maneuver.
        ManeuverAbort = "maneuver_abort",
        /// Drive backwards.
        Reverse = "reverse",
    }
);

closed_set!(
    /// The side of a lateral decision that has one.
    LateralDirection {
        /// To the left.
        Left = "left",
        /// To the right.
        Right = "right",
        /// Back in the opposite direction; only with `turn`.
        Uturn = "uturn",
    }
);

impl Lateral {
    /// The directions this decision may have; empty when it must have none (LABELING.md 2).
    pub fn directions(self) -> &'static [LateralDirection] {
        use LateralDirection::{Left, Right, Uturn};
        match self {
            Lateral::InLaneNudge | Lateral::OutOfLaneNudge | Lateral::LaneChange => &[Left, Right],
            Lateral::Turn => &[Left, Right, Uturn],
            Lateral::LaneKeeping
            | Lateral::MergeOrSplit
            | Lateral::PullOver
            | Lateral::ManeuverAbort
            | Lateral::Reverse => &[],
        }
    }
}
