//! Signal tables: what is derived from one drive, by name. The catalog of names is `schema/signals.yaml`.

use crate::pair::PairTable;
use crate::{Column, DriveId, FrameRange, Nanos, Need, ObjectClass, TrackId};
use std::collections::{BTreeMap, BTreeSet};

/// The first clause of a signal's meaning: what it is, without how it is computed. A signal that the clause refers to
/// by its id is replaced by the first clause of its own meaning, which `meaning` returns.
pub fn short_meaning<'m>(text: &str, meaning: impl Fn(&str) -> Option<&'m str>) -> String {
    let clause = first_clause(text);
    let short = |id: &str| meaning(id).map(first_clause).filter(|words| !words.is_empty());
    let other = clause.split(|c: char| !is_id_character(c)).find_map(|id| Some((id, short(id)?)));
    other.map_or_else(|| clause.to_owned(), |(id, words)| clause.replace(id, words))
}

/// True for a character that ids of signals are made of.
pub fn is_id_character(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '.'
}

fn first_clause(text: &str) -> &str {
    let stops = [". ", ", ", ": ", "; ", " (", "。", "，", "：", "；", "（"];
    let end = stops.iter().filter_map(|s| text.find(s)).filter(|&i| i > 0).min().unwrap_or(text.len());
    text[..end].trim_end_matches(['.', '。'])
}

/// Name of the column with the standard deviations of a number signal, in its unit, beside that of the signal. A signal
/// without one is exact.
pub fn deviation_name(signal: &str) -> String {
    format!("{signal}{DEVIATION}")
}

/// True for the name of a column of standard deviations: it is not a signal of the catalog.
pub fn is_deviation(column: &str) -> bool {
    column.ends_with(DEVIATION)
}

const DEVIATION: &str = ".sd";

/// All signals of one drive.
///
/// Names are as in the catalog: `ego.speed`, `target.gap`, `map.distance_to_junction`. A signal is in
/// exactly one of `frame_columns`, `target_columns` and `unavailable`. Number signals that are estimated from noisy
/// measurements have their standard deviations in a column of [`deviation_name`].
#[derive(Clone, Debug, Default)]
pub struct SignalTable {
    /// The drive.
    pub drive_id: DriveId,
    /// Frame times.
    pub times: Vec<Nanos>,
    /// Signals with one value per frame.
    pub frame_columns: BTreeMap<String, Column>,
    /// One entry per target, in the order of the rows.
    pub targets: Vec<TargetSpan>,
    /// Signals with one value per target and frame; all have the same number of rows.
    pub target_columns: BTreeMap<String, Column>,
    /// Signals that this log cannot support, with what it lacks: `{"light.state": [Need::TrafficLights]}`.
    pub unavailable: BTreeMap<String, Vec<Need>>,
    /// Signals with values although the log lacks what they need, with what it lacks: they are known only where other
    /// data proves them (a junction where the ego turns, without a map). A class that needs one is found there, but the
    /// drive does not count as searched for it.
    pub partial: BTreeMap<String, Vec<Need>>,
    /// Classes of objects of which no box is known in any frame: what needs their sizes is unknown.
    pub without_boxes: BTreeSet<ObjectClass>,
    /// Signals of pairs, where a rule uses them; then the ego may be the last of `targets`.
    pub pairs: Option<PairTable>,
}

/// Id of the ego where it is among the objects that a rule about any object uses.
pub const EGO_ID: &str = "ego";

/// True for a signal with a value for each object and frame, by its name.
pub fn is_of_object(signal: &str) -> bool {
    signal.starts_with("target.") || signal.starts_with("object.")
}

/// True for a signal that is derived only when a rule uses it, by its name: of any object, or of a pair.
pub fn is_on_demand(signal: &str) -> bool {
    signal.starts_with("object.") || signal.starts_with("pair.")
}

/// Where the rows of one target are: dense from its first to its last observed frame. In frames between
/// in which it was not observed, every target signal is unknown except `target.observed` (false).
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSpan {
    /// Track id.
    pub id: TrackId,
    /// Class.
    pub class: ObjectClass,
    /// Row of the first frame in every target column.
    pub first_row: usize,
    /// Frames covered; row = `first_row + frame - frames.start`.
    pub frames: FrameRange,
}

impl TargetSpan {
    /// The row of `frame`, if it is covered.
    pub fn row(&self, frame: usize) -> Option<usize> {
        self.frames.contains(frame).then(|| self.first_row + frame - self.frames.start)
    }
}

impl SignalTable {
    /// True if the log has what this signal needs, so that not finding something by it means that it is not there.
    pub fn shows_all(&self, signal: &str) -> bool {
        let of_pair = || self.pairs.as_ref().is_some_and(|p| p.columns.contains_key(signal));
        let has =
            self.frame_columns.contains_key(signal) || self.target_columns.contains_key(signal) || of_pair();
        has && !self.partial.contains_key(signal)
    }

    /// The target with this id.
    pub fn target(&self, id: &TrackId) -> Option<&TargetSpan> {
        self.targets.iter().find(|t| &t.id == id)
    }
}
