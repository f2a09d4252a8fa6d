//! The part of a candidate sample that stays in memory during a build: about 500 bytes; everything else is in record
//! files.

use crate::records::RecordRef;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use whyroad_model::messages::DrivingDecision;
use whyroad_model::{Bilingual, Lang};

/// Maximum bytes that a build keeps in memory per candidate sample (`docs/reference/release.md` states it; a test
/// checks the parts).
pub const BYTES_PER_SAMPLE: usize = 1024;

/// Numbers in a descriptor.
pub const DESCRIPTOR: usize = 40;
/// Values in the sketch of a trace.
pub const SKETCH: usize = 16;

/// A stage of the build, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// By class, status, quality, place, weather, source, license.
    Select,
    /// Cut from the drive.
    Sample,
    /// Assigned to a split.
    Split,
    /// Duplicates.
    Deduplicate,
    /// Caps.
    Balance,
}

impl Stage {
    /// All stages.
    pub const ALL: [Self; 5] = [Self::Select, Self::Sample, Self::Split, Self::Deduplicate, Self::Balance];

    /// Its displayed name.
    pub fn title(self) -> Bilingual {
        match self {
            Self::Select => Bilingual::new("选取", "selection"),
            Self::Sample => Bilingual::new("切分样本", "cutting samples"),
            Self::Split => Bilingual::new("划分", "split"),
            Self::Deduplicate => Bilingual::new("去重", "duplicates"),
            Self::Balance => Bilingual::new("均衡", "balance"),
        }
    }

    /// The name of its table: `stages/<name>.parquet`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Select => "1-select",
            Self::Sample => "2-sample",
            Self::Split => "3-split",
            Self::Deduplicate => "4-deduplicate",
            Self::Balance => "5-balance",
        }
    }
}

/// Why and where a candidate was dropped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Dropped {
    pub stage: Stage,
    /// An identifier: `status`, `class`, `history`, `duplicate_exact`, ...
    pub reason: Cow<'static, str>,
    /// Details, where the reason alone is not enough.
    pub detail: Option<Box<str>>,
}

impl Dropped {
    pub fn with(stage: Stage, reason: &'static str, detail: impl Into<Box<str>>) -> Self {
        Self { stage, reason: Cow::Borrowed(reason), detail: Some(detail.into()) }
    }
}

/// Reasons for which a candidate is dropped, in words.
const REASONS: &[(&str, &str, &str)] = &[
    ("unreadable", "无法读取", "unreadable"),
    ("invalid_label", "标签有错误", "invalid label"),
    ("repeated_label", "重复的标签", "repeated label"),
    ("secondary_episode", "次要事件", "secondary episode"),
    ("class_unknown", "类别未定到 L2", "class not known to the L2"),
    ("overruled", "被同一事件的另一标签取代", "another label of the episode was chosen"),
    ("not_chosen", "同一事件的多份标签尚未选定", "none of several labels of the episode was chosen"),
    ("draft", "未质检的草稿", "unchecked draft"),
    ("status", "状态不在选取之列", "status not selected"),
    ("class", "类别不在选取之列", "class not selected"),
    ("score", "得分过低", "score too low"),
    ("score_unknown", "得分未知", "score unknown"),
    ("source", "来源不在选取之列", "source not selected"),
    ("place", "地点不在选取之列", "place not selected"),
    ("weather", "天气不在选取之列", "weather not selected"),
    ("drive_missing", "行程不在数据湖中", "drive not in the lake"),
    ("licence", "许可不允许", "license does not allow it"),
    ("drive_unreadable", "行程无法读取", "drive unreadable"),
    ("keyframe_outside", "关键帧在行程之外", "keyframe outside the drive"),
    ("ego_pose", "没有自车位姿", "no pose of the ego"),
    ("history", "关键帧之前的轨迹不完整", "trajectory before the keyframe incomplete"),
    ("future", "关键帧之后的轨迹不完整", "trajectory after the keyframe incomplete"),
    ("label_unreadable", "标签无法读取", "label unreadable"),
    ("contradicts_recording", "标签与行程记录矛盾", "label contradicts the recording"),
    ("draft_doubt", "草稿存疑", "doubtful draft"),
    ("draft_invalid", "草稿有错误", "draft with errors"),
    ("camera_missing", "缺少相机", "camera missing"),
    ("image_missing", "缺少图片", "image missing"),
    ("image_before_drive", "图片时刻早于行程", "image time before the drive"),
    ("image_not_rendered", "无法渲染鸟瞰图", "bird's-eye image cannot be rendered"),
    ("image_in_video", "图片在视频中", "image inside a video"),
    ("image_file_missing", "缺少图片文件", "image file missing"),
    ("image_not_blurred", "图片未能模糊处理", "image could not be blurred"),
    ("between_kept", "介于旧数据集的两个划分之间", "between two splits of the earlier release"),
    ("duplicate_exact", "完全重复", "exact duplicate"),
    ("duplicate_near", "近似重复", "near-duplicate"),
    ("duplicate_across", "与其他划分近似重复", "near-duplicate of another split"),
    ("cap_cell", "超过单元上限", "over the cap of its cell"),
    ("cap_leaf", "超过 L3 场景上限", "over the cap of its leaf"),
];

/// The reason in words with this identifier, as [`Manifest`](crate::Manifest) counts them.
pub fn reason_in_words(id: &str) -> Bilingual {
    REASONS
        .iter()
        .find(|(known, ..)| *known == id)
        .map_or_else(|| Bilingual::same(id), |(_, zh, en)| Bilingual::new(*zh, *en))
}

/// Id of a sample as bytes; its text form is hexadecimal.
pub(crate) type SampleId = [u8; 8];

pub(crate) fn id_text(id: SampleId) -> String {
    hex(&id)
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// A candidate.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub id: SampleId,
    /// The label (or episode) in `labels.records`.
    pub label: RecordRef,
    /// The same in the other language.
    pub other: Option<RecordRef>,
    /// The mined episode that the label is about, where both were read.
    pub episode: Option<RecordRef>,
    /// Index into the build's drives.
    pub drive: u32,
    pub keyframe_ns: i64,
    /// Index into the build's classes.
    pub class: u32,
    /// Index into the build's statuses.
    pub status: u32,
    pub checked: bool,
    pub score: f32,
    /// Language of its trace; `None` where it has none.
    pub lang: Option<Lang>,
    /// Its decision; `None` for an episode.
    pub decision: Option<DrivingDecision>,
    pub dropped: Option<Dropped>,
    pub cut: Option<Box<Cut>>,
    pub split: Option<SplitName>,
    /// Connected component.
    pub component: u32,
    /// Index into the build's place cells; `u32::MAX`: none.
    pub place_cell: u32,
    pub weight: f64,
}

impl Item {
    pub fn kept(&self) -> bool {
        self.dropped.is_none()
    }
}

/// The three splits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SplitName {
    /// Training.
    Train,
    /// Validation.
    Val,
    /// Test.
    Test,
}

impl SplitName {
    /// All splits.
    pub const ALL: [Self; 3] = [Self::Train, Self::Val, Self::Test];

    /// `train`, `val`, `test`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Val => "val",
            Self::Test => "test",
        }
    }

    /// The split with this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|split| split.name() == name)
    }
}

/// A day, ns.
pub(crate) const DAY_NS: i64 = 86_400_000_000_000;

/// The data of a cut sample for the later stages.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Cut {
    /// The sample in its drive's record file.
    pub at: RecordRef,
    /// Hash of the model's input and target, independent of the drive's name.
    pub content: [u8; 16],
    pub descriptor: Vec<f32>,
    pub sketch: [u32; SKETCH],
    pub position: Option<Position>,
    /// Days since 1970.
    pub day: i32,
    pub longitudinal: Option<u8>,
    pub lateral: Option<u8>,
    pub images: u16,
}

/// Position of a sample, comparable inside one frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Position {
    /// `geo`, or `map:<place>`.
    pub frame: String,
    /// m. Of `geo`: on a sphere around the Earth's center, so that distances are correct everywhere.
    pub p: [f64; 3],
    /// For polygons and cells: map x and y in m, or longitude and latitude in degrees.
    pub plane: [f64; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_candidate_stays_within_the_stated_bound() {
        // The heap: the descriptor and the frame's name; the detail of a drop replaces the cut's use.
        let heap = DESCRIPTOR * size_of::<f32>() + 64 + 128;
        let all = size_of::<Item>() + size_of::<Cut>() + heap;
        assert!(all <= BYTES_PER_SAMPLE, "{all}");
    }
}
