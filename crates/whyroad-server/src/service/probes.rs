//! The questions of the probes of a service, one at a time each: see [`crate::service::figures`], which asks them.

use crate::metrics::StoreFigures;
use crate::service::bounded::Bounded;
use std::sync::Arc;

/// What the probes of a service ask.
#[derive(Default)]
pub struct Probes {
    /// Whether the store answers, or its error code.
    pub(crate) store: Arc<Bounded<Result<(), &'static str>>>,
    /// Whether the recordings can be read.
    pub(crate) lake: Arc<Bounded<bool>>,
    /// The figures of the store.
    pub(crate) figures: Arc<Bounded<Option<StoreFigures>>>,
}
