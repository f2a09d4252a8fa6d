-- What dashboards read, without the long rows of tasks and histories. Actions are counted as they happen.
CREATE TABLE activity (
  project_id TEXT NOT NULL REFERENCES projects (id), day BIGINT NOT NULL, actor TEXT NOT NULL, action TEXT NOT NULL,
  n BIGINT NOT NULL, PRIMARY KEY (project_id, day, actor, action));
INSERT INTO activity (project_id, day, actor, action, n)
  SELECT t.project_id, h.at / 86400000, coalesce(h.actor, ''), h.action, count(*)
  FROM history h JOIN tasks t ON t.id = h.task_id WHERE h.action IN ('submit', 'accept', 'send_back')
  GROUP BY t.project_id, h.at / 86400000, coalesce(h.actor, ''), h.action;
CREATE INDEX tasks_coverage ON tasks (project_id, scenario_id, state, episode_id);
CREATE INDEX tasks_ageing ON tasks (project_id, updated, id, state, scenario_id, holder, assigned, author);
CREATE INDEX tasks_overlap ON tasks (project_id, id, author, episode_id) WHERE overlap_count > 1;
CREATE INDEX history_submit ON history (task_id, seq) WHERE action = 'submit';
CREATE INDEX history_audit ON history (task_id, at, seq, action) WHERE from_state = 'in_audit';
