use gfmd_relax::Ending;

/// The place that a search came to, and why it ended there.
pub(crate) struct Ended {
    pub(crate) position: Vec<f64>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: f64,
    pub(crate) passed_instability: bool,
    pub(crate) lowest_curvature: f64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Ended(Ending),
    /// Pulled apart until nothing could hold.
    Detached,
}
