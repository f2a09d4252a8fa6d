//! The texts of a label after reading, for the rules that compare them.

use super::reading::{self, Named, TextFacts};
use super::view::View;
use whyroad_framework::label_words::GroupSet;
use whyroad_framework::lexicon::units::Units;
use whyroad_framework::{LabelWords, Lexicon};
use whyroad_model::decision::Longitudinal;

/// Input of the rules about the texts.
#[derive(Clone, Copy)]
pub(super) struct TextScope<'a> {
    pub label: &'a View<'a>,
    pub texts: &'a Texts,
    pub words: &'a LabelWords,
    pub lexicon: &'a Lexicon,
    /// Groups that only describe the location of something.
    pub background: GroupSet,
    /// Groups that the class is about.
    pub about: GroupSet,
}

impl TextScope<'_> {
    /// True if the class is about road users only, and the decision answers one.
    pub fn answers_a_road_user(&self) -> bool {
        let answers = matches!(
            self.label.longitudinal.get(),
            Some(
                Longitudinal::LeadFollowing
                    | Longitudinal::YieldToAgent
                    | Longitudinal::StopForObstacle
                    | Longitudinal::Resume
            )
        );
        answers && !self.about.is_empty() && self.about.without(self.words.known.actor).is_empty()
    }
}

/// The texts of a label after reading, shared by all rules.
pub(super) struct Texts {
    /// In the order of the label's parts.
    pub components: Vec<TextFacts>,
    pub trace: TextFacts,
    /// The trace, split into units.
    pub units: Units,
}

impl Texts {
    pub fn of(label: &View<'_>, words: &LabelWords) -> Self {
        let mut units = Units::default();
        let mut facts = |text: Option<&str>| {
            let text = text.unwrap_or_default();
            units.cut(text);
            reading::read(text, &units, words)
        };
        let components = label.parts.iter().map(|c| facts(c.description.get())).collect();
        let trace = facts(label.trace.get());
        Self { components, trace, units }
    }

    /// Groups that contain the things of the components, including absent ones.
    pub fn all_components(&self, words: &LabelWords) -> GroupSet {
        let all = self.components.iter().flat_map(|f| &f.named);
        all.fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].near))
    }

    /// Groups that contain the things that the components say are present. `beside`: for a road user on one side of the
    /// ego, which is not the lead.
    pub fn components_there(&self, words: &LabelWords, beside: bool) -> GroupSet {
        let before = words.known.lead.with(words.known.queue);
        let all = self.components.iter().flat_map(TextFacts::there);
        // "The car ahead on the right" is no lead.
        let is_beside = |n: &&Named| n.side.is_some() || !words.objects[n.group].own.meets(before);
        let all = all.filter(|n| !beside || is_beside(n));
        all.fold(GroupSet::default(), |set, n| set.with(words.objects[n.group].near))
    }
}
