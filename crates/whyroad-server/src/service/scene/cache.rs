//! Cache of recently requested scenes.

use crate::domain::scene::SceneView;
use crate::domain::workflow::Stage;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// Number of cached scenes.
const KEPT: usize = 64;

/// Recently requested scenes, so that a reload does not derive all signals again.
#[derive(Debug, Default)]
pub struct SceneCache {
    scenes: Mutex<VecDeque<(SceneKey, Arc<SceneView>)>>,
}

/// The state on which a scene depends: the task, how much of it is shown, and the version of its drive on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SceneKey {
    pub(super) task: String,
    pub(super) stage: Stage,
    pub(super) hides_leaf: bool,
    pub(super) drive_version: String,
}

impl SceneCache {
    pub(super) fn get(&self, key: &SceneKey) -> Option<Arc<SceneView>> {
        let scenes = self.scenes.lock().ok()?;
        scenes.iter().find(|(k, _)| k == key).map(|(_, scene)| Arc::clone(scene))
    }

    pub(super) fn put(&self, key: SceneKey, scene: &Arc<SceneView>) {
        if let Ok(mut scenes) = self.scenes.lock() {
            scenes.push_front((key, Arc::clone(scene)));
            scenes.truncate(KEPT);
        }
    }
}
