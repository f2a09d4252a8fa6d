-- API tokens end, and say what they are for: `read` or `write`. Those from before end a year after they were made.
ALTER TABLE api_tokens ADD COLUMN expires BIGINT NOT NULL DEFAULT 0;
ALTER TABLE api_tokens ADD COLUMN scope TEXT NOT NULL DEFAULT 'write';
UPDATE api_tokens SET expires = created + 31536000000;
