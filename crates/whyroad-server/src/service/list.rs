//! Lists of tasks with filters, page by page. A cursor is the place of the last one, so that a page stays whole while
//! others work.

use crate::domain::task::Tasks;
use crate::domain::workflow::State;
use crate::problem::{Answer, Problem};
use crate::service::{people, tasks};
use crate::store::{Tx, Value as Cell};

/// Tasks on a page when nothing is said, and at most.
const USUAL: usize = 50;
const MOST: usize = 200;
/// Maximum length of a text to search for, characters: databases refuse patterns beyond some tens of thousands.
const LONGEST_TEXT: usize = 200;

/// What is wanted, in the words of the query.
#[derive(Clone, Copy, Debug, Default)]
pub struct Filter<'a> {
    /// States, separated by commas.
    pub states: Option<&'a str>,
    /// A class: L1, L2 or leaf.
    pub scenario: Option<&'a str>,
    /// Held or written by this user (name or id).
    pub assignee: Option<&'a str>,
    /// Part of the clip's or task's id.
    pub part: Option<&'a str>,
    /// From the page before.
    pub cursor: Option<&'a str>,
    /// Page length.
    pub limit: Option<&'a str>,
    /// Only what is this user's (id): held, written or given.
    pub only_of: Option<&'a str>,
}

/// One page of the tasks of a project.
pub fn page(tx: &mut dyn Tx, project: &str, filter: &Filter<'_>) -> Answer<Tasks> {
    let limit = match filter.limit {
        None => USUAL,
        Some(text) => text.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(|| {
            Problem::request(format!("limit 须为 1 至 {MOST}"), format!("limit must be 1 to {MOST}"))
        })?,
    };
    for (name, text) in [("q", filter.part), ("scenario", filter.scenario), ("assignee", filter.assignee)] {
        if text.is_some_and(|t| t.chars().count() > LONGEST_TEXT) {
            return Err(Problem::request(
                format!("{name} 至多 {LONGEST_TEXT} 个字符"),
                format!("{name} may have at most {LONGEST_TEXT} characters"),
            ));
        }
    }
    let mut query = Query { sql: "project_id = $1".to_owned(), values: vec![project.into()] };
    states(&mut query, filter.states)?;
    if let Some(class) = filter.scenario {
        query.and(
            "(scenario_id = $ OR scenario_id LIKE $ ESCAPE '\\')",
            &[class.into(), format!("{}.%", literal(class)).into()],
        );
    }
    if let Some(name) = filter.assignee {
        let user = people::find(tx, name)?.map_or_else(|| name.to_owned(), |u| u.id);
        query.and(
            "(holder = $ OR author = $ OR assigned = $)",
            &[(&user).into(), (&user).into(), (&user).into()],
        );
    }
    if let Some(part) = filter.part {
        let like: Cell = format!("%{}%", literal(part)).into();
        query.and("(clip_id LIKE $ ESCAPE '\\' OR id LIKE $ ESCAPE '\\')", &[like.clone(), like]);
    }
    if let Some(user) = filter.only_of {
        query.and(
            "(holder = $ OR author = $ OR (assigned = $ AND author IS NULL))",
            &[user.into(), user.into(), user.into()],
        );
    }
    if let Some(cursor) = filter.cursor {
        let (priority, created, id) = place(cursor)?;
        query.and(
            "(priority < $ OR (priority = $ AND (created > $ OR (created = $ AND id > $))))",
            &[priority.into(), priority.into(), created.into(), created.into(), id.into()],
        );
    }
    // Ids first: only the tasks of this page are read whole.
    let sql = format!(
        "SELECT id FROM tasks WHERE {} ORDER BY priority DESC, created, id LIMIT {}",
        query.sql,
        limit + 1
    );
    let ids = tx.rows(&sql, &query.values)?;
    let mut found = ids.iter().map(|r| tasks::get(tx, &r.text("id")?)).collect::<Answer<Vec<_>>>()?;
    let more = found.len() > limit;
    found.truncate(limit);
    let next = found.last().filter(|_| more).map(|t| format!("{}_{}_{}", t.priority, t.created, t.id));
    let names = tasks::names(tx)?;
    Ok(Tasks { items: found.iter().map(|t| tasks::summary(t, &names)).collect(), next })
}

fn states(query: &mut Query, words: Option<&str>) -> Answer<()> {
    let Some(words) = words else { return Ok(()) };
    let state = |w: &str| {
        State::from_word(w.trim()).ok_or_else(|| {
            Problem::request(format!("'{w}' 不是任务状态"), format!("'{w}' is not a task state"))
        })
    };
    let states = words.split(',').map(state).collect::<Answer<Vec<_>>>()?;
    let holes = vec!["$"; states.len()].join(", ");
    let values: Vec<Cell> = states.iter().map(|s| s.word().into()).collect();
    query.and(&format!("state IN ({holes})"), &values);
    Ok(())
}

fn place(cursor: &str) -> Answer<(i64, i64, String)> {
    let bad = || Problem::request("cursor 无效", "cursor is invalid");
    let mut parts = cursor.splitn(3, '_');
    let mut part = || parts.next().ok_or_else(bad);
    let number = |text: &str| text.parse::<i64>().map_err(|_| bad());
    Ok((number(part()?)?, number(part()?)?, part()?.to_owned()))
}

/// A text inside LIKE.
fn literal(text: &str) -> String {
    text.replace('\\', "\\\\").replace('%', "\\%").replace('_', "\\_")
}

/// A condition in the making.
struct Query {
    sql: String,
    values: Vec<Cell>,
}

impl Query {
    /// Adds a condition; each `$` in it takes the next of `values`.
    fn and(&mut self, condition: &str, values: &[Cell]) {
        self.sql.push_str(" AND ");
        let mut next = self.values.len();
        for c in condition.chars() {
            self.sql.push(c);
            if c == '$' {
                next += 1;
                self.sql.push_str(&next.to_string());
            }
        }
        self.values.extend_from_slice(values);
    }
}
