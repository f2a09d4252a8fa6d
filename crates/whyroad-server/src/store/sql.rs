//! Values, rows and statements as both databases understand them. Statements write parameters as `$1`, `$2`, ...

use crate::problem::{Answer, Problem};

/// A value in a column: our tables have whole numbers and texts only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// Nothing.
    Null,
    /// BIGINT.
    Int(i64),
    /// TEXT.
    Text(String),
}

/// Refuses what not every database can hold: PostgreSQL's texts have no U+0000, and what goes into one store must go into
/// the other.
pub(super) fn holdable(values: &[Value]) -> Answer<()> {
    let odd = |v: &Value| matches!(v, Value::Text(t) if t.as_bytes().contains(&0));
    if !values.iter().any(odd) {
        return Ok(());
    }
    Err(Problem::new(422, "text.nul", "文本中不能含有字符 U+0000", "a text cannot hold the character U+0000"))
}

impl From<i64> for Value {
    fn from(v: i64) -> Self {
        Self::Int(v)
    }
}
impl From<&str> for Value {
    fn from(v: &str) -> Self {
        Self::Text(v.to_owned())
    }
}
impl From<String> for Value {
    fn from(v: String) -> Self {
        Self::Text(v)
    }
}
impl From<&String> for Value {
    fn from(v: &String) -> Self {
        Self::Text(v.clone())
    }
}
impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(v: Option<T>) -> Self {
        v.map_or(Self::Null, Into::into)
    }
}

/// One row of an answer.
#[derive(Clone, Debug)]
pub struct Row(pub Vec<Value>);

impl Row {
    /// The text in column `i`.
    pub fn text(&self, i: usize) -> Answer<String> {
        self.maybe_text(i)?.ok_or_else(|| Problem::store(format!("column {i} is null")))
    }

    /// The text in column `i`, where there is one.
    pub fn maybe_text(&self, i: usize) -> Answer<Option<String>> {
        match self.0.get(i) {
            Some(Value::Text(t)) => Ok(Some(t.clone())),
            Some(Value::Null) => Ok(None),
            other => Err(Problem::store(format!("column {i} is no text: {other:?}"))),
        }
    }

    /// The number in column `i`.
    pub fn int(&self, i: usize) -> Answer<i64> {
        self.maybe_int(i)?.ok_or_else(|| Problem::store(format!("column {i} is null")))
    }

    /// The number in column `i`, where there is one.
    pub fn maybe_int(&self, i: usize) -> Answer<Option<i64>> {
        match self.0.get(i) {
            Some(Value::Int(n)) => Ok(Some(*n)),
            Some(Value::Null) => Ok(None),
            other => Err(Problem::store(format!("column {i} is no number: {other:?}"))),
        }
    }
}

/// A transaction.
pub trait Tx {
    /// Runs a statement; the number of rows it touched.
    fn run(&mut self, sql: &str, values: &[Value]) -> Answer<u64>;
    /// Asks.
    fn rows(&mut self, sql: &str, values: &[Value]) -> Answer<Vec<Row>>;
    /// Runs several statements without parameters.
    fn script(&mut self, sql: &str) -> Answer<()>;
    /// Columns of a table in the order in which they were made; none where there is no such table.
    fn columns(&mut self, table: &str) -> Answer<Vec<String>>;
    /// What makes a SELECT keep its rows from other writers: ` FOR UPDATE`, or nothing where there is one writer.
    fn lock(&self) -> &'static str;

    /// The only row, where there is one.
    fn row(&mut self, sql: &str, values: &[Value]) -> Answer<Option<Row>> {
        Ok(self.rows(sql, values)?.into_iter().next())
    }
}

/// A list of values.
#[macro_export]
macro_rules! values {
    ($($v:expr),* $(,)?) => { &[$($crate::store::Value::from($v)),*] };
}
