//! The search for the nearest segment compared with a search of all segments, and hand-made cases.

use super::nearest::{MOST, MOST_BENT};
use super::*;
use crate::geometry::{p2, wrap};

fn l_shape() -> Polyline {
    Polyline::new([p2(0.0, 0.0), p2(10.0, 0.0), p2(10.0, 0.0), p2(10.0, 10.0)]).unwrap()
}

#[test]
fn projection_by_hand() {
    let line = l_shape();
    assert_eq!(line.length(), 20.0);
    let at = line.project(p2(4.0, 2.0));
    assert_eq!((at.s, at.lateral), (4.0, 2.0));
    let at = line.project(p2(12.0, 5.0));
    assert_eq!((at.s, at.lateral), (15.0, -2.0));
    let outer_corner = line.project(p2(13.0, -4.0));
    assert_eq!((outer_corner.s, outer_corner.lateral), (10.0, -5.0));
}

#[test]
fn the_ends_go_on_straight() {
    let line = l_shape();
    assert_eq!(line.project(p2(-3.0, -1.0)), Projection { s: -3.0, lateral: -1.0, segment: 0 });
    assert_eq!(line.project(p2(11.0, 30.0)).s, 40.0);
    assert_eq!(line.point_at(-2.0), p2(-2.0, 0.0));
    assert_eq!(line.point_at(25.0), p2(10.0, 15.0));
}

#[test]
fn a_window_keeps_the_right_branch() {
    // Out along y = 0, back along y = 4: the point is nearer to the way back, but the query is on the way out.
    let line = Polyline::new([p2(0.0, 0.0), p2(50.0, 0.0), p2(50.0, 4.0), p2(0.0, 4.0)]).unwrap();
    assert_eq!(line.project_between(p2(20.0, 3.0), 0.0, 40.0).s, 20.0);
    assert!(line.project(p2(20.0, 3.0)).s > 80.0);
}

/// Every segment, with the divisions that the definition has.
fn one_by_one(line: &Polyline, p: P2, segments: Range<usize>) -> Projection {
    let n = line.points.len() - 1;
    let mut best = (f64::INFINITY, Projection { s: 0.0, lateral: 0.0, segment: segments.start });
    for i in segments {
        let (a, length) = (line.points[i], line.s[i + 1] - line.s[i]);
        let ab = line.points[i + 1] - a;
        let along = (p - a).dot(ab) / length;
        let along = along.clamp(
            if i > 0 { 0.0 } else { f64::NEG_INFINITY },
            if i + 1 < n { length } else { f64::INFINITY },
        );
        let away = p - (a + ab * (along / length));
        let d2 = away.dot(away);
        if d2 < best.0 {
            let side = if ab.cross(p - a) >= 0.0 { 1.0 } else { -1.0 };
            let at = Projection { s: line.s[i] + along, lateral: side * d2.sqrt(), segment: i };
            best = (d2, at);
        }
    }
    best.1
}

#[test]
fn a_long_line_is_searched_as_a_short_one() {
    // Loops and straights, with points that are equally near to several segments: skipping blocks changes nothing.
    let wave = |i: usize| {
        let t = i as f64 * 0.05;
        p2(30.0 * t.cos() + 3.0 * t, 20.0 * (1.3 * t).sin())
    };
    let lines = [
        Polyline::new((0..900).map(wave)).unwrap(),
        Polyline::new((0..400).map(|i| p2(f64::from(i), 0.0))).unwrap(),
        Polyline::new((0..400).map(|i| p2(f64::from(i % 20), f64::from(i / 20)))).unwrap(),
        // In national coordinates, with steps of a few millimeters.
        Polyline::new((0..900).map(|i| wave(i) * 0.01 + p2(682_312.7, 3_412_990.3))).unwrap(),
        Polyline::new((0..20).map(wave)).unwrap(),
    ];
    for line in &lines {
        let n = line.points.len() - 1;
        let mut before: Option<Foot> = None;
        for k in 0..2000u32 {
            let p = p2(f64::from(k % 71) * 3.5 - 80.0, f64::from(k % 37) * 2.5 - 40.0);
            let p = if line.points[0].x > 1e5 { p * 0.02 + line.points[0] } else { p };
            let (a, b) = ((k as usize * 7) % n, (k as usize * 13) % n);
            // The whole line, a part of it, and as little as is around a box.
            for (first, end) in [(0, n), (a.min(b), a.max(b) + 1), (a, (a + 1 + b % MOST).min(n))] {
                let (window, nearest) = (Window { first, end }, one_by_one(line, p, first..end));
                assert_eq!(line.project_within(p, window), nearest, "{p:?} {first}..{end}");
                // From segment to segment, with any start.
                let size = if line.points[0].x > 1e5 { 0.03 } else { 3.0 };
                let aside = P2::from_heading(f64::from(k)) * size;
                let circles = [(p, 0.0), (p + aside, size * (1.0 + 1e-6))];
                for (center, radius) in circles {
                    let nearby = line.segments.nearby(window, center, radius);
                    for near in [first, end, (first + end) / 2, nearest.segment] {
                        let found = line.project_nearby(p, &nearby, near);
                        assert_eq!(found, nearest, "{p:?} {first}..{end}");
                    }
                }
                // With any start of the search.
                let found = line.foot(p, window, before.as_ref());
                assert_eq!(found.at, nearest, "{p:?} {first}..{end}");
                before = Some(found);
                for (first, end) in [(0, n), (first / 2, (end + 3).min(n)), (first, end - (end - first) / 3)]
                {
                    let moved = line.foot_again(p, Window { first, end }, &found);
                    assert_eq!(moved.at, one_by_one(line, p, first..end), "{p:?} {first}..{end}");
                    let back = line.foot_again(p, window, &moved);
                    assert_eq!(back.at, nearest, "{p:?} {first}..{end}");
                }
            }
        }
    }
}

#[test]
fn a_foot_point_that_follows_others_is_the_nearest() {
    // Straights, slight bends, corners and a way back; also in national coordinates.
    let mut points = vec![p2(0.0, 0.0)];
    for i in 0..600_i32 {
        let heading = match i / 50 {
            0 | 1 | 5 | 11 => 0.0,
            2 => 0.002 * f64::from(i - 100),
            3 | 4 => 0.1,
            6 => 0.03 * f64::from(i - 300),
            7 => 1.5,
            8 => 1.5 + 0.0628 * f64::from(i - 400),
            _ => 4.64,
        };
        points.push(points[points.len() - 1] + P2::from_heading(heading) * (0.8 + 0.1 * f64::from(i % 5)));
    }
    for far in [p2(0.0, 0.0), p2(682_312.7, 3_412_990.3)] {
        let line = Polyline::new(points.iter().map(|p| *p + far)).unwrap();
        let n = line.points.len() - 1;
        // Positions that go along the line, against it and past it, while the window goes along it.
        for walk in 0..24_usize {
            let (start, step) = (walk * 31 % n, [1.1, -0.7, 0.05, 4.0][walk % 4]);
            let aside = [0.0, 3.5, -12.0, 40.0, -90.0, 0.3][walk % 6];
            let mut p = line.points[start] + P2::from_heading(walk as f64) * 0.3;
            let mut before: Option<Foot> = None;
            for k in 0..150_usize {
                let at = line.project(p).s;
                let (along, left) = (line.directions[line.segment_at(at)], 1e-3 * f64::from(k as u32));
                p = p + along * step + along.left() * (if k == 0 { aside } else { left });
                let first = (start + k).saturating_sub(130).min(n - 70);
                let window = Window { first, end: (first + 260 - k / 2).min(n) };
                let found = line.foot(p, window, before.as_ref());
                assert_eq!(found.at, one_by_one(&line, p, window.first..window.end), "{walk} {k} {p:?}");
                before = Some(found);
            }
        }
    }
}

#[test]
fn the_way_to_the_nearest_segment_finds_it() {
    // A slight bend to both sides with unequal steps, and a corner; positions on points, beside them and far away; also
    // in national coordinates.
    let mut s = 0.0;
    let at = |i: u32| {
        s += [0.5, 0.9, 0.6, 1.1, 0.7][(i % 5) as usize];
        p2(s, (0.04 * s).sin() + if s > 120.0 { 0.4 * (s - 120.0) } else { 0.0 })
    };
    let points: Vec<P2> = (0..300).map(at).collect();
    for far in [p2(0.0, 0.0), p2(682_312.7, 3_412_990.3)] {
        let line = Polyline::new(points.iter().map(|p| *p + far)).unwrap();
        let mut told = 0;
        for k in 0..4000_usize {
            let (here, first) = (k * 7 % 280, (k * 7 % 280).saturating_sub(9));
            let window = Window { first, end: here + 12 };
            let (a, b) = (line.points[here], line.points[here + 1]);
            let aside = [0.0, 1e-9, 0.01, 1.0, -3.5, 20.0, -60.0][k % 7];
            let along = [0.0, 1e-7, 0.02, 0.5, 1.0, -0.3, 4.0][k / 7 % 7];
            let p = a + (b - a) * along + (b - a).left() * (aside / (b - a).norm());
            for radius in [0.0, 2.6] {
                let center = p + P2::from_heading(k as f64) * (radius * 0.999_999);
                let nearby = line.segments.nearby(window, center, radius);
                let found = line.project_nearby(p, &nearby, here);
                assert_eq!(found, one_by_one(&line, p, first..here + 12), "{k}");
                told += u32::from(nearby.bent <= MOST_BENT);
            }
        }
        assert!(told > 6000, "{told}");
    }
}

#[test]
fn only_the_inner_side_of_a_bend_is_bent() {
    // A quarter of a circle of 10 m to the left around (0, 10), with steps of about 1 m.
    let at =
        |i: u32| P2::from_heading(f64::from(i) * 0.1 - std::f64::consts::FRAC_PI_2) * 10.0 + p2(0.0, 10.0);
    let line = Polyline::new((0..=15).map(at)).unwrap();
    let bent = |aside: f64| {
        // From the middle of the bend, left positive.
        let middle = at(7) + (p2(0.0, 10.0) - at(7)) * (aside / 10.0);
        line.segments.nearby(Window { first: 0, end: 15 }, middle, 0.0).bent
    };
    for aside in [0.0, 2.0, 8.0] {
        // Farthest to the inner side of the last bend, 0.7 rad away.
        let expected = 1.0 - (1.0 - aside / 10.0) * 0.7_f64.cos();
        assert!((bent(aside) - expected).abs() < 0.003, "{aside} {}", bent(aside));
    }
    // Twenty meters to the right of it everything is on the outer sides.
    assert_eq!(bent(-20.0), 0.0);
}

#[test]
fn a_ray_meets_no_segment_that_was_left_out() {
    let wave =
        |i: usize| p2(30.0 * (i as f64 * 0.05).cos() + i as f64 * 0.15, 20.0 * (i as f64 * 0.065).sin());
    let line = Polyline::new((0..900).map(wave)).unwrap();
    let (points, mut met, mut looked_at) = (&line.points, 0, 0);
    for k in 0..400u32 {
        let from = p2(f64::from(k % 71) * 3.5 - 80.0, f64::from(k % 37) * 2.5 - 40.0);
        let ray = Ray { from, direction: P2::from_heading(f64::from(k) * 0.37), reach: 60.0 };
        let first = (k as usize * 7) % 800;
        let kept: Vec<usize> = line.segments_met(ray, first..points.len() - 1).collect();
        looked_at += kept.len();
        for i in first..points.len() - 1 {
            let (segment, to) = (points[i + 1] - points[i], points[i] - from);
            let across = ray.direction.cross(segment);
            let (x, share) = (to.cross(segment) / across, to.cross(ray.direction) / across);
            if (0.0..=1.0).contains(&share) && (0.0..=ray.reach).contains(&x) {
                assert!(kept.contains(&i));
                met += 1;
            }
        }
    }
    assert!(met > 300 && looked_at < 400 * 300, "{met} {looked_at}");
}

#[test]
fn places_are_those_of_asking_every_point() {
    // Steps of a millimeter next to steps of a kilometer.
    let steps = |i: u32| if i % 50 == 49 { 1000.0 } else { 0.002 + f64::from(i % 7) };
    let mut x = 0.0;
    let points = (0..300).map(|i| {
        x += steps(i);
        p2(x, 0.0)
    });
    let line = Polyline::new(points).unwrap();
    let values: Vec<f64> = (0..300).map(|i| f64::from(i * i)).collect();
    let around = line.s.iter().flat_map(|s| [*s, s.next_down(), s.next_up(), s + 0.3, -s]);
    for s in around.chain([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
        assert_eq!(line.points_up_to(s), line.s.partition_point(|&v| v <= s), "{s}");
        let (by_line, plain) = (line.interpolate(&values, s), interpolate(&line.s, &values, s));
        assert_eq!(by_line.to_bits(), plain.to_bits(), "{s}");
    }
}

#[test]
fn curvature_of_a_circle() {
    // Radius 25 m, left: 1/25.
    let line = Polyline::new((0..=100).map(|i| {
        let a = f64::from(i) * 0.02;
        p2(25.0 * a.sin(), 25.0 - 25.0 * a.cos())
    }))
    .unwrap();
    assert!((line.curvature_at(25.0, 5.0) - 0.04).abs() < 2e-4);
    assert!(Polyline::new([p2(1.0, 1.0), p2(1.0, 1.0)]).is_none());
}

#[test]
fn the_greatest_curvature_is_that_of_asking_each() {
    // Straight, a bend to the left, one to the right that is narrower, a corner, a way back.
    let mut points = vec![p2(0.0, 0.0)];
    let mut heading = 0.0_f64;
    for i in 0..120_i32 {
        heading += match i {
            30..50 => 0.03,
            60..75 => -0.08,
            90 => 1.7,
            100..104 => 0.8,
            _ => 1e-13 * f64::from(i % 3),
        };
        points.push(points[points.len() - 1] + P2::from_heading(heading) * 1.1);
    }
    let line = Polyline::new(points).unwrap();
    for k in 0..260 {
        let at = || (0..=25).map(|i| f64::from(k) * 0.5 - 10.0 + 2.0 * f64::from(i));
        let expected = at()
            .map(|s| line.curvature_at(s, 5.0))
            .fold(0.0_f64, |most, c| if c.abs() > most.abs() { c } else { most });
        assert_eq!(line.greatest_curvature(at(), 5.0).to_bits(), expected.to_bits(), "{k}");
        let s = f64::from(k) * 0.5;
        let off = line.smooth_direction_at(s, 1.0) - P2::from_heading(line.smooth_heading_at(s, 1.0));
        assert!(off.norm() < 1e-15, "{k}");
    }
}

#[test]
fn the_distance_is_that_of_all_segments() {
    // A spiral, the turns of which are near each other.
    let line =
        Polyline::new((0..300).map(|i| P2::from_heading(f64::from(i) * 0.1) * (1.0 + 0.1 * f64::from(i))));
    let line = line.unwrap();
    for k in 0..2000_i32 {
        let p = p2(f64::from(k * 37 % 101) - 50.0, f64::from(k * 53 % 97) - 48.0);
        let each = line.points.windows(2).map(|w| segment_distance2(p, w[0], w[1]));
        let expected = each.fold(f64::INFINITY, f64::min).sqrt();
        assert_eq!(line.distance(p).to_bits(), expected.to_bits(), "{k}");
    }
}

#[test]
fn chords_lead_in_the_range_of_directions() {
    // From east to north in steps of 10 deg, over west to south-west, and a zigzag across the wrap at 180 deg.
    let turns = [
        ((0..=9).map(|i| f64::from(i) * 10.0).collect::<Vec<f64>>(), 45.0, 45.0),
        (vec![150.0, 180.0, -160.0, -130.0], -170.0, 40.0),
        (vec![170.0, -170.0, 175.0, -175.0, 160.0], 175.0, 15.0),
    ];
    for (headings, middle, half) in turns {
        let mut at = vec![p2(680_000.0, 4_800_000.0)];
        for (i, heading) in headings.iter().enumerate() {
            at.push(at[i] + P2::from_heading(heading.to_radians()) * (0.4 + i as f64));
        }
        let line = Polyline::new(at).unwrap();
        let (of_middle, of_half) = line.range_of_directions();
        assert!(wrap(of_middle - f64::to_radians(middle)).abs() < 1e-6, "{of_middle}");
        assert!((of_half - f64::to_radians(half)).abs() < 1e-6, "{of_half}");
        for i in -5..=200 {
            let chord = line.smooth_heading_at(f64::from(i) * 0.1, 2.0);
            assert!(wrap(chord - of_middle).abs() <= of_half + 1e-6, "{i}");
        }
    }
}
