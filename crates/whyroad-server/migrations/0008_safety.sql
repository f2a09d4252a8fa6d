-- Answers of the safety filter, for counting: the label has the same. `reasons` is a sorted JSON list.
CREATE TABLE safety (
  task_id TEXT PRIMARY KEY REFERENCES tasks (id), project_id TEXT NOT NULL REFERENCES projects (id),
  answer TEXT NOT NULL, reasons TEXT NOT NULL, note TEXT, actor TEXT NOT NULL, at BIGINT NOT NULL);
CREATE INDEX safety_count ON safety (project_id, answer, reasons);

-- L2 classes of which Stage I shows no leaf, as a JSON list: from the project's settings and the framework.
ALTER TABLE projects ADD COLUMN veiled TEXT NOT NULL DEFAULT '[]';
