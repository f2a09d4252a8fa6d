//! Lists of tasks with filters, page by page. A cursor is the position of the last item, so that pages stay consistent
//! while others work.

use crate::domain::task::{TaskSummary, Tasks};
use crate::domain::workflow::State;
use crate::problem::{Answer, Problem};
use crate::service::{disagreement, other_class, people, projects, seen, tasks, veil};
use crate::store::{Tx, Value as Cell};
use std::collections::BTreeSet;
use whyroad_model::Nanos;

/// Number of tasks on a page by default, and the maximum.
const USUAL: usize = 50;
const MOST: usize = 200;
/// Maximum length of a search text, characters: databases reject patterns of more than some tens of thousands.
const LONGEST_TEXT: usize = 200;

/// Filter and order, as given in the query.
#[derive(Clone, Copy, Debug, Default)]
pub struct Filter<'a> {
    /// States, separated by commas.
    pub states: Option<&'a str>,
    /// A class: L1, L2 or L3.
    pub scenario: Option<&'a str>,
    /// Held, assigned to or written by this user (name or id).
    pub assignee: Option<&'a str>,
    /// Part of the clip's or task's id.
    pub part: Option<&'a str>,
    /// From the page before.
    pub cursor: Option<&'a str>,
    /// Page length.
    pub limit: Option<&'a str>,
    /// Order: one of [`ORDERS`], with `-` in front for descending.
    pub sort: Option<&'a str>,
    /// Only tasks with an open question to the lead.
    pub asks_lead: bool,
    /// Only tasks whose class does not fit, as their annotators say, and that nothing replaces.
    pub wrong_class: bool,
    /// Only tasks that were submitted with a finding of this code; `any` for every code.
    pub finding: Option<&'a str>,
    /// Only tasks of these overlap groups.
    pub groups: Option<Groups>,
    /// Not these tasks (ids).
    pub hidden: Option<&'a BTreeSet<String>>,
    /// Only tasks of this user (id): held, written or assigned.
    pub only_of: Option<&'a str>,
}

/// Overlap groups that leads ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Groups {
    /// Still to be adjudicated: their labels disagree.
    Disagreeing,
    /// No label was chosen yet.
    ToChoose,
}

/// The user who reads the list.
#[derive(Clone, Copy, Debug)]
pub struct Viewer<'a> {
    /// User id.
    pub user: &'a str,
    /// May do Stage I: sees thumbnails only of opened tasks.
    pub labels: bool,
    /// Leads: sees which overlap groups disagree.
    pub leads: bool,
}

/// Orders other than that of the queue, with their column and whether it contains numbers.
const ORDERS: [(&str, &str, bool); 6] = [
    ("updated", "updated", true),
    ("created", "created", true),
    ("scenario", "scenario_id", false),
    ("clip", "clip_id", false),
    ("state", "state", false),
    ("keyframe", MOMENT, false),
];

/// The drive and the keyframe in it, as a text with digits of equal number.
const MOMENT: &str = "(drive_id || ' ' || substr('0000000000000000000' || CAST(keyframe_ns AS TEXT),
    length(CAST(keyframe_ns AS TEXT)) + 1))";

/// A column to sort by.
#[derive(Clone, Copy)]
struct Order {
    column: &'static str,
    numeric: bool,
    descending: bool,
}

impl Order {
    /// From the value in a request; `None` for the order of the queue.
    fn of(word: Option<&str>) -> Answer<Option<Self>> {
        let (descending, word) = match word {
            None | Some("" | "priority" | "-priority") => return Ok(None),
            Some(text) => text.strip_prefix('-').map_or((false, text), |rest| (true, rest)),
        };
        let found = ORDERS.iter().find(|(name, ..)| *name == word).ok_or_else(|| {
            Problem::request(format!("不能按 '{word}' 排序"), format!("cannot sort by '{word}'"))
        })?;
        Ok(Some(Self { column: found.1, numeric: found.2, descending }))
    }

    /// Condition for items after the position of `cursor`.
    fn after(self, query: &mut Query, class: &str, cursor: &str) -> Answer<()> {
        let bad = || Problem::request("cursor 无效", "cursor is invalid");
        let (value, id) = cursor.rsplit_once('_').ok_or_else(bad)?;
        let value: Cell =
            if self.numeric { value.parse::<i64>().map_err(|_| bad())?.into() } else { value.into() };
        let (column, sign) = (self.sorts_by(class), if self.descending { '<' } else { '>' });
        query.and(
            &format!("({column} {sign} $ OR ({column} = $ AND id > $))"),
            &[value.clone(), value, id.into()],
        );
        Ok(())
    }

    /// The SQL expression for sorting; `class` is the expression of the displayed class.
    fn sorts_by(self, class: &str) -> &str {
        if self.column == "scenario_id" { class } else { self.column }
    }

    fn cursor(self, t: &tasks::TaskRow) -> String {
        match self.column {
            "updated" => format!("{}_{}", t.updated, t.id),
            "created" => format!("{}_{}", t.created, t.id),
            "scenario_id" => format!("{}_{}", t.shown_class(), t.id),
            "clip_id" => format!("{}_{}", t.clip_id, t.id),
            MOMENT => format!("{} {:019}_{}", t.drive_id, t.keyframe_ns, t.id),
            _ => format!("{}_{}", t.at.state.word(), t.id),
        }
    }
}

/// One page of the tasks of a project, and the keyframe of each.
pub fn page(
    tx: &mut dyn Tx,
    project: &str,
    filter: &Filter<'_>,
    viewer: Viewer<'_>,
) -> Answer<(Tasks, Vec<Nanos>)> {
    let order = Order::of(filter.sort)?;
    let limit = match filter.limit {
        None => USUAL,
        Some(text) => text.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(|| {
            Problem::request(format!("limit 须为 1 至 {MOST}"), format!("limit must be 1 to {MOST}"))
        })?,
    };
    let texts = [
        ("q", filter.part),
        ("scenario", filter.scenario),
        ("assignee", filter.assignee),
        ("finding", filter.finding),
    ];
    for (name, text) in texts {
        if text.is_some_and(|t| t.chars().count() > LONGEST_TEXT) {
            return Err(Problem::request(
                format!("{name} 至多 {LONGEST_TEXT} 个字符"),
                format!("{name} may have at most {LONGEST_TEXT} characters"),
            ));
        }
    }
    let mut query = Query { sql: "project_id = $1".to_owned(), values: vec![project.into()] };
    let rule = projects::get(tx, project)?.settings.history;
    query.and(&seen::hidden_in_stage1(rule), &[viewer.user.into()]);
    states(&mut query, filter.states)?;
    // Neither filter nor order may reveal more of a class than is displayed.
    let class_sql = veil::shown_class_sql(&veil::of(tx, project)?);
    if let Some(class) = filter.scenario {
        query.and(
            &format!("({class_sql} = $ OR {class_sql} LIKE $ ESCAPE '\\')"),
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
    if filter.asks_lead {
        query.and("id IN (SELECT task_id FROM comments WHERE to_lead = 1 AND resolved = 0)", &[]);
    }
    if filter.wrong_class {
        query.and(other_class::WAITING, &[]);
    }
    match filter.finding {
        None => {}
        Some("any") => query.and("findings > ' '", &[]),
        Some(code) => {
            query.and("findings LIKE $ ESCAPE '\\'", &[format!("% {} %", literal(code)).into()]);
        }
    }
    if let Some(hidden) = filter.hidden.filter(|ids| !ids.is_empty()) {
        let holes = vec!["$"; hidden.len()].join(", ");
        let values: Vec<Cell> = hidden.iter().map(Cell::from).collect();
        query.and(&format!("id NOT IN ({holes})"), &values);
    }
    match filter.groups {
        Some(Groups::Disagreeing) => query.and(disagreement::TO_ADJUDICATE, &[]),
        Some(Groups::ToChoose) => query.and(disagreement::TO_CHOOSE, &[]),
        None => {}
    }
    let total = match filter.cursor {
        Some(_) => None,
        None => {
            let sql = format!("SELECT count(*) AS n FROM tasks WHERE {}", query.sql);
            tx.row(&sql, &query.values)?.map(|r| r.int("n")).transpose()?
        }
    };
    match (filter.cursor, order) {
        (Some(cursor), Some(order)) => order.after(&mut query, &class_sql, cursor)?,
        (Some(cursor), None) => {
            let (priority, created, id) = place(cursor)?;
            query.and(
                "(priority < $ OR (priority = $ AND (created > $ OR (created = $ AND id > $))))",
                &[priority.into(), priority.into(), created.into(), created.into(), id.into()],
            );
        }
        (None, _) => {}
    }
    let sequence = match order {
        None => "priority DESC, created, id".to_owned(),
        Some(order) if order.descending => format!("{} DESC, id", order.sorts_by(&class_sql)),
        Some(order) => format!("{}, id", order.sorts_by(&class_sql)),
    };
    // Ids first: only the tasks of this page are read completely.
    let sql = format!("SELECT id FROM tasks WHERE {} ORDER BY {sequence} LIMIT {}", query.sql, limit + 1);
    let ids = tx.rows(&sql, &query.values)?;
    let mut found = ids.iter().map(|r| tasks::get(tx, &r.text("id")?)).collect::<Answer<Vec<_>>>()?;
    let more = found.len() > limit;
    found.truncate(limit);
    let cursor = |t: &tasks::TaskRow| match order {
        None => format!("{}_{}_{}", t.priority, t.created, t.id),
        Some(order) => order.cursor(t),
    };
    let next = found.last().filter(|_| more).map(cursor);
    let names = tasks::names(tx)?;
    let mut items = Vec::with_capacity(found.len());
    for t in &found {
        let pictured =
            t.pictured && !t.hides_leaf() && (!viewer.labels || seen::was_shown(tx, t, viewer.user)?);
        let thumbnail = pictured.then(|| format!("/api/v1/tasks/{}/thumbnail", t.id));
        let (disagrees, to_choose) = (viewer.leads && t.disagrees, viewer.leads && t.to_choose);
        items.push(TaskSummary { thumbnail, disagrees, to_choose, ..tasks::summary(t, &names) });
    }
    Ok((Tasks { items, total, next }, found.iter().map(|t| Nanos(t.keyframe_ns)).collect()))
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
    // A label of which the lead chose another one waits for nothing.
    query.and(disagreement::NOT_SUPERSEDED, &[]);
    Ok(())
}

fn place(cursor: &str) -> Answer<(i64, i64, String)> {
    let bad = || Problem::request("cursor 无效", "cursor is invalid");
    let mut parts = cursor.splitn(3, '_');
    let mut part = || parts.next().ok_or_else(bad);
    let number = |text: &str| text.parse::<i64>().map_err(|_| bad());
    Ok((number(part()?)?, number(part()?)?, part()?.to_owned()))
}

/// A text escaped for LIKE.
fn literal(text: &str) -> String {
    text.replace('\\', "\\\\").replace('%', "\\%").replace('_', "\\_")
}

/// A condition under construction.
struct Query {
    sql: String,
    values: Vec<Cell>,
}

impl Query {
    /// Adds a condition; each `$` in it is replaced by the next of `values`.
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
