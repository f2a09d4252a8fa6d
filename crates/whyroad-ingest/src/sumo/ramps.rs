//! Which lanes of a network are ramps. OpenStreetMap's word for them is an edge type that ends in `_link`; a network that was drawn
//! has none, but marks the lanes on which traffic from a ramp gains speed (`acceleration="1"`).

use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::road_map::Lane;

/// True for the type of a ramp's edge: `highway.motorway_link`.
pub(super) fn is_link_type(edge_type: &str) -> bool {
    edge_type.split('|').any(|t| t.ends_with("_link"))
}

/// Tags the lanes of edges that lead into nothing but acceleration lanes, and the junction lanes on the way, as ramps.
/// `edges` are the lanes of each edge that is not inside a junction.
pub(super) fn tag_feeders(edges: &[&Vec<String>], lanes: &mut BTreeMap<String, Lane>) {
    let fast = |id: &String| lanes.get(id).is_some_and(|l| l.is_tagged("acceleration"));
    let mut ramps: BTreeSet<String> = BTreeSet::new();
    for edge in edges {
        let mut inside: Vec<String> = Vec::new();
        let mut ends: Vec<String> = Vec::new();
        for next in edge.iter().filter_map(|id| lanes.get(id)).flat_map(|l| &l.successors) {
            // A junction's lane leads on; its end is what counts.
            match lanes.get(next) {
                Some(l) if next.starts_with(':') => {
                    inside.push(next.clone());
                    ends.extend(l.successors.iter().cloned());
                }
                _ => ends.push(next.clone()),
            }
        }
        let own_is_fast = edge.iter().any(&fast);
        if !own_is_fast && !ends.is_empty() && ends.iter().all(&fast) {
            ramps.extend(edge.iter().cloned());
            ramps.extend(inside);
        }
    }
    for id in ramps {
        if let Some(l) = lanes.get_mut(&id)
            && !l.is_tagged("ramp")
        {
            l.tags.push("ramp".to_owned());
        }
    }
}
