//! States the version of the signals: a hash of the code that derives them and of the catalog. What a lake keeps of
//! an older version is then derived again, without anybody having to remember to count a number up.

#[path = "../whyroad-model/build/code_version.rs"]
mod code_version;

fn main() {
    let version = code_version::of(&["src", "../whyroad-model/src", "../../schema/signals.yaml"]);
    println!("cargo:rustc-env=WHYROAD_SIGNALS_VERSION={version}");
}
