//! The viewer that a user names: `tev`, `tev:HOST:PORT`, `browser` or `browser:PORT`; and how it
//! warns.

use std::fmt;
use std::net::Ipv6Addr;
use std::str::FromStr;
use std::sync::Arc;
use thiserror::Error;

/// Host where tev listens unless told otherwise.
const TEV_HOST: &str = "127.0.0.1";

/// Port where tev listens unless told otherwise.
const TEV_PORT: u16 = 14158;

/// Takes a warning, from any thread.
pub type Warn = Arc<dyn Fn(String) + Send + Sync>;

/// A viewer of the growing picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PreviewTarget {
    /// The viewer tev, or one with the same protocol.
    Tev(TevAddress),
    /// A page on the loopback interface.
    Browser {
        /// Port of the page; 0 for any free port.
        port: u16,
    },
}

/// Where tev listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TevAddress {
    /// Name or address of the host; an IPv6 address without brackets.
    pub host: String,
    /// TCP port.
    pub port: u16,
}

/// A text that names no viewer.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct TargetError(String);

impl FromStr for PreviewTarget {
    type Err = TargetError;

    fn from_str(text: &str) -> Result<Self, TargetError> {
        let (viewer, rest) = match text.split_once(':') {
            Some((viewer, rest)) => (viewer, Some(rest)),
            None => (text, None),
        };
        match (viewer, rest) {
            ("tev", None) => Ok(PreviewTarget::Tev(TevAddress::default())),
            ("tev", Some(address)) => address.parse().map(PreviewTarget::Tev),
            ("browser", None) => Ok(PreviewTarget::Browser { port: 0 }),
            ("browser", Some(port)) => match port.parse() {
                Ok(port) => Ok(PreviewTarget::Browser { port }),
                Err(_) => Err(TargetError(format!(
                    "`{port}` is not a port; expected browser or browser:PORT with a port from 0 to 65535, 0 for any free one"
                ))),
            },
            _ => Err(TargetError(
                "expected tev, tev:HOST:PORT, browser or browser:PORT".into(),
            )),
        }
    }
}

impl Default for TevAddress {
    fn default() -> Self {
        TevAddress {
            host: TEV_HOST.into(),
            port: TEV_PORT,
        }
    }
}

impl FromStr for TevAddress {
    type Err = TargetError;

    /// `HOST`, `HOST:PORT`, `IPV6`, `[IPV6]` or `[IPV6]:PORT`.
    fn from_str(text: &str) -> Result<Self, TargetError> {
        let (host, port) = split_port(text)?;
        let port = match port {
            None => TEV_PORT,
            Some(port) => match port.parse() {
                Ok(port) if port > 0 => port,
                _ => {
                    return Err(TargetError(format!(
                        "`{port}` is not a port; expected a number from 1 to 65535"
                    )));
                }
            },
        };
        Ok(TevAddress {
            host: host.into(),
            port,
        })
    }
}

/// Host without brackets, and port as given.
fn split_port(text: &str) -> Result<(&str, Option<&str>), TargetError> {
    if let Some(rest) = text.strip_prefix('[') {
        let parts = rest.split_once(']').map(|(host, rest)| match rest {
            "" => (host, Some(None)),
            _ => (host, rest.strip_prefix(':').map(Some)),
        });
        return match parts {
            Some((host, Some(port))) if is_ipv6(host) => Ok((host, port)),
            _ => Err(TargetError(format!(
                "`{text}` is not an address; expected [IPv6 address]:PORT, such as [::1]:{TEV_PORT}"
            ))),
        };
    }
    if is_ipv6(text) {
        return Ok((text, None));
    }
    let (host, port) = match text.split_once(':') {
        Some((host, port)) => (host, Some(port)),
        None => (text, None),
    };
    if port.is_none() && host.parse::<u32>().is_ok() {
        return Err(TargetError(format!(
            "`{host}` is not a host; a port needs its host, such as tev:{TEV_HOST}:{host}"
        )));
    }
    if !is_host_name(host) {
        return Err(TargetError(format!(
            "`{host}` is not a host; expected tev:HOST:PORT, such as tev:{TEV_HOST}:{TEV_PORT}"
        )));
    }
    Ok((host, port))
}

/// An IPv6 address, perhaps with a zone such as `%eth0`.
fn is_ipv6(text: &str) -> bool {
    let (address, zone) = text.split_once('%').unwrap_or((text, "-"));
    address.parse::<Ipv6Addr>().is_ok() && !zone.is_empty()
}

fn is_host_name(text: &str) -> bool {
    let is_part = |part: &str| {
        let known = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        !part.is_empty() && part.len() <= 63 && part.chars().all(known)
    };
    text.strip_suffix('.')
        .unwrap_or(text)
        .split('.')
        .all(is_part)
}

impl fmt::Display for TevAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TevAddress { host, port } = self;
        if host.contains(':') {
            write!(f, "[{host}]:{port}")
        } else {
            write!(f, "{host}:{port}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tev(text: &str) -> Option<(String, u16)> {
        match text.parse() {
            Ok(PreviewTarget::Tev(address)) => Some((address.host, address.port)),
            _ => None,
        }
    }

    #[test]
    fn addresses_of_tev() {
        for (text, host, port) in [
            ("tev", "127.0.0.1", 14158),
            ("tev:10.0.0.7:99", "10.0.0.7", 99),
            (
                "tev:render-01.example.org:14159",
                "render-01.example.org",
                14159,
            ),
            ("tev:localhost", "localhost", 14158),
            ("tev:[::1]:7", "::1", 7),
            ("tev:[fe80::1%eth0]:7", "fe80::1%eth0", 7),
            ("tev:[::1]", "::1", 14158),
            ("tev:2001:db8::7", "2001:db8::7", 14158),
        ] {
            assert_eq!(tev(text), Some((host.into(), port)), "{text}");
        }
    }

    #[test]
    fn an_address_reads_back() {
        for text in ["127.0.0.1:14158", "[::1]:80", "a.b:1"] {
            assert_eq!(text.parse::<TevAddress>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn ports_of_the_browser() {
        for (text, port) in [("browser", 0), ("browser:0", 0), ("browser:8080", 8080)] {
            assert_eq!(text.parse(), Ok(PreviewTarget::Browser { port }));
        }
    }

    #[test]
    fn other_texts_name_what_is_expected() {
        for (text, word) in [
            ("", "tev:HOST:PORT"),
            ("tv", "browser:PORT"),
            ("TEV", "tev"),
            ("tev:", "not a host"),
            ("tev:14158", "tev:127.0.0.1:14158"),
            ("tev:host:", "not a port"),
            ("tev:host:0", "1 to 65535"),
            ("tev:host:65536", "1 to 65535"),
            ("tev:host:1:2", "not a port"),
            ("tev::14158", "not a host"),
            ("tev:a b:1", "not a host"),
            ("tev:http://host:1", "not a port"),
            ("tev:[::1", "[::1]:14158"),
            ("tev:[::1]7", "[::1]:14158"),
            ("tev:[host]:7", "IPv6"),
            ("browser:", "not a port"),
            ("browser:http", "0 to 65535"),
            ("browser:65536", "0 to 65535"),
            ("browser:-1", "0 to 65535"),
            ("browser:127.0.0.1:80", "not a port"),
        ] {
            let error = text.parse::<PreviewTarget>().unwrap_err().to_string();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
