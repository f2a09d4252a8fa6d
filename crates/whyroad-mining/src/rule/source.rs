//! A `mining:` block of `scenarios/<l1>/<l2>.yaml` to a [`Rule`]. `docs/reference/rules.md` describes the block.

use super::block;
use super::origin::Origin;
use super::{Listed, PartPlace, ResponseCondition, Rule, RuleParts, TARGET, Timing};
use crate::language::check::nearest;
use crate::language::program::{Moment, NodeId, Op, Subject, ValueKind};
use crate::language::syntax::{ExprKind, Quantity};
use crate::language::{Checker, Fault, Span, parse};
use std::collections::BTreeSet;
use whyroad_framework::ResolvedSpec;
use whyroad_framework::spec::MomentSpec;
use whyroad_model::units::Dimension;
use whyroad_model::yaml::{Entry, Node, Value};
use whyroad_model::{Bilingual, Diagnostic, Nanos, ScenarioId};
use whyroad_signals::Catalog;

/// Matches closer than this are merged unless the block states otherwise: a signal that drops out for a
/// few frames does not make a second event.
pub(super) const DEFAULT_MERGE_GAP: Nanos = Nanos(500_000_000);

/// A leaf's block over that of its L2: `parameters` and `define` are merged, `require` is appended, the rest of the
/// L2's block is replaced by the leaf's fields. Every part keeps its position.
pub fn inherit(l2: Option<&Node>, leaf: &Node) -> Node {
    let (Some(l2), Value::Map(own)) = (l2, &leaf.value) else { return leaf.clone() };
    if !matches!(l2.value, Value::Map(_)) {
        return leaf.clone();
    }
    let mut out = l2.entries().to_vec();
    for entry in own {
        match out.iter_mut().find(|e| e.key == entry.key) {
            Some(upper) => {
                let node = merged(&entry.key, &upper.node, &entry.node);
                *upper = Entry { node, ..entry.clone() };
            }
            None => out.push(entry.clone()),
        }
    }
    without_replaced_names(&mut out, leaf);
    Node { value: Value::Map(out), ..leaf.clone() }
}

/// The L2's name of a definition is not used for the leaf's replacement of it.
fn without_replaced_names(block: &mut [Entry], leaf: &Node) {
    let of = |key: &str| leaf.get(key).map_or(&[][..], Node::entries);
    let has = |entries: &[Entry], key: &str| entries.iter().any(|e| e.key == key);
    if let Some(Entry { node: Node { value: Value::Map(names), .. }, .. }) =
        block.iter_mut().find(|e| e.key == "names")
    {
        names.retain(|e| has(of("names"), &e.key) || !has(of("define"), &e.key));
    }
}

fn merged(key: &str, upper: &Node, own: &Node) -> Node {
    let value = match (key, &upper.value, &own.value) {
        ("parameters" | "define" | "names", Value::Map(a), Value::Map(b)) => {
            let kept = a.iter().filter(|e| b.iter().all(|o| o.key != e.key));
            Value::Map(kept.chain(b).cloned().collect())
        }
        ("require", _, _) => Value::List(items(upper).iter().chain(items(own)).cloned().collect()),
        _ => return own.clone(),
    };
    Node { value, ..own.clone() }
}

/// A list, or a single text as a list of one.
fn items(node: &Node) -> &[Node] {
    match &node.value {
        Value::List(items) => items,
        _ => std::slice::from_ref(node),
    }
}

/// The rule of a block, or all its errors.
pub fn compile(
    scenario: &ScenarioId,
    block: &Node,
    spec: Option<&ResolvedSpec>,
    catalog: &Catalog,
    origin: &Origin<'_>,
) -> Result<Rule, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let pointer = &block.pointer;
    let block = block::read(block, origin, &mut found);
    let mut c = Compiler {
        checker: Checker::new(catalog),
        scenario,
        origin,
        found,
        lacks_signals: false,
        broken: block.broken.iter().cloned().collect(),
    };
    let roles = c.roles(block.target, &block.roles);
    c.parameters(&block.parameters);
    c.checker.names = block.names.iter().map(|(e, words)| (e.key.clone(), words.clone())).collect();
    c.define(&block.define);
    c.names_of_definitions(&block.names);
    let subject = roles.target;
    let mut described = RuleParts::default();
    let when: Vec<NodeId> =
        block.when.iter().filter_map(|n| c.condition(n, PartPlace::When, &mut described)).collect();
    let require: Vec<NodeId> =
        block.require.iter().filter_map(|n| c.condition(n, PartPlace::Require, &mut described)).collect();
    for (written, all) in [(&block.when, &when), (&block.require, &require)] {
        if let Some(last) = written.last().filter(|_| all.len() > 1) {
            let span = Span { start: 0, end: last.text().unwrap_or_default().len() };
            if let Err(fault) = c.checker.possible_together(all, span) {
                c.report(last, fault);
            }
        }
    }
    let response: Vec<NodeId> = block.response.iter().filter_map(|n| c.response(n)).collect();
    let mut time = |node: Option<&Node>| node.and_then(|n| c.time(n));
    let min_duration = time(block.min_duration).unwrap_or_default();
    let max_duration = time(block.max_duration);
    let merge_gap = time(block.merge_gap).unwrap_or(DEFAULT_MERGE_GAP);
    if let Some((most, node)) = max_duration.zip(block.max_duration)
        && most < min_duration
    {
        let span = Span { start: 0, end: node.text().unwrap_or_default().len() };
        let fault = Fault::new(
            "rule.block",
            span,
            "max_duration 小于 min_duration，规则永远不会成立",
            "max_duration is less than min_duration: the rule can never match",
        );
        c.report(node, fault.hint("请改正其中之一", "correct one of them"));
    }
    let of_target = when.iter().chain(&require).any(|id| c.checker.is_of_target(*id));
    let subject = subject.or(c.checker.subject);
    // A kind of target that cannot be read is reported there.
    if of_target && subject.is_none() && block.target.is_none() && block.roles.is_empty() {
        let fault = Fault::new(
            "rule.target",
            Span::default(),
            "规则用到 target.* 信号，但没有写 target",
            "the rule uses target.* but does not state what its target is",
        );
        let fault = fault.hint("例如 target: vehicle", "as in `target: vehicle`");
        c.found.push(origin.file.at(origin.mark, pointer, fault));
    }
    let timing = spec.map_or_else(Timing::of_match, |s| c.timing(s, subject));
    let when = match when.as_slice() {
        [one] => *one,
        all => c.checker.program.add(Op::And(all.to_vec()), ValueKind::Condition),
    };
    let response = match response.as_slice() {
        [] => None,
        [one] => Some(*one),
        all => Some(c.checker.program.add(Op::And(all.to_vec()), ValueKind::Condition)),
    };
    let response = response
        .map(|condition| ResponseCondition { condition, of_target: c.checker.is_of_target(condition) });
    if c.lacks_signals || !c.found.is_empty() {
        return Err(c.found);
    }
    Ok(Rule {
        scenario: scenario.clone(),
        subject,
        target_role: c.checker.roles.first.clone().unwrap_or_else(|| TARGET.to_owned()),
        second: roles.second,
        when,
        require,
        response,
        atoms: described.atoms,
        parts: described.parts,
        listed: Listed::Holding,
        min_duration,
        max_duration,
        merge_gap,
        lengthy: c.checker.lengthy,
        timing,
        program: c.checker.program,
    })
}

pub(super) struct Compiler<'a> {
    pub(super) checker: Checker<'a>,
    scenario: &'a ScenarioId,
    origin: &'a Origin<'a>,
    found: Vec<Diagnostic>,
    /// It uses a signal whose entry in the catalog has an error, which is reported there.
    lacks_signals: bool,
    /// Parameters and definitions that have been reported: their absence elsewhere is not reported again.
    broken: BTreeSet<String>,
}

impl Compiler<'_> {
    /// Reports a fault in the text of `node`.
    pub(super) fn report(&mut self, node: &Node, fault: Fault) {
        let text = node.text().unwrap_or_default();
        let marked = text.get(fault.span.start..fault.span.end).unwrap_or_default();
        if !self.is_reported(&fault, marked) {
            self.found.push(self.origin.file.diagnose(node, fault));
        }
    }

    /// True where the name that is not found is one that has been reported as faulty where it is written.
    fn is_reported(&mut self, fault: &Fault, name: &str) -> bool {
        if fault.code != "rule.signal.unknown" {
            return false;
        }
        let lacks = self.checker.catalog.lacks(name);
        self.lacks_signals |= lacks;
        lacks || self.broken.contains(name)
    }

    /// Reports a fault of a key.
    pub(super) fn report_key(&mut self, entry: &Entry, fault: Fault) {
        self.found.push(self.origin.file.at(entry.mark, &entry.node.pointer, fault));
    }

    fn condition(&mut self, node: &Node, place: PartPlace, described: &mut RuleParts) -> Option<NodeId> {
        let text = node.text().unwrap_or_default();
        let expr = parse::parse(text).map_err(|fault| self.report(node, fault)).ok()?;
        let checked = self.checker.condition(&expr).and_then(|id| {
            if place == PartPlace::When && self.checker.program.node(id).needs_episode {
                return Err(needs_a_match(text));
            }
            described.add(&mut self.checker, &expr, place)?;
            Ok(id)
        });
        match checked {
            Ok(id) => Some(id),
            Err(first) => {
                for fault in self.checker.every_fault(&expr, first) {
                    self.report(node, fault);
                }
                None
            }
        }
    }

    /// What counts as the ego's response. It is searched in the time range, so it cannot refer to the match.
    fn response(&mut self, node: &Node) -> Option<NodeId> {
        let text = node.text().unwrap_or_default();
        let expr = parse::parse(text).map_err(|fault| self.report(node, fault)).ok()?;
        let checked = match self.checker.condition(&expr) {
            Ok(id) if self.checker.program.node(id).needs_episode => Err(vec![needs_a_match(text)]),
            Ok(id) => Ok(id),
            Err(first) => Err(self.checker.every_fault(&expr, first)),
        };
        checked.map_err(|faults| faults.into_iter().for_each(|fault| self.report(node, fault))).ok()
    }

    fn quantity(&mut self, node: &Node) -> Option<Quantity> {
        let checked = parse::parse(node.text().unwrap_or_default()).and_then(|expr| match expr.kind {
            ExprKind::Number(q) => Ok(q),
            ExprKind::Negate(of) => match of.kind {
                ExprKind::Number(q) => Ok(Quantity { value: -q.value, ..q }),
                _ => Err(not_a_quantity(expr.span)),
            },
            _ => Err(not_a_quantity(expr.span)),
        });
        checked.map_err(|fault| self.report(node, fault)).ok()
    }

    fn time(&mut self, node: &Node) -> Option<Nanos> {
        let q = self.quantity(node)?;
        if q.unit.dimension == Dimension::Time && q.value >= 0.0 {
            return Some(Nanos::from_secs_f64(q.base()));
        }
        let span = Span { start: 0, end: node.text().unwrap_or_default().len() };
        self.report(
            node,
            Fault::new("rule.unit.mismatch", span, "此处应为时长", "expected a time")
                .hint("例如 0.5 s", "such as 0.5 s"),
        );
        None
    }

    fn parameters(&mut self, parameters: &[(&Entry, &Node)]) {
        for (entry, value) in parameters {
            if !self.claim(entry) {
                continue;
            }
            match self.quantity(value) {
                Some(q) => {
                    self.checker.parameters.insert(entry.key.clone(), q);
                }
                None => {
                    self.broken.insert(entry.key.clone());
                }
            }
        }
    }

    fn define(&mut self, definitions: &[&Entry]) {
        self.checker.later = definitions.iter().map(|entry| entry.key.clone()).collect();
        for entry in definitions {
            // What uses itself is reported as such.
            self.checker.later.remove(&entry.key);
            if !self.claim(entry) {
                continue;
            }
            let text = entry.node.text().unwrap_or_default();
            if let Err(first) = self.checker.define(&entry.key, text) {
                let all = match parse::parse(text) {
                    Ok(expr) if first.code != "rule.name" => self.checker.every_fault(&expr, first),
                    _ => vec![first],
                };
                for fault in all {
                    self.report(&entry.node, fault);
                }
                self.broken.insert(entry.key.clone());
            }
        }
    }

    /// Every name in `names` is that of a definition.
    fn names_of_definitions(&mut self, names: &[(&Entry, Bilingual)]) {
        for (entry, _) in names {
            let key = &entry.key;
            if !self.checker.definitions.contains_key(key) && !self.broken.contains(key) {
                let fault = Fault::new(
                    "rule.name",
                    Span::default(),
                    format!("names 里的 '{key}' 不是 define 中的定义"),
                    format!("'{key}' in `names` is not a definition in `define`"),
                );
                let near = nearest(key, self.checker.definitions.keys().map(String::as_str));
                let fault = match near {
                    Some(n) => fault.hint(format!("是否想写 '{n}'？"), format!("did you mean '{n}'?")),
                    None => fault,
                };
                self.report_key(entry, fault);
            }
        }
    }

    /// False, and reported, where the name is not free.
    fn claim(&mut self, entry: &Entry) -> bool {
        let claimed = self.checker.claim(&entry.key);
        let free = claimed.is_ok();
        if let Err(fault) = claimed {
            self.report_key(entry, fault);
            self.broken.insert(entry.key.clone());
        }
        free
    }

    /// The moments of a labeling spec, whose expressions are checked here, with their rule.
    fn timing(&mut self, spec: &ResolvedSpec, subject: Option<Subject>) -> Timing {
        let mut timing = Timing::of_match();
        timing.kind = spec.keyframe.kind;
        let fallback = spec.keyframe.fallback.as_ref();
        let ways = std::iter::once((&spec.keyframe.expr, &spec.keyframe.rule))
            .chain(fallback.map(|f: &MomentSpec| (&f.expr, &f.rule)));
        for (expr, words) in ways {
            let moment = expr.as_ref().and_then(|e| self.moment(e, subject));
            timing.keyframe.extend(moment.map(|m| (m, words.clone())));
        }
        for (bound, out) in [(&spec.start, &mut timing.start), (&spec.end, &mut timing.end)] {
            let fallback = bound.fallback.as_ref().and_then(|f| f.expr.as_ref());
            for expr in bound.expr.iter().chain(fallback) {
                out.extend(self.moment(expr, subject));
            }
        }
        let second = spec.second_keyframe.as_ref();
        let ways =
            second.into_iter().flat_map(|k| k.expr.iter().chain(k.fallback.iter().flat_map(|f| &f.expr)));
        for expr in ways {
            timing.second_keyframe.extend(self.moment(expr, subject));
        }
        timing.before = Nanos::from_secs_f64(spec.pack.before_s);
        timing.after = Nanos::from_secs_f64(spec.pack.after_s);
        let until = spec.pack.after_until.as_ref().and_then(|m| m.expr.as_ref());
        timing.after_until = until.and_then(|e| self.moment(e, subject));
        timing
    }

    /// A moment of a spec. The default of an L1 refers to the target; it has no meaning for a rule without one.
    fn moment(&mut self, text: &str, subject: Option<Subject>) -> Option<Moment> {
        let checked = parse::parse(text).and_then(|expr| self.checker.moment(&expr));
        let moment = match checked {
            Ok(moment) => moment,
            Err(fault) => {
                let marked = text.get(fault.span.start..fault.span.end).unwrap_or_default();
                if !self.is_reported(&fault, marked) {
                    self.found.push(self.origin.diagnose_moment(self.scenario, text, fault));
                }
                return None;
            }
        };
        let of_target = moment.conditions().iter().any(|id| self.checker.is_of_target(*id));
        (subject.is_some() || !of_target).then_some(moment)
    }
}

/// `when` defines what a match is: it cannot refer to one.
pub(super) fn needs_a_match(text: &str) -> Fault {
    let word =
        ["at keyframe", "least(", "greatest("].into_iter().find_map(|w| Some((text.find(w)?, w.len())));
    let (start, len) = word.unwrap_or((0, text.len()));
    let span = Span { start, end: start + len };
    Fault::new(
        "rule.type",
        span,
        "when 里还没有匹配：at keyframe、least、greatest 只能用于 require、start、end",
        "`when` has no match yet: at keyframe, least and greatest belong in require, start and end",
    )
}

fn not_a_quantity(span: Span) -> Fault {
    Fault::new("rule.block", span, "此处应为带单位的数", "expected a number with its unit")
}
