-- A service that starts compares what was handed in before; ordinary tasks are not in this index.
CREATE INDEX tasks_not_compared ON tasks (project_id, episode_id, state, overlap_count, disagrees)
    WHERE overlap_count > 1 AND disagrees IS NULL;
