//! Interface to the rest of the program: drives, signals, drafts, mined folders. The caller provides it, so this crate
//! reads no lake and derives no signals.

use crate::domain::scene::SignalAbout;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use whyroad_label::check::Recorded;
use whyroad_model::messages::{
    CocLabel, CriticalComponent, EpisodeCursor, EpisodeFilter, EpisodePage, EpisodeRecord,
};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Bilingual, Drive, DriveId, Lang, Nanos, SignalTable};

/// Episodes similar to one.
#[derive(Clone, Debug, Default)]
pub struct Similar {
    /// With their similarity, 0 to 1.
    pub nearest: Vec<(EpisodeRecord, f64)>,
    /// Episodes that were compared.
    pub compared: u64,
}

/// A camera image in an object store: one image, never a video.
pub trait StoredImage {
    /// Its name in the store, with the extension of its format.
    fn name(&self) -> &str;

    /// An address that gives access to only this image, for this long.
    fn link(&self, lifetime: Duration) -> Result<String, Bilingual>;

    /// The image itself; `None` if it no longer exists.
    fn read(&self) -> Result<Option<Vec<u8>>, Bilingual>;
}

/// Location of a camera image.
pub enum CameraImage {
    /// A file on this machine.
    File(PathBuf),
    /// An object of an object store.
    Stored(Box<dyn StoredImage>),
}

/// Recorded drives and the data derived from them.
pub trait Recordings: Send + Sync {
    /// A drive; an error text when it is unavailable.
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual>;

    /// Times of the first and last frame of a drive; an error text when it is unavailable or has no frame. An
    /// implementation may determine this without reading the drive.
    fn span(&self, id: &DriveId) -> Result<(Nanos, Nanos), Bilingual> {
        span_of(&self.drive(id)?.times)
    }

    /// Changes when the drive on disk changes; data from an older version is then computed again. Constant where drives
    /// do not change.
    fn version(&self, _: &DriveId) -> String {
        String::new()
    }

    /// Whether the recordings can be read; otherwise the reason.
    fn ready(&self) -> Result<(), Bilingual> {
        Ok(())
    }

    /// Signals of `drive`. The service passes drives that were cut at the keyframe, so the result must depend only on
    /// the given drive.
    fn signals(&self, drive: &Drive) -> SignalTable;

    /// The same for a whole drive from [`Recordings::drive`], including its future: never for Stage I. Stored signals
    /// may be used.
    fn whole_signals(&self, drive: &Drive) -> SignalTable {
        self.signals(drive)
    }

    /// `drive` with estimates of values that its log did not measure (velocities), computed only from the given drive.
    fn estimated(&self, drive: &Arc<Drive>) -> Arc<Drive> {
        Arc::clone(drive)
    }

    /// Description of the signal `name`; `None` if there is no such signal.
    fn about(&self, name: &str) -> Option<SignalAbout>;

    /// A label skeleton for an episode of `drive`. If the components of Stage I are given, its trace names only their
    /// objects.
    fn draft(
        &self,
        drive: &Drive,
        signals: &SignalTable,
        episode: &EpisodeRecord,
        lang: Lang,
        listed: Option<&[CriticalComponent]>,
    ) -> CocLabel;

    /// The critical components that Stage I lists, for a drive that was cut at the keyframe; the result must depend
    /// only on the arguments, as for [`Recordings::signals`].
    fn components(&self, drive: &Drive, episode: &EpisodeRecord, lang: Lang) -> Vec<CriticalComponent> {
        self.draft(drive, &self.signals(drive), episode, lang, None).critical_components
    }

    /// The whole drive of a clip with its signals and the episodes that the rules find in it, for checks of labels
    /// whose Stage I is locked; `None` if it is not available. Never for users who must not see the future.
    fn recorded(&self, _clip_id: &str) -> Option<Arc<Recorded>> {
        None
    }

    /// The drive of a clip as Stage I shows it, cut at `keyframe`, for checks of components: it has nothing of
    /// what comes later. `None` if it is not available.
    fn recorded_until(&self, _clip_id: &str, _keyframe: Nanos) -> Option<Arc<Recorded>> {
        None
    }

    /// Whether there is a recorded drive for each label ([`Recordings::recorded`], [`Recordings::recorded_until`]): a
    /// label without one is then reported as not compared, instead of passing as compared and sound.
    fn compares(&self) -> bool {
        false
    }

    /// Names of the folders of mining results from which tasks can be created.
    fn mined(&self) -> Vec<String>;

    /// Number of episodes of a mined folder that match `filter`; `None` for an unknown name, an error text if the
    /// folder cannot be read. Without a filter the time does not depend on the folder's size.
    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, Bilingual>>;

    /// At most `limit` episodes of a mined folder that match `filter`, in the order of drive and keyframe, starting at
    /// `after` (`None`: at the first). `None` for an unknown name.
    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, Bilingual>>;

    /// The `limit` episodes of a mined folder that are most similar to `episode`, of its L2, most similar first,
    /// without itself. `None` for an unknown name, an error text if descriptors cannot be computed.
    fn similar(
        &self,
        _name: &str,
        _episode: &EpisodeRecord,
        _limit: usize,
    ) -> Option<Result<Similar, Bilingual>> {
        None
    }

    /// The file of a camera frame, if it is on this machine.
    fn media(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf>;

    /// A camera frame that is in an object store.
    fn stored_image(
        &self,
        _drive: &DriveId,
        _frame: &MediaFrame,
    ) -> Result<Option<Box<dyn StoredImage>>, Bilingual> {
        Ok(None)
    }
}

/// First and last of the frame times of a drive.
pub fn span_of(times: &[Nanos]) -> Result<(Nanos, Nanos), Bilingual> {
    let ends = times.first().zip(times.last()).map(|(first, last)| (*first, *last));
    ends.ok_or_else(|| Bilingual::new("行程没有任何帧", "the drive has no frames"))
}

/// The same drives, for the label checks.
pub struct CheckedDrives(pub Arc<dyn Recordings>);

impl whyroad_label::check::Recordings for CheckedDrives {
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>> {
        self.0.recorded(clip_id)
    }

    fn until(&self, clip_id: &str, keyframe: Nanos) -> Option<Arc<Recorded>> {
        self.0.recorded_until(clip_id, keyframe)
    }
}
