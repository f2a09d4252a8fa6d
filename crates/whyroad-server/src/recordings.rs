//! What the service needs of the rest of the program: drives, signals, drafts, mined folders. Handed in by the caller,
//! so that this crate reads no lake and derives no signal.

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

/// Episodes that resemble one.
#[derive(Clone, Debug, Default)]
pub struct Similar {
    /// With their similarity, 0 to 1.
    pub nearest: Vec<(EpisodeRecord, f64)>,
    /// Episodes that were compared.
    pub compared: u64,
}

/// A camera image in an object store: one image, never a video.
pub trait StoredImage {
    /// Its name in the store; it ends as the image's format does.
    fn name(&self) -> &str;

    /// An address that opens this image alone, for this long.
    fn link(&self, lifetime: Duration) -> Result<String, Bilingual>;

    /// The image itself; `None` where it is gone.
    fn read(&self) -> Result<Option<Vec<u8>>, Bilingual>;
}

/// Where a camera image is.
pub enum CameraImage {
    /// A file on this machine.
    File(PathBuf),
    /// An object of an object store.
    Stored(Box<dyn StoredImage>),
}

/// Recorded drives and what is derived from them.
pub trait Recordings: Send + Sync {
    /// A drive; an error text when it is unavailable.
    fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, Bilingual>;

    /// Times of the first and last frame of a drive; an error text when it is unavailable or has no frame. What can
    /// say so without reading the drive does.
    fn span(&self, id: &DriveId) -> Result<(Nanos, Nanos), Bilingual> {
        span_of(&self.drive(id)?.times)
    }

    /// Changes when the drive on disk changes; what was made from an older version is then made again. Constant where
    /// drives do not change.
    fn version(&self, _: &DriveId) -> String {
        String::new()
    }

    /// Whether the recordings can be read at all; why not, otherwise.
    fn ready(&self) -> Result<(), Bilingual> {
        Ok(())
    }

    /// Signals of `drive`. The service hands in drives that were cut at the keyframe, so the result must depend on
    /// nothing but the drive that is given.
    fn signals(&self, drive: &Drive) -> SignalTable;

    /// The same of a whole drive, as this gave it out, with its future: never for Stage I. What is stored need not be
    /// derived.
    fn whole_signals(&self, drive: &Drive) -> SignalTable {
        self.signals(drive)
    }

    /// `drive` with what its log did not measure (velocities) estimated, from nothing but the drive that is given.
    fn estimated(&self, drive: &Arc<Drive>) -> Arc<Drive> {
        Arc::clone(drive)
    }

    /// What the signal called `name` is; `None` for a name that no signal has.
    fn about(&self, name: &str) -> Option<SignalAbout>;

    /// A label skeleton for an episode of `drive`. Where the components of Stage I are given, its trace names no other
    /// objects than theirs.
    fn draft(
        &self,
        drive: &Drive,
        signals: &SignalTable,
        episode: &EpisodeRecord,
        lang: Lang,
        listed: Option<&[CriticalComponent]>,
    ) -> CocLabel;

    /// Only the critical components of [`Recordings::draft`], for a drive that was cut at the keyframe; the result must
    /// depend on nothing but what is given, as that of [`Recordings::signals`].
    fn components(&self, drive: &Drive, episode: &EpisodeRecord, lang: Lang) -> Vec<CriticalComponent> {
        self.draft(drive, &self.signals(drive), episode, lang, None).critical_components
    }

    /// The whole drive of a clip with its signals and what the rules find in it, for checks of labels whose Stage I is
    /// locked; `None` where it is not at hand. Never for anybody who must not see the future.
    fn recorded(&self, _clip_id: &str) -> Option<Arc<Recorded>> {
        None
    }

    /// Names of the folders of mining results that tasks can be made from.
    fn mined(&self) -> Vec<String>;

    /// Number of episodes of a mined folder that answer `filter`; `None` for an unknown name, an error in words when
    /// the folder cannot be read. Without a filter the folder's size makes no difference.
    fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, Bilingual>>;

    /// At most `limit` episodes of a mined folder that answer `filter`, in the order of drive and keyframe, from
    /// `after` on (`None`: from the first). `None` for an unknown name.
    fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, Bilingual>>;

    /// The `limit` episodes of a mined folder that resemble `episode` most, of its L2, most similar first; itself left
    /// out. `None` for an unknown name, an error in words where descriptors cannot be made.
    fn similar(
        &self,
        _name: &str,
        _episode: &EpisodeRecord,
        _limit: usize,
    ) -> Option<Result<Similar, Bilingual>> {
        None
    }

    /// The file of a camera frame, where it is on this machine.
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
    ends.ok_or_else(|| Bilingual::new("行程没有任何帧", "the drive has no frame"))
}

/// The same drives, for the label checks.
pub struct CheckedDrives(pub Arc<dyn Recordings>);

impl whyroad_label::check::Recordings for CheckedDrives {
    fn of_clip(&self, clip_id: &str) -> Option<Arc<Recorded>> {
        self.0.recorded(clip_id)
    }
}
