//! The generated pages: links that resolve, every rule between classes once, and hand-written text left alone.

use std::collections::BTreeSet;
use std::path::Path;
use whyroad_framework::Framework;
use whyroad_framework::docs::{fill_spec_page, taxonomy_page};
use whyroad_model::ScenarioId;

fn spec_page() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/SPEC.md");
    std::fs::read_to_string(path).unwrap().replace("\r\n", "\n")
}

#[test]
fn the_committed_spec_page_is_up_to_date() {
    let page = spec_page();
    let filled = fill_spec_page(Framework::bundled(), &page).unwrap();
    assert!(filled == page, "docs/reference/SPEC.md is stale: run `whyroad taxonomy docs`");
}

#[test]
fn every_reference_to_a_labelling_section_resolves() {
    let page = spec_page();
    let headings: BTreeSet<&str> = page.lines().filter_map(|l| l.strip_prefix("### ")).collect();
    let mut seen = 0;
    for (_, l2, l3) in Framework::bundled().taxonomy.leaves() {
        for reference in [&l2.labeling_spec_ref, &l3.labeling_spec_ref].into_iter().flatten() {
            let anchor = reference.strip_prefix("SPEC.md#").unwrap();
            assert!(headings.contains(anchor), "{reference}");
            seen += 1;
        }
    }
    assert!(seen >= 122, "{seen}");
}

#[test]
fn only_what_is_between_the_markers_is_written() {
    let page = "# Mine\n\nkept\n\n<!-- generated: longitudinal decisions -->\nold\n<!-- end generated -->\n\n\
        also kept\n\n<!-- generated: lateral decisions -->\n<!-- end generated -->\n\
        <!-- generated: no decision -->\n<!-- end generated -->\n\
        <!-- generated: labelling -->\n<!-- end generated -->\nend\n";
    let filled = fill_spec_page(Framework::bundled(), page).unwrap();
    assert!(filled.starts_with("# Mine\n\nkept\n\n<!-- generated: longitudinal decisions -->\n\n| id |"));
    assert!(
        filled.contains("\n\nalso kept\n\n") && filled.ends_with("\nend\n") && !filled.contains("\nold\n")
    );
    assert_eq!(fill_spec_page(Framework::bundled(), &filled).unwrap(), filled);
    let without = page.replacen("<!-- generated: labelling -->", "", 1);
    assert_eq!(
        fill_spec_page(Framework::bundled(), &without),
        Err("<!-- generated: labelling -->".to_owned())
    );
}

#[test]
fn the_spec_page_says_what_the_specs_say() {
    let page = spec_page().replace("\n  ", " ");
    // From scenarios/: a fallback of its own, inherited records none, a pack that may end sooner, two keyframes.
    for text in [
        "Keyframe: `reactive`, any wheel of the other vehicle crosses the lane line (fallback: first moment with TTC < 5 s)",
        "3 s before, 3 s after (or the ego is down to 5 km/h, if that is sooner than 3 s)",
        "Second keyframe: `reactive`, the obstacle is first visible",
        "横向决策：必须为 `in_lane_nudge`",
        "`oncoming_gap` (s)",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // An inherited fallback that repeats the rule is not printed.
    assert!(!page.contains("the moment of least TTC (fallback: the moment of least TTC)"));
}

/// Pairs that the page prints, each as the two full ids in order.
fn printed_pairs(page: &str) -> Vec<(String, String)> {
    let mut l1 = String::new();
    let mut l2 = String::new();
    let mut out = Vec::new();
    // Items may go on in lines that are indented.
    for line in page.replace("\n  ", " ").lines() {
        if let Some(head) = line.strip_prefix("## L1: ") {
            l1 = head.rsplit_once('(').unwrap().1.trim_end_matches(')').to_owned();
        } else if let Some(head) = line.strip_prefix("### L2: ") {
            l2 = head.split(" - ").next().unwrap().to_owned();
        } else if let Some((pairs, _)) = line.strip_prefix("- ").and_then(|l| l.split_once("`: "))
            && pairs.contains("` / `")
        {
            let full = |id: &str| match id {
                id if id.contains('.') => id.to_owned(),
                id if id == l2 => format!("{l1}.{l2}"),
                id => format!("{l1}.{l2}.{id}"),
            };
            for pair in pairs.trim_start_matches('`').split("`, `") {
                let (a, b) = pair.split_once("` / `").unwrap();
                let (a, b) = (full(a), full(b));
                out.push(if a < b { (a, b) } else { (b, a) });
            }
        }
    }
    out
}

#[test]
fn the_taxonomy_page_decides_each_pair_once() {
    let t = &Framework::bundled().taxonomy;
    let mut wanted = BTreeSet::new();
    for a in &t.l1 {
        for b in &a.l2 {
            let l2 = ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None };
            let leaves = b.l3.iter().map(|c| (ScenarioId::leaf(&a.id, &b.id, &c.id), &c.decides));
            for (id, decides) in std::iter::once((l2, &b.decides)).chain(leaves) {
                for d in decides {
                    let (x, y) = (id.to_string(), d.against.to_string());
                    wanted.insert(if x < y { (x, y) } else { (y, x) });
                }
            }
        }
    }
    let page = taxonomy_page(Framework::bundled());
    let printed = printed_pairs(&page);
    assert_eq!(printed.iter().cloned().collect::<BTreeSet<_>>(), wanted);
    assert_eq!(printed.len(), wanted.len(), "a pair is printed twice");
    // Links to the other sections resolve.
    let anchors: BTreeSet<&str> =
        page.split("<a id=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    let links: BTreeSet<&str> = page.split("](#").skip(1).filter_map(|s| s.split(')').next()).collect();
    assert!(!links.is_empty() && links.is_subset(&anchors), "{:?}", links.difference(&anchors));
}
