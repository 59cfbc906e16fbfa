//! What of a scene file is left out or replaced although the scene loads.

use crate::error::{Diagnostic, Location, delegate_diagnostic};
use std::fmt;

/// Something of a scene file that is left out or replaced. Its `Display` is `path:line:column: message`.
#[derive(Clone, Debug)]
pub struct Warning {
    diagnostic: Box<Diagnostic>,
}

impl Warning {
    /// The problem.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.diagnostic
    }

    /// What was found and what is done instead.
    pub fn message(&self) -> &str {
        &self.diagnostic.message
    }

    /// Where.
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
