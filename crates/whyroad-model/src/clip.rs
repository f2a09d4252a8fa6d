//! Which frames of a drive a clip has. The id states it, so it is not stored: `<drive>_<number>` is a clip of the
//! division of a drive into stretches of [`CLIP_FRAMES`], `<drive>_k<first frame>` one that was cut around a keyframe.

use crate::scene::CLIP_FRAMES;
use crate::{ClipId, DriveId, FrameRange};

/// How clips are cut from drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClipCut {
    /// One after the other from the start of the drive, [`CLIP_FRAMES`] each, the last one shorter.
    #[default]
    Fixed,
    /// Around the keyframe of each primary episode: in the middle of [`CLIP_FRAMES`], or as near to it as the ends of
    /// the drive allow. Clips may overlap.
    Keyframe,
}

/// Meaning of the last part of a clip's id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClipNumber {
    /// Number of the clip.
    Fixed(usize),
    /// First frame of the clip.
    Keyframe(usize),
}

impl ClipId {
    /// The id of the `index`-th clip of `drive`.
    pub fn of(drive: &DriveId, index: usize) -> Self {
        Self(format!("{drive}_{index:03}"))
    }

    /// The clip around frame `keyframe` of a drive with this number of frames.
    pub fn around(drive: &DriveId, keyframe: usize, frames: usize) -> (Self, FrameRange) {
        let start = keyframe.saturating_sub(CLIP_FRAMES / 2).min(frames.saturating_sub(CLIP_FRAMES));
        let id = Self(format!("{drive}_k{start:06}"));
        (id, FrameRange::new(start, (start + CLIP_FRAMES).min(frames)))
    }

    /// The clip that frame `frame` belongs to in the division of a drive with this number of frames.
    pub fn holding(drive: &DriveId, frame: usize, frames: usize) -> (Self, FrameRange) {
        let index = frame / CLIP_FRAMES;
        (Self::of(drive, index), fixed(index, frames))
    }

    /// True for a clip that was cut around a keyframe: its frames are also in clips of the division.
    pub fn is_around_keyframe(&self) -> bool {
        matches!(self.parts(), Some((_, ClipNumber::Keyframe(_))))
    }

    /// The drive that the clip is of; `None` where the id is not that of a clip.
    pub fn drive(&self) -> Option<DriveId> {
        self.parts().map(|(drive, _)| DriveId::from(drive))
    }

    /// Its frames in `drive`, which has this number of them; `None` where the drive has no such clip.
    pub fn frames(&self, drive: &DriveId, frames: usize) -> Option<FrameRange> {
        let (_, number) = self.parts().filter(|(of, _)| *of == drive.as_str())?;
        let range = match number {
            ClipNumber::Fixed(index) => fixed(index, frames),
            ClipNumber::Keyframe(start) => {
                FrameRange::new(start.min(frames), (start + CLIP_FRAMES).min(frames))
            }
        };
        (!range.is_empty()).then_some(range)
    }

    fn parts(&self) -> Option<(&str, ClipNumber)> {
        let (drive, tail) = self.as_str().rsplit_once('_').filter(|(drive, _)| !drive.is_empty())?;
        let number = |digits: &str, least: usize| {
            // Only the canonical spelling is accepted.
            let plain = digits.len() >= least && digits.bytes().all(|b| b.is_ascii_digit());
            let padded = digits.len() == least || !digits.starts_with('0');
            digits.parse::<usize>().ok().filter(|_| plain && padded)
        };
        let number = match tail.strip_prefix('k') {
            Some(start) => ClipNumber::Keyframe(number(start, 6)?),
            None => ClipNumber::Fixed(number(tail, 3)?),
        };
        Some((drive, number))
    }
}

fn fixed(index: usize, frames: usize) -> FrameRange {
    let start = index.saturating_mul(CLIP_FRAMES).min(frames);
    FrameRange::new(start, (start + CLIP_FRAMES).min(frames))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> DriveId {
        DriveId::from("city_7")
    }

    #[test]
    fn an_id_says_which_frames() {
        let frames = |id: &str| ClipId(id.to_owned()).frames(&drive(), 450).map(|f| (f.start, f.end));
        assert_eq!(frames("city_7_000"), Some((0, 200)));
        assert_eq!(frames("city_7_002"), Some((400, 450)));
        assert_eq!(frames("city_7_k000123"), Some((123, 323)));
        assert_eq!(frames("city_7_k000300"), Some((300, 450)));
        // Of another drive; beyond the drive; not a canonical id.
        for id in [
            "city_8_000",
            "city_7_003",
            "city_7_k000450",
            "city_7_0",
            "city_7_0001",
            "city_7_k12",
            "city_7",
            "x",
        ] {
            assert_eq!(frames(id), None, "{id}");
        }
        assert_eq!(ClipId("city_7_k000123".into()).drive(), Some(drive()));
    }

    #[test]
    fn a_keyframe_is_in_the_middle_where_the_drive_is_long_enough() {
        let around = |keyframe, frames| {
            let (id, range) = ClipId::around(&drive(), keyframe, frames);
            assert_eq!(id.frames(&drive(), frames), Some(range));
            assert!(range.contains(keyframe) && id.is_around_keyframe());
            (range.start, range.end)
        };
        assert_eq!(around(250, 450), (150, 350));
        // At the ends; a short drive.
        assert_eq!((around(30, 450), around(449, 450), around(80, 90)), ((0, 200), (250, 450), (0, 90)));
        assert_eq!(ClipId::holding(&drive(), 410, 450), (ClipId::of(&drive(), 2), FrameRange::new(400, 450)));
        assert!(!ClipId::of(&drive(), 2).is_around_keyframe());
    }
}
