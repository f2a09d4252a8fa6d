//! `whyroad-fuzz [--seconds N] [--executions N] [--seed N] [--folder DIR] [TARGET...]`: runs fuzz targets, all by
//! default. `--input FILE TARGET` runs one input again, with the usual panic message.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use whyroad_fuzz::harness::{Limit, run};

fn main() -> ExitCode {
    let (mut seconds, mut executions, mut seed) = (60, u64::MAX, 1);
    let (mut folder, mut input, mut names) = (PathBuf::from("target/fuzz-inputs"), None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_default();
        match argument.as_str() {
            "--seconds" => seconds = value().parse().unwrap_or(seconds),
            "--executions" => executions = value().parse().unwrap_or(executions),
            "--seed" => seed = value().parse().unwrap_or(seed),
            "--folder" => folder = value().into(),
            "--input" => input = Some(value()),
            name => names.push(name.to_owned()),
        }
    }
    if std::fs::create_dir_all(&folder).is_err() {
        eprintln!("{} cannot be created", folder.display());
        return ExitCode::from(2);
    }
    let targets = whyroad_fuzz::all();
    if let Some(unknown) = names.iter().find(|n| targets.iter().all(|t| t.name != **n)) {
        let known: Vec<&str> = targets.iter().map(|t| t.name.as_str()).collect();
        eprintln!("target '{unknown}' not found; the targets are {}", known.join(", "));
        return ExitCode::from(2);
    }
    let chosen = targets.iter().filter(|t| names.is_empty() || names.contains(&t.name));
    let limit = Limit { executions, time: Duration::from_secs(seconds) };
    let mut failed = false;
    for target in chosen {
        if let Some(file) = &input {
            let bytes = std::fs::read(file).unwrap_or_default();
            (target.run)(&bytes);
            continue;
        }
        let outcome = run(target, seed, limit, &folder);
        println!(
            "{:<24} {:>9} executions  {} failures",
            target.name,
            outcome.executions,
            outcome.failures.len()
        );
        for (execution, what) in &outcome.failures {
            println!("  {}.{execution}.failure: {what}", target.name);
        }
        failed |= !outcome.failures.is_empty();
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
