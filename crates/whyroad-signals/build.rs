//! Defines the version of the signals: a hash of the code that derives them and of the catalog. Signals that a lake has
//! stored from an older version are then derived again, without a version number that must be increased by hand.

#[path = "../whyroad-model/build/code_version.rs"]
mod code_version;

fn main() {
    let version = code_version::of(&["src", "../whyroad-model/src", "../../schema/signals.yaml"]);
    println!("cargo:rustc-env=WHYROAD_SIGNALS_VERSION={version}");
}
