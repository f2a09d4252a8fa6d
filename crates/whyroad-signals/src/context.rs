//! Context channels: what a log or a perception model states of weather, surface, light, works. A state holds by time until the next of
//! its kind, also over missing frames; before the first nothing is known.

use crate::table::TableBuilder;
use whyroad_model::scene::ContextState;
use whyroad_model::vocabulary::{ContextValues, UNKNOWN, context_values};
use whyroad_model::{Drive, Nanos, Tri};

/// A change is told for this long, s.
const CHANGE_S: f64 = 3.0;

/// Kinds that are signals of their own, as `context.<kind>`.
const WORDS: &[&str] = &[
    "weather",
    "surface",
    "lighting",
    "road_type",
    "lane_marks",
    "construction",
    "accident",
    "warning_light",
];

const PAVEMENTS: &[&str] = &["paved", "unpaved"];

/// The context of one drive by frame.
pub struct Channels<'a> {
    states: Vec<&'a ContextState>,
    times: &'a [Nanos],
}

impl<'a> Channels<'a> {
    /// Of `drive`.
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

    /// What holds in each frame; `None` before the first state and where it is unknown.
    pub fn values(&self, kind: &str) -> Vec<Option<&'a str>> {
        let states = self.of(kind);
        let at = |t: &Nanos| {
            let k = states.partition_point(|s| s.time <= *t);
            k.checked_sub(1).map(|k| states[k].value.as_str()).filter(|v| *v != UNKNOWN)
        };
        self.times.iter().map(at).collect()
    }

    /// Indices into `words`.
    pub fn codes(&self, kind: &str, words: &[&str]) -> Vec<Option<u16>> {
        let code = |v: &str| words.iter().position(|w| *w == v).map(|k| k as u16);
        self.values(kind).into_iter().map(|v| v.and_then(code)).collect()
    }

    /// Numbers; NaN where unknown.
    pub fn numbers(&self, kind: &str) -> Vec<f64> {
        let number = |v: &str| v.parse::<f64>().ok().filter(|n| n.is_finite());
        self.values(kind).into_iter().map(|v| v.and_then(number).unwrap_or(f64::NAN)).collect()
    }

    /// True while the last change from one known value to another is at most 3 s old; unknown where a value in that time is.
    fn changed(&self, kind: &str) -> Vec<Tri> {
        let states = self.of(kind);
        let at = |t: &Nanos| {
            let since = states.partition_point(|s| s.time.seconds_since(*t) < -CHANGE_S);
            let until = states.partition_point(|s| s.time <= *t);
            // The state that held when the window began, and those that began in it.
            let held = &states[since.saturating_sub(1)..until];
            let known = |s: &&ContextState| s.value != UNKNOWN;
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
    for kind in WORDS.iter().filter(|k| channels.has(k)) {
        if let Some(ContextValues::Words(words)) = context_values(kind) {
            table.category(&format!("context.{kind}"), channels.codes(kind, words));
        }
    }
    if channels.has("visibility") {
        table.number("context.visibility", channels.numbers("visibility"));
    }
    if channels.has("nav_speed_limit") {
        table.number("nav.speed_limit", channels.numbers("nav_speed_limit"));
    }
    if channels.has("lighting") {
        table.flag("context.lighting_change", channels.changed("lighting"));
    }
    if channels.has("pavement") {
        table.category("context.pavement", channels.codes("pavement", PAVEMENTS));
    }
}

/// Writes `context.pavement` where the lanes' tags tell of it too, by frame; what is stated counts first.
pub fn write_pavement(channels: &Channels<'_>, unpaved: &[Option<bool>], table: &mut TableBuilder<'_>) {
    let stated = channels.codes("pavement", PAVEMENTS);
    table.category("context.pavement", stated.iter().zip(unpaved).map(|(s, u)| s.or(u.map(u16::from))));
}
