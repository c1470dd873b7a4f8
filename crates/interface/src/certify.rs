use gfmd_vector::{add, pass, reduce, sum};
use ndarray::{Array2, Array3};

use crate::elastic::mean;
use crate::{Drive, Interface, Normal, Residual, State};

/// The state at `position`, the displacement in the frame of the drive: everything from fresh transforms and the law.
pub(crate) fn certify(interface: &Interface, drive: Drive, position: &[f64]) -> State {
    let frame = interface.frame(drive);
    let points = interface.clearance.len();
    let z = interface.elastic.components() - 1;
    let wall = interface.law.has_wall();
    let mut transforms = interface.elastic.transforms();
    let mut traction = vec![0.0; position.len()];
    transforms.stiffness(position, &frame.uniform_stiffness, &mut traction);

    let at = |i: usize| frame.separation(interface, position, i);
    let mut gap = vec![0.0; points];
    let gaps = |start: usize, [gap]: [&mut [f64]; 1]| {
        gap.iter_mut().enumerate().fold(f64::INFINITY, |least, (k, gap)| {
            *gap = at(start + k).0;
            least.min(*gap)
        })
    };
    let lowest = pass([&mut gap], &gaps, &f64::min);

    // What the law does not balance: the wall must, and may on the points that touch it. A component whose mean is held has
    // an unknown mean traction besides, the one with which its free points are at rest.
    let mut wall_pressure = vec![0.0; points];
    let [mut unbalanced, mut tension, mut largest] = [0.0_f64; 3];
    let mut law_means = [0.0; 3];
    for (c, traction) in traction.chunks_exact_mut(points).enumerate() {
        let axis = if c == z { 2 } else { c };
        let touches = |i: usize| c == z && wall && gap[i] <= 0.0;
        let push = if c == z { frame.push } else { 0.0 };
        let law = |i: usize| {
            let (normal, sliding) = at(i);
            interface.law.traction(normal, sliding)[axis]
        };
        let [free, net, total] = reduce(
            points,
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let law = law(i);
                    let one = if touches(i) { 0.0 } else { 1.0 };
                    add(sums, [one, one * (law + push - traction[i]), law])
                })
            },
            &add,
        );
        law_means[axis] = total / points as f64;
        let unknown = if frame.held[c] && free > 0.0 { net / free } else { 0.0 };
        let balance = |start: usize, [traction, pressure]: [&mut [f64]; 2]| {
            let mut worst = [0.0_f64; 3];
            for (k, (traction, pressure)) in traction.iter_mut().zip(pressure).enumerate() {
                let i = start + k;
                *traction += unknown - push;
                let left = law(i) - *traction;
                if touches(i) {
                    *pressure = left.max(0.0);
                    worst = higher(worst, [0.0, -left, traction.abs()]);
                } else {
                    worst = higher(worst, [left.abs(), 0.0, traction.abs()]);
                }
            }
            worst
        };
        // Of the other components the wall takes nothing: their pass has a pressure of no interest.
        let mut nothing = vec![0.0; if c == z { 0 } else { points }];
        let pressure = if c == z { &mut wall_pressure } else { &mut nothing };
        [unbalanced, tension, largest] =
            higher([unbalanced, tension, largest], pass([traction, pressure], &balance, &higher));
    }

    let means: Vec<f64> = traction.chunks_exact(points).map(mean).collect();
    let (mean_pressure, load) = match drive.normal {
        // What wall and law exert: at rest, the same as the mean of the elastic traction.
        Normal::MeanPressure(asked) => {
            let exerted = mean(&wall_pressure) - law_means[2];
            (exerted, exerted - asked)
        }
        Normal::Approach(_) => (-means[z], 0.0),
    };
    let [softest, _] = interface.elastic.stiffness_range();
    let stress = largest.max(softest * interface.rms_height).max(f64::MIN_POSITIVE);
    let residual = Residual {
        equilibrium: unbalanced / stress,
        penetration: if wall { (-lowest).max(0.0) / interface.length_scale() } else { 0.0 },
        wall_tension: tension / stress,
        load: load.abs() / stress,
    };
    let interface_energy = sum(points, &|range| range.map(|i| interface.energy(at(i))).sum()) / points as f64;
    let in_contact = |i: usize| {
        let (normal, sliding) = at(i);
        if wall { wall_pressure[i] > 0.0 } else { interface.law.traction(normal, sliding)[2] < 0.0 }
    };
    let contact = sum(points, &|range| range.map(|i| f64::from(in_contact(i))).sum()) / points as f64;

    // Back to the displacement of the surface: in the frame of a load it moved instead of the rigid one.
    let mut displacement = position.to_vec();
    let mut approach = frame.approach;
    if let Normal::MeanPressure(_) = drive.normal {
        approach = mean(&position[z * points..]) + interface.elastic.uniform_compliance()[z] * mean_pressure;
        displacement[z * points..].iter_mut().for_each(|u| *u -= approach);
    }
    let elastic_energy = 0.5 * gfmd_vector::dot(&traction, &displacement) / points as f64;
    let [nx, ny] = interface.elastic.grid().points();
    let vectors = |values: Vec<f64>| Array3::from_shape_vec((z + 1, nx, ny), values).expect(FITS);
    let field = |values: Vec<f64>| Array2::from_shape_vec((nx, ny), values).expect(FITS);
    State {
        displacement: vectors(displacement),
        traction: vectors(traction),
        gap: field(gap),
        wall_pressure: field(wall_pressure),
        mean_pressure,
        mean_shear: std::array::from_fn(|c| if c < z { means[c] } else { 0.0 }),
        approach,
        lateral: frame.lateral,
        elastic_energy,
        interface_energy,
        contact_fraction: contact,
        residual,
        iterations: 0,
        transform_pairs: transforms.pairs,
        passed_instability: false,
        lowest_curvature: f64::NAN,
    }
}

/// Fields are made with the shape of the grid.
const FITS: &str = "every field of an interface has the size of its grid";

/// The larger of each, NaN if either is.
pub(crate) fn higher<const K: usize>(a: [f64; K], b: [f64; K]) -> [f64; K] {
    std::array::from_fn(|k| if a[k].is_nan() || a[k] > b[k] { a[k] } else { b[k] })
}
