//! `whyroad migrate`: converts labels of older layouts to the current format, or back to 2.0.

use crate::output::reason::{cannot_read, cannot_write, reason};
use crate::{Global, framework_folder, output};
use anyhow::Context as _;
use serde_json::Value;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use whyroad_label::migrate::{Target, migrate};

/// Arguments of `whyroad migrate`.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// JSON or JSON Lines files with labels, or - for standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Format to write
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = To::Current)]
    to: To,
    /// Write the labels to this file (JSON Lines) instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A format of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum To {
    /// The newest
    Current,
    /// 2.0.0
    #[value(name = "2.0")]
    V2_0,
}

pub(crate) fn run(global: &Global, args: Args) -> anyhow::Result<ExitCode> {
    let (framework, _) = framework_folder::load(global)?;
    let target = match args.to {
        To::Current => Target::Current,
        To::V2_0 => Target::V2_0,
    };
    let (mut text, mut labels, mut lost) = (String::new(), 0_usize, 0_usize);
    for file in &args.files {
        let name = if file == Path::new("-") { "<stdin>".to_owned() } else { file.display().to_string() };
        for document in documents(file)? {
            let done = migrate(&framework, &document, target);
            for d in done.report {
                lost += 1;
                tell!("{}", output::render_text(&d.in_file(&name), global.lang));
            }
            if let Some(label) = done.label {
                labels += 1;
                text.push_str(&label.to_string());
                text.push('\n');
            }
        }
    }
    match &args.out {
        Some(path) => std::fs::write(path, text).with_context(|| cannot_write(path.display()))?,
        None => output::put(&text),
    }
    say!(
        "{}",
        match global.lang {
            whyroad_model::Lang::Zh => format!("已转换 {labels} 个标注，{lost} 处未能保留或有待补充"),
            whyroad_model::Lang::En =>
                format!("{labels} labels migrated, {lost} items left out or to be added"),
        }
    );
    Ok(if lost > 0 { output::lost_input() } else { output::FINE })
}

/// The documents of a file: one after another, or the items of one list.
fn documents(file: &Path) -> anyhow::Result<Vec<Value>> {
    let mut text = String::new();
    if file == Path::new("-") {
        std::io::stdin().read_to_string(&mut text).context(cannot_read("-"))?;
    } else {
        text = std::fs::read_to_string(file).with_context(|| cannot_read(file.display()))?;
    }
    let mut out = Vec::new();
    for value in serde_json::Deserializer::from_str(&text).into_iter::<Value>() {
        match value.with_context(|| {
            reason(format!("{} 不是 JSON", file.display()), format!("{} is not JSON", file.display()))
        })? {
            Value::Array(items) => out.extend(items),
            one => out.push(one),
        }
    }
    Ok(out)
}
