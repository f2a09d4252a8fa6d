//! What the components say of the things that the trace names: collected once for each group of things, so that long
//! texts take time in proportion to their length.

use crate::check::reading::{Named, TextFacts};
use crate::check::subject;
use crate::check::texts::TextScope;
use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;
use whyroad_framework::LabelWords;
use whyroad_framework::label_words::{Doings, GroupSet};

/// Sides and colors.
#[derive(Default)]
pub(super) struct Marks {
    pub sides: BTreeSet<bool>,
    pub colors: BTreeSet<usize>,
}

/// Stated numbers of a thing.
#[derive(Default)]
pub(super) struct Counts {
    pub sum: f64,
    pub number: usize,
    /// Without repetitions.
    pub different: Vec<f64>,
}

/// A named thing with the text of its component.
type InText<'a> = (Option<&'a str>, &'a Named);

/// Results by key, each computed once.
struct Memo<K, V>(RefCell<HashMap<K, V>>);

impl<K: Eq + std::hash::Hash, V: Clone> Memo<K, V> {
    fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        if let Some(known) = self.0.borrow().get(&key) {
            return known.clone();
        }
        let value = make();
        self.0.borrow_mut().insert(key, value.clone());
        value
    }
}

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

/// What the components of a label say.
pub(super) struct Given<'a> {
    scope: &'a TextScope<'a>,
    trace: &'a str,
    painted: OnceCell<BTreeSet<char>>,
    /// Whether the trace, and each component, says that something is oncoming.
    opposite: OnceCell<(bool, Vec<bool>)>,
    /// Road users that the trace names in each clause.
    actors: OnceCell<HashMap<usize, usize>>,
    /// By group.
    meant: Memo<usize, Rc<Marks>>,
    is_opposite: Memo<usize, bool>,
    counts: Memo<u64, Rc<Counts>>,
    turns: Memo<u64, BTreeSet<bool>>,
    doing: Memo<u64, Option<Doings>>,
    /// By group and name.
    other_kind: Memo<(usize, String), bool>,
    kinds: OnceCell<Vec<OfKind<'a>>>,
}

/// A thing of a component with the families of its name, and the kinds of each.
struct OfKind<'a> {
    text: &'a str,
    named: &'a Named,
    name: String,
    kinds: Vec<(usize, u64)>,
}

impl OfKind<'_> {
    fn of(&self, family: usize) -> u64 {
        self.kinds.iter().find(|(f, _)| *f == family).map_or(0, |(_, kinds)| *kinds)
    }
}

impl<'a> Given<'a> {
    pub fn of(scope: &'a TextScope<'a>, trace: &'a str) -> Self {
        Self {
            scope,
            trace,
            painted: OnceCell::new(),
            opposite: OnceCell::new(),
            actors: OnceCell::new(),
            meant: Memo::default(),
            is_opposite: Memo::default(),
            counts: Memo::default(),
            turns: Memo::default(),
            doing: Memo::default(),
            other_kind: Memo::default(),
            kinds: OnceCell::new(),
        }
    }

    /// Texts and facts of the components.
    fn parts(&self) -> impl Iterator<Item = (Option<&'a str>, &'a TextFacts)> {
        let TextScope { label, texts, .. } = *self.scope;
        label.parts.iter().zip(&texts.components).map(|(c, f)| (c.description.get(), f))
    }

    /// The things that are said to be present.
    fn there(&self) -> impl Iterator<Item = InText<'a>> {
        self.parts().flat_map(|(text, f)| f.there().map(move |n| (text, n)))
    }

    fn own(&self, n: &Named) -> GroupSet {
        self.scope.words.objects[n.group].own
    }

    fn near(&self, n: &Named) -> GroupSet {
        self.scope.words.objects[n.group].near
    }

    /// The names for the same thing, with their texts.
    fn same(&self, own: GroupSet) -> impl Iterator<Item = (&'a str, &'a Named)> {
        self.there().filter_map(move |(t, m)| Some((t?, m)).filter(|_| self.own(m) == own))
    }

    /// Colors that are part of the name of a car.
    pub fn painted(&self) -> &BTreeSet<char> {
        let words = self.scope.words;
        self.painted.get_or_init(|| self.there().filter_map(|(t, n)| painted(t, n, words)).collect())
    }

    /// Sides and colors of the things with the same name, otherwise of all that may be meant.
    pub fn meant(&self, n: &Named) -> Rc<Marks> {
        self.meant.get(n.group, || {
            let words = self.scope.words;
            let named = || self.there().map(|(_, c)| c).filter(|c| words.objects[c.group].named);
            let mut marks = Marks::default();
            let mut add = |c: &Named| {
                marks.sides.extend(c.side);
                marks.colors.extend(c.color);
            };
            if named().any(|c| self.own(c) == self.own(n)) {
                named().filter(|c| self.own(c) == self.own(n)).for_each(&mut add);
            } else {
                named().filter(|c| self.own(c).meets(self.near(n))).for_each(&mut add);
            }
            Rc::new(marks)
        })
    }

    /// "From the right" of a road user that is oncoming in its component.
    pub fn is_opposite(&self, n: &Named) -> bool {
        let words = self.scope.words;
        let says_opposite = |text: &str| {
            let lower = text.to_ascii_lowercase();
            words.subjects.opposite.iter().any(|w| lower.contains(w.as_str()))
        };
        let (of_trace, of_parts) = self.opposite.get_or_init(|| {
            let of_parts = self.parts().map(|(t, _)| t.is_some_and(says_opposite)).collect();
            (says_opposite(self.trace), of_parts)
        });
        if *of_trace || !self.own(n).meets(words.known.actor) {
            return false;
        }
        self.is_opposite.get(n.group, || {
            let same = |f: &TextFacts| f.there().any(|c| self.own(c).meets(self.near(n)));
            let parts = || self.parts().map(|(_, f)| f).zip(of_parts);
            let sided = |f: &TextFacts| f.there().any(|c| c.side.is_some());
            !parts().any(|(f, _)| sided(f) && same(f)) && parts().any(|(f, says)| *says && same(f))
        })
    }

    /// The numbers of the same thing, as `count` reads them.
    pub fn counts(&self, n: &Named, count: &dyn Fn(&str, &Named) -> Option<f64>) -> Rc<Counts> {
        let own = self.own(n);
        self.counts.get(own.0, || {
            let mut out = Counts::default();
            for value in self.same(own).filter_map(|(t, m)| count(t, m)) {
                out.sum += value;
                out.number += 1;
                if !out.different.contains(&value) {
                    out.different.push(value);
                }
            }
            Rc::new(out)
        })
    }

    /// The sides of the same thing.
    pub fn turns(&self, n: &Named) -> BTreeSet<bool> {
        let own = self.own(n);
        self.turns.get(own.0, || self.same(own).filter_map(|(t, m)| turned(t, m)).collect())
    }

    /// What a road user does that only one component names, and which is the only one in it.
    pub fn doing(&self, n: &Named) -> Option<Doings> {
        let own = self.own(n);
        self.doing.get(own.0, || {
            let words = self.scope.words;
            let mut same = self.parts().map(|(_, f)| f).filter(|f| f.there().any(|m| self.own(m) == own));
            let (Some(given), None) = (same.next(), same.next()) else { return None };
            let actors = given.there().filter(|m| self.own(m).meets(words.known.actor));
            (!given.does.is_empty() && actors.take(2).count() < 2).then_some(given.does)
        })
    }

    /// Number of road users that the trace says are present in a clause.
    pub fn actors_in_clause(&self, clause: usize) -> usize {
        let actors = self.actors.get_or_init(|| {
            let mut out = HashMap::new();
            let all = self.scope.texts.trace.there();
            for n in all.filter(|n| self.own(n).meets(self.scope.words.known.actor)) {
                *out.entry(n.clause).or_default() += 1;
            }
            out
        });
        actors.get(&clause).copied().unwrap_or_default()
    }

    /// A pickup in the trace for the hatchback of the components: its kind is none of theirs, and each component that
    /// may be meant was read and has a kind.
    pub fn is_other_kind(&self, n: &Named) -> bool {
        let Some(name) = self.trace.get(n.start..n.end) else { return false };
        let name = name.to_ascii_lowercase();
        self.other_kind.get((n.group, name.clone()), || self.is_kind_of_none(self.own(n), &name))
    }

    fn is_kind_of_none(&self, own: GroupSet, name: &str) -> bool {
        let words = self.scope.words;
        let all = self.kinds.get_or_init(|| {
            let texts = self.parts().filter_map(|(t, f)| Some((t?, f)));
            let all = texts.flat_map(|(t, f)| f.named.iter().map(move |m| (t, m)));
            let mut known: BTreeMap<&str, Vec<(usize, u64)>> = BTreeMap::new();
            all.map(|(text, named)| {
                let name = text.get(named.start..named.end).unwrap_or_default();
                let kinds = known.entry(name).or_insert_with(|| words.apart.kinds(name)).clone();
                OfKind { text, named, name: name.to_ascii_lowercase(), kinds }
            })
            .collect()
        });
        // "The taxi" of a minibus taxi; "the tires" of the ego.
        if words.subjects.is_part(name) || all.iter().any(|o| o.name.contains(name)) {
            return false;
        }
        words.apart.kinds(name).into_iter().any(|(family, said)| {
            let given = all.iter().fold(0, |set, o| set | o.of(family));
            let named: BTreeSet<&str> =
                all.iter().filter(|o| o.of(family) != 0).map(|o| o.name.as_str()).collect();
            // "The trailer", behind a flatbed trailer: refers to it.
            let refers = |o: &OfKind<'_>| {
                !subject::is_introduced(o.text, o.named.start, words)
                    && o.named.side.is_none()
                    && named.iter().any(|other| other.ends_with(&o.name))
            };
            let general = |o: &OfKind<'_>| {
                let there = !o.named.absent && !o.named.supposed && !words.subjects.is_of_many(&o.name);
                there && self.near(o.named).meets(own) && o.of(family) == 0 && !refers(o)
            };
            let has_kind = |t: &str, m: &Named| {
                let kinds = words.apart.kinds(t.get(m.start..m.end).unwrap_or_default());
                kinds.iter().any(|(f, kinds)| *f == family && *kinds != 0)
            };
            given != 0
                && given & said == 0
                && !all.iter().any(general)
                && !self.parts().filter_map(|(t, f)| Some((t?, f))).any(|(t, f)| {
                    !f.named.iter().any(|m| has_kind(t, m))
                        && introduces(t, words)
                        && subject::is_unread(t, f, words)
                })
        })
    }
}

/// A component presents something: "a kid on a scooter", "有个骑手". "He has not looked our way" and "AEB已触发" do
/// not.
fn introduces(text: &str, words: &LabelWords) -> bool {
    let lower = text.to_ascii_lowercase();
    let mut all = lower.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty());
    let counted = text.char_indices().any(|(at, c)| {
        words.subjects.counters.contains(c)
            && text[..at].ends_with(['一', '有', '两', '几', '二', '三', '那', '这'])
    });
    counted || all.any(|w| ["a", "an", "two", "some", "several", "another"].contains(&w))
}

/// The color of a car that is part of its name: "蓝车".
pub(super) fn painted(text: Option<&str>, n: &Named, words: &LabelWords) -> Option<char> {
    let mut word = text?.get(n.start..n.end)?.chars();
    let color = word.next().filter(|c| words.color_chars.iter().any(|(own, _)| own == c))?;
    (word.as_str() == "车").then_some(color)
}

/// A bend or a wall on the other side: as a word of its own, or as a part of its name.
pub(super) fn turned(text: &str, n: &Named) -> Option<bool> {
    let word = text.get(n.start..n.end).unwrap_or_default();
    match word.chars().next() {
        Some('左') => Some(true),
        Some('右') => Some(false),
        _ => n.side,
    }
}
