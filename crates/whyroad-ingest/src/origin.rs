//! Which source a drive of a lake came from, so that two sources with the same file name never replace each other. The
//! lake keeps a hash of the source's path beside the drive, not the path: lakes are shared with others.

use crate::source::drive_id;
use std::path::Path;
use whyroad_lake::Lake;
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId};

/// Codes of this module.
pub(crate) const CODES: &[&str] = &["ingest.drive_id.taken"];
const NOTE: &str = "source.hash";

/// A source: its file or folder, and the part of it.
pub(crate) struct Origin(String);

impl Origin {
    /// `label` is the source as its report names it: the path, then the part if there are several.
    pub fn new(path: &Path, label: &str) -> Self {
        let absolute = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let part = label.strip_prefix(&path.display().to_string()).unwrap_or_default();
        let hash = blake3::hash(format!("{}{part}", absolute.display()).as_bytes());
        Self(hash.to_hex().chars().take(16).collect())
    }

    /// True when the lake's drive of this id has other content and came from another source.
    fn is_taken(&self, id: &DriveId, content_hash: &str, lake: &Lake) -> bool {
        let other_source = lake.note(id, NOTE).is_some_and(|note| note != self.0.as_bytes());
        other_source && lake.content_hash(id).is_some_and(|held| held != content_hash)
    }

    /// Why a drive cannot have the id that the user states: it belongs to another source.
    pub fn refuse_id(&self, drive: &Drive, lake: &Lake) -> Option<Diagnostic> {
        let id = &drive.meta.drive_id;
        let message = Bilingual::new(
            format!("数据湖中已有来自另一来源的行程 {id}；此行程未写入"),
            format!("the lake has a drive {id} from another source; this one is not stored"),
        );
        let hint = Bilingual::new(
            format!("换一个 --drive-id；要替换原有行程，请先运行 `whyroad lake delete {id} --lake DIR`"),
            format!(
                "choose another --drive-id; to replace the drive, run `whyroad lake delete {id} --lake DIR` first"
            ),
        );
        let is_taken = self.is_taken(id, &drive.meta.content_hash, lake);
        is_taken.then(|| Diagnostic::error("ingest.drive_id.taken", message).with_hint(hint))
    }

    /// Gives the drive another id when its own belongs to another source; the id depends on the source alone, so that
    /// ingesting it again finds the drive.
    pub fn claim_id(&self, drive: &mut Drive, lake: &Lake) -> Option<Diagnostic> {
        let id = drive.meta.drive_id.clone();
        if !self.is_taken(&id, &drive.meta.content_hash, lake) {
            return None;
        }
        let new =
            drive_id(&format!("{}-{}", id.as_str().chars().take(110).collect::<String>(), &self.0[..8]));
        drive.meta.drive_id = new.clone();
        let message = Bilingual::new(
            format!("数据湖中已有来自另一来源的行程 {id}；此行程记为 {new}"),
            format!("the lake has a drive {id} from another source; this one is stored as {new}"),
        );
        let hint = Bilingual::new(
            "若要自定编号，请用 --drive-id；若来源只是被移动，请先删除旧行程",
            "set an id with --drive-id; if the source was only moved, delete the old drive first",
        );
        Some(Diagnostic::warning("ingest.drive_id.taken", message).with_hint(hint))
    }

    /// The note beside a drive that it came from this source: its name and content.
    pub fn note(&self) -> (&'static str, &[u8]) {
        (NOTE, self.0.as_bytes())
    }

    /// Adds the note to a drive that the lake holds without one: a lake written by an older version.
    pub fn complete(&self, id: &DriveId, lake: &Lake) {
        // Without the note, the next ingest assumes that the drive has the same source.
        if lake.note(id, NOTE).is_none() {
            let _ = lake.write_note(id, NOTE, self.0.as_bytes());
        }
    }
}
