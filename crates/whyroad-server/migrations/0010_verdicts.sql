-- What people said of mined episodes without labelling them; one verdict per episode and person. Moments of a drive are
-- nanoseconds, the score is a text: columns hold whole numbers and texts only.
CREATE TABLE verdicts (
  id TEXT PRIMARY KEY, project_id TEXT NOT NULL REFERENCES projects (id), mined TEXT NOT NULL, episode_id TEXT NOT NULL,
  drive_id TEXT NOT NULL, scenario_id TEXT NOT NULL, target_id TEXT, start_ns BIGINT NOT NULL, keyframe_ns BIGINT NOT NULL,
  end_ns BIGINT NOT NULL, score TEXT NOT NULL, verdict TEXT NOT NULL, leaf TEXT, moved_ns BIGINT, note TEXT,
  actor TEXT NOT NULL, at BIGINT NOT NULL, UNIQUE (project_id, episode_id, actor));
CREATE INDEX verdicts_export ON verdicts (project_id, drive_id, keyframe_ns, id);
