//! Ids of episodes that come from another one: of gold tasks, which are copies of episodes, and of tasks of another
//! class than the one that was mined.

/// Separates the id of the episode from a random text in the id of a copy.
pub(super) const MARK: &str = "~";
/// SQL that leaves out gold tasks; `tasks` is the table.
pub const NOT_GOLD: &str = "NOT EXISTS (SELECT 1 FROM gold g WHERE g.task_id = tasks.id)";

/// The id of the episode of a task, whether the task is a copy or not.
pub fn episode_of(episode_id: &str) -> &str {
    episode_id.split_once(MARK).map_or(episode_id, |(episode, _)| episode)
}

/// Separates the id of the episode from the class in the id of a task of another class.
const AS: &str = "^";

/// The id of the episode `episode_id` as one of class `class`.
pub fn as_class(episode_id: &str, class: &str) -> String {
    format!("{}{AS}{class}", mined_of(episode_id))
}

/// The id of the mined episode of a task, whether the task is a copy, of another class, or neither.
pub fn mined_of(episode_id: &str) -> &str {
    let episode = episode_of(episode_id);
    episode.split_once(AS).map_or(episode, |(mined, _)| mined)
}

/// The common prefixes of the ids that come from a mined episode; both have the same length.
pub fn from_mined(mined: &str) -> [String; 2] {
    [copies_of(mined), format!("{mined}{AS}")]
}

/// The common prefix of the ids of all copies of an episode.
pub fn copies_of(episode: &str) -> String {
    format!("{episode}{MARK}")
}
