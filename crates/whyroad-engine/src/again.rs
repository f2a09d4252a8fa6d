//! Mining into a folder that holds an earlier answer to the same question: only drives that are new or have changed
//! are opened, the lines of the others are copied. The files are the same byte for byte as those of a run without an
//! earlier one.
//!
//! Criteria, drive by drive:
//!
//! - *Unchanged*: the drive is in the same place (its folder, or its row of a pack), and the identity of `drive.json`
//!   (or the pack's `drives.parquet`) and of all its scene tables is unchanged: length, time of change and file number,
//!   or the hash of the content in an object store.
//! - *Moved* (packed, or the lake was copied): the identity differs, but `drive.json` is identical byte by byte and has
//!   a hash of the drive's content. Stored signals and results use that hash, too.
//! - *Changed in place*: a table is another file while `drive.json` is unchanged, so its hash of the content is not
//!   valid. Signals and results that are stored beside the drive are made again.
//! - Everything else, and a drive that could not be read, is opened as in a first run. A drive that is no longer in the
//!   lake is not copied.

use crate::drives::map_drives;
use crate::mine::{MineOptions, MinedDrive, Miner};
use crate::output::{FolderWriter, KnownDrive, SameDrive};
use crate::parts::{Request, Versions};
use whyroad_framework::{Framework, Taxonomy};
use whyroad_lake::mined::{Ledger, MinedWriteError};
use whyroad_lake::{Fingerprints, Lake, MinedFolder};
use whyroad_mining::RuleSet;
use whyroad_model::{Diagnostic, DriveId};

/// Hash of the code that makes lines of episodes.
const CODE: &str = env!("WHYROAD_ENGINE_VERSION");

/// Everything besides the drives that the lines of a mined folder depend on: question, language, clips, rules,
/// calibration, classes, and the versions of the code.
pub fn state(request: &Request, taxonomy: &Taxonomy, rules: &RuleSet) -> String {
    let mut request = request.clone();
    // A limit removes none of the lines; results are made again from all of them.
    request.questions.iter_mut().for_each(|q| q.limit = None);
    let mut hasher = blake3::Hasher::new();
    let parts = [
        serde_json::to_string(&request).unwrap_or_default(),
        format!("{:?}", Versions::of(taxonomy, rules, rules)),
        Framework::bundled().signals_yaml.clone(),
        CODE.to_owned(),
    ];
    for part in &parts {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

/// Results of an earlier run in a folder; `None` where they cannot be reused.
pub fn earlier(folder: &std::path::Path, state: &str) -> Option<Ledger> {
    Ledger::open(&MinedFolder::open(folder)?, state)
}

/// Result of a run into a folder.
#[derive(Debug, Default)]
pub struct MinedAgain {
    /// Drives that were not opened, because they have not changed.
    pub same: usize,
    /// An error for each drive that could not be read.
    pub diagnostics: Vec<Diagnostic>,
}

/// Handling of a drive.
enum Step {
    Same(SameDrive),
    Mined(MinedDrive, KnownDrive),
    Failed(DriveId, Box<Diagnostic>),
}

/// Mines every drive of the lake into a folder that keeps a ledger ([`FolderWriter::keep_ledger`]), in the order of
/// their ids. `done` is called after each drive, from any thread; `answer` reduces a drive's results to those that the
/// question requests.
///
/// # Errors
/// Where the folder cannot be written.
pub fn mine_into(
    folder: &mut FolderWriter,
    earlier: Option<&Ledger>,
    (lake, rules, options): (&Lake, &RuleSet, &MineOptions),
    done: impl Fn(&DriveId) + Sync,
    answer: impl Fn(MinedDrive) -> MinedDrive + Sync,
) -> Result<MinedAgain, MinedWriteError> {
    let (miner, fingerprints) = (Miner::new(lake, rules, options), lake.fingerprints());
    let one = |id: &DriveId| {
        let step = step(id, earlier, lake, &fingerprints, &miner);
        done(id);
        match step {
            Step::Mined(drive, known) => Step::Mined(answer(drive), known),
            step => step,
        }
    };
    let mut out = MinedAgain::default();
    map_drives(&lake.drive_ids(), options.jobs, one, |step| match (step, earlier) {
        (Step::Same(same), Some(earlier)) => {
            out.same += 1;
            folder.add_same(earlier, same)
        }
        (Step::Mined(drive, known), _) => folder.add_known(&drive, known),
        (Step::Failed(id, d), _) => {
            folder.leave_out(&id, d.code);
            out.diagnostics.push(*d);
            Ok(())
        }
        (Step::Same(_), None) => Ok(()),
    })?;
    out.diagnostics.extend(miner.published().or_else(|| miner.unwritable()));
    Ok(out)
}

fn step(
    id: &DriveId,
    earlier: Option<&Ledger>,
    lake: &Lake,
    fingerprints: &Fingerprints<'_>,
    miner: &Miner<'_>,
) -> Step {
    // Before the drive is read: the ledger never names a newer drive than the one whose lines it has.
    let now = fingerprints.of(id).unwrap_or_default();
    let mined = |mined: Result<MinedDrive, Box<Diagnostic>>, stated: Option<String>| match mined {
        Ok(drive) => Step::Mined(drive, KnownDrive { fingerprint: now.clone(), stated }),
        Err(d) => Step::Failed(id.clone(), d),
    };
    let Some((ledger, at)) = earlier.and_then(|l| Some((l, l.find(id)?))) else {
        let stated = lake.stated(id);
        return mined(miner.drive(id), stated);
    };
    let was = &ledger.entries[at];
    let same_head =
        was.fingerprint.place == now.place && was.fingerprint.head == now.head && !now.head.is_empty();
    let stated = if same_head { was.stated.clone() } else { lake.stated(id) };
    if same_head && was.fingerprint.tables != now.tables {
        return mined(miner.drive_afresh(id), stated);
    }
    let same = same_head || (stated.is_some() && stated == was.stated);
    let read =
        || SameDrive::read(ledger, at, KnownDrive { fingerprint: now.clone(), stated: stated.clone() });
    match same.then(read).flatten() {
        Some(same) => Step::Same(same),
        None => mined(miner.drive(id), stated),
    }
}
