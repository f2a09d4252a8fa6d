-- Episodes of which the retention period has removed the tasks: they get no second task.
CREATE TABLE finished_episodes (
  project_id TEXT NOT NULL REFERENCES projects (id), episode_id TEXT NOT NULL, drive_id TEXT NOT NULL,
  PRIMARY KEY (project_id, episode_id));
CREATE INDEX finished_episodes_drive ON finished_episodes (drive_id);
