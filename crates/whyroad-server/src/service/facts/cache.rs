//! Cache of facts about tasks between requests.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex};
use whyroad_label::facts::TaskFacts;

/// Maximum number of cached facts, over all projects; half a kilobyte each. A project with more is read again each
/// time.
const MOST_KEPT: usize = 200_000;

/// The state on which a task's facts depend: the last entry of its history and the outcome of adjudication.
pub(super) type Version = (i64, Option<String>);

/// Facts from an earlier report: only tasks that have changed since are read again.
#[derive(Default)]
pub struct FactsCache {
    /// The most recently used project is the last one.
    projects: Mutex<Vec<(String, Arc<Kept>)>>,
}

/// The facts of a project, and the names of people in them.
#[derive(Default)]
pub(super) struct Kept {
    pub names: HashMap<String, String>,
    pub tasks: BTreeMap<String, (Version, TaskFacts)>,
}

impl FactsCache {
    pub(super) fn get(&self, project: &str) -> Option<Arc<Kept>> {
        let projects = self.projects.lock().ok()?;
        projects.iter().find(|(id, _)| id == project).map(|(_, kept)| Arc::clone(kept))
    }

    pub(super) fn put(&self, project: &str, kept: Arc<Kept>) {
        let Ok(mut projects) = self.projects.lock() else { return };
        projects.retain(|(id, _)| id != project);
        projects.push((project.to_owned(), kept));
        while projects.iter().map(|(_, k)| k.tasks.len()).sum::<usize>() > MOST_KEPT {
            projects.remove(0);
        }
    }

    /// Number of cached tasks.
    pub fn len(&self) -> usize {
        self.projects.lock().map_or(0, |p| p.iter().map(|(_, k)| k.tasks.len()).sum())
    }

    /// True when nothing is cached.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
