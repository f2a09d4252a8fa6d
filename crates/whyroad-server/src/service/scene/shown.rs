//! The part of a drive that a task shows now.

use crate::app::App;
use crate::domain::workflow::Stage;
use crate::problem::{Answer, Problem};
use crate::service::tasks::TaskRow;
use std::sync::Arc;
use whyroad_model::{Drive, FrameRange, Nanos};

/// The drive of a task as far as it may be shown, and the frames that are shown.
pub struct Shown {
    /// Whole, or cut at the keyframe.
    pub drive: Arc<Drive>,
    /// Frames that are shown.
    pub frames: FrameRange,
}

/// The part of the drive that may be shown now.
pub fn shown(app: &App, t: &TaskRow) -> Answer<Shown> {
    shown_in(app, t, t.at.state.stage())
}

/// The part of the drive that `stage` shows.
pub(super) fn shown_in(app: &App, t: &TaskRow, stage: Stage) -> Answer<Shown> {
    let whole = app.recordings.drive(&t.drive_id.as_str().into()).map_err(|why| {
        Problem::new(
            503,
            "drive.missing",
            format!("行程不可用：{}", why.zh),
            format!("the drive is unavailable: {}", why.en),
        )
    })?;
    let (drive, last) = match stage {
        Stage::Stage1 => (Arc::new(whole.until(Nanos(t.keyframe_ns))), t.keyframe_ns),
        Stage::Stage2 => (whole, t.to_ns),
    };
    let start = drive.times.partition_point(|at| at.0 < t.shown_from());
    let end = drive.times.partition_point(|at| at.0 <= last);
    Ok(Shown { drive, frames: FrameRange::new(start, end) })
}
