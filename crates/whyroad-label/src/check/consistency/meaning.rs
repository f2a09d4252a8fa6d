//! Two components with the same meaning in other words: compares their things, places, sides, colors, actions,
//! distances and concepts. What one of them leaves out makes no difference, what it adds does.

use crate::check::reading::{Named, TextFacts};
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{ConceptSet, Doings, GroupSet, Quantity};
use whyroad_framework::lexicon::units::Units;

/// Minimum evidence, in halves: a common subject counts as 2, a place as 1, a distance as 3.
const LEAST_EVIDENCE: u32 = 8;
/// The same, where a road user is named by the same word twice, so the second may be another statement about it.
const LEAST_OF_SAME_NAME: u32 = 10;
/// Maximum number of distances that two components have in common.
const MOST_LENGTHS: u32 = 2;
/// Minimum share of the shorter component's content that the other one has, too.
const LEAST_SHARE: f64 = 0.6;
/// Shorter lengths are widths and margins, which things of one kind may have in common.
const LEAST_LENGTH_M: f64 = 3.0;

/// Content of a component.
pub(super) struct Meaning<'t> {
    text: &'t str,
    concepts: ConceptSet,
    /// Things other than places, and the groups that contain them.
    things: GroupSet,
    near: GroupSet,
    places: GroupSet,
    /// Bits: left, right.
    sides: u32,
    /// One bit per color.
    colors: u32,
    does: Doings,
    /// Something cannot be seen, or may be present.
    leaves_open: bool,
    /// Something is not there.
    denies: bool,
    /// The name of the first road user, which may only be a location.
    actor: &'t str,
    begins_with_landmark: bool,
    /// It describes another one of the same kind.
    of_another: bool,
}

impl<'t> Meaning<'t> {
    /// `background`: groups that only describe the location of something.
    pub fn of(text: &'t str, facts: &TextFacts, words: &LabelWords, background: GroupSet) -> Self {
        let place = background.with(words.known.no_cause).with(words.known.road);
        let own = |n: &Named| words.objects[n.group].own;
        let all = |pick: &dyn Fn(&Named) -> GroupSet| {
            facts.named.iter().fold(GroupSet::default(), |set, n| set.with(pick(n)))
        };
        let concepts = words.concepts.of(text, &Units::of(text));
        let actor = facts.named.iter().find(|n| own(n).meets(words.known.actor));
        let sides = facts.named.iter().filter_map(|n| n.side);
        let colors = facts.named.iter().filter_map(|n| n.color);
        Self {
            text,
            concepts,
            things: all(&|n| own(n).without(place)),
            near: all(&|n| words.objects[n.group].near),
            places: all(&|n| own(n).only(place)),
            sides: sides.fold(0, |bits, left| bits | 1 << u32::from(left)),
            colors: colors.fold(0, |bits, color| bits | 1 << color),
            does: facts.does,
            leaves_open: facts.named.iter().any(|n| n.supposed)
                || !concepts.only(words.concepts.unseen).is_empty(),
            denies: facts.named.iter().any(|n| n.absent),
            actor: actor.and_then(|n| text.get(n.start..n.end)).unwrap_or_default(),
            begins_with_landmark: actor.is_some_and(|n| words.subjects.is_landmark(text, n.start, n.end)),
            of_another: words.subjects.speaks_of_second(text),
        }
    }

    /// Both have the same meaning, except for what one of them leaves out.
    pub fn is_same(&self, other: &Self, words: &LabelWords) -> bool {
        let apart = |a: u32, b: u32| a != 0 && b != 0 && a & b == 0;
        if apart(self.sides, other.sides)
            || apart(self.colors, other.colors)
            || self.leaves_open != other.leaves_open
            || self.denies != other.denies
            || self.begins_with_landmark != other.begins_with_landmark
            || self.of_another
            || other.of_another
        {
            return false;
        }
        let shared = self.concepts.only(other.concepts).count()
            + (self.colors & other.colors).count_ones()
            + self.does.only(other.does).0.count_ones()
            + self.things.only(other.near).0.count_ones();
        let evidence = 2 * shared + self.places.only(other.places).0.count_ones();
        let same_name = !self.actor.is_empty() && self.actor.eq_ignore_ascii_case(other.actor);
        let least = if same_name { LEAST_OF_SAME_NAME } else { LEAST_EVIDENCE };
        // Most pairs end here.
        if evidence + 3 * MOST_LENGTHS < least {
            return false;
        }
        let lengths = |m: &Self| -> Vec<Quantity> { words.quantities.lengths(m.text) };
        let numbers = |m: &Self| -> Vec<Quantity> {
            let mut all = words.quantities.all(m.text, &words.subjects.counters);
            all.extend(lengths(m));
            all
        };
        let given = |all: &[Quantity], q: &Quantity| all.iter().any(|o| o.is_about(q));
        let (ours, theirs) = (lengths(self), lengths(other));
        let far = |q: &&Quantity| q.value >= LEAST_LENGTH_M;
        let same = ours.iter().filter(far).filter(|q| given(&theirs, q)).count() as u32;
        let size = |m: &Self, lengths: &[Quantity]| m.size() + lengths.iter().filter(far).count() as u32;
        let (our_size, their_size) = (size(self, &ours), size(other, &theirs));
        let (shorter, longer) = if our_size <= their_size { (self, other) } else { (other, self) };
        let evidence = evidence + 3 * same.min(MOST_LENGTHS);
        let longer = numbers(longer);
        evidence >= least
            && f64::from(evidence) >= 2.0 * LEAST_SHARE * f64::from(our_size.min(their_size))
            && numbers(shorter).iter().all(|q| given(&longer, q))
    }

    /// Neither speaks of another one of a kind, nor has each of them concepts of its own and none in common.
    pub fn may_repeat(&self, other: &Self) -> bool {
        /// Minimum number of a component's own concepts.
        const OWN: u32 = 2;
        let common = self.concepts.only(other.concepts).count();
        let own = |m: &Self| m.concepts.count() - common;
        let differ = common == 0 && own(self) >= OWN && own(other) >= OWN;
        !differ && !self.of_another && !other.of_another
    }

    /// Amount of content, apart from places and distances.
    fn size(&self) -> u32 {
        self.concepts.count()
            + self.colors.count_ones()
            + self.does.0.count_ones()
            + self.things.0.count_ones()
    }
}
