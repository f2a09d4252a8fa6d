//! The page of a drive made by hand.

use super::*;
use crate::fixture::{coverage, drive, episode, signals};
use whyroad_framework::Taxonomy;
use whyroad_model::Bilingual;
use whyroad_model::messages::DriveGap;

pub(crate) fn taxonomy() -> Taxonomy {
    let text = include_str!("../../../../schema/scenario_taxonomy.yaml");
    whyroad_framework::taxonomy::read_taxonomy("scenario_taxonomy.yaml", text).0.unwrap()
}

pub(crate) fn infos() -> BTreeMap<String, SignalInfo> {
    let info = |unit: &str, zh: &str, en: &str| SignalInfo {
        title: Bilingual::new(zh, en),
        unit: whyroad_model::units::Unit::parse(unit),
        meaning: Bilingual::new(zh, en),
        scale: 1.0,
        ..SignalInfo::default()
    };
    [
        ("ego.speed".to_owned(), info("m/s", "自车对地速度", "speed over ground")),
        ("target.ttc".to_owned(), info("s", "碰撞时间", "time to collision along the path")),
        ("light.state".to_owned(), info("", "信号灯状态", "state of the light")),
    ]
    .into()
}

fn page(name: &str, max_cards: usize) -> String {
    let (coverage, infos) = (coverage(), infos());
    let drive = drive(name);
    let context = ReportContext {
        framework: Framework::bundled(),
        coverage: &coverage,
        signals: &infos,
        lang: Lang::En,
    };
    let mut report = ReportBuilder::new(context);
    let chosen = CardChoice::new(max_cards).choose(vec![episode(&drive)]);
    report.add(DrivePart::new(&context, &drive, drive.tracks.len() + 1, &signals(&drive), &chosen));
    report.finish()
}

#[test]
fn all_leaves_are_in_the_map_and_in_the_table() {
    let page = page("d", 10);
    let taxonomy = taxonomy();
    assert!(taxonomy.leaves().count() > 100);
    for (l1, l2, l3) in taxonomy.leaves() {
        let id = format!("{}.{}.{}", l1.id, l2.id, l3.id);
        assert_eq!(page.matches(&format!("data-leaf=\"{id}\" data-state=")).count(), 1, "{id} in the map");
        assert_eq!(page.matches(&format!("<tr id=\"leaf-{id}\"")).count(), 1, "{id} in the table");
    }
}

/// The drive's log has one track more than there are objects.
#[test]
fn tracks_of_the_log_and_joined_objects_are_both_counted() {
    let page = page("d", 10);
    let objects = drive("d").tracks.len();
    let cells = format!("<td class=\"n\">{}</td><td class=\"n\">{objects}</td>", objects + 1);
    assert!(page.contains(&cells), "{cells}");
    assert!(page.contains("joined; rules are evaluated on these"));
}

#[test]
fn the_four_states_have_their_own_fill_and_mark() {
    let page = page("d", 10);
    let others = taxonomy().leaves().count() - 3;
    for (state, cells) in [("found", 1), ("not_found", 1), ("not_observable", 1), ("no_rule", others)] {
        let count = page.matches(&format!("\" data-state=\"{state}\"><title>")).count();
        assert_eq!(count, cells, "{state}");
        assert!(page.contains(&format!(".st-{state} {{ fill: ")), "{state} has a fill");
    }
    let named = "<span title=\"light.state\"><span lang=\"zh\">信号灯状态</span>";
    assert!(page.contains(named), "what is missing is named");
}

#[test]
fn a_leaf_that_some_drives_cannot_show_says_how_many_can() {
    let mut found_by_mining = coverage();
    let found = found_by_mining.leaves.iter_mut().find(|l| l.drives_searched > 0).unwrap();
    found.drives_searched = 3;
    let drives = vec![DriveId::from("a")].into();
    found.gaps = vec![DriveGap { drives, missing_signals: vec!["light.state".into()] }];
    let taxonomy = taxonomy();
    let rows = coverage::rows(&taxonomy, &found_by_mining);
    let part: Vec<_> = rows.iter().filter_map(coverage::LeafRow::searched_in_part).collect();
    // The one changed here, and one of the fixture's.
    assert_eq!(part, [(3, 4), (1, 2)]);
    let map = tree_map::render(&rows, &[]).into_string();
    assert_eq!(map.matches(">3/4</text>").count(), 1);
    assert!(summary::legend(&rows).into_string().contains("k/n <b>2</b>"));
}

#[test]
fn what_has_no_variant_is_shown_with_its_l2_and_counted_as_no_leaf() {
    let page = page("d", 10);
    assert!(page.contains("<tspan class=\"more\"> +2</tspan>"));
    assert_eq!(page.matches("<tr class=\"unresolved\">").count(), 1);
    let leaves = taxonomy().leaves().count();
    assert!(page.contains(&format!("<dd>1<small> / {leaves}</small></dd>")));
}

#[test]
fn the_page_fetches_nothing() {
    let page = page("d", 10);
    for what in [
        "http:",
        "https:",
        "src=",
        "@import",
        "url(\"",
        "url('",
        "//cdn",
        "<link",
        "<iframe",
        "fetch(",
        "XMLHttpRequest",
        "import(",
    ] {
        assert!(!page.contains(what), "{what}");
    }
    assert!(page.contains("default-src 'none'"));
    // The only references are to anchors in the page itself.
    for reference in page.split("href=\"").skip(1) {
        assert!(reference.starts_with('#'), "{}", &reference[..reference.len().min(40)]);
    }
}

#[test]
fn names_from_logs_cannot_become_markup() {
    let nasty = "<script>alert('x')</script>\"onload=\"y";
    let page = page(nasty, 10);
    assert!(!page.contains("<script>alert"));
    assert!(!page.contains("\"onload="));
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&quot;onload=&quot;y"));
}

#[test]
fn a_card_has_picture_conditions_and_a_plot_of_each_signal() {
    let page = page("d", 10);
    let card = page.split("<article").nth(1).unwrap().split("</article>").next().unwrap();
    assert_eq!(card.matches("<figure class=\"plot\">").count(), 5);
    assert!(card.contains("target.ttc &lt; 5 s</code></td><td>4.2</td>"));
    assert!(card.contains("他车车轮越过车道线") && card.contains("a wheel of the other vehicle crosses"));
    assert!(card.contains("class=\"vehicle target\""), "the target stands out");
    assert!(card.contains("way-ego before") && card.contains("way-ego after"));
    assert!(card.contains("class=\"zebra\"") && card.contains(">10 m</text>"));
    // light.state has no column: the page states what the log lacks instead of drawing a flat line.
    assert!(card.contains(
        "not observable, needs: </span><span lang=\"zh\">交通信号灯</span><span lang=\"en\">traffic lights"
    ));
    assert!(card.contains("Label draft (needs a person)"));
    // At the keyframe, 4 s in: ego at x = 40, the car at x = 58 and y = 1.2, so 18 m up and 1.2 m to the left.
    assert!(card.contains("<title>d · 轿车 / car · 7 m/s</title>"));
    // Its front right corner: (58 + 2.25 - 40, 1.2 - 0.9) is 20.25 m ahead, 0.3 m left: (-3, -203) in decimeters.
    assert!(card.contains("L-3 -203") || card.contains("L-3 -202"));
}

#[test]
fn unknown_is_a_gap_and_infinite_is_not_drawn_as_a_number() {
    let page = page("d", 10);
    let plot =
        page.split("<figcaption title=\"碰撞时间 / ").nth(1).unwrap().split("</figure>").next().unwrap();
    let line = plot.split("class=\"line\" d=\"").nth(1).unwrap().split('"').next().unwrap();
    // Frames 10 to 99 are shown (3 s around 20..70); 10 to 19 are unknown.
    assert_eq!(line.matches('M').count(), 1);
    assert_eq!(line.matches('L').count(), 99 - 20);
}

#[test]
fn episodes_that_the_page_cannot_hold_are_counted() {
    let page = page("d", 0);
    assert!(page.contains("left out: </span>1</p>"));
    assert!(!page.contains("<article"));
}
