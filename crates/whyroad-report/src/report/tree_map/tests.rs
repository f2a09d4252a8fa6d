use super::*;

fn area(r: &Rect) -> f64 {
    r.w * r.h
}

#[test]
fn areas_are_in_proportion_and_fill_the_whole() {
    let whole = Rect { x: 10.0, y: 20.0, w: 600.0, h: 400.0 };
    // The example of Bruls, Huizing, van Wijk (2000), figure 2.
    let weights = [6.0, 6.0, 4.0, 3.0, 2.0, 2.0, 1.0];
    let rects = squarify(&weights, whole);
    assert_eq!(rects.len(), weights.len());
    for (r, w) in rects.iter().zip(weights) {
        assert!((area(r) - w / 24.0 * 240_000.0).abs() < 1e-6);
        assert!(r.x >= 10.0 - 1e-9 && r.y >= 20.0 - 1e-9);
        assert!(r.x + r.w <= 610.0 + 1e-6 && r.y + r.h <= 420.0 + 1e-6);
    }
    // In that figure the first two share the left column, each 3 wide and 2 high of 6 by 4.
    assert!((rects[0].w - 300.0).abs() < 1e-9 && (rects[0].h - 200.0).abs() < 1e-9);
    for (i, a) in rects.iter().enumerate() {
        for b in &rects[i + 1..] {
            let w = (a.x + a.w).min(b.x + b.w) - a.x.max(b.x);
            let h = (a.y + a.h).min(b.y + b.h) - a.y.max(b.y);
            assert!(w < 1e-6 || h < 1e-6, "two cells overlap");
        }
    }
}

#[test]
fn names_break_between_words_or_characters_and_are_cut_last() {
    assert_eq!(wrap("Lead sudden brake", 70.0, 11.0, 3), ["Lead sudden", "brake"]);
    assert_eq!(wrap("左转掉头专用道", 45.0, 11.0, 2), ["左转掉头", "专用道"]);
    assert_eq!(wrap("Lead sudden brake", 40.0, 11.0, 1).len(), 1);
    assert!(wrap("Lead sudden brake", 40.0, 11.0, 1)[0].ends_with('…'));
}
