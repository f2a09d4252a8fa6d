//! Reports that the service shows and does not make: handed in by the caller, so that this crate knows no mined folder,
//! no release and no chart.

use crate::domain::project::Project;
use whyroad_label::facts::TaskFacts;
use whyroad_model::{Bilingual, Nanos};

/// Makes reports of a project.
pub trait Reports: Send + Sync {
    /// The analytics of a project as a piece of a page (HTML) in both languages, from its tasks; `now` is the
    /// moment that ages count from, `utc_offset_h` the shift of the reader's clock. An error in words when an
    /// input cannot be read.
    fn analytics(
        &self,
        project: &Project,
        tasks: &[TaskFacts],
        now: Nanos,
        utc_offset_h: i8,
    ) -> Result<String, Bilingual>;
}
