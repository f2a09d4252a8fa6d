//! A baseline that any model should beat: longitudinal decision, lateral decision and leaf from the history alone,
//! trained on a CPU in minutes. It shows how much of a release can be predicted from observations and motion before t0,
//! without images and without language.
//!
//! Stages: [`features`], a [`learner`], [`calibration`] on the validation split, [`compare`] against the majority
//! class and the last meta action. [`folds`] gives probabilities of samples that the model did not see, for
//! [`crate::doubtful`].

pub mod calibration;
pub mod compare;
pub mod features;
pub mod folds;
pub mod learner;
pub mod page;
pub mod row;

pub use row::{Row, Settings};

use crate::score::Target;
use crate::score::predictions::Prediction;
use crate::{DatasetError, Release, SplitName};
use calibration::temperature;
use learner::{Boosted, Learner, Majority, Problem, RepeatLast};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use whyroad_model::Bilingual;

/// Value of `format` in a model file.
const FORMAT: &str = "whyroad-baseline";
/// Version of the features and of the file; a model of another version is not read.
const VERSION: u32 = 1;

/// Reads the rows of a split; of all splits where none is named. Images and labels are not read.
///
/// # Errors
/// When the release cannot be read.
pub fn rows(release: &Release, split: Option<SplitName>) -> Result<Vec<Row>, DatasetError> {
    const COLUMNS: [&str; 14] = [
        "sample_id",
        "split",
        "weight",
        "scenario_id",
        "longitudinal",
        "lateral",
        "route",
        "lineage",
        "groups",
        "history",
        "future",
        "objects",
        "map",
        "lights",
    ];
    let mut out = Vec::new();
    for batch in release.batches(split, Some(&COLUMNS)) {
        let samples = crate::sample::schema::from_batch(&batch?);
        let samples = samples.map_err(|e| DatasetError::broken(release.dir(), e))?;
        out.extend(samples.iter().map(Row::of));
    }
    Ok(out)
}

/// How to predict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Gradient-boosted trees on the features.
    Boosted,
    /// The most frequent class of the training split, always.
    Majority,
    /// The class that training samples with the same last meta action have most often.
    RepeatLast,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Boosted, Self::Majority, Self::RepeatLast];

    /// Its id.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boosted => "boosted",
            Self::Majority => "majority",
            Self::RepeatLast => "repeat_last",
        }
    }

    /// Its name in a text for people.
    pub fn title(self) -> Bilingual {
        let zh = match self {
            Self::Boosted => "提升树",
            Self::Majority => "多数类",
            Self::RepeatLast => "重复上一动作",
        };
        Bilingual::new(zh, self.name())
    }
}

/// One target of a trained model.
#[derive(Serialize, Deserialize)]
pub struct TargetModel {
    /// Classes by index.
    pub classes: Vec<String>,
    /// Calibration of the boosted trees; 1 without a validation split.
    pub temperature: f64,
    boosted: Boosted,
    majority: Majority,
    repeat_last: RepeatLast,
}

/// A trained baseline.
#[derive(Serialize, Deserialize)]
pub struct Model {
    format: String,
    version: u32,
    /// Release that it was trained on, name and version.
    pub release: String,
    /// How.
    pub settings: Settings,
    /// Training samples.
    pub trained_on: usize,
    /// Samples of the calibration.
    pub calibrated_on: usize,
    /// Names of the features.
    pub features: Vec<String>,
    /// Per target.
    pub targets: BTreeMap<Target, TargetModel>,
}

impl Model {
    /// Trains on `train` and calibrates on `val`.
    pub fn train(release: &str, train: &[Row], val: &[Row], settings: Settings) -> Self {
        let targets = Target::ALL.map(|t| (t, target_model(train, val, t, settings)));
        Self {
            format: FORMAT.into(),
            version: VERSION,
            release: release.into(),
            settings,
            trained_on: train.len(),
            calibrated_on: val.len(),
            features: features::NAMES.iter().map(|n| (*n).to_owned()).collect(),
            targets: targets.into(),
        }
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// When it is not one, or of another version.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let text = std::fs::read_to_string(path).map_err(DatasetError::io(path))?;
        let model: Self = serde_json::from_str(&text).map_err(|e| DatasetError::broken(path, e))?;
        if model.format != FORMAT || model.version != VERSION || model.features != features::NAMES {
            return Err(DatasetError::broken(path, format!("not a {FORMAT} model of version {VERSION}")));
        }
        Ok(model)
    }

    /// The file's text: the same bytes for the same input.
    ///
    /// # Errors
    /// When a number cannot be written.
    pub fn to_json(&self) -> Result<String, DatasetError> {
        serde_json::to_string(self).map_err(|e| DatasetError::broken(Path::new(FORMAT), e))
    }

    /// Predictions for `rows`, probabilities included.
    pub fn predict(&self, rows: &[Row], method: Method) -> Vec<Prediction> {
        let mut out: Vec<Prediction> = rows
            .iter()
            .map(|r| Prediction { sample_id: r.truth.sample_id.clone(), ..Prediction::default() })
            .collect();
        for (target, model) in &self.targets {
            let probabilities = model.probabilities(rows, method);
            for (p, row) in out.iter_mut().zip(&probabilities) {
                put(p, *target, &model.classes, row);
            }
        }
        out
    }
}

impl TargetModel {
    /// One row per sample, one column per class.
    pub fn probabilities(&self, rows: &[Row], method: Method) -> Vec<Vec<f64>> {
        match method {
            Method::Boosted => {
                let raw = self.boosted.probabilities(rows);
                raw.iter().map(|p| calibration::scaled(p, self.temperature)).collect()
            }
            Method::Majority => self.majority.probabilities(rows),
            Method::RepeatLast => self.repeat_last.probabilities(rows),
        }
    }
}

/// Sets the class of greatest probability, and the probabilities.
pub(crate) fn put(p: &mut Prediction, target: Target, classes: &[String], row: &[f64]) {
    if classes.is_empty() {
        return;
    }
    let best = classes[crate::doubtful::confident::greatest(row)].clone();
    let decision = |class: String| Some((class != crate::score::NO_CHANGE).then_some(class));
    match target {
        Target::Longitudinal => p.longitudinal = decision(best),
        Target::Lateral => p.lateral = decision(best),
        Target::Leaf => p.scenario_id = Some(best),
    }
    p.probabilities.insert(target, classes.iter().cloned().zip(row.iter().copied()).collect());
}

fn target_model(train: &[Row], val: &[Row], target: Target, settings: Settings) -> TargetModel {
    let classes: BTreeSet<&str> = train.iter().filter_map(|r| r.truth.class(target)).collect();
    let classes: Vec<String> = classes.into_iter().map(str::to_owned).collect();
    let problem = Problem::new(train.iter().collect(), target, &classes);
    let boosted = Boosted::fit(&problem, settings);
    // A class that is absent from training cannot be used for calibration.
    let known: Vec<Row> = val
        .iter()
        .filter(|r| r.truth.class(target).is_some_and(|class| classes.iter().any(|c| c == class)))
        .cloned()
        .collect();
    let held_out = Problem::new(known.iter().collect(), target, &classes);
    let temperature = temperature(&boosted.probabilities(&known), &held_out.labels);
    TargetModel {
        temperature,
        boosted,
        majority: Majority::fit(&problem, settings),
        repeat_last: RepeatLast::fit(&problem, settings),
        classes,
    }
}

#[cfg(test)]
mod tests;
