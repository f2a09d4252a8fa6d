//! A request as a handler sees it: the caller, the project or task, the content.

use crate::app::App;
use crate::domain::people::User;
use crate::domain::workflow::Role;
use crate::problem::{Answer, Problem};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A request whose caller has passed the access check.
pub struct Call<'a> {
    /// The service. Shared, because jobs of the store outlive the call.
    pub app: &'a Arc<App>,
    /// The content of the request.
    pub request: &'a Request,
    /// The caller; `None` only on routes for anyone.
    pub caller: Option<User>,
    /// Result of the access check: project, roles, task.
    pub grant: Grant,
    /// Creates the OpenAPI document of all routes.
    pub document: fn() -> String,
}

/// Result of the access check. A handler that writes reads these again inside its own transaction.
#[derive(Clone, Debug, Default)]
pub struct Grant {
    /// Id of the project that the call is about.
    pub project: Option<String>,
    /// The caller's roles there; an admin is lead everywhere.
    pub roles: Vec<Role>,
}

impl Grant {
    /// The project's id.
    pub fn project(&self) -> Answer<&str> {
        self.project.as_deref().ok_or_else(Problem::missing)
    }

    /// True for leads, checkers and auditors.
    pub fn is_staff(&self) -> bool {
        is_staff(&self.roles)
    }
}

/// True for leads, checkers and auditors.
pub fn is_staff(roles: &[Role]) -> bool {
    roles.iter().any(|r| matches!(r, Role::Lead | Role::Checker | Role::Auditor))
}

/// The content of a request, before the caller is identified.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Values of the path's parameters.
    pub params: BTreeMap<String, String>,
    /// Values of the query.
    pub query: BTreeMap<String, String>,
    /// Body.
    pub body: Vec<u8>,
    /// Value of the session cookie.
    pub cookie: Option<String>,
    /// Bearer token.
    pub token: Option<String>,
    /// Value of `x-csrf-token`.
    pub csrf: Option<String>,
    /// Address of the client.
    pub address: String,
    /// Host name and port in the request.
    pub host: String,
}

impl Call<'_> {
    /// The caller.
    pub fn user(&self) -> Answer<&User> {
        self.caller.as_ref().ok_or_else(Problem::sign_in)
    }

    /// A parameter of the path.
    pub fn param(&self, name: &str) -> &str {
        self.request.params.get(name).map_or("", String::as_str)
    }

    /// A parameter of the query; an empty one counts as unset.
    pub fn query(&self, name: &str) -> Option<&str> {
        self.request.query.get(name).map(String::as_str).filter(|v| !v.is_empty())
    }

    /// The body as JSON.
    pub fn body<T: DeserializeOwned>(&self) -> Answer<T> {
        serde_json::from_slice(&self.request.body).map_err(|e| Problem::unreadable(&e))
    }
}
