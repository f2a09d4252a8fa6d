//! How much of each layer of the road a map has: all, part, derived from its geometry, or nothing. Information of an
//! absent layer is unknown, never "none".

use crate::{Bilingual, Need};
use serde::{Deserialize, Serialize};

/// A part of the road that a map may contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapLayer {
    /// Which lanes lead into which.
    Connections,
    /// Where junctions are.
    Junctions,
    /// Which lanes are beside each other.
    Neighbors,
    /// Pedestrian crossings.
    Crosswalks,
    /// Lines at which to stop.
    StopLines,
    /// Where traffic lights are.
    Lights,
    /// Legal speed limits of lanes.
    SpeedLimits,
    /// Marks on the edges of lanes.
    Marks,
    /// Heights of the road.
    Heights,
    /// Which lanes are ramps, or gain or lose speed beside a main road.
    Ramps,
}

/// How much of a layer a map has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayerState {
    /// Complete: what is not in the map is not on the road.
    Complete,
    /// Some of it.
    Partial,
    /// Not stated by the source, but derived from the geometry of its lanes.
    Derived,
    /// Nothing.
    Absent,
}

impl MapLayer {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Connections,
        Self::Junctions,
        Self::Neighbors,
        Self::Crosswalks,
        Self::StopLines,
        Self::Lights,
        Self::SpeedLimits,
        Self::Marks,
        Self::Heights,
        Self::Ramps,
    ];

    /// The need that a log with a map without this layer lacks; `None` where signals depend on something else that is
    /// checked separately (states of lights, marks of each lane, heights), or are always derived (lanes beside each
    /// other).
    pub fn need(self) -> Option<Need> {
        match self {
            Self::Connections => Some(Need::LaneConnections),
            Self::Junctions => Some(Need::Junctions),
            Self::Crosswalks => Some(Need::Crosswalks),
            Self::StopLines => Some(Need::StopLines),
            Self::SpeedLimits => Some(Need::SpeedLimits),
            Self::Ramps => Some(Need::Ramps),
            Self::Neighbors | Self::Lights | Self::Marks | Self::Heights => None,
        }
    }

    /// The displayed name.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Connections => ("车道连接", "connections"),
            Self::Junctions => ("路口", "junctions"),
            Self::Neighbors => ("相邻车道", "neighbors"),
            Self::Crosswalks => ("人行横道", "crosswalks"),
            Self::StopLines => ("停止线", "stop lines"),
            Self::Lights => ("信号灯位置", "lights"),
            Self::SpeedLimits => ("限速", "speed limits"),
            Self::Marks => ("车道线", "marks"),
            Self::Heights => ("高程", "heights"),
            Self::Ramps => ("匝道", "ramps"),
        };
        Bilingual::new(zh, en)
    }
}

impl LayerState {
    /// The displayed name.
    pub fn name(self) -> Bilingual {
        let (zh, en) = match self {
            Self::Complete => ("完整", "complete"),
            Self::Partial => ("部分", "partial"),
            Self::Derived => ("推导", "derived"),
            Self::Absent => ("无", "absent"),
        };
        Bilingual::new(zh, en)
    }
}
