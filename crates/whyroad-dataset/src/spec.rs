//! The spec of a release: everything that a build depends on besides its labels and its lake. Read from YAML with
//! positions, so that each mistake is reported where it is; every field has a default, which `template.yaml` shows
//! and explains.

mod read;

use serde::{Deserialize, Serialize};
use whyroad_model::{Lang, ScenarioId};

pub use read::{CODES, read};

/// The commented spec that `whyroad dataset init` writes.
pub const TEMPLATE: &str = include_str!("spec/template.yaml");

/// A spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spec {
    /// Name of the release, a slug.
    pub name: String,
    /// Displayed title.
    pub title: Option<String>,
    /// Version of the release, free text.
    pub version: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Selection of labels.
    pub labels: Labels,
    /// Selection of samples.
    pub select: Select,
    /// Licenses.
    pub licences: Licences,
    /// How a sample is cut.
    pub sample: Cut,
    /// How samples are split.
    pub split: Split,
    /// What counts as a duplicate.
    pub deduplicate: Deduplicate,
    /// Floors, caps, weights.
    pub balance: Balance,
    /// Samples in one file; files of one split differ by one sample at most.
    pub samples_per_shard: usize,
}

/// Selection of labels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Labels {
    /// States of the labeling service; labels of plain files have the state `imported`.
    pub statuses: Vec<String>,
    /// Unchecked drafts by rule or model too, marked `label_status = draft`.
    pub drafts: bool,
    /// Language of the drafts by rule that are made from episodes.
    #[serde(default)]
    pub draft_texts: Lang,
}

/// Selection of samples; an empty list means "all".
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Select {
    /// Classes (L1, L2 or leaf) to take.
    pub classes: Vec<ScenarioId>,
    /// Classes to leave out.
    pub exclude_classes: Vec<ScenarioId>,
    /// Sources of drives.
    pub sources: Vec<String>,
    /// Places of drives.
    pub places: Vec<String>,
    /// Stated weather at t0; a drive that states none is left out when this is set.
    pub weather: Vec<String>,
    /// Minimum match score of the episode; a label without a known score is left out and reported.
    pub min_score: Option<f64>,
}

/// Permitted uses of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Use {
    /// Inside one organization, not distributed.
    Internal,
    /// Published or distributed for research.
    Research,
    /// Distributed with commercial use permitted.
    Commercial,
}

/// Licenses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Licences {
    /// Purpose of the release.
    pub purpose: Use,
    /// Only these licenses; empty: all that the purpose permits.
    pub allow: Vec<String>,
    /// License of drives that state none. Unset: such drives are refused.
    pub assume: Option<String>,
}

/// Treatment of a sample whose window reaches beyond the drive or has steps without a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Incomplete {
    /// Left out and reported.
    Drop,
    /// Kept with nulls, `complete = false`.
    Keep,
}

/// Point of the ego that poses refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// The rear axle, where the source states how far it is from the box center.
    RearAxle,
    /// The box center.
    BoxCentre,
}

/// Which images a sample has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Images {
    /// None.
    None,
    /// Bird's-eye images rendered from the tables.
    Bev,
    /// Images of the cameras.
    Cameras,
    /// Images of the cameras; bird's-eye images for drives without any.
    CamerasOrBev,
}

/// How a sample is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// Steps per second.
    pub rate_hz: f64,
    /// Seconds before t0.
    pub history_s: f64,
    /// Seconds after t0.
    pub future_s: f64,
    /// Windows that reach beyond the drive.
    pub incomplete: Incomplete,
    /// Reference point.
    pub reference: Reference,
    /// Objects and map within this distance of the ego at t0, m.
    pub radius_m: f64,
    /// Maximum number of objects; named ones are always kept.
    pub max_objects: usize,
    /// With the map.
    pub map: bool,
    /// Images.
    pub images: Images,
    /// Cameras by name; empty: all.
    pub cameras: Vec<String>,
    /// Times of images, seconds from t0, never positive.
    pub image_times_s: Vec<f64>,
    /// Edge length of a bird's-eye image, pixels.
    pub bev_size_px: u32,
    /// Resolution of a bird's-eye image.
    pub bev_m_per_px: f64,
}

/// A key that samples are grouped by before they are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroupKey {
    /// The drive (always).
    Drive,
    /// The recording session.
    Session,
    /// The vehicle.
    Vehicle,
    /// Cells of a place grid, or the polygons.
    Place,
    /// The date.
    Date,
}

/// A named area of one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polygon {
    /// Name of the group.
    pub name: String,
    /// Place whose map frame the points are in; unset: the points are longitude and latitude in degrees.
    pub place: Option<String>,
    /// Corners, x then y (or longitude, latitude).
    pub points: Vec<[f64; 2]>,
}

/// How samples are split.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Share of training samples.
    pub train: f64,
    /// Share of validation samples.
    pub val: f64,
    /// Share of test samples.
    pub test: f64,
    /// Keys; `drive` is always one.
    pub by: Vec<GroupKey>,
    /// Edge of a place cell, m.
    pub place_cell_m: f64,
    /// With `place`: samples closer than this are in one group even across cells, m.
    pub min_distance_m: f64,
    /// Areas that replace grid cells inside them.
    pub polygons: Vec<Polygon>,
    /// Folder of an earlier release whose splits are kept, relative to the spec.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<String>,
}

/// What counts as a duplicate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deduplicate {
    /// Drop exact duplicates.
    pub exact: bool,
    /// Minimum similarity (0 to 1) of near-duplicates; unset: keep them.
    pub near: Option<f64>,
    /// Minimum similarity of reported traces.
    pub traces: f64,
}

/// Floors, caps, weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Training samples that every L2 should have.
    pub floor_l2: usize,
    /// Training samples that every leaf should have.
    pub floor_leaf: usize,
    /// Maximum number of training samples of one leaf; unset: no cap.
    pub cap_leaf: Option<usize>,
    /// Maximum number of training samples of one cell of leaf x decisions x place; unset: no cap.
    pub cap_cell: Option<usize>,
    /// 0: all weights 1; 1: every cell weighs the same.
    pub weight_exponent: f64,
    /// Maximum weight relative to the mean.
    pub max_weight: f64,
}

impl Default for Spec {
    fn default() -> Self {
        Self {
            name: "release".into(),
            title: None,
            version: "1".into(),
            seed: 0,
            labels: Labels {
                statuses: vec!["accepted".into(), "imported".into()],
                drafts: false,
                draft_texts: Lang::En,
            },
            select: Select::default(),
            licences: Licences { purpose: Use::Internal, allow: vec![], assume: None },
            sample: Cut::default(),
            split: Split {
                train: 0.8,
                val: 0.1,
                test: 0.1,
                by: vec![GroupKey::Drive, GroupKey::Session, GroupKey::Place],
                place_cell_m: 50.0,
                min_distance_m: 5.0,
                polygons: vec![],
                keep: None,
            },
            deduplicate: Deduplicate { exact: true, near: Some(0.9), traces: 0.9 },
            balance: Balance {
                floor_l2: 0,
                floor_leaf: 0,
                cap_leaf: None,
                cap_cell: None,
                weight_exponent: 0.5,
                max_weight: 10.0,
            },
            samples_per_shard: 1000,
        }
    }
}

impl Default for Cut {
    fn default() -> Self {
        Self {
            rate_hz: 10.0,
            history_s: 2.0,
            future_s: 6.0,
            incomplete: Incomplete::Drop,
            reference: Reference::RearAxle,
            radius_m: 60.0,
            max_objects: 64,
            map: true,
            images: Images::None,
            cameras: vec![],
            image_times_s: vec![-0.3, -0.2, -0.1, 0.0],
            bev_size_px: 256,
            bev_m_per_px: 0.25,
        }
    }
}

impl Cut {
    /// Steps before t0, and steps after it.
    pub fn steps(&self) -> (i32, i32) {
        ((self.history_s * self.rate_hz).round() as i32, (self.future_s * self.rate_hz).round() as i32)
    }
}
