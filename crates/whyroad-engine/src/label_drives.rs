//! Drives of a lake for the checks of labels: by clip id, with their signals and the episodes that the rules find. What
//! was used last stays in memory, up to a number of bytes.

mod bytes;
mod kept;
#[cfg(test)]
mod tests;

use crate::drives::signals_of;
use crate::output::record::write_down;
use kept::Kept;
use std::sync::{Arc, OnceLock};
use whyroad_framework::Framework;
use whyroad_label::check::{COMPONENT_SIGNALS, Recorded, Recordings};
use whyroad_lake::Lake;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::fast::{Plan, Signals, find_all};
use whyroad_mining::rule::RuleSet;
use whyroad_model::{ClipCut, ClipId, Drive, DriveId, Lang, Nanos};
use whyroad_signals::{Catalog, Wanted, derive_wanted, estimate};

/// Memory for what is kept of the lake, about. A drive of 20 s takes 3 to 40 MB, by the number of its objects.
const KEPT_BYTES: usize = 192 << 20;

/// Drives of one lake.
pub struct LabelDrives {
    lake: Lake,
    rules: RuleSet,
    /// Of `rules`, made when the first drive is mined.
    plan: OnceLock<Plan<'static>>,
    /// As the lake has them.
    measured: Kept<Version, Drive>,
    /// Estimated, with signals and episodes.
    recorded: Kept<Version, Recorded>,
    /// Cut at a keyframe.
    histories: Kept<(Version, Nanos), Recorded>,
}

/// A drive and its stamp.
type Version = (DriveId, String);

impl LabelDrives {
    /// Drives of `lake`, mined with the rules of `framework`. Rules with errors are left out; loading has reported
    /// them.
    pub fn new(lake: Lake, framework: &Framework) -> Self {
        Self::keeping(KEPT_BYTES, lake, framework)
    }

    /// [`LabelDrives::new`] that keeps this many bytes, about, or one drive that is larger.
    fn keeping(bytes: usize, lake: Lake, framework: &Framework) -> Self {
        let (rules, _) = RuleSet::of_framework(framework, Catalog::bundled());
        let sixth = bytes / 6;
        Self {
            lake,
            rules,
            plan: OnceLock::new(),
            measured: Kept::new(sixth),
            recorded: Kept::new(4 * sixth),
            histories: Kept::new(sixth),
        }
    }

    fn version(&self, clip_id: &str) -> Option<Version> {
        let id = drive_of_clip(clip_id)?;
        let stamp = self.lake.stamp(&id).ok()?;
        Some((id, format!("{stamp:?}")))
    }

    fn measured(&self, version: &Version) -> Option<Arc<Drive>> {
        self.measured.get(version, || {
            let drive = self.lake.read_drive(&version.0).ok()?;
            let bytes = bytes::of_drive(&drive);
            Some((drive, bytes))
        })
    }

    /// The recorded drive, and the bytes that it takes.
    fn read(&self, version: &Version) -> Option<(Recorded, usize)> {
        let id = &version.0;
        let measured = self.measured(version)?;
        let drive = match estimate(&measured) {
            std::borrow::Cow::Owned(complete) => Arc::new(complete),
            std::borrow::Cow::Borrowed(_) => Arc::clone(&measured),
        };
        let signals = signals_of(&self.lake, id).ok()?;
        let plan = self.plan.get_or_init(|| Plan::owning(&self.rules));
        let found = find_all(plan, &Signals::of_table(&signals));
        let mined = arbitrated(&self.rules, id, &drive.times, found);
        let episodes = write_down(&mined.episodes, id, &drive.times, ClipCut::Fixed, Lang::En);
        let episodes: Vec<_> = episodes.into_iter().map(|e| e.record).collect();
        let bytes = bytes::of_drive(&drive) + bytes::of_signals(&signals) + bytes::of_episodes(&episodes);
        Some((Recorded { drive, signals: Arc::new(signals), episodes }, bytes))
    }
}

/// `drive` as Stage I shows it, cut at `keyframe`, with what the checks of components read.
fn history(drive: &Drive, keyframe: Nanos) -> Option<Recorded> {
    let cut = drive.until(keyframe);
    if cut.times.is_empty() {
        return None;
    }
    let signals = derive_wanted(&cut, &Wanted::only(COMPONENT_SIGNALS));
    let drive = Drive { map: None, lights: None, context: None, media: None, ..cut };
    Some(Recorded { drive: Arc::new(drive), signals: Arc::new(signals), episodes: Vec::new() })
}

/// The drive that a clip is cut from: its id without the clip's number.
pub fn drive_of_clip(clip_id: &str) -> Option<DriveId> {
    ClipId(clip_id.to_owned()).drive()
}

impl Recordings for LabelDrives {
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>> {
        let version = self.version(clip_id)?;
        self.recorded.get(&version, || self.read(&version))
    }

    fn until(&self, clip_id: &str, keyframe: Nanos) -> Option<Arc<Recorded>> {
        let key = (self.version(clip_id)?, keyframe);
        self.histories.get(&key, || {
            let cut = history(&*self.measured(&key.0)?, keyframe)?;
            let bytes = bytes::of_drive(&cut.drive) + bytes::of_signals(&cut.signals);
            Some((cut, bytes))
        })
    }
}
