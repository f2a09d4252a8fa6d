//! The Intelligent Driver Model (Treiber, Hennecke and Helbing 2000), with parameters fitted to the ego's own history.

use whyroad_model::{Drive, SignalTable};

/// Length of the history to which the driver is fitted, frames: one clip.
const HISTORY_FRAMES: usize = 200;

/// Parameters of one driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver {
    /// Desired speed, m/s.
    pub wanted_mps: f64,
    /// Desired time headway, s.
    pub headway_s: f64,
    /// Gap at standstill, m.
    pub standstill_gap_m: f64,
    /// Acceleration from rest, m/s2.
    pub accel_mps2: f64,
    /// Comfortable braking, m/s2; positive.
    pub braking_mps2: f64,
    /// Strongest braking, m/s2; positive.
    pub strongest_mps2: f64,
}

impl Default for Driver {
    /// The values of the model's authors for urban traffic, m/s and s.
    fn default() -> Self {
        Self {
            wanted_mps: 13.9,
            headway_s: 1.4,
            standstill_gap_m: 2.0,
            accel_mps2: 1.5,
            braking_mps2: 2.0,
            strongest_mps2: 8.0,
        }
    }
}

impl Driver {
    /// The driver of the ego up to `frame`: its desired speed is the highest speed that it drove or is allowed to
    /// drive, its headway the one that it kept while it followed somebody steadily. `None` where its speed is unknown.
    pub fn fitted(_: &Drive, signals: &SignalTable, frame: usize) -> Option<Self> {
        let speed = signals.frame_columns.get("ego.speed")?;
        let now = speed.number(frame)?;
        let from = frame.saturating_sub(HISTORY_FRAMES);
        let mut driver = Self::default();
        let fastest = (from..=frame).filter_map(|f| speed.number(f)).fold(now, f64::max);
        let number = |name: &str, f: usize| signals.frame_columns.get(name).and_then(|c| c.number(f));
        // A speed limit far above the driven speed is not the desired speed; one slightly above it is.
        let limit = number("map.speed_limit", frame).filter(|l| *l >= fastest && *l < 2.0 * fastest.max(5.0));
        driver.wanted_mps = limit.unwrap_or(fastest).max(now).max(5.0);
        let mut headways: Vec<f64> = (from..=frame)
            .filter_map(|f| {
                let (gap, lead, v) = (number("lead.gap", f)?, number("lead.speed", f)?, speed.number(f)?);
                let steady = v > 3.0 && (lead - v).abs() < 0.8 && gap < 4.0 * v;
                steady.then(|| (gap - driver.standstill_gap_m) / v)
            })
            .filter(|t| (0.3..4.0).contains(t))
            .collect();
        // Ten frames (one second) of following are enough for an estimate.
        if headways.len() >= 10 {
            headways.sort_by(f64::total_cmp);
            driver.headway_s = headways[headways.len() / 2].clamp(0.6, 3.0);
        }
        let accels: Vec<f64> =
            (from..=frame).filter_map(|f| number("ego.accel", f)).filter(|a| *a > 0.3).collect();
        if accels.len() >= 10 {
            let mut sorted = accels;
            sorted.sort_by(f64::total_cmp);
            driver.accel_mps2 = sorted[sorted.len() * 9 / 10].clamp(0.8, 3.0);
        }
        Some(driver)
    }

    /// Acceleration on a free road, m/s2.
    pub fn free(&self, v: f64) -> f64 {
        self.accel_mps2 * (1.0 - (v / self.wanted_mps).powi(4))
    }

    /// Acceleration behind something at a distance of `gap_m` that moves along the path at `speed_mps`, m/s2.
    pub fn behind(&self, v: f64, gap_m: f64, speed_mps: f64) -> f64 {
        let gap = gap_m.max(0.1);
        let closing = v * (v - speed_mps) / (2.0 * (self.accel_mps2 * self.braking_mps2).sqrt());
        let wanted = self.standstill_gap_m + (v * self.headway_s + closing).max(0.0);
        self.accel_mps2 * (1.0 - (v / self.wanted_mps).powi(4) - (wanted / gap).powi(2))
    }

    /// The ego can still stop within `gap_m` without emergency braking.
    pub fn can_stop(&self, v: f64, gap_m: f64) -> bool {
        gap_m > 0.0 && v * v / (2.0 * gap_m) < 1.7 * self.braking_mps2
    }
}
