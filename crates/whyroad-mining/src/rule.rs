//! A rule: one program that defines when a scenario happens, and how its moments are found. Made from a
//! `mining:` block and the leaf's labeling spec ([`source`]) or from a JSON query ([`query`]).

mod block;
mod content;
pub mod file;
pub mod lint;
pub mod origin;
pub mod other;
pub mod query;
mod roles;
pub mod set;
pub mod sheet;
pub mod source;
pub mod text;

pub use set::{Precedence, RuleSet};

use crate::episode::score;
use crate::language::check::{PartText, Structure};
use crate::language::program::{Atom, Moment, NodeId, Op, Program, Subject};
use crate::language::{Checker, Expr, Fault};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::messages::KeyframeType;
use whyroad_model::signal::is_on_demand;
use whyroad_model::{Bilingual, Nanos, ScenarioId};

/// Codes of the diagnostics that this crate emits; each has a page in `docs/diagnostics/`.
pub const CODES: &[&str] = &[
    "rule.syntax",
    "rule.signal.unknown",
    "rule.unit.unknown",
    "rule.unit.mismatch",
    "rule.type",
    "rule.member.unknown",
    "rule.call",
    "rule.target",
    "rule.block",
    "rule.name",
    "rule.never",
    "rule.precedence",
    "rule.words",
    "rule.case",
    "rule.case.missing",
    "rule.case.skipped",
    "mine.drive.unreadable",
    "mine.drive.crashed",
    "mine.store.unwritable",
    "mine.query.syntax",
    "mine.query.scenario",
    "mine.scenario.no_rule",
];

pub use whyroad_model::ids::OTHER;

/// Name of the first role where the rule does not name it.
pub const TARGET: &str = "target";

/// An executable rule.
#[derive(Clone, Debug)]
pub struct Rule {
    /// The leaf, or the L2 where the rule does not determine the variant.
    pub scenario: ScenarioId,
    /// Kinds of the target; `None` when the rule is about the ego alone.
    pub subject: Option<Subject>,
    /// The rule's name for its target: `target`, or a name such as `lead`.
    pub target_role: String,
    /// The object that a rule binds besides its target.
    pub second: Option<SecondRole>,
    /// All operations of the rule and of its moments.
    pub program: Program,
    /// The condition whose runs of true are the matches.
    pub when: NodeId,
    /// Conditions at the keyframe.
    pub require: Vec<NodeId>,
    /// What counts as the ego's response to the trigger; `None` where the match is itself the ego's action.
    pub response: Option<ResponseCondition>,
    /// The parts of `when` and `require` that are shown to people.
    pub atoms: Vec<Atom>,
    /// The conditions, part by part, as shown to explain why the rule did not match.
    pub parts: Vec<Part>,
    /// Which atoms an episode lists.
    pub listed: Listed,
    /// Shorter matches are dropped, after merging.
    pub min_duration: Nanos,
    /// Longer matches are dropped.
    pub max_duration: Option<Nanos>,
    /// Matches of one target that are at most this far apart are merged.
    pub merge_gap: Nanos,
    /// Conditions that are displayed at length, by the definition that could have a name in `names`.
    pub lengthy: BTreeMap<String, Bilingual>,
    /// Keyframe, start, end, context.
    pub timing: Timing,
}

/// Signals that a rule about any object needs besides those derived for every drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnDemand {
    /// The `object.` and `pair.` signals.
    pub signals: BTreeSet<String>,
    /// All its other signals.
    pub others: BTreeSet<String>,
    /// It uses pairs of objects.
    pub pairs: bool,
}

/// The ego's response: searched from the match's start to the end of the time range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResponseCondition {
    /// The condition.
    pub condition: NodeId,
    /// It refers to the target: then it is known only while the target is observed.
    pub of_target: bool,
}

/// A part of a rule: one of the conditions that must hold together.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Where it must hold.
    pub place: PartPlace,
    /// As written, names replaced by their definitions.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Its truth.
    pub condition: NodeId,
    /// Its comparisons.
    pub atoms: Vec<Atom>,
    /// What it is made of.
    pub structure: Structure,
}

/// Where a part of a rule must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartPlace {
    /// At every frame of a match.
    When,
    /// At the keyframe.
    Require,
}

/// A second object that takes part: the rule is evaluated for every pair of a target and such an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SecondRole {
    /// The rule's name for it, such as `obstacle`.
    pub name: String,
    /// Its allowed kinds.
    pub subject: Subject,
}

/// Which atoms an episode lists as matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    /// Those that hold at the keyframe (a rule may have alternatives).
    Holding,
    /// All of them (the conditions of a query all hold together).
    All,
}

/// How the moments of an episode are found. Missing ones fall back, finally to the match itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// One moment or a range.
    pub kind: KeyframeType,
    /// The keyframe: each expression for it with its rule as text, the best first.
    pub keyframe: Vec<(Moment, Bilingual)>,
    /// Text for the fallback when none of these finds it: the start of the match.
    pub at_match_start: Bilingual,
    /// The second keyframe, the best expression first; unset without any, and where none finds it.
    pub second_keyframe: Vec<Moment>,
    /// Start of the time range, the best expression first.
    pub start: Vec<Moment>,
    /// End of the time range, the best expression first.
    pub end: Vec<Moment>,
    /// Context before the start.
    pub before: Nanos,
    /// Context after the end.
    pub after: Nanos,
    /// The context after the end stops here when this comes first.
    pub after_until: Option<Moment>,
}

impl Timing {
    /// The match itself, from its first to its last frame.
    pub fn of_match() -> Self {
        Self {
            kind: KeyframeType::Reactive,
            keyframe: vec![],
            at_match_start: Bilingual::new("匹配条件首次全部成立", "the conditions first hold together"),
            second_keyframe: vec![],
            start: vec![],
            end: vec![],
            before: Nanos::default(),
            after: Nanos::default(),
            after_until: None,
        }
    }
}

/// Displayed parts of a rule: its comparisons and conditions.
#[derive(Debug, Default)]
pub(crate) struct RuleParts {
    /// Each comparison once.
    pub atoms: Vec<Atom>,
    /// In the order in which they are written.
    pub parts: Vec<Part>,
}

impl RuleParts {
    /// Adds an expression that the checker has accepted.
    pub fn add(&mut self, checker: &mut Checker<'_>, expr: &Expr, place: PartPlace) -> Result<(), Fault> {
        checker.atoms(expr, &mut self.atoms)?;
        let mut parts = Vec::new();
        checker.parts(expr, &mut parts)?;
        let part = |p: PartText| Part {
            place,
            text: p.text,
            words: p.words,
            condition: p.condition,
            atoms: p.atoms,
            structure: p.structure,
        };
        self.parts.extend(parts.into_iter().map(part));
        Ok(())
    }
}

impl Rule {
    /// Score of a match whose margin is this: [`score`](crate::episode::score), and 0.5 for a rule that compares no
    /// numbers: then there is no margin.
    pub fn margin_score(&self, margin: f64) -> f64 {
        let mut roots = std::iter::once(&self.when).chain(&self.require);
        if roots.any(|id| self.program.compares_numbers(*id)) { score(margin) } else { score(0.0) }
    }

    /// Names of the signals that decide whether there is a match.
    pub fn signals(&self) -> BTreeSet<String> {
        self.program.signals_of(std::iter::once(&self.when).chain(&self.require).copied())
    }

    /// The signals that are derived only for rules that use them, and whether it uses pairs; `None` when it uses none
    /// of them.
    pub fn on_demand(&self) -> Option<OnDemand> {
        let all = self.program.all_signals();
        let asks_for_pairs = |op: &Op| matches!(op, Op::PairSignal { .. } | Op::AtLeastNear { .. });
        let pairs = self.program.nodes.iter().any(|n| asks_for_pairs(&n.op));
        let (signals, others): (BTreeSet<String>, BTreeSet<String>) =
            all.into_iter().partition(|s| is_on_demand(s));
        (!signals.is_empty()).then_some(OnDemand { signals, others, pairs })
    }

    /// Those of them without which the absence of a match is unknown: all except where a test `x is known` decides
    /// without them ([`Program::needs`]).
    pub fn needs(&self) -> BTreeSet<String> {
        let roots: Vec<NodeId> = std::iter::once(&self.when).chain(&self.require).copied().collect();
        let mut needs = self.program.needs(&roots);
        // A vehicle of unknown kind is not looked at; that it is not large is not known.
        needs.extend(self.subject.and_then(Subject::signal).map(str::to_owned));
        needs
    }
}
