-- The language that a task's label is to be written in; empty for any. The queue goes by it.
ALTER TABLE tasks ADD COLUMN lang TEXT NOT NULL DEFAULT '';
