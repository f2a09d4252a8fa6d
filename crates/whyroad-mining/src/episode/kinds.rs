//! What a drive shows of the kind of object that a rule is about. Cars with sizes say nothing of animals that have
//! none.

use crate::language::program::Subject;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::signal::{TargetSpan, is_of_object};
use whyroad_model::{Need, ObjectClass, SignalTable};
use whyroad_signals::catalog::Catalog;

/// The objects of a drive, and what is known of them in part only.
#[derive(Clone, Copy, Debug)]
pub struct Kinds<'a> {
    /// The objects.
    pub targets: &'a [TargetSpan],
    /// As [`SignalTable::partial`].
    pub partial: &'a BTreeMap<String, Vec<Need>>,
    /// As [`SignalTable::without_boxes`].
    pub without_boxes: &'a BTreeSet<ObjectClass>,
}

impl<'a> Kinds<'a> {
    /// Those of a table.
    pub fn of(table: &'a SignalTable) -> Self {
        Self { targets: &table.targets, partial: &table.partial, without_boxes: &table.without_boxes }
    }

    /// Whether a signal, which the drive has, shows all that it is about; of a signal of objects, for those that
    /// `subject` admits.
    pub fn shown_to(self, subject: Option<Subject>) -> impl Fn(&str) -> bool + use<'a> {
        let mut admitted =
            self.targets.iter().map(|t| t.class).filter(|c| subject.is_some_and(|s| s.admits(*c)));
        let boxed = admitted.next().is_none_or(|first| {
            std::iter::once(first).chain(admitted).any(|class| !self.without_boxes.contains(&class))
        });
        move |signal: &str| {
            let partial = self.partial.get(signal).map(Vec::as_slice);
            if is_of_object(signal) && needs_sizes(signal) {
                boxed && matches!(partial, None | Some([Need::ObjectSizes]))
            } else {
                partial.is_none()
            }
        }
    }
}

fn needs_sizes(signal: &str) -> bool {
    Catalog::bundled().get(signal).is_some_and(|def| def.needs.contains(&Need::ObjectSizes))
}
