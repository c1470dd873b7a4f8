//! Charts: panels side by side or one below the other, with a legend above.

use std::path::{Path, PathBuf};

use super::axis::Ticks;
use super::drawing::Drawing;
use super::frame::{EDGE, Frame, TICK, UNDER, left_margin};
use super::legend::{arrange, draw_legend, legend};
use super::panels::{HEAD, Labels, check, draw_panel, ranges, right_margin};
use super::{Panel, PlotError, stack};

const BETWEEN_PANELS: f64 = 12.0;

/// Width of one journal column, in points.
pub const COLUMN: f64 = 252.0;

/// Width of two journal columns, in points.
pub const TWO_COLUMNS: f64 = 516.0;

/// Panels side by side, or one below the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Panels from left to right, or from top to bottom.
    pub panels: Vec<Panel>,
    /// True if all panels share one ordinate, labelled at the left.
    pub share_y: bool,
    /// True if panels are one below the other with the abscissa of the lowest; `share_y` then has no effect.
    pub stacked: bool,
    /// Width of the figure in points.
    pub width: f64,
    /// Height of the axes in points. If stacked, the height of the first panel; the others have half of it.
    pub height: f64,
}

impl Chart {
    /// Creates a chart: one column wide for one panel, else two columns wide with a shared ordinate.
    pub fn new(panels: Vec<Panel>) -> Self {
        let several = panels.len() > 1;
        let width = if several { TWO_COLUMNS } else { COLUMN };
        Self { panels, share_y: several, stacked: false, width, height: 150.0 }
    }

    /// Creates a chart two columns wide with its panels one below the other.
    pub fn stacked(panels: Vec<Panel>) -> Self {
        Self { stacked: true, share_y: false, width: TWO_COLUMNS, ..Self::new(panels) }
    }

    /// Returns the figure as SVG text.
    pub fn svg(&self) -> Result<String, PlotError> {
        draw(self)?.svg()
    }

    /// Returns the figure as an `svg` element for an HTML page. Its ids begin with `name`, which must be unique in the
    /// page; `title` is the alternative text.
    pub fn element(&self, name: &str, title: &str) -> Result<String, PlotError> {
        draw(self)?.element(name, title)
    }

    /// Returns the figure as PNG bytes.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        draw(self)?.png()
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        draw(self)?.save(stem)
    }
}

pub(super) fn draw(chart: &Chart) -> Result<Drawing, PlotError> {
    if chart.panels.is_empty() {
        return Err(PlotError::Empty { what: "the figure has no panels" });
    }
    chart.panels.iter().try_for_each(check)?;
    let ranges = ranges(&chart.panels, chart.share_y && !chart.stacked)?;
    if chart.stacked {
        return stack::draw(&chart.panels, &ranges, [chart.width, chart.height]);
    }
    let count = chart.panels.len();
    let y_ticks = ranges
        .iter()
        .zip(&chart.panels)
        .map(|(range, panel)| Ticks::new(panel.y.scale, range[1], chart.height / 26.0))
        .collect::<Result<Vec<_>, _>>()?;

    let legend = legend(&chart.panels, &ranges);
    let (legend_rows, legend_height) = arrange(&legend, chart.width - 2.0 * EDGE);
    let titled = chart.panels.iter().any(|panel| !panel.title.is_empty());
    let factored = y_ticks.iter().any(|ticks| !ticks.factor.is_empty());
    let above = if titled || factored { HEAD } else { 0.0 };
    let top = EDGE + legend_height + above + 0.5 * TICK;

    // The margins hold tick labels and the ordinate label at the left, names of reference lines at the right.
    let lefts: Vec<f64> = (0..count)
        .map(|i| if i == 0 || !chart.share_y { left_margin(&y_ticks[i], &chart.panels[i].y) } else { 0.0 })
        .collect();
    let rights: Vec<f64> = (0..count)
        .map(|i| if i + 1 == count || !chart.share_y { right_margin(&chart.panels[i], ranges[i][1]) } else { 0.0 })
        .collect();
    let margins: f64 = lefts.iter().chain(&rights).sum();
    let gaps = (count - 1) as f64 * BETWEEN_PANELS;
    let width = ((chart.width - 2.0 * EDGE - margins - gaps) / count as f64).max(40.0);

    let mut svg = String::new();
    let mut left = EDGE;
    for (i, panel) in chart.panels.iter().enumerate() {
        left += lefts[i];
        let x = Ticks::new(panel.x.scale, ranges[i][0], width / 34.0)?;
        let frame = Frame { left, top, width, height: chart.height, x, y: y_ticks[i].clone() };
        let labels = Labels { x: true, y: !chart.share_y || i == 0, levels: !chart.share_y || i + 1 == count };
        draw_panel(&mut svg, panel, &frame, i, labels);
        left += width + rights[i] + BETWEEN_PANELS;
    }
    draw_legend(&mut svg, &legend_rows, chart.width);
    let bottom = top + chart.height + UNDER + EDGE;
    Ok(Drawing { width: chart.width, height: bottom, pictures: Vec::new(), elements: svg })
}
