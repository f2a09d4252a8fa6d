//! Exit codes shared by the commands: 0 fine, 1 findings or failure, 2 usage (clap's), 3 done but some input was lost.

use indicatif::{ProgressBar, ProgressStyle};
use std::process::ExitCode;

/// Talk, without a line's end. A closed stderr is no reason to stop, where `eprint!` would panic.
macro_rules! tell {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = write!(std::io::stderr(), $($text)*);
    }};
}

/// Talk, one line.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

/// All went well.
pub(crate) const FINE: ExitCode = ExitCode::SUCCESS;
/// There are findings, or the command could not do it at all.
pub(crate) const FINDINGS: ExitCode = ExitCode::FAILURE;

/// Done, but some input was lost.
pub(crate) fn lost_input() -> ExitCode {
    ExitCode::from(3)
}

/// Writes data to stdout. A reader that has heard enough (`| head`) ends the program quietly, as it would any other.
pub(crate) fn put(text: &str) {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
        std::process::exit(0);
    }
}

/// A bar for so many steps; draws on stderr, and only on a terminal.
pub(crate) fn progress(steps: usize) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {msg}") {
        bar.set_style(style);
    }
    bar
}
