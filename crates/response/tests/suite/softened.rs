//! Point springs on a body.

use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::{FreeCompliance, FreeTransforms, NormalResponse, NormalTransforms};

fn pressure(points: usize) -> Vec<f64> {
    (0..points).map(|i| (0.7 * i as f64).sin() + 0.3 * (2.9 * i as f64).cos()).collect()
}

#[test]
fn springs_add_their_own_displacement_to_that_of_the_body() {
    let (grid, springs) = (Grid::new([12, 10], [1.0, 0.9]).unwrap(), 0.37);
    let p = pressure(120);
    let mean = p.iter().sum::<f64>() / 120.0;
    let material = Material::from_young(2.0, 0.3).unwrap();
    for body in [Body::half_space(material), Body::slab(material, 0.3).unwrap()] {
        let response = Arc::new(NormalResponse::new(grid, &body));
        let softened = Arc::new(response.softened(springs));
        let displaced = |response: &Arc<NormalResponse>| {
            let mut out = vec![0.0; 120];
            NormalTransforms::of(response).convolve(response.compliance(), &p, &mut out);
            out.iter().map(|d| d + response.uniform_compliance() * mean).collect::<Vec<f64>>()
        };
        let sum = displaced(&response).into_iter().zip(&p).map(|(d, p)| d + springs * p);
        assert!(displaced(&softened).iter().zip(sum).all(|(found, sum)| (found - sum).abs() < 1e-13));
        let [softest, stiffest] = response.stiffness_range().map(|k| k / (1.0 + springs * k));
        let [low, high] = softened.stiffness_range();
        assert!((low / softest - 1.0).abs() < 1e-13 && (high / stiffest - 1.0).abs() < 1e-13);

        let free = Arc::new(FreeCompliance::new(grid, &body).unwrap());
        let softened = Arc::new(free.softened(springs));
        let displaced = |free: &Arc<FreeCompliance>| {
            let mut out = vec![0.0; 120];
            FreeTransforms::of(free).apply(&p, &mut out);
            out
        };
        let sum = displaced(&free).into_iter().zip(&p).map(|(d, p)| d + springs * p);
        assert!(displaced(&softened).iter().zip(sum).all(|(found, sum)| (found - sum).abs() < 1e-13));
    }
}
