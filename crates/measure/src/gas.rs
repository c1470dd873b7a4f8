//! Conductance of a gas in the gap between two surfaces (theory.md, section 7.6).

use std::f64::consts::PI;
use std::fmt;
use std::ops::Range;

use gfmd_vector::{Share, contiguous};
use ndarray::ArrayView2;

use crate::ShapesDiffer;

/// Molar gas constant, J/(mol K) (SI, exact).
const MOLAR_GAS_CONSTANT: f64 = 8.314_462_618_153_24;

/// Reference temperature of the Sutherland laws, K (White, Viscous Fluid Flow, 3rd ed. 2006, Tables 1-2 and 1-3).
const REFERENCE: f64 = 273.0;

/// Heat conduction of a gas between two surfaces at a distance g: the conductance per area k/(g + M).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapGas {
    /// Thermal conductivity k of the gas, stress × length² / (time × temperature); W/(m K) in SI.
    pub conductivity: f64,
    /// Temperature-jump length M of both surfaces together, length: the gap that would conduct as badly as the gas
    /// next to the surfaces does (Kennard, Kinetic Theory of Gases, 1938, section 168).
    pub jump: f64,
}

impl GapGas {
    /// Returns the conductance per area of the gas in the gap, the mean of k/(g + M) over all points: W/(m² K) in SI.
    /// Points with a positive `pressure` touch and contribute nothing. Heat crosses the gap along its height, which is
    /// valid for small slopes; radiation is left out. Both fields are `[x, y]`, the gap is a length; a negative gap
    /// without pressure counts as zero. The sum has the same bits for any number of threads.
    ///
    /// Source: Yovanovich, in Spacecraft Radiative Transfer and Temperature Control, AIAA 1982, p. 83, with the mean
    /// over the points in place of the mean over a Gaussian distribution of heights.
    ///
    /// # Errors
    /// Returns an error if the shapes differ.
    pub fn conductance(&self, pressure: ArrayView2<f64>, gap: ArrayView2<f64>) -> Result<f64, ShapesDiffer> {
        let (rows, columns) = gap.dim();
        self.conductance_over(&Share::whole(rows, columns), pressure, gap)
    }

    /// Returns the conductance as [`conductance`](Self::conductance), from the rows of each process.
    ///
    /// # Errors
    /// Returns an error if the shapes differ.
    pub fn conductance_over(
        &self,
        share: &Share,
        pressure: ArrayView2<f64>,
        gap: ArrayView2<f64>,
    ) -> Result<f64, ShapesDiffer> {
        if pressure.dim() != gap.dim() {
            let [pressure, other] = [pressure.dim(), gap.dim()].map(<[usize; 2]>::from);
            return Err(ShapesDiffer { pressure, other });
        }
        let (pressure, gap) = (&*contiguous(&pressure), &*contiguous(&gap));
        let of_range = |range: Range<usize>| {
            pressure[range.clone()].iter().zip(&gap[range]).fold(0.0, |sum, (pressure, gap)| {
                let gap = if *gap < 0.0 { 0.0 } else { *gap };
                if *pressure > 0.0 { sum } else { sum + 1.0 / (gap + self.jump) }
            })
        };
        Ok(self.conductivity * share.sum(&of_range) / share.total().max(1) as f64)
    }
}

/// Gas with known properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gas {
    /// Dry air.
    Air,
    /// Nitrogen.
    Nitrogen,
    /// Argon.
    Argon,
    /// Helium.
    Helium,
    /// Hydrogen.
    Hydrogen,
}

/// Properties of a gas at low density.
struct Properties {
    /// Molar mass, kg/mol: abridged standard atomic weights (Prohaska et al., Pure Appl. Chem. 94 (2022) 573); dry air
    /// from Picard et al., Metrologia 45 (2008) 149.
    molar_mass: f64,
    /// Molecule of two atoms, whose heat capacity is (7/2) R as for a rigid molecule; (5/2) R for single atoms.
    diatomic: bool,
    conductivity: TemperatureLaw,
    viscosity: TemperatureLaw,
}

/// Dependence of a transport coefficient on the temperature, SI.
enum TemperatureLaw {
    /// Sutherland's law: the value at 273 K, and the Sutherland temperature in K.
    Sutherland(f64, f64),
    /// Power law: the value at 1 K, and the exponent.
    Power(f64, f64),
}

impl TemperatureLaw {
    fn at(&self, temperature: f64) -> f64 {
        match *self {
            Self::Sutherland(value, s) => {
                value * (temperature / REFERENCE).powf(1.5) * (REFERENCE + s) / (temperature + s)
            }
            Self::Power(value, exponent) => value * temperature.powf(exponent),
        }
    }
}

impl Gas {
    /// All gases.
    pub const ALL: [Self; 5] = [Self::Air, Self::Nitrogen, Self::Argon, Self::Helium, Self::Hydrogen];

    /// Temperatures with known properties, K. The laws of the properties hold at least to 1000 K.
    pub const TEMPERATURES: Range<f64> = 200.0..1000.0;

    /// Largest pressure, Pa, up to which properties at low density are used.
    pub const LARGEST_PRESSURE: f64 = 1e6;

    /// Temperature of a gas whose temperature is not given, K.
    pub const TEMPERATURE: f64 = 300.0;

    /// Pressure of a gas whose pressure is not given, Pa: the standard atmosphere.
    pub const PRESSURE: f64 = 101_325.0;

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::Nitrogen => "nitrogen",
            Self::Argon => "argon",
            Self::Helium => "helium",
            Self::Hydrogen => "hydrogen",
        }
    }

    /// Returns the description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Air => "dry air",
            Self::Nitrogen => "nitrogen, N2",
            Self::Argon => "argon, Ar",
            Self::Helium => "helium, He",
            Self::Hydrogen => "hydrogen, H2",
        }
    }

    /// Returns the properties. Sutherland constants of conductivity and viscosity: White, Viscous Fluid Flow, 3rd ed.
    /// 2006, Tables 1-3 and 1-2. Helium: Petersen, Risø Report 224 (1970), at low pressure.
    fn properties(self) -> Properties {
        use TemperatureLaw::{Power, Sutherland};
        let (molar_mass, diatomic, conductivity, viscosity) = match self {
            Self::Air => (28.965e-3, true, Sutherland(0.0241, 194.0), Sutherland(1.716e-5, 111.0)),
            Self::Nitrogen => (28.014e-3, true, Sutherland(0.0242, 150.0), Sutherland(1.663e-5, 107.0)),
            Self::Argon => (39.95e-3, false, Sutherland(0.0163, 170.0), Sutherland(2.125e-5, 144.0)),
            Self::Helium => (4.0026e-3, false, Power(2.682e-3, 0.71), Power(3.674e-7, 0.7)),
            Self::Hydrogen => (2.016e-3, true, Sutherland(0.168, 120.0), Sutherland(8.411e-6, 97.0)),
        };
        Properties { molar_mass, diatomic, conductivity, viscosity }
    }

    /// Returns the thermal conductivity in W/(m K) at a temperature in K.
    pub fn conductivity(self, temperature: f64) -> f64 {
        self.properties().conductivity.at(temperature)
    }

    /// Returns the viscosity in Pa s at a temperature in K.
    pub fn viscosity(self, temperature: f64) -> f64 {
        self.properties().viscosity.at(temperature)
    }

    /// Returns the mean free path in m at a temperature in K and a pressure in Pa, from the viscosity:
    /// Λ = (η/p) √(π R T/(2 m)), with the molar mass m (Kennard, Kinetic Theory of Gases, 1938, section 78, with
    /// η = ρ c̄ Λ/2).
    pub fn mean_free_path(self, temperature: f64, pressure: f64) -> f64 {
        let mass = self.properties().molar_mass;
        self.viscosity(temperature) / pressure * (PI * MOLAR_GAS_CONSTANT * temperature / (2.0 * mass)).sqrt()
    }

    /// Returns the share of the temperature difference that a molecule gives up when it hits a surface, if none is
    /// given: the correlation of Song and Yovanovich for engineering surfaces at 273 K, m*/(m* + 6.8 g/mol), where m*
    /// is the molar mass, 1.4 times of it for two atoms (ASME HTD 69 (1987) 107). At other temperatures it depends on
    /// the solid.
    pub fn accommodation(self) -> f64 {
        let Properties { molar_mass, diatomic, .. } = self.properties();
        let mass = if diatomic { 1.4 * molar_mass } else { molar_mass };
        mass / (mass + 6.8e-3)
    }

    /// Returns the heat conduction of the gas in SI, at a temperature in K and a pressure in Pa, between surfaces with
    /// these accommodation coefficients: M = α β Λ, with α = Σ (2 − aᵢ)/aᵢ, β = 2γ/(Pr (γ + 1)), the ratio γ of heat
    /// capacities and the Prandtl number Pr (Kennard, Kinetic Theory of Gases, 1938, section 168; Yovanovich 1982).
    ///
    /// # Errors
    /// Returns an error for a temperature outside [`TEMPERATURES`](Self::TEMPERATURES), a pressure that is not
    /// positive or exceeds [`LARGEST_PRESSURE`](Self::LARGEST_PRESSURE), and an accommodation coefficient that is not
    /// above 0 and at most 1.
    pub fn between(self, temperature: f64, pressure: f64, accommodation: [f64; 2]) -> Result<GapGas, UnknownGasState> {
        let warmest = Self::TEMPERATURES.end;
        if !(Self::TEMPERATURES.contains(&temperature) || temperature == warmest) {
            return Err(UnknownGasState::Temperature { found: temperature });
        }
        if !(pressure > 0.0 && pressure <= Self::LARGEST_PRESSURE) {
            return Err(UnknownGasState::Pressure { found: pressure });
        }
        if let Some(found) = accommodation.into_iter().find(|a| !(*a > 0.0 && *a <= 1.0)) {
            return Err(UnknownGasState::Accommodation { found });
        }
        let Properties { molar_mass, diatomic, .. } = self.properties();
        let gamma = if diatomic { 7.0 / 5.0 } else { 5.0 / 3.0 };
        let heat_capacity = gamma / (gamma - 1.0) * MOLAR_GAS_CONSTANT / molar_mass;
        let conductivity = self.conductivity(temperature);
        let prandtl = self.viscosity(temperature) * heat_capacity / conductivity;
        let alpha: f64 = accommodation.into_iter().map(|a| (2.0 - a) / a).sum();
        let beta = 2.0 * gamma / (prandtl * (gamma + 1.0));
        Ok(GapGas { conductivity, jump: alpha * beta * self.mean_free_path(temperature, pressure) })
    }
}

impl fmt::Display for Gas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error for a state of a gas whose properties are not known.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UnknownGasState {
    /// Temperature, K.
    #[error("the temperature is {found} K; it must be from {} to {} K", Gas::TEMPERATURES.start, Gas::TEMPERATURES.end)]
    Temperature {
        /// Temperature given.
        found: f64,
    },
    /// Pressure, Pa.
    #[error("the pressure is {found} Pa; it must be positive and at most {} Pa", Gas::LARGEST_PRESSURE)]
    Pressure {
        /// Pressure given.
        found: f64,
    },
    /// Accommodation coefficient.
    #[error("an accommodation coefficient is {found}; it must be above 0 and at most 1")]
    Accommodation {
        /// Coefficient given.
        found: f64,
    },
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, array};

    use super::*;

    /// At 300 K and 600 K and 1 atm: reference equations of state and transport (air, nitrogen, argon: Lemmon and
    /// Jacobsen 2004; hydrogen: Assael et al. 2011, Muzny et al. 2013; helium: Hands and Arp 1981), as CoolProp 8 gives
    /// them. White states errors of 2 to 4 % for the laws used here; for the conductivity of hydrogen they grow.
    #[test]
    fn properties_agree_with_reference_equations() {
        for (gas, [cold, hot], [thin, thick], within) in [
            (Gas::Air, [0.026_38, 0.046_01], [1.854e-5, 3.077e-5], 0.02),
            (Gas::Nitrogen, [0.025_97, 0.044_84], [1.789e-5, 2.958e-5], 0.02),
            (Gas::Argon, [0.017_84, 0.030_57], [2.274e-5, 3.900e-5], 0.03),
            (Gas::Helium, [0.155_97, 0.252_4], [1.993e-5, 3.222e-5], 0.02),
            (Gas::Hydrogen, [0.186_7, 0.309_0], [8.938e-6, 1.447e-5], 0.06),
        ] {
            let found = [300.0, 600.0].map(|t| [gas.conductivity(t), gas.viscosity(t)]);
            for (found, wanted) in found.as_flattened().iter().zip([cold, thin, hot, thick]) {
                assert!((found / wanted - 1.0).abs() < within, "{gas}: {found} for {wanted}");
            }
        }
    }

    /// Mean free path of air in the U.S. Standard Atmosphere 1976 at 288.15 K: 66.3 nm, for hard spheres; Yovanovich
    /// (1982) takes 64 nm. The path is proportional to 1/p, and so is M.
    #[test]
    fn the_jump_follows_from_the_mean_free_path() {
        let path = Gas::Air.mean_free_path(288.0, 101_325.0);
        assert!((path / 64e-9 - 1.0).abs() < 0.01, "{path}");
        let at = |pressure, accommodation| Gas::Air.between(288.0, pressure, accommodation).unwrap();
        let full = at(101_325.0, [1.0; 2]);
        // α = 2, and β = 2.8/(0.71 · 2.4) = 1.64 with the Prandtl number of air.
        assert!((full.jump / path / (2.0 * 1.64) - 1.0).abs() < 0.02, "{full:?}");
        assert!((at(101.325, [1.0; 2]).jump / full.jump - 1000.0).abs() < 1e-9);
        assert!((at(101_325.0, [1.0, 0.5]).jump / full.jump - 2.0).abs() < 1e-12);
        assert!((Gas::Air.accommodation() - 0.856).abs() < 1e-3 && (Gas::Helium.accommodation() - 0.37).abs() < 1e-2);
    }

    #[test]
    fn states_without_known_properties_are_refused() {
        let refused = |t, p, a: f64| Gas::Argon.between(t, p, [1.0, a]).unwrap_err().to_string();
        assert_eq!(refused(150.0, 1e5, 1.0), "the temperature is 150 K; it must be from 200 to 1000 K");
        assert_eq!(refused(300.0, 2e6, 1.0), "the pressure is 2000000 Pa; it must be positive and at most 1000000 Pa");
        assert!(refused(f64::NAN, 1e5, 1.0).contains("temperature") && refused(300.0, -1.0, 1.0).contains("pressure"));
        for wrong in [0.0, 1.1, f64::NAN] {
            assert!(refused(300.0, 1e5, wrong).contains("accommodation"));
        }
        assert!(Gas::Argon.between(1000.0, 1e6, [1.0; 2]).is_ok());
    }

    /// A flat gap, limits of a long and a short jump, and points in contact, which leave out their share.
    #[test]
    fn limits_of_the_conductance() {
        let gas = GapGas { conductivity: 0.026, jump: 3e-7 };
        let free = Array2::zeros((8, 4));
        let flat = Array2::from_elem((8, 4), 2e-6);
        let found = gas.conductance(free.view(), flat.view()).unwrap();
        assert!((found / (0.026 / 2.3e-6) - 1.0).abs() < 1e-14);
        let (pressure, gap) = (array![[1.0, 0.0], [0.0, 0.0]], array![[0.0, 1e-6], [0.0, -1e-12]]);
        let of = |jump: f64| GapGas { jump, ..gas }.conductance(pressure.view(), gap.view()).unwrap();
        let wanted = 0.026 * (1.0 / 1.3e-6 + 2.0 / 3e-7) / 4.0;
        assert!((of(3e-7) / wanted - 1.0).abs() < 1e-14);
        assert!((of(1.0) / (0.026 * 0.75) - 1.0).abs() < 1e-6);
        assert!(gas.conductance(free.view(), gap.view()).is_err());
    }
}
