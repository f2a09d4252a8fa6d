//! The rule-language expressions of a labeling file with their places, so that whyroad-mining can check each one at its
//! position. Nothing is interpreted here.

use whyroad_model::yaml::{Node, Value};

/// An `expr` as written.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    /// The leaf whose block it is in; `None` in the block of the L2 or L1.
    pub leaf: Option<String>,
    /// The scalar.
    pub node: Node,
}

/// All expressions of the `labeling` blocks of a file, in file order.
pub(crate) fn expressions(root: &Node) -> Vec<Written> {
    let mut out = Vec::new();
    if let Some(labeling) = child(root, "labeling") {
        collect(labeling, None, &mut out);
    }
    if let Some(Value::Map(leaves)) = child(root, "leaves").map(|n| &n.value) {
        for leaf in leaves {
            if let Some(labeling) = child(&leaf.node, "labeling") {
                collect(labeling, Some(&leaf.key), &mut out);
            }
        }
    }
    out
}

fn child<'n>(node: &'n Node, key: &str) -> Option<&'n Node> {
    let Value::Map(entries) = &node.value else { return None };
    entries.iter().find(|e| e.key == key).map(|e| &e.node)
}

fn collect(node: &Node, leaf: Option<&String>, out: &mut Vec<Written>) {
    let Value::Map(entries) = &node.value else { return };
    for e in entries {
        match &e.node.value {
            Value::Scalar(_) if e.key == "expr" => {
                out.push(Written { leaf: leaf.cloned(), node: e.node.clone() })
            }
            _ => collect(&e.node, leaf, out),
        }
    }
}
