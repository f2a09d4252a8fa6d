//! Predictions as JSON Lines, one object per sample (`docs/reference/model-evaluation.md`). A field that is absent is
//! not predicted; a decision that is `null` is "no change".

use super::target::{NO_CHANGE, Target};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::io::BufRead;
use whyroad_framework::json_text;
use whyroad_model::diagnostic::Location;
use whyroad_model::{Bilingual, Diagnostic};

/// A model's prediction for one sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prediction {
    /// The sample.
    pub sample_id: String,
    /// Longitudinal decision; the inner `None` is "no change".
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub longitudinal: Option<Option<String>>,
    /// Lateral decision; the inner `None` is "no change".
    #[serde(default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    pub lateral: Option<Option<String>>,
    /// Class: `l1.l2` or `l1.l2.l3`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scenario_id: Option<String>,
    /// Probability per class of each target; `no_change` is the null decision.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub probabilities: BTreeMap<Target, BTreeMap<String, f64>>,
    /// The ego's path after t0, in the sample's frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<PredictedTrajectory>,
}

/// A predicted path: three lists of the same length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictedTrajectory {
    /// Seconds from t0, positive and rising.
    pub t_s: Vec<f64>,
    /// m forward.
    pub x: Vec<f64>,
    /// m to the left.
    pub y: Vec<f64>,
}

/// Distinguishes `null` from an absent field.
fn given<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Option<String>>, D::Error> {
    Option::<String>::deserialize(d).map(Some)
}

impl Prediction {
    /// The predicted class of a target; `None`: not predicted.
    pub fn class(&self, target: Target) -> Option<&str> {
        match target {
            Target::Longitudinal => self.longitudinal.as_ref().map(|d| d.as_deref().unwrap_or(NO_CHANGE)),
            Target::Lateral => self.lateral.as_ref().map(|d| d.as_deref().unwrap_or(NO_CHANGE)),
            Target::Leaf => self.scenario_id.as_deref(),
        }
    }
}

/// Classes that exist; a prediction of any other is reported.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary(pub BTreeMap<Target, BTreeSet<String>>);

impl Vocabulary {
    fn contains(&self, target: Target, class: &str) -> bool {
        (target != Target::Leaf && class == NO_CHANGE)
            || self.0.get(&target).is_none_or(|known| known.contains(class))
    }
}

/// Predictions by sample.
#[derive(Clone, Debug, Default)]
pub struct Predictions(BTreeMap<String, Prediction>);

impl Predictions {
    /// From rows; with several for one sample, the first is used.
    pub fn new(rows: impl IntoIterator<Item = Prediction>) -> Self {
        let mut out = BTreeMap::new();
        for p in rows {
            out.entry(p.sample_id.clone()).or_insert(p);
        }
        Self(out)
    }

    /// Reads JSON Lines. Unusable lines are left out and reported.
    ///
    /// # Errors
    /// When the stream itself fails.
    pub fn read(
        input: impl BufRead,
        name: &str,
        vocabulary: &Vocabulary,
    ) -> std::io::Result<(Self, Vec<Diagnostic>)> {
        let (mut out, mut found) = (BTreeMap::new(), Vec::new());
        for (i, line) in input.lines().enumerate() {
            let line = line?;
            if line.trim().is_empty() {
                continue;
            }
            let at = Location { file: Some(name.to_owned()), line: Some(i + 1), ..Location::default() };
            let prediction: Prediction = match serde_json::from_str(&line) {
                Ok(p) => p,
                Err(e) => {
                    let column = Some(e.column().max(1));
                    let Bilingual { zh, en } = json_text::message(&line, &e);
                    found.push(line_fault(&zh, &en).at(Location { column, ..at }));
                    continue;
                }
            };
            if let Some((zh, en)) = fault(&prediction) {
                found.push(line_fault(zh, en).at(at));
                continue;
            }
            for target in Target::ALL {
                if let Some(class) = prediction.class(target).filter(|c| !vocabulary.contains(target, c)) {
                    let target = target.title();
                    let text = Bilingual::new(
                        format!("{}没有类别 '{class}'；按错误计", target.zh),
                        format!("'{class}' is not a class of {}; it counts as wrong", target.en),
                    );
                    found.push(Diagnostic::warning("score.class.unknown", text).at(at.clone()));
                }
            }
            if out.contains_key(&prediction.sample_id) {
                let id = &prediction.sample_id;
                let text = Bilingual::new(
                    format!("样本 {id} 已有预测；以第一条为准"),
                    format!("sample {id} has a prediction already; the first counts"),
                );
                found.push(Diagnostic::error("score.prediction.repeated", text).at(at));
                continue;
            }
            out.insert(prediction.sample_id.clone(), prediction);
        }
        Ok((Self(out), found))
    }

    /// The prediction for a sample.
    pub fn of(&self, sample_id: &str) -> Option<&Prediction> {
        self.0.get(sample_id)
    }

    /// All predictions, by sample id.
    pub fn rows(&self) -> impl Iterator<Item = &Prediction> {
        self.0.values()
    }
}

fn line_fault(zh: &str, en: &str) -> Diagnostic {
    let text = Bilingual::new(
        format!("该行不是预测，已忽略：{zh}"),
        format!("this line is not a prediction and is ignored: {en}"),
    );
    Diagnostic::error("score.prediction.line", text)
}

/// Why a prediction is unusable.
fn fault(p: &Prediction) -> Option<(&'static str, &'static str)> {
    if let Some(t) = &p.trajectory {
        if t.t_s.len() != t.x.len() || t.t_s.len() != t.y.len() || t.t_s.is_empty() {
            return Some((
                "trajectory 的 t_s、x、y 长度不同或为空",
                "t_s, x, y of trajectory are empty or differ in length",
            ));
        }
        let rising = t.t_s[0] > 0.0 && t.t_s.windows(2).all(|w| w[0] < w[1]);
        if !rising || t.t_s.iter().chain(&t.x).chain(&t.y).any(|v| !v.is_finite()) {
            return Some(("trajectory 的 t_s 须为正且递增", "t_s of trajectory must be positive and rising"));
        }
    }
    let wrong = |v: &f64| !(0.0..=1.0).contains(v);
    if p.probabilities.values().any(|by| by.values().any(wrong) || by.values().sum::<f64>() > 1.001) {
        return Some((
            "概率须在 0 到 1 之间，且总和不超过 1",
            "probabilities must be from 0 to 1 and sum to at most 1",
        ));
    }
    None
}
