//! Ground truth of a split: the scored part of each sample, small enough to keep a split in memory.

use super::target::{NO_CHANGE, Target};
use crate::{DatasetError, Release, Sample, SplitName};

/// One sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Id.
    pub sample_id: String,
    /// Drive.
    pub drive: String,
    /// Place; `None`: not stated.
    pub place: Option<String>,
    /// `scenario_id`.
    pub leaf: String,
    /// Longitudinal decision or [`NO_CHANGE`]; `None` where it is unknown ([`Sample::states_decision`]).
    pub longitudinal: Option<String>,
    /// Lateral decision or [`NO_CHANGE`]; `None` where it is unknown.
    pub lateral: Option<String>,
    /// Future of the ego: seconds from t0, x and y in m. Steps without a pose are left out.
    pub future: Vec<[f32; 3]>,
    /// Every step of the future has a pose.
    pub future_complete: bool,
}

impl Truth {
    /// From a sample.
    pub fn of(sample: &Sample) -> Self {
        let decision = |d: &Option<String>| {
            sample.states_decision().then(|| d.clone().unwrap_or_else(|| NO_CHANGE.to_owned()))
        };
        let f = &sample.future;
        let steps = f.t_s.iter().zip(f.x.iter().zip(&f.y));
        let future: Vec<[f32; 3]> = steps.filter_map(|(t, (x, y))| Some([*t, (*x)?, (*y)?])).collect();
        Self {
            sample_id: sample.sample_id.clone(),
            drive: sample.lineage.drive_id.clone(),
            place: sample.groups.place.clone(),
            leaf: sample.scenario_id.clone(),
            longitudinal: decision(&sample.longitudinal),
            lateral: decision(&sample.lateral),
            future_complete: future.len() == f.t_s.len(),
            future,
        }
    }

    /// The right class of a target; `None` where it is unknown.
    pub fn class(&self, target: Target) -> Option<&str> {
        match target {
            Target::Longitudinal => self.longitudinal.as_deref(),
            Target::Lateral => self.lateral.as_deref(),
            Target::Leaf => Some(&self.leaf),
        }
    }

    /// True when a trajectory can be scored on it.
    pub fn has_future(&self) -> bool {
        self.future_complete && !self.future.is_empty()
    }
}

/// All samples of a split, in the order of the release.
pub(crate) fn read(release: &Release, split: SplitName) -> Result<Vec<Truth>, DatasetError> {
    release.samples(Some(split)).map(|s| s.map(|s| Truth::of(&s))).collect()
}
