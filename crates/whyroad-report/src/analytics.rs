//! One model of amount, quality and gaps of the data: from mining, the labeling service and releases. `whyroad report`,
//! the page of the service, the tables and the text all show this value.
//!
//! Nothing here opens a file or reads a clock: inputs are passed in ([`AnalyticsInputs`]). A number that no input gives
//! is `None`; it is never shown as zero. Classes that the drives cannot show are kept apart from classes without finds.

mod agreement;
mod contexts;
mod corrections;
mod decisions;
pub mod forecast;
mod input;
pub mod outlook;
pub mod page;
mod progress;
mod shortfalls;
mod stages;
mod tables;
pub(crate) mod text;
pub mod unseen;

pub use agreement::{AgreementRow, Measure};
pub use contexts::{ContextRow, Dimension};
pub use corrections::{Corrections, FieldCorrections, KeyframeShifts};
pub use decisions::{Channel, DecisionBasis, DecisionRow, Decisions};
pub use input::{
    AnalyticsInputs, DriveFacts, EpisodeTally, HourlyRate, MinedFacts, ReleaseFacts, SampleFacts,
};
pub use progress::{Cost, Finish, FinishBasis, PersonRow, Progress, WeekRow};
pub use shortfalls::{Shortfall, ShortfallStep};
pub use stages::{StageCounts, StageRow};
pub use tables::tables;
pub use text::render_text;

use serde::Serialize;
use unseen::Estimate;
use whyroad_framework::Framework;
use whyroad_label::facts::with_known_episodes;
use whyroad_model::{Nanos, ScenarioId};

/// Additional driving that outlooks assume, h.
pub const MORE_HOURS: f64 = 100.0;

/// All shown values.
#[derive(Clone, Debug, Serialize)]
pub struct Analytics {
    /// Version of the taxonomy whose classes these are.
    pub taxonomy_version: String,
    /// The moment that ages and forecasts count from; `None` without any entry of a history.
    pub as_of: Option<Nanos>,
    /// Shift of hours of the day from UTC, h.
    pub utc_offset_h: i8,
    /// Which inputs were given.
    pub given: Given,
    /// Every class, in tree order.
    pub stages: Vec<StageRow>,
    /// Decisions by leaf.
    pub decisions: Decisions,
    /// By place, hour, weather, source.
    pub contexts: Vec<ContextRow>,
    /// Changes to drafts; `None` without tasks.
    pub corrections: Option<Corrections>,
    /// Agreement of people who labeled the same episode; empty without overlaps.
    pub agreement: Vec<AgreementRow>,
    /// Throughput, finish, cost; `None` without tasks.
    pub progress: Option<Progress>,
    /// Unseen classes; `None` without mining.
    pub unseen: Option<Unseen>,
    /// Leaves with too few labels or without any find.
    pub shortfalls: Vec<Shortfall>,
}

/// Which inputs were given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Given {
    /// A mined folder.
    pub mined: bool,
    /// Tasks of the labeling service.
    pub tasks: bool,
    /// Releases.
    pub releases: bool,
}

/// Unseen classes.
#[derive(Clone, Debug, Serialize)]
pub struct Unseen {
    /// Hours that were searched.
    pub hours: f64,
    /// Drives that were searched.
    pub drives: usize,
    /// Leaves that these drives can show.
    pub observable: usize,
    /// Of these, leaves with at least one episode.
    pub found: usize,
    /// Probability that the next find (of a drive) is of a leaf without any so far.
    pub mass: Option<Estimate>,
    /// Leaves without a find so far that [`MORE_HOURS`] more would show; `None` where they are too far beyond what was
    /// searched.
    pub new_leaves: Option<Estimate>,
    /// Hours that have to be searched before `new_leaves` can be estimated.
    pub hours_needed: f64,
    /// Expected episodes in [`MORE_HOURS`] more, by observable leaf.
    pub leaves: Vec<LeafOutlook>,
}

/// Expected episodes of a leaf in [`MORE_HOURS`] more.
#[derive(Clone, Debug, Serialize)]
pub struct LeafOutlook {
    /// The leaf.
    pub scenario_id: ScenarioId,
    /// Primary episodes so far in the drives that were searched for it. A drive without the signals that decide its
    /// rule was not searched, also where an alternative of the rule found one.
    pub episodes: u64,
    /// Number of drives that were searched for it, as in the coverage.
    pub drives: usize,
    /// Their hours.
    pub hours: f64,
    /// Scatter between drives, 1 for Poisson.
    pub dispersion: f64,
    /// Expected primary episodes.
    pub coming: Option<Estimate>,
}

impl Analytics {
    /// Makes the model.
    pub fn new(framework: &Framework, inputs: &AnalyticsInputs<'_>) -> Self {
        let tasks = inputs.tasks.map(with_known_episodes);
        let inputs = &AnalyticsInputs { tasks: tasks.as_deref(), ..*inputs };
        let as_of = inputs.as_of.or_else(|| inputs.tasks.and_then(progress::last_entry));
        let unseen = inputs.mined.map(|m| unseen_of(framework, m));
        let stages = stages::rows(framework, inputs);
        let shortfalls = shortfalls::of(&stages, unseen.as_ref(), inputs);
        Self {
            taxonomy_version: framework.taxonomy.version.clone(),
            as_of,
            utc_offset_h: inputs.utc_offset_h,
            given: Given {
                mined: inputs.mined.is_some(),
                tasks: inputs.tasks.is_some(),
                releases: inputs.releases.is_some(),
            },
            decisions: decisions::of(framework, inputs),
            contexts: contexts::rows(inputs),
            corrections: inputs.tasks.map(corrections::of),
            agreement: inputs.tasks.map(agreement::rows).unwrap_or_default(),
            progress: inputs.tasks.map(|tasks| progress::of(tasks, &stages, inputs.rate, as_of)),
            stages,
            unseen,
            shortfalls,
        }
    }
}

fn unseen_of(framework: &Framework, mined: &MinedFacts) -> Unseen {
    let all = mined.drives.values().map(|d| d.seconds).sum::<f64>() / 3600.0;
    let rows = crate::coverage::rows(&framework.taxonomy, &mined.coverage);
    let observable: Vec<_> = rows.iter().filter(|r| r.drives_searched > 0 || r.episodes > 0).collect();
    let none = std::collections::BTreeMap::new();
    let found_in = |id: &ScenarioId| mined.episodes.by_class.get(id).unwrap_or(&none);
    let frequencies = unseen::frequencies(observable.iter().map(|r| found_in(&r.id).len() as u64));
    let found = observable.iter().filter(|r| !found_in(&r.id).is_empty()).count();
    let remaining = (observable.len() - found) as u64;
    let range = unseen::range(&frequencies);
    let leaves = observable.iter().map(|row| {
        let blind: std::collections::BTreeSet<_> = row.gaps.iter().flat_map(|g| &g.drives).collect();
        let own = found_in(&row.id);
        let drives: Vec<(f64, u64)> = mined
            .drives
            .iter()
            .filter(|(id, _)| !blind.contains(id))
            .map(|(id, d)| (d.seconds / 3600.0, own.get(id).map_or(0, |n| n.1)))
            .collect();
        let hours: f64 = drives.iter().map(|d| d.0).sum();
        let episodes = drives.iter().map(|d| d.1).sum();
        let dispersion = outlook::dispersion(&drives);
        LeafOutlook {
            scenario_id: row.id.clone(),
            episodes,
            drives: drives.len(),
            hours,
            dispersion,
            coming: outlook::coming(episodes, hours, MORE_HOURS, dispersion),
        }
    });
    Unseen {
        hours: all,
        drives: mined.drives.len(),
        observable: observable.len(),
        found,
        mass: unseen::unseen_mass(&frequencies),
        new_leaves: (all > 0.0)
            .then(|| unseen::new_classes(&frequencies, MORE_HOURS / all, remaining))
            .flatten(),
        hours_needed: MORE_HOURS / range,
        leaves: leaves.collect(),
    }
}

#[cfg(test)]
mod tests;
