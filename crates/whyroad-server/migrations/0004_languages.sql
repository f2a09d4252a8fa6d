-- The languages in which a member labels, as a JSON list: the queue gives tasks of these. Empty for that of their page.
ALTER TABLE members ADD COLUMN languages TEXT NOT NULL DEFAULT '[]';
