//! What the service needs of a language model: drafts and judgments. Handed in by the caller, so that this crate calls
//! no model, knows no prompt and holds no key.

use std::sync::Arc;
use whyroad_label::judged::JudgedLabel;
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{Bilingual, Lang, ModelSpent};

/// Why a draft or a judgment was not made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelFailure {
    /// For people; never the endpoint's key.
    pub text: Bilingual,
    /// No further question of this run can be answered: the budget is used up, or the endpoint refuses the key.
    pub ends_the_run: bool,
}

/// A model at some endpoint.
pub trait LanguageModel: Send + Sync {
    /// Its name: drafts and judgments are marked with it.
    fn name(&self) -> &str;

    /// Questions that are put at once.
    fn at_once(&self) -> usize;

    /// Begins a run, or goes on with one that had spent so much before the service was restarted: its budget counts
    /// that.
    fn begin(&self, spent: &ModelSpent) -> Result<Arc<dyn ModelSession>, Bilingual>;
}

/// One run: counts what it spends.
pub trait ModelSession: Send + Sync {
    /// The draft of an episode. Its components are made from the drive cut at the keyframe.
    fn draft(&self, episode: &EpisodeRecord, lang: Lang) -> Result<CocLabel, ModelFailure>;

    /// True/false questions about a label with the model's answers, and whether people are to answer them, too.
    fn judge(&self, label: &CocLabel, lang: Lang) -> Result<JudgedLabel, ModelFailure>;

    /// What was spent since the run began here.
    fn spent(&self) -> ModelSpent;
}
