//! Surface stiffness and compliance of elastic half-spaces and slabs, one Fourier mode at a time, in 2-D and 3-D.
