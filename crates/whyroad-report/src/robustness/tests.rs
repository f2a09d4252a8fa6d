use super::*;
use whyroad_model::Lang;

/// An episode of a class with a target, from `start` to `end` s, keyframe at `start`.
fn episode(class: &str, target: &str, start: f64, end: f64) -> Occurrence {
    let at = |s: f64| Nanos((s * 1e9) as i64);
    Occurrence {
        scenario: class.parse().unwrap(),
        objects: vec![target.into()],
        start: at(start),
        keyframe: at(start),
        end: at(end),
    }
}

fn compared() -> Robustness {
    let name = |n: &str| (n.to_owned(), Bilingual::new("扰动", "a perturbation"));
    let mut of = Robustness::new(3, [name("noise"), name("drops")]);
    let steady = "driving_state.longitudinal.steady";
    let before = [episode(steady, "a", 10.0, 20.0), episode(steady, "b", 10.0, 20.0)];
    // Under noise: one half a second late, one of another target (not the same), one more.
    let noisy = vec![
        episode(steady, "a", 10.5, 20.0),
        episode(steady, "c", 10.0, 20.0),
        episode(steady, "a", 30.0, 31.0),
    ];
    of.add((&"d1".into(), Nanos(4_000_000_000)), &before, &[noisy, before.to_vec()]);
    of.finish();
    of
}

#[test]
fn the_same_is_counted_once_and_by_target() {
    let of = compared();
    let noise = &of.perturbations[0].all;
    // By hand: 2 before, 3 after, 1 the same: 2 * 1 / 5.
    assert_eq!((noise.before, noise.after, noise.same), (2, 3, 1));
    assert!((noise.agreement - 0.4).abs() < 1e-12 && noise.ratio == Some(1.5));
    assert_eq!(noise.keyframe_shift_s, Some(0.5));
    assert_eq!(of.perturbations[1].all.agreement, 1.0);
    assert!((of.least() - 0.4).abs() < 1e-12);
    assert!(of.more_frequent(1.2).is_empty(), "three episodes say little");
}

#[test]
fn text_and_page_show_what_changed() {
    let of = compared();
    let text = render(&of, Lang::En, Shown { floor: 0.9, ..Shown::default() });
    assert!(text.contains("1 drives, seed 3"), "{text}");
    assert!(text.contains("0.40          2          3       1.50      0.5 s"), "{text}");
    assert!(!text.contains("drops: "), "nothing changed there: {text}");
    let page = page(&of, Lang::Zh, 0.9, |_| Bilingual::new("稳定行驶", "Steady driving"));
    assert!(
        page.contains("class=\"low\">0.4 <small>(3)</small>") && page.contains("class=\"same\">1"),
        "{page}"
    );
    // Classes by name; ids only in tooltips. Figures of the noise are not in the heads of columns.
    assert!(page.contains("稳定行驶") && !page.contains(">driving_state"), "{page}");
}

#[test]
fn what_differs_is_named_with_its_time_in_the_drive() {
    let of = compared();
    let named: Vec<_> = of.perturbations[0]
        .differences
        .iter()
        .map(|d| (d.change, d.objects[0].as_str(), d.keyframe_s, d.drive.as_str()))
        .collect();
    // By hand: b is lost, c and the second of a are new; the drive begins at 4 s.
    assert_eq!(
        named,
        [(Change::Lost, "b", 6.0, "d1"), (Change::New, "c", 6.0, "d1"), (Change::New, "a", 26.0, "d1")]
    );
    assert!(of.perturbations[1].differences.is_empty());
    let text = render(&of, Lang::En, Shown { floor: 0.9, episodes: true, ..Shown::default() });
    assert!(text.contains("- d1  6.0 s  driving_state.longitudinal.steady  b"), "{text}");
    assert!(text.contains("+ d1  26.0 s  driving_state.longitudinal.steady  a"), "{text}");
}
