//! Tests of FIRE against an entry-by-entry implementation of theory.md, section 6.4.

use gfmd_relax::{Fire, Landscape, Method, RelaxError, Stop, Uphill, relax};

use crate::support::{Chain, distance, scattered};

/// Algorithm of theory.md, section 6.4, on plain vectors, with one statement per line of the text.
struct Plain {
    fire: Fire,
    u: Vec<f64>,
    v: Vec<f64>,
    dt: f64,
    alpha: f64,
    downhill: u32,
    step: u64,
    uphills: u32,
}

impl Plain {
    fn new(fire: Fire, u: Vec<f64>) -> Self {
        let v = vec![0.0; u.len()];
        Self { fire, u, v, dt: fire.dt_start, alpha: fire.alpha_start, downhill: 0, step: 0, uphills: 0 }
    }

    /// Returns the force, with zero force and velocity for entries pressed against the wall.
    fn net_force(&mut self, problem: &mut Chain) -> Vec<f64> {
        let mut f = vec![0.0; self.u.len()];
        problem.force(&self.u, &mut f);
        if let Some(upper) = &problem.upper {
            for i in 0..f.len() {
                if self.u[i] == upper[i] && f[i] > 0.0 {
                    f[i] = 0.0;
                    self.v[i] = 0.0;
                }
            }
        }
        f
    }

    fn project(&mut self, problem: &Chain) {
        for (u, z) in self.u.iter_mut().zip(problem.upper.iter().flatten()) {
            *u = u.min(*z);
        }
    }

    fn step(&mut self, problem: &mut Chain) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut f = self.net_force(problem);
        let power = dot(&f, &self.v);
        let moving = self.v.iter().any(|v| *v != 0.0);
        if power > 0.0 {
            self.downhill += 1;
            if self.downhill > self.fire.delay {
                self.dt = (self.dt * self.fire.dt_grow).min(self.fire.dt_max);
                self.alpha *= self.fire.alpha_shrink;
            }
        } else if moving {
            self.uphills += 1;
            self.downhill = 0;
            if self.step >= self.fire.grace {
                self.dt = (self.dt * self.fire.dt_shrink).max(self.fire.dt_min);
                self.alpha = self.fire.alpha_start;
            }
            if self.fire.uphill == Uphill::StepBack {
                for (u, v) in self.u.iter_mut().zip(&self.v) {
                    *u -= 0.5 * self.dt * v;
                }
                self.project(problem);
            }
            self.v.fill(0.0);
            f = self.net_force(problem);
        }
        for (v, f) in self.v.iter_mut().zip(&f) {
            *v += self.dt * f;
        }
        let speed_per_force = (dot(&self.v, &self.v) / dot(&f, &f)).sqrt();
        for (v, f) in self.v.iter_mut().zip(&f) {
            *v = (1.0 - self.alpha) * *v + self.alpha * speed_per_force * f;
        }
        let old = self.u.clone();
        for (u, v) in self.u.iter_mut().zip(&self.v) {
            *u += self.dt * v;
        }
        self.project(problem);
        for ((v, u), old) in self.v.iter_mut().zip(&self.u).zip(&old) {
            *v = (u - old) / self.dt;
        }
        self.step += 1;
    }
}

#[test]
fn both_versions_follow_the_theory_step_by_step() {
    let n = 40;
    let free = Chain::springs(n, 0.02, |i| 0.1 * (0.7 * i as f64).cos());
    let pressed = free.clone().below(scattered(n).iter().map(|s| 0.3 * s).collect());
    for start in [free, pressed] {
        let dt_max = Fire::largest_dt(start.band().1);
        for fire in [Fire::bitzek(dt_max), Fire::v2(dt_max), Fire { delay: 2, grace: 7, ..Fire::v2(dt_max) }] {
            let mut problem = start.clone();
            let mut state = fire.start(&mut problem, scattered(n)).unwrap();
            let mut plain = Plain::new(fire, state.u.clone());
            let mut uphills = 0;
            for step in 0..150 {
                fire.step(&mut problem, &mut state).unwrap();
                plain.step(&mut problem);
                uphills += u32::from(state.memory.downhill == 0 && state.memory.uphill > 0);
                assert!(distance(&state.u, &plain.u) < 1e-11, "step {step}");
                assert!(distance(&state.memory.velocity, &plain.v) < 1e-10, "step {step}");
                assert!((state.memory.dt - plain.dt).abs() < 1e-14);
                assert!((state.memory.alpha - plain.alpha).abs() < 1e-14);
                assert_eq!(state.memory.downhill, plain.downhill);
            }
            assert!(uphills >= 2 && uphills == plain.uphills, "{uphills} {}", plain.uphills);
            let back = if fire.uphill == Uphill::StepBack { u64::from(uphills) } else { 0 };
            assert_eq!((state.step, state.evaluations), (150, 151 + back));
        }
    }
}

#[test]
fn the_time_step_stays_within_its_limits() {
    let mut problem = Chain::springs(60, 0.01, |_| 0.2);
    // A maximum time step short enough to be reached between two steps uphill.
    let dt_max = 0.2 * Fire::largest_dt(problem.band().1);
    for fire in [Fire::bitzek(dt_max), Fire::v2(dt_max)] {
        let mut state = fire.start(&mut problem, scattered(60)).unwrap();
        let (mut smallest, mut largest) = (f64::INFINITY, 0.0);
        for _ in 0..600 {
            fire.step(&mut problem, &mut state).unwrap();
            smallest = f64::min(smallest, state.memory.dt);
            largest = f64::max(largest, state.memory.dt);
        }
        assert_eq!(largest, fire.dt_max);
        assert!(smallest >= fire.dt_min && smallest < fire.dt_start * 1.0001);
    }
}

/// k Δt² = 1.9: every step overshoots to −0.9 u, so the force always points back.
#[test]
fn gives_up_after_too_many_steps_uphill() {
    let mut problem = Chain::modes(&[1.9, 1.9]);
    let fire = Fire { dt_start: 1.0, dt_min: 1.0, uphill: Uphill::Halt, max_uphill: 5, ..Fire::v2(1.0) };
    let mut state = fire.start(&mut problem, vec![1.0, 0.5]).unwrap();
    let stop = Stop { residual: 1e-10, settled: 0, max_steps: 1000 };
    match relax(&mut problem, &fire, &mut state, &stop, &mut ()) {
        Err(RelaxError::Uphill { reached, found, allowed }) => {
            assert_eq!((found, allowed, reached.step), (6, 5, 6));
            assert!((state.u[0] - 0.9f64.powi(6)).abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }
}

/// With this overshoot, the time step is constant for `grace` steps, then halved at each step uphill.
#[test]
fn uphill_steps_shorten_the_time_step_after_the_grace() {
    let mut problem = Chain::modes(&[1.9, 1.9]);
    for (dt_min, shortened) in [(0.1, 0.5), (0.6, 0.6)] {
        let fire = Fire { dt_start: 1.0, dt_min, grace: 3, uphill: Uphill::Halt, ..Fire::v2(1.0) };
        let mut state = fire.start(&mut problem, vec![1.0, 0.5]).unwrap();
        let mut seen = Vec::new();
        for _ in 0..5 {
            fire.step(&mut problem, &mut state).unwrap();
            seen.push((state.memory.dt, state.memory.uphill, state.memory.downhill));
        }
        // The shortened step does not overshoot.
        assert_eq!(seen, [(1.0, 0, 0), (1.0, 1, 0), (1.0, 2, 0), (shortened, 3, 0), (shortened, 0, 1)]);
    }
}

/// An entry overshoots to its bound, from −1 to 1/2 instead of 0.9, and is pulled off: the step back moves it off the
/// bound.
#[test]
fn an_entry_that_a_step_back_takes_off_its_bound_has_left_it() {
    let mut problem = Chain::modes(&[1.9, 1.9]).below(vec![0.5; 2]);
    let fire = Fire { dt_start: 1.0, grace: 0, ..Fire::v2(1.0) };
    let mut state = fire.start(&mut problem, vec![-1.0, -1.0]).unwrap();
    fire.step(&mut problem, &mut state).unwrap();
    assert_eq!((&state.u[..], &state.memory.velocity[..], state.settled), (&[0.5; 2][..], &[1.5; 2][..], 0));
    fire.step(&mut problem, &mut state).unwrap();
    // The step back is ½ Δt v with Δt = ½, followed by Δt² f from rest.
    let exact = (0.5 - 0.25 * 1.5) * (1.0 - 0.25 * 1.9);
    assert!((state.u[0] - exact).abs() < 1e-15, "{}", state.u[0]);
    assert_eq!((state.settled, state.evaluations), (0, 4));
}

/// For two entries on their bounds, a velocity into the wall does not count as a step uphill.
#[test]
fn entries_that_arrive_at_their_bound_stay_there() {
    let mut problem = Chain::springs(2, 0.05, |_| 1.0).below(vec![0.1, 1.4]).above(vec![-0.6, 1.4]);
    for fire in [Fire::bitzek(0.8), Fire::v2(0.8)] {
        let mut state = fire.start(&mut problem, vec![0.0; 2]).unwrap();
        let stop = Stop { residual: 0.0, settled: 20, max_steps: 60 };
        relax(&mut problem, &fire, &mut state, &stop, &mut ()).unwrap();
        assert_eq!(state.u, [0.1, 1.4]);
        assert_eq!(state.memory.uphill, 0);
    }
}

#[test]
fn at_rest_in_the_minimum_nothing_moves() {
    let mut problem = Chain::modes(&[1.0, 2.0]);
    let fire = Fire::bitzek(1.0);
    let mut state = fire.start(&mut problem, vec![0.0; 2]).unwrap();
    for _ in 0..5 {
        fire.step(&mut problem, &mut state).unwrap();
    }
    assert_eq!(state.u, [0.0; 2]);
    assert_eq!(state.memory.velocity, [0.0; 2]);
}

#[test]
fn parameters_without_meaning_are_refused() {
    let good = Fire::v2(0.8);
    let bad = [
        ("dt_max", Fire { dt_max: f64::NAN, ..good }),
        ("dt_max", Fire { dt_max: 0.0, ..good }),
        ("dt_start", Fire { dt_start: 0.9, ..good }),
        ("dt_start", Fire { dt_start: 0.0, ..good }),
        ("dt_min", Fire { dt_min: 0.5, ..good }),
        ("dt_min", Fire { dt_min: -0.1, ..good }),
        ("dt_grow", Fire { dt_grow: 0.9, ..good }),
        ("dt_shrink", Fire { dt_shrink: 1.0, ..good }),
        ("dt_shrink", Fire { dt_shrink: 0.0, ..good }),
        ("alpha_start", Fire { alpha_start: 1.1, ..good }),
        ("alpha_shrink", Fire { alpha_shrink: f64::NAN, ..good }),
    ];
    let mut problem = Chain::modes(&[1.0, 2.0]);
    assert!(good.start(&mut problem, vec![0.0; 2]).is_ok());
    for (expected, fire) in bad {
        match fire.start(&mut problem, vec![0.0; 2]) {
            Err(RelaxError::Parameter { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
}
