//! The interface between the ingest and a recorded format. A new format is one implementation of [`Adapter`],
//! registered in `formats.rs`; the command line, the search for sources and the list of diagnostic codes follow from
//! it.

use crate::assemble::coverage;
use crate::assemble::finish::finish;
use crate::maps::{self, MapBeside};
use crate::options::{OptionSpec, Options};
use crate::report::{RowCount, SourceReport, counts_text};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Lang, Need};

/// What is fixed about a format.
#[derive(Clone, Copy, Debug)]
pub struct FormatAbout {
    /// Name on the command line and in `DriveMeta::format`.
    pub name: &'static str,
    /// One line for the help text: what the format is.
    pub summary: &'static str,
    /// An example call for the help text, after `whyroad ingest`.
    pub example: &'static str,
    /// Options of this format.
    pub options: &'static [OptionSpec],
    /// Codes of the diagnostics of this format; each has a page in `docs/diagnostics/`.
    pub codes: &'static [&'static str],
}

/// A recorded format.
pub trait Adapter: Sync {
    /// What is fixed about the format.
    fn about(&self) -> &'static FormatAbout;

    /// Name on the command line and in `DriveMeta::format`.
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// Sources at or below `path`, sorted. Folders that cannot be listed are passed over; the caller reports them.
    fn find(&self, path: &Path) -> Vec<Located>;

    /// What is wrong with the values of options, before anything is looked for: files that they name. With an error
    /// nothing is read.
    fn check(&self, _options: &Options) -> Vec<Diagnostic> {
        Vec::new()
    }

    /// [`Adapter::find`] where options say what a source is.
    fn find_with(&self, path: &Path, _options: &Options) -> Vec<Located> {
        self.find(path)
    }

    /// Files that are read together with a source and lie outside of it.
    fn companions(&self, _source: &Path) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Why a file that looks like one of this format is not a source; `None` when it does not look like one.
    fn why_skipped(&self, _file: &Path) -> Option<SkipReason> {
        None
    }

    /// Reads one source: a drive with its report, or a report alone that says why there is no drive. Some sources have
    /// several drives (a simulation: one per ego).
    fn read(&self, source: &Source, options: &Options, drives: &mut DriveSink<'_>);

    /// Reads a log from memory, where the format allows it; formats that find their files in another way do nothing.
    fn read_files(&self, _files: &FilesInMemory, _options: &Options, _drives: &mut DriveSink<'_>) {}

    /// Maximum number of parts of one file or folder that [`Adapter::read_batch`] reads in one pass.
    fn batch_size(&self) -> usize {
        1
    }

    /// Reads several parts of one file or folder.
    fn read_batch(&self, sources: &[Source], options: &Options, drives: &mut DriveSink<'_>) {
        sources.iter().for_each(|source| self.read(source, options, drives));
    }
}

/// Files of a log in memory, by name.
pub type FilesInMemory = BTreeMap<String, Vec<u8>>;

/// Why a file is not a source, in both languages.
pub type SkipReason = Bilingual;

/// Where a source is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Located {
    /// Folder or file.
    pub path: PathBuf,
    /// Which drive of a file or folder with several: the byte at which its record begins, or the index of its scene.
    pub part: Option<u64>,
}

impl From<PathBuf> for Located {
    fn from(path: PathBuf) -> Self {
        Self { path, part: None }
    }
}

/// The paths as sources without parts.
pub(crate) fn whole(paths: Vec<PathBuf>) -> Vec<Located> {
    paths.into_iter().map(Located::from).collect()
}

/// One log to be read.
#[derive(Clone, Copy)]
pub struct AdapterRef(pub &'static dyn Adapter);

impl fmt::Debug for AdapterRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name())
    }
}

impl PartialEq for AdapterRef {
    fn eq(&self, other: &Self) -> bool {
        self.0.name() == other.0.name()
    }
}

impl Eq for AdapterRef {}

/// One source: a log folder, a recording, a simulation, a scene of a set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Adapter that reads it.
    pub adapter: AdapterRef,
    /// Folder or file.
    pub path: PathBuf,
    /// See [`Located::part`].
    pub part: Option<u64>,
}

impl Source {
    /// Name of the source's format.
    pub fn format(&self) -> &'static str {
        self.adapter.0.name()
    }
}

/// Receives the drives of a source one at a time, each with its report.
pub struct DriveSink<'a> {
    holds: &'a dyn Fn(&DriveId, &str) -> bool,
    each: &'a mut dyn FnMut(Option<Drive>, SourceReport),
    map: Option<&'a MapBeside>,
    /// To be reported with the first drive.
    news: Vec<Diagnostic>,
}

impl<'a> DriveSink<'a> {
    /// A sink that calls `each`; `holds` says whether the lake has a drive with this id and content hash.
    pub fn new(
        holds: &'a dyn Fn(&DriveId, &str) -> bool,
        each: &'a mut dyn FnMut(Option<Drive>, SourceReport),
    ) -> Self {
        Self { holds, each, map: None, news: Vec::new() }
    }

    /// The same sink, which gives every drive the map that the options name.
    pub fn with_map(mut self, options: &'a Options) -> Self {
        (self.map, self.news) = maps::of_options(options);
        self
    }

    /// True when the lake has this drive: it need not be made, [`DriveSink::put`] takes its report alone, with the id.
    pub fn holds(&self, id: &DriveId, content_hash: &str) -> bool {
        match self.map {
            Some(map) => (self.holds)(id, &map.with(content_hash)),
            None => (self.holds)(id, content_hash),
        }
    }

    /// Finishes a drive (what is common to all formats) and hands it over, or a report that says why there is none.
    pub fn put(&mut self, (mut drive, mut report): (Option<Drive>, SourceReport)) {
        report.diagnostics.append(&mut self.news);
        if let Some(drive) = &mut drive {
            if let Some(map) = self.map {
                map.attach(drive, &mut report);
            }
            report.diagnostics.extend(unused_objects(drive, &report));
            let had = (drive.map.is_some(), drive.lights.is_some());
            if !drive.meta.missing.contains(&Need::Objects) {
                let found = coverage::finding(drive);
                report.diagnostics.extend(found.map(|d| d.in_file(report.source.clone())));
            }
            report.diagnostics.extend(finish(drive).into_iter().map(|d| d.in_file(report.source.clone())));
            let tables = report.tables.iter_mut();
            let is_unused = |t: &&mut RowCount| {
                (had.0 && drive.map.is_none() && OF_MAPS.contains(&t.table))
                    || (had.1 && drive.lights.is_none() && t.table == "lights")
            };
            tables.filter(is_unused).for_each(|t| t.set_all_aside("not_used"));
        }
        (self.each)(drive, report);
    }
}

/// Tables of the road only.
const OF_MAPS: [&str; 6] = ["areas", "lanes", "map", "map_features", "shapes", "signs"];

/// Tables of other road users only.
const OF_OBJECTS: [&str; 4] = ["annotations", "objects", "obstacles", "radar"];

/// Rows of objects of which none could be used: the objects are unknown, the road is not empty.
fn unused_objects(drive: &mut Drive, report: &SourceReport) -> Option<Diagnostic> {
    if !drive.tracks.is_empty() {
        return None;
    }
    // Annotations of the ego alone are used: then there was nobody else.
    let is_unused = |t: &&RowCount| OF_OBJECTS.contains(&t.table) && t.read > 0 && t.kept_total() == 0;
    let table = report.tables.iter().find(is_unused)?;
    drive.meta.lacks(Need::Objects);
    let list = |lang: Lang| {
        let all = [&table.set_aside, &table.dropped].into_iter().filter(|counts| !counts.is_empty());
        all.map(|counts| counts_text(counts, lang)).collect::<Vec<_>>().join(", ")
    };
    let read = table.read;
    let message = Bilingual::new(
        format!("{read} 行目标中没有一行可用（{}）：该行程的目标为未知，并非没有", list(Lang::Zh)),
        format!(
            "none of {read} rows of objects could be used ({}): objects are unknown in this drive, not absent",
            list(Lang::En)
        ),
    );
    let lost = table.set_aside.iter().chain(&table.dropped);
    let most = lost.max_by_key(|(_, n)| **n).map_or("", |(reason, _)| *reason);
    let hint = unused_hint(most);
    Some(Diagnostic::error("ingest.objects.unused", message).with_hint(hint).in_file(report.source.clone()))
}

/// What to check where this is why most rows of objects are not used.
fn unused_hint(reason: &str) -> Bilingual {
    match reason {
        "unknown_frame" => Bilingual::new(
            "检查目标的坐标系：须为自车位姿的坐标系或自车坐标系",
            "check the frame of the objects: it has to be that of the ego's poses or that of its car",
        ),
        "no_id" => Bilingual::new(
            "检查目标的编号：每个目标须有在各帧中不变的编号",
            "check the ids of the objects: each needs one that is the same in all frames",
        ),
        "no_time" | "no_position" | "no_heading" | "no_list" | "invalid" | "undecodable" => Bilingual::new(
            "检查目标各字段的名称与形式；其他消息会指出无法使用的字段",
            "check the names and forms of the objects' fields; other messages name those that could not be used",
        ),
        _ => Bilingual::new(
            "检查目标与自车的时间是否用同一时钟、同一单位",
            "check that the times of objects and ego are of one clock and in one unit",
        ),
    }
}
