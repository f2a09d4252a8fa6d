//! The generated pages of `docs/` that are made of several sources: a page for every leaf, the index of leaves, the
//! index of diagnostics, the list of formats, and the lists of all in the book's summary.

mod cases;
mod diagnostics;
mod formats;
mod generated;
mod leaf;
mod leaves;
mod sources;
mod summary;

pub(super) use diagnostics::index as diagnostics_index;
pub(super) use formats::fill as fill_formats;
pub(super) use leaves::pages as leaf_pages;
pub(super) use summary::fill as fill_summary;

use whyroad_model::{Bilingual, Lang};

/// First line of a generated page.
const GENERATED: &str =
    "<!-- Written by `whyroad taxonomy docs` from schema/ and scenarios/. Change those, not this page. -->";

/// Ending of a page's file name.
fn ending(lang: Lang) -> &'static str {
    match lang {
        Lang::En => ".md",
        Lang::Zh => ".zh.md",
    }
}

/// A literal in `lang`.
fn say(lang: Lang, en: &'static str, zh: &'static str) -> &'static str {
    match lang {
        Lang::En => en,
        Lang::Zh => zh,
    }
}

/// Text that cannot break a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// Both names, that of the reader's language first.
fn title(name: &Bilingual, lang: Lang) -> String {
    let (first, second) = match lang {
        Lang::En => (&name.en, &name.zh),
        Lang::Zh => (&name.zh, &name.en),
    };
    if first == second { first.clone() } else { format!("{first} · {second}") }
}
