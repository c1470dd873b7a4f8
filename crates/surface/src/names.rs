//! Names of choices on a command line.

/// Implements `ALL`, `name`, `meaning`, `FromStr` and `Display` for an enum without fields.
macro_rules! named {
    ($type:ident, $subject:literal: $($variant:ident = $name:literal, $meaning:literal;)+) => {
        impl $type {
            /// All values.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Returns the name on a command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }

            /// Returns the meaning in one line, for a help text.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$variant => $meaning),+
                }
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::SurfaceError;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                Self::ALL.iter().copied().find(|value| value.name() == name).ok_or_else(|| $crate::SurfaceError::Name {
                    subject: $subject,
                    found: name.into(),
                    allowed: [$($name),+].join(", "),
                })
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}
pub(crate) use named;

#[cfg(test)]
mod tests {
    use crate::{Amplitudes, Displaced, Fill, Periodisation, RollOffShape, Trend};

    #[test]
    fn every_name_leads_back_to_its_value() {
        macro_rules! check {
            ($($type:ident),+) => {$(
                for value in $type::ALL {
                    assert_eq!(value.name().parse(), Ok(*value));
                    assert_eq!(value.to_string(), value.name());
                    assert!(!value.meaning().is_empty());
                }
            )+};
        }
        check!(Amplitudes, Displaced, Fill, Periodisation, RollOffShape, Trend);
    }

    #[test]
    fn unknown_names_are_refused_with_those_allowed() {
        let refused = "cubic".parse::<Trend>().unwrap_err().to_string();
        assert_eq!(refused, "the trend is \"cubic\"; it must be one of mean, plane, slope, quadratic");
    }
}
