//! Elastic body of a configuration, built like the body of a contact.

use gfmd_green::{Body, Height};
use gfmd_problem::options::{BodyArgs, Layer, OtherArgs};
use gfmd_problem::{Unusable, argument};

use super::BodyConfig;
use crate::SweepError;

impl BodyConfig {
    /// Builds the elastic body under a cell of length 1.
    pub(super) fn build(&self) -> Result<Body, SweepError> {
        let Self { young, poisson, height, base, base_young, base_poisson, layers, second_body } = self.clone();
        let second = Layer::of(&second_body);
        if second.is_none() && !second_body.is_empty() {
            return Err(SweepError::Field {
                field: "body.second_body",
                found: format!("{second_body:?}"),
                allowed: "[E, nu] or [E, nu, H]: Young's modulus, Poisson's ratio, height".into(),
            });
        }
        let layer = layers.iter().filter_map(|layer| Layer::of(layer)).collect();
        let others = OtherArgs { base, base_young, base_poisson, layer, second_body: second };
        let options = BodyArgs { young: Some(young), poisson, height, others, ..BodyArgs::default() };
        let body = options.body().and_then(|body| options.others.check_heights(height, &[1.0]).map(|()| body));
        body.map_err(|unusable| SweepError::Body(in_fields(&unusable)))
    }

    /// Returns true if every body is a half-space, or has a top layer at least as high as the cell.
    pub(super) fn is_high(&self) -> bool {
        let second = self.second_body.get(2).map_or(Height::Infinite, |height| Height::Finite(*height));
        [self.height, second].iter().all(|height| match height {
            Height::Infinite => true,
            Height::Finite(height) => *height >= 1.0,
        })
    }
}

/// Returns the error message of the options with the names of the fields.
fn in_fields(unusable: &Unusable) -> String {
    unusable.words().spelled_by(|key, value| {
        let value = value.map_or_else(String::new, |value| format!(" {value}"));
        format!("body.{}{value}", argument(key))
    })
}
