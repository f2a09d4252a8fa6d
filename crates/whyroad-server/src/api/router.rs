//! Finds the route of the table for a method and a path, with the values of the path's parameters.

use super::deliver::ALLOW;
use super::openapi::verb_word;
use super::route::{Route, Verb};
use super::table::ROUTES;
use crate::problem::{Answer, Problem};
use axum::http::Method;
use percent_encoding::percent_decode_str;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Routes by path: the routes of one path differ in their verb.
static PATHS: LazyLock<Result<matchit::Router<Vec<&'static Route>>, matchit::InsertError>> =
    LazyLock::new(paths);

fn paths() -> Result<matchit::Router<Vec<&'static Route>>, matchit::InsertError> {
    let mut by_path: BTreeMap<&str, Vec<&'static Route>> = BTreeMap::new();
    for route in ROUTES {
        by_path.entry(route.path).or_default().push(route);
    }
    let mut router = matchit::Router::new();
    by_path.into_iter().try_for_each(|(path, routes)| router.insert(path, routes))?;
    Ok(router)
}

/// The route of a path below the API's root, and the values of its parameters.
pub(super) fn find(method: &Method, path: &str) -> Answer<(&'static Route, BTreeMap<String, String>)> {
    let verb = match method.as_str() {
        "GET" | "HEAD" => Some(Verb::Get),
        "POST" => Some(Verb::Post),
        "PATCH" => Some(Verb::Patch),
        "DELETE" => Some(Verb::Delete),
        _ => None,
    };
    let paths = PATHS.as_ref().map_err(|e| Problem::new(500, "internal", "内部错误", e.to_string()))?;
    let found = paths.at(path).map_err(|_| Problem::missing())?;
    let route = found.value.iter().find(|r| Some(r.verb) == verb);
    let route = route.ok_or_else(|| wrong_method(found.value.iter().map(|r| r.verb)))?;
    if found.params.iter().any(|(_, value)| value.is_empty()) {
        return Err(Problem::missing());
    }
    // A value that is not UTF-8 matches nothing here.
    let decoded = |value: &str| percent_decode_str(value).decode_utf8().map(String::from);
    let params = found.params.iter().map(|(name, value)| Ok((name.to_owned(), decoded(value)?)));
    let params = params.collect::<Result<_, std::str::Utf8Error>>().map_err(|_| Problem::missing())?;
    Ok((route, params))
}

/// The path exists, but not for this method: `verbs` are those that it has.
pub(super) fn wrong_method(verbs: impl IntoIterator<Item = Verb>) -> Problem {
    let mut allowed = Vec::new();
    for verb in verbs {
        allowed.push(verb_word(verb).to_uppercase());
        // Whatever can be read has a header, too.
        allowed.extend((verb == Verb::Get).then(|| "HEAD".to_owned()));
    }
    allowed.sort();
    Problem::new(405, "request.method", "不支持该方法", "this path does not support the method")
        .with(json!({ ALLOW: allowed.join(", ") }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(method: Method, path: &str) -> Result<(&'static str, Vec<String>), u16> {
        find(&method, path).map(|(r, p)| (r.path, p.into_values().collect())).map_err(|p| p.status)
    }

    #[test]
    fn every_route_of_the_table_is_found_under_its_own_path() {
        assert!(paths().is_ok(), "{:?}", paths().err());
        for route in ROUTES {
            let method = verb_word(route.verb).to_uppercase();
            let (there, params) = find(&method.parse().unwrap(), route.path).unwrap();
            assert!(std::ptr::eq(there, route), "{method} {}", route.path);
            assert_eq!(params.len(), route.path.matches('{').count());
        }
    }

    #[test]
    fn parameters_are_decoded_once_and_what_has_no_route_is_refused() {
        let media = |camera: &str| found(Method::GET, &format!("/tasks/t1/media/{camera}/3"));
        let path = "/tasks/{t}/media/{camera}/{index}";
        assert_eq!(media("front"), Ok((path, vec!["front".into(), "3".into(), "t1".into()])));
        assert_eq!(media("a%2Fb%20%E5%89%8D%2541").unwrap().1[0], "a/b 前%41");
        assert_eq!(media("%FF"), Err(404));
        assert_eq!(media(""), Err(404));
        assert_eq!(found(Method::GET, "/tasks/t1/"), Err(404));
        assert_eq!(found(Method::GET, "/tasks"), Err(404));
        assert_eq!(found(Method::POST, "/tasks/t1"), Err(405));
        assert_eq!(found(Method::PUT, "/tasks/t1"), Err(405));
        assert_eq!(found(Method::HEAD, "/healthz"), Ok(("/healthz", vec![])));
    }
}
