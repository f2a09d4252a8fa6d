//! How to find the thing that a component describes (`subjects` of `schema/label_words.yaml`).

use super::compile::expanded;
use super::{CharSet, Words, has_one_of, has_word};
use serde::Deserialize;
use std::collections::HashSet;
use whyroad_model::Bilingual;

/// Words around the name of a thing.
#[derive(Clone, Debug, Default)]
pub struct Subjects {
    ends: HashSet<String>,
    pronouns: HashSet<String>,
    /// A text in Chinese that begins with one of these is about the ego.
    pub own: Vec<String>,
    /// The thing after one of these is near the ego.
    pub behind_own: CharSet,
    /// Number words, in Chinese.
    pub counts: CharSet,
    /// The measure word after the number.
    pub counters: CharSet,
    /// Positions that are neither left nor right; in lower case.
    pub opposite: Vec<String>,
    /// A record that begins with one of these states that there is nothing; in lower case.
    pub nothing: Vec<String>,
    /// Characters in too many names of things to be evidence when shared.
    pub common: CharSet,
    /// The same of Latin letters, in lower case.
    pub common_words: HashSet<String>,
    /// Names for all members of a kind, in lower case.
    general: HashSet<String>,
    /// After the name of a place.
    pub places: CharSet,
    /// Before a name in Latin letters.
    pub articles: Vec<String>,
    /// The same, and words that begin the object of an action.
    determiners: Vec<String>,
    /// Before a name of Latin letters that refers to a known thing.
    pub definite: Vec<String>,
    /// Before a name of Latin letters of a possession.
    pub owners: Vec<String>,
    /// Before the change of a measure of the ego, in Chinese.
    pub measures: Vec<String>,
    /// Before a name of Latin letters that refers to a thing not named before.
    pub introduces: Vec<String>,
    /// Before the measure word, in Chinese, the same.
    pub appears: CharSet,
    /// Before a number in Chinese that is not a count.
    pub ordinals: CharSet,
    /// Before a name in Chinese that is an origin or destination.
    pub origins: CharSet,
    /// Before a verb of Latin letters, in lower case.
    pub auxiliaries: Vec<String>,
    /// Before a name in Chinese of one character.
    pub before_name: CharSet,
    /// Possible names of the ego where no component is about a vehicle; in lower case.
    pub may_be_ego: Vec<String>,
    /// Names that may also be a part of a vehicle, in lower case.
    vague: HashSet<String>,
    /// Names of many, or of whoever is behind the ego, in lower case.
    many: HashSet<String>,
    /// Parts that every vehicle has, in lower case.
    parts: HashSet<String>,
    /// Parts that have a left and a right one: in Chinese by their first character, in lower case.
    own_parts: (CharSet, HashSet<String>),
    /// Words for something written, in lower case.
    writing: Vec<String>,
    /// The ego, in Chinese and in Latin letters.
    ego: [Vec<String>; 2],
    /// After a name in Chinese, before one of Latin letters: the name only locates something else; in lower case.
    landmark: [Vec<String>; 2],
    stand_for: HashSet<String>,
    stand_for_chinese: Vec<String>,
    /// Words for positions, in lower case: before the ego, behind it.
    pub at: [Vec<String>; 2],
    /// Words of a movement to one side, in lower case: left, right.
    pub goes_to: [Vec<String>; 2],
    /// Words for another one of the same kind.
    pub another: Vec<String>,
    /// Hold the name of a side and name none.
    no_side: Vec<String>,
    /// Stand before the name of a side, and behind it.
    before_side: Vec<String>,
    behind_side: Vec<String>,
    /// Words that only add another one of the same kind; those of `another` may also say where it is.
    second: Vec<String>,
    /// Systems of the ego, and its route.
    own_systems: Vec<String>,
    /// Before an action that is not possible, in lower case.
    pub unable: Vec<String>,
    /// Another lane than the ego's, in lower case.
    pub beside_ego: Vec<String>,
    /// Words for things already behind the ego.
    pub earlier: Vec<String>,
    /// After the route: the route does not require the decision.
    pub route_not: Vec<String>,
    /// Words for the lane in which the ego is or was.
    pub own_lane: Vec<String>,
    /// Before a name of Latin letters, after one in Chinese: something else is farther on.
    pub beyond: Vec<String>,
    /// Words for the time and place of the ego, not for a cause.
    pub here: Vec<String>,
    /// Names of lanes that indicate a side.
    pub lanes: Vec<String>,
    /// Words for a free path, in lower case.
    pub free: Vec<String>,
    /// Words for missing room, in lower case.
    pub full: Vec<String>,
    /// Somebody lets the ego go first, in lower case.
    pub lets_ego_go: Vec<String>,
    /// The ego's lane is free ahead, in lower case.
    pub free_ahead: Vec<String>,
    /// Names of each part that has a left and a right one, in lower case.
    pub side_parts: Vec<Vec<String>>,
}

impl Subjects {
    /// The word of Latin letters, in lower case, ends the words for a thing.
    pub fn ends(&self, word: &str) -> bool {
        self.ends.contains(word)
    }

    /// `name`, in upper or lower case, is a name for all members of a kind.
    pub fn is_general(&self, name: &str) -> bool {
        self.general.contains(&name.to_ascii_lowercase())
    }

    /// `name`, in upper or lower case, may also be a part of a vehicle.
    pub fn is_vague(&self, name: &str) -> bool {
        self.vague.contains(&name.to_ascii_lowercase())
    }

    /// `name`, in upper or lower case, is not of the one road user that the ego responds to, but of many, or of whoever
    /// is behind the ego.
    pub fn is_of_many(&self, name: &str) -> bool {
        self.many.contains(&name.to_ascii_lowercase())
    }

    /// The character at this byte of the text is in too many names to be evidence when shared.
    pub fn is_common(&self, text: &str, at: usize) -> bool {
        text[at..].starts_with(|c| self.common.contains(c))
    }

    /// The text mentions the ego.
    pub fn speaks_of_ego(&self, text: &str) -> bool {
        let [chinese, latin] = &self.ego;
        chinese.iter().any(|w| text.contains(w.as_str()))
            || has_word(text, |word| latin.iter().any(|w| word.eq_ignore_ascii_case(w)))
    }

    /// The text states that something is to the left or to the right.
    pub fn speaks_of_side(&self, text: &str) -> bool {
        text.contains(['左', '右'])
            || has_word(text, |w| w.eq_ignore_ascii_case("left") || w.eq_ignore_ascii_case("right"))
    }

    /// The text begins with the ego as the acting subject.
    pub fn begins_with_ego(&self, text: &str) -> bool {
        let [chinese, latin] = &self.ego;
        if text.is_ascii() {
            let mut all = text.split_whitespace().filter(|w| !w.eq_ignore_ascii_case("the"));
            let possessive = ["our", "my", "us"];
            return all.next().is_some_and(|first| {
                let is_ego = latin.iter().any(|w| first.eq_ignore_ascii_case(w));
                is_ego && !possessive.iter().any(|w| first.eq_ignore_ascii_case(w))
            });
        }
        let rest = chinese.iter().find_map(|w| text.strip_prefix(w.as_str()));
        rest.is_some_and(|r| !r.starts_with(|c| self.behind_own.contains(c)))
    }

    /// The text begins with a system of the ego or with its route: "the route turns left here".
    pub fn begins_with_own_system(&self, text: &str) -> bool {
        let text = text.strip_prefix("the ").or(text.strip_prefix("The ")).unwrap_or(text);
        let begins = |w: &String| text.get(..w.len()).is_some_and(|t| t.eq_ignore_ascii_case(w));
        self.own_systems.iter().any(begins)
    }

    /// The text states that something is written.
    pub fn speaks_of_writing(&self, text: &str) -> bool {
        let lower = text.to_ascii_lowercase();
        self.writing.iter().any(|w| lower.contains(w.as_str()))
    }

    /// Bytes of the first word for the left and for the right, where it says where something is: not "right away", "two
    /// meters left" or "left turn".
    pub fn sides(&self, text: &str) -> [Option<(usize, usize)>; 2] {
        let mut lower = text.to_ascii_lowercase();
        for word in &self.no_side {
            if lower.contains(word.as_str()) {
                lower = lower.replace(word.as_str(), &" ".repeat(word.len()));
            }
        }
        [("左", "left"), ("右", "right")].map(|(chinese, latin)| {
            let all = lower.match_indices(chinese).map(|(at, w)| (at, at + w.len()));
            all.chain(self.latin_side(&lower, latin)).min()
        })
    }

    /// Where `text`, in lower case, names the side `word`.
    fn latin_side(&self, text: &str, word: &str) -> Option<(usize, usize)> {
        let is_letter = |c: char| c.is_ascii_alphabetic();
        text.match_indices(word).map(|(at, _)| (at, at + word.len())).find(|(start, end)| {
            let (before, behind) = (&text[..*start], &text[*end..]);
            let last =
                before.trim_end().rsplit(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
            let next = behind.trim_start_matches([' ', '-']);
            let next = next.split(|c: char| !is_letter(c)).next().unwrap_or_default();
            let leads = self.before_side.iter().any(|w| w == last);
            let goes_on = self.behind_side.iter().any(|w| w == next);
            !before.ends_with(is_letter)
                && (!behind.starts_with(is_letter) || behind.starts_with("ward"))
                && (leads || goes_on)
        })
    }

    /// The text adds another one of a kind: "a second van", "another one too".
    pub fn speaks_of_second(&self, text: &str) -> bool {
        has_one_of(text, &self.second)
    }

    /// The text begins with a part that every vehicle has on the left and the right: "wheels".
    pub fn begins_with_own_part(&self, text: &str) -> bool {
        let text = text.trim_start();
        let word = text.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        text.starts_with(|c| self.own_parts.0.contains(c))
            || self.own_parts.1.contains(&word.to_ascii_lowercase())
    }

    /// The name at `start..end` of the text only locates something else.
    pub fn is_landmark(&self, text: &str, start: usize, end: usize) -> bool {
        let [behind, before] = &self.landmark;
        behind.iter().any(|w| text[end..].starts_with(w.as_str()))
            || text.is_ascii() && {
                let ahead = text[..start].trim_end().to_ascii_lowercase();
                before.iter().any(|w| ahead.ends_with(w.as_str()))
            }
    }

    /// The text has a pronoun that refers to a road user.
    pub fn has_pronoun(&self, text: &str) -> bool {
        self.stand_for_chinese.iter().any(|w| text.contains(w.as_str()))
            || has_word(text, |w| self.stand_for.contains(&w.to_ascii_lowercase()))
    }

    /// `name`, in upper or lower case, is a part that every vehicle has, including the ego.
    pub fn is_part(&self, name: &str) -> bool {
        self.parts.contains(&name.to_ascii_lowercase())
    }

    /// The word of Latin letters, in lower case, begins the words for a thing.
    pub fn is_determiner(&self, word: &str) -> bool {
        self.determiners.iter().any(|w| w == word)
    }

    /// A text that begins with this word of Latin letters, in lower case, refers to what was named before or to no
    /// thing.
    pub fn is_pronoun(&self, word: &str) -> bool {
        self.pronouns.contains(word)
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSubjects {
    ends: Words,
    pronouns: Words,
    own: Words,
    behind_own: Words,
    counts: Words,
    counters: Words,
    nothing: Words,
    opposite: Words,
    common: Words,
    general: Words,
    places: Words,
    articles: Words,
    determiners: Words,
    definite: Words,
    owners: Words,
    measures: Words,
    introduces: Words,
    ordinals: Words,
    origins: Words,
    auxiliaries: Words,
    before_name: Words,
    may_be_ego: Words,
    vague: Words,
    many: Words,
    parts: Words,
    own_parts: Words,
    writing: Words,
    ego: Words,
    landmark: Words,
    stand_for: Words,
    before_ego: Words,
    behind_ego: Words,
    goes_left: Words,
    goes_right: Words,
    another: Words,
    second: Words,
    own_systems: Words,
    no_side: Words,
    before_side: Words,
    behind_side: Words,
    unable: Words,
    beside_ego: Words,
    #[serde(default)]
    earlier: Words,
    #[serde(default)]
    route_not: Words,
    #[serde(default)]
    own_lane: Words,
    #[serde(default)]
    beyond: Words,
    #[serde(default)]
    here: Words,
    #[serde(default)]
    lanes: Words,
    free: Words,
    full: Words,
    #[serde(default)]
    lets_ego_go: Words,
    #[serde(default)]
    free_ahead: Words,
    side_parts: Vec<Words>,
}

impl RawSubjects {
    pub(super) fn compile(&self, problems: &mut Vec<Bilingual>) -> Subjects {
        let list = |w: &Words| w.en.iter().cloned().collect();
        let chars = |w: &Words| CharSet::of(w.zh.iter().map(String::as_str));
        let all = |w: &Words| w.all().map(str::to_owned).collect::<Vec<_>>();
        let mut patterns = |w: &Words| w.all().flat_map(|p| expanded(p, problems)).collect();
        Subjects {
            lets_ego_go: patterns(&self.lets_ego_go),
            free_ahead: patterns(&self.free_ahead),
            ends: list(&self.ends),
            pronouns: list(&self.pronouns),
            own: self.own.zh.clone(),
            behind_own: chars(&self.behind_own),
            counts: chars(&self.counts),
            counters: chars(&self.counters),
            nothing: all(&self.nothing),
            opposite: all(&self.opposite),
            common: chars(&self.common),
            common_words: list(&self.common),
            general: self.general.all().map(str::to_owned).collect(),
            places: chars(&self.places),
            articles: self.articles.en.clone(),
            determiners: self.articles.en.iter().chain(&self.determiners.en).cloned().collect(),
            definite: self.definite.en.clone(),
            owners: self.owners.en.clone(),
            measures: self.measures.zh.clone(),
            introduces: self.introduces.en.clone(),
            appears: chars(&self.introduces),
            ordinals: chars(&self.ordinals),
            origins: chars(&self.origins),
            auxiliaries: self.auxiliaries.en.clone(),
            before_name: chars(&self.before_name),
            may_be_ego: all(&self.may_be_ego),
            vague: self.vague.all().map(str::to_owned).collect(),
            many: self.many.all().flat_map(|p| expanded(p, problems)).collect(),
            ego: [self.ego.zh.clone(), self.ego.en.clone()],
            landmark: [self.landmark.zh.clone(), self.landmark.en.clone()],
            stand_for: list(&self.stand_for),
            stand_for_chinese: self.stand_for.zh.clone(),
            own_parts: (chars(&self.own_parts), list(&self.own_parts)),
            writing: all(&self.writing),
            parts: self.parts.all().map(str::to_owned).collect(),
            at: [all(&self.before_ego), all(&self.behind_ego)],
            goes_to: [all(&self.goes_left), all(&self.goes_right)],
            another: all(&self.another),
            second: all(&self.second),
            own_systems: all(&self.own_systems),
            no_side: all(&self.no_side),
            before_side: all(&self.before_side),
            behind_side: all(&self.behind_side),
            unable: all(&self.unable),
            beside_ego: all(&self.beside_ego),
            earlier: all(&self.earlier),
            route_not: all(&self.route_not),
            own_lane: all(&self.own_lane),
            beyond: all(&self.beyond),
            here: all(&self.here),
            lanes: all(&self.lanes),
            free: all(&self.free),
            full: all(&self.full),
            side_parts: self.side_parts.iter().map(all).collect(),
        }
    }
}
