//! Who may see the page: those who know its token, from this machine.

use axum::extract::Request;
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Number of random bytes in a token.
const TOKEN_BYTES: usize = 16;

/// Names of this machine in the `Host` header. Another name there means that the name of a foreign
/// page leads to this machine (DNS rebinding). Ports do not matter: a tunnel may change them.
const HOSTS: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];

/// A random part of the address of a page, in hexadecimal digits.
///
/// # Errors
/// The system has no random numbers.
pub(super) fn token() -> Result<String, getrandom::Error> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Refuses requests that do not name this machine as their host, and those that a foreign page
/// sends.
pub(super) async fn check_sender(request: Request, next: Next) -> Response {
    if is_this_machine(request.headers()) && is_own_page(request.headers()) {
        next.run(request).await
    } else {
        let text = "The page is only available as http://127.0.0.1 or http://localhost.\n";
        (StatusCode::FORBIDDEN, text).into_response()
    }
}

fn is_this_machine(headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(header::HOST).iter();
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return false;
    };
    host.to_str().is_ok_and(names_this_machine)
}

/// Whether `host`, with or without a port, is this machine.
fn names_this_machine(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    HOSTS.iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// Whether no page of another place sends the request: browsers name that place in the header
/// `Origin`.
fn is_own_page(headers: &HeaderMap) -> bool {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    origins.all(|origin| {
        let (_, host) = match origin.to_str().map(|origin| origin.split_once("://")) {
            Ok(Some(parts)) => parts,
            _ => return false,
        };
        names_this_machine(host)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ() {
        let (a, b) = (token().unwrap(), token().unwrap());
        assert_eq!((a.len(), b.len()), (32, 32));
        assert_ne!(a, b);
    }

    #[test]
    fn foreign_pages() {
        let of = |origin: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ORIGIN, origin.parse().unwrap());
            is_own_page(&headers)
        };
        assert!(is_own_page(&HeaderMap::new()));
        assert!(of("http://127.0.0.1:80") && of("http://localhost"));
        for foreign in [
            "null",
            "",
            "http://evil.example",
            "https://127.0.0.1.evil.example",
        ] {
            assert!(!of(foreign), "{foreign}");
        }
    }

    #[test]
    fn hosts_of_this_machine() {
        let of = |hosts: &[&str]| {
            let mut headers = HeaderMap::new();
            for host in hosts {
                headers.append(header::HOST, host.parse().unwrap());
            }
            is_this_machine(&headers)
        };
        for host in [
            "127.0.0.1:80",
            "127.0.0.1",
            "localhost:9",
            "LocalHost",
            "[::1]:7",
            "[::1]",
        ] {
            assert!(of(&[host]), "{host}");
        }
        for host in [
            "evil.example",
            "127.0.0.1.evil.example:80",
            "localhost.",
            "10.0.0.1:80",
            "",
            "[::1",
            "a:b",
        ] {
            assert!(!of(&[host]), "{host}");
        }
        assert!(!of(&[]));
        assert!(!of(&["localhost", "localhost"]));
    }
}
