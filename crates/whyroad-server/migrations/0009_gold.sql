-- Gold tasks: copies of an accepted episode whose label is known, each made for one annotator. To everybody but leads
-- they are tasks like any other.
CREATE TABLE gold (
  task_id TEXT PRIMARY KEY REFERENCES tasks (id), project_id TEXT NOT NULL REFERENCES projects (id),
  user_id TEXT NOT NULL REFERENCES users (id), source_task TEXT NOT NULL, answer TEXT NOT NULL, created BIGINT NOT NULL);
CREATE INDEX gold_project ON gold (project_id, user_id);
