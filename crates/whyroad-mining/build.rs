//! States the version of how rules are judged: a hash of the code that does it. What a lake keeps of what an
//! older version found is then not used again, without anybody having to remember to count a number up.

#[path = "../whyroad-model/build/code_version.rs"]
mod code_version;

fn main() {
    let version = code_version::of(&[
        "src/comparison.rs",
        "src/deviation.rs",
        "src/interpret",
        "src/interpret.rs",
        "src/fast",
        "src/episode",
        "src/episode.rs",
        "src/language",
    ]);
    println!("cargo:rustc-env=WHYROAD_MINING_VERSION={version}");
}
