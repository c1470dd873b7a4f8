//! Responses of the server.

use std::path::Path;

use oxhttp::model::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use oxhttp::model::{Body, HeaderValue, Response, StatusCode};
use serde::Serialize;

/// Rules for the page: scripts, styles and requests of this server alone.
const OWN: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                   connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Rules for the page of a result, which has its style and figures inside and no script.
const RESULT: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// Headers of all responses.
const ALWAYS: [(&str, &str); 5] = [
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
];

/// Returns a response with the headers of all responses.
fn response(status: StatusCode, kind: &'static str, body: Body) -> Response<Body> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(OWN));
    for (name, value) in ALWAYS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Returns a file of the page.
pub(super) fn part(kind: &'static str, text: &'static str) -> Response<Body> {
    response(StatusCode::OK, kind, Body::from(text.as_bytes()))
}

/// Returns numbers of a map.
pub(super) fn bytes(bytes: Vec<u8>) -> Response<Body> {
    response(StatusCode::OK, "application/octet-stream", Body::from(bytes))
}

/// Returns a value as JSON.
pub(super) fn json(value: &impl Serialize) -> Response<Body> {
    match serde_json::to_vec(value) {
        Ok(text) => response(StatusCode::OK, "application/json", Body::from(text)),
        Err(error) => refusal(StatusCode::INTERNAL_SERVER_ERROR, &error.to_string()),
    }
}

/// Returns a message in one line, as JSON.
pub(super) fn refusal(status: StatusCode, message: &str) -> Response<Body> {
    let text = serde_json::json!({ "error": message }).to_string();
    response(status, "application/json", Body::from(text.into_bytes()))
}

/// Returns a file of a result: a page to be shown, or a file to be stored.
pub(super) fn file(path: &Path, is_page: bool) -> Response<Body> {
    let opened = match std::fs::File::open(path) {
        Ok(file) => file,
        Err(error) => return refusal(StatusCode::NOT_FOUND, &error.to_string()),
    };
    let kind = if is_page { "text/html; charset=utf-8" } else { "application/octet-stream" };
    let mut response = response(StatusCode::OK, kind, Body::from_read(opened));
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let place = if is_page { "inline" } else { "attachment" };
    if let Ok(value) = HeaderValue::from_str(&format!("{place}; filename=\"{name}\"")) {
        response.headers_mut().insert(CONTENT_DISPOSITION, value);
    }
    if is_page {
        response.headers_mut().insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(RESULT));
    }
    response
}
