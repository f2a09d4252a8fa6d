//! Distribution of differences.

/// Differences, in the order in which they were added.
#[derive(Default)]
pub struct Errors(Vec<f64>);

impl Errors {
    pub fn add(&mut self, error: f64) {
        self.0.push(error);
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The absolute error that a share `q` of all does not exceed; infinite when there are none.
    pub fn quantile(&self, q: f64) -> f64 {
        let mut sorted: Vec<f64> = self.0.iter().map(|e| e.abs()).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted.get((q * last as f64).round() as usize).copied().unwrap_or(f64::INFINITY)
    }

    /// Mean signed error.
    pub fn bias(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len().max(1) as f64
    }

    /// As text for people.
    pub fn line(&self) -> String {
        let q = |q| self.quantile(q);
        format!(
            "n {}, |error| median {:.3}, 90 % {:.3}, 99 % {:.3}, most {:.3}, bias {:+.3}",
            self.len(),
            q(0.5),
            q(0.9),
            q(0.99),
            q(1.0),
            self.bias()
        )
    }
}
