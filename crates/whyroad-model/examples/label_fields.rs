//! Writes the page's module of the label's fields:
//! `cargo run -q -p whyroad-model --example label_fields > web/src/label/label_fields.generated.ts`.
#![allow(clippy::print_stdout)] // printing is what it is for

use whyroad_model::label_fields::{LABEL_FIELDS, page_module};

fn main() {
    print!("{}", page_module(LABEL_FIELDS));
}
