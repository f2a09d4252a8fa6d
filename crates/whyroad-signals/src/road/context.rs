//! Context channels: states of weather, surface, light and road works from a log or a perception model. A state is
//! valid until the next one of its kind, also over missing frames; before the first one nothing is known.

use crate::table::TableBuilder;
use whyroad_model::catalog::{Category, CategoryValue, PerFrame, Signal};
use whyroad_model::catalog::{id, value::ContextPavement};
use whyroad_model::scene::ContextState;
use whyroad_model::vocabulary::UNKNOWN;
use whyroad_model::{Drive, Nanos, Tri};

/// Minimum confidence of a state that is used: more likely true than false.
const LEAST_CONFIDENCE: f64 = 0.5;

/// A change is reported for this long, s.
const CHANGE_S: f64 = 3.0;

fn is_sure(state: &ContextState) -> bool {
    state.confidence.is_none_or(|c| c >= LEAST_CONFIDENCE)
}

/// The context of one drive by frame.
pub struct Channels<'a> {
    states: Vec<&'a ContextState>,
    times: &'a [Nanos],
}

impl<'a> Channels<'a> {
    /// The context of `drive`.
    pub fn new(drive: &'a Drive) -> Self {
        let mut states: Vec<&ContextState> = drive.context.iter().flatten().collect();
        states.sort_by_key(|s| s.time);
        Self { states, times: &drive.times }
    }

    /// True when the log states this kind at least once.
    pub fn has(&self, kind: &str) -> bool {
        self.states.iter().any(|s| s.kind == kind)
    }

    fn of(&self, kind: &str) -> Vec<&'a ContextState> {
        self.states.iter().copied().filter(|s| s.kind == kind).collect()
    }

    /// The valid state in each frame; `None` before the first state and where it is unknown.
    pub fn values(&self, kind: &str) -> Vec<Option<&'a str>> {
        let states = self.of(kind);
        let at = |t: &Nanos| {
            let k = states.partition_point(|s| s.time <= *t);
            let state = states[k.checked_sub(1)?];
            Some(state.value.as_str()).filter(|v| *v != UNKNOWN && is_sure(state))
        };
        self.times.iter().map(at).collect()
    }

    /// Values of a category whose names are those of the state; unknown for any other name.
    pub fn categories<C: CategoryValue>(&self, kind: &str) -> Vec<Option<C>> {
        self.values(kind).into_iter().map(|v| v.and_then(C::from_name)).collect()
    }

    /// Writes the signal whose values are the names of the states, if the log has this kind.
    fn write<C: CategoryValue>(
        &self,
        kind: &str,
        id: Signal<PerFrame, Category<C>>,
        table: &mut TableBuilder<'_>,
    ) {
        if self.has(kind) {
            table.category(id, self.categories(kind));
        }
    }

    /// Numbers; NaN where unknown.
    pub fn numbers(&self, kind: &str) -> Vec<f64> {
        let number = |v: &str| v.parse::<f64>().ok().filter(|n| n.is_finite());
        self.values(kind).into_iter().map(|v| v.and_then(number).unwrap_or(f64::NAN)).collect()
    }

    /// True while the last change from one known value to another is at most 3 s old; unknown if a value in that time
    /// is unknown.
    fn changed(&self, kind: &str) -> Vec<Tri> {
        let states = self.of(kind);
        let at = |t: &Nanos| {
            let since = states.partition_point(|s| s.time.seconds_since(*t) < -CHANGE_S);
            let until = states.partition_point(|s| s.time <= *t);
            // The state at the beginning of the window, and those that began in it.
            let held = &states[since.saturating_sub(1)..until];
            let known = |s: &&ContextState| s.value != UNKNOWN && is_sure(s);
            if held.windows(2).any(|w| w.iter().all(known) && w[0].value != w[1].value) {
                Tri::True
            } else if since == 0 || !held.iter().all(known) {
                Tri::Unknown
            } else {
                Tri::False
            }
        };
        self.times.iter().map(at).collect()
    }
}

/// Writes `context.*` and `nav.speed_limit`.
pub fn write(channels: &Channels<'_>, table: &mut TableBuilder<'_>) {
    channels.write("weather", id::CONTEXT_WEATHER, table);
    channels.write("surface", id::CONTEXT_SURFACE, table);
    channels.write("lighting", id::CONTEXT_LIGHTING, table);
    channels.write("road_type", id::CONTEXT_ROAD_TYPE, table);
    channels.write("lane_marks", id::CONTEXT_LANE_MARKS, table);
    channels.write("construction", id::CONTEXT_CONSTRUCTION, table);
    channels.write("accident", id::CONTEXT_ACCIDENT, table);
    channels.write("warning_light", id::CONTEXT_WARNING_LIGHT, table);
    channels.write("pavement", id::CONTEXT_PAVEMENT, table);
    if channels.has("visibility") {
        table.number(id::CONTEXT_VISIBILITY, channels.numbers("visibility"));
    }
    if channels.has("nav_speed_limit") {
        table.number(id::NAV_SPEED_LIMIT, channels.numbers("nav_speed_limit"));
    }
    if channels.has("lighting") {
        table.flag(id::CONTEXT_LIGHTING_CHANGE, channels.changed("lighting"));
    }
}

/// Writes `context.pavement` if the lanes' tags also state it, by frame; the channel has priority.
pub fn write_pavement(channels: &Channels<'_>, unpaved: &[Option<bool>], table: &mut TableBuilder<'_>) {
    let stated = channels.categories("pavement");
    let drawn = |unpaved: bool| if unpaved { ContextPavement::Unpaved } else { ContextPavement::Paved };
    table.category(id::CONTEXT_PAVEMENT, stated.iter().zip(unpaved).map(|(s, u)| s.or(u.map(drawn))));
}
