//! From paths to a lake: finds the sources, and writes one source at a time into the lake.

use crate::adapter::{AdapterRef, DriveSink, FilesInMemory, Source};
use crate::formats;
use crate::leftover::{self, Below};
use crate::options::Options;
use crate::origin::Origin;
use crate::report::SourceReport;
use std::cell::Cell;
use std::path::PathBuf;
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::scene::FRAME_RATE_HZ;
use whyroad_model::{Bilingual, Diagnostic, Drive, DriveId, Severity};

/// Codes of the search for sources.
pub(crate) const CODES: &[&str] = &["ingest.path.missing", "ingest.nothing_found"];

/// [`find_sources_with`] without options.
pub fn find_sources(format: Option<AdapterRef>, paths: &[PathBuf]) -> (Vec<Source>, Vec<Diagnostic>) {
    find_sources_with(format, paths, &Options::default())
}

/// The sources at or below `paths`, and diagnostics for paths without any and for files that no source uses. Without a
/// format, every adapter is tried.
pub fn find_sources_with(
    format: Option<AdapterRef>,
    paths: &[PathBuf],
    options: &Options,
) -> (Vec<Source>, Vec<Diagnostic>) {
    let adapters = format.as_ref().map_or(formats::ALL, std::slice::from_ref);
    let problems: Vec<Diagnostic> = adapters.iter().flat_map(|a| a.0.check(options)).collect();
    if !problems.is_empty() {
        return (Vec::new(), problems);
    }
    let (mut sources, mut problems) = (Vec::new(), Vec::new());
    for path in paths {
        let label = path.display().to_string();
        if !path.exists() {
            problems.push(not_there(&label));
            continue;
        }
        let before = (sources.len(), problems.len());
        for &adapter in adapters {
            let found = adapter.0.find_with(path, options).into_iter();
            sources.extend(found.map(|at| Source { adapter, path: at.path, part: at.part }));
        }
        let mut found = sources.split_off(before.0);
        let all = found.clone();
        problems.extend(leftover::refuse_pointers(&mut found));
        let below = Below::of(path);
        problems.extend(leftover::unreadable(path, &below, &all));
        if format.is_none() {
            problems.extend(leftover::skipped(path, &below, &all, adapters));
        }
        let reported = problems[before.1..].iter().any(|d| d.severity == Severity::Error);
        if found.is_empty() && !reported {
            problems.push(nothing_found(&label, adapters));
        }
        sources.extend(found);
    }
    (sources, problems)
}

/// Reads one source: its drive, or that of its first ego where it has several.
pub fn read(source: &Source, options: &Options) -> (Option<Drive>, SourceReport) {
    let mut first = None;
    let mut each = |drive, report| {
        first.get_or_insert((drive, report));
    };
    let mut sink = DriveSink::new(&|_, _| false, &mut each).with_map(options);
    source.adapter.0.read(source, options, &mut sink);
    first.unwrap_or_else(|| (None, SourceReport::new(source.path.display().to_string())))
}

/// Reads a log from memory: its drives, each with its report; none where the format reads from disk only.
pub fn read_files(
    format: AdapterRef,
    files: &FilesInMemory,
    options: &Options,
) -> Vec<(Option<Drive>, SourceReport)> {
    let mut out = Vec::new();
    let mut each = |drive, report| out.push((drive, report));
    format.0.read_files(files, options, &mut DriveSink::new(&|_, _| false, &mut each));
    out
}

/// The sources in their order, cut into those that are read together.
pub fn batches(sources: &[Source]) -> impl Iterator<Item = &[Source]> {
    let together =
        |a: &Source, b: &Source| a.adapter.0.batch_size() > 1 && (a.adapter, &a.path) == (b.adapter, &b.path);
    sources.chunk_by(together).flat_map(|alike| alike.chunks(alike[0].adapter.0.batch_size()))
}

/// Reads a batch of sources and writes their drives, one at a time; a simulation has one per ego. `each` gets one
/// complete report per drive; a drive that is not in the lake has no `outcome`. Drives that the lake holds already are
/// not made again: an interrupted ingest, also one interrupted inside a source, continues where it was.
pub fn ingest_each(batch: &[Source], options: &Options, lake: &Lake, each: &mut dyn FnMut(SourceReport)) {
    let Some(source) = batch.first() else { return };
    // The source that is being read.
    let current = Cell::new(source.path.as_path());
    let mut keep = |drive: Option<Drive>, mut report: SourceReport| {
        let origin = Origin::new(current.get(), &report.source);
        let is_stated = |drive: &Drive| options.drive_id.as_ref() == Some(&drive.meta.drive_id);
        if let Some(refused) = drive.as_ref().filter(|d| is_stated(d)).and_then(|d| origin.refuse_id(d, lake))
        {
            report.diagnostics.push(refused);
        } else if let Some(mut drive) = drive {
            report.diagnostics.extend(origin.claim_id(&mut drive, lake));
            write(&drive, &origin, &mut report, lake);
        } else if let Some(id) = &report.drive_id
            && let Ok(drive) = lake.read_drive(id)
        {
            origin.complete(id, lake);
            describe(&drive, &mut report);
            report.outcome = Some(WriteOutcome::Unchanged);
        }
        each(report);
    };
    // A drive that cannot be read completely is made again.
    let holds = |id: &DriveId, hash: &str| lake.read_drive(id).is_ok_and(|d| d.meta.content_hash == hash);
    for alike in batches(batch) {
        current.set(alike[0].path.as_path());
        let mut sink = DriveSink::new(&holds, &mut keep).with_map(options);
        alike[0].adapter.0.read_batch(alike, options, &mut sink);
    }
}

/// [`ingest_each`] for a source with one drive: the report of the first.
pub fn ingest(source: &Source, options: &Options, lake: &Lake) -> SourceReport {
    let mut first = None;
    ingest_each(std::slice::from_ref(source), options, lake, &mut |report| {
        first.get_or_insert(report);
    });
    first.unwrap_or_else(|| SourceReport::new(source.path.display().to_string()))
}

/// Size of a drive, for its report.
fn describe(drive: &Drive, report: &mut SourceReport) {
    report.drive_id = Some(drive.meta.drive_id.clone());
    report.frames = drive.frame_count();
    // As `lake list`, `inspect` and reports state it: each frame lasts a tenth of a second.
    report.duration_s = drive.frame_count() as f64 / FRAME_RATE_HZ;
    report.tracks = drive.tracks.len();
    report.missing = drive.meta.missing.clone();
}

fn write(drive: &Drive, origin: &Origin, report: &mut SourceReport, lake: &Lake) {
    describe(drive, report);
    match lake.write_drive_with(drive, &[origin.note()]) {
        Ok(outcome) => {
            report.outcome = Some(outcome);
            origin.complete(&drive.meta.drive_id, lake);
        }
        Err(e) => report.diagnostics.push(e.diagnostic()),
    }
}

fn not_there(path: &str) -> Diagnostic {
    Diagnostic::error(
        "ingest.path.missing",
        Bilingual::new(format!("{path} 不存在"), format!("{path} does not exist")),
    )
    .in_file(path)
}

fn nothing_found(path: &str, adapters: &[AdapterRef]) -> Diagnostic {
    let names: Vec<&str> = adapters.iter().map(|a| a.0.name()).collect();
    let names = names.join(", ");
    Diagnostic::error(
        "ingest.nothing_found",
        Bilingual::new(
            format!("{path} 中没有可识别的行程（已尝试：{names}）"),
            format!("nothing in {path} looks like a drive (tried: {names})"),
        ),
    )
    .with_hint(Bilingual::new(
        "docs/reference/formats.zh.md 说明各格式需要哪些文件；自有的表用 `whyroad ingest table --mapping` 导入",
        "docs/reference/formats.md says which files each format needs; tables of your own are read by \
         `whyroad ingest table --mapping`",
    ))
    .in_file(path)
}
