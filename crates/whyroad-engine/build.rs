//! States the version of how results are written down: a hash of the code that does it. The ledger of a mined folder is
//! then not relied on when another version wrote it, without anybody having to remember to count a number up.

#[path = "../whyroad-model/build/code_version.rs"]
mod code_version;

fn main() {
    let version = code_version::of(&[
        "src/again.rs",
        "src/mine.rs",
        "src/objects.rs",
        "src/output",
        "../whyroad-lake/src/clips.rs",
        "../whyroad-lake/src/mined",
        "../whyroad-mining/src/drive.rs",
        "../whyroad-mining/src/rule",
    ]);
    println!("cargo:rustc-env=WHYROAD_ENGINE_VERSION={version}");
}
