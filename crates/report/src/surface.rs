//! Figures of a surface, and the page about it.

mod figures;

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_files::Provenance;
use gfmd_plot::PlotError;
use gfmd_record::{Cell, Column, Surface};
use gfmd_surface::{RadialBin, Texture};
use gfmd_unit::Units;
use maud::{Markup, html};
use ndarray::{Array2, ArrayRef2};

use crate::figures::{named, sides};
use crate::page::{Fact, Page, Table, command, given, number, page_of, powers, text};
use gfmd_input::failure::Failure;

const CITED: [&str; 4] = [
    "ISO 25178-2:2021, Geometrical product specifications (GPS), Surface texture: Areal, Part 2: Terms, definitions \
     and surface texture parameters.",
    "T. D. B. Jacobs, T. Junge, L. Pastewka, Quantitative characterization of surface topography using spectral \
     analysis, Surface Topography: Metrology and Properties 5, 013001 (2017).",
    "A. Wang, M. H. Müser, On the usefulness of the height-difference-autocorrelation function for contact mechanics, \
     Tribology International 123, 224–233 (2018).",
    "A. Sanner, W. G. Nöhring, L. A. Thimons, T. D. B. Jacobs, L. Pastewka, Scale-dependent roughness parameters for \
     topography analysis, Applied Surface Science Advances 7, 100190 (2022).",
];

/// Surface with its numbers.
pub struct Subject<'a> {
    /// Heights, `[x, y]`.
    pub heights: &'a ArrayRef2<f64>,
    /// Grid of the heights.
    pub grid: &'a Grid,
    /// Unit of heights and lengths, if known.
    pub unit: Option<&'a str>,
    /// Radially averaged power spectral density.
    pub spectrum: &'a [RadialBin],
    /// Name of the window of the spectrum, if there was one.
    pub window: Option<&'a str>,
    /// Longest and shortest wavelengths that the points of a scan resolve, or that its filters leave.
    pub resolved: Option<[f64; 2]>,
    /// True if filters set the band of wavelengths.
    pub is_filtered: bool,
    /// Fitted Hurst exponent, and the longest and shortest wavelengths of the fit.
    pub hurst: Option<(f64, [f64; 2])>,
    /// Autocorrelation, distributions, slopes against distance and bearing curve, if requested.
    pub texture: Option<&'a Texture>,
    /// Points at the course lines between hills, if there are hills and they were requested.
    pub course_lines: Option<&'a Array2<bool>>,
}

/// Number of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// Key in JSON.
    pub name: &'static str,
    /// Value, if it has one.
    pub value: Option<f64>,
    /// Kind of quantity, such as "1/length".
    pub unit: &'static str,
    /// Definition of the number.
    pub meaning: &'static str,
}

impl Number {
    /// Returns the number of a column of statistics with its definition.
    pub fn of(column: &Column<Surface>, cell: &Cell, meaning: &'static str) -> Self {
        let value = Some(cell.number()).filter(|_| !matches!(cell, Cell::Undefined(_)));
        Self { name: column.name, value, unit: column.unit, meaning }
    }
}

/// Texts of a page about a surface.
pub struct About<'a> {
    /// Name of the file or array, or a description of a generated surface.
    pub name: &'a str,
    /// Origin of the heights, and how they were prepared.
    pub source: &'a str,
    /// Further facts: terms and their values.
    pub facts: &'a [(&'static str, String)],
    /// True if the heights are periodic, so that differences cross the edges of the cell.
    pub repeats: bool,
    /// All numbers.
    pub numbers: &'a [Number],
    /// Command that makes the page, if there is one.
    pub again: Option<String>,
    /// File that was read, and its SHA-256.
    pub file: Option<(&'a str, &'a str)>,
    /// Warnings.
    pub remarks: Vec<String>,
}

impl Subject<'_> {
    fn unit(&self) -> &str {
        self.unit.unwrap_or("length")
    }

    /// Draws `PREFIX-map` (not for a profile), `PREFIX-profile` and `PREFIX-spectrum`; with a texture also
    /// `PREFIX-hills` (not for a profile), `PREFIX-autocorrelation`, `PREFIX-correlation-map` (not for a profile),
    /// `PREFIX-distributions`, `PREFIX-slopes`, `PREFIX-curvatures`, `PREFIX-bearing`.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written or the heights cannot be drawn.
    pub fn draw(&self, prefix: &Path) -> Result<Vec<PathBuf>, Failure> {
        let mut files = Vec::new();
        let mut keep = |made: Option<Result<[PathBuf; 2], PlotError>>| -> Result<(), Failure> {
            if let Some(made) = made {
                files.extend(made?);
            }
            Ok(())
        };
        keep(self.map(|map| map.save(&named(prefix, "map"))))?;
        keep(self.hills(|map| map.save(&named(prefix, "hills"))))?;
        keep(Some(self.profile().save(&named(prefix, "profile"))))?;
        keep(self.spectrum().map(|chart| chart.save(&named(prefix, "spectrum"))))?;
        if let Some(texture) = self.texture {
            keep(self.autocorrelation(texture).map(|chart| chart.save(&named(prefix, "autocorrelation"))))?;
            keep(self.correlation_map(texture, |map| map.save(&named(prefix, "correlation-map"))))?;
            keep(self.distributions(texture).map(|chart| chart.save(&named(prefix, "distributions"))))?;
            let [slopes, curvatures] = self.scales(texture);
            keep(slopes.map(|chart| chart.save(&named(prefix, "slopes"))))?;
            keep(curvatures.map(|chart| chart.save(&named(prefix, "curvatures"))))?;
            keep(self.bearing(texture).map(|chart| chart.save(&named(prefix, "bearing"))))?;
        }
        Ok(files)
    }

    /// Returns the page about the surface as HTML, and the number of its figures.
    pub fn page(&self, about: &About, provenance: &Provenance) -> (String, usize) {
        let mut page = Page { title: "Rough surface".into(), cited: CITED.to_vec(), ..Page::default() };
        if self.grid.is_line() {
            page.title = "Profile of a rough surface".into();
        }
        page.remarks.clone_from(&about.remarks);
        self.answer(&mut page, about);
        self.asked(&mut page, about);
        self.figures(&mut page, about);
        page.tables.push(self.table(about));
        let repeat = html! {
            @if let Some(again) = &about.again {
                p { "To make this page again:" }
                pre tabindex="0" { code { (command(again)) } }
            } @else { p { "The page was made by the Python package, from heights in memory." } }
            @if let Some((file, sum)) = about.file {
                p { "The surface was read from " code { (text(file)) } ", SHA-256 " code { (text(sum)) } "." }
            }
        };
        let name = Path::new(about.name).file_name().map_or(about.name.into(), |name| name.to_string_lossy());
        let made = page_of(&page, format!("gfmd surface · {}", text(&name)), provenance, repeat);
        (made.into_string(), page.figures())
    }

    /// Formats a number with its unit.
    fn shown(&self, value: f64, kind: &str) -> Markup {
        let units = Units::new(self.unit, None);
        match units.shown(kind, value) {
            Some(shown) => html! { (number(value * shown.factor)) " " (shown.name) },
            None if kind == "1" => number(value),
            None => html! { (number(value)) " " (units.name(kind)) },
        }
    }

    fn answer(&self, page: &mut Page, about: &About) {
        let of = |name: &str| about.numbers.iter().find(|number| number.name == name);
        let value = |name: &str| of(name).and_then(|number| number.value).unwrap_or(f64::NAN);
        let shown = |name: &str| of(name).map(|number| self.shown(number.value.unwrap_or(f64::NAN), number.unit));
        let (gradient, way) = match about.repeats {
            true => ("rms_gradient", "from the spectrum"),
            false => ("rms_gradient_inside", "by differences inside"),
        };
        let quantity = if self.grid.is_line() { "slope" } else { "gradient" };
        page.answer.push(html! {
            p.headline {
                "Rms height " i { "S" } sub { "q" } " = " (shown("rms_height").unwrap_or_default())
                ", rms " (quantity) " " (number(value(gradient))) " " span { (way) }
            }
        });
        page.answer.push(html! {
            p {
                "Mean distance from the mean height " i { "S" } sub { "a" } " = " (shown("sa").unwrap_or_default())
                ", highest less lowest point " i { "S" } sub { "z" } " = "
                (shown("peak_to_valley").unwrap_or_default()) ". "
                @if value("ssk").is_finite() {
                    "Skewness " (number(value("ssk"))) ", kurtosis " (number(value("sku")))
                    " (0 and 3 of a Gaussian surface). "
                }
                @if let Some((hurst, [longest, shortest])) = self.hurst {
                    "Hurst exponent " (number(hurst)) ", fitted between wavelengths of " (self.shown(longest, "length"))
                    " and " (self.shown(shortest, "length")) ". "
                }
                @match value("sal") {
                    sal if sal.is_finite() => {
                        "The autocorrelation falls to 0.2 within " (self.shown(sal, "length"))
                        " (" i { "S" } sub { "al" } ")."
                    }
                    _ => {
                        "The autocorrelation does not fall to 0.2 within half of the cell: the surface has no "
                        "correlation length that it resolves."
                    }
                }
            }
        });
    }

    fn asked(&self, page: &mut Page, about: &About) {
        let ([nx, ny], [lx, ly]) = (self.grid.points(), self.grid.lengths());
        let read = sides(self.grid, self.unit());
        let (lx, ly) = (lx * read.factor, ly * read.factor);
        let unit = if self.unit.is_none() { "" } else { &*read.name };
        page.asked.push(Fact::new("surface", about.source));
        page.asked.push(Fact(
            html! { "grid" },
            if self.grid.is_line() {
                html! { (nx) " points on a line of " (given(lx)) " " (unit) }
            } else {
                html! { (nx) " × " (ny) " points on " (given(lx)) " × " (given(ly)) " " (unit) }
            },
        ));
        page.asked.extend(about.facts.iter().map(|(term, said)| Fact::new(term, said)));
        let way = match about.repeats {
            true => "periodic: differences and distances cross the edges of the cell",
            false => {
                "not periodic: differences and distances are between points inside, the spectrum is that of one period"
            }
        };
        page.asked.push(Fact::new("boundary", way));
        page.asked.push(Fact::new("window of the spectrum", self.window.unwrap_or("none")));
        if self.unit.is_none() {
            page.asked.push(Fact::new("unit", "unknown; numbers are in the unit of the heights"));
        }
    }

    fn figures(&self, page: &mut Page, about: &About) {
        let caption =
            html! { "Heights. The colours leave out a thousandth of the points at either end if these lie far away." };
        if let Some(map) = self.map(|map| map.clone().element(&page.next_name(), "map of the heights")) {
            page.drawn(map, "map of the heights", &caption);
        }
        let row = if self.grid.is_line() {
            html! { "The profile." }
        } else {
            html! { "Heights along the row of points through the middle." }
        };
        page.chart(&self.profile(), "profile", &row);
        if let Some(chart) = self.spectrum() {
            let of = if self.grid.is_line() { "line" } else { "plane" };
            let caption = html! {
                "Power spectral density, " @if !self.grid.is_line() { "averaged over rings of wave vectors; " }
                "its integral over the " (of) " of wave vectors is " i { "S" } sub { "q" } "²."
                @if self.resolved.is_some() {
                    " The broken lines bound the band that the "
                    @if self.is_filtered { "filters leave." } @else { "points resolve." }
                }
            };
            page.chart(&chart, "power spectral density", &caption);
        }
        let hills = html! {
            "Heights, with the course lines between hills. Hills lower than the pruned height have joined others, and "
            "the lines bound the " i { "mean hill area" } " of the table."
        };
        if let Some(map) = self.hills(|map| map.clone().element(&page.next_name(), "map of the hills")) {
            page.drawn(map, "map of the hills", &hills);
        }
        let Some(texture) = self.texture else { return };
        if let Some(chart) = self.autocorrelation(texture) {
            let caption = html! {
                "Autocorrelation " i { "f" } " = 1 − ⟨(" i { "h" } "(" i { "x" } " + " i { "d" } ") − " i { "h" } "("
                i { "x" } "))²⟩/2"
                i { "S" } sub { "q" } "², "
                @if about.repeats { "over all points. " } @else { "over the pairs of points inside. " }
                "It ends a correlated distance where it falls to 0.2."
            };
            page.chart(&chart, "autocorrelation", &caption);
        }
        let name = page.next_name();
        if let Some(map) = self.correlation_map(texture, |map| map.element(&name, "map of the autocorrelation")) {
            page.drawn(
                map,
                "map of the autocorrelation",
                &html! { "Autocorrelation in all directions, up to half of the cell." },
            );
        }
        if let Some(chart) = self.distributions(texture) {
            let caption = html! {
                "Distribution over 100 bins, beside the Gaussian of the same mean and standard deviation; slopes are "
                "forward differences, "
                "curvatures central second differences"
                @if !self.grid.is_line() { ", the mean of those along x and y" } "."
            };
            page.chart(&chart, "distribution", &caption);
        }
        let [slopes, curvatures] = self.scales(texture);
        if let Some(chart) = slopes {
            let caption = html! { "Rms slope against the distance between the two points of the difference." };
            page.chart(&chart, "slope against distance", &caption);
        }
        if let Some(chart) = curvatures {
            let caption =
                html! { "Rms curvature against the distance between the outer points of the second difference." };
            page.chart(&chart, "curvature against distance", &caption);
        }
        if let Some(chart) = self.bearing(texture) {
            let caption = html! {
                "Bearing curve: the share of points at or above a height above the mean. The broken line is the "
                "core of height "
                i { "S" } sub { "k" } ", through the least steep 40 %."
            };
            page.chart(&chart, "bearing curve", &caption);
        }
    }

    fn table(&self, about: &About) -> Table {
        let row = |of: &Number| {
            let value = of.value.unwrap_or(f64::NAN);
            let units = Units::new(self.unit, None);
            let known = units.shown(of.unit, value);
            let (factor, unit) = match known {
                Some(shown) => (shown.factor, shown.name),
                None if of.unit == "1" => (1.0, String::new()),
                None => (1.0, units.name(of.unit)),
            };
            let meaning = html! { span.meaning { (of.meaning) } };
            vec![html! { code { (of.name) } }, powers_of(value * factor), html! { (unit) }, meaning]
        };
        Table {
            caption: html! {
                "All numbers, under their names in " code { "gfmd surface --json" } "; a dash has no value."
            },
            head: vec![html! { "number" }, html! { "value" }, html! { "unit" }, html! { span.meaning { "meaning" } }],
            rows: about.numbers.iter().map(row).collect(),
        }
    }
}

/// Formats a number for a table.
fn powers_of(value: f64) -> Markup {
    if value.is_finite() && value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        return powers(&format!("{value:.4e}"));
    }
    number(value)
}

/// Returns the unit of a power of length, for lengths in `unit`.
pub fn unit_of(unit: &str, power: i32) -> String {
    match power {
        0 => "1".into(),
        1 => unit.into(),
        -1 => format!("1/{unit}"),
        power if power < 0 => format!("1/{unit}^{}", -power),
        power => format!("{unit}^{power}"),
    }
}
