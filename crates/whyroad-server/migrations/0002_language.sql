-- The language that a task's label is to be written in; empty for any. The queue goes by it.
ALTER TABLE tasks ADD COLUMN lang TEXT NOT NULL DEFAULT '';

-- The queue and the lists go along an index in their own order and stop at the first that fit: a row is long (drafts), and
-- there may be a hundred thousand of them.
DROP INDEX tasks_queue;
CREATE INDEX tasks_queue ON tasks (project_id, state, priority DESC, created, overlap_index, keyframe_ns, id,
  scenario_id, assigned, lang, author, checker, holder, lease_until, adjudication);
CREATE INDEX tasks_list ON tasks (project_id, priority DESC, created, id, state, scenario_id, holder, author, assigned);
DROP INDEX tasks_holder;
CREATE INDEX tasks_holder ON tasks (project_id, holder);
CREATE INDEX tasks_author ON tasks (project_id, author);
