//! Makes cargo rebuild this crate when a file of the built page appears or goes: `include_dir` on stable Rust only
//! notices changes inside files that it already knows.

fn main() {
    println!("cargo:rerun-if-changed=assets");
}
