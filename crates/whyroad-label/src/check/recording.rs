//! The recorded drive of a label, for the checks that compare the two. The caller provides it: this crate reads no lake
//! and derives no signals.

use std::fmt;
use std::sync::Arc;
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Drive, Nanos, SignalTable};

/// A drive with the data derived from it.
#[derive(Clone, Debug, Default)]
pub struct Recorded {
    /// The whole drive.
    pub drive: Arc<Drive>,
    /// Its signals.
    pub signals: Arc<SignalTable>,
    /// Episodes that the mining rules found in it; empty where they were not run.
    pub episodes: Vec<EpisodeRecord>,
}

/// The signals with which components are compared.
pub const COMPONENT_SIGNALS: [&str; 8] = [
    "ego.speed",
    "light.state",
    "target.accel",
    "target.distance",
    "target.heading_difference",
    "target.lateral",
    "target.longitudinal",
    "target.speed",
];

/// Finds drives by the clips that labels name.
pub trait Recordings: Send + Sync {
    /// The drive of a clip; `None` where it is not available.
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>>;

    /// The drive of a clip as Stage I shows it: cut at `keyframe`, with signals derived from the cut drive, and without
    /// episodes; `None` where it is not available. Only its tracks and the signals [`COMPONENT_SIGNALS`] are used.
    fn until(&self, _clip_id: &str, _keyframe: Nanos) -> Option<Arc<Recorded>> {
        None
    }
}

impl fmt::Debug for dyn Recordings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("recordings")
    }
}
