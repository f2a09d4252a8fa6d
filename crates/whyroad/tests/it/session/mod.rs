//! The binary as a user runs it, for the tests of commands.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run of the binary gave.
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Runs the binary in `folder`, whatever the environment says of framework and language.
pub fn whyroad_in(folder: &Path, args: &[&str]) -> Run {
    whyroad_with(folder, args, &[])
}

/// The same, with these environment variables.
pub fn whyroad_with(folder: &Path, args: &[&str], environment: &[(&str, &str)]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .current_dir(folder)
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .envs(environment.iter().copied())
        .output()
        .unwrap();
    Run {
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}
