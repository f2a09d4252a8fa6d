//! Light states (`<tlsStates>`, written by `<timedEvent type="SaveTLSStates">`), one letter per link of the light.

use super::net::LightLink;
use crate::encodings::input::Input;
use crate::encodings::xml::{Tag, for_each_tag};
use std::collections::HashMap;
use whyroad_model::Nanos;
use whyroad_model::scene::{LightColor, LightState};

/// States by lane and time, repeated ones left out. Light states before the drive's start are kept: they still hold
/// then.
pub(super) fn read(input: Input<'_>, links: &[LightLink], start: Nanos) -> Result<Vec<LightState>, String> {
    let mut of_light: HashMap<&str, Vec<&LightLink>> = HashMap::new();
    for l in links {
        of_light.entry(&l.tls).or_default().push(l);
    }
    let mut last: HashMap<(String, String), LightColor> = HashMap::new();
    let mut states = Vec::new();
    for_each_tag(input, |tag| {
        let Tag::Open(e) = tag else { return };
        if e.name() != "tlsState" {
            return;
        }
        let (Some(time), Some(id), Some(letters)) = (e.number("time"), e.get("id"), e.get("state")) else {
            return;
        };
        for link in of_light.get(id.as_ref()).into_iter().flatten() {
            let Some(color) = letters.as_bytes().get(link.index).map(|c| color(*c)) else { continue };
            let movement = (link.lane.clone(), link.to_lane.clone());
            if last.insert(movement, color) == Some(color) {
                continue;
            }
            states.push(LightState {
                lane_id: link.lane.clone(),
                to_lane_id: Some(link.to_lane.clone()),
                time: start + Nanos((time * 1e9).round() as i64),
                color,
                countdown_s: None,
            });
        }
    })?;
    states.sort_by(|a, b| (&a.lane_id, a.time, &a.to_lane_id).cmp(&(&b.lane_id, b.time, &b.to_lane_id)));
    Ok(states)
}

/// SUMO's letters (user documentation, "Traffic Lights", signal state definitions).
fn color(letter: u8) -> LightColor {
    match letter {
        b'r' => LightColor::Red,
        b'y' | b'Y' => LightColor::Yellow,
        b'G' => LightColor::Green,
        // `s` is a green right-turn arrow: stop first, then give way.
        b'g' | b's' => LightColor::GreenYield,
        b'u' => LightColor::RedYellow,
        b'o' => LightColor::FlashingYellow,
        b'O' => LightColor::Off,
        _ => LightColor::Unknown,
    }
}
