/// Branch of a generalised Maxwell body: a spring and a dashpot in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Relaxation time τ, in time.
    pub time: f64,
    /// Spring modulus relative to the long-term modulus, c = E_i/E_∞.
    pub weight: f64,
}
