//! The components of a draft in one language, and what they are in its trace: what calls for the decision, what makes
//! room for it, and what is nearer than the subject of the class. Everything but the words is the same in both
//! languages.

use super::components::{Scene, is_light, says_standing};
use super::lead::Lead;
use super::moment::Moment;
use super::trace::{self, StateOrder};
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::messages::{CriticalComponent, DrivingDecision, Uncertainty};
use whyroad_model::{Lang, TrackId};

/// Settings of a skeleton.
#[derive(Clone, Copy)]
pub(super) struct How<'a> {
    /// Language of the draft.
    pub lang: Lang,
    /// Seed of the phrasings.
    pub run: u64,
    /// Components that Stage I lists; `None` where all may be named.
    pub listed: Option<&'a [CriticalComponent]>,
}

impl How<'_> {
    /// The object may be named in addition to the subject of the class.
    pub(super) fn names(&self, object: &TrackId) -> bool {
        let links = |c: &CriticalComponent| c.linked_objects.iter().any(|id| id == object.as_str());
        self.listed.is_none_or(|listed| listed.iter().any(links))
    }

    /// The component, whose text is in `lang`, may be named in addition to the subject of the class.
    fn lists(&self, component: &CriticalComponent, lang: Lang) -> bool {
        let in_words = |c: &CriticalComponent| lang != self.lang || c.description == component.description;
        let said = |c: &CriticalComponent| is_same(c, component) && in_words(c);
        self.listed.is_none_or(|listed| listed.iter().any(said))
    }

    /// Gives each component the text that it has in Stage I, for which less was known about the subject of the class.
    /// True if that says of one that it stands, where the whole drive shows otherwise.
    fn reword(&self, components: &mut [CriticalComponent]) -> bool {
        let mut moved = false;
        let mut left: Vec<&CriticalComponent> = self.listed.into_iter().flatten().collect();
        for c in components {
            if let Some(at) = left.iter().position(|of| is_same(of, c)) {
                let listed = &left.remove(at).description;
                moved |= says_standing(listed) && !says_standing(&c.description);
                c.description.clone_from(listed);
            }
        }
        moved
    }
}

/// True when both components describe the same thing.
pub fn is_same(a: &CriticalComponent, b: &CriticalComponent) -> bool {
    a.category == b.category && a.linked_objects == b.linked_objects
}

/// What is named, whatever the language.
pub(super) struct Named<'a> {
    pub scene: &'a Scene<'a>,
    pub moment: &'a Moment<'a>,
    pub how: How<'a>,
    pub decision: &'a DrivingDecision,
    /// The lead that is the nearest cause.
    pub by_lead: Option<Lead<'a>>,
    /// A lead that slows the ego although the class requires a decision other than following.
    pub beside: Option<Lead<'a>>,
    /// The light may be named.
    pub has_light: bool,
    /// A light that is named is the nearest cause.
    pub light_decides: bool,
}

/// The components in one language.
pub(super) struct Subjects {
    pub components: Vec<CriticalComponent>,
    pub order: StateOrder,
    /// Index of the component that announces the turn of an ego whose class is not about it.
    pub of_turn: Option<usize>,
    /// Index of the component that is the cause of the longitudinal decision.
    pub along: usize,
    pub by_light: bool,
    /// Stage I lists one as standing that does not stand: what is said of its motion would contradict that.
    pub has_moved: bool,
}

impl Named<'_> {
    pub(super) fn in_language(&self, lang: Lang) -> Subjects {
        let Named { scene, moment, decision, .. } = *self;
        let lists = |c: &CriticalComponent| self.how.lists(c, lang);
        let observed = scene.observed(moment, lang);
        let mut components = with_cause(scene, observed, moment, lang);
        let mut also = trace::also(scene.framework, &scene.episode.scenario_id, moment, lang).filter(lists);
        let mut order = StateOrder::FirstLast;
        let (mut of_turn, mut along) = (None, 0);
        if let Some(component) = self.by_lead.and_then(|lead| scene.lead(&lead, lang)) {
            // The component nearest to the ego comes last, because the text after it refers to it.
            order = StateOrder::AsListed;
            along = components.len().min(1);
            components.insert(along, component);
            also = None;
        } else if scene.has_course
            && components.len() < trace::MOST_IN_STATE
            && decision.lateral == Some(Lateral::Turn)
        {
            let intent = scene.turn_intent(moment, lang).filter(lists);
            of_turn = intent.is_some().then_some(components.len());
            components.extend(intent);
        }
        let names_light = components.iter().chain(&also).any(is_light);
        let light = scene.light(moment, lang).filter(|c| self.has_light && !names_light && lists(c));
        also = also.or_else(|| self.beside.and_then(|lead| scene.lead(&lead, lang)));
        // The ego fits its speed to those beside it, who are named with the reason for its maneuver.
        let is_of_gap = |c: &CriticalComponent| !c.linked_objects.is_empty();
        if decision.longitudinal == Some(Longitudinal::GapMatching) && also.as_ref().is_some_and(is_of_gap) {
            components.truncate(1);
            along = components.len();
        }
        // The component that makes room for the decision comes after the one that calls for it.
        if also.is_some() && components.len() < trace::MOST_IN_STATE {
            order = StateOrder::AsListed;
        }
        components.extend(also);
        let by_light = light.is_some() && self.light_decides;
        if let Some(component) = light {
            if by_light {
                // What the text after it refers to comes last.
                order = StateOrder::AsListed;
                components.truncate(1);
                along = components.len();
                components.push(component);
            } else if components.len() < trace::MOST_IN_STATE {
                components.push(component);
            }
        }
        components.truncate(trace::MOST_IN_STATE);
        let has_moved = lang == self.how.lang && self.how.reword(&mut components);
        Subjects { components, order, of_turn, along, by_light, has_moved }
    }
}

/// Inserts the component that every episode of the class has as the first one, if the `observed` ones do not show it;
/// where the course is known, in the words for this moment. The Chinese texts decide what a component is about, so that
/// drafts of both languages have the same ones.
pub(super) fn with_cause(
    scene: &Scene<'_>,
    mut observed: Vec<CriticalComponent>,
    moment: &Moment<'_>,
    lang: Lang,
) -> Vec<CriticalComponent> {
    let (framework, class) = (scene.framework, &scene.episode.scenario_id);
    let in_chinese = (lang != Lang::Zh).then(|| scene.observed(moment, Lang::Zh));
    let found = in_chinese.as_ref().unwrap_or(&observed);
    if let Some(seen) = trace::seen(framework, class, found, moment, lang) {
        observed.insert(0, seen);
    }
    // LABELING.md 3: at least one component about a hidden road user is uncertain.
    let is_high = |c: &CriticalComponent| c.uncertainty == Some(Uncertainty::High);
    if framework.specs.get(class).is_some_and(|s| s.uncertainty_high)
        && !observed.iter().any(is_high)
        && let Some(first) = observed.first_mut()
    {
        first.uncertainty = Some(Uncertainty::High);
    }
    observed
}
