//! How to reach a language model: the options that `draft`, `judge` and `ask` share, and the text about its cost.

use crate::arguments::not_a_number;
use crate::output::reason::{Reason, reason};
use anyhow::bail;
use std::path::PathBuf;
use std::time::Duration;
use whyroad_chat::client::Key;
use whyroad_chat::{Budget, Client, Price, Settings};
use whyroad_model::{Diagnostic, Lang, ModelSpent};

/// Variable with the name of the model. It may be set for other commands, too, so that it does not ask for `--model`
/// as an option does.
const NAME_VARIABLE: &str = "WHYROAD_MODEL";

/// Options of a model behind an OpenAI-compatible interface; each asks for `--model`, the address.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct ModelArgs {
    /// Name of the model at the endpoint [env: WHYROAD_MODEL] [default: default]
    #[arg(long, value_name = "NAME", requires = "model")]
    model_name: Option<String>,
    /// Environment variable with the endpoint's key; the key itself is never an argument, printed or stored
    #[arg(long, value_name = "VARIABLE", requires = "model")]
    key_env: Option<String>,
    /// Folder in which answers are kept by the content of their request, so that a run can be resumed and repeated
    /// without cost [default: beside the output]
    #[arg(long, value_name = "DIR", requires = "model")]
    cache: Option<PathBuf>,
    /// Time limit of one request, s
    #[arg(long, value_name = "SECONDS", requires = "model", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..=3600))]
    timeout: u64,
    /// Further requests after a time-out, 429 or 5xx
    #[arg(long, value_name = "N", requires = "model", default_value_t = 4)]
    retries: u32,
    /// Maximum number of requests per minute [default: no limit]
    #[arg(long, value_name = "N", requires = "model", value_parser = clap::value_parser!(u32).range(1..))]
    requests_per_minute: Option<u32>,
    /// Maximum number of requests of this run, retries among them [default: no limit]
    #[arg(long, value_name = "N", requires = "model")]
    max_requests: Option<u64>,
    /// Number of tokens, of questions and answers together, from which on no further request is sent; those under way
    /// are finished [default: no limit]
    #[arg(long, value_name = "N", requires = "model")]
    max_tokens: Option<u64>,
    /// Maximum number of tokens of one answer
    #[arg(long, value_name = "N", requires = "model", default_value_t = 2048)]
    max_answer_tokens: u32,
    /// Price of a million tokens of questions, for the cost report
    #[arg(long, value_name = "PRICE", requires_all = ["price_output", "model"], value_parser = price)]
    price_input: Option<f64>,
    /// Price of a million tokens of answers
    #[arg(long, value_name = "PRICE", requires_all = ["price_input", "model"], value_parser = price)]
    price_output: Option<f64>,
}

fn price(text: &str) -> Result<f64, Reason> {
    let value: f64 = text.parse().map_err(|_| not_a_number())?;
    let fits = value.is_finite() && value >= 0.0;
    fits.then_some(value).ok_or_else(|| reason("单价不能小于 0", "a price is 0 or more"))
}

impl ModelArgs {
    /// The client for the endpoint at `url`; answers are kept in `cache` unless `--cache` names another folder.
    pub(crate) fn client(&self, url: &str, cache: PathBuf, lang: Lang) -> anyhow::Result<Client> {
        match Client::new(self.settings(url, cache, lang)?) {
            Ok(client) => Ok(client),
            Err(e) => bail!("{}", e.diagnostic().message(lang)),
        }
    }

    fn name(&self) -> String {
        let of_environment = || std::env::var(NAME_VARIABLE).ok().filter(|name| !name.is_empty());
        self.model_name.clone().or_else(of_environment).unwrap_or_else(|| "default".to_owned())
    }

    /// Settings of that client; an error where the key's variable is unset.
    pub(crate) fn settings(&self, url: &str, cache: PathBuf, lang: Lang) -> anyhow::Result<Settings> {
        let key = match self.key_env.as_deref().map(Key::from_environment).transpose() {
            Ok(key) => key,
            Err(e) => bail!("{}", e.diagnostic().message(lang)),
        };
        let price = self.price_input.zip(self.price_output);
        Ok(Settings {
            key,
            timeout: Duration::from_secs(self.timeout),
            retries: self.retries,
            requests_per_minute: self.requests_per_minute,
            budget: Budget { requests: self.max_requests, tokens: self.max_tokens },
            price: price.map(|(input_per_million, output_per_million)| Price {
                input_per_million,
                output_per_million,
            }),
            cache: Some(self.cache.clone().unwrap_or(cache)),
            max_answer_tokens: self.max_answer_tokens,
            ..Settings::new(url, self.name())
        })
    }
}

/// `drafts.jsonl` to `drafts.answers`.
pub(crate) fn cache_beside(out: &std::path::Path) -> PathBuf {
    out.with_extension("answers")
}

/// The cost, as one line.
pub(crate) fn cost(spent: &ModelSpent, lang: Lang) -> String {
    let ModelSpent { requests, cached, input_tokens, output_tokens, answers_without_count, cost } = *spent;
    let uncounted = match (answers_without_count, lang) {
        (0, _) => String::new(),
        (n, Lang::Zh) => format!("（另有 {n} 个回答未给出令牌数）"),
        (n, Lang::En) => format!(" (and {n} answers without a count)"),
    };
    match lang {
        Lang::Zh => {
            let cost = match cost {
                Some(_) if answers_without_count > 0 && input_tokens + output_tokens == 0 => {
                    "；费用未知".to_owned()
                }
                Some(c) if answers_without_count > 0 => format!("；费用至少 {c:.4}"),
                Some(c) => format!("；费用 {c:.4}"),
                None => String::new(),
            };
            format!(
                "模型：{requests} 次请求，{cached} 个回答来自缓存；令牌 输入 {input_tokens}、输出 {output_tokens}{uncounted}{cost}"
            )
        }
        Lang::En => {
            let cost = match cost {
                Some(_) if answers_without_count > 0 && input_tokens + output_tokens == 0 => {
                    "; cost unknown".to_owned()
                }
                Some(c) if answers_without_count > 0 => format!("; cost at least {c:.4}"),
                Some(c) => format!("; cost {c:.4}"),
                None => String::new(),
            };
            format!(
                "model: {requests} requests, {cached} answers from the cache; tokens: {input_tokens} in, {output_tokens} out{uncounted}{cost}"
            )
        }
    }
}

/// Prints findings to stderr.
pub(crate) fn tell_all(found: &[Diagnostic], lang: Lang) {
    for d in found {
        tell!("{}", crate::output::render_text(d, lang));
    }
}
