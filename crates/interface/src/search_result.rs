use gfmd_relax::Ending;

/// Last position of a search, and the reason for its end.
pub(crate) struct SearchResult {
    pub(crate) position: Vec<f64>,
    /// Insets at a wall that gives way, else empty.
    pub(crate) inset: Vec<f64>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: f64,
    pub(crate) passed_instability: bool,
    pub(crate) lowest_curvature: f64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Finished(Ending),
    /// The surfaces have separated under a tensile load.
    Detached,
}
