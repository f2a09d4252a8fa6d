//! The report: one self-contained HTML page, in Chinese and English, with the coverage of the whole taxonomy
//! and a card for each episode. It fetches nothing, and forbids fetching by a Content-Security-Policy.
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
use whyroad_model::{Drive, DriveId, Lang, SignalTable};
use whyroad_render::markup::Markup;

/// Settings of the whole report.
#[derive(Clone, Copy, Debug)]
pub struct ReportContext<'a> {
    /// Classes, specs and decisions.
    pub framework: &'a Framework,
    /// What mining searched for and found.
    pub coverage: &'a Coverage,
    /// Signals by name.
    pub signals: &'a BTreeMap<String, SignalInfo>,
    /// Language that is shown first; the reader can switch.
    pub lang: Lang,
}

/// Chooses the episodes that get a card, drive by drive: primary ones first where there are more than the page can
/// hold.
#[derive(Clone, Copy, Debug)]
pub struct CardChoice {
    room: usize,
}

impl CardChoice {
    /// For a page of at most `max_cards`.
    pub fn new(max_cards: usize) -> Self {
        Self { room: max_cards }
    }

    /// Chooses among episodes in the order of their drives, one of which is in memory at a time; returns the chosen
    /// ones by drive.
    pub fn choose_all(
        mut self,
        episodes: impl Iterator<Item = EpisodeRecord>,
    ) -> BTreeMap<DriveId, ChosenEpisodes> {
        let mut out = BTreeMap::new();
        let mut own: Vec<EpisodeRecord> = Vec::new();
        let mut close = |own: &mut Vec<EpisodeRecord>| {
            if let Some(drive) = own.first().map(|e| e.drive_id.clone()) {
                let chosen = self.choose(std::mem::take(own));
                let of_drive: &mut ChosenEpisodes = out.entry(drive).or_default();
                of_drive.total += chosen.total;
                of_drive.cards.extend(chosen.cards);
            }
        };
        for episode in episodes {
            if own.first().is_some_and(|e| e.drive_id != episode.drive_id) {
                close(&mut own);
            }
            own.push(episode);
        }
        close(&mut own);
        out
    }

    /// Chooses among the episodes of one drive.
    pub fn choose(&mut self, mut own: Vec<EpisodeRecord>) -> ChosenEpisodes {
        let total = own.len();
        own.sort_by(|a, b| {
            let key = |e: &EpisodeRecord| (e.keyframe.timestamp, !e.is_primary, e.scenario_id.clone());
            key(a).cmp(&key(b)).then_with(|| a.episode_id.cmp(&b.episode_id))
        });
        if total > self.room {
            own.sort_by_key(|e| !e.is_primary);
            own.truncate(self.room);
            own.sort_by_key(|e| e.keyframe.timestamp);
        }
        self.room -= own.len();
        ChosenEpisodes { cards: own, total }
    }
}

/// The episodes of one drive that get a card.
#[derive(Clone, Debug, Default)]
pub struct ChosenEpisodes {
    /// In the order of time.
    pub cards: Vec<EpisodeRecord>,
    /// Number of episodes of the drive, with and without a card.
    pub total: usize,
}

/// The content of one drive on the page. Drives are rendered independently of each other.
#[derive(Debug)]
pub struct DrivePart {
    line: page::DriveLine,
    cards: Vec<card::Card>,
}

impl DrivePart {
    /// Renders an estimated drive, whose log has this many `tracks`. `signals` are only read for episodes with a card.
    pub fn new(
        context: &ReportContext<'_>,
        drive: &Drive,
        tracks: usize,
        signals: &SignalTable,
        chosen: &ChosenEpisodes,
    ) -> Self {
        let card = |e: &EpisodeRecord| card::render(context, drive, signals, e);
        Self {
            line: page::DriveLine::new(drive, tracks, chosen.total),
            cards: chosen.cards.iter().map(card).collect(),
        }
    }
}

/// Collects the page.
#[derive(Debug)]
pub struct ReportBuilder<'a> {
    context: ReportContext<'a>,
    cards: Vec<card::Card>,
    episodes: usize,
    drives: Vec<page::DriveLine>,
    analytics: Option<Markup>,
}

impl<'a> ReportBuilder<'a> {
    /// An empty report.
    pub fn new(context: ReportContext<'a>) -> Self {
        Self { context, cards: Vec::new(), episodes: 0, drives: Vec::new(), analytics: None }
    }

    /// Adds the analytics after the coverage.
    pub fn put_analytics(&mut self, fragment: Markup) {
        self.analytics = Some(fragment);
    }

    /// Adds a drive; call it in page order.
    pub fn add(&mut self, part: DrivePart) {
        self.episodes += part.line.episodes;
        self.drives.push(part.line);
        self.cards.extend(part.cards);
    }

    /// The page.
    pub fn finish(self) -> String {
        let rows = coverage::rows(&self.context.framework.taxonomy, self.context.coverage);
        page::render(&self.context, &rows, &self.drives, &self.cards, self.episodes, self.analytics.as_ref())
    }
}

#[cfg(test)]
pub(crate) mod tests;
