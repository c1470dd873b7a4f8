//! The elastic body of a configuration.

use gfmd_green::{Base, BaseKind, Body, GreenError, Height, Material};

use super::BodyConfig;
use crate::SweepError;

impl BodyConfig {
    /// The elastic body.
    pub(super) fn build(&self) -> Result<Body, SweepError> {
        let Self { young, poisson, height, base, base_young, base_poisson, layers, second_body } = self;
        let material = material(["body.young", "body.poisson"], *young, *poisson)?;
        let of = |field: &'static str| move |source: GreenError| SweepError::Body { field, source };
        let refused = |field: &'static str, found: String, allowed: &str| SweepError::Field {
            field,
            found,
            allowed: allowed.to_owned(),
        };
        const UNUSED: &str = "absent without base = \"half-space\"";
        let below = match (base, base_young, base_poisson) {
            (BaseKind::HalfSpace, Some(young), Some(poisson)) => {
                Some(self::material(["body.base_young", "body.base_poisson"], *young, *poisson)?)
            }
            (BaseKind::HalfSpace, young, _) => {
                let field = if young.is_none() { "body.base_young" } else { "body.base_poisson" };
                return Err(refused(field, "absent".into(), "given with base = \"half-space\""));
            }
            (_, None, None) => None,
            (_, Some(found), _) => return Err(refused("body.base_young", found.to_string(), UNUSED)),
            (_, None, Some(found)) => return Err(refused("body.base_poisson", found.to_string(), UNUSED)),
        };
        let body = match height {
            Height::Infinite => {
                if *base != BaseKind::Bonded {
                    return Err(refused("body.base", base.to_string(), "bonded with height = \"inf\""));
                }
                if let Some(layer) = layers.first() {
                    return Err(refused("body.layers", format!("{layer:?}"), "absent with height = \"inf\""));
                }
                Body::half_space(material)
            }
            Height::Finite(height) => {
                let mut stack = vec![(material, *height)];
                for &[young, poisson, height] in layers {
                    let material = self::material(["body.layers"; 2], young, poisson)?;
                    Body::slab(material, height).map_err(of("body.layers"))?;
                    stack.push((material, height));
                }
                let base: Base = base.with(below).map_err(of("body.base"))?;
                Body::stack(&stack, base).map_err(of("body.height"))?
            }
        };
        let second = match second_body[..] {
            [] => return Ok(body),
            [young, poisson] => (young, poisson, Height::Infinite),
            [young, poisson, height] => (young, poisson, Height::Finite(height)),
            _ => {
                let allowed = "[E, nu] or [E, nu, H]: Young's modulus, Poisson's ratio, height";
                return Err(refused("body.second_body", format!("{second_body:?}"), allowed));
            }
        };
        let material = self::material(["body.second_body"; 2], second.0, second.1)?;
        Ok(body.against(Body::new(material, second.2).map_err(of("body.second_body"))?))
    }

    /// True if every body is a half-space, or its top layer is at least as high as the cell.
    pub(super) fn is_high(&self) -> bool {
        self.heights().next().is_none_or(|(_, height)| height >= 1.0)
            && self.second_body.get(2).is_none_or(|height| *height >= 1.0)
    }

    /// The heights of slabs and layers, from the top down, with their fields.
    pub(super) fn heights(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        let top = if let Height::Finite(height) = self.height { Some(("body.height", height)) } else { None };
        let layers = self.layers.iter().map(|[_, _, height]| ("body.layers", *height));
        top.into_iter().chain(layers)
    }

    /// The moduli of all bodies, with their fields.
    pub(super) fn moduli(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        let below = self.base_young.map(|young| ("body.base_young", young));
        let layers = self.layers.iter().map(|[young, ..]| ("body.layers", *young));
        let second = self.second_body.first().map(|young| ("body.second_body", *young));
        std::iter::once(("body.young", self.young)).chain(below).chain(layers).chain(second)
    }
}

fn material([young_field, poisson_field]: [&'static str; 2], young: f64, poisson: f64) -> Result<Material, SweepError> {
    Material::from_young(young, poisson).map_err(|source| {
        let field = if matches!(source, GreenError::Young(_)) { young_field } else { poisson_field };
        SweepError::Body { field, source }
    })
}
