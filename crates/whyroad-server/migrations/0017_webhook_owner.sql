-- Who added a webhook (user id): it is paused while that account is disabled. Unset: added before this was kept.
ALTER TABLE webhooks ADD COLUMN owner TEXT;
