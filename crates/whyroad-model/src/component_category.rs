//! Reference categories of critical components (LABELING.md 3, after table 2 of Alpamayo-R1). A label's `category` is
//! free text; these are what the page offers, what drafts use and what models are asked for.

use crate::Bilingual;
use crate::decision::closed_set;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

closed_set!(
    /// What a critical component is of.
    ComponentCategory {
        /// Road users, animals and things.
        CriticalObjects = "critical_objects",
        /// The light that the ego obeys.
        TrafficLights = "traffic_lights",
        /// Where to give way or to stop otherwise.
        YieldStopControl = "yield_stop_control",
        /// What is particular about the road ahead.
        RoadEvents = "road_events",
        /// Lanes, their lines, and who they are for.
        LaneAndLaneLines = "lane_and_lane_lines",
        /// Where the route leads.
        RoutingIntent = "routing_intent",
        /// Weather, lighting, grip, blind spots.
        OddConstraints = "odd_constraints",
    }
);

impl ComponentCategory {
    /// Name for people.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::CriticalObjects => ("关键目标", "critical objects"),
            Self::TrafficLights => ("交通信号灯", "traffic lights"),
            Self::YieldStopControl => ("让行/停车控制", "yield or stop control"),
            Self::RoadEvents => ("道路事件", "road events"),
            Self::LaneAndLaneLines => ("车道与车道线", "lane and lane lines"),
            Self::RoutingIntent => ("导航意图", "routing intent"),
            Self::OddConstraints => ("运行设计域约束", "ODD constraints"),
        };
        Bilingual::new(zh, en)
    }
}
