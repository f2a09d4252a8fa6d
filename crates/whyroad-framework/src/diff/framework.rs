//! Two whole frameworks: their classes, labeling specs and mining rules, and for each file that states a version
//! whether that version is high enough.

use super::{Change, ChangeKind, Moves, TaxonomyDiff, VersionCheck, diff, labelling, mining, tables};
use crate::Framework;
use crate::framework::{DECISION_TABLE, DECISIONS, RECORD_TYPES};
use crate::version::{Step, Version};
use serde::Serialize;

pub(super) const TAXONOMY: &str = "schema/scenario_taxonomy.yaml";

/// The version of one file, and the version that its changes require.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileVersion {
    /// Relative path.
    pub file: String,
    /// Version in A.
    pub from_version: String,
    /// Version in B.
    pub to_version: String,
    /// The smallest step that the changes of this file require.
    pub step: Step,
    /// Result for the two versions.
    pub version_check: VersionCheck,
}

impl FileVersion {
    pub(super) fn of(file: &str, from: &str, to: &str, step: Step) -> Self {
        let version_check = match (Version::parse(from), Version::parse(to)) {
            (Some(x), Some(y)) => match x.step_to(y) {
                None => VersionCheck::Backwards,
                Some(stated) if stated < step => VersionCheck::TooSmall,
                Some(_) => VersionCheck::Consistent,
            },
            _ => VersionCheck::Unknown,
        };
        let (file, from_version, to_version) = (file.to_owned(), from.to_owned(), to.to_owned());
        Self { file, from_version, to_version, step, version_check }
    }
}

/// Compares B with A in everything that affects labels and mining: classes, labeling specs, the tables of decisions and
/// records, mining rules.
pub fn diff_frameworks(a: &Framework, b: &Framework) -> TaxonomyDiff {
    let mut out = diff(&a.taxonomy, &b.taxonomy);
    let moves = Moves::of(&out.changes);
    let labelling = labelling::changes(a, b, &moves);
    let of_classes = labelling.into_iter().chain(mining::changes(a, b, &moves));
    let specs: Vec<Change> = of_classes.chain(tables::changes(a, b)).collect();
    out.files.extend(files(a, b, &specs));
    out.step = specs.iter().map(|c| c.step).chain([out.step]).max().unwrap_or_default();
    out.version_check = out.files.iter().map(|f| f.version_check).max().unwrap_or(VersionCheck::Unknown);
    out.changes.extend(specs);
    out
}

/// The file in which a change is written, with the files above it that the class inherits from.
fn written_in(change: &Change) -> Vec<String> {
    let table = match change.field {
        Some(
            tables::LONGITUDINAL
            | tables::LATERAL
            | tables::DECIDES
            | tables::ABOUT
            | tables::CAUSES
            | tables::PAIRS,
        ) => Some(DECISION_TABLE),
        Some(tables::RECORD_TYPE) => Some(RECORD_TYPES),
        _ if change.kind == ChangeKind::Decision => Some(DECISIONS),
        _ => None,
    };
    if let Some(table) = table {
        return vec![table.to_owned()];
    }
    let id = &change.id;
    let l1 = format!("scenarios/{}.yaml", id.l1);
    match &id.l2 {
        None => vec![l1],
        Some(l2) => vec![format!("scenarios/{}/{l2}.yaml", id.l1), l1],
    }
}

/// The files of these changes. A change may come from the class's own file or from the one it inherits from: it counts
/// for the file whose version was raised, or for the class's own file if neither was.
fn files(a: &Framework, b: &Framework, changes: &[Change]) -> Vec<FileVersion> {
    let stated = |f: &Framework, file: &str| f.spec_versions.get(file).or(f.file_versions.get(file)).cloned();
    let version = |f: &Framework, file: &str| stated(f, file).unwrap_or_default();
    let mut out: Vec<FileVersion> = Vec::new();
    for change in changes {
        let candidates = written_in(change);
        // A file that is new has no version to be raised.
        if candidates.first().is_some_and(|own| stated(a, own).is_none() && stated(b, own).is_some()) {
            continue;
        }
        let judged = candidates
            .iter()
            .map(|file| FileVersion::of(file, &version(a, file), &version(b, file), change.step));
        let Some(best) = judged.min_by_key(|v| v.version_check) else { continue };
        match out.iter_mut().find(|v| v.file == best.file) {
            Some(v) if v.step < best.step => *v = best,
            Some(_) => {}
            None => out.push(best),
        }
    }
    out.sort_by(|x, y| x.file.cmp(&y.file));
    out
}
