//! Relaxation methods for constrained minimisation: damped position Verlet, FIRE, constrained conjugate gradients. No physics inside.
