use super::*;

fn view() -> View {
    // Facing north (world y) at (100, 50).
    View::around(100.0, 50.0, std::f64::consts::FRAC_PI_2, None)
}

fn close(a: Spot, b: Spot) -> bool {
    (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9
}

#[test]
fn what_is_ahead_is_up_and_what_is_to_the_right_is_right() {
    assert!(close(view().spot(100.0, 60.0), (0.0, -10.0)), "10 m ahead");
    assert!(
        close(view().spot(103.0, 50.0), (3.0, 0.0)),
        "3 m east of a car that faces north is on its right"
    );
}

#[test]
fn the_window_grows_to_show_the_target_but_not_without_end() {
    let near = View::around(0.0, 0.0, 0.0, Some((20.0, 0.0)));
    assert!((near.ahead_m - 38.0).abs() < 1e-9);
    let far = View::around(0.0, 0.0, 0.0, Some((50.0, 0.0)));
    assert!((far.ahead_m - 58.0).abs() < 1e-9);
    assert!(View::around(0.0, 0.0, 0.0, Some((500.0, 0.0))).ahead_m <= 72.0);
}

#[test]
fn a_line_is_cut_where_it_leaves_the_window_and_resumes_where_it_enters() {
    let p = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    // East-west through the ego, then far out, then back along the other side of the window.
    let lines = view().lines(&[p(50.0, 50.0), p(150.0, 50.0), p(150.0, 60.0), p(50.0, 60.0)]);
    assert_eq!(lines.len(), 2);
    assert!(close(lines[0][0], (-30.0, 0.0)) && close(lines[0][1], (30.0, 0.0)));
    assert!(close(lines[1][0], (30.0, -10.0)) && close(lines[1][1], (-30.0, -10.0)));
}

#[test]
fn points_on_a_straight_line_are_left_out_and_corners_stay() {
    let p = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    let lines =
        view().lines(&[p(100.0, 50.0), p(100.0, 55.0), p(100.01, 57.0), p(100.0, 60.0), p(110.0, 60.0)]);
    assert_eq!(lines, [vec![view().spot(100.0, 50.0), view().spot(100.0, 60.0), view().spot(110.0, 60.0)]]);
}

#[test]
fn an_area_larger_than_the_window_fills_it() {
    let p = |x: f64, y: f64| Point3 { x, y, z: 0.0 };
    let area = view().area(&[p(-900.0, -900.0), p(900.0, -900.0), p(900.0, 900.0), p(-900.0, 900.0)]);
    let twice: f64 = area.iter().zip(area.iter().cycle().skip(1)).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum();
    assert!((twice.abs() / 2.0 - 60.0 * 60.0).abs() < 1e-6);
    assert!(view().area(&[p(900.0, 900.0), p(901.0, 900.0), p(900.0, 901.0)]).is_empty());
}
