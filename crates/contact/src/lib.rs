//! Frictionless hard-wall contact of a rigid rough surface with an elastic body: problem, control, solvers, certified solution.
