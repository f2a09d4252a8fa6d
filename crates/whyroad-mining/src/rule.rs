//! A rule: one program that says when a scenario happens, and how its moments are found. Made from a
//! `mining:` block and the leaf's labeling spec ([`source`]) or from a JSON query ([`query`]).

mod block;
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
use crate::language::check::PartText;
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
    "rule.precedence",
    "rule.words",
    "rule.case",
    "rule.case.skipped",
    "mine.drive.unreadable",
    "mine.drive.crashed",
    "mine.store.unwritable",
    "mine.query.syntax",
    "mine.query.scenario",
    "mine.scenario.no_rule",
];

pub use whyroad_model::ids::OTHER;

/// What the first role is called where the rule gives it no name of its own.
pub const TARGET: &str = "target";

/// An executable rule.
#[derive(Clone, Debug)]
pub struct Rule {
    /// The leaf, or the L2 where the rule does not determine the variant.
    pub scenario: ScenarioId,
    /// What the target can be; `None` when the rule speaks of the ego alone.
    pub subject: Option<Subject>,
    /// How the rule calls its target: `target`, or a name such as `lead`.
    pub target_role: String,
    /// The object that a rule binds besides its target.
    pub second: Option<SecondRole>,
    /// All operations of the rule and of its moments.
    pub program: Program,
    /// The condition whose runs of true are the matches.
    pub when: NodeId,
    /// Conditions at the keyframe.
    pub require: Vec<NodeId>,
    /// What counts as the ego's answer to the trigger; `None` where the match is itself what the ego did.
    pub response: Option<ResponseCondition>,
    /// The parts of `when` and `require` that are shown to people.
    pub atoms: Vec<Atom>,
    /// What has to hold, part by part, as shown when somebody asks why the rule did not match.
    pub parts: Vec<Part>,
    /// Which atoms an episode lists.
    pub listed: Listed,
    /// Shorter matches are dropped, after merging.
    pub min_duration: Nanos,
    /// Longer matches are dropped.
    pub max_duration: Option<Nanos>,
    /// Matches of one target that are no further apart are one.
    pub merge_gap: Nanos,
    /// Conditions that people are shown at length, by the definition that could have a name in `names`.
    pub lengthy: BTreeMap<String, Bilingual>,
    /// Keyframe, start, end, context.
    pub timing: Timing,
}

/// What a rule about any object needs besides what is derived for every drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnDemand {
    /// The `object.` and `pair.` signals.
    pub signals: BTreeSet<String>,
    /// All its other signals.
    pub others: BTreeSet<String>,
    /// It asks about pairs of objects.
    pub pairs: bool,
}

/// When the ego answers: looked for from the match's start to the end of the time range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResponseCondition {
    /// The condition.
    pub condition: NodeId,
    /// It speaks of the target: then it is known only while the target is seen.
    pub of_target: bool,
}

/// A part of a rule: one of the conditions that must hold together.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Where it must hold.
    pub place: PartPlace,
    /// As written, names replaced by what they stand for.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Its truth.
    pub condition: NodeId,
    /// What it measures.
    pub atoms: Vec<Atom>,
}

/// Where a part of a rule must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartPlace {
    /// At every frame of a match.
    When,
    /// At the keyframe.
    Require,
}

/// A second object that takes part: the rule is judged for every pair of a target and such an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SecondRole {
    /// How the rule calls it, such as `obstacle`.
    pub name: String,
    /// What it can be.
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

/// How the moments of an episode are found. Whatever is missing falls back, at last to the match itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// One moment or a range.
    pub kind: KeyframeType,
    /// The keyframe: each way to find it with its rule in words, the best first.
    pub keyframe: Vec<(Moment, Bilingual)>,
    /// What the keyframe is when none of these finds it: the start of the match, in words.
    pub at_match_start: Bilingual,
    /// The second keyframe, the best expression first; unset without any, and where none finds it.
    pub second_keyframe: Vec<Moment>,
    /// Start of the time range, the best way first.
    pub start: Vec<Moment>,
    /// End of the time range, the best way first.
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

/// What is shown of a rule: what it measures, and what has to hold.
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
        };
        self.parts.extend(parts.into_iter().map(part));
        Ok(())
    }
}

impl Rule {
    /// Score of a match whose margin is this: [`score`](crate::episode::score), and 0.5 for a rule that compares no
    /// numbers: then there is nothing that could be exceeded by much or by little.
    pub fn margin_score(&self, margin: f64) -> f64 {
        let mut roots = std::iter::once(&self.when).chain(&self.require);
        if roots.any(|id| self.program.compares_numbers(*id)) { score(margin) } else { score(0.0) }
    }

    /// Names of the signals on which it depends whether there is a match.
    pub fn signals(&self) -> BTreeSet<String> {
        let mut out = self.program.signals(self.when);
        for id in &self.require {
            out.extend(self.program.signals(*id));
        }
        out
    }

    /// The signals that are derived only for rules that ask for them, and whether it asks about pairs; `None` when it
    /// asks for none of them.
    pub fn on_demand(&self) -> Option<OnDemand> {
        let all = self.program.all_signals();
        let asks_for_pairs = |op: &Op| matches!(op, Op::PairSignal { .. } | Op::AtLeastNear { .. });
        let pairs = self.program.nodes.iter().any(|n| asks_for_pairs(&n.op));
        let (signals, others): (BTreeSet<String>, BTreeSet<String>) =
            all.into_iter().partition(|s| is_on_demand(s));
        (!signals.is_empty()).then_some(OnDemand { signals, others, pairs })
    }

    /// Those of them without which nobody can say that it was not there: all but the ones of which the rule itself
    /// asks whether they are known.
    pub fn needs(&self) -> BTreeSet<String> {
        let roots = std::iter::once(&self.when).chain(&self.require);
        let asked: BTreeSet<String> = roots.flat_map(|id| self.program.asked_for(*id)).collect();
        self.signals().difference(&asked).cloned().collect()
    }
}
