//! A label skeleton for each primary episode, written and checked by the label checker, so that the demo can report the
//! remaining work for people.

use crate::output::reason::cannot_write;
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use whyroad_engine::drives::signals_of;
use whyroad_engine::mine::MinedLake;
use whyroad_framework::Framework;
use whyroad_label::check::{Checker, ClipIndex};
use whyroad_label::draft::{Draft, draft};
use whyroad_lake::Lake;
use whyroad_model::messages::{ClipMetadataMessage, EpisodeRecord};
use whyroad_model::{Diagnostic, Lang, Severity};

/// The drafts, and the checker's results.
pub(super) struct Drafts {
    path: PathBuf,
    count: usize,
    /// Drafts without an error.
    sound: usize,
    /// Errors by code.
    faults: BTreeMap<&'static str, usize>,
    /// Drives that could not be read again.
    pub lost: Vec<Diagnostic>,
}

/// Writes `draft_labels.jsonl` (labels in the exchange format) and `draft_notes.jsonl` (inferred and missing parts; one
/// line per label, in the same order).
pub(super) fn write(
    framework: &Framework,
    lake: &Lake,
    mined: &MinedLake,
    episodes: &[EpisodeRecord],
    out: &Path,
    lang: Lang,
) -> anyhow::Result<Drafts> {
    let (mut all, mut lost): (Vec<Draft>, Vec<Diagnostic>) = (Vec::new(), Vec::new());
    for found in &mined.drives {
        let read = lake.read_drive(&found.drive_id);
        let read = read.and_then(|drive| Ok((drive, signals_of(lake, &found.drive_id)?)));
        let (drive, signals) = match read {
            Ok(read) => read,
            Err(e) => {
                lost.push(e.diagnostic());
                continue;
            }
        };
        let own = episodes.iter().filter(|e| e.drive_id == found.drive_id && e.is_primary);
        let made = own.map(|e| draft(framework, &drive, &signals, e, lang));
        all.extend(made.filter(|d| d.doubt.is_none()));
    }

    let mut clips = ClipIndex::default();
    for clip in mined.drives.iter().flat_map(|d| &d.clips) {
        clips.add(&serde_json::to_vec(&ClipMetadataMessage { clip_metadata: clip.clone() })?);
    }
    let checker = Checker::new(framework).with_clips(clips);
    let (mut labels, mut notes) = (String::new(), String::new());
    let (mut sound, mut faults) = (0, BTreeMap::new());
    for draft in &all {
        let text = serde_json::to_string(&draft.label)?;
        let found = checker.check_text(&text);
        let errors: Vec<_> = found.iter().filter(|d| d.severity == Severity::Error).collect();
        sound += usize::from(errors.is_empty());
        for d in errors {
            *faults.entry(d.code).or_default() += 1;
        }
        let _ = writeln!(labels, "{text}");
        let _ = writeln!(notes, "{}", serde_json::to_string(draft)?);
    }
    let path = out.join("draft_labels.jsonl");
    for (path, text) in [(&path, labels), (&out.join("draft_notes.jsonl"), notes)] {
        std::fs::write(path, text).with_context(|| cannot_write(path.display()))?;
    }
    Ok(Drafts { path, count: all.len(), sound, faults, lost })
}

impl Drafts {
    /// Summary of the drafts and the checker's findings, in one paragraph.
    pub(super) fn summary(&self, lang: Lang) -> String {
        let (count, sound, path) = (self.count, self.sound, self.path.display());
        let rest = count - sound;
        let mut text = match lang {
            Lang::Zh => format!(
                "草稿  {count} 个标注草稿写入 {path}；校验：{sound} 个格式完整，{rest} 个还有欠缺；全部须由标注员确认"
            ),
            Lang::En => format!(
                "draft   {count} label skeletons in {path}; checker: {sound} complete, {rest} incomplete; each needs a person"
            ),
        };
        for (code, n) in &self.faults {
            let _ = write!(text, "\n          {n:>3} × {code}");
        }
        text
    }
}
