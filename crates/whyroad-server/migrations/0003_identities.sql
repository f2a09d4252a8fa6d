-- Signing in at an OpenID provider. An account is linked to at most one person of each provider, a person to one account.
CREATE TABLE identities (
  id TEXT PRIMARY KEY, issuer TEXT NOT NULL, subject TEXT NOT NULL, user_id TEXT NOT NULL REFERENCES users (id),
  email TEXT, created BIGINT NOT NULL, seen BIGINT NOT NULL, UNIQUE (issuer, subject), UNIQUE (user_id, issuer));

-- Hashes of states that were used, until they would be too old anyway: none serves twice.
CREATE TABLE oidc_used (state TEXT PRIMARY KEY, expires BIGINT NOT NULL);

-- In small letters; only administrators write it, since a verified address of the provider's links to it.
ALTER TABLE users ADD COLUMN email TEXT;
CREATE UNIQUE INDEX users_email ON users (email);

-- 1 for a session that began at a provider.
ALTER TABLE sessions ADD COLUMN oidc BIGINT NOT NULL DEFAULT 0;
