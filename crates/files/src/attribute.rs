/// Value of an attribute of a group or variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// String.
    Text(String),
    /// Real number.
    Real(f64),
    /// Integer.
    Integer(i64),
    /// Non-negative integer, such as a seed.
    Natural(u64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<u64> for Attribute {
    fn from(number: u64) -> Self {
        Self::Natural(number)
    }
}

impl From<i64> for Attribute {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}
