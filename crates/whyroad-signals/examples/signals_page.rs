//! Prints `docs/reference/signals.md` from the bundled catalogue.
#![allow(clippy::print_stdout, reason = "the page is the output")]

fn main() {
    print!("{}", whyroad_signals::Catalogue::bundled().page());
}
