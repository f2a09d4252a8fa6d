//! Reference categories of critical components (LABELING.md 3, after table 2 of Alpamayo-R1). A label's `category` is
//! free text; the page, drafts and model prompts use these.

use crate::Bilingual;
use crate::decision::closed_set;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

closed_set!(
    /// Category of a critical component.
    ComponentCategory {
        /// Road users, animals and things.
        CriticalObjects = "critical_objects",
        /// The light that the ego obeys.
        TrafficLights = "traffic_lights",
        /// Other places to give way or to stop.
        YieldStopControl = "yield_stop_control",
        /// Special features of the road ahead.
        RoadEvents = "road_events",
        /// Lanes, their lines, and their users.
        LaneAndLaneLines = "lane_and_lane_lines",
        /// Where the route leads.
        RoutingIntent = "routing_intent",
        /// Weather, lighting, grip, blind spots.
        OddConstraints = "odd_constraints",
    }
);

impl ComponentCategory {
    /// Displayed name.
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
