//! Reports what cannot be converted.

use whyroad_model::{Bilingual, Diagnostic, Location};

/// Something that cannot be converted.
pub(in crate::migrate) fn lost(pointer: &str, zh: &str, en: &str) -> Diagnostic {
    Diagnostic::warning("label.migrate.lost", Bilingual::new(zh, en))
        .at(Location { pointer: Some(pointer.to_owned()), ..Location::default() })
}
