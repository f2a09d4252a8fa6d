//! Traffic lights that are stated for lanes at every step, as the Waymo motion set has them and ScenarioNet keeps them.

use whyroad_model::Nanos;
use whyroad_model::scene::{LightColor, LightState};

/// The color that a state's name means: Waymo's `LANE_STATE_*` and MetaDrive's `TRAFFIC_LIGHT_*`. `None` for a name
/// that neither defines.
///
/// A green that is not stated to be an arrow is taken for the ordinary round light, under which a left turn gives way
/// to oncoming traffic. Flashing red (stop, then proceed) is not one of our colors: unknown.
pub(crate) fn color(name: &str) -> Option<LightColor> {
    Some(match name.trim_start_matches("LANE_STATE_").trim_start_matches("TRAFFIC_LIGHT_") {
        "ARROW_STOP" | "STOP" | "RED" => LightColor::Red,
        "ARROW_CAUTION" | "CAUTION" | "YELLOW" => LightColor::Yellow,
        "ARROW_GO" => LightColor::GreenArrow,
        "GO" | "GREEN" => LightColor::GreenRound,
        "FLASHING_CAUTION" => LightColor::FlashingYellow,
        "FLASHING_STOP" | "UNKNOWN" => LightColor::Unknown,
        _ => return None,
    })
}

/// One state for each change. A step in which the light was not seen is unknown, so that the previous color does not
/// remain in effect.
pub(crate) fn changes(
    lane: &str,
    steps: impl Iterator<Item = (Nanos, Option<LightColor>)>,
) -> Vec<LightState> {
    let mut out: Vec<LightState> = Vec::new();
    for (time, color) in steps {
        let color = color.unwrap_or(LightColor::Unknown);
        if out.last().is_none_or(|s| s.color != color) {
            out.push(LightState {
                lane_id: lane.to_owned(),
                to_lane_id: None,
                time,
                color,
                countdown_s: None,
            });
        }
    }
    out
}
