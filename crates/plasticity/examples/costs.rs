//! Counts of volume operators and transform pairs per step, memory and time, on a self-affine surface:
//! `cargo run --release -p gfmd-plasticity --example costs -- 64 128 256`.
#![expect(clippy::print_stdout, reason = "the example prints its counts")]

use std::time::Instant;

use gfmd_plasticity::{Body, Budget, Cells, Fields, Grid, Hardening, Load, Material, YieldingContact};
use gfmd_surface::SelfAffine;

/// Returns the largest resident memory of the process, in bytes; zero where it is not known.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok()).map_or(0.0, |kib| 1024.0 * kib)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sizes: Vec<usize> = std::env::args().skip(1).map(|size| size.parse()).collect::<Result<_, _>>()?;
    for points in if sizes.is_empty() { vec![64, 128, 256] } else { sizes } {
        let grid = Grid::square(points, 1.0)?;
        let rough = SelfAffine {
            hurst: 0.8,
            longest_wavelength: 0.5,
            shortest_wavelength: 1.0 / 16.0,
            ..SelfAffine::with_rms_gradient(0.1)
        };
        let heights = rough.heights(&grid, 1)?;
        let body = Body::half_space(Material::from_young(1.0, 0.3)?);
        let hardening = Hardening::new(0.03)?.isotropic(0.02)?;
        let contact = YieldingContact::new(&body, &grid, &heights, &[Some(hardening)], &Cells::default())?;
        let n = (points * points) as f64;
        println!("{points}²: {} cells, {:.2} equivalent", contact.cells().len(), contact.equivalent_cells());
        let mut state = contact.rest()?;
        for pressure in [0.002, 0.005, 0.01, 0.03, 0.0005] {
            let load = Load::MeanPressure(pressure);
            let start = Instant::now();
            let elastic = gfmd_contact::Equilibrium::press(contact.contact(), load).solve()?;
            let of_elastic = start.elapsed().as_secs_f64();
            let start = Instant::now();
            state = contact.step(&state, load, &Budget::default(), &mut ())?;
            let seconds = start.elapsed().as_secs_f64();
            let summary = state.summary();
            println!(
                "  p = {pressure}: area {:.3}, {} operators, {:.0} pairs, {seconds:.2} s, {:.1} elastic contacts, \
                 yielded {:.2} % of the volume, max strain {:.3}, imbalance {:.1e}; elastic: {}",
                summary.area_fraction,
                state.operators,
                state.effort().transform_pairs,
                seconds / of_elastic,
                100.0 * state.yielded_volume() / 0.5,
                state.max_plastic_strain(),
                state.work_imbalance / (pressure * state.approach()),
                elastic.effort,
            );
        }
        println!("  peak memory {:.0} bytes per point of the surface", peak() / n);
    }
    Ok(())
}
