//! The assignment of rows to columns with the greatest sum (Kuhn 1955, Munkres 1957; shortest augmenting paths with
//! potentials as in Jonker and Volgenant 1987). As many pairs as the smaller side has.

/// Pairs (row, column) of the best assignment of `weight[row][column]`, rows ascending.
pub fn best_assignment(weight: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let (rows, columns) = (weight.len(), weight.first().map_or(0, Vec::len));
    if rows == 0 || columns == 0 {
        return Vec::new();
    }
    if rows > columns {
        let turned: Vec<Vec<f64>> = (0..columns).map(|c| weight.iter().map(|r| r[c]).collect()).collect();
        let mut out: Vec<_> = best_assignment(&turned).into_iter().map(|(c, r)| (r, c)).collect();
        out.sort_unstable();
        return out;
    }
    // Column `columns` is a root that each row in turn starts from; costs are negative weights.
    let (mut row_potential, mut column_potential) = (vec![0.0; rows], vec![0.0; columns + 1]);
    let mut owner: Vec<Option<usize>> = vec![None; columns + 1];
    for row in 0..rows {
        owner[columns] = Some(row);
        let mut least = vec![f64::INFINITY; columns];
        let mut before = vec![columns; columns];
        let mut used = vec![false; columns + 1];
        let mut at = columns;
        while let Some(r) = owner[at] {
            used[at] = true;
            let (mut step, mut next) = (f64::INFINITY, at);
            for c in (0..columns).filter(|&c| !used[c]) {
                let slack = -weight[r][c] - row_potential[r] - column_potential[c];
                if slack < least[c] {
                    (least[c], before[c]) = (slack, at);
                }
                if least[c] < step {
                    (step, next) = (least[c], c);
                }
            }
            for c in 0..=columns {
                match owner[c].filter(|_| used[c]) {
                    Some(r) => {
                        row_potential[r] += step;
                        column_potential[c] -= step;
                    }
                    None if c < columns => least[c] -= step,
                    None => {}
                }
            }
            at = next;
        }
        while at != columns {
            owner[at] = owner[before[at]];
            at = before[at];
        }
    }
    let mut out: Vec<_> = (0..columns).filter_map(|c| Some((owner[c]?, c))).collect();
    out.sort_unstable();
    out
}
