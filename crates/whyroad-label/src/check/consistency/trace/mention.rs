//! Finds decisions that a trace names, and how certainly it attributes them to the ego.

use crate::check::reading::starting_in;
use whyroad_framework::lexicon::units::Units;
use whyroad_framework::lexicon::{Hit, Lexicon, Role};
use whyroad_model::decision::LateralDirection;

/// How a decision is attributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::check) enum Force {
    /// The ego does it.
    Asserted,
    /// The actor may not be the ego, or the action not the first one, or only intended. Supports a label, never
    /// contradicts one.
    Doubtful,
    /// The ego does not do it.
    Negated,
    /// About another road user, in a condition, or part of the cause.
    Unsaid,
}

/// One decision named in a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::check) struct Mention {
    /// Index into the lexicon's phrases.
    pub phrase: usize,
    pub side: Option<LateralDirection>,
    pub force: Force,
    /// Bytes of the trace.
    pub start: usize,
    pub end: usize,
    pub clause: usize,
    /// Another road user does it.
    pub by_other: bool,
    /// The ego is named as the one who does it, here or in the clauses before.
    pub by_ego: bool,
    /// It is denied.
    pub denied: bool,
    /// After "we are to": what the ego is going to do, where another clause decides.
    pub meant: bool,
    /// Its subject is inherited from an earlier clause, in which another road user acts.
    pub carried: bool,
    /// After "then": what the ego does after its decision.
    pub later: bool,
}

/// A trace after reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::check) struct Reading {
    pub mentions: Vec<Mention>,
    /// Byte from which the trace states its decision.
    pub decision_from: usize,
    /// A word such as "therefore" marks it; otherwise it is the last sentence.
    pub marked: bool,
    /// One past the last byte that was read: final punctuation is excluded.
    pub end: usize,
    /// It names the ego.
    pub names_ego: bool,
    /// Number of the last clause.
    pub last_clause: usize,
    /// One past the first word that introduces a reason.
    pub because: Option<usize>,
    /// Bytes of the last words that state that the ego, named in the same clause, does not do something; and the number
    /// of that clause.
    pub refused: Option<(usize, usize, usize)>,
    /// Bytes of the first decision identifier.
    pub decision_id: Option<(usize, usize)>,
}

impl Reading {
    /// Mentions that begin in these bytes.
    pub fn mentions_in(&self, from: usize, to: usize) -> &[Mention] {
        starting_in(&self.mentions, |m| m.start, from, to)
    }
}

/// `text` ends with `word`, in upper or lower case.
fn ends_with(text: &str, word: &str) -> bool {
    let end = text.len().checked_sub(word.len()).and_then(|from| text.get(from..));
    end.is_some_and(|end| end.eq_ignore_ascii_case(word))
}

/// The actor of a clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Actor {
    Unknown,
    Ego,
    Other,
    /// Only the object of an action has been named.
    Object,
}

#[derive(Clone, Copy)]
struct Negation {
    end: usize,
    reach: usize,
    used: bool,
}

/// State of the reader, which goes from left to right.
struct Reader<'l> {
    lexicon: &'l Lexicon,
    text: &'l str,
    out: Reading,
    // Since the sentence's start.
    sequel: bool,
    then: bool,
    reason_until_sentence_end: bool,
    /// Actor of the clauses before, in this sentence.
    inherited: Actor,
    anything_in_sentence: bool,
    // Since the clause's start.
    clause: usize,
    actor: Actor,
    /// The ego is named in it.
    names_ego: bool,
    /// It states what the ego is going to do: "we are to".
    meant: bool,
    hypothesis: bool,
    intention: bool,
    reason: bool,
    negation: Option<Negation>,
    /// A negation right after this mention, unless another phrase follows it.
    back_negation: Option<usize>,
    /// The last word makes the next noun an object.
    governs: bool,
}

/// Reads `text`, split into `units`, with the words of `lexicon`.
pub(in crate::check) fn read(text: &str, units: &Units, lexicon: &Lexicon) -> Reading {
    let mut r = Reader {
        lexicon,
        text,
        out: Reading::default(),
        sequel: false,
        then: false,
        reason_until_sentence_end: false,
        inherited: Actor::Unknown,
        anything_in_sentence: false,
        clause: 0,
        actor: Actor::Unknown,
        names_ego: false,
        meant: false,
        hypothesis: false,
        intention: false,
        reason: false,
        negation: None,
        back_negation: None,
        governs: false,
    };
    let text_end = text.trim_end().trim_end_matches(['。', '.', '!', '！', ' ']).len();
    r.out.end = text_end;
    lexicon.hits(units, 0..text_end, |hit| r.take(hit));
    r.end_clause();
    debug_assert!(r.out.mentions.is_sorted_by_key(|m| m.start));
    // The last clause states the decision (LABELING.md 7): if it has no subject of its own, its subject is the ego.
    let last = r.clause;
    r.out.last_clause = last;
    for m in &mut r.out.mentions {
        if m.carried && m.clause == last {
            m.force = match m.force {
                Force::Doubtful => Force::Asserted,
                Force::Unsaid if m.denied => Force::Negated,
                f => f,
            };
            m.by_other = false;
        }
    }
    r.out
}

impl Reader<'_> {
    fn take(&mut self, hit: Hit) {
        match hit.role {
            Role::SentenceEnd => {
                self.next_clause();
                self.sequel = false;
                self.then = false;
                self.reason_until_sentence_end = false;
                self.inherited = Actor::Unknown;
                self.anything_in_sentence = false;
                if !self.out.marked {
                    self.out.decision_from = hit.end;
                }
                return;
            }
            Role::ClauseEnd => return self.next_clause(),
            // "Lowers its speed accordingly": nothing follows.
            Role::DecisionMarker if hit.end >= self.out.end => {}
            Role::DecisionMarker => {
                self.next_clause();
                self.sequel = false;
                self.then = false;
                self.reason_until_sentence_end = false;
                self.actor = Actor::Ego;
                self.inherited = Actor::Ego;
                self.out.marked = true;
                self.out.decision_from = hit.start;
            }
            Role::Duty => {
                if matches!(self.actor, Actor::Unknown | Actor::Object) {
                    self.actor = Actor::Ego;
                }
                self.negation = None;
            }
            Role::Reason => {
                self.out.because.get_or_insert(hit.end);
                // "Because A, B" and "B because A, and A": only the second continues to the end.
                if self.anything_in_sentence {
                    self.reason_until_sentence_end = true;
                } else {
                    self.reason = true;
                }
            }
            Role::Hypothesis => self.hypothesis = true,
            Role::Intention => self.intention = true,
            Role::Sequel => {
                self.sequel = true;
                // "Lets it by and then turns": the ego again.
                if self.actor == Actor::Other && self.text[..hit.start].ends_with("and ") {
                    self.actor = Actor::Unknown;
                }
                self.then = self.lexicon.introduces_another(&self.text[hit.start..hit.end]);
            }
            Role::Negation | Role::NegationAdjacent => {
                let adjacent = hit.role == Role::NegationAdjacent;
                let limits = &self.lexicon.limits;
                let reach = if adjacent { limits.adjacent_reach } else { limits.negation_reach };
                let last = self.out.mentions.last();
                // "Braking is surely too late", in Chinese without a word between the two.
                let is_latin = self.text[hit.start..].starts_with(|c: char| c.is_ascii());
                let behind = if is_latin { limits.adjacent_reach } else { limits.behind_reach };
                // "Eases left without leaving it": in Latin text only a predicate negates the text before it.
                let adjacent = adjacent || is_latin && !self.text[hit.start..].starts_with("is");
                if !adjacent && last.is_some_and(|m| m.clause == self.clause && hit.start - m.end <= behind) {
                    self.back_negation = Some(self.out.mentions.len() - 1);
                }
                self.negation = Some(Negation { end: hit.end, reach, used: false });
                let word = &self.text[hit.start..hit.end];
                let unsaid = self.hypothesis || self.reason || self.reason_until_sentence_end;
                if self.names_ego && self.actor == Actor::Ego && !unsaid && self.lexicon.refuses(word) {
                    self.out.refused = Some((hit.start, hit.end, self.clause));
                }
            }
            Role::NegationEnd => self.negation = None,
            // "Towards our lane", "behind the ego": the location or direction of something.
            Role::Ego if self.is_place_of_ego(hit) => self.out.names_ego = true,
            Role::Ego => {
                self.actor = Actor::Ego;
                self.names_ego = true;
                self.out.names_ego = true;
                self.meant = self.lexicon.is_meant(&self.text[hit.end..]);
            }
            Role::Agent => match (self.governs, self.actor) {
                (true, Actor::Unknown) => self.actor = Actor::Object,
                (true, _) => {}
                // "So it stops": the subject is still the deciding ego.
                (false, Actor::Ego) if self.is_pronoun(hit) => {}
                (false, _) => self.actor = Actor::Other,
            },
            Role::Phrase(phrase) => self.mention(hit, phrase),
            Role::DecisionId => {
                self.out.decision_id.get_or_insert((hit.start, hit.end));
            }
            // The road user named next does the following action.
            Role::Permits => self.actor = Actor::Other,
            Role::ObjectOf | Role::Neutral => {}
        }
        if hit.role != Role::Neutral {
            self.governs = matches!(hit.role, Role::ObjectOf | Role::Phrase(_) | Role::NegationAdjacent);
        }
        self.anything_in_sentence = true;
    }

    /// The name of the ego at `hit` describes a location or direction of something else, not an actor.
    fn is_place_of_ego(&self, hit: Hit) -> bool {
        self.lexicon.is_place_of_ego(self.text, hit.start, hit.end)
    }

    fn is_pronoun(&self, hit: Hit) -> bool {
        let word = &self.text[hit.start..hit.end];
        self.out.marked && self.lexicon.pronouns.iter().any(|p| word.eq_ignore_ascii_case(p))
    }

    fn mention(&mut self, hit: Hit, phrase: usize) {
        self.back_negation = None;
        let (before, behind) = (&self.text[..hit.start], &self.text[hit.end..]);
        // "Only left turns", "it can be stopped": a noun, and a possible action.
        let is_noun = before.ends_with("left ") && behind.is_ascii() || before.ends_with("right ");
        let is_noun = is_noun && self.text[hit.start..hit.end].eq_ignore_ascii_case("turns");
        if is_noun || self.lexicon.can.iter().any(|w| behind.starts_with(w.as_str())) {
            return;
        }
        let actor = if self.actor == Actor::Unknown { self.inherited } else { self.actor };
        let carried = self.actor == Actor::Unknown && self.inherited == Actor::Other;
        let negated = match &mut self.negation {
            // "Without leaving the lane and brakes": a finite verb continues the clause before it.
            Some(n)
                if ends_with(&self.text[..n.end], "without")
                    && self.text[n.end..hit.start].contains(" and ")
                    && !self.text[hit.start..hit.end].contains("ing") =>
            {
                Force::Asserted
            }
            Some(n) if !n.used && hit.start - n.end <= n.reach => {
                n.used = true;
                Force::Negated
            }
            // A second phrase after "no need to": negated too if they are joined, otherwise uncertain.
            Some(n) if n.used => {
                let last = self.out.mentions.last().map_or(hit.start, |m| m.end);
                let between = self.text[last..hit.start].trim().to_ascii_lowercase();
                let joined = self.lexicon.joined.contains(&between);
                if joined { Force::Negated } else { Force::Doubtful }
            }
            _ => Force::Asserted,
        };
        // "Pushing on would be to hit it": in Chinese right after the action that is not done.
        let follows = &self.text[hit.end..];
        let imagined = self.lexicon.consequence.iter().any(|w| follows.starts_with(w.as_str()));
        let unsaid = self.hypothesis || self.reason || self.reason_until_sentence_end || imagined;
        let force = match negated {
            _ if unsaid || (actor == Actor::Other && !carried) => Force::Unsaid,
            Force::Negated if carried => Force::Unsaid,
            Force::Asserted if carried || self.intention || self.sequel || actor == Actor::Object => {
                Force::Doubtful
            }
            f => f,
        };
        // "Let him go first": the rest of the clause is the other road user's.
        let word = &self.text[hit.start..hit.end];
        let begins = |text: &str, words: &[String]| words.iter().any(|w| text.starts_with(w.as_str()));
        let lexicon = self.lexicon;
        let mut given = lexicon.gives_way.iter().filter_map(|w| word.strip_prefix(w.as_str()));
        // "Slows down to let" is one phrase.
        let ends = || lexicon.gives_way.iter().any(|w| word.ends_with(w.as_str()));
        let behind = || begins(&self.text[hit.end..], &lexicon.given_way);
        if given.any(|to| begins(to, &lexicon.given_way)) || ends() && behind() {
            self.actor = Actor::Other;
        }
        // A mention that is uncertain for another reason does not become the ego's by being the last.
        let denied = negated == Force::Negated && !unsaid;
        let carried = carried && !self.intention && !self.sequel && negated != Force::Doubtful;
        let own_clause = !matches!(self.actor, Actor::Other | Actor::Object);
        let later = self.then && own_clause && !unsaid && !self.intention && negated == Force::Asserted;
        self.out.mentions.push(Mention {
            phrase,
            by_other: actor == Actor::Other,
            by_ego: actor == Actor::Ego,
            side: hit.side,
            force,
            start: hit.start,
            end: hit.end,
            clause: self.clause,
            denied,
            meant: self.meant,
            carried,
            later,
        });
    }

    fn end_clause(&mut self) {
        if let Some(i) = self.back_negation.take() {
            let m = &mut self.out.mentions[i];
            if m.force == Force::Asserted {
                m.force = Force::Negated;
            }
        }
    }

    fn next_clause(&mut self) {
        self.end_clause();
        if matches!(self.actor, Actor::Ego | Actor::Other) {
            self.inherited = self.actor;
        }
        self.clause += 1;
        self.actor = Actor::Unknown;
        self.names_ego = false;
        self.meant = false;
        self.hypothesis = false;
        self.intention = false;
        self.reason = false;
        self.negation = None;
        self.governs = false;
    }
}
