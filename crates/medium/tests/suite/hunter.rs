//! A rigid cylinder sliding on a standard linear solid (Hunter 1961).

use approx::assert_relative_eq;
use gfmd_contact::{Budget, Contact, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_medium::{Prony, Relaxes, SlidingContact, Velocity};
use ndarray::Array2;

/// Contact b − a < x < b + a of a cylinder under the force P per length, and its friction.
struct Cylinder {
    force: f64,
    middle: f64,
    friction: f64,
}

/// Computes e^k K₀, K₁, K₂ at k by the trapezoidal rule; the integrands decay doubly exponentially.
fn decaying(k: f64) -> [f64; 3] {
    let step = 1.0 / 64.0;
    [0.0, 1.0, 2.0].map(|order: f64| {
        let of = |i: i32| {
            let t = step * f64::from(i);
            (-k * (t.cosh() - 1.0)).exp() * (order * t).cosh()
        };
        step * (0.5 * of(0) + (1..1000).map(of).take_while(|value| *value > 0.0).sum::<f64>())
    })
}

/// Computes e^{−k} I₀, I₁, I₂ at k by the trapezoidal rule over a period.
fn growing(k: f64) -> [f64; 3] {
    let n = 64 + (8.0 * k) as i32;
    [0.0, 1.0, 2.0].map(|order: f64| {
        let of = |i: i32| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            (k * (angle.cos() - 1.0)).exp() * (order * angle).cos()
        };
        (0..n).map(of).sum::<f64>() / f64::from(n)
    })
}

impl Cylinder {
    /// Solves for half width a, radius R, E*_∞ = 1 and one branch of weight c and time τ = 1. The equivalent elastic
    /// pressure w satisfies w₀ K₀(k) + w₁ K₁(k) + w₂ K₂(k) = 0 and w₀ I₀(λ) − w₁ I₁(λ) + w₂ I₂(λ) = 0.
    fn new(a: f64, radius: f64, c: f64, speed: f64) -> Self {
        let trail = speed * (1.0 + c);
        let k = a / trail;
        let ([k0, k1, k2], [i0, i1, i2]) = (decaying(k), growing((1.0 + c) * k));
        let w2 = -a / (4.0 * radius);
        let determinant = -k0 * i1 - k1 * i0;
        let w0 = (k2 * w2 * i1 + k1 * i2 * w2) / determinant;
        let w1 = (-k0 * i2 * w2 + i0 * k2 * w2) / determinant;
        let force = std::f64::consts::PI * a * w0;
        let middle = trail - 2.0 * radius * w1;
        let moment = middle * force + std::f64::consts::PI * a * a * w1 / 2.0 - trail / (1.0 + c) * force;
        Self { force, middle, friction: moment / (force * radius) }
    }
}

#[test]
fn the_closed_form_has_known_values() {
    for (speed, force, middle, friction) in [
        (0.03, 0.01009598218, 0.1250791831, 0.002311555806),
        (0.3, 0.03319861910, 0.7604765049, 0.009902930116),
        (3.0, 0.07625420007, 0.5118350684, 0.005490383381),
    ] {
        let found = Cylinder::new(1.0, 100.0, 9.0, speed);
        assert_relative_eq!(found.force, force, max_relative = 1e-9);
        assert_relative_eq!(found.middle, middle, max_relative = 1e-9);
        assert_relative_eq!(found.friction, friction, max_relative = 1e-9);
    }
}

#[test]
fn a_cylinder_in_a_cell_converges_with_the_square_of_its_length() {
    let (radius, speed) = (100.0, 0.3);
    let exact = Cylinder::new(1.0, radius, 9.0, speed);
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.5).unwrap());
    let prony = Prony::from_fractions(&[(1.0, 0.9)]).unwrap();
    let error = |length: f64| {
        let n = (40.0 * length) as usize;
        let grid = Grid::line(n, length).unwrap();
        let place = |i: usize| length * (i as f64 / n as f64 - 0.5);
        let heights = Array2::from_shape_fn((n, 1), |(i, _)| -0.5 * place(i).powi(2) / radius);
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        let contact = SlidingContact::new(contact, &body, &prony, Relaxes::Both).unwrap();
        let (velocity, load) = (Velocity::new(speed, 0.0).unwrap(), Load::MeanPressure(exact.force / length));
        let state = contact.slide(&velocity, load, &Budget::default(), None, &mut ()).unwrap();
        let touching: Vec<f64> = (0..n).filter(|i| state.solution.pressure[[*i, 0]] > 0.0).map(place).collect();
        // The contact is shifted ahead by b.
        let middle = 0.5 * (touching[0] + touching[touching.len() - 1]);
        assert!((middle - exact.middle).abs() < 0.03, "{middle} {}", exact.middle);
        (state.friction / exact.friction - 1.0).abs()
    };
    let errors = [25.0, 50.0, 100.0].map(error);
    let order = (errors[1] / errors[2]).log2();
    assert!(errors[2] < 2e-3 && (1.8..2.3).contains(&order), "order {order}: {errors:?}");
}
