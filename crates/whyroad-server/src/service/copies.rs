//! Episode ids of gold tasks, which are copies of episodes.

/// Separates the id of the episode from a random text in the id of a copy.
pub(super) const MARK: &str = "~";
/// SQL that leaves out gold tasks; `tasks` is the table.
pub const NOT_GOLD: &str = "NOT EXISTS (SELECT 1 FROM gold g WHERE g.task_id = tasks.id)";

/// The id of the episode of a task, whether the task is a copy or not.
pub fn episode_of(episode_id: &str) -> &str {
    episode_id.split_once(MARK).map_or(episode_id, |(episode, _)| episode)
}

/// The common prefix of the ids of all copies of an episode.
pub fn copies_of(episode: &str) -> String {
    format!("{episode}{MARK}")
}
