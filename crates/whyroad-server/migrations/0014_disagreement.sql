-- 1: the labels of this task's overlap group, as handed in, disagree about the decision. Unset until it was compared.
ALTER TABLE tasks ADD COLUMN disagrees BIGINT;
CREATE INDEX tasks_disagreeing ON tasks (project_id, adjudication, id) WHERE disagrees = 1;

-- When a message was last delivered, ms since 1970; unset when none was. 0: before this was kept.
ALTER TABLE webhooks ADD COLUMN delivered BIGINT;
UPDATE webhooks SET delivered = 0;
