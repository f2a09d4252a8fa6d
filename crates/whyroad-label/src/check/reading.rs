//! The things that a text of a label names, with their side, color and state, clause by clause. This is not a language
//! parser; conditional or negated statements are marked as such, and the checks ignore them.

use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{
    Bears, Divider, Doings, GroupSet, LONGEST_UNFINISHED, SaidState, WordRole,
};
use whyroad_framework::lexicon::units::Units;

/// A thing that a text names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Named {
    /// Index of its group.
    pub group: usize,
    /// True is left.
    pub side: Option<bool>,
    pub color: Option<usize>,
    /// Its state in its clause.
    pub state: Option<SaidState>,
    /// "No pedestrian": it is not there.
    pub absent: bool,
    /// "If a pedestrian", "a pedestrian may".
    pub supposed: bool,
    /// "Before the ego".
    pub ahead: bool,
    /// Number of its clause.
    pub clause: usize,
    /// Bytes of the text.
    pub start: usize,
    pub end: usize,
}

impl Named {
    /// It is said to be present.
    pub fn is_there(&self) -> bool {
        !self.absent && !self.supposed
    }
}

/// A text after reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct TextFacts {
    pub named: Vec<Named>,
    /// Groups of all named things, including absent ones.
    pub groups: GroupSet,
    /// Bytes of the first phrase of hindsight.
    pub hindsight: Option<(usize, usize)>,
    /// Bytes of the first phrase about a consequence of the ego's response: hindsight in a component.
    pub after_response: Option<(usize, usize)>,
    /// Bytes of statements that a road user is out of the way.
    pub resolved: Vec<(usize, usize)>,
    /// Number of words that are in any list.
    pub words: usize,
    /// States without a named thing, in order.
    pub states: Vec<SaidState>,
    /// Bytes of the last phrase that states that the ego continues as before.
    pub unchanged: Option<(usize, usize)>,
    /// Actions and states of the named things that are stated as facts.
    pub does: Doings,
    /// The text is still to be written.
    pub unfinished: bool,
    /// Bytes of the words, in a text of any length, that state that something is still to be written.
    pub unwritten: Option<(usize, usize)>,
    /// Bytes of the statement that there is no reason.
    pub no_reason: Option<(usize, usize)>,
    /// Bytes of the statement that something is irrelevant for the decision.
    pub irrelevant: Option<(usize, usize)>,
    /// Bytes of statements that nothing hides or hinders.
    pub clear: Vec<(usize, usize)>,
    /// Bytes of statements that there is nothing to respond to.
    pub harmless: Vec<(usize, usize)>,
    /// Statements about the named things, in order, including negated ones.
    pub acts: Vec<Act>,
    /// Bytes of the first word that is unrelated to roads and traffic.
    pub idle: Option<(usize, usize)>,
    /// Bytes of the first place that is off the road.
    pub apart: Option<(usize, usize)>,
    /// Bytes of times after the ego's response, or after the road user to which it responds has finished.
    pub done: Vec<(usize, usize)>,
    /// Bytes of the statement that the cause was not observed.
    pub unobserved: Option<(usize, usize)>,
    /// Bytes of the words that place the thing far away, or beyond a named road user.
    pub distant: Option<(usize, usize)>,
}

/// A statement about something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Act {
    pub doing: Doings,
    /// It is negated.
    pub denied: bool,
    /// Bytes of the text.
    pub start: usize,
    pub end: usize,
}

/// Maximum number of characters between a negating word and what it negates: "no other", "没有任何".
const BETWEEN_CHINESE: usize = 2;
const BETWEEN_LATIN: usize = 12;

/// Reads `text`, split into `units`, with `words`, in one pass.
pub(super) fn read(text: &str, units: &Units, words: &LabelWords) -> TextFacts {
    let mut out = TextFacts::default();
    let mut clause = Clause::default();
    let mut last_end = 0;
    let mut marks = units.marks().iter().peekable();
    words.hits_in(units, 0..text.len(), |hit| {
        // A separator inside a word separates nothing.
        let (mut divides, mut ends, mut from) = (false, false, 0);
        while let Some(mark) = marks.next_if(|m| m.start < hit.start) {
            if mark.start >= last_end
                && let Some(divider) = words.clauses.divides(*mark)
            {
                divides |= divider != Divider::Aside;
                ends |= divider == Divider::Sentence;
                from = mark.end();
            }
        }
        if divides {
            clause.close(&mut out);
            let sentence = if ends { out.named.len() } else { clause.sentence };
            // "If somebody, or a dog, came out".
            let adds = || words.clauses.alternative.iter().any(|w| starts_with(text[from..].trim_start(), w));
            let supposed = clause.supposed && adds();
            clause = Clause { number: clause.number + 1, from, sentence, supposed, ..Clause::default() };
        }
        last_end = hit.end;
        let word = &text[hit.start..hit.end];
        match hit.role {
            // "Obstacle: ...", "【障碍】...".
            WordRole::Object(_) if text[hit.end..].trim_start().starts_with([':', '：', '】', ']']) => {}
            WordRole::Object(group) => {
                out.words += 1;
                let is_no_car = word.starts_with(['无', '没']) && word.ends_with('车');
                // "It is not snowing".
                let is_not = clause.denied.is_some_and(|d| text[d.end..hit.start].trim().is_empty());
                let absent = is_no_car
                    || clause.absent.is_some_and(|a| a.reaches(text, hit.start))
                    || is_not && words.objects[group].own.meets(words.known.adverse);
                // "没有车排队".
                if is_no_car {
                    clause.absent = Some(Denial { end: hit.end, is_latin: false });
                }
                out.groups = out.groups.with(words.objects[group].own);
                let lane_side = lane_side(text, hit.start, hit.end);
                if let Some(left) = lane_side {
                    clause.say_side(left, word.is_ascii(), words, &mut out);
                }
                if let Some(from) = clause.beyond.take()
                    && words.objects[group].own.meets(words.known.actor)
                {
                    out.distant.get_or_insert((from, hit.end));
                }
                out.named.push(Named {
                    group,
                    side: if lane_side.is_some() { None } else { clause.side },
                    color: clause.color.take().or_else(|| color_before(text, hit.start, words)),
                    state: None,
                    absent,
                    supposed: clause.supposed
                        || clause.likened.take().is_some_and(|l| l.reaches(text, hit.start)),
                    ahead: std::mem::take(&mut clause.ahead),
                    clause: clause.number,
                    start: hit.start,
                    end: hit.end,
                });
                clause.names += 1;
                // Something that cannot be seen is not said to be present.
                clause.supposed |= ["看不", "cannot", "can't"].iter().any(|w| word.starts_with(w));
            }
            // "Its left wheels": the location of a part.
            WordRole::Side(_) if words.subjects.begins_with_own_part(&text[hit.end..]) => out.words += 1,
            WordRole::Side(left) => {
                out.words += 1;
                // "An old man comes from the left": after the name in Chinese, too.
                let from = out.named.last().is_some_and(|n| n.clause == clause.number && !n.absent)
                    && text[..hit.start].ends_with(['从', '自', '由', '打']);
                clause.say_side(left, word.is_ascii() || from, words, &mut out);
            }
            WordRole::Doing(doing) => {
                out.words += 1;
                clause.act(doing, text, (hit.start, hit.end), &mut out);
            }
            WordRole::Template => out.unfinished |= text.len() <= LONGEST_UNFINISHED,
            WordRole::Unwritten => drop(out.unwritten.get_or_insert((hit.start, hit.end))),
            WordRole::Irrelevant => {
                out.words += 1;
                if !clause.supposed {
                    out.irrelevant.get_or_insert((hit.start, hit.end));
                }
            }
            WordRole::Unobserved => drop(out.unobserved.get_or_insert((hit.start, hit.end))),
            // "Like a bull": not said to be present.
            WordRole::Likened => {
                clause.likened = Some(Denial { end: hit.end, is_latin: word.is_ascii() });
            }
            WordRole::NoReason => {
                // "The sedan brakes for no apparent reason": another road user has none.
                // So has he where it begins a clause: "it has slammed on its brakes, for no reason".
                let begins = !text[clause.from..hit.start].contains(char::is_alphanumeric);
                let own = |n: &Named| n.clause == clause.number || begins && n.clause + 1 == clause.number;
                let acts = |n: &Named| own(n) && is_actor(n, words);
                if !out.named.iter().any(acts) {
                    out.no_reason.get_or_insert((hit.start, hit.end));
                }
            }
            WordRole::Distant => {
                out.words += 1;
                out.distant.get_or_insert((hit.start, hit.end));
            }
            WordRole::Beyond => {
                out.words += 1;
                clause.beyond = Some(hit.start);
            }
            WordRole::State(state, doing) => {
                out.words += 1;
                if !clause.act(doing, text, (hit.start, hit.end), &mut out) {
                    // "The car has stopped at the line": an actor, rather than a place.
                    let open = |n: &&mut Named| n.clause == clause.number && n.state.is_none();
                    let acts = |n: &&mut Named| words.objects[n.group].named;
                    let own = out.named.iter_mut().rev().filter(open).find(acts);
                    match own {
                        Some(n) => n.state = Some(state),
                        None => match out.named.last_mut().filter(open) {
                            Some(n) => n.state = Some(state),
                            None => clause.state = Some(state),
                        },
                    }
                }
            }
            WordRole::Color(color) => {
                out.words += 1;
                clause.color = Some(color);
            }
            WordRole::Hindsight => {
                out.words += 1;
                if !is_imagined(text, (hit.start, hit.end), units, words) {
                    out.hindsight.get_or_insert((hit.start, hit.end));
                }
            }
            WordRole::AfterResponse => {
                out.words += 1;
                out.after_response.get_or_insert((hit.start, hit.end));
            }
            WordRole::Resolved => {
                out.words += 1;
                if !clause.supposed && !clause.denied.is_some_and(|d| d.reaches(text, hit.start)) {
                    out.resolved.push((hit.start, hit.end));
                }
            }
            // After a name in English, before it in Chinese.
            WordRole::Ahead if word.is_ascii() => {
                // Of an actor rather than a place: "has pulled up at the line ahead of us".
                let own = || (0..out.named.len()).rev().take_while(|i| out.named[*i].clause == clause.number);
                let acts = |i: &usize| words.objects[out.named[*i].group].own.meets(words.known.actor);
                if let Some(i) = own().find(acts).or_else(|| own().next()) {
                    out.named[i].ahead = true;
                }
            }
            // "The crossroads two hundred meters before the truck": the name comes first in Chinese.
            WordRole::Ahead if is_beyond(text, (hit.start, hit.end), &out, words) => {
                let from = out.named.last().map_or(hit.start, |n| n.start);
                out.distant.get_or_insert((from, hit.end));
            }
            WordRole::Ahead => clause.ahead = true,
            WordRole::Absent => {
                out.acts.push(Act { doing: Doings::default(), denied: true, start: hit.start, end: hit.end });
                // "There is no ice at all" is "ice, none" in Chinese.
                let at_end = || !text[hit.end..].starts_with(|c: char| c.is_alphanumeric());
                if !word.is_ascii()
                    && (text[..hit.start].ends_with(['都', '也', '全']) || at_end())
                    && let Some(n) = out.named.last_mut().filter(|n| n.clause == clause.number)
                    && text.get(n.end..hit.start).is_some_and(is_of_absence)
                {
                    n.absent = true;
                }
                // "Not a sign of backing up" is "backing up, of that no sign" in Chinese.
                if text[..hit.start].ends_with(['都', '也'])
                    && at_end()
                    && let Some(act) = out.acts.last_mut().filter(|a| a.start >= clause.from)
                {
                    act.denied = true;
                }
                let word = Denial { end: hit.end, is_latin: word.is_ascii() };
                (clause.absent, clause.denied) = (Some(word), Some(word));
            }
            WordRole::Denied => clause.denied = Some(Denial { end: hit.end, is_latin: word.is_ascii() }),
            WordRole::Supposed => {
                clause.supposed = true;
                // "A person could step out": nobody is said to be present.
                let last = out.named.last_mut().filter(|n| n.clause == clause.number && word.is_ascii());
                if let Some(n) = last.filter(|n| words.objects[n.group].named) {
                    n.supposed |= is_indefinite(&text[..n.start], words);
                }
            }
            WordRole::Uncertain => {
                clause.supposed = true;
                let own = out.named.iter_mut().rev().take_while(|n| n.clause == clause.number);
                own.for_each(|n| n.supposed = true);
            }
            WordRole::Unchanged => out.unchanged = Some((hit.start, hit.end)),
            WordRole::Plain => {}
        }
    });
    clause.close(&mut out);
    debug_assert!(out.named.is_sorted_by_key(|n| n.start) && out.acts.is_sorted_by_key(|a| a.start));
    out.does = out.acts.iter().filter(|a| !a.denied).fold(Doings::default(), |all, a| all.with(a.doing));
    words.bearing.hits(units, text.len(), |says, start, end| match says {
        Bears::Clear => out.clear.push((start, end)),
        Bears::Harmless => out.harmless.push((start, end)),
        Bears::Idle => drop(out.idle.get_or_insert((start, end))),
        Bears::Apart => drop(out.apart.get_or_insert((start, end))),
        Bears::Done => out.done.push((start, end)),
    });
    out
}

/// "Otherwise it hits us", "at this speed it hits us in two seconds", "the paths cross two seconds later": what would
/// happen, not what did. `at`: bytes of the words that state it.
fn is_imagined(text: &str, at: (usize, usize), units: &Units, words: &LabelWords) -> bool {
    let around = |ends| words.clauses.around(units, at.0..at.1, text.len(), ends);
    let (clause, clause_end) = around(&|d| d != Divider::Aside);
    let (sentence, sentence_end) = around(&|d| d == Divider::Sentence);
    let word = &text[at.0..at.1];
    // "Straight on, and we hit it": behind its condition in Chinese.
    if text[clause..at.0].ends_with('就') {
        return true;
    }
    // "It has stopped raining not long ago": since when something is, with nothing behind it.
    const DURATIONS: [&str; 4] = ["多久", "会儿", "片刻", "会"];
    let ends_clause = !text[at.1..clause_end].contains(char::is_alphanumeric);
    if ends_clause && at.1 < text.len() && DURATIONS.iter().any(|d| word.ends_with(d)) {
        return true;
    }
    // "A bollard sticks out a little further on": where something is, unless it is told in the past tense.
    if word.is_ascii() && word.ends_with("ther on") && !has_past(&text[sentence..sentence_end], words) {
        return true;
    }
    let imagined = text[clause..at.0].to_ascii_lowercase();
    // "At this speed, two seconds later": in the sentence before it, or in the clause after it.
    words.imagined.iter().any(|w| imagined.contains(w.as_str()))
        || is_predicted(&text[sentence..at.0], words)
        || is_predicted(&text[at.1..clause_end], words)
}

/// The part says what may come: "if", "would", "the predicted path".
pub(super) fn is_predicted(part: &str, words: &LabelWords) -> bool {
    let part = part.to_ascii_lowercase();
    words.predicted.iter().any(|w| part.contains(w.as_str()))
}

/// The part has a past tense in English.
fn has_past(part: &str, words: &LabelWords) -> bool {
    part.split(|c: char| !c.is_ascii_alphabetic()).map(str::to_ascii_lowercase).any(|w| {
        w.len() >= 5 && w.ends_with("ed") && !w.ends_with("eed")
            || w != "left" && words.aftermath.told.contains(&w)
    })
}

/// The named thing is a road user, which may act.
fn is_actor(n: &Named, words: &LabelWords) -> bool {
    !n.absent && words.objects[n.group].own.meets(words.known.actor)
}

/// The text in Chinese between a name and the words for its absence: "ice, a bit of it there is not". With any other
/// text between them, something else is absent: "the car, its lights are not on".
fn is_of_absence(between: &str) -> bool {
    between.chars().all(|c| "一点个辆人根本半丝压毫都也全些儿种，, ".contains(c))
}

/// The next name in a Latin text means any of its kind: no article or pronoun within three words before it.
fn is_indefinite(before: &str, words: &LabelWords) -> bool {
    let last = before.rsplit(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).take(3);
    !last.into_iter().any(|w| words.subjects.definite.iter().any(|d| w.eq_ignore_ascii_case(d)))
}

/// The color right before a name in Chinese: "红卡车".
fn color_before(text: &str, start: usize, words: &LabelWords) -> Option<usize> {
    let c = text[..start].chars().next_back().filter(|c| !c.is_ascii())?;
    words.color_chars.iter().find(|(own, _)| *own == c).map(|(_, i)| *i)
}

/// The word at `at`, "before" in Chinese, follows the name of a road user and is followed by a long distance.
fn is_beyond(text: &str, (start, end): (usize, usize), out: &TextFacts, words: &LabelWords) -> bool {
    let follows =
        |n: &Named| n.end == start && !n.absent && words.objects[n.group].own.meets(words.known.actor);
    out.named.last().is_some_and(follows) && words.numbers.begins_long_distance(&text[end..])
}

/// `text` begins with `word`, in upper or lower case.
fn starts_with(text: &str, word: &str) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// The side of a lane that describes the location or origin of a road user: "the car in the left lane",
/// "右侧车道的轿车". Not the side of a lane to which a road user goes.
fn lane_side(text: &str, start: usize, end: usize) -> Option<bool> {
    let word = &text[start..end];
    if word.is_ascii() {
        let left = match word.as_bytes().first()? {
            b'l' | b'L' if word.len() == 9 => true,
            b'r' | b'R' if word.len() == 10 => false,
            _ => return None,
        };
        let before = text[..start].trim_end();
        let from = ["from the", "in the", "on the"].iter().any(|w| before.ends_with(w));
        return (from && word.ends_with("lane")).then_some(left);
    }
    let left = match word.chars().next()? {
        '左' => true,
        '右' => false,
        _ => return None,
    };
    let goes = text[..start].ends_with(['向', '往', '到', '至', '入', '进']);
    let of = text[end..].starts_with(['的', '上', '内', '里', '一', '那', '有', '停', '并', '跟'])
        || text[..start].ends_with(['从', '自']);
    (word.ends_with("车道") && of && !goes).then_some(left)
}

/// A word that negates the text after it.
#[derive(Clone, Copy)]
struct Denial {
    end: usize,
    is_latin: bool,
}

impl Denial {
    /// True when the text at `at` is close enough to be negated.
    fn reaches(self, text: &str, at: usize) -> bool {
        let reach = if self.is_latin { BETWEEN_LATIN } else { BETWEEN_CHINESE };
        // "Without a signal it comes out": 不打灯就……
        let between = &text[self.end..at];
        between.chars().nth(reach).is_none() && !between.contains('就')
    }
}

/// State since the last end of a clause.
#[derive(Default)]
struct Clause {
    number: usize,
    /// Its first byte.
    from: usize,
    side: Option<bool>,
    color: Option<usize>,
    state: Option<SaidState>,
    absent: Option<Denial>,
    denied: Option<Denial>,
    likened: Option<Denial>,
    supposed: bool,
    ahead: bool,
    /// First byte of a distance beyond the thing that is named next.
    beyond: Option<usize>,
    names: usize,
    /// Things named before this sentence.
    sentence: usize,
}

impl Clause {
    /// Adds a statement about the named things. Returns true when it is negated.
    fn act(&self, doing: Doings, text: &str, (start, end): (usize, usize), out: &mut TextFacts) -> bool {
        let denied = self.denied.is_some_and(|d| d.reaches(text, start));
        if !self.supposed {
            out.acts.push(Act { doing, denied, start, end });
        }
        denied
    }

    /// "The car on the left": after the name, of an actor rather than a place. In Chinese the side comes first.
    fn say_side(&mut self, left: bool, is_behind: bool, words: &LabelWords, out: &mut TextFacts) {
        let number = self.number;
        let own = out.named.iter_mut().rev().take_while(|n| n.clause == number);
        let mut open = own.filter(|n| n.side.is_none());
        let last = open.next();
        let behind = match last {
            Some(n) if words.objects[n.group].named => Some(n),
            Some(n) => Some(open.find(|n| words.objects[n.group].named).unwrap_or(n)),
            None => None,
        };
        match behind {
            Some(n) if is_behind => n.side = Some(left),
            // "A woman is on the crosswalk, coming from the left".
            None if is_behind && self.names == 0 => {
                let before = out.named.iter_mut().skip(self.sentence).rev();
                let mut acts = before.filter(|n| words.objects[n.group].named && n.side.is_none());
                match acts.next() {
                    Some(n) => n.side = Some(left),
                    None => self.side = Some(left),
                }
            }
            _ => self.side = Some(left),
        }
    }

    fn close(&self, out: &mut TextFacts) {
        // "A lorry, blue,": after the name, in a clause of its own.
        if let (Some(color), 0) = (self.color, self.names)
            && let Some(n) = out.named.last_mut().filter(|n| n.color.is_none() && n.clause + 1 == self.number)
        {
            n.color = Some(color);
        }
        let Some(state) = self.state else { return };
        let first = out.named.partition_point(|n| n.clause < self.number);
        match out.named[first..].iter_mut().find(|n| n.state.is_none()) {
            Some(n) if self.names > 0 => n.state = Some(state),
            _ => out.states.push(state),
        }
    }
}

/// The part of `all`, which ascend by their first byte, that begins in these bytes.
pub(super) fn starting_in<T>(all: &[T], start: impl Fn(&T) -> usize, from: usize, to: usize) -> &[T] {
    let first = all.partition_point(|x| start(x) < from);
    let end = first + all[first..].partition_point(|x| start(x) < to);
    &all[first..end]
}

impl TextFacts {
    /// Things that are said to be present.
    pub fn there(&self) -> impl Iterator<Item = &Named> {
        self.named.iter().filter(|n| n.is_there())
    }

    /// Things whose names begin in these bytes.
    pub fn named_in(&self, from: usize, to: usize) -> &[Named] {
        starting_in(&self.named, |n| n.start, from, to)
    }

    /// Statements that begin in these bytes.
    pub fn acts_in(&self, from: usize, to: usize) -> &[Act] {
        starting_in(&self.acts, |a| a.start, from, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_framework::Framework;

    fn said(text: &str) -> Vec<String> {
        let words = Framework::bundled().label_words();
        let facts = read(text, &Units::of(text), words);
        facts
            .named
            .iter()
            .map(|n| {
                let mut s = words.objects[n.group].id.clone();
                s += match n.side {
                    Some(true) => " left",
                    Some(false) => " right",
                    None => "",
                };
                if let Some(state) = n.state {
                    s += &format!(" {state:?}");
                }
                s + if n.absent { " absent" } else { "" } + if n.supposed { " supposed" } else { "" }
            })
            .collect()
    }

    #[test]
    fn a_lane_that_leads_somewhere_is_no_lead() {
        let names_lead = |text: &str| said(text).iter().any(|n| n.starts_with("lead"));
        for verb in [
            "The ego's lane does not lead where its route goes, but the next one does",
            "By then the lane may lead elsewhere",
            "The road may lead into the tunnel",
        ] {
            assert!(!names_lead(verb), "{verb}");
        }
        for noun in ["The lead stops where the road narrows", "We follow the lead into the tunnel"] {
            assert!(names_lead(noun), "{noun}");
        }
    }

    #[test]
    fn things_have_side_state_and_mood() {
        assert_eq!(said("左前方白色轿车切入，右侧货车并行"), ["car left CuttingIn", "truck right"]);
        assert_eq!(said("后方没有来车，前车已停"), ["vehicle_any absent", "lead Standing"]);
        assert_eq!(said("若行人突然出现"), ["pedestrian supposed"]);
        assert_eq!(
            said("A cyclist on the right is crossing; no other vehicles."),
            ["rider right Crossing", "vehicle_any absent"]
        );
        assert_eq!(said("There is a parked van on the left"), ["parked_vehicle left"]);
        assert_eq!(
            said("右侧车道的黑色轿车正在靠近，没有车从左侧来"),
            ["lane", "car right", "vehicle_any absent"]
        );
        assert_eq!(said("自车向左侧车道变道避开事故车"), ["lane", "broken_down"]);
        assert_eq!(said("A truck enters the junction from the right"), ["truck right", "junction"]);
        assert_eq!(said("A van from the left lane moves over"), ["car left", "lane"]);
    }
}
