//! What the client does with time-outs, 429, 500, broken JSON, refusals, wrong keys and used-up budgets.

use crate::scripted::{Reply, Scripted};
use serde_json::json;
use std::time::{Duration, Instant};
use whyroad_chat::client::Key;
use whyroad_chat::{AnswerForm, Budget, ChatError, Client, Message, Price, Request, Role, Settings};

fn request(text: &str) -> Request {
    let schema = json!({
        "type": "object", "properties": { "n": { "type": "integer" } }, "required": ["n"], "additionalProperties": false,
    });
    Request { messages: vec![Message::text(Role::User, text)], form: AnswerForm { name: "number", schema } }
}

fn number(text: &str) -> Result<i64, String> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
    value["n"].as_i64().ok_or_else(|| "n is missing".to_owned())
}

fn settings(endpoint: &Scripted) -> Settings {
    Settings {
        timeout: Duration::from_millis(400),
        backoff: Duration::from_millis(10),
        longest_pause: Duration::from_secs(2),
        ..Settings::new(&endpoint.url, "m")
    }
}

fn says(n: i64) -> Reply {
    Reply::Says(json!({ "n": n }).to_string())
}

#[test]
fn a_time_out_a_429_and_a_500_are_repeated_and_retry_after_is_honored() {
    let endpoint = Scripted::new(|n, _| match n {
        0 => Reply::Hangs(Duration::from_millis(900)),
        1 => Reply::Status(429, Some(1), r#"{"error":{"message":"slow down"}}"#.into()),
        2 => Reply::Status(500, None, "oops".into()),
        3 => Reply::Body("<html>a proxy</html>".into()),
        _ => says(7),
    });
    let client = Client::new(settings(&endpoint)).unwrap();
    let start = Instant::now();
    assert_eq!(client.ask(&request("?"), number).unwrap().value, 7);
    assert!(start.elapsed() >= Duration::from_millis(1400), "0.4 s time-out and 1 s retry-after");
    let spent = client.spent();
    assert_eq!((spent.requests, spent.input_tokens, spent.output_tokens), (5, 100, 20));
    assert_eq!(endpoint.seen()[4].form(), "number");
}

#[test]
fn an_endpoint_that_stays_away_is_given_up_and_a_pause_that_is_too_long_is_not_waited_for() {
    let endpoint =
        Scripted::new(|_, _| Reply::Status(503, None, r#"{"error":{"message":"overloaded"}}"#.into()));
    let client = Client::new(Settings { retries: 2, ..settings(&endpoint) }).unwrap();
    let why = client.ask(&request("?"), number).unwrap_err();
    assert_eq!(why, ChatError::Unavailable { attempts: 3, why: "status 503: overloaded".into() });
    assert!(!why.ends_the_run());
    let patient = Scripted::new(|_, _| Reply::Status(429, Some(3600), String::new()));
    let client = Client::new(settings(&patient)).unwrap();
    let start = Instant::now();
    assert!(matches!(client.ask(&request("?"), number), Err(ChatError::Unavailable { attempts: 1, .. })));
    assert!(start.elapsed() < Duration::from_secs(1));
    let nobody = Client::new(Settings { retries: 1, ..Settings::new("http://127.0.0.1:9/v1", "m") }).unwrap();
    assert!(matches!(nobody.ask(&request("?"), number), Err(ChatError::Unavailable { attempts: 2, .. })));
}

#[test]
fn broken_json_is_asked_for_once_more_and_not_kept() {
    let dir = tempfile::tempdir().unwrap();
    let endpoint = Scripted::new(|n, _| match n {
        0 | 2 | 3 => Reply::Says("{\"n\": 1".into()),
        1 => says(1),
        _ => Reply::Says("{\"m\": 1}".into()),
    });
    let cached = Settings { cache: Some(dir.path().to_owned()), ..settings(&endpoint) };
    let client = Client::new(cached).unwrap();
    assert_eq!(client.ask(&request("a"), number).unwrap().value, 1);
    assert!(matches!(client.ask(&request("b"), number), Err(ChatError::Answer(_))));
    assert_eq!(client.ask(&request("c"), number), Err(ChatError::Answer("n is missing".into())));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn a_refusal_is_reported_and_not_repeated() {
    let endpoint = Scripted::new(|_, _| Reply::Refuses("I cannot help with that".into()));
    let client = Client::new(settings(&endpoint)).unwrap();
    let refused = client.ask(&request("?"), number);
    assert_eq!(refused, Err(ChatError::Refused("I cannot help with that".into())));
    assert_eq!(endpoint.seen().len(), 1);
    assert_eq!(refused.unwrap_err().diagnostic().code, "chat.refused");
    // With a cache, another run does not pay for it again.
    let dir = tempfile::tempdir().unwrap();
    let cached = || Settings { cache: Some(dir.path().to_owned()), ..settings(&endpoint) };
    let refused = ChatError::Refused("I cannot help with that".into());
    for sent in [2, 2] {
        let client = Client::new(cached()).unwrap();
        assert_eq!(client.ask(&request("?"), number), Err(refused.clone()));
        assert_eq!(endpoint.seen().len(), sent);
    }
}

#[test]
fn answers_are_kept_by_content_and_a_second_run_sends_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let endpoint = Scripted::new(|n, _| says(n as i64));
    let cached = || Settings { cache: Some(dir.path().join("a/b")), ..settings(&endpoint) };
    let first = Client::new(cached()).unwrap();
    assert_eq!(["x", "y", "x"].map(|t| first.ask(&request(t), number).unwrap().value), [0, 1, 0]);
    let second =
        Client::new(Settings { budget: Budget { requests: Some(0), tokens: None }, ..cached() }).unwrap();
    assert_eq!(second.ask(&request("y"), number).unwrap().value, 1);
    assert!(second.ask(&request("z"), number).unwrap_err().ends_the_run());
    assert_eq!((second.spent().cached, second.spent().requests), (1, 0));
    // Another model is another question.
    let other = Client::new(Settings { model: "n".into(), ..cached() }).unwrap();
    assert_eq!(other.ask(&request("y"), number).unwrap().value, 2);
    // A file that was damaged is asked for again.
    for file in std::fs::read_dir(dir.path().join("a/b")).unwrap() {
        std::fs::write(file.unwrap().path(), "{").unwrap();
    }
    assert_eq!(first.ask(&request("x"), number).unwrap().value, 3);
}

#[test]
fn the_key_is_sent_and_is_in_no_error_and_no_cache() {
    const SECRET: &str = "sk-very-secret-123";
    let dir = tempfile::tempdir().unwrap();
    let echo = format!(r#"{{"error":{{"message":"Incorrect API key provided: {SECRET}"}}}}"#);
    let endpoint = Scripted::new(move |n, _| match n {
        0 => Reply::Status(401, None, echo.clone()),
        1 => Reply::Status(400, None, echo.clone()),
        2 => Reply::Says(format!("{{\"n\": 1, \"key\": \"{SECRET}\"}}")),
        _ => says(1),
    });
    let cache = Some(dir.path().to_owned());
    let key = Key::new(SECRET);
    let client = Client::new(Settings { key, cache, ..settings(&endpoint) }).unwrap();
    for expected in [401, 400, 200] {
        let why = client.ask(&request("?"), number).unwrap_err();
        assert!(matches!(why, ChatError::Rejected { status, .. } if status == expected), "{why:?}");
        let all = format!("{why} {why:?} {:?}", why.diagnostic());
        assert!(!all.contains("secret"), "{all}");
    }
    assert_eq!(client.ask(&request("?"), number).unwrap().value, 1);
    assert!(endpoint.seen()[3].head.contains(&format!("Bearer {SECRET}")));
    assert!(!format!("{client:?}").contains("secret"));
    for file in std::fs::read_dir(dir.path()).unwrap() {
        let file = file.unwrap();
        let kept = format!("{:?} {}", file.file_name(), std::fs::read_to_string(file.path()).unwrap());
        assert!(!kept.contains("secret"), "{kept}");
    }
}

#[test]
fn a_budget_of_tokens_stops_and_the_cost_is_reported() {
    let endpoint = Scripted::new(|n, _| match n {
        1 => Reply::Body(json!({ "choices": [{ "message": { "content": "{\"n\": 5}" } }] }).to_string()),
        _ => says(5),
    });
    let limited = Settings {
        budget: Budget { requests: None, tokens: Some(130) },
        price: Some(Price { input_per_million: 1.0, output_per_million: 5.0 }),
        ..settings(&endpoint)
    };
    let client = Client::new(limited).unwrap();
    for text in ["a", "b"] {
        assert_eq!(client.ask(&request(text), number).unwrap().value, 5);
    }
    // Nobody knows how many tokens the second one took.
    assert!(matches!(client.ask(&request("c"), number), Err(ChatError::Budget(_))));
    let spent = client.spent();
    // A counted answer of 100 and 20 tokens: (100 x 1 + 20 x 5) / 1e6.
    assert_eq!((spent.input_tokens, spent.output_tokens, spent.answers_without_count), (100, 20, 1));
    assert!((spent.cost.unwrap() - 2e-4).abs() < 1e-12);
}

#[test]
fn requests_of_several_threads_share_the_rate_limit() {
    let endpoint = Scripted::new(|_, _| says(1));
    let client = Client::new(Settings { requests_per_minute: Some(600), ..settings(&endpoint) }).unwrap();
    let start = Instant::now();
    std::thread::scope(|s| {
        for i in 0..4 {
            let client = &client;
            s.spawn(move || client.ask(&request(&i.to_string()), number).unwrap());
        }
    });
    // One each 100 ms.
    assert!(start.elapsed() >= Duration::from_millis(300));
}

#[test]
fn every_code_has_a_page() {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
    for code in whyroad_chat::CODES {
        assert!(docs.join(format!("{code}.md")).is_file(), "docs/diagnostics/{code}.md is missing");
    }
}
