//! Integration tests: the label checks on a corpus of true and faulty labels, and the counterfactual model.

#![allow(clippy::unwrap_used, reason = "a test says what went wrong by failing")]

mod corpus;
mod counterfactual;
mod facts;
mod hindsight;
mod last_clauses;
mod near_causes;
mod recording;
