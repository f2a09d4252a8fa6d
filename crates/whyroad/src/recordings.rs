//! The engine's recordings, handed to the labelling service: each answer is one call.

use std::path::PathBuf;
use std::sync::Arc;
use whyroad_engine::label_drives::LabelDrives;
use whyroad_engine::recordings::{LakeRecordings, MinedFolderError};
use whyroad_framework::Framework;
use whyroad_label::check::{Recorded, Recordings as _};
use whyroad_label::draft;
use whyroad_lake::Lake;
use whyroad_model::messages::{CocLabel, EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Drive, DriveId, Lang, SignalTable};
use whyroad_server::domain::scene::{SignalAbout, SignalKind};
use whyroad_server::recordings::Recordings;
use whyroad_signals::{Catalogue, SignalKind as Kind};

/// What the service sees of a lake.
pub(crate) struct ServiceRecordings {
    lake: LakeRecordings,
    /// Whole drives, for checks after Stage I.
    checked: LabelDrives,
    framework: &'static Framework,
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
        Ok(Self { lake: LakeRecordings::open(lake, mined, media)?, checked, framework })
    }
}

impl Recordings for ServiceRecordings {
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, String> {
        self.lake.drive(id).map_err(|e| e.to_string())
    }

    fn version(&self, id: &DriveId) -> String {
        self.lake.version(id)
    }

    fn signals(&self, drive: &Drive) -> SignalTable {
        self.lake.signals(drive)
    }

    fn estimated(&self, drive: &Arc<Drive>) -> Arc<Drive> {
        self.lake.estimated(drive)
    }

    fn about(&self, name: &str) -> Option<SignalAbout> {
        let def = Catalogue::bundled().get(name)?;
        let (kind, unit) = match &def.kind {
            // Columns hold base units, whatever the catalogue writes.
            Kind::Number(dimension) => (SignalKind::Number, dimension.base().symbol),
            Kind::Flag => (SignalKind::Flag, ""),
            Kind::Category(_) => (SignalKind::Category, ""),
        };
        let unit = (!unit.is_empty()).then(|| unit.to_owned());
        Some(SignalAbout { kind, unit, meaning: def.meaning.clone() })
    }

    fn draft(&self, drive: &Drive, signals: &SignalTable, episode: &EpisodeRecord, lang: Lang) -> CocLabel {
        draft::draft(self.framework, drive, signals, episode, lang).label
    }

    fn recorded(&self, clip_id: &str) -> Option<Arc<Recorded>> {
        self.checked.of_clip(clip_id)
    }

    fn mined(&self) -> Vec<String> {
        self.lake.mined()
    }

    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, String>> {
        Some(self.lake.episode_count(name, filter)?.map_err(|e| e.to_string()))
    }

    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, String>> {
        Some(self.lake.episodes(name, filter, after, limit)?.map_err(|e| e.to_string()))
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
        // As schema/signals.yaml says; an angle written in degrees there is a column in radians.
        assert_eq!(unit("ego.accel"), Some((SignalKind::Number, Some("m/s2".into()))));
        assert_eq!(unit("map.sight_angle"), Some((SignalKind::Number, Some("rad".into()))));
        assert_eq!(unit("target.visible_share"), Some((SignalKind::Number, None)));
        assert_eq!(unit("target.emerges"), Some((SignalKind::Flag, None)));
        assert_eq!(unit("lead.class"), Some((SignalKind::Category, None)));
        assert_eq!(unit("ego.no_such"), None);
    }
}
