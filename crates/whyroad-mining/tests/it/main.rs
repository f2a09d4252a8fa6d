//! Integration tests of rules, cases, queries and the fast evaluator, in one binary.
#![allow(clippy::unwrap_used)]

mod any_text;
mod arbitration;
mod blocks;
mod bundled;
mod cases;
mod decision_moments;
mod diagnostics;
mod equality;
mod fast;
mod fast_truth;
mod lint;
mod names;
mod query;
#[path = "../../../whyroad-model/testing/require.rs"]
mod require;
mod searched;
