use std::sync::Arc;

use gfmd_contact::{Effort, Fields, Losses, Refusal, RigidSurface, Solution, Variables, Visit};
use gfmd_measure::{Scales, Summary};
use gfmd_medium::Memory;
use gfmd_vector::with_contiguous;
use ndarray::{Array2, ArrayView2, CowArray, Ix2};

use super::QuasistaticContact;
use super::normal::NormalState;
use crate::State;

/// State of a [`QuasistaticContact`](crate::QuasistaticContact) under a load, or at the end of an increment with its
/// history. Fields are `[x, y]`.
#[derive(Clone, Debug)]
pub struct QuasistaticState {
    pub(super) normal: NormalState,
    pub(super) sheared: Option<ShearFields>,
    /// Mean shear traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Time since the first touch of the undeformed surfaces.
    pub time: f64,
    /// Sliding distance since the first touch, length.
    pub distance: f64,
    pub(super) memory: Option<Memory>,
    pub(super) worn: Option<Array2<f64>>,
    pub(super) pressed_in: Option<Array2<f64>>,
    /// Fraction of points with a pressure equal to the hardness, to the accuracy of the state; 0 without one.
    pub plastic_fraction: f64,
    /// [Elastic energy](Self::elastic_energy) at the end of an increment; `None` under a load.
    pub(super) stored: Option<f64>,
    /// Energies lost in the increment, per area, stress × length.
    pub losses: Losses,
    /// Magnitude of the difference between the work of the rigid surface in the increment, by the trapezoidal rule, and
    /// the energies stored and lost, per area. It is of second order in the length of the increment, or of first order
    /// where points slip, but is not the error of the losses: at a held approach it is 0 for any duration. In an
    /// increment with a jump, this difference is the loss, and the value is the largest error of the rule for forces
    /// that change monotonically. It is 0 in an instantaneous increment of surfaces that neither slip nor yield, and in
    /// the first increment with a law, where the work is unknown.
    pub work_imbalance: f64,
}

/// Fields of the shear; vectors are stored component by component.
#[derive(Clone, Debug)]
pub(super) struct ShearFields {
    pub(super) displacement: Vec<f64>,
    pub(super) traction: Vec<f64>,
    pub(super) slip: Vec<f64>,
    pub(super) stick_fraction: f64,
    pub(super) friction: f64,
    pub(super) excess: f64,
}

impl QuasistaticState {
    /// Returns the state of the wall, unless a law acts across the gap.
    pub fn wall(&self) -> Option<&Solution> {
        self.normal.wall()
    }

    /// Returns the state of the law across the gap, if there is one.
    pub fn law(&self) -> Option<&State> {
        self.normal.law()
    }

    /// Returns the elastic energy per area, stress × length; of the springs of all branches if the body relaxes.
    pub fn elastic_energy(&self) -> f64 {
        self.stored.unwrap_or_else(|| self.normal.elastic_energy())
    }

    /// Returns the energy of the law across the gap per area, stress × length; 0 without one, NaN if it has none.
    pub fn interface_energy(&self) -> f64 {
        self.normal.interface_energy()
    }

    /// Returns the shear traction on the elastic surface along x (0) or y (1), stress; `None` for surfaces that do not
    /// shear each other.
    pub fn shear(&self, axis: usize) -> Option<ArrayView2<'_, f64>> {
        match (&self.sheared, &self.normal) {
            (Some(sheared), _) => self.component(&sheared.traction, axis),
            (None, NormalState::Law(state)) if axis + 1 < state.traction.len_of(ndarray::Axis(0)) => {
                Some(state.traction.index_axis(ndarray::Axis(0), axis))
            }
            _ => None,
        }
    }

    /// Returns the slip in the increment along x (0) or y (1), length, of the elastic surface relative to the rigid
    /// one; `None` without friction.
    pub fn slip(&self, axis: usize) -> Option<ArrayView2<'_, f64>> {
        self.sheared.as_ref().and_then(|sheared| self.component(&sheared.slip, axis))
    }

    /// Returns the fraction of all points that touch and stick; `None` without friction.
    pub fn stick_fraction(&self) -> Option<f64> {
        self.sheared.as_ref().map(|sheared| sheared.stick_fraction)
    }

    /// Returns the depth that both surfaces have lost so far, length; `None` if they do not wear.
    pub fn wear_depth(&self) -> Option<&Array2<f64>> {
        self.worn.as_ref()
    }

    /// Returns the depth by which the surfaces were pressed into each other, length: so far along a path, or by a load;
    /// `None` without a hardness.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        self.pressed_in.as_ref().or_else(|| self.normal.pressed_in())
    }

    /// Returns the indentation −u_z of a body that relaxes, and the elongation of the spring of each branch along z,
    /// `[x, y]`, length; `None` for an elastic body.
    pub fn memory(&self) -> Option<Vec<Array2<f64>>> {
        let (share, shape) = (self.share(), self.gap().dim());
        let rows = if share.is_whole() { shape.0 } else { share.total() / shape.1 };
        let grid = gfmd_field::Grid::new([rows, shape.1], [1.0; 2]).ok()?;
        let fields = self.memory.as_ref()?.normal(&grid, share).ok()?;
        fields.into_iter().map(|values| Array2::from_shape_vec(shape, values).ok()).collect()
    }

    fn component<'a>(&self, vector: &'a [f64], axis: usize) -> Option<ArrayView2<'a, f64>> {
        let shape = self.gap().dim();
        let points = shape.0 * shape.1;
        let field = vector.get(axis * points..(axis + 1) * points)?;
        ArrayView2::from_shape(shape, field).ok()
    }

    /// Multiplies all lengths and stresses by the given factors; the surface and E* are in the new units.
    pub(super) fn times(self, length: f64, stress: f64, scales: (&Arc<RigidSurface>, f64)) -> Self {
        let field = |field: Option<Array2<f64>>| field.map(|field| field * length);
        let sheared = self.sheared.map(|sheared| ShearFields {
            displacement: sheared.displacement.into_iter().map(|u| u * length).collect(),
            traction: sheared.traction.into_iter().map(|t| t * stress).collect(),
            slip: sheared.slip.into_iter().map(|s| s * length).collect(),
            ..sheared
        });
        Self {
            normal: self.normal.times(length, stress, scales),
            sheared,
            mean_shear: self.mean_shear.map(|t| t * stress),
            lateral: self.lateral.map(|u| u * length),
            distance: self.distance * length,
            memory: self.memory.map(|memory| memory.times(length, stress)),
            worn: field(self.worn),
            pressed_in: field(self.pressed_in),
            stored: self.stored.map(|energy| energy * stress * length),
            losses: self.losses.times(stress * length),
            work_imbalance: self.work_imbalance * stress * length,
            ..self
        }
    }
}

impl QuasistaticContact {
    /// Returns a state without forces, to be filled in.
    pub(super) fn blank(&self) -> Result<QuasistaticState, Refusal> {
        let points = self.points();
        let lateral = self.response.as_ref().map(|response| (response.components().len() - 1) * points);
        let zeros = || Array2::zeros(self.normal.surface().shape());
        Ok(QuasistaticState {
            normal: self.normal.blank()?,
            sheared: lateral.map(|lateral| ShearFields {
                displacement: vec![0.0; lateral],
                traction: vec![0.0; lateral],
                slip: vec![0.0; lateral],
                stick_fraction: 0.0,
                friction: 0.0,
                excess: 0.0,
            }),
            mean_shear: [0.0; 2],
            lateral: [0.0; 2],
            time: 0.0,
            distance: 0.0,
            memory: self.medium.as_ref().map(|medium| medium.rest()),
            worn: self.wear.map(|_| zeros()),
            pressed_in: self.hardness.as_ref().map(|_| zeros()),
            plastic_fraction: 0.0,
            stored: Some(0.0),
            losses: Losses::default(),
            work_imbalance: 0.0,
        })
    }
}

impl Variables for QuasistaticState {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let share = &self.share().clone();
        let Self { normal, sheared, memory, worn, pressed_in, .. } = self;
        normal.visit(visitor);
        if let Some(ShearFields { displacement, traction, slip, stick_fraction, friction, excess }) = sheared {
            let (fields, own) = ([displacement, traction, slip].into_iter(), share.own().len());
            fields.flat_map(|field| field.chunks_exact_mut(own)).for_each(|rows| visitor.rows(share, rows));
            visitor.numbers(&mut [stick_fraction, friction, excess]);
        }
        for field in worn.iter_mut().chain(pressed_in) {
            with_contiguous(field, |field| visitor.rows(share, field));
        }
        if let Some(memory) = memory {
            memory.visit(share, visitor);
        }
        let Self { mean_shear: [shear_x, shear_y], lateral: [x, y], time, distance, .. } = self;
        visitor.numbers(&mut [shear_x, shear_y, x, y, time, distance]);
        let Self { plastic_fraction, stored, losses, work_imbalance, .. } = self;
        visitor.numbers(&mut [plastic_fraction, stored.get_or_insert_default(), work_imbalance]);
        let Losses { relaxation, friction, wear, plastic, jumps } = losses;
        visitor.numbers(&mut [relaxation, friction, wear, plastic, jumps]);
    }
}

impl Fields for QuasistaticState {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.normal.pressure()
    }

    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.normal.repulsion()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.normal.fields().displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.normal.fields().gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.normal.fields().mean_pressure()
    }

    fn approach(&self) -> f64 {
        self.normal.fields().approach()
    }

    fn effort(&self) -> Effort {
        self.normal.fields().effort()
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        let of_shear = self.sheared.iter().flat_map(|of| [("friction", of.friction), ("excess", of.excess)]);
        self.normal.fields().residuals().into_iter().chain(of_shear).collect()
    }

    fn scales(&self) -> Scales {
        self.normal.fields().scales()
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        let summary = self.normal.fields().summary_in(scales);
        Summary { elastic_energy: self.stored.unwrap_or(summary.elastic_energy), ..summary }
    }
}
