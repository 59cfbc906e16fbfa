//! The `$name` parameters of a scene.

use super::super::super::sink::{FileSpan, Problem, Sink};
use crate::error::LoadErrorKind;
use crate::suggest::{one_of, similar};

/// Where the value of a parameter is defined.
#[derive(PartialEq, Eq)]
enum Definition {
    /// By the caller ([`LoadOptions::defines`](crate::LoadOptions::defines)). `used` is set once
    /// the scene mentions the name.
    Caller { used: bool },
    /// By a `<default>` of the scene.
    Scene,
}

struct Parameter {
    name: String,
    value: String,
    definition: Definition,
}

/// All parameters defined so far. The first definition of a name is valid.
pub(super) struct Parameters {
    parameters: Vec<Parameter>,
}

impl Parameters {
    /// The parameters that the caller defines, as pairs of name and value.
    pub(super) fn from_defines(defines: &[(String, String)]) -> Self {
        let parameters = defines.iter().map(|(name, value)| Parameter {
            name: name.clone(),
            value: value.clone(),
            definition: Definition::Caller { used: false },
        });
        Parameters {
            parameters: parameters.collect(),
        }
    }

    /// A `<default>`: defines the parameter unless it is defined already.
    pub(super) fn add_default(&mut self, name: &str, value: &str) {
        let existing = self.parameters.iter_mut().find(|p| p.name == name);
        match existing {
            Some(parameter) => parameter.mark_used(),
            None => self.parameters.push(Parameter {
                name: name.to_owned(),
                value: value.to_owned(),
                definition: Definition::Scene,
            }),
        }
    }

    /// `text` with each `$name` replaced by its value, where `name` is the longest defined name
    /// that matches. An undefined name is reported at `span`, and `text` is returned unchanged.
    pub(super) fn substitute(&mut self, text: &str, span: FileSpan, sink: &Sink) -> String {
        let mut result = String::new();
        let mut rest = text;
        while let Some(dollar) = rest.find('$') {
            result.push_str(&rest[..dollar]);
            rest = &rest[dollar + 1..];
            let longest = self
                .parameters
                .iter_mut()
                .filter(|parameter| !parameter.name.is_empty() && rest.starts_with(&parameter.name))
                .max_by_key(|parameter| parameter.name.len());
            match longest {
                Some(parameter) => {
                    parameter.mark_used();
                    result.push_str(&parameter.value);
                    rest = &rest[parameter.name.len()..];
                }
                None => {
                    let length = rest
                        .find(|c: char| !c.is_alphanumeric() && c != '_')
                        .unwrap_or(rest.len());
                    self.report_undefined(&rest[..length], span, sink);
                    return text.to_owned();
                }
            }
        }
        result.push_str(rest);
        result
    }

    fn report_undefined(&self, name: &str, span: FileSpan, sink: &Sink) {
        let defined = self.parameters.iter().map(|p| p.name.as_str());
        let help = match similar(name, defined) {
            Some(similar) => format!("did you mean `${similar}`?"),
            None => format!(
                "define it by `-D {name}=...` or `<default name=\"{name}\" value=\"...\"/>`"
            ),
        };
        let message = format!("the parameter `${name}` is not defined");
        let problem = Problem::new("scene::undefined_parameter", span, message);
        sink.error(problem.label("not defined").help(help));
    }

    /// Reports the caller's parameters that the scene does not mention.
    pub(super) fn report_unused(&self, sink: &Sink) {
        let (unused, known): (Vec<_>, Vec<_>) = self
            .parameters
            .iter()
            .partition(|p| p.definition == Definition::Caller { used: false });
        let known: Vec<&str> = known.iter().map(|p| p.name.as_str()).collect();
        for Parameter { name, value, .. } in unused {
            let help = match known.as_slice() {
                [] => "the scene has no parameters".to_owned(),
                known => one_of(name, known.iter().copied()),
            };
            let message = format!("`-D {name}={value}`: the scene does not use `${name}`");
            let code = "scene::unknown_parameter";
            sink.file_error(code, message, Some(help), LoadErrorKind::Scene);
        }
    }
}

impl Parameter {
    fn mark_used(&mut self) {
        if let Definition::Caller { used } = &mut self.definition {
            *used = true;
        }
    }
}
