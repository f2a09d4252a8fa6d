-- Comments that ask the lead something; lists and cards show which tasks have one.
ALTER TABLE comments ADD COLUMN to_lead BIGINT NOT NULL DEFAULT 0;
CREATE INDEX comments_to_lead ON comments (task_id) WHERE to_lead = 1 AND resolved = 0;

-- A small picture of the keyframe for lists, as SVG; apart from the tasks, whose rows are written at each save.
CREATE TABLE thumbnails (task_id TEXT PRIMARY KEY REFERENCES tasks (id), svg TEXT NOT NULL);
CREATE INDEX tasks_scenario ON tasks (project_id, scenario_id, id);

-- 1: the draft is still to be made; 2: making it failed.
ALTER TABLE tasks ADD COLUMN pending BIGINT NOT NULL DEFAULT 0;
CREATE INDEX tasks_pending ON tasks (pending, priority DESC, drive_id, keyframe_ns, id) WHERE pending <> 0;
