//! How the copies that gold tasks are name the episode that they are about.

/// In the episode id of a copy between that of its episode and a random text.
pub(super) const MARK: &str = "~";
/// SQL that leaves out gold tasks; `tasks` is the table.
pub const NOT_GOLD: &str = "NOT EXISTS (SELECT 1 FROM gold g WHERE g.task_id = tasks.id)";

/// The id of the episode that a task is about, whether it is a copy or not.
pub fn episode_of(episode_id: &str) -> &str {
    episode_id.split_once(MARK).map_or(episode_id, |(episode, _)| episode)
}

/// What the ids of all copies of an episode begin with.
pub fn copies_of(episode: &str) -> String {
    format!("{episode}{MARK}")
}
