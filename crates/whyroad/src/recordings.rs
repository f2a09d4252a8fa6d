//! The engine's recordings for the labeling service: each method is one call.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use whyroad_dataset::similar::{self, EpisodeDescriptor};
use whyroad_engine::label_drives::LabelDrives;
use whyroad_engine::recordings::{self, LakeRecordings, MinedFolderError};
use whyroad_framework::Framework;
use whyroad_label::check::{Recorded, Recordings as _};
use whyroad_label::draft;
use whyroad_lake::{Lake, LakeError};
use whyroad_model::messages::{
    CocLabel, CriticalComponent, EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord,
};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, Drive, DriveId, Lang, Nanos, ScenarioId, SignalTable};
use whyroad_server::domain::scene::{SignalAbout, SignalKind};
use whyroad_server::recordings::{Recordings, Similar, StoredImage, span_of};
use whyroad_signals::{Catalog, SignalKind as Kind};

/// The service's view of a lake.
pub(crate) struct ServiceRecordings {
    lake: LakeRecordings,
    /// Whole drives, for checks after Stage I.
    checked: LabelDrives,
    framework: &'static Framework,
    /// By version of the drive and episode; none for a moment without a pose.
    descriptors: Mutex<HashMap<(String, String), Option<EpisodeDescriptor>>>,
}

impl ServiceRecordings {
    /// See [`LakeRecordings::open`].
    pub(crate) fn open(
        lake: Lake,
        framework: &'static Framework,
        mined: &[PathBuf],
        media: &[PathBuf],
    ) -> Result<Self, MinedFolderError> {
        let checked = LabelDrives::new(lake.clone(), framework);
        Ok(Self {
            lake: LakeRecordings::open(lake, mined, media)?,
            checked,
            framework,
            descriptors: Mutex::default(),
        })
    }
}

impl ServiceRecordings {
    /// See [`LakeRecordings::image_origins`].
    pub(crate) fn image_origins(&self) -> Result<Vec<String>, LakeError> {
        self.lake.image_origins()
    }
}

/// Maximum number of episodes of the L2 that one is compared with. A descriptor takes about a millisecond once the
/// drive is in memory.
const MOST_COMPARED: usize = 2000;
/// Maximum number of kept descriptors.
const MOST_KEPT: usize = 20_000;

impl ServiceRecordings {
    /// The `limit` of `others` that resemble `episode` most. Descriptors are made drive by drive and kept.
    fn nearest(
        &self,
        episode: &EpisodeRecord,
        others: Vec<EpisodeRecord>,
        limit: usize,
    ) -> Result<Similar, Bilingual> {
        let mut by_drive: BTreeMap<DriveId, Vec<EpisodeRecord>> = BTreeMap::new();
        for e in others.into_iter().filter(|e| e.episode_id != episode.episode_id) {
            by_drive.entry(e.drive_id.clone()).or_default().push(e);
        }
        let own = self.described(&episode.drive_id, std::slice::from_ref(episode))?.remove(0);
        let own = own.ok_or_else(|| {
            Bilingual::new("行程在关键帧处没有自车位姿", "the drive has no pose at the keyframe")
        })?;
        let mut out = Similar::default();
        for (drive, episodes) in by_drive {
            // The rest is shown even if a drive is no longer in the lake.
            let Ok(described) = self.described(&drive, &episodes) else { continue };
            for (e, descriptor) in episodes.into_iter().zip(described) {
                if let Some(descriptor) = descriptor {
                    out.compared += 1;
                    out.nearest.push((e, own.similarity(&descriptor)));
                }
            }
        }
        out.nearest.sort_by(|(a, x), (b, y)| y.total_cmp(x).then_with(|| a.episode_id.cmp(&b.episode_id)));
        out.nearest.truncate(limit);
        Ok(out)
    }

    /// Descriptors of episodes of one drive.
    fn described(
        &self,
        drive: &DriveId,
        episodes: &[EpisodeRecord],
    ) -> Result<Vec<Option<EpisodeDescriptor>>, Bilingual> {
        let key = |e: &EpisodeRecord| (self.lake.version(drive), e.episode_id.clone());
        let known: Vec<Option<Option<EpisodeDescriptor>>> = {
            let kept = self.descriptors.lock().map_err(|e| Bilingual::same(e.to_string()))?;
            episodes.iter().map(|e| kept.get(&key(e)).cloned()).collect()
        };
        if known.iter().all(Option::is_some) {
            return Ok(known.into_iter().flatten().collect());
        }
        let recorded = self.estimated(&self.drive(drive)?);
        let made = similar::describe(self.framework, &recorded, episodes);
        let mut kept = self.descriptors.lock().map_err(|e| Bilingual::same(e.to_string()))?;
        if kept.len() + made.len() > MOST_KEPT {
            kept.clear();
        }
        kept.extend(episodes.iter().zip(&made).map(|(e, d)| (key(e), d.clone())));
        Ok(made)
    }
}

/// An image that the engine found in an object store.
struct LinkableImage(recordings::StoredImage);

impl StoredImage for LinkableImage {
    fn name(&self) -> &str {
        &self.0.media.key
    }

    fn link(&self, lifetime: Duration) -> Result<String, Bilingual> {
        self.0.store.link(&self.0.media, lifetime).map_err(in_words)
    }

    fn read(&self) -> Result<Option<Vec<u8>>, Bilingual> {
        self.0.store.read(&self.0.media).map_err(in_words)
    }
}

/// Errors of the lake, in both languages.
fn in_words(error: LakeError) -> Bilingual {
    error.diagnostic().message
}

impl Recordings for ServiceRecordings {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual> {
        self.lake.drive(id).map_err(in_words)
    }

    fn span(&self, id: &DriveId) -> Result<(Nanos, Nanos), Bilingual> {
        span_of(&self.lake.frame_times(id).map_err(in_words)?)
    }

    fn version(&self, id: &DriveId) -> String {
        self.lake.version(id)
    }

    fn compares(&self) -> bool {
        true
    }

    fn ready(&self) -> Result<(), Bilingual> {
        self.lake.ready().map_err(in_words)
    }

    fn signals(&self, drive: &Drive) -> SignalTable {
        self.lake.signals(drive)
    }

    fn whole_signals(&self, drive: &Drive) -> SignalTable {
        self.lake.whole_signals(drive)
    }

    fn estimated(&self, drive: &Arc<Drive>) -> Arc<Drive> {
        self.lake.estimated(drive)
    }

    fn about(&self, name: &str) -> Option<SignalAbout> {
        let def = Catalog::bundled().get(name)?;
        let (kind, unit) = match &def.kind {
            // Columns hold base units, whatever the catalog writes.
            Kind::Number(dimension) => (SignalKind::Number, dimension.base().symbol),
            Kind::Flag => (SignalKind::Flag, ""),
            Kind::Category(_) => (SignalKind::Category, ""),
        };
        let unit = (!unit.is_empty()).then(|| unit.to_owned());
        Some(SignalAbout { kind, unit, title: def.title.clone(), meaning: def.meaning.clone() })
    }

    fn draft(
        &self,
        drive: &Drive,
        signals: &SignalTable,
        episode: &EpisodeRecord,
        lang: Lang,
        listed: Option<&[CriticalComponent]>,
    ) -> CocLabel {
        let made = match listed {
            Some(listed) => draft::draft_of_listed(self.framework, drive, signals, episode, lang, listed),
            None => draft::draft(self.framework, drive, signals, episode, lang),
        };
        made.label
    }

    fn components(&self, drive: &Drive, episode: &EpisodeRecord, lang: Lang) -> Vec<CriticalComponent> {
        draft::components(self.framework, drive, &self.lake.last_frame(drive), episode, lang)
    }

    fn recorded(&self, clip_id: &str) -> Option<Arc<Recorded>> {
        self.checked.of_clip(clip_id)
    }

    fn recorded_until(&self, clip_id: &str, keyframe: Nanos) -> Option<Arc<Recorded>> {
        self.checked.until(clip_id, keyframe)
    }

    fn mined(&self) -> Vec<String> {
        self.lake.mined()
    }

    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, Bilingual>> {
        Some(self.lake.episode_count(name, filter)?.map_err(in_words))
    }

    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, Bilingual>> {
        Some(self.lake.episodes(name, filter, after, limit)?.map_err(in_words))
    }

    fn similar(
        &self,
        name: &str,
        episode: &EpisodeRecord,
        limit: usize,
    ) -> Option<Result<Similar, Bilingual>> {
        let l2 = ScenarioId { l3: None, ..episode.scenario_id.clone() };
        let filter = EpisodeFilter { scenario: Some(l2), ..EpisodeFilter::default() };
        let page = match self.episodes(name, &filter, None, MOST_COMPARED)? {
            Ok(page) => page,
            Err(why) => return Some(Err(why)),
        };
        Some(self.nearest(episode, page.episodes, limit))
    }

    fn stored_image(
        &self,
        drive: &DriveId,
        frame: &MediaFrame,
    ) -> Result<Option<Box<dyn StoredImage>>, Bilingual> {
        let found = self.lake.stored_image(drive, frame).map_err(in_words)?;
        Ok(found.map(|image| Box::new(LinkableImage(image)) as Box<dyn StoredImage>))
    }

    fn media(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        self.lake.media(drive, frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_has_the_unit_of_its_column() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        let recordings = ServiceRecordings::open(lake, Framework::bundled(), &[], &[]).unwrap();
        let unit = |name: &str| recordings.about(name).map(|a| (a.kind, a.unit));
        // As in schema/signals.yaml; an angle written in degrees there is a column in radians.
        assert_eq!(unit("ego.accel"), Some((SignalKind::Number, Some("m/s2".into()))));
        assert_eq!(unit("map.sight_angle"), Some((SignalKind::Number, Some("rad".into()))));
        assert_eq!(unit("target.visible_share"), Some((SignalKind::Number, None)));
        assert_eq!(unit("target.emerges"), Some((SignalKind::Flag, None)));
        assert_eq!(unit("lead.class"), Some((SignalKind::Category, None)));
        assert_eq!(unit("ego.no_such"), None);
    }
}
