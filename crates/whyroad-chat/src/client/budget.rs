//! The budget, and what was spent.

use crate::ChatError;
use std::sync::{Mutex, MutexGuard, PoisonError};
use whyroad_model::ModelSpent;

/// The budget; `None` means no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Budget {
    /// Requests, retries among them.
    pub requests: Option<u64>,
    /// Tokens of questions and answers together. A request is sent while the count is below this, and while every
    /// answer has stated its count.
    pub tokens: Option<u64>,
}

/// A budget that is used up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Number of requests.
    Requests(u64),
    /// Number of tokens.
    Tokens(u64),
    /// A number of tokens, of which nobody knows how many are used: the endpoint does not count them.
    Uncounted(u64),
}

/// Prices of a million tokens, in the user's currency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Price {
    /// Of questions.
    pub input_per_million: f64,
    /// Of answers.
    pub output_per_million: f64,
}

/// Tokens as the endpoint counts them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tokens {
    pub input: u64,
    pub output: u64,
}

/// Counts, and decides when to stop.
#[derive(Debug)]
pub(super) struct Ledger {
    budget: Budget,
    price: Option<Price>,
    spent: Mutex<ModelSpent>,
}

impl Ledger {
    pub fn new(budget: Budget, price: Option<Price>) -> Self {
        Self { budget, price, spent: Mutex::default() }
    }

    /// Counts a request that is about to be sent; an error where none may be.
    pub fn take(&self) -> Result<(), ChatError> {
        let mut spent = self.lock();
        if let Some(most) = self.budget.requests.filter(|most| spent.requests >= *most) {
            return Err(ChatError::Budget(Limit::Requests(most)));
        }
        let used = spent.input_tokens.saturating_add(spent.output_tokens);
        if let Some(most) = self.budget.tokens {
            if used >= most {
                return Err(ChatError::Budget(Limit::Tokens(most)));
            }
            if spent.answers_without_count > 0 {
                return Err(ChatError::Budget(Limit::Uncounted(most)));
            }
        }
        spent.requests += 1;
        Ok(())
    }

    /// Counts an answer.
    pub fn add(&self, tokens: Option<Tokens>) {
        let mut spent = self.lock();
        match tokens {
            Some(t) => {
                spent.input_tokens = spent.input_tokens.saturating_add(t.input);
                spent.output_tokens = spent.output_tokens.saturating_add(t.output);
            }
            None => spent.answers_without_count += 1,
        }
    }

    /// Counts an answer from the cache.
    pub fn cached(&self) {
        self.lock().cached += 1;
    }

    pub fn spent(&self) -> ModelSpent {
        let spent = *self.lock();
        let cost = self.price.map(|p| {
            (spent.input_tokens as f64 * p.input_per_million
                + spent.output_tokens as f64 * p.output_per_million)
                / 1e6
        });
        ModelSpent { cost, ..spent }
    }

    fn lock(&self) -> MutexGuard<'_, ModelSpent> {
        self.spent.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_ends_and_a_cost_is_by_the_million() {
        let price = Price { input_per_million: 2.0, output_per_million: 8.0 };
        let ledger = Ledger::new(Budget { requests: Some(3), tokens: Some(100) }, Some(price));
        ledger.take().unwrap();
        ledger.add(Some(Tokens { input: 60, output: 39 }));
        ledger.take().unwrap();
        ledger.add(Some(Tokens { input: 1, output: 0 }));
        assert_eq!(ledger.take(), Err(ChatError::Budget(Limit::Tokens(100))));
        // 61 x 2 + 39 x 8 = 434 millionths.
        assert!((ledger.spent().cost.unwrap() - 434e-6).abs() < 1e-12);
        let few = Ledger::new(Budget { requests: Some(1), tokens: None }, None);
        few.take().unwrap();
        few.add(None);
        assert_eq!(few.take(), Err(ChatError::Budget(Limit::Requests(1))));
        assert_eq!((few.spent().answers_without_count, few.spent().cost), (1, None));
        let blind = Ledger::new(Budget { requests: None, tokens: Some(100) }, None);
        blind.take().unwrap();
        blind.add(None);
        assert_eq!(blind.take(), Err(ChatError::Budget(Limit::Uncounted(100))));
    }
}
