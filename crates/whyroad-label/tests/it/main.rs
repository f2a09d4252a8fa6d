//! Integration tests: the label checks on a corpus of true and faulty labels, and the counterfactual model.

mod corpus;
mod counterfactual;
