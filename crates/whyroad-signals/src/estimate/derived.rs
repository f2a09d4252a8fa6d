//! Values that a log does not state but that follow from its other channels: daylight and glare from position, time and
//! heading; rain from the wipers; a rough surface from vertical acceleration; emergency braking from deceleration, jerk
//! and the pedals. Stated values are never replaced, and values that do not follow stay unknown.

mod braking;
mod bumps;
mod sun;
mod wipers;

use std::borrow::Cow;
use whyroad_model::Drive;
use whyroad_model::scene::ContextState;
use whyroad_model::vocabulary::UNKNOWN;

/// Adds derived values to a drive with estimated states; the drive is copied only if there is something to add.
pub fn add_derived(drive: &mut Cow<'_, Drive>) {
    let mut states = Vec::new();
    for (kind, derive) in KINDS {
        if !drive.context.iter().flatten().any(|s| s.kind == *kind) {
            states.extend(changes(drive, kind, &derive(drive)));
        }
    }
    let aeb =
        drive.ego.as_ref().filter(|e| e.bus.aeb.is_empty()).map(|e| braking::emergency(e, &drive.times));
    let aeb = aeb.filter(|flags| flags.iter().any(Option::is_some));
    if !states.is_empty() {
        drive.to_mut().context.get_or_insert_default().extend(states);
    }
    if let Some(aeb) = aeb {
        drive.to_mut().ego.iter_mut().for_each(|ego| ego.bus.aeb.clone_from(&aeb));
    }
}

/// Values of a kind of context by frame; empty if the log has no data for it.
type Derivation = fn(&Drive) -> Vec<Option<&'static str>>;

/// Kinds of context states with their derivations.
const KINDS: &[(&str, Derivation)] =
    &[("lighting", sun::lighting), ("weather", wipers::weather), ("surface", bumps::surface)];

/// One state for each change of value; none if no value is known.
fn changes(drive: &Drive, kind: &str, values: &[Option<&'static str>]) -> Vec<ContextState> {
    let mut out: Vec<ContextState> = Vec::new();
    if values.iter().all(Option::is_none) {
        return out;
    }
    for (value, time) in values.iter().zip(&drive.times) {
        let value = value.unwrap_or(UNKNOWN);
        if out.last().is_none_or(|s| s.value != value) {
            out.push(ContextState {
                time: *time,
                kind: kind.to_owned(),
                value: value.to_owned(),
                source: "derived".to_owned(),
                confidence: None,
            });
        }
    }
    out
}

#[cfg(test)]
mod tests;
