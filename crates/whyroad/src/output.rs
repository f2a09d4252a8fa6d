//! Printing and exit codes shared by the commands. Color only on a terminal (or by `--color`). Exit codes: 0 fine, 1
//! findings or failure, 2 usage (clap's), 3 done but some input was lost.

pub(crate) mod log;
pub(crate) mod reason;
pub(crate) mod usage;

use serde::Serialize;
use std::process::ExitCode;
use whyroad_model::{Diagnostic, Lang};

/// Prints to stderr, without a line end. A closed stderr is not a reason to stop, where `eprint!` would panic.
macro_rules! tell {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = write!(anstream::stderr(), $($text)*);
    }};
}

/// Prints one message to stderr, in the log format.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::output::log::message(&format!($($text)*))
    };
}

/// How a command prints the requested data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DataFormat {
    /// For people
    #[default]
    Text,
    /// One JSON document
    Json,
}

/// `--format` of a command that prints data: the same option everywhere.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct Print {
    /// How to print the result
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub format: DataFormat,
}

impl Print {
    /// Prints `data` as JSON, or the text that `text` makes.
    pub fn put<T: Serialize + ?Sized>(self, data: &T, text: impl FnOnce() -> String) -> anyhow::Result<()> {
        match self.format {
            DataFormat::Json => put_json(data)?,
            DataFormat::Text => put(&text()),
        }
        Ok(())
    }
}

/// How a command prints findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum FindingFormat {
    /// For people
    #[default]
    Text,
    /// One JSON document: diagnostics and counts
    Json,
    /// SARIF 2.1.0, for code hosting and editors
    Sarif,
}

/// `--format` of a command that prints findings.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct PrintFindings {
    /// How to print findings
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub format: FindingFormat,
}

/// Writes a JSON document to stdout, indented.
pub(crate) fn put_json<T: Serialize + ?Sized>(data: &T) -> anyhow::Result<()> {
    put(&format!("{}\n", serde_json::to_string_pretty(data)?));
    Ok(())
}

/// A diagnostic as text, colored where the stream is a terminal: `tell!` and `put` remove colors elsewhere. In the log
/// format JSON it is a line of that.
pub(crate) fn render_text(d: &Diagnostic, lang: Lang) -> String {
    if log::is_json() {
        return log::of_diagnostic(d, lang);
    }
    whyroad_model::diagnostic::render_ansi(d, lang)
}

/// The values of `--color`.
pub(crate) fn color_choice(text: &str) -> Result<anstream::ColorChoice, reason::Reason> {
    match text {
        "auto" => Ok(anstream::ColorChoice::Auto),
        "always" => Ok(anstream::ColorChoice::Always),
        "never" => Ok(anstream::ColorChoice::Never),
        _ => Err(reason::possible_values(&["auto", "always", "never"])),
    }
}

/// Success.
pub(crate) const FINE: ExitCode = ExitCode::SUCCESS;
/// There are findings, or the command failed.
pub(crate) const FINDINGS: ExitCode = ExitCode::FAILURE;

/// Done, but some input was lost.
pub(crate) fn lost_input() -> ExitCode {
    ExitCode::from(3)
}

/// Writes data to stdout. A reader that closes the pipe (`| head`) ends the program quietly.
pub(crate) fn put(text: &str) {
    use std::io::Write as _;
    let mut out = anstream::stdout().lock();
    if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
        std::process::exit(0);
    }
}

/// A progress bar with this number of steps; drawn on stderr, and only on a terminal. In the log format JSON it is an
/// occasional line.
pub(crate) fn progress(steps: usize) -> log::Progress {
    log::Progress::new(steps)
}
