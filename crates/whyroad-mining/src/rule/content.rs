//! Everything that a rule consists of as bytes, so that rules can be told apart by a hash. Each rule of a run is hashed
//! at its start: texts are copied as they are, and only what has none is printed.

use super::{Part, Rule, SecondRole, Timing};
use crate::language::check::Structure;
use crate::language::program::Atom;
use std::fmt::{Debug, Write as _};
use whyroad_model::Bilingual;

impl Rule {
    /// All of the rule: rules whose bytes are equal find the same in every drive, and say the same about it.
    pub fn content(&self) -> Vec<u8> {
        // Every field is named, so that none that is added later can be forgotten.
        let Self {
            scenario,
            subject,
            target_role,
            second,
            program,
            when,
            require,
            response,
            atoms,
            parts,
            listed,
            min_duration,
            max_duration,
            merge_gap,
            lengthy,
            timing,
        } = self;
        let mut out = Content(String::new());
        out.printed(&(scenario, subject, when, require, response, listed));
        out.printed(&(min_duration, max_duration, merge_gap));
        out.text(target_role);
        out.some(second.as_ref(), |out, SecondRole { name, subject }| {
            out.text(name);
            out.printed(subject);
        });
        out.printed(program);
        out.each(atoms, Content::atom);
        out.each(parts, Content::part);
        out.each(lengthy, |out, (name, words)| {
            out.text(name);
            out.bilingual(words);
        });
        out.timing(timing);
        out.0.into_bytes()
    }
}

/// Bytes of what was added, each with its length or at its place, so that they can be read in one way only.
struct Content(String);

impl Content {
    /// What contains no texts for people.
    fn printed(&mut self, value: &impl Debug) {
        // Numbers print with all their digits. Writing to a text does not fail.
        let _ = write!(self.0, "{value:?};");
    }

    fn text(&mut self, text: &str) {
        let _ = write!(self.0, "{}:", text.len());
        self.0.push_str(text);
    }

    fn bilingual(&mut self, Bilingual { zh, en }: &Bilingual) {
        self.text(zh);
        self.text(en);
    }

    fn each<T>(
        &mut self,
        all: impl IntoIterator<Item = T, IntoIter: ExactSizeIterator>,
        add: impl Fn(&mut Self, T),
    ) {
        let all = all.into_iter();
        let _ = write!(self.0, "{}[", all.len());
        all.for_each(|one| add(self, one));
    }

    fn some<T>(&mut self, value: Option<T>, add: impl Fn(&mut Self, T)) {
        self.0.push(if value.is_some() { '+' } else { '-' });
        value.into_iter().for_each(|value| add(self, value));
    }

    fn atom(&mut self, atom: &Atom) {
        let Atom { text, words, condition, measured, signals, unit, value_names, threshold, is_denied } =
            atom;
        self.text(text);
        self.bilingual(words);
        self.each(signals, |out, name| out.text(name));
        self.each(value_names, |out, (value, name)| {
            out.text(value);
            out.bilingual(name);
        });
        self.printed(&(condition, measured, unit, threshold, is_denied));
    }

    fn part(&mut self, part: &Part) {
        let Part { place, text, words, condition, atoms, structure } = part;
        self.printed(&(place, condition));
        self.text(text);
        self.bilingual(words);
        self.each(atoms, Self::atom);
        self.structure(structure);
    }

    fn structure(&mut self, structure: &Structure) {
        let Structure { shown, definition, is_named, join, members, is_listed_above } = structure;
        self.atom(shown);
        self.some(definition.as_deref(), Self::text);
        self.printed(&(is_named, join, is_listed_above));
        self.each(members, Self::structure);
    }

    fn timing(&mut self, timing: &Timing) {
        let Timing {
            kind,
            keyframe,
            at_match_start,
            second_keyframe,
            start,
            end,
            before,
            after,
            after_until,
        } = timing;
        self.each(keyframe, |out, (moment, words)| {
            out.printed(moment);
            out.bilingual(words);
        });
        self.bilingual(at_match_start);
        self.printed(&(kind, second_keyframe, start, end, before, after, after_until));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rule::RuleSet;
    use std::collections::{BTreeMap, BTreeSet};
    use whyroad_framework::Framework;
    use whyroad_signals::Catalog;

    #[test]
    fn contents_are_equal_where_rules_are() {
        let rules = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0.rules;
        let again = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0.rules;
        let contents: Vec<Vec<u8>> = rules.iter().map(Rule::content).collect();
        assert_eq!(contents, again.iter().map(Rule::content).collect::<Vec<_>>());
        assert_eq!(contents.iter().collect::<BTreeSet<_>>().len(), rules.len());
    }

    #[test]
    fn every_text_counts() {
        type Change = (&'static str, fn(&mut Rule));
        let rules = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0.rules;
        let rule = rules.iter().find(|r| r.atoms.iter().any(|a| !a.value_names.is_empty())).unwrap();
        let changes: [Change; 9] = [
            ("words of an atom", |r| r.atoms[0].words.zh.push('。')),
            ("text moved to the words", |r| {
                let last = r.atoms[0].text.pop().unwrap();
                r.atoms[0].words.zh.insert(0, last);
            }),
            ("name of a value", |r| {
                let atom = r.atoms.iter_mut().find(|a| !a.value_names.is_empty()).unwrap();
                atom.value_names = BTreeMap::new();
            }),
            ("threshold", |r| r.atoms[0].threshold = Some(0.1 + 0.2)),
            ("words of a part", |r| r.parts[0].words.en.push('.')),
            ("structure", |r| r.parts[0].structure.is_listed_above ^= true),
            ("text of the keyframe", |r| r.timing.at_match_start.zh.push('。')),
            ("context", |r| r.timing.before.0 += 1),
            ("program", |r| drop(r.program.nodes.pop())),
        ];
        for (what, change) in changes {
            let mut other = rule.clone();
            change(&mut other);
            assert_ne!(rule.content(), other.content(), "{what}");
        }
    }
}
