//! The safety filter: the first question of Stage II, answered before any decision is saved (LABELING.md 6).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;
use whyroad_model::messages::SafetyAnswer;

/// Body of `POST /tasks/{t}/safety`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SafetyRequest {
    /// Fencing token of the lease.
    pub fence: i64,
    /// `unsafe` also rejects the task.
    pub answer: SafetyAnswer,
    /// Reasons; required for `unsafe`.
    #[serde(default)]
    pub reasons: Vec<SafetyReason>,
    /// Explanation; required for the reason `other`.
    #[serde(default)]
    pub note: Option<String>,
}

/// Why driving is illegal or unsafe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SafetyReason {
    /// The ego touches something.
    Collision,
    /// The ego passes a red light or a stop sign.
    RanSignal,
    /// The ego drives faster than allowed.
    Speeding,
    /// The ego drives against the direction of traffic.
    WrongWay,
    /// The ego crosses a solid line.
    SolidLine,
    /// The ego does not yield where it must.
    FailedToYield,
    /// The ego keeps too little distance.
    UnsafeGap,
    /// The ego brakes, accelerates or steers hard without need.
    HarshManeuver,
    /// Another reason, which the note states.
    Other,
}

impl SafetyReason {
    /// All reasons, in the order of the page.
    pub const ALL: [Self; 9] = [
        Self::Collision,
        Self::RanSignal,
        Self::Speeding,
        Self::WrongWay,
        Self::SolidLine,
        Self::FailedToYield,
        Self::UnsafeGap,
        Self::HarshManeuver,
        Self::Other,
    ];

    /// The id in labels, exports and the API.
    pub fn id(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::RanSignal => "ran_signal",
            Self::Speeding => "speeding",
            Self::WrongWay => "wrong_way",
            Self::SolidLine => "solid_line",
            Self::FailedToYield => "failed_to_yield",
            Self::UnsafeGap => "unsafe_gap",
            Self::HarshManeuver => "harsh_maneuver",
            Self::Other => "other",
        }
    }

    /// The name for people.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Collision => ("碰撞", "collision"),
            Self::RanSignal => ("闯红灯或停车让行标志", "ran a red light or stop sign"),
            Self::Speeding => ("超速", "speeding"),
            Self::WrongWay => ("逆行或占用对向车道", "against the traffic"),
            Self::SolidLine => ("压实线", "crossed a solid line"),
            Self::FailedToYield => ("未按规定让行", "failed to yield"),
            Self::UnsafeGap => ("车距过近", "unsafe gap"),
            Self::HarshManeuver => ("无必要的急制动、急加速或急转向", "harsh maneuver without need"),
            Self::Other => ("其他", "other"),
        };
        Bilingual::new(zh, en)
    }
}

/// Answers of the safety filter in a project.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SafetyCounts {
    /// Tasks answered as safe.
    pub safe: i64,
    /// Tasks answered as unsafe, and so rejected.
    #[serde(rename = "unsafe")]
    pub unsafe_: i64,
    /// How often each reason was given, by its id.
    pub reasons: BTreeMap<String, i64>,
}
