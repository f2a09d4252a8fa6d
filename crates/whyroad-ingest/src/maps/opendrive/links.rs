//! Which lanes lead into which, from the links of lanes, roads and junctions.
//!
//! A link says that an end of one lane touches an end of another; which of the two is the successor follows from the
//! directions in which they are driven.

use super::document::{Document, End, Road, RoadLink};
use super::lanes::{LaneKey, goes_forward};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use whyroad_model::road_map::Lane;

/// An end of a lane.
type LaneEnd = (LaneKey, End);

/// Roads by id, lanes by key.
pub(super) struct Index<'d> {
    pub roads: HashMap<&'d str, usize>,
    /// Whether each lane of the file is driven forward.
    forward: BTreeMap<LaneKey, bool>,
}

impl<'d> Index<'d> {
    pub fn of(document: &'d Document) -> Self {
        let mut out = Self { roads: HashMap::new(), forward: BTreeMap::new() };
        for (road, doc) in document.roads.iter().enumerate() {
            out.roads.entry(&doc.id).or_insert(road);
            for (section, lanes) in doc.sections.iter().enumerate() {
                for lane in lanes.lanes.iter().filter(|l| l.id != 0) {
                    out.forward.insert(LaneKey { road, section, lane: lane.id }, goes_forward(doc, lane));
                }
            }
        }
        out
    }
}

/// Joins the lanes; returns links that name elements missing from the file.
pub(super) fn join(
    document: &Document,
    index: &Index<'_>,
    lanes: &mut BTreeMap<LaneKey, Lane>,
) -> Vec<String> {
    let mut joints: BTreeSet<(LaneEnd, LaneEnd)> = BTreeSet::new();
    let mut dangling = Vec::new();
    for (number, road) in document.roads.iter().enumerate() {
        along(number, road, &mut joints);
        across(number, road, document, index, &mut joints, &mut dangling);
    }
    for junction in &document.junctions {
        for c in &junction.connections {
            let (from, to) = (index.roads.get(c.incoming.as_str()), index.roads.get(c.connecting.as_str()));
            let (Some(&from), Some(&to), Some(contact)) = (from, to, c.contact) else {
                dangling
                    .push(format!("junction {}: road {} -> road {}", junction.id, c.incoming, c.connecting));
                continue;
            };
            let Some(end) = end_at(from, &junction.id, (to, contact), document, lanes) else { continue };
            for &(a, b) in &c.lanes {
                joints.insert((
                    (at_end(document, from, end, a), end),
                    (at_end(document, to, contact, b), contact),
                ));
            }
        }
    }
    for (a, b) in joints {
        let leaves = |(key, end): LaneEnd| Some(*index.forward.get(&key)? == (end == End::End));
        let (before, after) = match (leaves(a), leaves(b)) {
            (Some(true), Some(false)) => (a.0, b.0),
            (Some(false), Some(true)) => (b.0, a.0),
            // Two lanes that come together head on: one of them is driven the other way than its side says.
            (Some(_), Some(_)) => continue,
            (known, _) => {
                let missing = if known.is_none() { a.0 } else { b.0 };
                let id = &document.roads[missing.road].id;
                dangling.push(format!("road {id}, section {}, lane {}", missing.section, missing.lane));
                continue;
            }
        };
        let id = |key| lanes.get(key).map(|l| l.id.clone());
        let (Some(first), Some(second)) = (id(&before), id(&after)) else { continue };
        lanes.entry(before).and_modify(|l| push_new(&mut l.successors, second));
        lanes.entry(after).and_modify(|l| push_new(&mut l.predecessors, first));
    }
    dangling
}

fn push_new(list: &mut Vec<String>, id: String) {
    if !list.contains(&id) {
        list.push(id);
    }
}

/// From section to section of one road.
fn along(road: usize, doc: &Road, joints: &mut BTreeSet<(LaneEnd, LaneEnd)>) {
    for (section, lanes) in doc.sections.iter().enumerate() {
        for lane in lanes.lanes.iter().filter(|l| l.id != 0) {
            let key = |section, lane| LaneKey { road, section, lane };
            if section + 1 < doc.sections.len() {
                joints.extend(
                    lane.successors.iter().map(|&next| {
                        ((key(section, lane.id), End::End), (key(section + 1, next), End::Start))
                    }),
                );
            }
            if section > 0 {
                joints.extend(lane.predecessors.iter().map(|&before| {
                    ((key(section - 1, before), End::End), (key(section, lane.id), End::Start))
                }));
            }
        }
    }
}

/// From a road to the one at its start or end.
fn across(
    road: usize,
    doc: &Road,
    document: &Document,
    index: &Index<'_>,
    joints: &mut BTreeSet<(LaneEnd, LaneEnd)>,
    dangling: &mut Vec<String>,
) {
    for (own, link) in [(End::Start, &doc.predecessor), (End::End, &doc.successor)] {
        let Some(RoadLink::Road(id, contact)) = link else { continue };
        let Some(&other) = index.roads.get(id.as_str()) else {
            dangling.push(format!("road {} -> road {id}", doc.id));
            continue;
        };
        let section = section_at(document, road, own);
        let Some(lanes) = doc.sections.get(section) else { continue };
        for lane in lanes.lanes.iter().filter(|l| l.id != 0) {
            let ids = if own == End::Start { &lane.predecessors } else { &lane.successors };
            let key = LaneKey { road, section, lane: lane.id };
            joints.extend(
                ids.iter().map(|&to| ((key, own), (at_end(document, other, *contact, to), *contact))),
            );
        }
    }
}

fn section_at(document: &Document, road: usize, end: End) -> usize {
    match end {
        End::Start => 0,
        End::End => document.roads[road].sections.len().saturating_sub(1),
    }
}

fn at_end(document: &Document, road: usize, end: End, lane: i32) -> LaneKey {
    LaneKey { road, section: section_at(document, road, end), lane }
}

/// The end of a road that lies at a junction; the one nearer to the connecting road when both do.
fn end_at(
    road: usize,
    junction: &str,
    (to, contact): (usize, End),
    document: &Document,
    lanes: &BTreeMap<LaneKey, Lane>,
) -> Option<End> {
    let doc = &document.roads[road];
    let is = |link: &Option<RoadLink>| *link == Some(RoadLink::Junction(junction.to_owned()));
    match (is(&doc.predecessor), is(&doc.successor)) {
        (true, false) => Some(End::Start),
        (false, true) => Some(End::End),
        (false, false) => None,
        (true, true) => {
            let point = |road: usize, end: End| {
                let section = section_at(document, road, end);
                let from = LaneKey { road, section, lane: i32::MIN };
                let (key, lane) = lanes.range(from..=LaneKey { lane: i32::MAX, ..from }).next()?;
                let doc_lane =
                    document.roads[road].sections[section].lanes.iter().find(|l| l.id == key.lane)?;
                let last = goes_forward(&document.roads[road], doc_lane) == (end == End::End);
                if last { lane.center.last() } else { lane.center.first() }.copied()
            };
            let there = point(to, contact)?;
            let reach = |end| point(road, end).map(|p| crate::assemble::geometry::distance(p, there));
            let (start, end) = (reach(End::Start)?, reach(End::End)?);
            Some(if start < end { End::Start } else { End::End })
        }
    }
}
