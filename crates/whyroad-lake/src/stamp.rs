//! Checks whether a drive on disk is still the one that was read, without reading it again.

use crate::LakeError;
use crate::lake::{Lake, MANIFEST};
use crate::packs::Place;
use std::fs;
use std::time::SystemTime;
use whyroad_model::DriveId;

/// What differs when a drive was written again or its images were changed: both replace `drive.json`. Taken *before*
/// reading the drive, so it is never newer than the data read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
    /// Hash of what a packed drive states about itself; empty for one with a folder.
    packed: String,
}

impl Lake {
    /// The stamp of a drive as it is now.
    pub fn stamp(&self, id: &DriveId) -> Result<Stamp, LakeError> {
        if let Some(mirror) = &self.mirror {
            // While the store cannot be reached, the drives are taken as unchanged.
            let _ = mirror.refresh();
        }
        self.at_place(id, |place| match place {
            Place::Loose(dir) => {
                let path = dir.join(MANIFEST);
                match fs::metadata(&path) {
                    Ok(data) => Ok(Stamp {
                        modified: data.modified().ok(),
                        length: data.len(),
                        packed: String::new(),
                    }),
                    Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                        Err(LakeError::DriveMissing(id.clone()))
                    }
                    Err(e) => Err(LakeError::io(&path)(e)),
                }
            }
            // Packed again, it is the same drive.
            Place::Packed(pack, row) => {
                let text = serde_json::to_vec(&pack.manifests[*row])
                    .map_err(|e| LakeError::broken(&place.path(MANIFEST), e))?;
                let packed = blake3::hash(&text).to_hex().to_string();
                Ok(Stamp { modified: None, length: text.len() as u64, packed })
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_that_is_not_there_has_none_and_no_id_leads_out_of_the_lake() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
        fs::write(dir.path().join(MANIFEST), "{}").unwrap();
        for id in ["d1", "../..", "..", "", "a/b"] {
            assert!(matches!(lake.stamp(&id.into()), Err(LakeError::DriveMissing(_))), "{id}");
        }
    }
}
