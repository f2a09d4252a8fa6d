//! The framework as data: text in, validated taxonomy, decisions, labeling specs and rule sources out.
//!
//! Nothing here reads a file or a clock: callers pass texts, or take the copy that is built in. Mining rules
//! are carried, not interpreted.

pub mod calibration;
pub mod check;
pub mod codes;
pub mod decision_table;
pub mod decisions;
pub mod diff;
pub mod docs;
pub mod draft_texts;
pub mod framework;
pub mod json_text;
pub mod label_words;
pub mod lexicon;
pub mod listing;
pub mod mapping;
pub mod markdown;
pub mod phrases;
pub mod prompts;
pub mod record_types;
pub mod schemas;
pub mod spec;
pub mod taxonomy;
pub mod version;
pub mod yaml_text;

pub use calibration::Calibration;
pub use decision_table::DecisionTable;
pub use decisions::DecisionSets;
pub use draft_texts::DraftTexts;
pub use framework::{ExpressionSource, Framework, FrameworkFiles, ReadingTables, RuleSource};
pub use label_words::LabelWords;
pub use lexicon::Lexicon;
pub use prompts::{Prompt, PromptName, Prompts};
pub use record_types::RecordTypes;
pub use spec::ResolvedSpec;
pub use taxonomy::{L1, L2, L3, Resolution, Taxonomy};
