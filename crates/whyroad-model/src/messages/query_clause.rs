//! The conditions of a `mining_query`: the comparisons of DATA_FORMAT.md 5.1 and, compatible with them, clauses that
//! combine others (`any`, `all`, `not`), refer to time, or are written in the rule language
//! (`docs/reference/rules.md`).

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// `field operator value unit`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QueryCondition {
    /// A signal's name or alias.
    pub field: String,
    /// Comparison.
    pub operator: QueryOperator,
    /// A number, text or truth value.
    pub value: serde_json::Value,
    /// Unit of the value; absent is the signal's base unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// Comparison in a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(inline)]
pub enum QueryOperator {
    /// Greater.
    #[serde(rename = ">")]
    Gt,
    /// Greater or equal.
    #[serde(rename = ">=")]
    Ge,
    /// Less.
    #[serde(rename = "<")]
    Lt,
    /// Less or equal.
    #[serde(rename = "<=")]
    Le,
    /// Equal.
    #[serde(rename = "==")]
    Eq,
    /// Not equal.
    #[serde(rename = "!=")]
    Ne,
    /// One of a list.
    #[serde(rename = "in")]
    In,
}

/// One clause of a query.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum QueryClause {
    /// `{"field": .., "operator": .., "value": .., "unit": ..}`.
    Comparison(QueryCondition),
    /// `{"any": [..]}`.
    Any(AnyOf),
    /// `{"all": [..]}`.
    All(AllOf),
    /// `{"not": ..}`.
    Not(NotThat),
    /// `{"temporal": "for", "seconds": 2, "condition": ..}`.
    OverTime(OverTime),
    /// `{"temporal": "then", "seconds": 3, "first": .., "second": ..}`.
    TwoOverTime(TwoOverTime),
    /// `{"rule": "target.gap < 20 m for 1 s"}`.
    Rule(RuleText),
}

/// At least one of them holds.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnyOf {
    /// The clauses.
    pub any: Vec<QueryClause>,
}

/// All of them hold.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AllOf {
    /// The clauses.
    pub all: Vec<QueryClause>,
}

/// It does not hold.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NotThat {
    /// The clause.
    pub not: Box<QueryClause>,
}

/// An operator over time with one operand.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverTime {
    /// Which.
    pub temporal: OneOperator,
    /// Its time, s: needed by `for` and `within`, optional for `previously`, none for `rises` and `falls`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Its operand.
    pub condition: Box<QueryClause>,
}

/// An operator over time with two operands.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoOverTime {
    /// Which.
    pub temporal: TwoOperator,
    /// Its time, s: needed by `then`, optional for `since` and `until`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// The clause on its left.
    pub first: Box<QueryClause>,
    /// The clause on its right.
    pub second: Box<QueryClause>,
}

/// A condition in the rule language.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RuleText {
    /// Its text.
    pub rule: String,
}

/// Operators over time of one operand, as in the rule language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum OneOperator {
    /// Belongs to a run of true that lasts at least that time.
    For,
    /// True now or within that time after now.
    Within,
    /// True at some earlier time, within that time before now.
    Previously,
    /// True now and false just before.
    Rises,
    /// False now and true just before.
    Falls,
}

/// Operators over time of two operands, as in the rule language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum TwoOperator {
    /// The second now, and the first before it.
    Then,
    /// The second now or earlier, and the first ever since.
    Since,
    /// The second now or later, and the first until then.
    Until,
}

/// Either kind of operator, as read.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Temporal {
    For,
    Within,
    Previously,
    Rises,
    Falls,
    Then,
    Since,
    Until,
}

/// A clause as read: the fields determine which clause it is. (An untagged enum would be read as well, but
/// could not say what is wrong with it, nor where.)
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    field: Option<String>,
    operator: Option<QueryOperator>,
    value: Option<serde_json::Value>,
    unit: Option<String>,
    any: Option<Vec<QueryClause>>,
    all: Option<Vec<QueryClause>>,
    not: Option<Box<QueryClause>>,
    temporal: Option<Temporal>,
    seconds: Option<f64>,
    condition: Option<Box<QueryClause>>,
    first: Option<Box<QueryClause>>,
    second: Option<Box<QueryClause>>,
    rule: Option<String>,
}

impl<'de> Deserialize<'de> for QueryClause {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Written::deserialize(deserializer)?.clause().map_err(serde::de::Error::custom)
    }
}

impl Written {
    fn clause(self) -> Result<QueryClause, String> {
        let kinds = [
            ("field", self.field.is_some() || self.operator.is_some() || self.value.is_some()),
            ("any", self.any.is_some()),
            ("all", self.all.is_some()),
            ("not", self.not.is_some()),
            ("temporal", self.temporal.is_some()),
            ("rule", self.rule.is_some()),
        ];
        let found: Vec<&str> = kinds.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect();
        let [kind] = found.as_slice() else {
            return Err(format!(
                "a condition has `field`, `operator` and `value`, or one of `any`, `all`, `not`, `temporal`, `rule`; this one has {}",
                if found.is_empty() { "none of them".to_owned() } else { found.join(" and ") }
            ));
        };
        let stray = [
            ("unit", self.unit.is_some(), *kind == "field"),
            ("seconds", self.seconds.is_some(), *kind == "temporal"),
            ("condition", self.condition.is_some(), *kind == "temporal"),
            ("first", self.first.is_some(), *kind == "temporal"),
            ("second", self.second.is_some(), *kind == "temporal"),
        ];
        if let Some((name, ..)) = stray.iter().find(|(_, there, belongs)| *there && !belongs) {
            return Err(format!("`{name}` does not belong beside `{kind}`"));
        }
        let missing = |name: &str| format!("missing field `{name}`");
        if let Some(any) = self.any {
            return Ok(QueryClause::Any(AnyOf { any }));
        }
        if let Some(all) = self.all {
            return Ok(QueryClause::All(AllOf { all }));
        }
        if let Some(not) = self.not {
            return Ok(QueryClause::Not(NotThat { not }));
        }
        if let Some(rule) = self.rule {
            return Ok(QueryClause::Rule(RuleText { rule }));
        }
        if let Some(temporal) = self.temporal {
            return over_time(temporal, self.seconds, self.condition, (self.first, self.second));
        }
        Ok(QueryClause::Comparison(QueryCondition {
            field: self.field.ok_or_else(|| missing("field"))?,
            operator: self.operator.ok_or_else(|| missing("operator"))?,
            value: self.value.ok_or_else(|| missing("value"))?,
            unit: self.unit,
        }))
    }
}

type Operand = Option<Box<QueryClause>>;

fn over_time(
    temporal: Temporal,
    seconds: Option<f64>,
    condition: Operand,
    (first, second): (Operand, Operand),
) -> Result<QueryClause, String> {
    use Temporal::{Falls, For, Previously, Rises, Since, Then, Until, Within};
    match (temporal, seconds) {
        (For | Within | Then, None) => return Err("missing field `seconds`".to_owned()),
        (Rises | Falls, Some(_)) => return Err("`rises` and `falls` take no `seconds`".to_owned()),
        (_, Some(s)) if !(s.is_finite() && s >= 0.0) => {
            return Err("`seconds` is a number of seconds, zero or more".to_owned());
        }
        _ => {}
    }
    let one = |temporal| match (&first, &second, condition.clone()) {
        (None, None, Some(condition)) => Ok(QueryClause::OverTime(OverTime { temporal, seconds, condition })),
        _ => Err("this operator has one operand, `condition`".to_owned()),
    };
    let two = |temporal| match (first.clone(), second.clone(), &condition) {
        (Some(first), Some(second), None) => {
            Ok(QueryClause::TwoOverTime(TwoOverTime { temporal, seconds, first, second }))
        }
        _ => Err("this operator has two operands, `first` and `second`".to_owned()),
    };
    match temporal {
        For => one(OneOperator::For),
        Within => one(OneOperator::Within),
        Previously => one(OneOperator::Previously),
        Rises => one(OneOperator::Rises),
        Falls => one(OneOperator::Falls),
        Then => two(TwoOperator::Then),
        Since => two(TwoOperator::Since),
        Until => two(TwoOperator::Until),
    }
}
