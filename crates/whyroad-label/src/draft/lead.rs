//! The lead where it, and not the subject of the class, is the nearest cause of the ego's motion (LABELING.md 6,
//! *proximate cause*), and where the class itself is about a lead that the rule does not name as a target.

use super::moment::FACING_RAD;
use super::motion::LongitudinalMotion;
use crate::driven::other::Other;
use crate::driven::{Driven, STANDSTILL_MPS};
use whyroad_model::{Drive, SignalTable, TrackId};

/// Maximum time gap at which the lead affects the ego's speed, s.
const NEAR_S: f64 = 2.0;
/// Maximum distance at which it does so at any speed, m.
const NEAR_M: f64 = 8.0;
/// Maximum time gap at which it does so even if it is not slower, s.
const CLOSE_S: f64 = 1.0;
/// Maximum time in which the ego would close in on a slower lead that is farther away, s, and its maximum distance, m.
const CLOSING_S: f64 = 7.0;
const CLOSING_M: f64 = 70.0;
/// How far a driver extrapolates the braking of the lead, s.
const AHEAD_S: f64 = 2.0;
/// An ego that stands within this distance behind a lead waits for it, m.
const QUEUE_M: f64 = 12.0;
/// Speed below which both are in a queue, m/s: walking pace.
const QUEUE_MPS: f64 = 2.0;
/// Maximum distance at which a lead is a reason to change lanes, m; at speed, the time that the ego needs for it, s
/// (TAXONOMY.md, following: a THW of 3 s).
const REASON_M: f64 = 50.0;
const REASON_S: f64 = 3.0;
/// A road user slower than this is stationary, m/s.
pub(super) const STANDING_MPS: f64 = 0.5;
/// Minimum speed difference that is a reason to slow down, m/s.
const SLOWER_MPS: f64 = 0.5;
/// A road user with an acceleration below this is braking, m/s2; as for a target.
const BRAKING_MPS2: f64 = -0.5;
/// Frames in which the ego comes to a stand behind it: 10 s.
const STOP_FRAMES: usize = 100;
/// A vehicle this far beside the area that the ego sweeps is not on its way, m; and a second later.
const ASIDE_M: f64 = 1.0;
const LATER_FRAMES: usize = 10;
/// Half the length of a vehicle whose size is not in the log, m.
const HALF_LENGTH_M: f64 = 2.3;

/// The lead at one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead<'a> {
    pub id: &'a TrackId,
    /// Its row in the target columns.
    pub row: usize,
    /// Bumper to bumper, m.
    gap_m: f64,
    /// Half the lengths of both, m.
    halves_m: f64,
    speed_mps: f64,
    accel_mps2: Option<f64>,
    /// Speed of the ego, m/s.
    ego_mps: f64,
}

impl<'a> Lead<'a> {
    /// The lead at `frame`. It is read from the targets, which are known in the last frame of a drive too.
    pub(super) fn at(drive: &Drive, signals: &'a SignalTable, frame: usize) -> Option<Self> {
        let is_lead = signals.target_columns.get("target.is_lead")?;
        let number = |name: &str, row: usize| signals.target_columns.get(name).and_then(|c| c.number(row));
        let ego_mps = signals.frame_columns.get("ego.speed")?.number(frame)?;
        let (id, row) = signals
            .targets
            .iter()
            .filter_map(|span| Some((&span.id, span.row(frame)?)))
            .find(|(_, row)| is_lead.flag(*row).is_true())?;
        let halves_m = half_length(drive.ego.as_ref().map(|e| e.length_m))
            + half_length(size_at(drive, id, frame).map(|(length, _)| length));
        Some(Self {
            id,
            row,
            // In a turn the lead is on a side of the ego, and its longitudinal distance is small even if it is far
            // away.
            gap_m: number("target.longitudinal", row)?.hypot(number("target.lateral", row).unwrap_or(0.0))
                - halves_m,
            halves_m,
            speed_mps: number("target.speed", row)?,
            accel_mps2: number("target.accel", row),
            ego_mps,
        })
    }

    /// The lead may be the reason for a lane change.
    pub(super) fn is_reason(&self) -> bool {
        self.gap_m < REASON_M.max(REASON_S * self.ego_mps)
    }

    /// It is near enough to affect the speed of the ego, whatever the ego then does.
    pub(super) fn is_near(&self) -> bool {
        if self.ego_mps < STANDING_MPS {
            return self.gap_m < QUEUE_M;
        }
        self.is_followed() || self.is_closed_in_on()
    }

    /// It is within the following distance of a moving ego.
    fn is_followed(&self) -> bool {
        self.gap_m < NEAR_M.max(NEAR_S * self.ego_mps)
    }

    /// The ego would reach it soon, its braking extrapolated.
    fn is_closed_in_on(&self) -> bool {
        self.is_slower() && self.gap_m < CLOSING_M.min(CLOSING_S * (self.ego_mps - self.soon_mps()))
    }

    /// Its speed in a moment, its braking extrapolated, m/s.
    fn soon_mps(&self) -> f64 {
        (self.speed_mps + self.accel_mps2.unwrap_or(0.0).min(0.0) * AHEAD_S).max(0.0)
    }

    /// It stands, or will in a moment.
    pub(super) fn stops(&self) -> bool {
        self.soon_mps() < STANDING_MPS
    }

    /// Both move slowly, close behind each other: the ego goes on as the lead lets it.
    pub(super) fn is_crept_behind(&self) -> bool {
        let slow = |mps: f64| (STANDING_MPS..QUEUE_MPS).contains(&mps);
        slow(self.ego_mps) && self.speed_mps < QUEUE_MPS && self.gap_m < NEAR_M
    }

    pub(super) fn stands(&self) -> bool {
        self.speed_mps < STANDING_MPS
    }

    /// It is on the way that the ego drives, now and a second later. True where that is unknown.
    pub(super) fn is_on_the_way(&self, w: &Driven<'_>) -> bool {
        let Some(lead) = Other::of(w, self.id) else { return true };
        let aside = |f: usize| lead.number("target.path_side_distance", f).is_some_and(|m| m > ASIDE_M);
        let comes =
            lead.number("target.heading_difference", w.keyframe).is_some_and(|a| a.abs() > FACING_RAD);
        !comes && !aside(w.keyframe) && !aside(w.keyframe + LATER_FRAMES)
    }

    /// The ego comes to a stand close behind it, and it stands then too.
    pub(super) fn is_stopped_behind(&self, w: &Driven<'_>) -> bool {
        let end = (w.keyframe + STOP_FRAMES).min(w.range_end);
        let stop = (w.keyframe..end).find(|&f| w.speed(f).is_some_and(|v| v < STANDSTILL_MPS));
        stop.zip(Other::of(w, self.id)).is_some_and(|(f, lead)| {
            let place = lead.number("target.longitudinal", f).zip(lead.number("target.lateral", f));
            let stands = lead.number("target.speed", f).is_some_and(|v| v < STANDING_MPS);
            stands && place.is_some_and(|(x, y)| x > 0.0 && x.hypot(y) - self.halves_m < NEAR_M)
        })
    }

    /// It is slower than the ego.
    pub(super) fn is_slower(&self) -> bool {
        self.speed_mps < self.ego_mps - SLOWER_MPS
    }

    /// The lead is the cause of the ego's `motion`.
    pub(super) fn is_cause_of(&self, motion: LongitudinalMotion) -> bool {
        if self.ego_mps < STANDING_MPS {
            return self.gap_m < QUEUE_M;
        }
        let slower = self.is_slower();
        match motion {
            LongitudinalMotion::Slows | LongitudinalMotion::Stops => {
                let brakes = self.accel_mps2.is_some_and(|a| a < BRAKING_MPS2);
                let slows_it = self.stands() || slower || brakes || self.gap_m < CLOSE_S * self.ego_mps;
                self.is_near() && slows_it
            }
            LongitudinalMotion::SpeedsUp | LongitudinalMotion::Starts | LongitudinalMotion::Waits => {
                self.is_followed() && !slower
            }
            LongitudinalMotion::Keeps | LongitudinalMotion::Unknown => false,
        }
    }
}

fn half_length(length_m: Option<f64>) -> f64 {
    length_m.filter(|l| l.is_finite() && *l > 0.0).map_or(HALF_LENGTH_M, |l| l / 2.0)
}

/// Length and width of a track's box at `frame`, m.
pub(super) fn size_at(drive: &Drive, id: &TrackId, frame: usize) -> Option<(f64, f64)> {
    let track = drive.track(id)?;
    let row = track.frames.binary_search(&u32::try_from(frame).ok()?).ok()?;
    Some((*track.length_m.get(row)?, *track.width_m.get(row)?))
}
