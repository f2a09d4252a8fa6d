//! Values that hold along a road, each from a station on.

/// The value that holds longest between two stations, of values that hold each from a station on.
pub(super) fn longest<T: Clone + PartialEq>(values: &[(f64, T)], from: f64, to: f64) -> Option<T> {
    let mut spans: Vec<(&T, f64)> = Vec::new();
    for (i, (start, value)) in values.iter().enumerate() {
        let end = values.get(i + 1).map_or(f64::INFINITY, |next| next.0);
        let span = end.min(to) - start.max(from);
        match spans.iter().position(|(v, _)| *v == value) {
            _ if span <= 0.0 => {}
            Some(at) => spans[at].1 += span,
            // More values than this in one section are not a road's.
            None if spans.len() < 64 => spans.push((value, span)),
            None => {}
        }
    }
    spans.into_iter().rev().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(v, _)| v.clone())
}
