//! Interface to reports that the service shows: the caller provides them, so this crate knows no mined folder, no
//! release and no chart.

use crate::domain::project::Project;
use whyroad_label::facts::TaskFacts;
use whyroad_model::{Bilingual, Nanos};

/// Generates reports of a project.
pub trait Reports: Send + Sync {
    /// The analytics of a project as an HTML fragment in both languages, from its tasks; `now` is the reference time of
    /// ages, `utc_offset_h` the UTC offset of the reader's clock. Returns an error text when an input cannot be read.
    fn analytics(
        &self,
        project: &Project,
        tasks: &[TaskFacts],
        now: Nanos,
        utc_offset_h: i8,
    ) -> Result<String, Bilingual>;
}
