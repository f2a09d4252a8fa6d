//! A worker: mines the drives of a list into a part folder, and continues where an earlier worker was killed.
//!
//! A drive on which the program dies (out of memory, a signal) leaves a line for its start and none for its end. The
//! next worker does such suspects last and one by one, so that a later crash has one possible cause; a drive that was
//! in work at [`PartOptions::deaths`] crashes is set aside and reported.

use super::folder::{DRIVES, FORMAT, Failed, LOCK, Line, PART, PartError, Progress, Seal, WORK, Work};
use super::folder::{broken, hash, io, read_json, write_json};
use super::wire::Exact;
use super::{Request, Versions, WorkList};
use crate::drives::map_drives;
use crate::mine::{MineOptions, MinedDrive, Miner};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_model::{Bilingual, Diagnostic, DriveId};

/// How a worker runs.
#[derive(Clone, Copy, Debug)]
pub struct PartOptions {
    /// How drives are mined.
    pub mine: MineOptions,
    /// A drive that was in work at this many crashes of a worker is set aside.
    pub deaths: usize,
    /// Start again, ignoring the contents of the folder.
    pub restart: bool,
}

/// Result of a worker.
#[derive(Clone, Debug, Default)]
pub struct Worked {
    /// Drives of the list with results.
    pub drives: usize,
    /// Of these, finished by an earlier worker.
    pub resumed: usize,
    /// Drives set aside, by id.
    pub failed: Vec<Failed>,
    /// Other diagnostics.
    pub diagnostics: Vec<Diagnostic>,
}

/// Mines the drives of `list` into the part folder `out`. `done` is called after each drive, from any thread; `answer`
/// reduces a drive's results to those that the question requests.
pub fn work(
    lake: &Lake,
    rules: &RuleSet,
    (versions, request, list): (Versions, Request, WorkList),
    options: &PartOptions,
    out: &Path,
    done: impl Fn(&DriveId) + Sync,
    answer: impl Fn(MinedDrive) -> MinedDrive + Sync,
) -> Result<Worked, PartError> {
    fs::create_dir_all(out).map_err(io(out))?;
    let _lock = lock(out)?;
    let work = Work { format: FORMAT.to_owned(), versions, request, list };
    let lines = out.join(DRIVES);
    let progress = begin(out, &work, options.restart)?;
    let listed: Vec<DriveId> = work.list.drives.iter().map(|d| d.drive_id.clone()).collect();
    let journal = Journal::open(&lines, &progress)?;
    let resumed = progress.done.len();

    let open: Vec<&DriveId> = listed
        .iter()
        .filter(|id| !progress.done.contains_key(id) && !progress.failed.contains_key(id))
        .collect();
    let deaths = |id: &DriveId| progress.begun.get(id).copied().unwrap_or(0);
    let (fresh, suspects): (Vec<_>, Vec<_>) = open.into_iter().cloned().partition(|id| deaths(id) == 0);
    let (guilty, mut suspects): (Vec<_>, Vec<_>) =
        suspects.into_iter().partition(|id| deaths(id) >= options.deaths.max(1));

    // The drive that was in work at most crashes is last: the others are finished before it can crash again.
    suspects.sort_by_key(|id| deaths(id));
    let miner = Miner::new(lake, rules, &options.mine);
    let one = |id: &DriveId| -> Result<(), PartError> {
        journal.put(&Line::Begun(id.clone()))?;
        let line = match miner.drive(id) {
            Ok(mined) => Line::Done {
                drive_id: id.clone(),
                content_hash: lake.content_hash(id).unwrap_or_default(),
                mined: Exact::of(&answer(mined)).map_err(|e| broken(&lines, e))?,
            },
            Err(d) => Line::Failed(Failed::of(id, &named(lake, id, *d))),
        };
        journal.put(&line)?;
        done(id);
        Ok(())
    };
    for id in &guilty {
        journal.put(&Line::Failed(Failed::of(id, &kills(id, deaths(id)))))?;
        done(id);
    }
    map_drives(&fresh, options.mine.jobs, one, |worked| worked)?;
    suspects.iter().try_for_each(one)?;

    journal.close()?;
    let progress = Progress::read(&lines)?;
    let seal = Seal { drives: progress.done.len(), failed: progress.failed.len(), hash: hash(&lines)? };
    write_json(&out.join(PART), &seal)?;
    Ok(Worked {
        drives: progress.done.len(),
        resumed,
        failed: progress.failed.into_values().collect(),
        diagnostics: miner.unwritable().into_iter().collect(),
    })
}

/// Only one worker writes a part: a second one, started by a scheduler that considers the first one dead, is refused.
fn lock(out: &Path) -> Result<File, PartError> {
    let path = out.join(LOCK);
    let file = File::create(&path).map_err(io(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(PartError::Busy(out.to_owned())),
        Err(TryLockError::Error(e)) => Err(io(&path)(e)),
    }
}

/// The results of an earlier worker for the same work; otherwise a new folder.
fn begin(out: &Path, work: &Work, restart: bool) -> Result<Progress, PartError> {
    let (header, lines) = (out.join(WORK), out.join(DRIVES));
    if header.exists() && !restart {
        if read_json::<Work>(&header)? != *work {
            return Err(PartError::OtherWork(out.to_owned()));
        }
        return Progress::read(&lines);
    }
    for name in [PART, DRIVES, WORK] {
        match fs::remove_file(out.join(name)) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(io(&out.join(name))(e)),
            _ => {}
        }
    }
    write_json(&header, work)?;
    Ok(Progress::default())
}

/// The lines that are written, by all threads.
struct Journal<'a> {
    path: &'a Path,
    file: Mutex<File>,
}

impl<'a> Journal<'a> {
    /// After the last complete line.
    fn open(path: &'a Path, progress: &Progress) -> Result<Self, PartError> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(io(path))?;
        file.set_len(progress.length).map_err(io(path))?;
        Ok(Self { path, file: Mutex::new(file) })
    }

    /// A line is written by one call, so it is complete unless the machine fails.
    fn put(&self, line: &Line) -> Result<(), PartError> {
        let mut text = serde_json::to_vec(line).map_err(|e| broken(self.path, e))?;
        text.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&text).map_err(io(self.path))
    }

    fn close(self) -> Result<(), PartError> {
        let file = self.file.into_inner().unwrap_or_else(PoisonError::into_inner);
        file.sync_all().map_err(io(self.path))
    }
}

/// A drive that a list names and the lake does not hold is a different error from one that cannot be read.
fn named(lake: &Lake, id: &DriveId, d: Diagnostic) -> Diagnostic {
    if !matches!(lake.size(id), Err(whyroad_lake::LakeError::DriveMissing(_))) {
        return d;
    }
    let message = Bilingual::new(
        format!("工作清单中的行程 {id} 不在数据湖中"),
        format!("drive {id} of the work list is not in the lake"),
    );
    Diagnostic::error("mine.drive.unknown", message)
}

fn kills(id: &DriveId, deaths: usize) -> Diagnostic {
    let message = Bilingual::new(
        format!("处理行程 {id} 时工作进程 {deaths} 次异常终止，已搁置"),
        format!("drive {id} is set aside: a worker crashed {deaths} times while working on it"),
    );
    Diagnostic::error("mine.drive.kills_worker", message)
}
