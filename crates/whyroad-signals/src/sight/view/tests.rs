//! Shares by trigonometry, and compared with individual sight lines.

use super::*;
use crate::geometry::{p2, wrap};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn at(x: f64, y: f64, heading: f64, length: f64, width: f64) -> OrientedBox {
    OrientedBox::new(p2(x, y), heading, length, width)
}

fn view(boxes: &[OrientedBox]) -> View {
    let mut view = View::from(p2(0.0, 0.0), 0);
    for (k, b) in boxes.iter().enumerate() {
        view.add_box(Owner::Target(k), *b, &mut None);
    }
    view
}

#[test]
fn a_share_by_angles() {
    // Seen end on from (0, 0): the near face at x = 18 from y = -1 to 1 fills atan(1/18) either side of the x axis.
    let target = at(20.0, 0.0, 0.0, 4.0, 2.0);
    // A square whose lower edge is y = 0 hides exactly the upper half.
    let half = view(&[at(10.0, 1.0, 0.0, 2.0, 2.0)]).sight(None, &target).unwrap();
    assert!((half.share - 0.5).abs() < 1e-12);
    assert_eq!(half.occluder, Some(Owner::Target(0)));
    // One with the lower left corner (9, 0.2): it hides the part above atan(0.2 / 9) - but its lower edge is y = 0.2,
    // whose far end (11, 0.2) appears lower, at atan(0.2 / 11).
    let angle = (1.0_f64 / 18.0).atan();
    let expected = ((0.2_f64 / 11.0).atan() + angle) / (2.0 * angle);
    let part = view(&[at(10.0, 1.2, 0.0, 2.0, 2.0)]).sight(None, &target).unwrap();
    assert!((part.share - expected).abs() < 1e-12, "{} {expected}", part.share);
    assert_eq!(view(&[]).sight(None, &target), Some(Sight { share: 1.0, occluder: None }));
    assert_eq!(
        view(&[at(0.0, 0.0, 0.3, 4.0, 2.0)]).sight(None, &target).unwrap().share,
        1.0,
        "around the eye"
    );
    assert_eq!(view(&[]).sight(None, &at(0.5, 0.0, 0.0, 4.0, 2.0)), None);
}

#[test]
fn behind_beside_and_overlapping_hide_nothing() {
    let target = at(20.0, 0.0, 0.0, 4.0, 2.0);
    for other in [at(30.0, 0.0, 0.0, 4.0, 9.0), at(10.0, 5.0, 0.0, 4.0, 2.0), at(-10.0, 0.0, 0.0, 4.0, 2.0)] {
        assert_eq!(view(&[other]).sight(None, &target).unwrap().share, 1.0);
    }
    let bicycle = at(19.0, 0.0, 0.0, 2.0, 1.0);
    assert_eq!(view(&[bicycle]).sight(None, &target).unwrap().share, 1.0);
    assert_eq!(view(&[target]).sight(Some(Owner::Target(0)), &target).unwrap().share, 1.0);
}

#[test]
fn the_one_that_hides_most_is_named_and_the_nearer_of_equals() {
    let target = at(40.0, 0.0, 0.0, 4.0, 2.0);
    let both = view(&[at(20.0, 0.0, 0.0, 4.0, 4.0), at(10.0, 0.0, 0.0, 4.0, 4.0)]);
    let sight = both.sight(None, &target).unwrap();
    assert_eq!((sight.share, sight.occluder), (0.0, Some(Owner::Target(1))));
    let mut walled = view(&[at(10.0, 1.1, 0.0, 2.0, 2.0)]);
    walled.add_wall(Owner::Building(0), p2(20.0, -5.0), p2(20.0, 0.4));
    assert_eq!(walled.sight(None, &target).unwrap().occluder, Some(Owner::Building(0)));
}

#[test]
fn across_the_seam_of_angles() {
    let target = at(-20.0, 0.0, 0.0, 4.0, 2.0);
    assert_eq!(view(&[at(-8.0, 0.0, 0.0, 4.0, 2.0)]).sight(None, &target).unwrap().share, 0.0);
    assert!((view(&[at(-8.0, 1.0, 0.0, 2.0, 2.0)]).sight(None, &target).unwrap().share - 0.5).abs() < 1e-12);
    let v = view(&[at(-8.0, 0.0, 0.0, 4.0, 2.0)]);
    assert_eq!(v.counting(|_| true).before(p2(-20.0, -0.5)), Some(Owner::Target(0)));
    assert_eq!(v.counting(|_| false).before(p2(-20.0, -0.5)), None);
    assert_eq!(v.counting(|_| true).before(p2(-5.0, 0.0)), None);
}

/// Distance at which a ray from the origin enters the box, by clipping against its two pairs of sides: an independent
/// method.
fn slab(b: &OrientedBox, angle: f64) -> f64 {
    let (sin, cos) = b.heading.sin_cos();
    let turn = |x: f64, y: f64| (x * cos + y * sin, y * cos - x * sin);
    let (o, d) = (turn(-b.center.x, -b.center.y), turn(angle.cos(), angle.sin()));
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for (o, d, half) in [(o.0, d.0, b.length / 2.0), (o.1, d.1, b.width / 2.0)] {
        let (t0, t1) = ((-half - o) / d, (half - o) / d);
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    if enter <= leave { enter } else { f64::INFINITY }
}

fn boxes() -> impl Strategy<Value = Vec<OrientedBox>> {
    let one = (-PI..PI, 4.0..60.0_f64, -PI..PI, 0.5..12.0_f64, 0.4..3.0_f64)
        .prop_map(|(angle, r, h, l, w)| at(r * angle.cos(), r * angle.sin(), h, l, w));
    prop::collection::vec(one, 2..14)
}

/// [`Counting::before`] without ranges of directions: every piece is checked.
fn before_one_by_one(v: &View, place: P2) -> Option<Owner> {
    let to = place - v.eye;
    let distance = to.norm();
    let direction = to * (1.0 / distance.max(1e-9));
    let met = v.pieces.iter().filter(|p| p.reach.nearest < distance && p.sector.contains(direction));
    let met = met.map(|p| (entry(p.outline.corners(), direction), p.owner)).filter(|(at, _)| *at < distance);
    met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, owner)| owner)
}

/// The middle and half of the angle at which all corners are seen, each of which is asked for its own.
fn angles_of_all(corners: &[P2]) -> [u64; 2] {
    let first = corners[0].heading();
    let turned = || corners[1..].iter().map(|c| wrap(c.heading() - first));
    let (low, high) = (turned().fold(0.0, f64::min), turned().fold(0.0, f64::max));
    [wrap(first + (low + high) / 2.0), (high - low) / 2.0].map(f64::to_bits)
}

#[test]
fn corners_between_others_change_no_angle() {
    for k in 0..20_000_i32 {
        let (turn, away) = (f64::from(k) * 0.37, 1.2 + f64::from(k % 97) * 0.6);
        // Also boxes with corners that are seen in one direction, or nearly.
        let heading = if k % 3 == 0 { turn + f64::from(k % 2) * 1e-14 } else { f64::from(k) * 0.71 };
        let b =
            at(away * turn.cos(), away * turn.sin(), heading, 0.3 + f64::from(k % 9), f64::from(k % 4) * 0.6);
        if b.overlaps(&OrientedBox::point(p2(0.0, 0.0))) {
            continue;
        }
        let (corners, [a, _, c, _]) = (b.corners(), b.corners());
        for corners in [&corners[..], &[a, c]] {
            let sector = Sector::of(corners);
            assert_eq!([sector.mid, sector.half].map(f64::to_bits), angles_of_all(corners), "{k}");
        }
    }
}

const LINES: usize = 600;

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn ranges_of_directions_leave_no_piece_out(
        many in prop::collection::vec((-PI..PI, 1.0..60.0_f64, -PI..PI, 0.0..40.0_f64), 1..150),
        places in prop::collection::vec((-PI..PI, 0.0..80.0_f64), 60),
    ) {
        let mut v = View::from(p2(0.0, 0.0), 0);
        for (k, (angle, r, h, l)) in many.iter().enumerate() {
            if k % 3 == 0 {
                let (a, along) = (P2::from_heading(*angle) * *r, P2::from_heading(*h) * *l);
                v.add_wall(Owner::Building(k), a, a + along);
            } else {
                v.add_box(Owner::Target(k), at(r * angle.cos(), r * angle.sin(), *h, l / 4.0 + 0.2, 1.0), &mut None);
            }
        }
        // Also exactly along the edges of pieces, and along the axes, where ranges meet.
        let corners: Vec<P2> = v.pieces.iter().flat_map(|p| p.outline.corners()).map(|c| *c * 1.5).collect();
        let around = places.iter().map(|(angle, r)| P2::from_heading(*angle) * *r);
        let axes = [p2(50.0, 0.0), p2(0.0, 50.0), p2(-50.0, 0.0), p2(0.0, -50.0), p2(-50.0, -0.0)];
        for place in around.chain(corners).chain(axes) {
            prop_assert_eq!(v.counting(|_| true).before(place), before_one_by_one(&v, place));
        }
        for piece in &v.pieces {
            let is_near = |k: &usize| in_ranges(&v.ranges[k / 64], piece.sector.ranges) >> (k % 64) & 1 == 1;
            let near: Vec<Owner> = (0..v.pieces.len()).filter(is_near).map(|k| v.pieces[k].owner).collect();
            for other in v.pieces.iter().filter(|o| piece.sector.shared(o.sector.mid, o.sector.half).is_some()) {
                prop_assert!(near.contains(&other.owner));
            }
        }
    }

    #[test]
    fn shares_are_those_of_sight_lines_tried_one_by_one(candidates in boxes()) {
        let eye = at(0.0, 0.0, 0.0, 0.1, 0.1);
        let mut kept: Vec<OrientedBox> = Vec::new();
        for b in candidates {
            if !b.overlaps(&eye) && !kept.iter().any(|k| k.overlaps(&b)) {
                kept.push(b);
            }
        }
        let v = view(&kept);
        for (k, target) in kept.iter().enumerate() {
            let center = target.center.heading();
            let turned = target.corners().map(|c| wrap(c.heading() - center));
            let (low, high) = (turned.into_iter().fold(0.0, f64::min), turned.into_iter().fold(0.0, f64::max));
            let reaches = |i: &usize| {
                let angle = center + low + (high - low) * (*i as f64 + 0.5) / LINES as f64;
                let own = slab(target, angle);
                !kept.iter().enumerate().any(|(j, o)| j != k && slab(o, angle) < own)
            };
            let tried = (0..LINES).filter(reaches).count() as f64 / LINES as f64;
            let sight = v.sight(Some(Owner::Target(k)), target).unwrap();
            // Each edge between visible and hidden may be between two lines.
            let tolerance = 2.0 * kept.len() as f64 / LINES as f64;
            prop_assert!((sight.share - tried).abs() <= tolerance, "{} against {tried}", sight.share);
            prop_assert_eq!(sight.occluder.is_none(), sight.share == 1.0);
            // A position is hidden exactly if the line to it is blocked.
            let stopped = kept.iter().enumerate().any(|(j, o)| {
                let at = slab(o, target.center.heading());
                j != k && at < target.center.norm() - 1e-9
            });
            let before = v.counting(|o| o != Owner::Target(k)).before(target.center);
            prop_assert_eq!(before.is_some(), stopped);
        }
    }
}

#[test]
fn a_right_angle_in_a_corner() {
    // A wall from (10, 3) along y hides positions behind it and not those in front of it.
    let mut v = View::from(p2(0.0, 0.0), 0);
    v.add_wall(Owner::Building(0), p2(10.0, 3.0), p2(10.0, 30.0));
    assert_eq!(v.counting(|_| true).before(p2(20.0, 5.9)), None);
    assert_eq!(v.counting(|_| true).before(p2(20.0, 6.1)), Some(Owner::Building(0)));
    assert_eq!(v.counting(|_| true).before(p2(9.0, 20.0)), None);
    assert_eq!(v.sight(None, &at(20.0, 20.0, FRAC_PI_2, 4.0, 2.0)).unwrap().share, 0.0);
}
