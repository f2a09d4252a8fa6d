//! Values, rows and statements in a form that both databases support. Statements write parameters as `$1`, `$2`, ...

use crate::problem::{Answer, Problem};
use std::sync::Arc;

/// A value in a column: our tables only have integers and texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// NULL.
    Null,
    /// BIGINT.
    Int(i64),
    /// TEXT.
    Text(String),
}

/// Refuses values that not every database can store: PostgreSQL's texts cannot contain U+0000, and the content of one
/// store must be valid in the other.
pub(super) fn holdable(values: &[Value]) -> Answer<()> {
    let odd = |v: &Value| matches!(v, Value::Text(t) if t.as_bytes().contains(&0));
    if !values.iter().any(odd) {
        return Ok(());
    }
    Err(Problem::new(
        422,
        "text.nul",
        "文本中不能含有字符 U+0000",
        "a text cannot contain the character U+0000",
    ))
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

/// One row of a result. Its values are read by the name of their column: the one after `AS`, or the column's own.
#[derive(Clone, Debug)]
pub struct Row {
    /// Names, shared by all rows of a result.
    pub(super) columns: Arc<[String]>,
    /// Values, in the order of the names.
    pub(super) values: Vec<Value>,
}

impl Row {
    fn value(&self, column: &str) -> Answer<&Value> {
        let at = self.columns.iter().position(|c| c == column);
        at.and_then(|i| self.values.get(i)).ok_or_else(|| Problem::store(format!("no column '{column}'")))
    }

    /// The text in `column`.
    pub fn text(&self, column: &str) -> Answer<String> {
        self.maybe_text(column)?.ok_or_else(|| Problem::store(format!("column '{column}' is null")))
    }

    /// The text in `column`; `None` for null.
    pub fn maybe_text(&self, column: &str) -> Answer<Option<String>> {
        match self.value(column)? {
            Value::Text(t) => Ok(Some(t.clone())),
            Value::Null => Ok(None),
            Value::Int(n) => Err(Problem::store(format!("column '{column}' is not text: {n}"))),
        }
    }

    /// The number in `column`.
    pub fn int(&self, column: &str) -> Answer<i64> {
        self.maybe_int(column)?.ok_or_else(|| Problem::store(format!("column '{column}' is null")))
    }

    /// The number in `column`; `None` for null.
    pub fn maybe_int(&self, column: &str) -> Answer<Option<i64>> {
        match self.value(column)? {
            Value::Int(n) => Ok(Some(*n)),
            Value::Null => Ok(None),
            Value::Text(_) => Err(Problem::store(format!("column '{column}' is not a number"))),
        }
    }

    /// The flag in `column`, which contains 0 or 1.
    pub fn flag(&self, column: &str) -> Answer<bool> {
        Ok(self.int(column)? != 0)
    }
}

/// A transaction.
pub trait Tx {
    /// Runs a statement; returns the number of affected rows.
    fn run(&mut self, sql: &str, values: &[Value]) -> Answer<u64>;
    /// Runs a query.
    fn rows(&mut self, sql: &str, values: &[Value]) -> Answer<Vec<Row>>;
    /// Runs several statements without parameters.
    fn script(&mut self, sql: &str) -> Answer<()>;
    /// Columns of a table in the order of their creation; empty if the table does not exist.
    fn columns(&mut self, table: &str) -> Answer<Vec<String>>;
    /// SQL that makes a SELECT lock its rows for other writers: ` FOR UPDATE`, or empty if there is one writer.
    fn lock(&self) -> &'static str;

    /// The database's own clock, ms since 1970, if it has one that services on several machines share.
    fn clock(&mut self) -> Answer<Option<i64>> {
        Ok(None)
    }

    /// From now on, rows that this connection deletes are overwritten on disk, if the database does not do that itself.
    fn overwrite_deleted(&mut self) -> Answer<()> {
        Ok(())
    }

    /// The only row, if there is one.
    fn row(&mut self, sql: &str, values: &[Value]) -> Answer<Option<Row>> {
        Ok(self.rows(sql, values)?.into_iter().next())
    }
}
