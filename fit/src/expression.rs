//! Expressions of parameters, such as `1.2*friction.stribeck.Fc`.

use std::iter::Peekable;
use std::str::Chars;

use crate::refused::Refused;

/// A parameter that follows from others.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Its name.
    pub name: String,
    /// Its value.
    pub expression: Expression,
}

/// A function of one number, by its name.
type Function = (&'static str, fn(f64) -> f64);
const FUNCTIONS: [Function; 4] = [("sqrt", libm::sqrt), ("exp", libm::exp), ("log", libm::log), ("abs", libm::fabs)];

/// An expression of numbers, names, `+ - * / **`, brackets, and `sqrt`, `exp`, `log` and `abs`, as Python has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// A name, which may have dots and the number of an element.
    Name(String),
    /// The negative of an expression.
    Negative(Box<Expression>),
    /// A function, by its place among them, of an expression.
    Call(usize, Box<Expression>),
    /// Two expressions with an operator between them: one of `+ - * / ^`.
    Both(char, Box<(Expression, Expression)>),
}

/// Why a text is no expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoExpression {
    /// It is written otherwise.
    Other,
    /// It has a function that there is not.
    Unknown(String),
}

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    /// [`NoExpression`].
    pub fn read(text: &str) -> Result<Self, NoExpression> {
        let mut reader = Reader { text: text.chars().peekable() };
        let found = reader.sum()?;
        reader.space();
        if reader.text.peek().is_some() { Err(NoExpression::Other) } else { Ok(found) }
    }

    /// The same, with a refusal in words.
    ///
    /// # Errors
    /// [`Refused`] that names what is wrong.
    pub fn checked(text: &str) -> Result<Self, Refused> {
        Self::read(text).map_err(|why| {
            let wrong = if let NoExpression::Unknown(name) = why { format!("{name}()") } else { text.to_owned() };
            let functions = FUNCTIONS.map(|(name, _)| name).join(", ");
            Refused(format!(
                "{wrong} is refused; an expression has numbers, names, + - * / **, brackets, and {functions}"
            ))
        })
    }

    /// The names in it, each once.
    pub fn names(&self) -> Vec<String> {
        let mut found = Vec::new();
        self.gather(&mut found);
        found
    }

    fn gather(&self, found: &mut Vec<String>) {
        match self {
            Self::Number(_) => {}
            Self::Name(name) if found.contains(name) => {}
            Self::Name(name) => found.push(name.clone()),
            Self::Negative(inner) | Self::Call(_, inner) => inner.gather(found),
            Self::Both(_, both) => {
                both.0.gather(found);
                both.1.gather(found);
            }
        }
    }

    /// Value of the expression for given values of its names; NaN where it is undefined, such as the root of a negative number.
    pub fn value(&self, of: &dyn Fn(&str) -> f64) -> f64 {
        let found = match self {
            Self::Number(number) => *number,
            Self::Name(name) => of(name),
            Self::Negative(inner) => -inner.value(of),
            Self::Call(place, inner) => FUNCTIONS[*place].1(inner.value(of)),
            Self::Both(operator, both) => {
                let (left, right) = (both.0.value(of), both.1.value(of));
                match operator {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    '/' => left / right,
                    _ => libm::pow(left, right),
                }
            }
        };
        if found.is_finite() { found } else { f64::NAN }
    }
}

/// Reads a text from left to right.
struct Reader<'a> {
    text: Peekable<Chars<'a>>,
}

impl Reader<'_> {
    fn space(&mut self) {
        while self.text.next_if(|sign| sign.is_whitespace()).is_some() {}
    }

    /// Takes one of these signs.
    fn one_of(&mut self, signs: &str) -> Option<char> {
        self.space();
        self.text.next_if(|sign| signs.contains(*sign))
    }

    fn sum(&mut self) -> Result<Expression, NoExpression> {
        let mut found = self.product()?;
        while let Some(operator) = self.one_of("+-") {
            found = Expression::Both(operator, Box::new((found, self.product()?)));
        }
        Ok(found)
    }

    fn product(&mut self) -> Result<Expression, NoExpression> {
        let mut found = self.signed()?;
        while let Some(operator) = self.one_of("*/") {
            found = Expression::Both(operator, Box::new((found, self.signed()?)));
        }
        Ok(found)
    }

    fn signed(&mut self) -> Result<Expression, NoExpression> {
        match self.one_of("+-") {
            Some('-') => Ok(Expression::Negative(Box::new(self.signed()?))),
            Some(_) => self.signed(),
            None => self.power(),
        }
    }

    fn power(&mut self) -> Result<Expression, NoExpression> {
        let base = self.single()?;
        self.space();
        let mut ahead = self.text.clone();
        if ahead.next() == Some('*') && ahead.next() == Some('*') {
            self.text = ahead;
            return Ok(Expression::Both('^', Box::new((base, self.signed()?))));
        }
        Ok(base)
    }

    fn single(&mut self) -> Result<Expression, NoExpression> {
        if self.one_of("(").is_some() {
            let found = self.sum()?;
            return self.one_of(")").map(|_| found).ok_or(NoExpression::Other);
        }
        match self.text.peek() {
            Some(sign) if sign.is_ascii_digit() || *sign == '.' => self.number(),
            Some(sign) if sign.is_alphabetic() || *sign == '_' => self.named(),
            _ => Err(NoExpression::Other),
        }
    }

    fn number(&mut self) -> Result<Expression, NoExpression> {
        let mut text = String::new();
        let is_exponent = |text: &str| text.ends_with(['e', 'E']);
        while let Some(sign) = self.text.next_if(|sign| {
            sign.is_ascii_digit() || ".eE".contains(*sign) || ("+-".contains(*sign) && is_exponent(&text))
        }) {
            text.push(sign);
        }
        text.parse().map(Expression::Number).map_err(|_| NoExpression::Other)
    }

    fn named(&mut self) -> Result<Expression, NoExpression> {
        let mut name = String::new();
        while let Some(sign) = self.text.next_if(|sign| sign.is_alphanumeric() || "_.[]".contains(*sign)) {
            name.push(sign);
        }
        if self.one_of("(").is_none() {
            return Ok(Expression::Name(name));
        }
        let inner = self.sum()?;
        self.one_of(")").ok_or(NoExpression::Other)?;
        let place = FUNCTIONS.iter().position(|(known, _)| *known == name);
        place.map(|place| Expression::Call(place, Box::new(inner))).ok_or(NoExpression::Unknown(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let of = |name: &str| if name == "friction.gms.k[2]" { 8.0 } else { 3.0 };
        Expression::read(text).unwrap_or_else(|why| panic!("{text}: {why:?}")).value(&of)
    }

    #[test]
    fn operators_bind_as_in_python() {
        for (text, expected) in [
            ("1 + 2*3", 7.0),
            ("(1+2)*3", 9.0),
            ("-a**2", -9.0),
            ("2**-1", 0.5),
            ("2**3**2", 512.0),
            ("7 - 2 - 1", 4.0),
            ("8/2/2", 2.0),
            ("1.5e+1*friction.gms.k[2]", 120.0),
            ("sqrt(abs(-16.)) + log(exp(2))", 6.0),
        ] {
            assert!((value(text) - expected).abs() < 1e-12 * expected.abs(), "{text} = {}", value(text));
        }
        assert!(value("sqrt(-1)").is_nan() && value("1/(a - 3)").is_nan());
    }

    #[test]
    fn names_are_told_and_what_is_no_expression_is_refused() {
        let read = |text| Expression::read(text);
        assert_eq!(
            read("ratio*b.c + ratio").map(|found| found.names()),
            Ok(vec!["ratio".to_owned(), "b.c".to_owned()])
        );
        for text in ["", "14 N", "1.2:1:3", "a b", "2*", "(a", "1..2*a", "a % 2", "a < b"] {
            assert_eq!(read(text), Err(NoExpression::Other), "{text}");
        }
        assert_eq!(read("2*sin(a)"), Err(NoExpression::Unknown("sin".to_owned())));
        assert!(Expression::checked("sin(a)").is_err_and(|Refused(told)| told.contains("sin()")));
    }
}
