//! Something that the draft does not name holds the ego, and what it names does not: then its reason is not that of the
//! motion (LABELING.md 6, *causal correctness*). The counterfactual model says what the ego would do without each; it
//! knows neither the road nor a maneuver to the side, so a draft about these is not compared.

use super::components::is_light;
use crate::counterfactual::{HORIZON_S, Removed, counterfactual};
use crate::driven::Driven;
use whyroad_model::TrackId;
use whyroad_model::messages::CriticalComponent;

/// The ego drives as the model does with everything present if the difference is at most this share of what the other
/// thing changes.
const ALIKE_SHARE: f64 = 0.5;
/// Minimum change that explains a motion, m.
const EXPLAINS_M: f64 = 4.0;

/// The thing that explains why the ego slows or stands instead of the subject of the class and those in `components`.
pub(super) fn of(
    w: &Driven<'_>,
    target: Option<&TrackId>,
    components: &[CriticalComponent],
) -> Option<Removed> {
    let objects = components.iter().flat_map(|c| &c.linked_objects).map(|id| TrackId::from(id.as_str()));
    let mut named: Vec<Removed> = target.cloned().into_iter().chain(objects).map(Removed::Object).collect();
    named.extend(components.iter().any(is_light).then_some(Removed::Light));
    if named.is_empty() {
        return None;
    }
    let found = counterfactual(w.drive, w.signals, w.keyframe)?;
    let was_seen = |thing: &Removed| match thing {
        Removed::Light => true,
        Removed::Object(id) => w.was_seen(id),
    };
    let other = found.instead_of(&named, was_seen).filter(|e| e.distance_m > EXPLAINS_M)?;
    let off_m = (w.distance_m(HORIZON_S)? - found.distance_m).abs();
    (off_m < ALIKE_SHARE * other.distance_m).then(|| other.removed.clone())
}
