//! What tests do where a component is missing on the machine (included by path): they say so, and fail when
//! `WHYROAD_REQUIRE` names it. Components: `recorded` (the recorded drives), `specification`, `postgres`, `chromium`,
//! `python`, `ffmpeg`, `root`.
#![allow(dead_code, reason = "each test binary uses its part")]

/// Reports that a test is skipped for lack of `component`.
///
/// # Panics
/// When `WHYROAD_REQUIRE` (a comma-separated list) names the component.
#[allow(clippy::print_stdout, reason = "a skipped test says so")]
pub fn skipped(component: &str, why: &str) {
    let required = std::env::var("WHYROAD_REQUIRE").unwrap_or_default();
    assert!(
        !required.split(',').any(|name| name.trim() == component),
        "WHYROAD_REQUIRE names {component}, but: {why}"
    );
    println!("skipped: {why}");
}
