//! Drives of a lake for the checks of labels: by clip id, with their signals and the episodes that the rules find; the
//! last few stay in memory, because labels are mostly ordered by drive.

use crate::drives::signals_of;
use crate::output::record::write_down;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use whyroad_framework::Framework;
use whyroad_label::check::{COMPONENT_SIGNALS, Recorded, Recordings};
use whyroad_lake::Lake;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::fast::{Plan, Signals, find_all};
use whyroad_mining::rule::RuleSet;
use whyroad_model::{ClipCut, ClipId, Drive, DriveId, Lang, Nanos};
use whyroad_signals::{Catalog, Wanted, derive_wanted};

/// Drives kept in memory.
const KEPT: usize = 8;
/// Drives cut at a keyframe that are kept: without their map and most signals they are small.
const HISTORIES_KEPT: usize = 64;

/// Drives of one lake.
pub struct LabelDrives {
    lake: Lake,
    rules: RuleSet,
    kept: Mutex<VecDeque<(DriveId, Option<Arc<Recorded>>)>>,
    histories: Mutex<VecDeque<(History, Option<Arc<Recorded>>)>>,
}

/// A drive's version and a keyframe.
type History = (DriveId, String, Nanos);

impl LabelDrives {
    /// Drives of `lake`, mined with the rules of `framework`. Rules with errors are left out; loading has reported
    /// them.
    pub fn new(lake: Lake, framework: &Framework) -> Self {
        let (rules, _) = RuleSet::of_framework(framework, Catalog::bundled());
        Self { lake, rules, kept: Mutex::default(), histories: Mutex::default() }
    }

    fn read(&self, id: &DriveId) -> Option<Arc<Recorded>> {
        let drive = crate::estimated(self.lake.read_drive(id).ok()?);
        let signals = signals_of(&self.lake, id).ok()?;
        let plan = Plan::of(&self.rules);
        let found = find_all(&plan, &Signals::of_table(&signals));
        let mined = arbitrated(&self.rules, id, &drive.times, found);
        let episodes = write_down(&mined.episodes, id, &drive.times, ClipCut::Fixed, Lang::En);
        let episodes = episodes.into_iter().map(|e| e.record).collect();
        Some(Arc::new(Recorded { drive: Arc::new(drive), signals: Arc::new(signals), episodes }))
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
        let id = drive_of_clip(clip_id)?;
        {
            let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, found)) = kept.iter().find(|(k, _)| *k == id) {
                return found.clone();
            }
        }
        let found = self.read(&id);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_front((id, found.clone()));
        kept.truncate(KEPT);
        found
    }

    fn until(&self, clip_id: &str, keyframe: Nanos) -> Option<Arc<Recorded>> {
        let id = drive_of_clip(clip_id)?;
        let version = self.lake.stamp(&id).map(|s| format!("{s:?}")).ok()?;
        let key = (id, version, keyframe);
        {
            let kept = self.histories.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, found)) = kept.iter().find(|(k, _)| *k == key) {
                return found.clone();
            }
        }
        let found = self.lake.read_drive(&key.0).ok().and_then(|d| history(&d, keyframe)).map(Arc::new);
        let mut kept = self.histories.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_front((key, found.clone()));
        kept.truncate(HISTORIES_KEPT);
        found
    }
}
