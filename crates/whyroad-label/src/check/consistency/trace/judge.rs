//! Whether a trace agrees with the decisions of its label, channel by channel.

use super::{Force, Mention, Reading};
use whyroad_framework::lexicon::Lexicon;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::label_fields::name;

/// A contradiction between a trace and its label. Spans are bytes of the trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::check) enum TraceVerdict {
    /// The trace states another decision in a channel.
    OtherDecision { label: &'static str, says: Vec<&'static str>, start: usize, end: usize },
    /// The trace states that the label's decision is not taken.
    Denied { label: &'static str, start: usize, end: usize },
    /// A statement of the trace about the ego contradicts the label's decision, in words that name no decision.
    Against { label: &'static str, start: usize, end: usize },
    /// The trace states the other side.
    OtherSide { label: LateralDirection, says: LateralDirection, start: usize, end: usize },
    /// The trace states a decision in a channel that the label leaves null.
    Unlabelled { channel: &'static str, says: &'static str, start: usize, end: usize },
    /// The deciding part of the trace does not state the label's decision.
    NotStated { label: &'static str, start: usize, end: usize },
}

/// One channel of a label, for both kinds of decision.
struct Channel<'l, D: 'static> {
    name: &'static str,
    label: Option<D>,
    null_allows: &'l [D],
    says: fn(&whyroad_framework::lexicon::Says) -> &[D],
    id: fn(D) -> &'static str,
}

/// All contradictions, in channel order.
pub(in crate::check) fn judge(
    reading: &Reading,
    lexicon: &Lexicon,
    longitudinal: Option<Longitudinal>,
    lateral: Option<Lateral>,
    direction: Option<LateralDirection>,
    sink: &mut dyn FnMut(TraceVerdict),
) {
    if lexicon.patterns.is_empty() {
        return;
    }
    let any = std::cell::Cell::new(false);
    let mut sink = |v: TraceVerdict| {
        any.set(true);
        sink(v);
    };
    let sink: &mut dyn FnMut(TraceVerdict) = &mut sink;
    let along = Channel {
        name: name::LONGITUDINAL,
        label: longitudinal,
        null_allows: &lexicon.null_allows.longitudinal,
        says: |s| &s.longitudinal,
        id: Longitudinal::id,
    };
    // Pulling over includes slowing down and stopping.
    let pulls_over = lateral == Some(Lateral::PullOver) && longitudinal.is_none();
    if !pulls_over {
        along.judge(reading, lexicon, sink);
    }
    let across = Channel {
        name: name::LATERAL,
        label: lateral,
        null_allows: &lexicon.null_allows.lateral,
        says: |s| &s.lateral,
        id: Lateral::id,
    };
    let agrees = across.judge(reading, lexicon, sink);
    if let (true, Some(lateral), Some(direction)) = (agrees, lateral, direction) {
        side(reading, lexicon, lateral, direction, sink);
    }
    if any.get() {
        return;
    }
    let not_stated = match (along.stated(reading, lexicon), across.stated(reading, lexicon)) {
        // A car keeps its lane also without a statement about it.
        (_, Stated::Nowhere) if lateral != Some(Lateral::LaneKeeping) => lateral.map(Lateral::id),
        (Stated::Nowhere | Stated::Before, Stated::Nowhere | Stated::Before | Stated::Null) => {
            longitudinal.map(Longitudinal::id)
        }
        (Stated::Null, Stated::Nowhere) if reading.mentions.is_empty() => lateral.map(Lateral::id),
        _ => None,
    };
    if let Some(label) = not_stated {
        // The text about later events may begin before the mark.
        let start = reading.decision_from.min(reading.end);
        sink(TraceVerdict::NotStated { label, start, end: reading.end });
    }
}

/// Part of a trace that states the decision of a channel.
enum Stated {
    /// The channel has no decision.
    Null,
    /// The part that states the decision.
    Deciding,
    /// Only the text before it.
    Before,
    Nowhere,
}

impl<D: Copy + PartialEq> Channel<'_, D> {
    /// The part of the trace that states the label's decision for the ego. Intended and later actions count.
    fn stated(&self, reading: &Reading, lexicon: &Lexicon) -> Stated {
        let Some(label) = self.label else { return Stated::Null };
        let says = |m: &&Mention| (self.says)(&lexicon.phrases[m.phrase]).contains(&label);
        let own = reading.mentions.iter().filter(says).filter(|m| m.force != Force::Negated && !m.by_other);
        let mut stated = Stated::Nowhere;
        for m in own {
            if m.start >= reading.decision_from || !reading.marked {
                return Stated::Deciding;
            }
            stated = Stated::Before;
        }
        stated
    }

    /// Returns true when nothing was found.
    fn judge(&self, reading: &Reading, lexicon: &Lexicon, sink: &mut dyn FnMut(TraceVerdict)) -> bool {
        let says = |m: &Mention| (self.says)(&lexicon.phrases[m.phrase]);
        // A road user in words that are in no list may act in a clause that names nobody, unless it is the last one.
        let of_ego = |m: &&Mention| m.by_ego || m.clause == reading.last_clause;
        // "We are to turn left here": the route, if another clause decides.
        let decides = |m: &&Mention| reading.marked || !m.meant || m.clause == reading.last_clause;
        let firm = |m: &&Mention| {
            m.force == Force::Asserted && !lexicon.phrases[m.phrase].supports_only && of_ego(m)
        };
        let relevant = || reading.mentions.iter().filter(|m| !says(m).is_empty());
        let deciding = || relevant().filter(|m| m.start >= reading.decision_from);

        let Some(label) = self.label else {
            let named = deciding().filter(firm).filter(decides).find(|m| {
                let other = says(m).iter().all(|d| !self.null_allows.contains(d));
                other || lexicon.phrases[m.phrase].change
            });
            if let Some(m) = named {
                let says = (self.id)(says(m)[0]);
                sink(TraceVerdict::Unlabelled { channel: self.name, says, start: m.start, end: m.end });
            }
            return named.is_none();
        };

        let supports = |m: &&Mention| says(m).contains(&label);
        // "Not slowing down" denies no particular decision; a phrase for one or two decisions does, and one for a side.
        let denies = |m: &&Mention| {
            let ids = lexicon.phrases[m.phrase].denies.iter().any(|d| d.id() == (self.id)(label));
            m.force == Force::Negated && (says(m).len() <= 2 || ids || m.side.is_some())
        };
        // "Holds its speed and does not keep the gap": what is denied is more specific than what may agree with the
        // label.
        let exact = |m: &&Mention| says(m).len() <= 2 || m.side.is_some();
        // Denied at last, for the ego: statements without a subject in the clauses before are not the decision.
        let at_last = |m: &Mention| m.clause == reading.last_clause;
        let is_refused = |m: &&Mention| m.force == Force::Negated && m.by_ego && at_last(m);
        let refused = deciding().filter(supports).find(is_refused);
        let by_ego = |m: &&Mention| m.by_ego || at_last(m);
        let asserted = |m: &Mention| matches!(m.force, Force::Asserted | Force::Doubtful);
        if let Some(m) = refused.filter(|_| !relevant().filter(by_ego).any(asserted)) {
            sink(TraceVerdict::Denied { label: (self.id)(label), start: m.start, end: m.end });
            return false;
        }
        let plainly = deciding().filter(supports).filter(exact).filter(|m| refused.is_none() || by_ego(m));
        let denied_only = deciding().filter(supports).filter(exact).any(|m| denies(&m))
            && !plainly.clone().any(|m| matches!(m.force, Force::Asserted | Force::Doubtful));
        // "It requires a halt, and we sail straight through": the ego's last action is another one, and the label's
        // decision is only what it has to do.
        let at_last_other =
            relevant().filter(firm).find(|m| m.by_ego && at_last(m) && !says(m).contains(&label));
        let own_support =
            relevant().filter(supports).any(|m| asserted(m) && (m.by_ego || at_last(m)) && !m.denied);
        let overruled = at_last_other.filter(|_| !reading.marked && !own_support);
        if overruled.is_none()
            && !denied_only
            && deciding().filter(supports).any(|m| matches!(m.force, Force::Asserted | Force::Doubtful))
        {
            return true;
        }
        // Without a "therefore" the decision may be before the last sentence.
        if overruled.is_none()
            && !denied_only
            && !reading.marked
            && relevant().filter(supports).any(|m| m.force == Force::Asserted)
        {
            return true;
        }
        if let Some(m) = overruled {
            sink(TraceVerdict::Against { label: (self.id)(label), start: m.start, end: m.end });
            return false;
        }
        if let Some(m) = deciding().filter(firm).filter(decides).find(|m| !says(m).contains(&label)) {
            sink(TraceVerdict::OtherDecision {
                label: (self.id)(label),
                says: says(m).iter().map(|d| (self.id)(*d)).collect(),
                start: m.start,
                end: m.end,
            });
            return false;
        }
        if let Some(m) = deciding().filter(supports).filter(of_ego).find(denies) {
            sink(TraceVerdict::Denied { label: (self.id)(label), start: m.start, end: m.end });
            return false;
        }
        true
    }
}

fn side(
    reading: &Reading,
    lexicon: &Lexicon,
    lateral: Lateral,
    label: LateralDirection,
    sink: &mut dyn FnMut(TraceVerdict),
) {
    let sided: Vec<&Mention> = reading
        .mentions
        .iter()
        .filter(|m| m.start >= reading.decision_from && m.side.is_some())
        .filter(|m| matches!(m.force, Force::Asserted | Force::Doubtful))
        .filter(|m| lexicon.phrases[m.phrase].lateral.contains(&lateral))
        .collect();
    if sided.iter().any(|m| m.side == Some(label)) {
        return;
    }
    // A U-turn may be described as a left turn, or as a right turn in left-hand traffic.
    let other = sided.iter().find_map(|m| match (m.side, label) {
        (Some(s), LateralDirection::Left | LateralDirection::Right) => Some((s, m)),
        _ => None,
    });
    if let Some((says, m)) = other {
        sink(TraceVerdict::OtherSide { label, says, start: m.start, end: m.end });
    }
}
