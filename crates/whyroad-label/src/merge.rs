//! Fields of a draft by JSON pointer (RFC 6901): changing them, and merging two people's changes field by field. This
//! module does not depend on tasks, users or the protocol.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use whyroad_model::Bilingual;

/// Maximum size of a draft in bytes.
pub const MAX_DRAFT: usize = 256 * 1024;
/// Maximum nesting of a draft. A label needs five levels; a document nested beyond 128 could be stored but never be
/// read again.
pub const MAX_DEPTH: usize = 32;
/// Maximum number of values in a draft, lists and objects included. A label has several hundred; the time of checking
/// grows with them.
pub const MAX_VALUES: usize = 5_000;
/// Maximum number of changes in one request.
pub const MAX_CHANGES: usize = 100;

/// One field set, added or removed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldChange {
    /// JSON pointer into the label: `/coc_trace`, `/critical_components/0/description`; `-` as the last part appends.
    pub path: String,
    /// New value.
    #[serde(default)]
    pub value: Value,
    /// Removes the field instead.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub remove: bool,
}

/// A field that two people changed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FieldConflict {
    /// JSON pointer.
    pub path: String,
    /// The caller's value.
    pub mine: Value,
    /// The current value.
    pub theirs: Value,
}

/// Why a change or a draft is rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DraftError {
    /// The text is not the path of a field.
    #[error("'{0}' is not the path of a field")]
    NotAPath(String),
    /// The draft has no such field, and none can be added there.
    #[error("no field at {0}")]
    NoField(String),
    /// Larger than [`MAX_DRAFT`].
    #[error("the draft is too large")]
    TooLarge,
    /// Nested deeper than [`MAX_DEPTH`].
    #[error("the draft is nested more than {MAX_DEPTH} levels deep")]
    TooDeep,
    /// More values than [`MAX_VALUES`].
    #[error("the draft has more than {MAX_VALUES} values")]
    TooMany,
}

impl DraftError {
    /// Stable code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotAPath(_) | Self::NoField(_) => "draft.path",
            Self::TooLarge => "draft.too_large",
            Self::TooDeep => "draft.too_deep",
            Self::TooMany => "draft.too_many",
        }
    }

    /// The message in both languages.
    pub fn text(&self) -> Bilingual {
        let zh = match self {
            Self::NotAPath(path) => format!("'{path}' 不是字段路径"),
            Self::NoField(path) => format!("路径 {path} 处没有字段"),
            Self::TooLarge => "草稿过大".to_owned(),
            Self::TooDeep => format!("草稿嵌套超过 {MAX_DEPTH} 层"),
            Self::TooMany => format!("草稿中的值超过 {MAX_VALUES} 个"),
        };
        Bilingual::new(zh, self.to_string())
    }
}

/// Applies one change. Missing objects on the path are created; list elements must exist.
pub fn apply(draft: &mut Value, change: &FieldChange) -> Result<(), DraftError> {
    let parts = parts(&change.path)?;
    let wrong = || DraftError::NoField(change.path.clone());
    let Some((last, way)) = parts.split_last() else { return Err(wrong()) };
    let mut at = draft;
    for part in way {
        if at.is_null() {
            *at = Value::Object(Map::new());
        }
        at = match at {
            Value::Object(fields) => fields.entry(part.clone()).or_insert(Value::Null),
            Value::Array(items) => {
                part.parse::<usize>().ok().and_then(|i| items.get_mut(i)).ok_or_else(wrong)?
            }
            _ => return Err(wrong()),
        };
    }
    if at.is_null() {
        *at = if last == "-" { Value::Array(vec![]) } else { Value::Object(Map::new()) };
    }
    match at {
        Value::Object(fields) if change.remove => {
            fields.remove(last);
        }
        Value::Object(fields) => {
            fields.insert(last.clone(), change.value.clone());
        }
        Value::Array(items) if last == "-" && !change.remove => items.push(change.value.clone()),
        Value::Array(items) => {
            let i = last.parse::<usize>().ok().filter(|i| *i < items.len()).ok_or_else(wrong)?;
            if change.remove {
                items.remove(i);
            } else {
                items[i] = change.value.clone();
            }
        }
        _ => return Err(wrong()),
    }
    Ok(())
}

/// Rejects a draft that is larger or nested deeper than any label.
pub fn bounded(draft: &Value) -> Result<(), DraftError> {
    if draft.to_string().len() > MAX_DRAFT {
        return Err(DraftError::TooLarge);
    }
    if depth(draft) > MAX_DEPTH {
        return Err(DraftError::TooDeep);
    }
    if values(draft) > MAX_VALUES {
        return Err(DraftError::TooMany);
    }
    Ok(())
}

/// Depth of nested lists and objects; 0 for a plain value. serde_json reads nothing deeper than 128, and a change adds
/// at most eight, so the recursion is bounded.
fn depth(value: &Value) -> usize {
    match value {
        Value::Array(items) => 1 + items.iter().map(depth).max().unwrap_or(0),
        Value::Object(fields) => 1 + fields.values().map(depth).max().unwrap_or(0),
        _ => 0,
    }
}

/// Number of values, lists and objects included.
fn values(value: &Value) -> usize {
    match value {
        Value::Array(items) => 1 + items.iter().map(values).sum::<usize>(),
        Value::Object(fields) => 1 + fields.values().map(values).sum::<usize>(),
        _ => 1,
    }
}

/// Rejects a path that is not in its canonical form, under which conflicts are searched: with empty parts, with numbers
/// such as `00` or `+1`, with a `~` that escapes nothing. Only for incoming changes; those of an older history stay
/// readable.
pub fn canonical(path: &str) -> Result<(), DraftError> {
    let number = |p: &str| {
        let digits = p.strip_prefix('+').unwrap_or(p);
        !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
    };
    let odd = |p: &str| {
        let escapes = p.split('~').skip(1).any(|rest| !rest.starts_with(['0', '1']));
        p.is_empty()
            || escapes
            || (number(p) && p != "0" && !p.starts_with(|c: char| ('1'..='9').contains(&c)))
    };
    if parts(path)?.is_empty() || path.split('/').skip(1).any(odd) {
        return Err(DraftError::NotAPath(path.to_owned()));
    }
    Ok(())
}

fn parts(path: &str) -> Result<Vec<String>, DraftError> {
    if path.len() > 200 || !path.starts_with('/') || path.split('/').count() > 8 {
        return Err(DraftError::NotAPath(path.to_owned()));
    }
    Ok(path.split('/').skip(1).map(|p| p.replace("~1", "/").replace("~0", "~")).collect())
}

/// The first part of a path: the field of the label.
pub fn top(path: &str) -> &str {
    path.trim_start_matches('/').split('/').next().unwrap_or_default()
}

/// How two changes relate to each other.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meeting {
    /// Both can be applied.
    Apart,
    /// They change the same field, or the field of one contains the other's.
    SameField,
    /// One removes an element from a list in which the other uses an index.
    Shifted,
}

fn meet(a: &FieldChange, b: &FieldChange) -> Meeting {
    // Two appends do not conflict.
    if a.path.ends_with("/-") && b.path.ends_with("/-") {
        return Meeting::Apart;
    }
    let within = |inner: &str, outer: &str| inner == outer || inner.starts_with(&format!("{outer}/"));
    let list_of = |c: &FieldChange| {
        let (list, last) = c.path.rsplit_once('/').unwrap_or_default();
        (c.remove && last.parse::<usize>().is_ok()).then(|| list.to_owned())
    };
    let shifts = |a: &FieldChange, b: &FieldChange| list_of(a).is_some_and(|list| within(&b.path, &list));
    if shifts(a, b) || shifts(b, a) {
        Meeting::Shifted
    } else if within(&a.path, &b.path) || within(&b.path, &a.path) {
        Meeting::SameField
    } else {
        Meeting::Apart
    }
}

/// Conflicts of `mine` with `theirs`, which was applied in between. A change to the current value is no conflict,
/// unless elements have moved: then another element happens to have this value.
pub fn conflicts(now: &Value, mine: &[FieldChange], theirs: &[FieldChange]) -> Vec<FieldConflict> {
    let there = |path: &str| now.pointer(path).cloned().unwrap_or(Value::Null);
    let clash = |m: &FieldChange, t: &FieldChange| match meet(m, t) {
        Meeting::Apart => false,
        Meeting::SameField => m.remove || now.pointer(&m.path) != Some(&m.value),
        Meeting::Shifted => true,
    };
    mine.iter()
        .filter(|m| theirs.iter().any(|t| clash(m, t)))
        .map(|m| FieldConflict { path: m.path.clone(), mine: m.value.clone(), theirs: there(&m.path) })
        .collect()
}

/// Top-level fields in which two drafts differ, sorted.
pub fn differing(a: &Value, b: &Value) -> Vec<String> {
    let (Some(a), Some(b)) = (a.as_object(), b.as_object()) else { return vec![] };
    let mut names: Vec<&String> = a.keys().chain(b.keys()).collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().filter(|k| a.get(*k) != b.get(*k)).map(|k| format!("/{k}")).collect()
}

#[cfg(test)]
mod tests;
