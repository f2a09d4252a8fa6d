//! Whether the subject of a component has been read. If it is in words that are in no list, it is not known what the
//! component names, even if many of its other words are known. Used only before a finding is reported.

use super::reading::{Named, TextFacts};
use whyroad_framework::LabelWords;

/// The component's subject is in words that are in no list.
pub(super) fn is_unread(text: &str, facts: &TextFacts, words: &LabelWords) -> bool {
    if text.is_ascii() { is_unread_latin(text, facts, words) } else { is_unread_chinese(text, facts, words) }
}

/// "A horsebox stands half on the verge": no thing is named up to the verb. A text about a road and the like may have
/// any words.
fn is_unread_latin(text: &str, facts: &TextFacts, words: &LabelWords) -> bool {
    let mut end = text.len();
    let mut is_first = true;
    let mut at = 0;
    for word in text.split(|c: char| !c.is_ascii_alphanumeric() && c != '\'' && c != '-') {
        let start = at;
        at += word.len() + 1;
        let lower = word.to_ascii_lowercase();
        if lower.is_empty() || (is_first && words.subjects.articles.contains(&lower)) {
            continue;
        }
        if is_first && (words.subjects.is_pronoun(&lower) || lower.starts_with(|c: char| c.is_ascii_digit()))
        {
            return false;
        }
        // "Automatic braking has come on": an action is no thing.
        let next = text.get(at..).unwrap_or_default();
        if !is_first
            && lower.ends_with("ing")
            && ["has ", "is ", "was ", "had "].iter().any(|w| next.starts_with(w))
        {
            return false;
        }
        // A second article or pronoun begins the object of the action.
        let divides = (words.subjects.is_determiner(&lower) && !text[..start].ends_with("of "))
            || start > 0 && text[..start].trim_end().ends_with([',', ';', '.', ':']);
        if !is_first && (divides || words.subjects.ends(&lower) || is_participle(&lower)) {
            end = start;
            break;
        }
        is_first = false;
    }
    // The last word is the kind of the thing: a "hay wagon" is no hay. A verb may follow.
    let is_last = |n: &Named| {
        let next = text.get(n.end..end).unwrap_or_default();
        let next = next.split(|c: char| !c.is_ascii_alphanumeric()).find(|w| !w.is_empty());
        end == text.len() || next.is_none_or(|w| w.ends_with('s') || w.ends_with("ed"))
    };
    !facts.named.iter().any(|n| n.start < end && is_last(n))
}

/// The name at `start` is of a single thing: "a beige estate". Latin letters, with at most three words between.
pub(super) fn is_single(text: &str, start: usize) -> bool {
    let before = text.get(..start).unwrap_or_default();
    let words = before.rsplit(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
    let mut all = words.take(4);
    text.is_ascii() && all.any(|w| w.eq_ignore_ascii_case("a") || w.eq_ignore_ascii_case("an"))
}

/// Precedes the words for a thing that is not introduced.
fn is_break(word: &str, words: &LabelWords) -> bool {
    words.subjects.ends(word) || words.subjects.is_determiner(word)
}

/// Action or kind of a thing: "a car waiting", "a wobbling cyclist".
fn is_participle(word: &str) -> bool {
    word.len() > 5 && word.ends_with("ing")
}

/// "胡同里来了一台小货": nothing is named after the counting word; or nothing at all except a place.
fn is_unread_chinese(text: &str, facts: &TextFacts, words: &LabelWords) -> bool {
    let subjects = &words.subjects;
    let chars: Vec<(usize, char)> = text.char_indices().collect();
    // "The first car" is no count.
    let is_ordinal = |at: usize| text[..at].ends_with(|c| subjects.ordinals.contains(c));
    let counted = chars.windows(2).filter(|w| {
        subjects.counts.contains(w[0].1) && subjects.counters.contains(w[1].1) && !is_ordinal(w[0].0)
    });
    let mut counted = counted.map(|w| w[1].0 + w[1].1.len_utf8()).peekable();
    let clause_end = |from: usize| {
        text[from..].find(['，', '。', '；', '、', '：', '！']).map_or(text.len(), |i| from + i)
    };
    // "从公交车前": the origin of a road user.
    let is_origin = |n: &Named| text[..n.start].ends_with(|c| subjects.origins.contains(c));
    // After "of", which is followed by the thing: "a man who climbs the fence". A near name may be a place.
    const NEAR: usize = 12;
    let within = |from: usize, to: usize| {
        let of = text[from..to].find('的').filter(|at| *at <= 2 * NEAR).map_or(from, |at| from + at);
        let is_near = |n: &Named| n.start <= of + NEAR || words.objects[n.group].named;
        facts
            .named
            .iter()
            .any(|n| n.end > of && n.start < to && is_near(n) && !(n.start > from && is_origin(n)))
    };
    if counted.peek().is_some() {
        return counted.any(|from| !within(from, clause_end(from)));
    }
    // "自车车速偏快", but not "自车前方".
    let rest = |w: &String| text.strip_prefix(w.as_str());
    if subjects.own.iter().filter_map(rest).any(|r| !r.starts_with(|c| subjects.behind_own.contains(c))) {
        return false;
    }
    // A measure, and nothing about a road user.
    let first = clause_end(0);
    if facts.named.iter().any(|n| n.start < first && words.objects[n.group].own.meets(words.known.gap)) {
        return false;
    }
    let is_place = |n: &Named| text[n.end..].starts_with(|c| subjects.places.contains(c));
    let says_where = words.known.no_cause.with(words.known.road);
    let is_thing = |n: &&Named| !words.objects[n.group].own.without(says_where).is_empty() && !is_place(n);
    !facts.named.iter().any(|n| is_thing(&n))
}

/// The text introduces the thing at `start`, rather than referring to a known one: "a cyclist", "还有个骑手".
pub(super) fn is_introduced(text: &str, start: usize, words: &LabelWords) -> bool {
    const NEAR: usize = 4;
    let is_article = |w: &str| words.subjects.introduces.iter().any(|i| i == w);
    let before = &text[..start];
    if text.is_ascii() {
        let last = before.rsplit(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).take(NEAR);
        let mut lower =
            last.map(str::to_ascii_lowercase).take_while(|w| is_article(w) || !is_break(w, words));
        return lower.any(|w| is_article(&w));
    }
    let near = before.chars().rev().take(NEAR * 2).take_while(|c| !"，。；、：".contains(*c));
    let near: Vec<char> = near.collect();
    near.windows(2).any(|w| {
        words.subjects.counters.contains(w[0])
            && (words.subjects.counts.contains(w[1]) || words.subjects.appears.contains(w[1]))
    }) || near.first().is_some_and(|c| *c == '有')
}

/// The word at `start..end` is no name: a verb behind an auxiliary ("a pace the track will bear"), or one Chinese
/// character inside another word ("立马"), that nothing counts and no clause begins with.
pub(super) fn is_no_noun(text: &str, start: usize, end: usize, words: &LabelWords) -> bool {
    let (before, subjects) = (&text[..start], &words.subjects);
    if text.is_ascii() {
        let last = before.trim_end().rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        return before.ends_with(' ') && subjects.auxiliaries.iter().any(|w| last.eq_ignore_ascii_case(w));
    }
    let is_single = text[start..end].chars().nth(1).is_none();
    let begins_name =
        |c: char| !c.is_alphanumeric() || subjects.counters.contains(c) || subjects.before_name.contains(c);
    let stands_free = before.chars().next_back().is_none_or(begins_name);
    is_single && !text[start..end].is_ascii() && !stands_free && !is_introduced(text, start, words)
}

/// What follows `before` in Latin letters belongs to somebody who was named: "its trailer".
pub(super) fn is_owned(before: &str, words: &LabelWords) -> bool {
    let last = before.rsplit(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
    words.subjects.owners.iter().any(|w| last.eq_ignore_ascii_case(w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::reading;
    use whyroad_framework::Framework;
    use whyroad_framework::lexicon::units::Units;

    #[test]
    fn a_thing_in_unknown_words_is_unread() {
        let words = Framework::bundled().label_words();
        let unread = |text: &str| {
            let mut facts = reading::read(text, &Units::of(text), words);
            // As if the thing were in no list.
            facts.named.retain(|n| !["coupe", "小货"].contains(&&text[n.start..n.end]));
            is_unread(text, &facts, words)
        };
        for text in [
            "A silver coupe stands across our lane",
            "胡同里迎面来了一台小货",
            "The xylophone is near the truck",
        ] {
            assert!(unread(text), "{text}");
        }
        for text in [
            "Emergency braking has just been triggered",
            "A cyclist on the right is crossing",
            "导航提示右转",
            "自车车速偏快",
            "右侧一辆货车正在并线",
            "It is about ten meters away",
        ] {
            assert!(!unread(text), "{text}");
        }
    }

    #[test]
    fn what_is_introduced_was_not_there_before() {
        let words = Framework::bundled().label_words();
        let introduced = |text: &str, thing: &str| is_introduced(text, text.find(thing).unwrap(), words);
        assert!(introduced("and a wobbling cyclist", "cyclist") && !introduced("and the cyclist", "cyclist"));
        assert!(is_owned("lets the pickup and its", words) && !is_owned("lets the", words));
        assert!(introduced("后面还有辆三轮车", "三轮车") && !introduced("三轮车横穿", "三轮车"));
    }
}
