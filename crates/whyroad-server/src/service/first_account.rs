//! The token with which the first account of a service that others can reach is created. All services on a store accept
//! the same one: a load balancer sends the request that creates the account to any of them. It is sealed in the store,
//! and removed with its use.

use crate::problem::{Answer, Problem};
use crate::service::people;
use crate::store::{Store, Tx, vault};
use crate::{secret, values};
use std::sync::Arc;

/// The name of the setting.
const NAME: &str = "setup_token";

/// The token, made on the first call for this store; `None` once there is an account.
pub fn token(store: &Store) -> Answer<Option<String>> {
    let vault = Arc::clone(&store.vault);
    let fresh = vault.seal(vault::SETUP_TOKEN, &secret::random(16)?)?;
    let sealed = store.write(move |tx| {
        if !people::is_first_run(tx)? {
            forget(tx)?;
            return Ok(None);
        }
        tx.run(
            "INSERT INTO settings (name, value) VALUES ($1, $2) ON CONFLICT (name) DO NOTHING",
            values![NAME, &fresh],
        )?;
        let row = tx.row("SELECT value FROM settings WHERE name = $1", values![NAME])?;
        row.ok_or_else(Problem::missing)?.text("value").map(Some)
    })?;
    sealed.map(|sealed| vault.open_text(vault::SETUP_TOKEN, &sealed)).transpose()
}

/// Removes the token: the first account is created in the same transaction.
pub fn forget(tx: &mut dyn Tx) -> Answer<()> {
    tx.run("DELETE FROM settings WHERE name = $1", values![NAME]).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::fixtures;

    #[test]
    fn services_on_one_store_have_one_token_and_none_once_there_is_an_account() {
        let (app, _dir) = fixtures::app();
        let first = token(&app.store).unwrap();
        assert_eq!(first.as_ref().map(String::len), Some(32), "16 bytes in hexadecimal");
        assert_eq!(token(&app.store).unwrap(), first);
        let stored = |app: &crate::app::App| {
            let row =
                app.store.read(|tx| tx.row("SELECT value FROM settings WHERE name = $1", values![NAME]));
            row.unwrap().map(|r| r.text("value").unwrap())
        };
        assert!(!stored(&app).unwrap().contains(&first.clone().unwrap()), "a backup does not show it");
        // A replaced key seals it again.
        app.store.rotate_key().unwrap();
        assert_eq!(token(&app.store).unwrap(), first);
        app.store
            .write(|tx| {
                forget(tx)?;
                tx.run(
                    "INSERT INTO users (id, name, display, admin, lang, password_hash, disabled, created)
                     VALUES ('a', 'a', 'A', 1, 'en', '', 0, 0)",
                    &[],
                )
            })
            .unwrap();
        assert_eq!((token(&app.store).unwrap(), stored(&app)), (None, None));
    }
}
