//! `whyroad mine --sequences FILE`: the results of a custom rule, in the form of the Argoverse 2 scenario-mining
//! challenge.

use crate::output::reason::{Reason, cannot_write, reason};
use anyhow::Context as _;
use std::path::{Path, PathBuf};
use whyroad_lake::Lake;
use whyroad_model::DriveId;
use whyroad_model::messages::EpisodeRecord;
use whyroad_report::evaluation::scenario_mining::bridge;
use whyroad_report::evaluation::scenario_mining::result::{MiningResult, to_pickle};
use whyroad_report::evaluation::scenario_mining::sequence;
use whyroad_signals::estimate::estimated;

/// The file's name, whose ending states the form.
pub(super) fn file(text: &str) -> Result<PathBuf, Reason> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|e| e == "pkl" || e == "jsonl");
    known
        .then_some(path)
        .ok_or_else(|| reason("文件名应以 .pkl 或 .jsonl 结尾", "the name must end with .pkl or .jsonl"))
}

/// Writes the results on each of these drives: a pickle where the file ends in `.pkl`, else JSON Lines.
pub(super) fn write(
    file: &Path,
    lake: &Lake,
    prompt: &str,
    found: &[(DriveId, Vec<EpisodeRecord>)],
) -> anyhow::Result<()> {
    let mut results: Vec<MiningResult> = Vec::with_capacity(found.len());
    for (id, episodes) in found {
        let drive = lake.read_drive(id).map_err(|e| anyhow::anyhow!(Reason::from(e.diagnostic().message)))?;
        let joined = estimated(&drive).joined;
        let result = bridge::result(&drive, prompt, episodes, &joined);
        // A drive without a pose of the ego has no position in the city.
        if !result.frames.is_empty() {
            results.push(result);
        }
    }
    let bytes = if file.extension().is_some_and(|e| e == "pkl") {
        to_pickle(&results)
    } else {
        let sequences: Vec<_> = results.iter().map(MiningResult::to_sequence).collect();
        sequence::write(&sequences)?.into_bytes()
    };
    std::fs::write(file, bytes).with_context(|| cannot_write(file.display()))
}
