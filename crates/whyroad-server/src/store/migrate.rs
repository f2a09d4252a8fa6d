//! Migrates the tables one version at a time. A released script is never changed.

use super::sql::Tx;
use crate::problem::{Answer, Problem};
use crate::values;

/// One script per version, from 1.
const SCRIPTS: &[&str] = &[
    include_str!("../../migrations/0001_tables.sql"),
    include_str!("../../migrations/0002_language.sql"),
    include_str!("../../migrations/0003_identities.sql"),
    include_str!("../../migrations/0004_languages.sql"),
    include_str!("../../migrations/0005_tokens.sql"),
    include_str!("../../migrations/0006_dashboard.sql"),
    include_str!("../../migrations/0007_page.sql"),
    include_str!("../../migrations/0008_safety.sql"),
    include_str!("../../migrations/0009_gold.sql"),
    include_str!("../../migrations/0010_verdicts.sql"),
    include_str!("../../migrations/0011_sign_in_failures.sql"),
    include_str!("../../migrations/0012_language_model.sql"),
    include_str!("../../migrations/0013_covering_indexes.sql"),
    include_str!("../../migrations/0014_disagreement.sql"),
    include_str!("../../migrations/0015_not_compared.sql"),
    include_str!("../../migrations/0016_choice.sql"),
    include_str!("../../migrations/0017_webhook_owner.sql"),
    include_str!("../../migrations/0018_imported.sql"),
    include_str!("../../migrations/0019_other_class.sql"),
    include_str!("../../migrations/0020_in_hand.sql"),
    include_str!("../../migrations/0021_finished_episodes.sql"),
];

/// The version of this program.
pub(super) const LATEST: i64 = SCRIPTS.len() as i64;

/// The version of the store; 0 for an empty one.
pub(super) fn version(tx: &mut dyn Tx) -> Answer<i64> {
    tx.script("CREATE TABLE IF NOT EXISTS schema_version (version BIGINT NOT NULL)")?;
    let row = tx.row("SELECT max(version) AS version FROM schema_version", &[])?;
    let version = row.map(|r| r.maybe_int("version")).transpose()?.flatten().unwrap_or(0);
    if version > LATEST {
        return Err(Problem::new(
            503,
            "store.newer",
            format!("存储的版本为 {version}，本程序最高支持 {LATEST}"),
            format!("the store has version {version}, this program supports up to {LATEST}"),
        ));
    }
    Ok(version)
}

/// Migrates the tables to version `wanted`.
pub(super) fn to(tx: &mut dyn Tx, wanted: i64) -> Answer<()> {
    let now = version(tx)?;
    for (number, script) in (1..=wanted).zip(SCRIPTS).skip(now as usize) {
        tx.script(script)?;
        tx.run("INSERT INTO schema_version (version) VALUES ($1)", values![number])?;
    }
    Ok(())
}
