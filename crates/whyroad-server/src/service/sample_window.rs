//! The window of a training sample around a keyframe: a label whose window reaches beyond its drive cannot become a
//! sample of the default spec of a data set (`whyroad dataset init`).

use crate::domain::task::ShortWindow;
use whyroad_model::Nanos;
use whyroad_model::messages::EpisodeRecord;

/// Seconds before the keyframe: what Stage I shows at least, and `sample.history_s` of the default spec (LABELING.md 4
/// and 6).
pub const HISTORY_S: f64 = 2.0;
/// Seconds after it: what Stage II shows at least, and `sample.future_s` of the default spec.
pub const FUTURE_S: f64 = 6.0;
/// Half a frame: a step is as near as this to a frame.
const TOLERANCE_S: f64 = 0.05;

/// The part of a drive around a keyframe, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    before_s: f64,
    after_s: f64,
}

impl Window {
    /// Around `keyframe` in a drive from its first to its last frame.
    pub fn of(keyframe: Nanos, (first, last): (Nanos, Nanos)) -> Self {
        Self { before_s: keyframe.seconds_since(first), after_s: last.seconds_since(keyframe) }
    }

    fn has_history(self) -> bool {
        self.before_s >= HISTORY_S - TOLERANCE_S
    }

    fn has_future(self) -> bool {
        self.after_s >= FUTURE_S - TOLERANCE_S
    }

    /// A sample of the default spec can be cut.
    pub fn is_whole(self) -> bool {
        self.has_history() && self.has_future()
    }

    /// The parts that are too short; of what comes after the keyframe only if `with_future`.
    pub fn short(self, with_future: bool) -> Option<ShortWindow> {
        let before_s = (!self.has_history()).then_some(self.before_s);
        let after_s = (with_future && !self.has_future()).then_some(self.after_s);
        (before_s.is_some() || after_s.is_some()).then_some(ShortWindow { before_s, after_s })
    }
}

/// The keyframe of `episode` is the first frame of its drive: Stage I has no history at all.
pub fn is_first(episode: &EpisodeRecord, span: Option<(Nanos, Nanos)>) -> bool {
    span.is_some_and(|(first, _)| episode.keyframe.timestamp <= first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive of 15.5 s, as the AV2 sensor logs: LABELING.md 4 asks for 2 s before, the default spec for 6 s after.
    #[test]
    fn a_window_beyond_the_drive_is_short() {
        let at = |s: f64| Nanos(0).plus_secs(s);
        let of = |s: f64| Window::of(at(s), (at(0.0), at(15.5)));
        assert!(of(2.0).is_whole() && of(9.5).is_whole());
        assert_eq!(of(0.0).short(true), Some(ShortWindow { before_s: Some(0.0), after_s: None }));
        assert_eq!(of(11.5).short(true), Some(ShortWindow { before_s: None, after_s: Some(4.0) }));
        assert_eq!(of(11.5).short(false), None, "Stage I says nothing of what comes after");
    }
}
