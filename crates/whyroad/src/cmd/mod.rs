//! One file per command: its arguments, and the calls that answer them.

pub(crate) mod accounts;
pub(crate) mod backup;
pub(crate) mod baseline;
pub(crate) mod compare;
pub(crate) mod dataset;
pub(crate) mod demo;
pub(crate) mod evaluate;
pub(crate) mod explain;
pub(crate) mod ingest;
pub(crate) mod inspect;
pub(crate) mod labels;
pub(crate) mod media;
pub(crate) mod migrate;
pub(crate) mod mine;
pub(crate) mod report;
pub(crate) mod robustness;
pub(crate) mod rules;
pub(crate) mod serve;
pub(crate) mod shell;
pub(crate) mod signals;
pub(crate) mod tasks;
pub(crate) mod taxonomy;
pub(crate) mod validate;
