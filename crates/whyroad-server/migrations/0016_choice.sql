-- 1: all labels of this task's overlap group are handed in, skipped or rejected, so that a lead can choose one.
ALTER TABLE tasks ADD COLUMN complete BIGINT NOT NULL DEFAULT 0;
UPDATE tasks SET complete = 1 WHERE overlap_count > 1 AND NOT EXISTS (
  SELECT 1 FROM tasks o WHERE o.project_id = tasks.project_id AND o.episode_id = tasks.episode_id
    AND (o.state IN ('open', 'stage1', 'stage1_locked', 'stage2') OR o.adjudication = 'chosen'));
CREATE INDEX tasks_to_choose ON tasks (project_id, episode_id, state, adjudication, complete, id)
    WHERE complete = 1 AND adjudication IS NULL;
