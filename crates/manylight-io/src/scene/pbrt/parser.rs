//! From tokens to statements: one directive with its arguments.

use super::super::sink::{FileSpan, Problem, Sink, Text};
use super::directives::{Form, form_of, similar_directive};
use super::lexer::{Lexer, Token, TokenKind};
use super::param_types::{Param, ParamType, TYPE_NAMES, Values};
use crate::suggest::one_of;

/// A directive with its location.
#[derive(Debug)]
pub(super) struct Statement {
    pub(super) directive: Text,
    pub(super) arguments: Arguments,
}

/// Arguments of a directive.
#[derive(Debug)]
pub(super) enum Arguments {
    None,
    /// Numbers, in brackets or not.
    Numbers(Vec<f64>),
    /// One or two quoted names.
    Names(Vec<Text>),
    /// A word, as of `ActiveTransform`.
    Word(Text),
    /// A name and parameters.
    Declaration(Text, Vec<Param>),
    /// Name, type, class and parameters of a texture.
    Texture([Text; 3], Vec<Param>),
    /// The parameter of `Option`.
    Option(Param),
}

/// Reads the statements of one file.
pub(super) struct Parser {
    lexer: Lexer,
    /// A token that has been read ahead.
    ahead: Option<Token>,
}

impl Parser {
    pub(super) fn new(lexer: Lexer) -> Self {
        Parser { lexer, ahead: None }
    }

    /// The next statement; `None` at the end of the file. Broken statements are reported and
    /// skipped.
    pub(super) fn next(&mut self, sink: &Sink) -> Option<Statement> {
        loop {
            match self.statement() {
                Ok(statement) => return statement,
                Err(problem) => sink.error(*problem),
            }
            if !self.recover() {
                return None;
            }
        }
    }

    /// Skips to the next word with a capital, which may be a directive. `false` at the end of the
    /// file, or where the text has no tokens.
    fn recover(&mut self) -> bool {
        while let Ok(Some(token)) = self.token() {
            let is_capital = |text: &str| text.starts_with(|c: char| c.is_ascii_uppercase());
            if token.kind == TokenKind::Word && is_capital(self.lexer.text(token.span)) {
                self.ahead = Some(token);
                return true;
            }
        }
        false
    }

    fn token(&mut self) -> Parsed<Option<Token>> {
        match self.ahead.take() {
            Some(token) => Ok(Some(token)),
            None => self.lexer.next(),
        }
    }

    /// The next token, which `expected` describes.
    fn expect(&mut self, expected: &str) -> Parsed<Token> {
        match self.token()? {
            Some(token) => Ok(token),
            None => {
                let message = format!("found the end of the file, expected {expected}");
                Err(problem(self.lexer.end(), message))
            }
        }
    }

    fn text(&self, token: Token) -> Text {
        let value = match token.kind {
            TokenKind::Quoted => self.lexer.unquoted(token.span),
            _ => self.lexer.text(token.span).to_owned(),
        };
        Text {
            value,
            span: token.span,
        }
    }

    /// The error that `token` is not what was expected.
    fn unexpected(&mut self, token: Token, expected: &str) -> Box<Problem> {
        const LONGEST: usize = 40;
        let found: String = self.lexer.text(token.span).chars().take(LONGEST).collect();
        // The next statement may start here.
        self.ahead = Some(token);
        problem(token.span, format!("found `{found}`, expected {expected}"))
    }

    fn statement(&mut self) -> Parsed<Option<Statement>> {
        let Some(token) = self.token()? else {
            return Ok(None);
        };
        let directive = self.text(token);
        let known = form_of(&directive.value).filter(|_| token.kind == TokenKind::Word);
        let Some(form) = known else {
            return Err(unknown_directive(&directive, token.kind));
        };
        let arguments = self.arguments(form)?;
        Ok(Some(Statement {
            directive,
            arguments,
        }))
    }

    fn arguments(&mut self, form: Form) -> Parsed<Arguments> {
        Ok(match form {
            Form::None => Arguments::None,
            Form::Numbers(count) => Arguments::Numbers(self.numbers(count)?),
            Form::Names { least, most } => {
                let mut names = Vec::new();
                while names.len() < least {
                    names.push(self.quoted("a name in quotes")?);
                }
                while names.len() < most && self.is_ahead(TokenKind::Quoted)? {
                    names.push(self.quoted("a name in quotes")?);
                }
                Arguments::Names(names)
            }
            Form::Word => {
                let token = self.expect("a word")?;
                Arguments::Word(self.text(token))
            }
            Form::Declaration => {
                let name = self.quoted("a type in quotes")?;
                Arguments::Declaration(name, self.parameters()?)
            }
            Form::Texture => {
                let names = [
                    self.quoted("the name of the texture in quotes")?,
                    self.quoted("`\"float\"` or `\"spectrum\"`")?,
                    self.quoted("a type in quotes")?,
                ];
                Arguments::Texture(names, self.parameters()?)
            }
            Form::Option => {
                let declaration = self.quoted("a parameter such as \"bool disablepixeljitter\"")?;
                Arguments::Option(self.parameter(&declaration)?)
            }
        })
    }

    fn is_ahead(&mut self, kind: TokenKind) -> Parsed<bool> {
        self.ahead = self.token()?;
        Ok(self.ahead.is_some_and(|token| token.kind == kind))
    }

    fn quoted(&mut self, expected: &str) -> Parsed<Text> {
        let token = self.expect(expected)?;
        match token.kind {
            TokenKind::Quoted => Ok(self.text(token)),
            // A name in brackets.
            TokenKind::Open => {
                let name = self.expect(expected)?;
                if name.kind != TokenKind::Quoted {
                    return Err(self.unexpected(name, expected));
                }
                let name = self.text(name);
                let close = self.expect("`]`")?;
                match close.kind {
                    TokenKind::Close => Ok(name),
                    _ => Err(self.unexpected(close, "`]`")),
                }
            }
            _ => Err(self.unexpected(token, expected)),
        }
    }

    /// `count` numbers, in brackets or not.
    fn numbers(&mut self, count: usize) -> Parsed<Vec<f64>> {
        let expected = format!("{count} numbers");
        let brackets = self.is_ahead(TokenKind::Open)?;
        if brackets {
            self.ahead = None;
        }
        let mut numbers = Vec::with_capacity(count);
        while numbers.len() < count {
            let token = self.expect(&expected)?;
            match token.kind {
                TokenKind::Number(value) => numbers.push(value),
                _ => return Err(self.unexpected(token, &expected)),
            }
        }
        if brackets {
            let token = self.expect("`]`")?;
            if token.kind != TokenKind::Close {
                return Err(self.unexpected(token, &format!("`]` after {count} numbers")));
            }
        }
        Ok(numbers)
    }

    fn parameters(&mut self) -> Parsed<Vec<Param>> {
        let mut parameters: Vec<Param> = Vec::new();
        while self.is_ahead(TokenKind::Quoted)? {
            let declaration = self.quoted("a parameter")?;
            let parameter = self.parameter(&declaration)?;
            let name = &parameter.name.value;
            if let Some(first) = parameters.iter().find(|other| other.name.value == *name) {
                let message = format!("the parameter `{name}` is given twice");
                let span = parameter.name.span;
                let twice = Problem::new("scene::duplicate_parameter", span, message);
                let twice = twice.label("second value");
                return Err(Box::new(twice.second(first.name.span, "first value")));
            }
            parameters.push(parameter);
        }
        Ok(parameters)
    }

    /// The parameter with the declaration "type name".
    fn parameter(&mut self, declaration: &Text) -> Parsed<Param> {
        let words: Vec<&str> = declaration.value.split_ascii_whitespace().collect();
        let [ty, name] = words[..] else {
            let message = format!(
                "found `\"{}\"`, expected type and name of a parameter, such as \"float radius\"",
                declaration.value
            );
            return Err(problem(declaration.span, message));
        };
        let Some((_, ty)) = TYPE_NAMES.iter().find(|(known, _)| *known == ty) else {
            return Err(unknown_type(ty, declaration.span));
        };
        let name = Text {
            value: name.to_owned(),
            span: declaration.span,
        };
        let (values, span) = self.values(*ty)?;
        check_count(*ty, &name, &values, span)?;
        Ok(Param {
            ty: *ty,
            name,
            values,
            span,
        })
    }

    /// One value, or a list in brackets.
    fn values(&mut self, ty: ParamType) -> Parsed<(Values, FileSpan)> {
        let expected = expected_value(ty);
        let first = self.expect(expected)?;
        let mut values = match (ty, first.kind) {
            (ParamType::Integer, _) => Values::Integers(Vec::new()),
            (ParamType::Bool, _) => Values::Bools(Vec::new()),
            (ParamType::String | ParamType::Texture, _) => Values::Strings(Vec::new()),
            (ParamType::Spectrum, TokenKind::Quoted) => Values::Strings(Vec::new()),
            _ => Values::Numbers(Vec::new()),
        };
        if first.kind != TokenKind::Open {
            self.push(&mut values, first, expected)?;
            return Ok((values, first.span));
        }
        loop {
            let token = self.expect("`]`")?;
            if token.kind == TokenKind::Close {
                let span = FileSpan {
                    end: token.span.end,
                    ..first.span
                };
                return Ok((values, span));
            }
            if ty == ParamType::Spectrum && values.len() == 0 && token.kind == TokenKind::Quoted {
                values = Values::Strings(Vec::new());
            }
            self.push(&mut values, token, expected)?;
        }
    }

    #[inline]
    fn push(&mut self, values: &mut Values, token: Token, expected: &str) -> Parsed<()> {
        match (values, token.kind) {
            (Values::Numbers(list), TokenKind::Number(value)) => list.push(value as f32),
            (Values::Integers(list), TokenKind::Number(value))
                if value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX) =>
            {
                list.push(value as i32)
            }
            (Values::Strings(list), TokenKind::Quoted) => list.push(self.text(token)),
            (Values::Bools(list), TokenKind::Word | TokenKind::Quoted) => {
                match self.text(token).value.as_str() {
                    "true" => list.push(true),
                    "false" => list.push(false),
                    _ => return Err(self.unexpected(token, expected)),
                }
            }
            _ => return Err(self.unexpected(token, expected)),
        }
        Ok(())
    }
}

/// A result of parsing. Problems are boxed because they are large and rare.
type Parsed<T> = Result<T, Box<Problem>>;

fn problem(span: FileSpan, message: String) -> Box<Problem> {
    Box::new(Problem::new("scene::syntax", span, message))
}

/// What a value of the type looks like.
fn expected_value(ty: ParamType) -> &'static str {
    match ty {
        ParamType::Integer => "an integer",
        ParamType::Bool => "`true` or `false`",
        ParamType::String => "a string in quotes",
        ParamType::Texture => "the name of a texture in quotes",
        ParamType::Spectrum => "a name in quotes or pairs of wavelength and value",
        _ => "a number",
    }
}

/// Checks that a list has whole elements.
fn check_count(ty: ParamType, name: &Text, values: &Values, span: FileSpan) -> Parsed<()> {
    let arity = ty.arity();
    if values.len().is_multiple_of(arity) {
        return Ok(());
    }
    let message = format!(
        "`{}` has {} numbers, expected a multiple of {arity} for the type `{}`",
        name.value,
        values.len(),
        ty.name()
    );
    Err(Box::new(Problem::new("scene::bad_value", span, message)))
}

fn unknown_type(found: &str, span: FileSpan) -> Box<Problem> {
    let help = one_of(found, TYPE_NAMES.iter().map(|(name, _)| *name));
    let message = format!("unknown type `{found}` of a parameter");
    Box::new(Problem::new("scene::unknown_type", span, message).help(help))
}

fn unknown_directive(found: &Text, kind: TokenKind) -> Box<Problem> {
    let text: String = found.value.chars().take(40).collect();
    let message = match kind {
        TokenKind::Word => format!("unknown directive `{text}`"),
        _ => format!("found `{text}`, expected a directive such as `Shape`"),
    };
    let problem = Problem::new("scene::unknown_directive", found.span, message);
    Box::new(problem.maybe_help(similar_directive(&text)))
}
