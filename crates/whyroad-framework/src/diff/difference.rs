//! One difference between two frameworks, before it is known for how many classes it holds.

use crate::version::Step;
use whyroad_model::Bilingual;

/// One difference between two specs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Difference {
    pub field: &'static str,
    pub before: Bilingual,
    pub after: Bilingual,
    pub step: Step,
}
