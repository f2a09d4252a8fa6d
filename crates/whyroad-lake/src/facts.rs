//! What is known about a drive beside its log: session, vehicle, position, place, license, stated later and kept when
//! the drive is ingested again.

use crate::lake::{Lake, MANIFEST, write_json};
use crate::tables::clips;
use crate::{LakeError, file, packs};
use std::fs;
use whyroad_model::DriveId;
use whyroad_model::scene::{DriveMeta, GeoPosition};

/// Facts about a drive; `None` means not stated and changes nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveFacts {
    /// Recording session.
    pub session: Option<String>,
    /// Vehicle.
    pub vehicle: Option<String>,
    /// Position of the world frame's origin on Earth.
    pub position: Option<GeoPosition>,
    /// City or road network.
    pub place: Option<String>,
    /// License of the data.
    pub licence: Option<String>,
}

impl DriveFacts {
    /// Facts that survive when a drive is replaced by one whose log does not have them.
    pub(crate) fn of(meta: &DriveMeta) -> Self {
        Self {
            session: meta.session.clone(),
            vehicle: meta.vehicle.clone(),
            position: meta.position,
            place: None,
            licence: None,
        }
    }

    /// Writes the known facts into `meta`.
    pub(crate) fn state(self, meta: &mut DriveMeta) {
        meta.session = self.session.or(meta.session.take());
        meta.vehicle = self.vehicle.or(meta.vehicle.take());
        meta.position = self.position.or(meta.position);
        meta.place = self.place.or(meta.place.take());
        meta.licence = self.licence.or(meta.licence.take());
    }
}

impl Lake {
    /// States facts about a drive that is in the lake; true when one of them was new. `drive.json` and the clips'
    /// table change, nothing else, so that signals and episodes stay valid.
    pub fn state_facts(&self, id: &DriveId, facts: DriveFacts) -> Result<bool, LakeError> {
        let mut manifest = self.manifest(id)?;
        let before = manifest.meta.clone();
        facts.state(&mut manifest.meta);
        if manifest.meta == before {
            return Ok(false);
        }
        self.unpack(id)?;
        let outline = self.outline(id)?;
        let mut listed = outline.clips;
        for clip in &mut listed {
            clip.place.clone_from(&manifest.meta.place);
            clip.licence.clone_from(&manifest.meta.licence);
        }
        let put = |name: &str, aside: &std::path::Path| {
            let target = self.drive_dir(id).join(name);
            fs::rename(aside, &target).map_err(LakeError::io(&target))
        };
        let table = self.aside(id, "clips.parquet")?;
        file::write_table(&table, clips::to_table(&listed), clips::ROW_ORDER)?;
        let json = self.aside(id, MANIFEST)?;
        write_json(&json, &manifest)?;
        let _lock = packs::changing(self.dir())?;
        put("clips.parquet", &table)?;
        put(MANIFEST, &json)?;
        Ok(true)
    }
}
