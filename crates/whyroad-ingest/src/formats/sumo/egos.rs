//! Which vehicles of a simulation are egos: named, or a share of all drawn by a seed.

use super::fcd::Fcd;
use super::vehicle_types::{IsPerson, VehicleTypes};

/// The vehicles that become egos, one drive per ego.
#[derive(Clone, Debug, PartialEq)]
pub enum Egos {
    /// By id, in this order.
    Named(Vec<String>),
    /// Every motor vehicle with this probability. Whether one is drawn depends only on its id and the seed, not on the
    /// other vehicles.
    Share {
        /// 0 to 1.
        share: f64,
        /// Another seed draws others.
        seed: u64,
    },
}

impl Default for Egos {
    fn default() -> Self {
        Egos::Named(vec!["ego".to_owned()])
    }
}

impl Egos {
    /// Ids of the egos in a log; named ones even if they are not in the log.
    pub(super) fn choose(&self, fcd: &Fcd, types: &VehicleTypes) -> Vec<String> {
        match self {
            Egos::Named(ids) => ids.clone(),
            Egos::Share { share, seed } => {
                let motor = |o: &super::fcd::Object| {
                    o.is_person == IsPerson::No && types.get(&o.type_id, o.is_person).0.class.is_vehicle()
                };
                let all = fcd.objects.iter().filter(|(_, o)| motor(o));
                all.filter(|(id, _)| draw(*seed, id) < *share).map(|(id, _)| id.clone()).collect()
            }
        }
    }
}

/// Evenly in [0, 1) by seed and id.
fn draw(seed: u64, id: &str) -> f64 {
    let mut hash = blake3::Hasher::new();
    hash.update(&seed.to_le_bytes());
    hash.update(id.as_bytes());
    let mut first = [0u8; 8];
    first.copy_from_slice(&hash.finalize().as_bytes()[..8]);
    // 53 bits are what a double holds.
    (u64::from_le_bytes(first) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::draw;

    #[test]
    fn draws_are_even_and_stay() {
        let n = (0..10_000).filter(|i| draw(7, &format!("v{i}")) < 0.1).count();
        // Binomial with mean 1000 and deviation 30.
        assert!((850..1150).contains(&n), "{n}");
        assert_eq!(draw(7, "v1"), draw(7, "v1"));
        assert_ne!(draw(7, "v1"), draw(8, "v1"));
    }
}
