//! Documents that are checked together: on all cores and drive by drive, whatever their order, so that each drive is
//! read once for a batch. What was found is reported in the order of the input.

use super::input::How;
use rayon::prelude::*;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use whyroad_engine::label_drives::drive_of_clip;
use whyroad_framework::check::{Document, Origin, Piece, Problem};
use whyroad_model::{Diagnostic, DriveId};

/// Maximum text of a batch where labels are compared with drives: some 40,000 labels. The more labels of a drive are in
/// a batch, the less often it is read.
pub(super) const WITH_DRIVES: usize = 48 << 20;
/// The same where they are not: enough for all cores.
pub(super) const ALONE: usize = 1 << 20;
/// What a step takes besides its text, about.
const STEP_BYTES: usize = 128;
/// Maximum number of documents of one drive that one core checks after another.
const TOGETHER: usize = 512;
/// Findings of a batch from which on the rest of it is checked one by one as it is reported, so that they do not
/// fill the memory.
const MOST_FINDINGS: usize = 200_000;

/// A step of reading the input.
pub(super) enum Step {
    /// A file begins.
    Begin { name: String, how: How },
    /// A document in it.
    Document { origin: Origin, bytes: Vec<u8> },
    /// A problem between two documents.
    Problem(Problem, Origin),
    /// The file ends.
    End(io::Result<()>),
    /// An input that is not a file.
    Other { name: String, found: Diagnostic },
}

/// The steps of some of the input.
pub(super) struct Batch {
    steps: Vec<Step>,
    bytes: usize,
    most: usize,
}

impl Batch {
    /// An empty one for this many bytes.
    pub fn new(most: usize) -> Self {
        Self { steps: Vec::new(), bytes: 0, most }
    }

    /// What is in it; it is empty afterwards.
    pub fn take(&mut self) -> Self {
        std::mem::replace(self, Self::new(self.most))
    }

    pub fn push(&mut self, step: Step) {
        self.bytes += STEP_BYTES + if let Step::Document { bytes, .. } = &step { bytes.len() } else { 0 };
        self.steps.push(step);
    }

    pub fn piece(&mut self, piece: &Piece<'_>) {
        self.push(match piece {
            Piece::Document(d) => Step::Document { origin: d.origin.clone(), bytes: d.bytes.to_vec() },
            Piece::Problem(problem, origin) => Step::Problem(*problem, origin.clone()),
        });
    }

    pub fn is_full(&self) -> bool {
        self.bytes >= self.most
    }

    /// The steps, each document with the result of `check`. `findings`: how many a result has.
    pub fn checked<T: Send>(
        self,
        check: &(dyn Fn(&Document<'_>) -> T + Sync),
        findings: fn(&T) -> usize,
    ) -> impl Iterator<Item = (Step, Option<T>)> {
        let found = AtomicUsize::new(0);
        let one = |&i: &usize| -> Option<(usize, T)> {
            if found.load(Ordering::Relaxed) > MOST_FINDINGS {
                return None;
            }
            let result = check(&self.steps[i].document()?);
            found.fetch_add(findings(&result), Ordering::Relaxed);
            Some((i, result))
        };
        let groups = self.groups();
        let mut results: Vec<(usize, T)> =
            groups.par_iter().with_max_len(1).flat_map_iter(|group| group.iter().filter_map(one)).collect();
        results.sort_unstable_by_key(|(i, _)| *i);
        let mut results = results.into_iter().peekable();
        self.steps.into_iter().enumerate().map(move |(i, step)| {
            let result = results.next_if(|(of, _)| *of == i).map(|(_, result)| result);
            let result = result.or_else(|| Some(check(&step.document()?)));
            (step, result)
        })
    }

    /// The documents by the drives that their labels name, each in the order of the input.
    fn groups(&self) -> Vec<Vec<usize>> {
        let drive = |step: &Step| match step {
            Step::Document { bytes, .. } => Some(drive_of(bytes)),
            _ => None,
        };
        let mut all: Vec<(Option<DriveId>, usize)> =
            self.steps.iter().enumerate().filter_map(|(i, step)| Some((drive(step)?, i))).collect();
        all.sort_unstable();
        let of_one = all.chunk_by(|a, b| a.0 == b.0);
        of_one.flat_map(|d| d.chunks(TOGETHER)).map(|d| d.iter().map(|(_, i)| *i).collect()).collect()
    }
}

impl Step {
    fn document(&self) -> Option<Document<'_>> {
        let Self::Document { origin, bytes } = self else { return None };
        Some(Document { origin: origin.clone(), bytes })
    }
}

/// The drive of the first clip that the text names. Only the order of the work depends on it.
fn drive_of(text: &[u8]) -> Option<DriveId> {
    const KEY: &[u8] = b"\"clip_id\"";
    let at = text.windows(KEY.len()).position(|w| w == KEY)? + KEY.len();
    let mut parts = text[at..].splitn(3, |b| *b == b'"');
    let clip = parts.nth(1)?;
    drive_of_clip(std::str::from_utf8(clip).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(texts: &[&str]) -> Batch {
        let mut batch = Batch::new(ALONE);
        batch.push(Step::Begin { name: "a".into(), how: How::Named });
        for text in texts {
            batch.piece(&Piece::Document(Document { origin: Origin::start(), bytes: text.as_bytes() }));
        }
        batch.push(Step::End(Ok(())));
        batch
    }

    #[test]
    fn documents_are_grouped_by_drive_and_reported_in_order() {
        let texts = [
            r#"{"clip_id":"b_000"}"#,
            r#"{ "x": 1, "clip_id" : "a_001" }"#,
            "no label",
            r#"{"clip_id":"b_k000050"}"#,
            r#"{"clip_id": 7}"#,
            r#"{"clip_id":"a_000"}"#,
        ];
        assert_eq!(batch(&texts).groups(), [vec![3, 5], vec![2, 6], vec![1, 4]]);
        let check = |d: &Document<'_>| String::from_utf8(d.bytes.to_vec()).unwrap();
        for findings in [|_: &String| 1, |_: &String| MOST_FINDINGS] {
            let seen: Vec<_> = batch(&texts).checked(&check, findings).collect();
            assert!(matches!(seen[0], (Step::Begin { .. }, None)) && matches!(seen[7], (Step::End(_), None)));
            let seen: Vec<_> = seen.into_iter().filter_map(|(_, text)| text).collect();
            assert_eq!(seen, texts);
        }
    }

    #[test]
    fn many_documents_of_one_drive_are_divided() {
        let texts = vec![r#"{"clip_id":"b_000"}"#; 2 * TOGETHER + 1];
        assert_eq!(batch(&texts).groups().iter().map(Vec::len).collect::<Vec<_>>(), [TOGETHER, TOGETHER, 1]);
    }
}
