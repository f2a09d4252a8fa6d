//! Drives of a lake for the checks of labels: by clip id, with their signals and the episodes that the rules find; the
//! last few stay in memory, because labels are mostly ordered by drive.

use crate::drives::signals_of;
use crate::output::record::write_down;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use whyroad_framework::Framework;
use whyroad_label::check::{Recorded, Recordings};
use whyroad_lake::Lake;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::fast::{Plan, Signals, find_all};
use whyroad_mining::rule::RuleSet;
use whyroad_model::{ClipCut, ClipId, DriveId, Lang};
use whyroad_signals::Catalog;

/// Drives kept in memory.
const KEPT: usize = 8;

/// Drives of one lake.
pub struct LabelDrives {
    lake: Lake,
    rules: RuleSet,
    kept: Mutex<VecDeque<(DriveId, Option<Arc<Recorded>>)>>,
}

impl LabelDrives {
    /// Drives of `lake`, mined with the rules of `framework`. Rules with errors are left out; loading has reported
    /// them.
    pub fn new(lake: Lake, framework: &Framework) -> Self {
        let (rules, _) = RuleSet::of_framework(framework, Catalog::bundled());
        Self { lake, rules, kept: Mutex::default() }
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
}
