//! Texts that must be one of a few identifiers, and suggestions for others.

use super::finding::{Finding, Sink, Words};
use super::json::Node;
use super::slot::Slot;
use super::walk::Walk;
use crate::taxonomy::did_you_mean;
use whyroad_model::messages::KeyframeType;

/// A closed set: names of its members in messages and for display.
pub struct ClosedSet<T: 'static> {
    /// The finding's code.
    pub code: &'static str,
    /// A member, in Chinese.
    pub zh: &'static str,
    /// A member, in English, with its article.
    pub en: &'static str,
    /// The members.
    pub all: &'static [T],
    /// A member's identifier.
    pub id: fn(T) -> &'static str,
    /// Displayed names in both languages, with their identifiers.
    pub names: Vec<(String, &'static str)>,
}

/// A member of the set by its identifier; any other text is reported with a suggestion.
pub fn choose<'d, T: Copy>(
    walk: &mut Walk<'d>,
    node: Option<&'d Node<'d>>,
    pointer: &str,
    set: &ClosedSet<T>,
) -> Slot<T> {
    let text = match walk.any_text(node, pointer) {
        Slot::Is(t) => t,
        Slot::Absent => return Slot::Absent,
        Slot::Broken => return Slot::Broken,
    };
    if let Some(member) = set.all.iter().find(|m| (set.id)(**m) == text) {
        return Slot::Is(*member);
    }
    walk.report(Finding::error(set.code, pointer.to_owned()), &|| {
        let words = Words::new(format!("'{text}' 不是{}", set.zh), format!("'{text}' is not {}", set.en));
        let ids = || set.all.iter().map(|m| (set.id)(*m));
        let wanted = text.trim().to_lowercase();
        // A Chinese name inside a longer phrase still identifies the member.
        let contained = set.names.iter().filter(|(n, _)| !n.is_ascii() && wanted.contains(n.as_str()));
        let named = set.names.iter().find(|(n, _)| *n == wanted).or(contained.max_by_key(|(n, _)| n.len()));
        let named = named.map(|(_, id)| *id);
        let spelled = wanted.replace([' ', '-'], "_");
        match named.or_else(|| did_you_mean(&spelled, ids())) {
            Some(id) => words.meant(id),
            None => {
                let all: Vec<&str> = ids().collect();
                words.one_of(&all.join("、"), &all.join(", "))
            }
        }
    });
    Slot::Broken
}

/// The type of a keyframe; also of a suggested one.
pub fn keyframe_type<'d>(
    walk: &mut Walk<'d>,
    node: &'d Node<'d>,
    pointer: &str,
    code: &'static str,
) -> Slot<KeyframeType> {
    let set = ClosedSet {
        code,
        zh: "关键帧类型",
        en: "a keyframe type",
        all: KeyframeType::ALL,
        id: KeyframeType::id,
        names: Vec::new(),
    };
    choose(walk, Some(node), pointer, &set)
}
