-- 1: the suggested draft comes from an import; Stage I does not show its components, whose words may tell the future.
ALTER TABLE tasks ADD COLUMN imported BIGINT NOT NULL DEFAULT 0;
