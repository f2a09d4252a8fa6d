-- The tables of the labelling service, for SQLite and PostgreSQL alike: BIGINT and TEXT only. Moments of the service are
-- milliseconds since 1970, moments of a drive nanoseconds. Flags are 0 and 1. JSON is TEXT.

CREATE TABLE settings (name TEXT PRIMARY KEY, value TEXT NOT NULL);

CREATE TABLE users (
  id TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, display TEXT NOT NULL, admin BIGINT NOT NULL, lang TEXT NOT NULL,
  password_hash TEXT NOT NULL, disabled BIGINT NOT NULL, created BIGINT NOT NULL);

-- Only hashes: who reads the store cannot sign in with what is in it.
CREATE TABLE sessions (hash TEXT PRIMARY KEY, user_id TEXT NOT NULL REFERENCES users (id), expires BIGINT NOT NULL);
CREATE TABLE api_tokens (
  id TEXT PRIMARY KEY, hash TEXT NOT NULL UNIQUE, user_id TEXT NOT NULL REFERENCES users (id), name TEXT NOT NULL,
  created BIGINT NOT NULL);

CREATE TABLE projects (
  id TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, guide TEXT NOT NULL, quota TEXT NOT NULL, settings TEXT NOT NULL,
  created BIGINT NOT NULL);
CREATE TABLE members (
  project_id TEXT NOT NULL REFERENCES projects (id), user_id TEXT NOT NULL REFERENCES users (id),
  roles TEXT NOT NULL, skills TEXT NOT NULL, PRIMARY KEY (project_id, user_id));

CREATE TABLE tasks (
  id TEXT PRIMARY KEY, project_id TEXT NOT NULL REFERENCES projects (id),
  episode_id TEXT NOT NULL, overlap_index BIGINT NOT NULL, overlap_count BIGINT NOT NULL,
  drive_id TEXT NOT NULL, clip_id TEXT NOT NULL, scenario_id TEXT NOT NULL,
  keyframe_ns BIGINT NOT NULL, from_ns BIGINT NOT NULL, to_ns BIGINT NOT NULL,
  episode TEXT NOT NULL, initial TEXT NOT NULL, draft TEXT NOT NULL, version BIGINT NOT NULL,
  priority BIGINT NOT NULL, state TEXT NOT NULL, authors TEXT NOT NULL, author TEXT, checker TEXT, auditor TEXT,
  checked BIGINT NOT NULL, audited BIGINT NOT NULL, adjudication TEXT,
  assigned TEXT, holder TEXT, fence BIGINT NOT NULL, lease_until BIGINT,
  seq BIGINT NOT NULL, created BIGINT NOT NULL, updated BIGINT NOT NULL,
  UNIQUE (project_id, episode_id, overlap_index));
CREATE INDEX tasks_queue ON tasks (project_id, state, priority, created);
CREATE INDEX tasks_holder ON tasks (holder);
CREATE INDEX tasks_drive ON tasks (drive_id);

-- Append-only: nothing here is ever changed.
CREATE TABLE history (
  task_id TEXT NOT NULL REFERENCES tasks (id), seq BIGINT NOT NULL, at BIGINT NOT NULL, actor TEXT, action TEXT NOT NULL,
  from_state TEXT, to_state TEXT, changes TEXT, snapshot TEXT, note TEXT, version BIGINT NOT NULL,
  PRIMARY KEY (task_id, seq));
CREATE INDEX history_version ON history (task_id, version);
CREATE INDEX history_at ON history (at);

CREATE TABLE comments (
  id TEXT PRIMARY KEY, task_id TEXT NOT NULL REFERENCES tasks (id), path TEXT NOT NULL, author TEXT NOT NULL,
  body TEXT NOT NULL, at BIGINT NOT NULL, resolved BIGINT NOT NULL);
CREATE INDEX comments_task ON comments (task_id, at);

-- Who was shown which part of a drive beyond a keyframe, so that nobody does Stage I of what they have seen.
CREATE TABLE seen (
  user_id TEXT NOT NULL, task_id TEXT NOT NULL, drive_id TEXT NOT NULL, from_ns BIGINT NOT NULL, to_ns BIGINT NOT NULL,
  PRIMARY KEY (user_id, task_id));
CREATE INDEX seen_drive ON seen (drive_id, user_id);

CREATE TABLE webhooks (
  id TEXT PRIMARY KEY, project_id TEXT NOT NULL REFERENCES projects (id), url TEXT NOT NULL, events TEXT NOT NULL,
  secret TEXT NOT NULL, last_error TEXT, created BIGINT NOT NULL);
CREATE TABLE outbox (
  id TEXT PRIMARY KEY, webhook_id TEXT NOT NULL REFERENCES webhooks (id), body TEXT NOT NULL, tries BIGINT NOT NULL,
  due BIGINT NOT NULL, created BIGINT NOT NULL);
CREATE INDEX outbox_due ON outbox (due);
