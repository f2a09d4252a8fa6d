//! The whole framework as one value, from the texts of `schema/`, `scenarios/` and `prompts/`.

mod load;

use crate::{
    Calibration, DecisionSets, DecisionTable, DraftTexts, LabelWords, Lexicon, Prompts, RecordTypes,
    ResolvedSpec, Taxonomy,
};
use include_dir::{Dir, include_dir};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use whyroad_model::yaml::{Mark, Node};
use whyroad_model::{Diagnostic, ScenarioId};

/// Classes, decisions, labeling specs, rule sources, and the texts that other crates parse.
#[derive(Clone, Debug, Default)]
pub struct Framework {
    /// The classes.
    pub taxonomy: Taxonomy,
    /// The decisions in words.
    pub decisions: DecisionSets,
    /// One spec a leaf, inheritance applied.
    pub specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One spec an L1 whose default is whole.
    pub l1_specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One spec an L2 that has any, for what is known to be of that L2 and of no leaf in particular.
    pub l2_specs: BTreeMap<ScenarioId, ResolvedSpec>,
    /// One `mining:` block an L2 or leaf that has one, in taxonomy order, an L2 before its leaves.
    pub rules: Vec<RuleSource>,
    /// Every expression of the labeling specs as written, in the order of the files.
    pub expressions: Vec<ExpressionSource>,
    /// Version that each file of `scenarios/` states, by relative path.
    pub spec_versions: BTreeMap<String, String>,
    /// What reads and judges the texts of labels.
    reading: Reading,
    /// What the required records may hold.
    pub record_types: RecordTypes,
    /// Texts of label drafts.
    pub draft_texts: DraftTexts,
    /// What language models are asked.
    pub prompts: Prompts,
    /// How often mined episodes are right; without the file, no class is calibrated.
    pub calibration: Calibration,
    /// Text of `schema/signals.yaml`, which whyroad-signals parses; empty when the file is absent.
    pub signals_yaml: String,
    /// Text of `schema/precedence.yaml`, which whyroad-mining parses; empty when the file is absent.
    pub precedence_yaml: String,
}

/// What reads and judges the texts of labels. The words fill a fifth of a second of every start, and most commands read
/// no label: those of the program itself, which a test holds free of findings, are compiled when first asked for.
#[derive(Clone, Debug)]
enum Reading {
    Bundled(OnceLock<Box<ReadingTables>>),
    Read(Box<ReadingTables>),
}

impl Default for Reading {
    fn default() -> Self {
        Self::Read(Box::default())
    }
}

/// Tables that reading the texts of labels needs.
#[derive(Clone, Debug, Default)]
pub struct ReadingTables {
    /// Words that name decisions in a trace.
    pub lexicon: Lexicon,
    /// Words of a label's texts.
    pub label_words: LabelWords,
    /// Which decisions each leaf goes with; its causes are kinds of the words.
    pub decision_table: DecisionTable,
}

/// A mining rule as written, of a leaf or of an L2. whyroad-mining gives it meaning.
#[derive(Clone, Debug)]
pub struct RuleSource {
    /// Which leaf, or which L2.
    pub leaf: ScenarioId,
    /// `scenarios/<l1>/<l2>.yaml`.
    pub file: String,
    /// The `mining:` block; every part of it knows its position.
    pub rule: Node,
    /// Position of the block's key.
    pub mark: Mark,
    /// The whole file, from which faults are shown.
    pub text: Arc<str>,
}

/// An `expr` of a labeling spec as written: a moment of the rule language. whyroad-mining gives it meaning.
#[derive(Clone, Debug)]
pub struct ExpressionSource {
    /// The class whose labeling it belongs to: an L1, an L2 or a leaf.
    pub class: ScenarioId,
    /// `scenarios/<l1>.yaml` or `scenarios/<l1>/<l2>.yaml`.
    pub file: String,
    /// The expression: a scalar that knows its position and pointer.
    pub expression: Node,
    /// The whole file, from which faults are shown.
    pub source: Arc<str>,
}

impl ExpressionSource {
    /// The expression's text.
    pub fn text(&self) -> &str {
        self.expression.text().unwrap_or_default().trim()
    }
}

static SCHEMA: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../schema");
static PROMPTS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../prompts");
static SCENARIOS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../scenarios");

impl Framework {
    /// The framework that is built into this program. A test holds it free of findings.
    pub fn bundled() -> &'static Framework {
        static BUNDLED: OnceLock<Framework> = OnceLock::new();
        BUNDLED.get_or_init(|| load::bundled(&Framework::bundled_files()).unwrap_or_default())
    }

    /// Words that name decisions in a trace.
    pub fn lexicon(&self) -> &Lexicon {
        &self.reading().lexicon
    }

    /// Words of a label's texts.
    pub fn label_words(&self) -> &LabelWords {
        &self.reading().label_words
    }

    /// Which decisions each leaf goes with.
    pub fn decision_table(&self) -> &DecisionTable {
        &self.reading().decision_table
    }

    /// With other tables to read texts.
    pub fn with_reading(self, change: impl FnOnce(&mut ReadingTables)) -> Self {
        let mut tables = self.reading().clone();
        change(&mut tables);
        Self { reading: Reading::Read(Box::new(tables)), ..self }
    }

    fn reading(&self) -> &ReadingTables {
        match &self.reading {
            Reading::Read(tables) => tables,
            Reading::Bundled(tables) => tables.get_or_init(|| {
                Box::new(load::reading(&Self::bundled_files(), &self.taxonomy, &mut Vec::new()))
            }),
        }
    }

    /// The texts that [`Framework::bundled`] is made of, by relative path.
    pub fn bundled_files() -> BTreeMap<String, String> {
        let mut out = BTreeMap::new();
        collect(&SCHEMA, "schema", &mut out);
        collect(&SCENARIOS, "scenarios", &mut out);
        out.extend(Self::bundled_prompts());
        out
    }

    /// The texts of `prompts/`.
    fn bundled_prompts() -> BTreeMap<String, String> {
        let mut out = BTreeMap::new();
        collect(&PROMPTS, "prompts", &mut out);
        out
    }

    /// A framework from the texts of its files by relative path (`schema/...yaml`, `scenarios/...yaml`,
    /// `prompts/...yaml`).
    ///
    /// `None` only when there is no usable taxonomy; otherwise what could be read, with everything that is
    /// wrong in it.
    pub fn from_files(files: &BTreeMap<String, String>) -> (Option<Framework>, Vec<Diagnostic>) {
        load::load(files)
    }

    /// The rule of this leaf, where there is one.
    pub fn rule(&self, leaf: &ScenarioId) -> Option<&RuleSource> {
        self.rules.iter().find(|r| r.leaf == *leaf)
    }
}

fn collect(dir: &Dir<'_>, root: &str, out: &mut BTreeMap<String, String>) {
    for file in dir.files() {
        if let (Some(text), Some(path)) = (file.contents_utf8(), file.path().to_str()) {
            out.insert(format!("{root}/{}", path.replace('\\', "/")), text.to_owned());
        }
    }
    for sub in dir.dirs() {
        collect(sub, root, out);
    }
}
