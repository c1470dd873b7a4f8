//! Indentation of aluminium by flat punches of three widths: smaller is harder. Writes indentation.csv, the curves and
//! a picture of the dislocations.
//!
//!     cargo run --release -p gfmd-dislocation --example indentation -- [FOLDER] [SURFACES]
//!
//! Lengths in µm, stresses in GPa, times in ns. Everything scales with the width of the punch except the dislocation
//! quantities: Burgers vector, density and strength of sources and obstacles, and the speed of the punch. Each curve is
//! the mean over several random placements (3, or the second argument).

#![allow(clippy::print_stdout, reason = "the result of the example")]

use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use gfmd_dislocation::{Crystal, Domain, Obstacle, SlipSystem, Source};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const WIDTHS: [f64; 3] = [0.2, 0.4, 0.8];
const POINTS: usize = 135;
const STEPS: usize = 200;
/// Final depth divided by the width.
const DEPTH: f64 = 0.012;
const BURGERS: f64 = 2.5e-4;
/// Distance at which opposite dislocations annihilate.
const CAPTURE: f64 = 20.0 * BURGERS;
/// Numbers of sources and obstacles per µm².
const DENSITY: [f64; 2] = [12.0, 24.0];

fn crystal(width: f64, seed: u64) -> Result<Crystal, Box<dyn Error>> {
    let (length, height) = (4.0 * width, 2.0 * width);
    let body = Body::slab(Material::from_young(70.0, 0.33)?, height)?;
    let grid = Grid::line(POINTS, length)?;
    let held: Vec<bool> = (0..POINTS).map(|i| (i as f64 - 67.0).abs() < 0.125 * POINTS as f64).collect();
    let domain = Domain::new(&body, &grid, &held)?;
    let angle = PI / 3.0;
    // Planes a hundred Burgers vectors apart.
    let count = (length * angle.sin() / (100.0 * BURGERS)) as usize;
    let planes = (0..count).map(|k| (k as f64 + 0.5) * length / count as f64).collect();
    let slip = SlipSystem { angle, burgers: BURGERS, planes, drag: 1e-4, capture: CAPTURE };
    let mut random = Pcg64::seed_from_u64(seed);
    let lowest = -height / angle.sin();
    let mut place = |margin: f64| (random.random_range(0..count), random.random_range(lowest + margin..-margin));
    let sources = (0..(DENSITY[0] * length * height) as usize)
        .map(|number| {
            let (plane, place) = place(0.06);
            // Strengths spread evenly about 50 MPa.
            let strength = 0.05 + 0.02 * ((number as f64 * 0.618_034).fract() - 0.5);
            Source { plane, place, strength, delay: 0.2 }
        })
        .collect::<Vec<_>>();
    let obstacles = (0..(DENSITY[1] * length * height) as usize)
        .map(|_| {
            let (plane, place) = place(0.005);
            Obstacle { plane, place, strength: 0.15 }
        })
        .collect::<Vec<_>>();
    Ok(Crystal::new(domain, slip, &[], &sources, &obstacles)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| ".".into());
    let placings: u64 = arguments.next().map_or(Ok(3), |text| text.parse())?;
    let mut table = String::from("width,depth_over_width,contact_pressure,dislocations\n");
    let mut series = Vec::new();
    let mut last = None;
    for (hue, width) in WIDTHS.into_iter().enumerate() {
        let mut curve = vec![[0.0; 2]; STEPS + 1];
        for seed in 0..placings {
            let mut crystal = crystal(width, seed)?;
            for now in &mut curve[1..] {
                crystal.advance_within(0.5 * width, DEPTH * width / STEPS as f64, 0.5 * CAPTURE)?;
                now[0] += crystal.state().mean_pressure() * 4.0 / placings as f64;
                now[1] += crystal.dislocations().len() as f64 / placings as f64;
            }
            let (balance, events) = (crystal.balance(), crystal.events());
            println!(
                "width {width}: {} dislocations, {events:?}, energy error {:.1e} of the work",
                crystal.dislocations().len(),
                balance.error() / balance.work
            );
            last = Some(crystal);
        }
        for (step, [pressure, dislocations]) in curve.iter().enumerate() {
            writeln!(table, "{width},{},{pressure},{dislocations}", DEPTH * step as f64 / STEPS as f64)?;
        }
        let points = curve.iter().enumerate().map(|(step, now)| (DEPTH * step as f64 / STEPS as f64, now[0]));
        series.push(Series::line(&format!("{width} µm"), hue, points));
        if hue == 0 {
            let slope = curve[1][0] / (DEPTH / STEPS as f64);
            let ends = [0.0, 0.5 * DEPTH].map(|x| Point::new(x, slope * x));
            series.push(Series { label: "elastic".into(), hue: 3, mark: Mark::Dashes, points: ends.to_vec() });
        }
    }
    std::fs::write(Path::new(&folder).join("indentation.csv"), table)?;
    let panel = Panel {
        x: Axis::linear("depth over width"),
        y: Axis::linear("mean pressure below the punch (GPa)"),
        series,
        ..Panel::default()
    };
    Chart::new(vec![panel]).save(&Path::new(&folder).join("indentation"))?;
    if let Some(crystal) = last {
        let place = |sign: f64| {
            let all = crystal.dislocations().iter().zip(crystal.state().edges());
            all.filter(|(d, _)| d.sign == sign)
                .map(|(_, e)| Point::new(e.place[0].rem_euclid(4.0 * WIDTHS[2]), e.place[1]))
                .collect()
        };
        let punch = [1.5, 2.5].map(|x| (x * WIDTHS[2], 0.0));
        let panel = Panel {
            x: Axis::linear("*x* (µm)"),
            y: Axis::linear("*z* (µm)"),
            series: vec![
                Series::points("+", 0, place(1.0)),
                Series::points("−", 1, place(-1.0)),
                Series::line("punch", 2, punch),
            ],
            ..Panel::default()
        };
        Chart::new(vec![panel]).save(&Path::new(&folder).join("dislocations"))?;
    }
    Ok(())
}
