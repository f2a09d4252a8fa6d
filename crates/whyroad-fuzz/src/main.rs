//! `whyroad-fuzz [--seconds N] [--executions N] [--resume] [--seed N] [--folder DIR] [TARGET...]`: runs fuzz targets,
//! all by default, for a minute each or until each has that many executions. `--resume` continues the run before with
//! the same seed. `--input FILE TARGET` runs one input again, with the usual panic message.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use whyroad_fuzz::harness::{Begin, Limit, Target, run};

fn main() -> ExitCode {
    let (mut seconds, mut executions, mut seed, mut begin) = (None, None, 1, Begin::New);
    let (mut folder, mut input, mut names) = (PathBuf::from("target/fuzz-inputs"), None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_default();
        match argument.as_str() {
            "--seconds" => seconds = value().parse().ok(),
            "--executions" => executions = value().parse().ok(),
            "--resume" => begin = Begin::Resumed,
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
    // In the order in which they were named.
    let named = names.iter().flat_map(|n| targets.iter().filter(move |t| t.name == *n));
    let chosen: Vec<&Target> = if names.is_empty() { targets.iter().collect() } else { named.collect() };
    // A minute, unless a number of executions is asked for.
    let usual = if executions.is_some() { Duration::MAX } else { Duration::from_secs(60) };
    let limit = Limit {
        executions: executions.unwrap_or(u64::MAX),
        time: seconds.map_or(usual, Duration::from_secs),
    };
    let mut failed = false;
    for target in chosen {
        if let Some(file) = &input {
            let bytes = std::fs::read(file).unwrap_or_default();
            let taken = (target.run)(&bytes);
            println!("{}", if taken { "accepted" } else { "refused" });
            continue;
        }
        let outcome = run(target, seed, limit, begin, &folder);
        println!(
            "{:<24} {:>9} executions  {:>7.1} s of CPU time  {:>7.0} per second  {} failures",
            target.name,
            outcome.executions,
            outcome.spent.as_secs_f64(),
            outcome.executions as f64 / outcome.spent.as_secs_f64().max(1e-3),
            outcome.failures.len()
        );
        for f in &outcome.failures {
            println!("  {}.{}.failure, {} times: {}", target.name, f.execution, f.times, f.what);
        }
        failed |= !outcome.failures.is_empty();
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
