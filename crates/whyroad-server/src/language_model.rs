//! Interface to a language model: drafts and judgments. The caller provides it, so this crate calls no model, knows no
//! prompt and holds no key.

use std::sync::Arc;
use whyroad_label::judged::JudgedLabel;
use whyroad_model::messages::{CocLabel, EpisodeRecord};
use whyroad_model::{Bilingual, Lang, ModelSpent};

/// Why a draft or a judgment was not created.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelFailure {
    /// For people; never the endpoint's key.
    pub text: Bilingual,
    /// No further question of this run can be answered: the budget is used up, or the endpoint rejects the key.
    pub ends_the_run: bool,
}

/// A model at some endpoint.
pub trait LanguageModel: Send + Sync {
    /// Its name, which marks drafts and judgments.
    fn name(&self) -> &str;

    /// Number of concurrent questions.
    fn at_once(&self) -> usize;

    /// Starts a run, or resumes one that had this cost before the service was restarted: its budget includes that.
    fn begin(&self, spent: &ModelSpent) -> Result<Arc<dyn ModelSession>, Bilingual>;
}

/// One run: counts its cost.
pub trait ModelSession: Send + Sync {
    /// The draft of an episode. Its components are computed from the drive cut at the keyframe.
    fn draft(&self, episode: &EpisodeRecord, lang: Lang) -> Result<CocLabel, ModelFailure>;

    /// True/false questions about a label with the model's answers, and whether people are to answer them, too.
    fn judge(&self, label: &CocLabel, lang: Lang) -> Result<JudgedLabel, ModelFailure>;

    /// Cost since the run started here.
    fn spent(&self) -> ModelSpent;
}
