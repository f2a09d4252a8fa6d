//! The language of a page that holds both: the same rule on every page that a command writes.

/// Script for the end of the body. The page opens in the language of its `<html lang>`, unless its reader chose another
/// one before, or the address does. It serves buttons (`data-lang`) and radio buttons (`name="l"`, ids `zh` and `en`);
/// without scripts, radio buttons still work by style alone.
pub const LANGUAGE_SCRIPT: &str = include_str!("../assets/language.js");
