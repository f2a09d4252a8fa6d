//! Work on the drives of a lake: on all cores, results in the order of the ids, and only some of them in memory.

use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};
use whyroad_lake::{Lake, LakeError};
use whyroad_model::{Bilingual, Diagnostic, DriveId, SignalTable};

/// Drives that are processed for each core before their results are handed on: memory use does not grow with the lake,
/// and a core that finishes early waits for the others once per this many drives.
const DRIVES_PER_CORE: usize = 32;

/// Calls `work` for each drive, from any thread, and passes the results to `each` in the order of the ids. An error of
/// `each` stops it. `jobs` bounds the drives in work at once (`None`: all cores).
pub fn map_drives<T: Send, E>(
    ids: &[DriveId],
    jobs: Option<usize>,
    work: impl Fn(&DriveId) -> T + Sync,
    mut each: impl FnMut(T) -> Result<(), E>,
) -> Result<(), E> {
    crate::memory::keep_freed();
    let pool = jobs.and_then(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().ok());
    let cores = pool.as_ref().map_or_else(rayon::current_num_threads, rayon::ThreadPool::current_num_threads);
    for some in ids.chunks(cores.max(1) * DRIVES_PER_CORE) {
        // Drives one by one: their sizes differ, and each is enough work.
        let all = || -> Vec<T> { some.par_iter().with_max_len(1).map(&work).collect() };
        let results = match &pool {
            Some(pool) => pool.install(all),
            None => all(),
        };
        results.into_iter().try_for_each(&mut each)?;
    }
    Ok(())
}

/// The signals of a whole drive: those that the lake stores, or derived and stored now. They contain the drive's
/// future; Stage I needs [`crate::recordings::LakeRecordings::signals`] of the drive cut at the keyframe.
pub fn signals_of(lake: &Lake, id: &DriveId) -> Result<SignalTable, LakeError> {
    if let Some(file) = lake.signals(id, whyroad_signals::VERSION)?
        && let Ok(table) = file.read_table(0)
    {
        return Ok(table);
    }
    let table = derived_signals(lake, id)?;
    // A lake that cannot be written can still be read: the next command derives again.
    let _ = lake.write_signals(id, whyroad_signals::VERSION, &table);
    Ok(table)
}

/// The signals of a whole drive, derived from its scene tables; nothing is stored.
pub(crate) fn derived_signals(lake: &Lake, id: &DriveId) -> Result<SignalTable, LakeError> {
    Ok(whyroad_signals::derive(&lake.read_drive(id)?))
}

/// Derives and stores the signals of every drive that has none stored by this version, as `mine` does on the way.
/// Returns the number of drives whose signals were derived, and an error for each drive that could not be read; where
/// they cannot be stored, one error of the file system.
pub fn derive_signals(
    lake: &Lake,
    jobs: Option<usize>,
    done: impl Fn(&DriveId) + Sync,
) -> (usize, Vec<Diagnostic>) {
    let refused: Mutex<Option<LakeError>> = Mutex::default();
    let one = |id: &DriveId| -> Result<usize, Box<Diagnostic>> {
        let derive = || -> Result<usize, LakeError> {
            if lake.signals(id, whyroad_signals::VERSION)?.is_some() {
                return Ok(0);
            }
            let table = derived_signals(lake, id)?;
            let stored = lake.write_signals(id, whyroad_signals::VERSION, &table);
            if let Err(e) = stored {
                refused.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(e);
                return Ok(0);
            }
            Ok(1)
        };
        let derived = derive().map_err(|e| unreadable(id, &e));
        done(id);
        derived
    };
    let (mut derived, mut errors) = (0, Vec::new());
    let kept: Result<(), std::convert::Infallible> = map_drives(&lake.drive_ids(), jobs, one, |result| {
        match result {
            Ok(n) => derived += n,
            Err(d) => errors.push(*d),
        }
        Ok(())
    });
    let Ok(()) = kept;
    let refused = refused.into_inner().unwrap_or_else(PoisonError::into_inner);
    errors.extend(refused.map(|e| e.diagnostic()));
    if let Err(e) = lake.publish() {
        errors.push(e.diagnostic());
    }
    (derived, errors)
}

/// The diagnostic of a drive that cannot be read and is skipped.
pub(crate) fn unreadable(id: &DriveId, e: &LakeError) -> Box<Diagnostic> {
    let cause = e.diagnostic();
    let message = Bilingual::new(
        format!("行程 {id} 无法读取，已跳过：{}", cause.message.zh),
        format!("drive {id} cannot be read and is left out: {}", cause.message.en),
    );
    let d = Diagnostic::error("mine.drive.unreadable", message).at(cause.location);
    Box::new(match cause.hint {
        Some(hint) => d.with_hint(hint),
        None => d,
    })
}
