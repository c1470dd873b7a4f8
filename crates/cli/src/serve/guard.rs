//! Requests that are answered: from the page of this server alone, on this machine.

use oxhttp::model::header::{HOST, ORIGIN};
use oxhttp::model::{Body, Method, Request, StatusCode};

/// Number of random bytes of a token.
const BYTES: usize = 16;

/// Returns a new token.
///
/// # Errors
/// Returns an error if the system has no random numbers.
pub(super) fn token() -> Result<String, getrandom::Error> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Token and names of the server.
pub(super) struct Guard {
    token: String,
    /// Values of `Host` under which the page is reached.
    hosts: [String; 2],
}

impl Guard {
    /// Creates the guard of a server on this port.
    pub(super) fn new(token: &str, port: u16) -> Self {
        Self { token: token.into(), hosts: ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}")) }
    }

    /// Returns the path of a request behind the token.
    ///
    /// # Errors
    /// Returns status and reason of a refusal: another token or host, or a request from a page of another site.
    pub(super) fn admit(&self, request: &Request<Body>) -> Result<String, (StatusCode, &'static str)> {
        let header = |name: &str| request.headers().get(name).map(|value| value.to_str().unwrap_or_default());
        let is_host = |found: &str| self.hosts.iter().any(|host| host == found);
        if !header(HOST.as_str()).is_some_and(is_host) {
            return Err((StatusCode::MISDIRECTED_REQUEST, "the Host is not this server"));
        }
        let (is_read, is_write) = (request.method() == Method::GET, request.method() == Method::POST);
        if !is_read && !is_write {
            return Err((StatusCode::METHOD_NOT_ALLOWED, "the method is neither GET nor POST"));
        }
        let is_own = |found: &str| found.strip_prefix("http://").is_some_and(is_host);
        let site = header("sec-fetch-site").unwrap_or("same-origin");
        let is_near = site == "same-origin" || (is_read && site == "none");
        if !header(ORIGIN.as_str()).is_none_or(is_own) || !is_near {
            return Err((StatusCode::FORBIDDEN, "the request comes from another site"));
        }
        let path = request.uri().path();
        let (token, rest) = path.strip_prefix('/').unwrap_or_default().split_once('/').unwrap_or_default();
        if !is_equal(token.as_bytes(), self.token.as_bytes()) {
            return Err((StatusCode::NOT_FOUND, "the address lacks the token of this server"));
        }
        Ok(rest.to_owned())
    }
}

/// Returns true if two texts are equal, in a time that does not depend on where they differ.
fn is_equal(found: &[u8], expected: &[u8]) -> bool {
    let differ = found.iter().zip(expected).fold(0, |differ, (a, b)| std::hint::black_box(differ | (a ^ b)));
    found.len() == expected.len() && differ == 0
}
