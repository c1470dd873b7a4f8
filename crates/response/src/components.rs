use gfmd_field::Grid;

/// Components of a vector on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// x, z: plane strain, on a line.
    Plane,
    /// x, y, z.
    Space,
}

impl Components {
    /// Returns the components on a grid: two on a line, otherwise three.
    pub fn of(grid: &Grid) -> Self {
        if grid.is_line() { Self::Plane } else { Self::Space }
    }

    /// Returns the number of components.
    #[expect(clippy::len_without_is_empty, reason = "there are two or three")]
    pub fn len(self) -> usize {
        self.axes().len()
    }

    /// Returns the spatial axis of each component: x is 0, y is 1, z is 2.
    pub fn axes(self) -> &'static [usize] {
        match self {
            Self::Plane => &[0, 2],
            Self::Space => &[0, 1, 2],
        }
    }

    /// Returns the index of the component z, which is the last.
    pub fn normal(self) -> usize {
        self.len() - 1
    }
}
