//! Writes the OpenAPI document:
//! `cargo run -q -p whyroad-server --example openapi > crates/whyroad-server/openapi.json`.

use std::io::Write;

fn main() -> std::io::Result<()> {
    std::io::stdout()
        .write_all(whyroad_server::api::openapi::text(whyroad_server::api::table::ROUTES).as_bytes())
}
