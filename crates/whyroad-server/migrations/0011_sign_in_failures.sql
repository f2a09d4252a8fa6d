-- Failed sign-ins, counted by all services on one store: by the hash of a name or an address. Rows of the last minutes,
-- at most some ten thousand.
CREATE TABLE sign_in_failures (who TEXT PRIMARY KEY, failures BIGINT NOT NULL, last BIGINT NOT NULL);
