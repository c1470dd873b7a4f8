use std::borrow::Cow;

use gfmd_contact::Hardness;
use gfmd_field::Share;
use ndarray::{Array2, ArrayView2};

use gfmd_input::rows;
use gfmd_input::source::Surface;
use gfmd_report::figures::SceneFields;
use gfmd_run::series::{Field, Prepared};

/// Whole fields of a contact for figures and VTK files, gathered on the first of several processes.
pub(crate) struct Whole<'a> {
    pub(crate) surface: Cow<'a, Surface>,
    pub(crate) hardness: Option<Cow<'a, Hardness>>,
    pub(crate) shown: SceneFields,
    pub(crate) fields: Vec<Field<'a>>,
    /// Lateral displacement of the surface.
    pub(crate) lateral: Cow<'a, [Array2<f64>]>,
}

impl<'a> Whole<'a> {
    /// Gathers the fields; `None` on all processes but the first. All processes must call it.
    pub(crate) fn of(
        prepared: &'a Prepared,
        shown: SceneFields,
        fields: Vec<Field<'a>>,
        lateral: &'a [Array2<f64>],
    ) -> Option<Self> {
        let Prepared { surface, hardness, .. } = prepared;
        let share = &surface.share;
        if share.is_whole() {
            let hardness = hardness.as_ref().map(Cow::Borrowed);
            return Some(Self {
                surface: Cow::Borrowed(surface),
                hardness,
                shown,
                fields,
                lateral: Cow::Borrowed(lateral),
            });
        }
        let shown = shown_by_first(surface, shown);
        let gathered = fields.into_iter().map(|Field { name, units, values }| {
            let values = rows::gathered(share, values.view())?;
            Some(Field { name, units, values: values.into() })
        });
        // Gather every field, since all processes take part.
        let fields: Vec<Option<Field>> = gathered.collect();
        let hardness = hardness.as_ref().map(|hardness| match hardness {
            Hardness::Field(field) => rows::gathered(share, field.view()).map(Hardness::Field),
            uniform => Some(uniform.clone()),
        });
        let lateral: Vec<Option<Array2<f64>>> =
            lateral.iter().map(|field| rows::gathered(share, field.view())).collect();
        let lateral = lateral.into_iter().flatten().collect();
        let surface = Cow::Owned(surface.gathered()?);
        let shown = shown?;
        let hardness = hardness.flatten().map(Cow::Owned);
        Some(Self { surface, hardness, shown, fields: fields.into_iter().flatten().collect(), lateral })
    }
}

/// Gathers fields for figures on the first process; `None` on the others. All processes must call it.
pub(crate) fn shown_by_first(surface: &Surface, shown: SceneFields) -> Option<SceneFields> {
    let (share, columns) = (&surface.share, surface.grid.points()[1]);
    if share.is_whole() {
        return Some(shown);
    }
    let SceneFields { pressure, repulsion, gap, level } = shown;
    let [pressure, repulsion, gap, level] = [pressure, repulsion, gap, level].map(|own| gathered(share, own, columns));
    Some(SceneFields { pressure: pressure?, repulsion: repulsion?, gap: gap?, level: level? })
}

/// Gathers all rows on the first process; `own` are the rows of this one.
fn gathered(share: &Share, own: Vec<f64>, columns: usize) -> Option<Vec<f64>> {
    let own = ArrayView2::from_shape((own.len() / columns, columns), &own).ok()?;
    rows::gathered(share, own).map(|whole: Array2<f64>| whole.into_raw_vec_and_offset().0)
}
