//! Which frames of a drive a clip has. The id states it, so it is not stored: `<drive>_<number>` is a clip of the
//! division of a drive into stretches of [`CLIP_FRAMES`], `<drive>_k<first frame>` one that was cut around a keyframe.
//! No clip goes on over a gap of the recording: what lies on both sides of it are two situations.

use crate::scene::{CLIP_FRAMES, FRAME_RATE_HZ};
use crate::{ClipId, DriveId, FrameRange, Nanos};

/// A longer time between two frames ends a clip, s: a logger that paused. Shorter ones are messages that were lost.
const CLIP_GAP_S: f64 = 5.0;

/// How clips are cut from drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClipCut {
    /// One after the other from the start of the drive, [`CLIP_FRAMES`] each, the last one and those before a gap
    /// shorter.
    #[default]
    Fixed,
    /// Around the keyframe of each primary episode: in the middle of [`CLIP_FRAMES`], or as near to it as the ends of
    /// the drive, or gaps, allow. Clips may overlap.
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

    /// The clip around frame `keyframe` of a drive with frames at these times.
    pub fn around(drive: &DriveId, keyframe: usize, times: &[Nanos]) -> (Self, FrameRange) {
        let part = part_with(keyframe, times);
        let latest = part.end.saturating_sub(CLIP_FRAMES).max(part.start);
        let start = keyframe.saturating_sub(CLIP_FRAMES / 2).clamp(part.start, latest);
        let id = Self(format!("{drive}_k{start:06}"));
        (id, FrameRange::new(start, (start + CLIP_FRAMES).min(part.end)))
    }

    /// The clip that frame `frame` belongs to in the division of a drive with frames at these times.
    pub fn holding(drive: &DriveId, frame: usize, times: &[Nanos]) -> (Self, FrameRange) {
        let clips = division(times);
        let index = clips.partition_point(|clip| clip.end <= frame);
        (Self::of(drive, index), clips.get(index).copied().unwrap_or_default())
    }

    /// True for a clip that was cut around a keyframe: its frames are also in clips of the division.
    pub fn is_around_keyframe(&self) -> bool {
        matches!(self.parts(), Some((_, ClipNumber::Keyframe(_))))
    }

    /// The drive that the clip is of; `None` where the id is not that of a clip.
    pub fn drive(&self) -> Option<DriveId> {
        self.parts().map(|(drive, _)| DriveId::from(drive))
    }

    /// Its frames in `drive`, which has frames at these times; `None` where the drive has no such clip.
    pub fn frames(&self, drive: &DriveId, times: &[Nanos]) -> Option<FrameRange> {
        let (_, number) = self.parts().filter(|(of, _)| *of == drive.as_str())?;
        let range = match number {
            ClipNumber::Fixed(index) => division(times).get(index).copied().unwrap_or_default(),
            ClipNumber::Keyframe(start) => {
                let end = part_with(start, times).end;
                FrameRange::new(start.min(end), (start.saturating_add(CLIP_FRAMES)).min(end))
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

fn parts_at(before: Nanos, after: Nanos) -> bool {
    after.seconds_since(before) > CLIP_GAP_S
}

/// Time at which the frame before `end` is over: when the next one begins, or a nominal period later at the end of the
/// drive and before a gap.
pub fn end_time(times: &[Nanos], end: usize) -> Nanos {
    let last = end.checked_sub(1).and_then(|i| times.get(i)).or(times.last()).copied();
    let goes_on = |t: &Nanos| last.is_none_or(|last| !parts_at(last, *t));
    match times.get(end).copied().filter(goes_on) {
        Some(t) => t,
        None => last.map_or(Nanos::default(), |t| t.plus_secs(1.0 / FRAME_RATE_HZ)),
    }
}

/// The clips of the division of a drive with frames at these times, in order.
pub fn division(times: &[Nanos]) -> Vec<FrameRange> {
    let mut starts = Vec::new();
    for (frame, time) in times.iter().enumerate() {
        let begins = starts
            .last()
            .is_none_or(|&start| frame - start == CLIP_FRAMES || parts_at(times[frame - 1], *time));
        if begins {
            starts.push(frame);
        }
    }
    let ends = starts.iter().skip(1).copied().chain([times.len()]);
    starts.iter().copied().zip(ends).map(|(start, end)| FrameRange::new(start, end)).collect()
}

/// The number of the clip of the division that each frame is in.
pub fn clip_of_frames(times: &[Nanos]) -> Vec<usize> {
    division(times).iter().enumerate().flat_map(|(clip, range)| vec![clip; range.len()]).collect()
}

/// The frames from one gap to the next around this one.
fn part_with(frame: usize, times: &[Nanos]) -> FrameRange {
    let here = frame.min(times.len());
    let start = (1..here).rfind(|&i| parts_at(times[i - 1], times[i]));
    let start = if here > 0 && here < times.len() && parts_at(times[here - 1], times[here]) {
        here
    } else {
        start.unwrap_or(0)
    };
    let end = (here + 1..times.len()).find(|&i| parts_at(times[i - 1], times[i])).unwrap_or(times.len());
    FrameRange::new(start, end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> DriveId {
        DriveId::from("city_7")
    }

    fn times(frames: usize) -> Vec<Nanos> {
        (0..frames as i64).map(|i| Nanos(i * 100_000_000)).collect()
    }

    #[test]
    fn an_id_says_which_frames() {
        let frames = |id: &str| ClipId(id.to_owned()).frames(&drive(), &times(450)).map(|f| (f.start, f.end));
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
            let (id, range) = ClipId::around(&drive(), keyframe, &times(frames));
            assert_eq!(id.frames(&drive(), &times(frames)), Some(range));
            assert!(range.contains(keyframe) && id.is_around_keyframe());
            (range.start, range.end)
        };
        assert_eq!(around(250, 450), (150, 350));
        // At the ends; a short drive.
        assert_eq!((around(30, 450), around(449, 450), around(80, 90)), ((0, 200), (250, 450), (0, 90)));
        assert_eq!(
            ClipId::holding(&drive(), 410, &times(450)),
            (ClipId::of(&drive(), 2), FrameRange::new(400, 450))
        );
        assert!(!ClipId::of(&drive(), 2).is_around_keyframe());
    }

    #[test]
    fn no_clip_goes_on_over_a_pause_of_the_logger() {
        // 300 frames, a pause of 600 s, 100 frames, 4 s without messages, 50 frames.
        let mut times = times(450);
        times[300..].iter_mut().for_each(|t| t.0 += 600_000_000_000);
        times[400..].iter_mut().for_each(|t| t.0 += 4_000_000_000);
        let pairs = |ranges: Vec<FrameRange>| ranges.iter().map(|r| (r.start, r.end)).collect::<Vec<_>>();
        assert_eq!(pairs(division(&times)), [(0, 200), (200, 300), (300, 450)]);
        assert_eq!(clip_of_frames(&times)[299..301], [1, 2]);
        for (frame, expected) in [(299, (200, 300)), (300, (300, 450)), (449, (300, 450))] {
            let (id, range) = ClipId::holding(&drive(), frame, &times);
            assert_eq!(((range.start, range.end), id.frames(&drive(), &times)), (expected, Some(range)));
        }
        for (keyframe, expected) in
            [(290, (100, 300)), (305, (300, 450)), (300, (300, 450)), (299, (100, 300))]
        {
            let (id, range) = ClipId::around(&drive(), keyframe, &times);
            assert_eq!(((range.start, range.end), id.frames(&drive(), &times)), (expected, Some(range)));
        }
        assert_eq!(division(&[]), []);
    }
}
