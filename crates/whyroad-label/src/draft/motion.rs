//! The ego's motion after the keyframe, as used by the decision and by the conditions on the moment.

use whyroad_model::SignalTable;
use whyroad_model::decision::LateralDirection;

/// Frames after the keyframe in which the first action is searched: the 6 s of a sample's future (LABELING.md 4).
pub(super) const HORIZON_FRAMES: usize = 60;

/// The first longitudinal motion of the ego after the keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LongitudinalMotion {
    /// No change: keeps its speed, or is stationary.
    Keeps,
    /// Slows without stopping.
    Slows,
    /// Slows and stops.
    Stops,
    /// Moves off from standstill.
    Starts,
    /// Waits, and moves off later or when the light allows it.
    Waits,
    /// Speeds up while moving.
    SpeedsUp,
    /// Not known from the signals.
    Unknown,
}

impl LongitudinalMotion {
    /// All values.
    pub const ALL: [Self; 7] =
        [Self::Keeps, Self::Slows, Self::Stops, Self::Starts, Self::Waits, Self::SpeedsUp, Self::Unknown];

    /// Its id in `schema/draft_texts.yaml`; empty where no text refers to it.
    pub fn id(self) -> &'static str {
        match self {
            Self::Slows => "slows",
            Self::Stops => "stops",
            Self::Starts => "starts",
            Self::Waits => "waits",
            Self::SpeedsUp => "speeds_up",
            Self::Keeps | Self::Unknown => "",
        }
    }
}

/// The ego changes lanes after the keyframe.
pub(super) fn changes_lane(signals: &SignalTable, keyframe: usize) -> bool {
    side_of_change(signals, keyframe).is_some()
}

/// The side of the first lane change after the keyframe.
pub(super) fn side_of_change(signals: &SignalTable, keyframe: usize) -> Option<LateralDirection> {
    let column = signals.frame_columns.get("ego.lane_change")?;
    let end = (keyframe + HORIZON_FRAMES + 1).min(column.len());
    (keyframe..end).find_map(|f| column.category(f).and_then(LateralDirection::from_id))
}
