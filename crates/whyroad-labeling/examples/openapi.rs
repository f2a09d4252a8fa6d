//! Writes the OpenAPI document: `cargo run -q -p whyroad-labeling --example openapi > crates/whyroad-labeling/openapi.json`.

use std::io::Write;

fn main() -> std::io::Result<()> {
    std::io::stdout().write_all(whyroad_labeling::api::openapi::text().as_bytes())
}
