//! Words for statements that are recognized by their place in a text rather than as phrases (`forms` of
//! `schema/label_words.yaml`): what the ego does in the last sentence of a trace, a component that only describes the
//! road, a place where nothing is.

use super::Words;
use super::compile::expanded;
use crate::phrases::Phrases;
use serde::Deserialize;
use whyroad_model::Bilingual;

/// All lists, in lower case.
#[derive(Clone, Debug, Default)]
pub struct Forms {
    /// Of the road and the weather as they mostly are.
    pub ordinary: Phrases,
    /// Parts of the course of the ego, and words for what stays the same.
    pub course: Phrases,
    /// See `course`.
    pub same: Phrases,
    /// Nothing is there.
    pub free: Phrases,
    /// A reason follows.
    pub because: Phrases,
    /// What was named is not the reason.
    pub not_reason: Phrases,
    /// Who was named makes no difference to the ego.
    pub no_bearing: Phrases,
    /// Before one of these two: it is only supposed.
    pub supposed: Phrases,
    /// Before the name of a road user that only locates something else.
    pub between: Phrases,
    /// Not on the ego's lane, but on both sides of it, or on another one.
    pub both_sides: Phrases,
    /// Movements of the ego out of its lane.
    pub sideways: Phrases,
    /// A clause about the ego begins with one.
    pub begins: Phrases,
    /// Before a movement: somebody else moves, or may.
    pub others: Phrases,
    /// Hold one of `others` and mean nobody else.
    pub not_others: Phrases,
    /// Negations, conditions and plans.
    pub denied: Phrases,
    /// Before what the ego does not do, in a component.
    pub instead: Phrases,
    /// Behind a movement: room for it.
    pub room: Phrases,
    /// Speed and what sets it, and words with which a clause does not state that it is kept.
    pub pace: Phrases,
    /// See `pace`.
    pub kept: Phrases,
    /// See `pace`.
    pub changed: Phrases,
    /// Before a side: a movement to it.
    pub towards: Phrases,
    /// The ego goes on as fast as it was, or faster, or past.
    pub going: Phrases,
    /// The ego slows.
    pub slowing: Phrases,
    /// Words that divide a sentence into clauses.
    pub links: Phrases,
    /// The ego, and what may stand between it and its verb.
    pub of_ego: Phrases,
    /// Before what is not done, or by somebody else.
    pub not_of_ego: Phrases,
    /// Movements of the ego to the side.
    pub aside: Phrases,
    /// Where they lead.
    pub place: Phrases,
    /// Between the two: where something is.
    pub placed: Phrases,
    /// After a side: it is none.
    pub no_side: Phrases,
    /// Any word for a maneuver to the side.
    pub lateral: Phrases,
    /// Of what another component names: it has gone.
    pub over: Phrases,
    /// See `over`.
    pub already: Phrases,
    /// See `over`.
    pub gone: Phrases,
    /// The state before the keyframe.
    pub as_before: Phrases,
    /// The ego slows.
    pub slows: Phrases,
    /// Behind one of `slows`: a name.
    pub slow_names: Phrases,
    /// A clause that foresees begins with one.
    pub if_so: Phrases,
    /// See `if_so`.
    pub then_so: Phrases,
    /// A response of the ego.
    pub responds: Phrases,
    /// Words for a movement within the lane.
    pub nudges: Phrases,
    /// What the ego has, is or can.
    pub stative: Phrases,
    /// A sentence that begins with one may be an order.
    pub orders: Phrases,
    /// Finite verbs for how something is.
    pub is: Phrases,
    /// With one of these a sentence may be about the ego.
    pub controls: Phrases,
}

/// The lists as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawForms {
    ordinary: Words,
    course: Words,
    same: Words,
    free: Words,
    because: Words,
    not_reason: Words,
    no_bearing: Words,
    supposed: Words,
    between: Words,
    both_sides: Words,
    sideways: Words,
    begins: Words,
    others: Words,
    not_others: Words,
    denied: Words,
    instead: Words,
    room: Words,
    pace: Words,
    kept: Words,
    changed: Words,
    towards: Words,
    going: Words,
    slowing: Words,
    links: Words,
    of_ego: Words,
    not_of_ego: Words,
    aside: Words,
    place: Words,
    placed: Words,
    no_side: Words,
    lateral: Words,
    over: Words,
    already: Words,
    gone: Words,
    as_before: Words,
    slows: Words,
    slow_names: Words,
    if_so: Words,
    then_so: Words,
    responds: Words,
    nudges: Words,
    stative: Words,
    orders: Words,
    is: Words,
    controls: Words,
}

impl RawForms {
    pub(super) fn compile(&self, problems: &mut Vec<Bilingual>) -> Forms {
        let mut all = |w: &Words| Phrases::new(w.all().flat_map(|p| expanded(p, problems)).collect());
        Forms {
            ordinary: all(&self.ordinary),
            course: all(&self.course),
            same: all(&self.same),
            free: all(&self.free),
            because: all(&self.because),
            not_reason: all(&self.not_reason),
            no_bearing: all(&self.no_bearing),
            supposed: all(&self.supposed),
            between: all(&self.between),
            both_sides: all(&self.both_sides),
            sideways: all(&self.sideways),
            begins: all(&self.begins),
            others: all(&self.others),
            not_others: all(&self.not_others),
            denied: all(&self.denied),
            instead: all(&self.instead),
            room: all(&self.room),
            pace: all(&self.pace),
            kept: all(&self.kept),
            changed: all(&self.changed),
            towards: all(&self.towards),
            going: all(&self.going),
            slowing: all(&self.slowing),
            links: all(&self.links),
            of_ego: all(&self.of_ego),
            not_of_ego: all(&self.not_of_ego),
            aside: all(&self.aside),
            place: all(&self.place),
            placed: all(&self.placed),
            no_side: all(&self.no_side),
            lateral: all(&self.lateral),
            over: all(&self.over),
            already: all(&self.already),
            gone: all(&self.gone),
            as_before: all(&self.as_before),
            slows: all(&self.slows),
            slow_names: all(&self.slow_names),
            if_so: all(&self.if_so),
            then_so: all(&self.then_so),
            responds: all(&self.responds),
            nudges: all(&self.nudges),
            stative: all(&self.stative),
            orders: all(&self.orders),
            is: all(&self.is),
            controls: all(&self.controls),
        }
    }
}
