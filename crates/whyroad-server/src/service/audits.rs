//! The random selection of checked labels for audit. The audit rate depends on the author's record: see
//! [`super::dashboard`].

use crate::domain::workflow::Draw;
use crate::secret;
use crate::service::tasks::TaskRow;

/// Whether this submission is audited: cannot be predicted without `key`, and is the same on every call.
pub fn draw(key: &str, t: &TaskRow, percent: f64) -> Draw {
    drawn(key, &t.id, t.version, percent)
}

fn drawn(key: &str, task: &str, version: i64, percent: f64) -> Draw {
    let ticket = secret::sign(key, format!("audit {task} {version}").as_bytes());
    let number = u64::from_str_radix(ticket.get(..12).unwrap_or_default(), 16).unwrap_or(0);
    if (number as f64) < percent / 100.0 * 2_f64.powi(48) { Draw::Audit } else { Draw::Pass }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_comes_out() {
        let share = |percent: f64| {
            (0..10_000).filter(|i| drawn("key", &format!("task{i}"), 7, percent) == Draw::Audit).count()
        };
        assert_eq!((share(0.0), share(100.0)), (0, 10_000));
        // Binomial with p = 0.15 and n = 10000: the standard deviation is 36.
        assert!((1500 - 150..1500 + 150).contains(&share(15.0)), "{}", share(15.0));
    }
}
