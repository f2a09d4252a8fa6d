//! The report: one self-contained HTML page, in Chinese and English, with the coverage of the whole taxonomy
//! and a card for each episode. It fetches nothing, and says so to the browser (Content-Security-Policy).
//!
//! Drives are added one at a time, so that memory does not grow with the lake.

mod card;
mod draft_box;
mod page;
mod summary;
mod tree_map;

use crate::coverage;
use std::collections::BTreeMap;
pub use whyroad_render::plot::SignalInfo;

use whyroad_framework::Framework;
use whyroad_model::messages::{Coverage, EpisodeRecord};
use whyroad_model::{Drive, Lang, SignalTable};

/// What holds for the whole report.
#[derive(Clone, Copy, Debug)]
pub struct ReportContext<'a> {
    /// Classes, specs and decisions.
    pub framework: &'a Framework,
    /// What mining looked for and what came of it.
    pub coverage: &'a Coverage,
    /// Signals by name.
    pub signals: &'a BTreeMap<String, SignalInfo>,
    /// Language that is shown first; the reader can switch.
    pub lang: Lang,
    /// At most so many cards, so that a browser can hold the page; what is left out is counted on the page.
    pub max_cards: usize,
}

/// Collects the page.
#[derive(Debug)]
pub struct ReportBuilder<'a> {
    context: ReportContext<'a>,
    cards: Vec<card::Card>,
    episodes: usize,
    drives: Vec<page::DriveLine>,
}

impl<'a> ReportBuilder<'a> {
    /// An empty report.
    pub fn new(context: ReportContext<'a>) -> Self {
        Self { context, cards: Vec::new(), episodes: 0, drives: Vec::new() }
    }

    /// Adds a drive with its episodes; episodes of other drives are ignored.
    ///
    /// Primary episodes come first where there are more than the page can hold.
    pub fn add_drive(&mut self, drive: &Drive, signals: &SignalTable, episodes: &[EpisodeRecord]) {
        let mut own: Vec<&EpisodeRecord> =
            episodes.iter().filter(|e| e.drive_id == drive.meta.drive_id).collect();
        own.sort_by(|a, b| {
            let key = |e: &EpisodeRecord| (e.keyframe.timestamp, !e.is_primary, e.scenario_id.clone());
            key(a).cmp(&key(b)).then_with(|| a.episode_id.cmp(&b.episode_id))
        });
        self.episodes += own.len();
        self.drives.push(page::DriveLine::new(drive, own.len()));
        let room = self.context.max_cards.saturating_sub(self.cards.len());
        let mut chosen: Vec<&EpisodeRecord> = own.clone();
        if own.len() > room {
            chosen.sort_by_key(|e| !e.is_primary);
            chosen.truncate(room);
            chosen.sort_by_key(|e| e.keyframe.timestamp);
        }
        for episode in chosen {
            self.cards.push(card::render(&self.context, drive, signals, episode));
        }
    }

    /// The page.
    pub fn finish(self) -> String {
        let rows = coverage::rows(&self.context.framework.taxonomy, self.context.coverage);
        page::render(&self.context, &rows, &self.drives, &self.cards, self.episodes)
    }
}

#[cfg(test)]
pub(crate) mod tests;
