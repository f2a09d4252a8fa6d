//! The analytics as the labeling service shows them: the tasks come from its store, mining from the folders that
//! `whyroad serve --mined` names.

use super::{largest, mined};
use crate::cmd::dataset::query::Queries;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::SystemTime;
use whyroad_framework::Framework;
use whyroad_label::facts::TaskFacts;
use whyroad_lake::mined::MinedFile;
use whyroad_lake::{Lake, MinedFolder};
use whyroad_model::{Bilingual, Nanos};
use whyroad_report::analytics::{Analytics, AnalyticsInputs, HourlyRate, MinedFacts, page};
use whyroad_server::domain::project::Project;
use whyroad_server::reports::Reports;

/// A mined folder, the time of its last change, and the data read from it.
type Held = (PathBuf, Option<SystemTime>, Arc<MinedFacts>);

/// Makes the page.
pub(crate) struct ServiceReports {
    lake: Lake,
    framework: &'static Framework,
    dirs: Vec<PathBuf>,
    queries: Queries,
    /// The data last read from a mined folder, with the time at which its coverage was written.
    held: Mutex<Option<Held>>,
}

impl ServiceReports {
    pub(crate) fn new(lake: Lake, framework: &'static Framework, dirs: Vec<PathBuf>) -> Self {
        Self { lake, framework, dirs, queries: Queries::new(framework), held: Mutex::default() }
    }

    fn mined(&self, folder: &MinedFolder) -> Result<Arc<MinedFacts>, Bilingual> {
        let path = folder.path(MinedFile::Coverage);
        let written = std::fs::metadata(&path).and_then(|m| m.modified()).ok();
        let mut held = self.held.lock().map_err(|e| Bilingual::same(e.to_string()))?;
        if let Some((of, at, facts)) = &*held
            && (of, at) == (&path, &written)
            && written.is_some()
        {
            return Ok(Arc::clone(facts));
        }
        // Drives without a readable context have no weather: the page shows "not stated".
        let (facts, _) = mined(folder, &self.lake).map_err(|d| d.message)?;
        let facts = Arc::new(facts);
        *held = Some((path, written, Arc::clone(&facts)));
        Ok(facts)
    }
}

impl Reports for ServiceReports {
    fn analytics(
        &self,
        project: &Project,
        tasks: &[TaskFacts],
        now: Nanos,
        utc_offset_h: i8,
    ) -> Result<String, Bilingual> {
        let mined = largest(&self.dirs).map(|folder| self.mined(&folder)).transpose()?;
        let wanted = project.quota.iter().filter_map(|(leaf, n)| Some((leaf.parse().ok()?, u64::from(*n))));
        let rate = project
            .settings
            .hourly_rate
            .map(|amount| HourlyRate { amount, currency: project.settings.currency.clone() });
        let inputs = AnalyticsInputs {
            mined: mined.as_deref(),
            tasks: Some(tasks),
            releases: None,
            wanted: &wanted.collect(),
            rate: rate.as_ref(),
            as_of: Some(now),
            utc_offset_h,
            query: &|class, n| self.queries.query(class, n),
        };
        Ok(page::fragment(&Analytics::new(self.framework, &inputs)).into_string())
    }
}
