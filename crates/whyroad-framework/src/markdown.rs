//! A TAXONOMY.md as data: what its tables list, what its tree lists, and the numbers it states, each with its position.
//! `lint` compares them; nothing is judged here.

mod lint;

use crate::docs::wrap::join;
pub use lint::lint_markdown;

use crate::taxonomy::{L1, L2, L3, Taxonomy};
use whyroad_model::{Bilingual, Location};

/// All information about classes in a TAXONOMY.md.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkdownTaxonomy {
    /// From `> 版本: 2.0.0`.
    pub version: Option<Item>,
    /// The L1 sections with their L2 sections and L3 tables.
    pub listed: Vec<Class>,
    /// The lines of the tree.
    pub tree: Vec<Class>,
    /// Every stated number of classes.
    pub stated: Vec<Stated>,
}

/// A piece of text and its position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Item {
    /// The text.
    pub text: String,
    /// Its place; no file.
    pub place: Location,
}

/// A class with the classes below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Class {
    /// Id.
    pub id: Item,
    /// Chinese name; empty where none is written (the L2 of a tree).
    pub name: String,
    /// Chinese condition of an L3; its definition for an L1 or L2, where one is written.
    pub meaning: String,
    /// Classes below.
    pub children: Vec<Class>,
}

/// A number that the text states.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// Of what.
    pub subject: Subject,
    /// Level that is counted: 1, 2 or 3.
    pub level: u8,
    /// The number.
    pub number: usize,
    /// Its place; no file.
    pub place: Location,
    /// Which part of the text.
    pub part: Part,
}

/// Scope of a stated number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Everything.
    Whole,
    /// Below one L1.
    L1(String),
    /// Below one L2, by L1 and L2.
    L2(String, String),
}

/// Part of a TAXONOMY.md that states numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The line `> 总计: ...` at the top.
    Header,
    /// The table `分类统计`.
    Statistics,
    /// The tree.
    Tree,
}

/// Reads a TAXONOMY.md. Lines of unknown form are skipped.
pub fn read_markdown(text: &str) -> MarkdownTaxonomy {
    let mut out = MarkdownTaxonomy::default();
    let mut fenced = Fence::Outside;
    let mut columns: Vec<String> = Vec::new();
    let mut defining = false;
    for (i, raw) in text.lines().enumerate() {
        let line = Line { text: raw, number: i + 1 };
        if raw.trim_start().starts_with("```") {
            fenced = if fenced == Fence::Outside { Fence::Inside } else { Fence::Outside };
            continue;
        }
        if fenced == Fence::Inside {
            tree_line(&line, &mut out);
            continue;
        }
        if !raw.trim_start().starts_with('|') {
            columns.clear();
        }
        if let Some(rest) = raw.strip_prefix("## L1:") {
            heading_l1(&line, rest, &mut out);
        } else if let Some(rest) = raw.strip_prefix("### L2:") {
            heading_l2(&line, rest, &mut out);
        } else if let Some(rest) = raw.strip_prefix('>') {
            let text = rest.trim();
            if defining && !text.is_empty() && !text.starts_with("**") {
                // The definition continues.
                if let Some(meaning) = meaning(&mut out) {
                    join(meaning, text);
                }
            } else {
                defining = text.starts_with("**定义**");
                quote(&line, rest, &mut out);
            }
        } else if raw.trim_start().starts_with('|') {
            let cells = cells(&line);
            if columns.is_empty() {
                columns = cells.iter().map(|c| c.text.clone()).collect();
            } else {
                row(&columns, &cells, &mut out);
            }
        }
    }
    out
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fence {
    Outside,
    Inside,
}

struct Line<'t> {
    text: &'t str,
    number: usize,
}

impl Line<'_> {
    /// The place of `part`, a slice of this line's text starting at byte `at`.
    fn place(&self, at: usize, part: &str) -> Location {
        Location {
            line: Some(self.number),
            column: Some(self.text[..at].chars().count() + 1),
            snippet: Some(self.text.to_owned()),
            span: part.chars().count(),
            ..Location::default()
        }
    }

    fn item(&self, at: usize, part: &str) -> Item {
        let trimmed = part.trim_start();
        let at = at + part.len() - trimmed.len();
        let trimmed = trimmed.trim_end();
        Item { text: trimmed.to_owned(), place: self.place(at, trimmed) }
    }

    /// Numbers that stand directly before `label` in this line: `30个L2`, `30 L2`.
    fn count_before(&self, label: &str) -> Option<(usize, Location)> {
        let end = self.text.find(label)?;
        let before = self.text[..end].trim_end().trim_end_matches('个').trim_end();
        let digits_start = before
            .rfind(|c: char| !c.is_ascii_digit())
            .map_or(0, |i| i + before[i..].chars().next().map_or(1, char::len_utf8));
        let digits = &before[digits_start..];
        Some((digits.parse().ok()?, self.place(digits_start, digits)))
    }
}

/// `## L1: 交互响应 (reactive_agent)`
fn heading_l1(line: &Line, rest: &str, out: &mut MarkdownTaxonomy) {
    let (Some(open), Some(close)) = (rest.rfind('('), rest.rfind(')')) else { return };
    if close < open {
        return;
    }
    let base = line.text.len() - rest.len();
    out.listed.push(Class {
        id: line.item(base + open + 1, &rest[open + 1..close]),
        name: rest[..open].trim().to_owned(),
        ..Class::default()
    });
}

/// `### L2: cutin - Cutin响应`
fn heading_l2(line: &Line, rest: &str, out: &mut MarkdownTaxonomy) {
    let (id, name) = rest.split_once(" - ").unwrap_or((rest, ""));
    let base = line.text.len() - rest.len();
    let class = Class { id: line.item(base, id), name: name.trim().to_owned(), ..Class::default() };
    if let Some(l1) = out.listed.last_mut() {
        l1.children.push(class);
    }
}

/// The definition of the class that is being read: under an L1's heading the L1's; after an L2's heading, the L2's.
fn meaning(out: &mut MarkdownTaxonomy) -> Option<&mut String> {
    let l1 = out.listed.last_mut()?;
    Some(match l1.children.last_mut() {
        Some(l2) => &mut l2.meaning,
        None => &mut l1.meaning,
    })
}

/// `> 版本: 2.0.0`, `> 总计: 5个L1 | 30个L2 | 95个L3`, `> **定义**: ...`
fn quote(line: &Line, rest: &str, out: &mut MarkdownTaxonomy) {
    let base = line.text.len() - rest.len();
    let Some((key, value)) = rest.split_once([':', '：']) else { return };
    let key = key.trim().trim_matches('*');
    let value_at = base + rest.len() - value.len();
    match key {
        "版本" | "Version" => out.version = out.version.take().or(Some(line.item(value_at, value))),
        "总计" | "Total" => totals(line, Part::Header, out),
        "定义" => {
            if let Some(meaning) = meaning(out) {
                *meaning = value.trim().to_owned();
            }
        }
        _ => {}
    }
}

fn totals(line: &Line, part: Part, out: &mut MarkdownTaxonomy) {
    for (level, label) in [(1, "L1"), (2, "L2"), (3, "L3")] {
        if let Some((number, place)) = line.count_before(label) {
            out.stated.push(Stated { subject: Subject::Whole, level, number, place, part });
        }
    }
}

/// The cells of a table row, marks of emphasis and code removed.
fn cells(line: &Line) -> Vec<Item> {
    let mut out = Vec::new();
    let mut at = line.text.find('|').map_or(0, |i| i + 1);
    while let Some(len) = line.text[at..].find('|') {
        let raw = &line.text[at..at + len];
        let bare = raw.trim_matches([' ', '*', '`']);
        let offset = raw.find(bare).unwrap_or(0);
        out.push(line.item(at + offset, bare));
        at += len + 1;
    }
    out
}

/// A body row of a table: of the statistics, or of an L2's variants.
fn row(columns: &[String], cells: &[Item], out: &mut MarkdownTaxonomy) {
    let column =
        |names: &[&str]| columns.iter().position(|c| names.contains(&c.as_str())).and_then(|i| cells.get(i));
    if let (Some(l1), Some(l2), Some(l3)) =
        (column(&["L1"]), column(&["L2数量", "L2"]), column(&["L3数量", "L3"]))
    {
        let subject = match l1.text.as_str() {
            "总计" | "Total" => Subject::Whole,
            id => Subject::L1(id.to_owned()),
        };
        for (level, cell) in [(2, l2), (3, l3)] {
            if let Ok(number) = cell.text.parse() {
                let place = cell.place.clone();
                out.stated.push(Stated {
                    subject: subject.clone(),
                    level,
                    number,
                    place,
                    part: Part::Statistics,
                });
            }
        }
        return;
    }
    let Some(id) = column(&["L3 ID"]).filter(|c| !c.text.is_empty() && !c.text.starts_with('-')) else {
        return;
    };
    let text = |names: &[&str]| column(names).map(|c| c.text.clone()).unwrap_or_default();
    let class =
        Class { id: id.clone(), name: text(&["名称"]), meaning: text(&["条件"]), children: Vec::new() };
    if let Some(l2) = out.listed.last_mut().and_then(|l1| l1.children.last_mut()) {
        l2.children.push(class);
    }
}

/// A line of the tree: its head with totals, an L1 with two counts, or an L2 with one count and its variants.
fn tree_line(line: &Line, out: &mut MarkdownTaxonomy) {
    let body = line.text.trim_start_matches(['│', '├', '└', '─', ' ']);
    let at = line.text.len() - body.len();
    if at == 0 && body.contains(" L1") && body.contains(" L2") {
        totals(line, Part::Tree, out);
        return;
    }
    if at == 0 {
        return;
    }
    let (Some(open), Some(close)) = (body.find('['), body.find(']')) else { return };
    if close < open {
        return;
    }
    let (label, inside, after) = (&body[..open], &body[open + 1..close], &body[close + 1..]);
    if let Some((id, name)) = label.split_once('(') {
        let class = Class {
            id: line.item(at, id),
            name: name.trim().trim_end_matches(')').to_owned(),
            ..Class::default()
        };
        for (level, mark) in [(2, " L2"), (3, " L3")] {
            if let Some((number, place)) = line.count_before(mark) {
                let subject = Subject::L1(class.id.text.clone());
                out.stated.push(Stated { subject, level, number, place, part: Part::Tree });
            }
        }
        out.tree.push(class);
        return;
    }
    let Some(l1) = out.tree.last_mut() else { return };
    let mut class = Class { id: line.item(at, label), ..Class::default() };
    if let Ok(number) = inside.trim().parse() {
        let subject = Subject::L2(l1.id.text.clone(), class.id.text.clone());
        let place = line.place(at + open + 1, inside);
        out.stated.push(Stated { subject, level: 3, number, place, part: Part::Tree });
    }
    let variants = after.trim_start_matches([':', '：']);
    let mut from = at + body.len() - variants.len();
    for id in variants.split(',') {
        let item = line.item(from, id);
        from += id.len() + 1;
        if !item.text.is_empty() {
            class.children.push(Class { id: item, ..Class::default() });
        }
    }
    l1.children.push(class);
}

impl MarkdownTaxonomy {
    /// The listed classes as a taxonomy, for comparison. Fields that a TAXONOMY.md does not have (English, definitions
    /// of L3, decisions) are empty.
    pub fn to_taxonomy(&self) -> Taxonomy {
        let zh = |text: &str| Bilingual::new(text, "");
        let l3 = |c: &Class| L3 {
            id: c.id.text.clone(),
            name: zh(&c.name),
            condition: zh(&c.meaning),
            ..L3::default()
        };
        let l2 = |c: &Class| L2 {
            id: c.id.text.clone(),
            name: zh(&c.name),
            definition: zh(&c.meaning),
            l3: c.children.iter().map(l3).collect(),
            ..L2::default()
        };
        let l1 = |c: &Class| L1 {
            id: c.id.text.clone(),
            name: zh(&c.name),
            definition: zh(&c.meaning),
            l2: c.children.iter().map(l2).collect(),
        };
        Taxonomy {
            version: self.version.as_ref().map(|v| v.text.clone()).unwrap_or_default(),
            description: Bilingual::default(),
            l1: self.listed.iter().map(l1).collect(),
        }
    }
}
