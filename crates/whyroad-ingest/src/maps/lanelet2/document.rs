//! An OSM file as Lanelet2 uses it: nodes, ways and relations with tags, before anything is placed.

use crate::encodings::input::Input;
use crate::encodings::xml::{Element, Tag, for_each_tag};
use std::collections::{BTreeMap, HashMap};

/// Tags of an element.
pub(super) type Tags = BTreeMap<String, String>;

#[derive(Clone, Debug, Default)]
pub(super) struct Node {
    pub lat: Option<f64>,
    pub lon: Option<f64>,
    pub local: (Option<f64>, Option<f64>),
    pub height: Option<f64>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Way {
    pub nodes: Vec<i64>,
    pub tags: Tags,
}

/// What a member of a relation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MemberKind {
    Way,
    Relation,
    Node,
}

#[derive(Clone, Debug)]
pub(super) struct Member {
    pub kind: MemberKind,
    pub id: i64,
    pub role: String,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Relation {
    pub members: Vec<Member>,
    pub tags: Tags,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Document {
    pub nodes: HashMap<i64, Node>,
    pub ways: BTreeMap<i64, Way>,
    pub relations: BTreeMap<i64, Relation>,
    pub broken: Option<String>,
}

impl Relation {
    /// Ids of the members of a kind with a role, in order.
    pub fn members<'r>(&'r self, kind: MemberKind, role: &'r str) -> impl Iterator<Item = i64> + 'r {
        self.members.iter().filter(move |m| m.kind == kind && m.role == role).map(|m| m.id)
    }

    /// A tag, empty where it is absent.
    pub fn tag(&self, name: &str) -> &str {
        self.tags.get(name).map_or("", String::as_str)
    }
}

impl Way {
    /// A tag, empty where it is absent.
    pub fn tag(&self, name: &str) -> &str {
        self.tags.get(name).map_or("", String::as_str)
    }
}

/// Adds the nodes of a way that begins or ends where `nodes` end, and returns whether it was turned round for it.
/// `None` where it does neither; then nothing is added.
pub(super) fn append(nodes: &mut Vec<i64>, way: &[i64]) -> Option<bool> {
    let end = nodes.last()?;
    if way.first() == Some(end) {
        nodes.extend(&way[1..]);
        Some(false)
    } else if way.last() == Some(end) {
        nodes.extend(way.iter().rev().skip(1));
        Some(true)
    } else {
        None
    }
}

/// The element that tags belong to.
enum Open {
    Nothing,
    Node(i64, Node),
    Way(i64, Way),
    Relation(i64, Relation),
}

/// Reads the file as far as it can be read. `Err` when it is not OSM XML.
pub(super) fn read(input: Input<'_>) -> Result<Document, String> {
    let mut out = Document::default();
    let (mut is_osm, mut open) = (false, Open::Nothing);
    let end = for_each_tag(input, |tag| match tag {
        Tag::Open(e) if e.name() == "osm" => is_osm = true,
        Tag::Open(e) => begin(&e, &mut open),
        Tag::Close("node" | "way" | "relation") => match std::mem::replace(&mut open, Open::Nothing) {
            Open::Nothing => {}
            Open::Node(id, node) => drop(out.nodes.insert(id, node)),
            Open::Way(id, way) => drop(out.ways.insert(id, way)),
            Open::Relation(id, relation) => drop(out.relations.insert(id, relation)),
        },
        Tag::Close(_) => {}
    });
    if !is_osm {
        return Err(end.err().unwrap_or_else(|| "it has no <osm>".to_owned()));
    }
    out.broken = end.err();
    Ok(out)
}

fn begin(e: &Element<'_>, open: &mut Open) {
    let id = |name: &str| e.get(name).and_then(|v| v.trim().parse::<i64>().ok());
    match (e.name(), &mut *open) {
        ("node", _) => {
            let node = Node { lat: e.number("lat"), lon: e.number("lon"), ..Node::default() };
            *open = id("id").filter(|_| is_kept(e)).map_or(Open::Nothing, |id| Open::Node(id, node));
        }
        ("way", _) => {
            *open = id("id").filter(|_| is_kept(e)).map_or(Open::Nothing, |id| Open::Way(id, Way::default()));
        }
        ("relation", _) => {
            let relation = id("id").filter(|_| is_kept(e));
            *open = relation.map_or(Open::Nothing, |id| Open::Relation(id, Relation::default()));
        }
        ("nd", Open::Way(_, way)) => way.nodes.extend(id("ref")),
        ("member", Open::Relation(_, relation)) => {
            let kind = match e.get("type").as_deref() {
                Some("way") => MemberKind::Way,
                Some("relation") => MemberKind::Relation,
                _ => MemberKind::Node,
            };
            if let Some(id) = id("ref") {
                relation.members.push(Member { kind, id, role: e.text("role").unwrap_or_default() });
            }
        }
        ("tag", open) => {
            let (Some(key), Some(value)) = (e.text("k"), e.text("v")) else { return };
            match open {
                Open::Nothing => {}
                Open::Node(_, node) => {
                    let number = value.trim().parse().ok().filter(|v: &f64| v.is_finite());
                    match key.as_str() {
                        "local_x" => node.local.0 = number,
                        "local_y" => node.local.1 = number,
                        "ele" => node.height = number,
                        _ => {}
                    }
                }
                Open::Way(_, way) => drop(way.tags.insert(key, value)),
                Open::Relation(_, relation) => drop(relation.tags.insert(key, value)),
            }
        }
        _ => {}
    }
}

/// False for what an editor marked as deleted.
fn is_kept(e: &Element<'_>) -> bool {
    e.get("action").as_deref() != Some("delete") && e.get("visible").as_deref() != Some("false")
}
