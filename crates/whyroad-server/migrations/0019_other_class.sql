-- The class that fits instead of the task's, as its annotator says (empty: one that they do not know); the task that
-- replaces it, and the one that it replaces; codes of the findings with which it was submitted, each between spaces.
ALTER TABLE tasks ADD COLUMN right_class TEXT;
ALTER TABLE tasks ADD COLUMN replaced_by TEXT;
ALTER TABLE tasks ADD COLUMN replaces TEXT;
ALTER TABLE tasks ADD COLUMN findings TEXT NOT NULL DEFAULT '';
