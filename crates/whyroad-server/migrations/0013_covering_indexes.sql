-- Counts of pending drafts by project read the index only.
DROP INDEX tasks_pending;
CREATE INDEX tasks_pending ON tasks (pending, priority DESC, drive_id, keyframe_ns, id, project_id) WHERE pending <> 0;

-- So does coverage, which leaves out gold tasks by their id.
DROP INDEX tasks_coverage;
CREATE INDEX tasks_coverage ON tasks (project_id, scenario_id, state, episode_id, id);
