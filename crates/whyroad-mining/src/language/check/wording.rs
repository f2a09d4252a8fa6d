//! Conditions as text for people who do not know the rule language: signals by their titles, values of categories by
//! their names, definitions by the names that the rule gives them (`names:`) or else by their content. Numbers are
//! compared with the signs of mathematics.

pub(super) mod idioms;

use idioms::{around, during, same, without_guards, without_repeats};

use super::super::syntax::{ArithmeticOp, CompareOp, Expr, ExprKind, Quantity};
use super::Checker;
use std::cell::RefCell;
use std::collections::HashMap;
use whyroad_model::units::Dimension;
use whyroad_model::{Bilingual, Lang};

/// Separators between conditions, in Chinese and English.
const AND: (&str, &str) = ("且", "and");
const OR: (&str, &str) = ("或", "or");

/// Addition to a negation that also holds where the value is unknown.
pub(super) const ZH_OR_UNKNOWN: &str = "（或未知）";
/// The same in English.
pub(super) const EN_OR_UNKNOWN: &str = " (or unknown)";

/// Precedence of a text: an embedded text is quoted where it could be misread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Bond {
    /// A noun or a plain clause.
    Single,
    /// A comparison.
    Comparison,
    /// Several clauses, or a clause with a time.
    Joined,
}

/// A text and its precedence.
#[derive(Clone)]
pub(super) struct Phrase {
    text: String,
    bond: Bond,
}

impl Phrase {
    fn single(text: impl Into<String>) -> Self {
        Self { text: text.into(), bond: Bond::Single }
    }

    fn comparison(text: String) -> Self {
        Self { text, bond: Bond::Comparison }
    }

    fn joined(text: String) -> Self {
        Self { text, bond: Bond::Joined }
    }
}

/// The object that "the target" means in the title of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whose {
    /// The rule's target.
    Target,
    /// Each object in turn, inside `exists`, `forall` and `count`.
    Object,
}

impl Checker<'_> {
    /// Text of a condition or number.
    pub fn in_words(&self, expr: &Expr) -> Bilingual {
        if let Some(words) = self.worded.get(expr) {
            return words;
        }
        let said =
            |lang| Words { checker: self, lang, guards: Guards::Dropped }.phrase(expr, Whose::Target).text;
        self.worded.put(expr, Bilingual::new(said(Lang::Zh), capitalized(&said(Lang::En))))
    }

    /// The name that the rule gives a definition.
    pub(super) fn name_of_definition(&self, name: &str) -> Option<Bilingual> {
        let words = self.names.get(name)?;
        Some(Bilingual::new(words.zh.clone(), capitalized(&words.en)))
    }
}

/// A sentence begins with a capital letter.
fn capitalized(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().to_string() + rest.as_str())
}

/// Tests that a value is known, beside a condition on that value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Guards {
    /// They are left out: where the condition holds, the value is known.
    Dropped,
    /// They are kept, inside a negation: this holds where the value is unknown.
    Kept,
}

/// Words of the definitions that have no name, by definition. They are part of the words of all conditions above them,
/// so that without this they would be put together hundreds of times.
pub(super) type Said = RefCell<HashMap<String, Vec<(Manner, Phrase)>>>;

/// What the words of a definition depend on, besides its expression.
type Manner = (Lang, Guards, Whose);

struct Words<'c, 'a> {
    checker: &'c Checker<'a>,
    lang: Lang,
    guards: Guards,
}

impl Words<'_, '_> {
    fn say(&self, zh: String, en: String) -> String {
        match self.lang {
            Lang::Zh => zh,
            Lang::En => en,
        }
    }

    fn phrase(&self, expr: &Expr, whose: Whose) -> Phrase {
        if let Some(q) = self.checker.quantity(expr) {
            return Phrase::single(quantity(q));
        }
        match &expr.kind {
            ExprKind::Number(q) => Phrase::single(quantity(*q)),
            ExprKind::Name(name) => self.name(name, whose),
            ExprKind::Call(name, arguments) => self.call(name, arguments, whose),
            ExprKind::Negate(of) => Phrase::single(format!("−{}", self.quoted(of, whose))),
            ExprKind::Arithmetic(op, a, b) => {
                if let Some(product) = self.product(*op, a, b) {
                    return Phrase::single(quantity(product));
                }
                let sign = match op {
                    ArithmeticOp::Add => '+',
                    ArithmeticOp::Subtract => '−',
                    ArithmeticOp::Multiply => '×',
                };
                let (a, b) = (self.quoted(a, whose), self.quoted(b, whose));
                Phrase::comparison(format!("{a} {sign} {b}"))
            }
            ExprKind::Not(of) => self.not(of, whose),
            ExprKind::And(all) => self.joined(&self.members(all), whose, AND),
            ExprKind::Or(all) => {
                let all = without_repeats(all);
                if let [a, b] = all.as_slice() {
                    if let Some((stretch, happens)) = during(a, b) {
                        return self.during(stretch, happens, whose);
                    }
                    if let Some((of, time)) = around(a, b) {
                        return self.around(of, time, whose);
                    }
                }
                self.joined(&all, whose, OR)
            }
            ExprKind::Compare(first, rest) => self.compare(first, rest, whose),
            ExprKind::In(of, members) => {
                let members: Vec<&str> = members.iter().map(|(word, _)| word.as_str()).collect();
                self.is_one_of(of, &members, true, whose)
            }
            ExprKind::Known(of) => {
                let of = self.quoted(of, whose);
                Phrase::comparison(self.say(format!("{of}已知"), format!("{of} is known")))
            }
            ExprKind::For(of, time) => {
                let (of, gaps) = match &of.kind {
                    ExprKind::Gaps(of, gaps) => (of, Some(self.time(gaps))),
                    _ => (of, None),
                };
                let (of, time) = (self.quoted(of, whose), self.time(time));
                let gaps = gaps.map_or_else(String::new, |g| {
                    self.say(format!("（允许中断 {g}）"), format!(" (with gaps of up to {g})"))
                });
                Phrase::joined(
                    self.say(format!("{of}持续至少 {time}{gaps}"), format!("{of} for at least {time}{gaps}")),
                )
            }
            ExprKind::Gaps(of, _) => self.phrase(of, whose),
            ExprKind::Within(of, time) => {
                let (of, time) = (self.quoted(of, whose), self.time(time));
                Phrase::joined(
                    self.say(format!("此后 {time} 内{of}"), format!("within the next {time}: {of}")),
                )
            }
            ExprKind::Then(a, b, time) => {
                let (a, b, time) = (self.quoted(a, whose), self.quoted(b, whose), self.time(time));
                Phrase::joined(
                    self.say(format!("先{a}，{time} 内再{b}"), format!("{a}, then within {time} {b}")),
                )
            }
            ExprKind::Since(a, b, time) => {
                let (a, b) = (self.quoted(a, whose), self.beside(a, b, whose));
                let (zh, en) = self.limit(time.as_deref());
                Phrase::joined(self.say(format!("从{b}起一直{a}{zh}"), format!("{a} ever since {b}{en}")))
            }
            ExprKind::Until(a, b, time) => {
                let (a, b) = (self.quoted(a, whose), self.beside(a, b, whose));
                let (zh, en) = self.limit(time.as_deref());
                Phrase::joined(self.say(format!("{a}，直到{b}{zh}"), format!("{a} until {b}{en}")))
            }
            ExprKind::At(of) => {
                let of = self.quoted(of, whose);
                Phrase::comparison(self.say(format!("关键帧时{of}"), format!("{of} at the keyframe")))
            }
        }
    }

    /// The product of two fixed numbers.
    fn product(&self, op: ArithmeticOp, a: &Expr, b: &Expr) -> Option<Quantity> {
        let (a, b) = (self.checker.quantity(a)?, self.checker.quantity(b)?);
        let unit = if a.unit.dimension == Dimension::Ratio { b.unit } else { a.unit };
        (op == ArithmeticOp::Multiply).then_some(Quantity { value: a.value * b.value, unit })
    }

    /// True some time before or after now.
    fn around(&self, of: &Expr, time: &Expr, whose: Whose) -> Phrase {
        let (of, time) = (self.quoted(of, whose), self.time(time));
        Phrase::joined(
            self.say(format!("前后 {time} 内{of}"), format!("within {time} before or after: {of}")),
        )
    }

    /// Something happens in a stretch of time.
    fn during(&self, stretch: &Expr, happens: &Expr, whose: Whose) -> Phrase {
        let (stretch, happens) = (self.quoted(stretch, whose), self.beside(stretch, happens, whose));
        Phrase::joined(self.say(format!("{stretch}期间，{happens}"), format!("{happens}, while {stretch}")))
    }

    /// A time limit behind a phrase, in both languages.
    fn limit(&self, time: Option<&Expr>) -> (String, String) {
        time.map_or_else(Default::default, |t| {
            let t = self.time(t);
            (format!("（{t} 内）"), format!(" (within {t})"))
        })
    }

    fn time(&self, expr: &Expr) -> String {
        self.checker.quantity(expr).map_or_else(String::new, quantity)
    }

    /// For use in another phrase: in quotes where it is more than one clause.
    fn quoted(&self, expr: &Expr, whose: Whose) -> String {
        self.quote(self.phrase(expr, whose))
    }

    fn quote(&self, phrase: Phrase) -> String {
        match phrase.bond {
            Bond::Joined => self.say(format!("“{}”", phrase.text), format!("({})", phrase.text)),
            _ => phrase.text,
        }
    }

    /// `a until (a and c)` means until c: the part that b adds to a.
    fn beside(&self, a: &Expr, b: &Expr, whose: Whose) -> String {
        let ExprKind::And(all) = &b.kind else { return self.quoted(b, whose) };
        let added: Vec<&Expr> = self.members(all).into_iter().filter(|e| !same(e, a)).collect();
        if added.is_empty() { self.quoted(b, whose) } else { self.quote(self.joined(&added, whose, AND)) }
    }

    /// The members of a conjunction that are said.
    fn members<'e>(&self, all: &'e [Expr]) -> Vec<&'e Expr> {
        match self.guards {
            Guards::Dropped => without_guards(all),
            Guards::Kept => all.iter().collect(),
        }
    }

    /// One condition unchanged, several with a word between them.
    fn joined(&self, all: &[&Expr], whose: Whose, (zh, en): (&str, &str)) -> Phrase {
        if let [one] = all {
            return self.phrase(one, whose);
        }
        let all: Vec<String> = all.iter().map(|e| self.quoted(e, whose)).collect();
        Phrase::joined(all.join(&self.say(format!("，{zh}"), format!(" {en} "))))
    }

    fn name(&self, name: &str, whose: Whose) -> Phrase {
        if let Some(words) = self.checker.names.get(name) {
            return Phrase::single(words.get(self.lang));
        }
        if let Some(definition) = self.checker.definitions.get(name) {
            return self.definition(name, &definition.expr, whose);
        }
        match name {
            "true" => return Phrase::single(self.say("恒成立".into(), "always".into())),
            "false" => return Phrase::single(self.say("恒不成立".into(), "never".into())),
            _ => {}
        }
        Phrase::single(self.signal(name, whose))
    }

    /// The words of a definition without a name.
    fn definition(&self, name: &str, expr: &Expr, whose: Whose) -> Phrase {
        let manner = (self.lang, self.guards, whose);
        if let Some(said) = self.checker.said.borrow().get(name)
            && let Some((_, phrase)) = said.iter().find(|(m, _)| *m == manner)
        {
            return phrase.clone();
        }
        let phrase = self.phrase(expr, whose);
        self.checker.said.borrow_mut().entry(name.to_owned()).or_default().push((manner, phrase.clone()));
        phrase
    }

    /// The title of a signal; `target.`, "the target" in titles, is the current object here.
    fn signal(&self, name: &str, whose: Whose) -> String {
        let catalog = self.checker.catalog;
        let roles = &self.checker.roles;
        let (role, rest) = name.split_once('.').unwrap_or(("", name));
        let is = |r: &Option<String>| r.as_deref() == Some(role);
        let (id, about) = if is(&roles.first) || is(&roles.second) {
            (format!("target.{rest}"), Some(role.replace('_', " ")))
        } else if role == "other" {
            (format!("object.{rest}"), Some(self.say("另一对象".into(), "other object".into())))
        } else if role == "reverse" {
            (format!("pair.{rest}"), None)
        } else {
            let object = || self.say("该对象".into(), "object".into());
            (name.to_owned(), (whose == Whose::Object && role.starts_with("target")).then(object))
        };
        let Some(def) = catalog.get(&id) else { return name.replace(['.', '_'], " ") };
        let title = def.title.get(self.lang);
        match about {
            Some(who) if role == "other" => title.replace(&self.say("对象".into(), "object".into()), &who),
            Some(who) => title
                .replace("目标", &who)
                .replace("the target", &format!("the {who}"))
                .replace("target's", &format!("{who}'s")),
            None if role == "reverse" => {
                self.say(format!("{title}（从另一对象看）"), format!("{title} (seen from the other)"))
            }
            None => title.to_owned(),
        }
    }

    fn not(&self, of: &Expr, whose: Whose) -> Phrase {
        match &of.kind {
            ExprKind::Not(inner) => self.phrase(inner, whose),
            ExprKind::Known(inner) => {
                let inner = self.quoted(inner, whose);
                Phrase::comparison(self.say(format!("{inner}未知"), format!("{inner} is unknown")))
            }
            ExprKind::In(inner, members) => {
                let members: Vec<&str> = members.iter().map(|(word, _)| word.as_str()).collect();
                self.is_one_of(inner, &members, false, whose)
            }
            ExprKind::Compare(first, rest) if rest.len() == 1 => {
                let rest = [(opposite(rest[0].0), rest[0].1.clone())];
                self.compare(first, &rest, whose)
            }
            ExprKind::And(all) => match without_guards(all).as_slice() {
                [one] if all.len() > 1 => self.not_or_unknown(one, whose),
                _ => self.denied(of, whose),
            },
            ExprKind::Name(name) if !self.checker.names.contains_key(name) => {
                match self.checker.definitions.get(name) {
                    Some(definition) => self.not(&definition.expr, whose),
                    None => self.denied(of, whose),
                }
            }
            ExprKind::Call(name, arguments) => match (name.as_str(), arguments.as_slice()) {
                ("previously", [c, time]) => {
                    let (c, time) = (self.quoted(c, whose), self.time(time));
                    Phrase::joined(
                        self.say(format!("此前 {time} 内并未{c}"), format!("not in the last {time}: {c}")),
                    )
                }
                ("previously", [c]) => {
                    let c = self.quoted(c, whose);
                    Phrase::joined(self.say(format!("此前并未{c}"), format!("not before: {c}")))
                }
                ("exists", [c, ..]) => {
                    let c = self.quoted(c, Whose::Object);
                    let kind = self.kind_of_object(arguments.get(1));
                    Phrase::joined(
                        self.say(format!("没有{kind}满足：{c}"), format!("no {kind} for which {c}")),
                    )
                }
                _ => self.denied(of, whose),
            },
            ExprKind::Within(inner, time) => {
                let (inner, time) = (self.quoted(inner, whose), self.time(time));
                Phrase::joined(self.say(
                    format!("此后 {time} 内并未{inner}"),
                    format!("not within the next {time}: {inner}"),
                ))
            }
            _ => self.denied(of, whose),
        }
    }

    fn denied(&self, of: &Expr, whose: Whose) -> Phrase {
        let of = self.with_guards().quoted(of, whose);
        Phrase::comparison(self.say(format!("并非{of}"), format!("not: {of}")))
    }

    /// The words inside a negation.
    fn with_guards(&self) -> Self {
        Self { guards: Guards::Kept, ..*self }
    }

    /// `not (x is known and x)`: it also holds where x is unknown.
    fn not_or_unknown(&self, of: &Expr, whose: Whose) -> Phrase {
        match &of.kind {
            ExprKind::Name(name) if !self.checker.names.contains_key(name) => {
                match self.checker.definitions.get(name) {
                    Some(definition) => self.not_or_unknown(&definition.expr, whose),
                    None => self.denied_or_unknown(of, whose),
                }
            }
            ExprKind::In(..) | ExprKind::Compare(..) => {
                let not = self.not(of, whose).text;
                Phrase::comparison(self.say(format!("{not}{ZH_OR_UNKNOWN}"), format!("{not}{EN_OR_UNKNOWN}")))
            }
            _ => self.denied_or_unknown(of, whose),
        }
    }

    fn denied_or_unknown(&self, of: &Expr, whose: Whose) -> Phrase {
        let of = self.quoted(of, whose);
        Phrase::comparison(self.say(format!("并非{ZH_OR_UNKNOWN}{of}"), format!("not{EN_OR_UNKNOWN}: {of}")))
    }

    fn call(&self, name: &str, arguments: &[Expr], whose: Whose) -> Phrase {
        let noun = |zh: String, en: String| Phrase::single(self.say(zh, en));
        match (name, arguments) {
            ("abs", [x]) => Phrase::single(format!("|{}|", self.phrase(x, whose).text)),
            ("min" | "max", [x, time]) => {
                let (x, time) = (self.quoted(x, whose), self.time(time));
                let (zh, en) = if name == "min" { ("小", "lowest") } else { ("大", "highest") };
                noun(format!("最近 {time} 内{x}的最{zh}值"), format!("{en} {x} of the last {time}"))
            }
            ("share", [c, time]) => {
                let (c, time) = (self.quoted(c, whose), self.time(time));
                noun(format!("最近 {time} 内{c}的时间占比"), format!("share of the last {time} in which {c}"))
            }
            ("rises", [c]) => {
                let c = self.quoted(c, whose);
                Phrase::joined(self.say(format!("此刻起{c}"), format!("from now on: {c}")))
            }
            ("falls", [c]) => {
                let c = self.quoted(c, whose);
                Phrase::joined(self.say(format!("此刻起不再{c}"), format!("no longer: {c}")))
            }
            ("previously", [c, time]) => {
                let (c, time) = (self.quoted(c, whose), self.time(time));
                Phrase::joined(self.say(format!("此前 {time} 内{c}"), format!("within the last {time}: {c}")))
            }
            ("previously", [c]) => {
                let c = self.quoted(c, whose);
                Phrase::joined(self.say(format!("此前{c}"), format!("before: {c}")))
            }
            ("exists" | "forall" | "count", [c, ..]) => {
                let c = self.quoted(c, Whose::Object);
                let kind = self.kind_of_object(arguments.get(1));
                match name {
                    "exists" => Phrase::joined(
                        self.say(format!("有{kind}满足：{c}"), format!("a {kind} for which {c}")),
                    ),
                    "forall" => Phrase::joined(
                        self.say(format!("每个{kind}都满足：{c}"), format!("for every {kind}: {c}")),
                    ),
                    _ => noun(format!("满足“{c}”的{kind}数"), format!("number of {kind}s for which {c}")),
                }
            }
            ("least" | "greatest", [x]) => {
                let x = self.quoted(x, whose);
                let (zh, en) = if name == "least" { ("小", "lowest") } else { ("大", "highest") };
                noun(format!("事件期间{x}的最{zh}值"), format!("{en} {x} of the event"))
            }
            _ => Phrase::single(name.replace('_', " ")),
        }
    }

    /// `vru` in `exists(c, vru)`; any object without one.
    fn kind_of_object(&self, word: Option<&Expr>) -> String {
        match word.map(|e| &e.kind) {
            Some(ExprKind::Name(word)) if word != "any" => self.value(word),
            _ => self.say("对象".into(), "object".into()),
        }
    }

    fn value(&self, word: &str) -> String {
        self.checker.catalog.value_name(word).get(self.lang).to_owned()
    }

    fn compare(&self, first: &Expr, rest: &[(CompareOp, Expr)], whose: Whose) -> Phrase {
        if let [(op @ (CompareOp::Equal | CompareOp::NotEqual), right)] = rest
            && let Some(truth) = right.truth()
        {
            let holds = truth == (*op == CompareOp::Equal);
            return if holds { self.phrase(first, whose) } else { self.not(first, whose) };
        }
        if let [(op @ (CompareOp::Equal | CompareOp::NotEqual), Expr { kind: ExprKind::Name(word), .. })] =
            rest
            && !self.checker.is_own(word)
            && self.checker.catalog.get(word).is_none()
            && !word.contains('.')
        {
            return self.is_one_of(first, &[word], *op == CompareOp::Equal, whose);
        }
        // What is measured comes first.
        if let [(op, right)] = rest
            && self.checker.quantity(first).is_some()
            && self.checker.quantity(right).is_none()
        {
            return self.compare(right, &[(op.mirrored(), first.clone())], whose);
        }
        let mut text = self.quoted(first, whose);
        for (op, right) in rest {
            text = format!("{text} {} {}", sign(*op), self.quoted(right, whose));
        }
        Phrase::comparison(text)
    }

    fn is_one_of(&self, of: &Expr, members: &[&str], is: bool, whose: Whose) -> Phrase {
        let of = self.quoted(of, whose);
        let names: Vec<String> = members.iter().map(|word| self.value(word)).collect();
        let (last, others) = names.split_last().map_or(("", &names[..]), |(l, o)| (l.as_str(), o));
        let (comma, or) = match self.lang {
            Lang::Zh => ("、", "或"),
            Lang::En => (", ", " or "),
        };
        let list =
            if others.is_empty() { last.to_owned() } else { format!("{}{or}{last}", others.join(comma)) };
        Phrase::comparison(match is {
            true => self.say(format!("{of}为{list}"), format!("{of} is {list}")),
            false => self.say(format!("{of}不为{list}"), format!("{of} is not {list}")),
        })
    }
}

fn opposite(op: CompareOp) -> CompareOp {
    match op {
        CompareOp::Less => CompareOp::GreaterOrEqual,
        CompareOp::LessOrEqual => CompareOp::Greater,
        CompareOp::Greater => CompareOp::LessOrEqual,
        CompareOp::GreaterOrEqual => CompareOp::Less,
        CompareOp::Equal => CompareOp::NotEqual,
        CompareOp::NotEqual => CompareOp::Equal,
    }
}

fn sign(op: CompareOp) -> &'static str {
    match op {
        CompareOp::LessOrEqual => "≤",
        CompareOp::GreaterOrEqual => "≥",
        CompareOp::Equal => "=",
        CompareOp::NotEqual => "≠",
        other => other.symbol(),
    }
}

/// A number and its unit as displayed.
fn quantity(q: Quantity) -> String {
    let shown = q.unit.displayed();
    let value = q.unit.convert(q.value, shown);
    // Converted values have digits that nobody wrote.
    let value = if shown == q.unit { value } else { (value * 100.0).round() / 100.0 };
    shown.of(&(value + 0.0).to_string().replace('-', "−"))
}

#[cfg(test)]
mod tests;
