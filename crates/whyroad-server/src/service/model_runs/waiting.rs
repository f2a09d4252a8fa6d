//! Cached numbers of tasks that wait for the language model.

use crate::domain::model::ModelRunKind;
use crate::sync::lock;
use std::collections::HashMap;
use std::sync::Mutex;

/// Number of tasks that waited for a run at the last count, by project and kind: time, ms since 1970, and number.
#[derive(Debug, Default)]
pub struct WaitingCounts(Mutex<HashMap<(String, ModelRunKind), (i64, i64)>>);

impl WaitingCounts {
    pub(super) fn get(&self, project: &str, kind: ModelRunKind) -> Option<(i64, i64)> {
        let all = lock(&self.0);
        all.get(&(project.to_owned(), kind)).copied()
    }

    pub(super) fn put(&self, project: &str, kind: ModelRunKind, counted: (i64, i64)) {
        lock(&self.0).insert((project.to_owned(), kind), counted);
    }
}
