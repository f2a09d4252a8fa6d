//! A `mining:` block of `scenarios/<l1>/<l2>.yaml` to a [`Rule`]. `docs/reference/rules.md` describes the block.

use super::block;
use super::origin::Origin;
use super::{Listed, PartPlace, Rule, TARGET, Timing, Told};
use crate::language::program::{Kind, Moment, NodeId, Op, Subject};
use crate::language::syntax::{ExprKind, Quantity};
use crate::language::{Checker, Fault, Span, parse};
use serde_yaml_ng::Value;
use std::collections::BTreeSet;
use whyroad_framework::ResolvedSpec;
use whyroad_framework::spec::MomentSpec;
use whyroad_model::units::Dimension;
use whyroad_model::{Diagnostic, Nanos, ScenarioId};
use whyroad_signals::Catalogue;

/// Matches nearer together than this are one unless the block says otherwise: a signal that drops out for a
/// few frames does not make a second event.
pub(super) const DEFAULT_MERGE_GAP: Nanos = Nanos(500_000_000);

/// A leaf's block over that of its L2: `parameters` and `define` add up, `require` is appended, the rest of
/// the L2's is replaced by what the leaf says.
pub fn inherit(l2: Option<&Value>, leaf: &Value) -> Value {
    let (Some(Value::Mapping(l2)), Value::Mapping(leaf)) = (l2, leaf) else { return leaf.clone() };
    let mut out = l2.clone();
    for (key, value) in leaf {
        let merged = match (key.as_str(), out.get(key), value) {
            (Some("parameters" | "define"), Some(Value::Mapping(a)), Value::Mapping(b)) => {
                let mut both = a.clone();
                both.extend(b.clone());
                Value::Mapping(both)
            }
            (Some("require"), Some(a), b) => Value::Sequence(items(a).chain(items(b)).cloned().collect()),
            _ => value.clone(),
        };
        out.insert(key.clone(), merged);
    }
    Value::Mapping(out)
}

/// A list, or a single text as a list of one.
fn items(value: &Value) -> impl Iterator<Item = &Value> {
    let list = value.as_sequence();
    list.into_iter().flatten().chain(list.is_none().then_some(value))
}

/// The rule of a block, or everything that is wrong with it.
pub fn compile(
    scenario: &ScenarioId,
    block: &Value,
    spec: Option<&ResolvedSpec>,
    catalogue: &Catalogue,
    origin: &Origin<'_>,
) -> Result<Rule, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let block = block::read(block, origin, &mut found);
    let mut c = Compiler {
        checker: Checker::new(catalogue),
        origin,
        found,
        broken: block.broken.into_iter().collect(),
    };
    let roles = c.roles(block.target.as_deref(), &block.roles);
    c.parameters(&block.parameters);
    c.define(&block.define);
    let subject = roles.target;
    let mut told = Told::default();
    let when: Vec<NodeId> =
        block.when.iter().filter_map(|t| c.condition(t, PartPlace::When, &mut told)).collect();
    let require: Vec<NodeId> =
        block.require.iter().filter_map(|t| c.condition(t, PartPlace::Require, &mut told)).collect();
    let mut time = |text: &Option<String>, key: &str| text.as_ref().and_then(|t| c.time(t, key));
    let min_duration = time(&block.min_duration, "/mining/min_duration").unwrap_or_default();
    let max_duration = time(&block.max_duration, "/mining/max_duration");
    let merge_gap = time(&block.merge_gap, "/mining/merge_gap").unwrap_or(DEFAULT_MERGE_GAP);
    let of_target = when.iter().chain(&require).any(|id| c.checker.is_of_target(*id));
    let subject = subject.or(c.checker.subject);
    if of_target && subject.is_none() {
        let fault = Fault::new(
            "rule.target",
            Span::default(),
            "规则用到 target.* 信号，但没有写 target",
            "the rule speaks of target.* but does not say what its target is",
        );
        c.report("/mining", "", fault.hint("例如 target: vehicle", "as in `target: vehicle`"));
    }
    let timing = spec.map_or_else(Timing::of_match, |s| c.timing(s, subject));
    let when = match when.as_slice() {
        [one] => *one,
        all => c.checker.program.add(Op::And(all.to_vec()), Kind::Condition),
    };
    if !c.found.is_empty() {
        return Err(c.found);
    }
    Ok(Rule {
        scenario: scenario.clone(),
        subject,
        target_role: c.checker.roles.first.clone().unwrap_or_else(|| TARGET.to_owned()),
        second: roles.second,
        when,
        require,
        atoms: told.atoms,
        parts: told.parts,
        listed: Listed::Holding,
        min_duration,
        max_duration,
        merge_gap,
        timing,
        program: c.checker.program,
    })
}

pub(super) struct Compiler<'a> {
    pub(super) checker: Checker<'a>,
    origin: &'a Origin<'a>,
    found: Vec<Diagnostic>,
    /// Parameters and definitions that have been reported: that they are missing elsewhere is not news.
    broken: BTreeSet<String>,
}

impl Compiler<'_> {
    pub(super) fn report(&mut self, key: &str, text: &str, fault: Fault) {
        let marked = text.get(fault.span.start..fault.span.end).unwrap_or_default();
        if fault.code == "rule.signal.unknown" && self.broken.contains(marked) {
            return;
        }
        self.found.push(self.origin.diagnose(key, text, fault));
    }

    fn condition(&mut self, text: &str, place: PartPlace, told: &mut Told) -> Option<NodeId> {
        let key = match place {
            PartPlace::When => "/mining/when",
            PartPlace::Require => "/mining/require",
        };
        let checked = parse::parse(text).and_then(|expr| {
            let id = self.checker.condition(&expr)?;
            if place == PartPlace::When && self.checker.program.node(id).needs_episode {
                return Err(needs_a_match(text));
            }
            told.add(&mut self.checker, &expr, place)?;
            Ok(id)
        });
        checked.map_err(|fault| self.report(key, text, fault)).ok()
    }

    fn moment(&mut self, text: &str, key: &str) -> Option<Moment> {
        let checked = parse::parse(text).and_then(|expr| self.checker.moment(&expr));
        checked.map_err(|fault| self.report(key, text, fault)).ok()
    }

    fn quantity(&mut self, text: &str, key: &str) -> Option<Quantity> {
        let checked = parse::parse(text).and_then(|expr| match expr.kind {
            ExprKind::Number(q) => Ok(q),
            ExprKind::Negate(of) => match of.kind {
                ExprKind::Number(q) => Ok(Quantity { value: -q.value, ..q }),
                _ => Err(not_a_quantity(expr.span)),
            },
            _ => Err(not_a_quantity(expr.span)),
        });
        checked.map_err(|fault| self.report(key, text, fault)).ok()
    }

    fn time(&mut self, text: &str, key: &str) -> Option<Nanos> {
        let q = self.quantity(text, key)?;
        if q.unit.dimension == Dimension::Time && q.value >= 0.0 {
            return Some(Nanos::from_secs_f64(q.base()));
        }
        let span = Span { start: 0, end: text.len() };
        self.report(
            key,
            text,
            Fault::new("rule.unit.mismatch", span, "此处应为时长", "expected a time")
                .hint("例如 0.5 s", "such as 0.5 s"),
        );
        None
    }

    fn parameters(&mut self, parameters: &[(String, String)]) {
        for (name, value) in parameters {
            let key = format!("/mining/parameters/{name}");
            if !self.claim(&key, name) {
                continue;
            }
            match self.quantity(value, &key) {
                Some(q) => {
                    self.checker.parameters.insert(name.clone(), q);
                }
                None => {
                    self.broken.insert(name.clone());
                }
            }
        }
    }

    fn define(&mut self, definitions: &[(String, String)]) {
        for (name, text) in definitions {
            let key = format!("/mining/define/{name}");
            if !self.claim(&key, name) {
                continue;
            }
            if let Err(fault) = self.checker.define(name, text) {
                self.report(&key, text, fault);
                self.broken.insert(name.clone());
            }
        }
    }

    /// False, and said, where the name is not free.
    fn claim(&mut self, key: &str, name: &str) -> bool {
        let claimed = self.checker.claim(name);
        let free = claimed.is_ok();
        if let Err(fault) = claimed {
            self.report(key, name, fault);
            self.broken.insert(name.to_owned());
        }
        free
    }

    /// The moments of a labelling spec, whose expressions are checked here, with the rule that they serve.
    fn timing(&mut self, spec: &ResolvedSpec, subject: Option<Subject>) -> Timing {
        let mut timing = Timing::of_match();
        timing.kind = spec.keyframe.kind;
        let fallback = spec.keyframe.fallback.as_ref();
        let ways = std::iter::once((&spec.keyframe.expr, &spec.keyframe.rule))
            .chain(fallback.map(|f: &MomentSpec| (&f.expr, &f.rule)));
        for (expr, words) in ways {
            let moment = expr.as_ref().and_then(|e| self.moment_for(e, "/labeling/keyframe", subject));
            timing.keyframe.extend(moment.map(|m| (m, words.clone())));
        }
        for (bound, out, key) in [
            (&spec.start, &mut timing.start, "/labeling/start"),
            (&spec.end, &mut timing.end, "/labeling/end"),
        ] {
            let fallback = bound.fallback.as_ref().and_then(|f| f.expr.as_ref());
            for expr in bound.expr.iter().chain(fallback) {
                out.extend(self.moment_for(expr, key, subject));
            }
        }
        let second = spec.second_keyframe.as_ref();
        let ways =
            second.into_iter().flat_map(|k| k.expr.iter().chain(k.fallback.iter().flat_map(|f| &f.expr)));
        for expr in ways {
            timing.second_keyframe.extend(self.moment_for(expr, "/labeling/second_keyframe", subject));
        }
        timing.before = Nanos::from_secs_f64(spec.pack.before_s);
        timing.after = Nanos::from_secs_f64(spec.pack.after_s);
        let until = spec.pack.after_until.as_ref().and_then(|m| m.expr.as_ref());
        timing.after_until = until.and_then(|e| self.moment_for(e, "/labeling/pack/after_until", subject));
        timing
    }

    /// A moment of a spec. The default of an L1 speaks of the target; it has no meaning for a rule without one.
    fn moment_for(&mut self, text: &str, key: &str, subject: Option<Subject>) -> Option<Moment> {
        let moment = self.moment(text, key)?;
        let of_target = moment.conditions().iter().any(|id| self.checker.is_of_target(*id));
        (subject.is_some() || !of_target).then_some(moment)
    }
}

/// `when` decides what a match is: it cannot speak of one.
pub(super) fn needs_a_match(text: &str) -> Fault {
    let word =
        ["at keyframe", "least(", "greatest("].into_iter().find_map(|w| Some((text.find(w)?, w.len())));
    let (start, len) = word.unwrap_or((0, text.len()));
    let span = Span { start, end: start + len };
    Fault::new(
        "rule.type",
        span,
        "when 里还没有匹配：at keyframe、least、greatest 只能用于 require、start、end",
        "there is no match yet in `when`: at keyframe, least and greatest belong in require, start and end",
    )
}

fn not_a_quantity(span: Span) -> Fault {
    Fault::new("rule.block", span, "此处应为带单位的数", "expected a number with its unit")
}
