-- Runs of a language model: drafts of tasks, or judgements of labels. `alive` is renewed by the service that works on
-- it (`worker`); another one goes on when it is old. `spent` and `note` are JSON.
CREATE TABLE model_runs (
  id TEXT PRIMARY KEY, project_id TEXT NOT NULL REFERENCES projects (id), kind TEXT NOT NULL, state TEXT NOT NULL,
  model TEXT NOT NULL, actor TEXT NOT NULL, started BIGINT NOT NULL, ended BIGINT, spent TEXT NOT NULL, note TEXT,
  worker TEXT, alive BIGINT NOT NULL);
CREATE INDEX model_runs_project ON model_runs (project_id, started, id);
CREATE INDEX model_runs_open ON model_runs (started, id) WHERE ended IS NULL;

-- Tasks of a run: `waiting`, `done`, `failed` (with the reason as JSON), `left_out`.
CREATE TABLE model_run_tasks (
  run_id TEXT NOT NULL REFERENCES model_runs (id), task_id TEXT NOT NULL REFERENCES tasks (id), state TEXT NOT NULL,
  note TEXT, PRIMARY KEY (run_id, task_id));
CREATE INDEX model_run_tasks_task ON model_run_tasks (task_id);

-- True/false questions about a label (`version` of the task) with answers: of the model (`judge` is empty) or a user.
CREATE TABLE judgements (
  task_id TEXT NOT NULL REFERENCES tasks (id), judge TEXT NOT NULL, project_id TEXT NOT NULL REFERENCES projects (id),
  version BIGINT NOT NULL, answers TEXT NOT NULL, passed BIGINT, for_people BIGINT NOT NULL, at BIGINT NOT NULL,
  PRIMARY KEY (task_id, judge));
CREATE INDEX judgements_project ON judgements (project_id, judge, for_people);
