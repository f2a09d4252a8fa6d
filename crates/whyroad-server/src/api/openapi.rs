//! The OpenAPI document (3.1), generated from the table of routes and the request and response types.

use super::route::{Access, Route, Verb};
use crate::domain::people::ProblemBody;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The document.
pub fn document(routes: &[Route]) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.definitions_path = "/components/schemas".into());
    let mut generator = settings.into_generator();
    let problem = generator.subschema_for::<ProblemBody>();
    let mut paths = Map::new();
    for route in routes {
        let mut operation = json!({
            "operationId": operation_id(route),
            "summary": route.about,
            "x-access": route.access.word(),
            "parameters": parameters(route),
            "responses": { "default": { "description": "a refusal", "content": { "application/problem+json": { "schema": problem } } } },
        });
        if route.session_only {
            operation["security"] = json!([{ "session": [] }]);
        }
        if route.access == Access::Anyone {
            operation["security"] = json!([]);
        }
        if let Some(body) = route.body {
            let schema = body(&mut generator);
            operation["requestBody"] =
                json!({ "required": true, "content": { route.body_media: { "schema": schema } } });
        }
        let mut fine = json!({ "description": "done" });
        if let Some(reply) = route.reply {
            fine["content"] = json!({ "application/json": { "schema": reply(&mut generator) } });
        } else if let Some(media) = route.media {
            fine["content"] = json!({ media: { "schema": { "type": "string" } } });
        }
        operation["responses"]["200"] = fine;
        if let Some(meaning) = route.empty {
            operation["responses"]["204"] = json!({ "description": meaning });
        }
        paths.entry(route.path).or_insert_with(|| json!({}))[verb_word(route.verb)] = operation;
    }
    let schemas: Map<String, Value> = generator.take_definitions(true);
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "Whyroad labeling service",
            "version": "1",
            "description": "All methods except GET need the header x-csrf-token (value of GET /session) or a bearer token.",
            "license": { "name": "Apache-2.0", "identifier": "Apache-2.0" },
        },
        "servers": [{ "url": "/api/v1" }],
        "security": [{ "session": [] }, { "token": [] }],
        "paths": paths,
        "components": {
            "schemas": schemas,
            "securitySchemes": {
                "session": { "type": "apiKey", "in": "cookie", "name": "whyroad_session" },
                "token": { "type": "http", "scheme": "bearer" },
            },
        },
    })
}

/// The document as in the file `openapi.json`.
pub fn text(routes: &[Route]) -> String {
    format!("{:#}\n", document(routes))
}

/// The verb in lower case, as in the document.
pub fn verb_word(verb: Verb) -> &'static str {
    match verb {
        Verb::Get => "get",
        Verb::Post => "post",
        Verb::Patch => "patch",
        Verb::Delete => "delete",
    }
}

fn operation_id(route: &Route) -> String {
    let words = route.path.split(['/', ':', '.']).filter(|p| !p.is_empty());
    let words = words.map(|p| p.trim_matches(['{', '}']).to_owned()).collect::<Vec<_>>();
    format!("{}_{}", verb_word(route.verb), words.join("_"))
}

fn parameters(route: &Route) -> Vec<Value> {
    let in_path = route.path.split('/').filter_map(|p| p.strip_prefix('{')?.strip_suffix('}'));
    let in_path = in_path
        .map(|name| json!({ "name": name, "in": "path", "required": true, "schema": { "type": "string" } }));
    let in_query = route.query.iter().map(
        |(name, about)| json!({ "name": name, "in": "query", "description": about, "schema": { "type": "string" } }),
    );
    in_path.chain(in_query).collect()
}
