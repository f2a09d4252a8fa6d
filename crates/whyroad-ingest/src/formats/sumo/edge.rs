//! An edge of a network: lanes side by side between two nodes.

#[derive(Default)]
pub(super) struct Edge {
    pub from: String,
    pub to: String,
    pub function: String,
    /// `highway.motorway_link`; empty where the network does not state it.
    pub kind: String,
    /// Ids of its lanes, from the right.
    pub lanes: Vec<String>,
}
