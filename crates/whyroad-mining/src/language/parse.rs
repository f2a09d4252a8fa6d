//! Tokens to syntax. From loosest to tightest:
//!
//! ```text
//! sequence    := held ("then" held "within" duration)*
//!              | held ("since" | "until") held ["within" duration]
//! held        := disjunction ("for" duration ["gaps" duration] | "within" duration)*
//!                                                                -- applies to everything to its left
//! disjunction := conjunction ("or" conjunction)*
//! conjunction := negation ("and" negation)*
//! negation    := "not" negation | comparison
//! comparison  := sum (compare sum)* | sum "in" "{" name ("," name)* "}" | sum "is" ["not"] "known"
//! sum         := product (("+" | "-") product)*
//! product     := prefix ("*" prefix)*
//! prefix      := "-" prefix | primary ["at" "keyframe"]
//! primary     := number [unit] | name | name "(" sequence ("," sequence)* ")" | "(" sequence ")"
//! ```
//!
//! `a for 1 s and b` is rejected, not guessed: it needs parentheses.

use super::Fault;
use super::check::nearest;
use super::syntax::{ArithmeticOp, Expr, ExprKind, Extent, Span};
use super::token::{KEYWORDS, Token, tokens};

/// The expression in `text`, or the first fault.
pub fn parse(text: &str) -> Result<Expr, Fault> {
    let tokens = tokens(text)?;
    if let Some((_, span)) = tokens.get(MAX_TOKENS) {
        return Err(Fault::new(
            "rule.syntax",
            *span,
            format!("表达式过长：超过 {MAX_TOKENS} 个词"),
            format!("the expression is too long: more than {MAX_TOKENS} words and signs"),
        )
        .hint("请用 define 分成几个有名字的部分", "name parts of it under `define`"));
    }
    let end = Span { start: text.trim_end().len(), end: text.trim_end().len() };
    let mut parser = Parser { tokens, at: 0, end, depth: 0 };
    let expr = parser.sequence()?;
    match parser.peek() {
        None if !expr.extent(&|_| Extent::default()).is_sane() => Err(too_large(expr.span)),
        None => Ok(expr),
        Some(Token::Keyword(k @ ("and" | "or"))) => Err(two_readings(k, parser.span())),
        Some(token) => {
            let meant = match token {
                Token::Name(name) => nearest(&name.to_lowercase(), KEYWORDS.iter().copied().chain(["gaps"])),
                _ => None,
            };
            let fault =
                parser.unexpected("rule.syntax", "表达式应在此结束", "the expression should end here");
            Err(match meant {
                Some(word) => fault.hint(format!("是否想写 `{word}`？"), format!("did you mean `{word}`?")),
                None => fault,
            })
        }
    }
}

/// Parentheses in parentheses: the parser goes through all its levels for each.
const MAX_DEPTH: usize = 64;
/// Limits the chains (`not not a`, `a + b + c`) that are built without parentheses.
const MAX_TOKENS: usize = 2000;

/// The fault for an expression that exceeds [`Extent::MOST`].
pub fn too_large(span: Span) -> Fault {
    let most = Extent::MOST;
    Fault::new(
        "rule.syntax",
        span,
        format!("嵌套超过 {} 层，或展开后超过 {} 项", most.height, most.size),
        format!("nested more than {} deep, or more than {} parts in all", most.height, most.size),
    )
    .hint("请写得简单些", "write it more simply")
}

/// The fault for `a for 1 s and b`.
fn two_readings(word: &str, span: Span) -> Fault {
    Fault::new(
        "rule.syntax",
        span,
        format!("`for`、`within` 之后的 `{word}` 有歧义"),
        format!("`{word}` after `for` or `within` can be read in two ways"),
    )
    .hint("请加括号，例如 (a for 1 s) and b", "write parentheses, as in (a for 1 s) and b")
}

struct Parser {
    tokens: Vec<(Token, Span)>,
    at: usize,
    end: Span,
    depth: usize,
}

impl Parser {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at).map(|(t, _)| t)
    }

    fn span(&self) -> Span {
        self.tokens.get(self.at).map_or(self.end, |(_, s)| *s)
    }

    fn keyword(&mut self, word: &str) -> bool {
        let found = matches!(self.peek(), Some(Token::Keyword(k)) if *k == word);
        self.at += usize::from(found);
        found
    }

    fn sign(&mut self, sign: char) -> bool {
        let found = matches!(self.peek(), Some(Token::Sign(c)) if *c == sign);
        self.at += usize::from(found);
        found
    }

    fn unexpected(&self, code: &'static str, zh: &str, en: &str) -> Fault {
        let (found_zh, found_en) = match self.peek() {
            None => ("此处已到末尾".to_owned(), "the text ends here".to_owned()),
            Some(Token::Name(n)) => (format!("此处是 '{n}'"), format!("found '{n}'")),
            Some(Token::Keyword(k)) => (format!("此处是 '{k}'"), format!("found '{k}'")),
            Some(Token::Sign(c)) => (format!("此处是 '{c}'"), format!("found '{c}'")),
            Some(Token::Compare(op)) => {
                (format!("此处是 '{}'", op.symbol()), format!("found '{}'", op.symbol()))
            }
            Some(Token::Number(q)) => {
                (format!("此处是数 {}", q.value), format!("found the number {}", q.value))
            }
        };
        Fault::new(code, self.span(), format!("{zh}；{found_zh}"), format!("{en}; {found_en}"))
    }

    fn expect(&mut self, sign: char) -> Result<(), Fault> {
        if self.sign(sign) {
            return Ok(());
        }
        if let Some(Token::Keyword(k @ ("and" | "or"))) = self.peek() {
            return Err(two_readings(k, self.span()));
        }
        Err(self.unexpected("rule.syntax", &format!("缺少 '{sign}'"), &format!("expected '{sign}'")))
    }

    fn sequence(&mut self) -> Result<Expr, Fault> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(too_large(self.span()));
        }
        let mut left = self.held(Postfix::All)?;
        while self.keyword("then") {
            let right = self.held(Postfix::ForOnly)?;
            if !self.keyword("within") {
                return Err(self.unexpected(
                    "rule.syntax",
                    "`then` 之后须写明时限：a then b within 3 s",
                    "`then` needs its time: a then b within 3 s",
                ));
            }
            let time = self.duration()?;
            let span = left.span.to(time.span);
            left = Expr { kind: ExprKind::Then(Box::new(left), Box::new(right), Box::new(time)), span };
        }
        left = self.lasting(left)?;
        self.depth -= 1;
        Ok(left)
    }

    /// `since` and `until` after their operand; two of them in a row are ambiguous.
    fn lasting(&mut self, left: Expr) -> Result<Expr, Fault> {
        let make = if self.keyword("since") {
            ExprKind::Since
        } else if self.keyword("until") {
            ExprKind::Until
        } else {
            return Ok(left);
        };
        let right = self.held(Postfix::ForOnly)?;
        let time = if self.keyword("within") { Some(self.duration()?) } else { None };
        if let Some(Token::Keyword(k @ ("then" | "since" | "until"))) = self.peek() {
            let k = *k;
            return Err(Fault::new(
                "rule.syntax",
                self.span(),
                format!("`since`、`until` 之后的 `{k}` 有歧义"),
                format!("`{k}` after `since` or `until` can be read in two ways"),
            )
            .hint("请加括号", "write parentheses"));
        }
        let span = left.span.to(time.as_ref().map_or(right.span, |t| t.span));
        Ok(Expr { kind: make(Box::new(left), Box::new(right), time.map(Box::new)), span })
    }

    /// `within` after `then`, `since` and `until` belongs to them.
    fn held(&mut self, postfix: Postfix) -> Result<Expr, Fault> {
        let mut of = self.disjunction()?;
        loop {
            if self.keyword("for") {
                let time = self.duration()?;
                let mut span = of.span.to(time.span);
                if matches!(self.peek(), Some(Token::Name(n)) if n == "gaps") {
                    self.at += 1;
                    let gaps = self.duration()?;
                    span = of.span.to(gaps.span);
                    of = Expr { kind: ExprKind::Gaps(Box::new(of), Box::new(gaps)), span };
                }
                of = Expr { kind: ExprKind::For(Box::new(of), Box::new(time)), span };
            } else if matches!(postfix, Postfix::All) && self.keyword("within") {
                let time = self.duration()?;
                let span = of.span.to(time.span);
                of = Expr { kind: ExprKind::Within(Box::new(of), Box::new(time)), span };
            } else {
                return Ok(of);
            }
        }
    }

    /// A number or a parameter's name; that it is a time is checked later.
    fn duration(&mut self) -> Result<Expr, Fault> {
        match self.peek() {
            Some(Token::Number(_) | Token::Name(_)) => self.primary(),
            _ => {
                Err(self.unexpected("rule.syntax", "此处应为时长，如 0.5 s", "expected a time such as 0.5 s"))
            }
        }
    }

    fn disjunction(&mut self) -> Result<Expr, Fault> {
        self.chain("or", Self::conjunction, ExprKind::Or)
    }

    fn conjunction(&mut self) -> Result<Expr, Fault> {
        self.chain("and", Self::negation, ExprKind::And)
    }

    fn chain(
        &mut self,
        word: &str,
        operand: fn(&mut Self) -> Result<Expr, Fault>,
        make: fn(Vec<Expr>) -> ExprKind,
    ) -> Result<Expr, Fault> {
        let first = operand(self)?;
        let mut all = vec![first];
        while self.keyword(word) {
            all.push(operand(self)?);
        }
        if all.len() == 1 {
            return Ok(all.remove(0));
        }
        let span = all[0].span.to(all[all.len() - 1].span);
        Ok(Expr { kind: make(all), span })
    }

    fn negation(&mut self) -> Result<Expr, Fault> {
        let start = self.span();
        let mut count = 0usize;
        while self.keyword("not") {
            count += 1;
        }
        let mut of = self.comparison()?;
        for _ in 0..count {
            let span = start.to(of.span);
            of = Expr { kind: ExprKind::Not(Box::new(of)), span };
        }
        Ok(of)
    }

    fn comparison(&mut self) -> Result<Expr, Fault> {
        let left = self.sum()?;
        if self.keyword("in") {
            let (members, end) = self.members()?;
            let span = left.span.to(end);
            return Ok(Expr { kind: ExprKind::In(Box::new(left), members), span });
        }
        if self.keyword("is") {
            let negated = self.keyword("not");
            let end = self.span();
            let word = match self.peek() {
                Some(Token::Name(n)) if n == "known" || n == "unknown" => n.clone(),
                _ => {
                    return Err(self.unexpected(
                        "rule.syntax",
                        "`is` 之后应为 known 或 unknown",
                        "`is` is followed by `known` or `unknown`",
                    ));
                }
            };
            self.at += 1;
            let span = left.span.to(end);
            let known = Expr { kind: ExprKind::Known(Box::new(left)), span };
            let positive = (word == "known") != negated;
            return Ok(if positive { known } else { Expr { kind: ExprKind::Not(Box::new(known)), span } });
        }
        let mut rest = Vec::new();
        while let Some(Token::Compare(op)) = self.peek() {
            let op = *op;
            self.at += 1;
            rest.push((op, self.sum()?));
        }
        match rest.last() {
            None => Ok(left),
            Some((_, last)) => {
                let span = left.span.to(last.span);
                Ok(Expr { kind: ExprKind::Compare(Box::new(left), rest), span })
            }
        }
    }

    fn members(&mut self) -> Result<(Vec<(String, Span)>, Span), Fault> {
        self.expect('{')?;
        let mut members = Vec::new();
        loop {
            let span = self.span();
            match self.peek() {
                Some(Token::Name(n)) => members.push((n.clone(), span)),
                _ => return Err(self.unexpected("rule.syntax", "此处应为名称", "expected a name")),
            }
            self.at += 1;
            let end = self.span();
            if self.sign('}') {
                return Ok((members, end));
            }
            self.expect(',')?;
        }
    }

    fn sum(&mut self) -> Result<Expr, Fault> {
        let mut left = self.product()?;
        loop {
            let op = if self.sign('+') {
                ArithmeticOp::Add
            } else if self.sign('-') {
                ArithmeticOp::Subtract
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            left = arithmetic(op, left, right);
        }
    }

    fn product(&mut self) -> Result<Expr, Fault> {
        let mut left = self.prefix()?;
        while self.sign('*') {
            let right = self.prefix()?;
            left = arithmetic(ArithmeticOp::Multiply, left, right);
        }
        Ok(left)
    }

    fn prefix(&mut self) -> Result<Expr, Fault> {
        let start = self.span();
        if self.sign('-') {
            self.depth += 1;
            if self.depth > MAX_DEPTH {
                return Err(too_large(start));
            }
            let of = self.prefix()?;
            self.depth -= 1;
            let span = start.to(of.span);
            return Ok(Expr { kind: ExprKind::Negate(Box::new(of)), span });
        }
        let of = self.primary()?;
        if self.keyword("at") {
            let end = self.span();
            if !matches!(self.peek(), Some(Token::Name(n)) if n == "keyframe") {
                return Err(self.unexpected(
                    "rule.syntax",
                    "`at` 之后只能是 keyframe",
                    "only `keyframe` can follow `at`",
                ));
            }
            self.at += 1;
            let span = of.span.to(end);
            return Ok(Expr { kind: ExprKind::At(Box::new(of)), span });
        }
        Ok(of)
    }

    fn primary(&mut self) -> Result<Expr, Fault> {
        let span = self.span();
        match self.peek().cloned() {
            Some(Token::Number(q)) => {
                self.at += 1;
                Ok(Expr { kind: ExprKind::Number(q), span })
            }
            Some(Token::Name(name)) => {
                self.at += 1;
                if !self.sign('(') {
                    return Ok(Expr { kind: ExprKind::Name(name), span });
                }
                let mut arguments = Vec::new();
                loop {
                    arguments.push(self.sequence()?);
                    let end = self.span();
                    if self.sign(')') {
                        return Ok(Expr { kind: ExprKind::Call(name, arguments), span: span.to(end) });
                    }
                    self.expect(',')?;
                }
            }
            Some(Token::Sign('(')) => {
                self.at += 1;
                let inner = self.sequence()?;
                let end = self.span();
                self.expect(')')?;
                Ok(Expr { kind: inner.kind, span: span.to(end) })
            }
            _ => Err(self.unexpected(
                "rule.syntax",
                "此处应为信号、数或括号",
                "expected a signal, a number or '('",
            )),
        }
    }
}

#[derive(Clone, Copy)]
enum Postfix {
    All,
    ForOnly,
}

fn arithmetic(op: ArithmeticOp, left: Expr, right: Expr) -> Expr {
    let span = left.span.to(right.span);
    Expr { kind: ExprKind::Arithmetic(op, Box::new(left), Box::new(right)), span }
}
