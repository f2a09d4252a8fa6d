//! The rows over which a program is evaluated: the frames of a drive, and one row for each gap between them.

use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{FrameRange, Nanos};

/// A frame, or the hole where frames are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// When it begins.
    pub time: Nanos,
    /// When the next one begins: a frame represents the time until then.
    pub end: Nanos,
    /// Frame of the drive; `None` in a gap, where nothing is known.
    pub frame: Option<usize>,
}

/// All rows of a drive.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// In order of time, without holes.
    pub rows: Vec<Row>,
}

/// Nominal time between frames.
pub const STEP: Nanos = Nanos((1e9 / FRAME_RATE_HZ) as i64);

/// Frames further apart than this have a gap between them: at 10 Hz, one lost frame makes a gap.
const GAP: Nanos = Nanos(STEP.0 * 3 / 2);

impl Timeline {
    /// The rows of a drive with these frame times.
    pub fn new(times: &[Nanos]) -> Self {
        let mut rows = Vec::with_capacity(times.len());
        for (i, &time) in times.iter().enumerate() {
            let next = times.get(i + 1).copied();
            let gap = next.is_some_and(|n| n - time > GAP);
            let end = if gap { time + STEP } else { next.unwrap_or(time + STEP) };
            rows.push(Row { time, end, frame: Some(i) });
            if let (true, Some(next)) = (gap, next) {
                rows.push(Row { time: end, end: next, frame: None });
            }
        }
        Self { rows }
    }

    /// Rows from the first to the last of these frames, gaps between them included.
    pub fn window(&self, frames: FrameRange) -> (usize, usize) {
        let from = self.position(frames.start);
        if frames.is_empty() { (from, from) } else { (from, self.position(frames.end - 1) + 1) }
    }

    /// The row of a frame.
    pub fn position(&self, frame: usize) -> usize {
        // Gaps only ever shift a frame to the right of its own index.
        (frame..self.rows.len()).find(|&i| self.rows[i].frame == Some(frame)).unwrap_or(self.rows.len())
    }
}
