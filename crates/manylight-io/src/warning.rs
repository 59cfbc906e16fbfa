//! Warnings of a scene that loads.

use crate::error::{Diagnostic, Location, delegate_diagnostic};
use std::fmt;

/// A part of a scene file that is ignored or replaced. `Display` gives `path:line:column: message`.
#[derive(Clone, Debug)]
pub struct Warning {
    diagnostic: Box<Diagnostic>,
}

impl Warning {
    /// Severity, class, message, location and help.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.diagnostic
    }

    /// What was found and what is done instead.
    pub fn message(&self) -> &str {
        &self.diagnostic.message
    }

    /// Where it was found; `None` if it concerns no single place of a file.
    pub fn location(&self) -> Option<&Location> {
        self.diagnostic.location.as_ref()
    }
}

impl From<Diagnostic> for Warning {
    fn from(diagnostic: Diagnostic) -> Self {
        Warning {
            diagnostic: Box::new(diagnostic),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = self.location() {
            write!(f, "{location}: ")?;
        }
        f.write_str(self.message())
    }
}

impl std::error::Error for Warning {}

delegate_diagnostic!(Warning, diagnostic);
