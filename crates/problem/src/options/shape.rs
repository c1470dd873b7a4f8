//! Text of a shape in the record of a run.

use gfmd_surface::Shape;
use serde::{Deserialize, Deserializer, Serializer, de::Error};

/// Writes the text of a shape.
///
/// # Errors
/// Returns an error of the serialiser.
pub(super) fn serialize<S: Serializer>(shape: &Option<Shape>, serializer: S) -> Result<S::Ok, S::Error> {
    match shape {
        Some(shape) => serializer.collect_str(shape),
        None => serializer.serialize_none(),
    }
}

/// Reads the text of a shape.
///
/// # Errors
/// Returns an error for a text that is no shape.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Shape>, D::Error> {
    let text = Option::<String>::deserialize(deserializer)?;
    text.map(|text| text.parse().map_err(D::Error::custom)).transpose()
}
