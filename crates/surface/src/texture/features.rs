use gfmd_field::Grid;
use ndarray::{Array2, ArrayRef2};
use rayon::prelude::*;

use crate::SurfaceError;
use crate::names::named;
use crate::statistics::checked;

/// Number of the highest peaks, or of the deepest pits, whose heights are averaged.
const HIGHEST: usize = 5;

/// Mark of a point that has no hill yet.
const NONE: u32 = u32::MAX;

/// Treatment of hills and dales that touch the edge of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotifEdges {
    /// They count as all others.
    All,
    /// They do not count, since they may continue outside.
    LeaveOut,
    /// They continue at the opposite edge.
    Periodic,
}

named! { MotifEdges, "motif edges":
    All = "all", "motifs at the edges count";
    LeaveOut = "leave-out", "motifs at the edges do not count";
    Periodic = "periodic", "motifs continue at the opposite edge";
}

/// Feature parameters of ISO 25178-2: hills and dales by steepest ascent between the eight neighbours of a point, after
/// Wolf pruning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Hills and their peaks.
    pub hills: Motifs,
    /// Dales and their pits, of the heights upside down: depths below the mean are positive.
    pub dales: Motifs,
}

/// Hills, or dales of the heights upside down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motifs {
    /// Number of motifs.
    pub count: usize,
    /// Number of motifs divided by the area of the cell: Spd, Svd, 1/area.
    pub density: f64,
    /// Mean curvature −(h_xx + h_yy)/2 at the peaks, by central differences: Spc, Svc, 1/length. Peaks at the edge of a
    /// surface that does not continue are left out; `None` without other ones.
    pub curvature: Option<f64>,
    /// Mean height of the five highest peaks above the mean of the surface, or of all peaks if there are fewer: S5p,
    /// S5v, length; `None` without peaks.
    pub five: Option<f64>,
    /// Mean area of a motif; `None` without motifs.
    pub area: Option<f64>,
}

impl Features {
    /// Finds the hills and dales of heights `[nx, ny]`. A hill remains if its peak is at least the fraction `wolf` of
    /// the height range above the highest saddle to a higher peak; otherwise it joins the hill beyond this saddle. Of
    /// equal heights the one that is stored first counts as higher. Returns `None` for a profile and a flat surface.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite, or more than 2³² − 2 of them; a
    /// fraction outside 0 to 1.
    pub fn of(
        heights: &ArrayRef2<f64>,
        grid: &Grid,
        wolf: f64,
        edges: MotifEdges,
    ) -> Result<Option<Self>, SurfaceError> {
        Ok(Self::with_course_lines(heights, grid, wolf, edges)?.map(|(features, _)| features))
    }

    /// Finds hills and dales as [`of`](Self::of), and the course lines between hills, `[nx, ny]`: points with another
    /// hill at the next point along x or y.
    ///
    /// # Errors
    /// The errors of [`of`](Self::of).
    pub fn with_course_lines(
        heights: &ArrayRef2<f64>,
        grid: &Grid,
        wolf: f64,
        edges: MotifEdges,
    ) -> Result<Option<(Self, Array2<bool>)>, SurfaceError> {
        let all = checked(heights, grid)?;
        if !(0.0..=1.0).contains(&wolf) {
            return Err(SurfaceError::Fraction { what: "Wolf pruning", found: wolf });
        }
        if all.len() >= NONE as usize {
            let most = NONE as usize - 1;
            return Err(SurfaceError::TooManyPoints { what: "a search for hills", most, found: all.len() });
        }
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let mut above: Vec<f64> = all.iter().map(|height| height - mean).collect();
        let highest = above.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = above.iter().copied().fold(f64::INFINITY, f64::min);
        if grid.is_line() || highest <= lowest {
            return Ok(None);
        }
        let least = wolf * (highest - lowest);
        let (hills, hill_of) = Map { heights: &above, grid, edges }.motifs(least);
        above.iter_mut().for_each(|height| *height = -*height);
        let (dales, _) = Map { heights: &above, grid, edges }.motifs(least);
        let [nx, ny] = grid.points();
        let wraps = edges == MotifEdges::Periodic;
        let lines = Array2::from_shape_fn((nx, ny), |(i, j)| {
            let own = hill_of[i * ny + j];
            let differs = |x: usize, y: usize| hill_of[(x % nx) * ny + y % ny] != own;
            ((wraps || i + 1 < nx) && differs(i + 1, j)) || ((wraps || j + 1 < ny) && differs(i, j + 1))
        });
        Ok(Some((Self { hills, dales }, lines)))
    }

    /// Returns S10z, the sum of the mean heights of the five highest peaks and the mean depths of the five deepest
    /// pits, length; `None` without peaks or pits.
    pub fn s10z(&self) -> Option<f64> {
        Some(self.hills.five? + self.dales.five?)
    }
}

/// Heights on a grid.
struct Map<'a> {
    heights: &'a [f64],
    grid: &'a Grid,
    edges: MotifEdges,
}

/// Sets that are joined; each has a smallest member by which it is known.
struct Sets(Vec<u32>);

impl Sets {
    fn find(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let next = self.0[self.0[member as usize] as usize];
            self.0[member as usize] = next;
            member = next;
        }
        member
    }
}

impl Map<'_> {
    /// Calls `visit` with the neighbours of a point and their distances.
    fn around(&self, point: usize, mut visit: impl FnMut(usize, f64)) {
        let ([nx, ny], [dx, dy]) = (self.grid.points(), self.grid.spacing());
        let (i, j) = (point / ny, point % ny);
        let wraps = self.edges == MotifEdges::Periodic;
        let moved = |at: usize, step: usize, n: usize| match (at + step, wraps) {
            // Steps are −1, 0, 1, less one.
            (0, false) => None,
            (0, true) => Some(n - 1),
            (next, _) if next <= n => Some(next - 1),
            (_, wraps) => wraps.then_some(0),
        };
        for a in 0..3 {
            let Some(x) = moved(i, a, nx) else { continue };
            for b in (0..3).filter(|b| (a, *b) != (1, 1)) {
                let Some(y) = moved(j, b, ny) else { continue };
                visit(
                    x * ny + y,
                    match (a, b) {
                        (1, _) => dy,
                        (_, 1) => dx,
                        _ => dx.hypot(dy),
                    },
                );
            }
        }
    }

    /// Finds the hills whose peaks are at least `least` above the highest saddle to a higher peak, and the hill of each
    /// point.
    ///
    /// Points are visited from the highest to the lowest one. A point without a higher neighbour is a peak; others
    /// belong to the hill of the steepest ascent. Where a point joins two regions, the lower one of their peaks has
    /// its highest saddle. If this peak is pruned, its region has no other peak that stays, so that one hill joins
    /// another (Wolf pruning equals persistence).
    fn motifs(&self, least: f64) -> (Motifs, Vec<u32>) {
        let heights = self.heights;
        let mut order: Vec<u32> = (0..heights.len() as u32).collect();
        order.par_sort_unstable_by(|a, b| heights[*b as usize].total_cmp(&heights[*a as usize]).then(a.cmp(b)));
        let mut hill_of = vec![NONE; heights.len()];
        // Hills are numbered from the highest peak down.
        let (mut peaks, mut regions, mut hills) = (Vec::new(), Sets(Vec::new()), Sets(Vec::new()));
        for point in order {
            let at = point as usize;
            let (mut steepest, mut higher) = (None::<(f64, f64, usize)>, [0_usize; 8]);
            let mut count = 0;
            self.around(at, |next, distance| {
                if hill_of[next] != NONE {
                    let slope = (heights[next] - heights[at]) / distance;
                    // Of equal slopes the higher point counts, of equal heights the one that is stored first.
                    let better = steepest.is_none_or(|(most, height, first)| {
                        slope > most
                            || (slope == most && (heights[next] > height || (heights[next] == height && next < first)))
                    });
                    if better {
                        steepest = Some((slope, heights[next], next));
                    }
                    higher[count] = next;
                    count += 1;
                }
            });
            let Some((.., ahead)) = steepest else {
                let own = peaks.len() as u32;
                hill_of[at] = own;
                peaks.push(point);
                regions.0.push(own);
                hills.0.push(own);
                continue;
            };
            let own = hill_of[ahead];
            hill_of[at] = own;
            for other in higher[..count].iter().map(|next| hill_of[*next]) {
                let [here, there] = [regions.find(own), regions.find(other)];
                if here == there {
                    continue;
                }
                let [kept, lower] = [here.min(there), here.max(there)];
                regions.0[lower as usize] = kept;
                if heights[peaks[lower as usize] as usize] - heights[at] < least {
                    let [joined, into] = if lower == here { [own, other] } else { [other, own] };
                    let [joined, into] = [hills.find(joined), hills.find(into)];
                    // A hill is known by its highest peak.
                    hills.0[joined.max(into) as usize] = joined.min(into);
                }
            }
        }
        let motifs = self.measure(&peaks, &hill_of, &mut hills);
        hill_of.iter_mut().for_each(|hill| *hill = hills.find(*hill));
        (motifs, hill_of)
    }

    /// Measures the hills that remain.
    fn measure(&self, peaks: &[u32], hill_of: &[u32], hills: &mut Sets) -> Motifs {
        let [nx, ny] = self.grid.points();
        let at_edge = |point: usize| [0, nx - 1].contains(&(point / ny)) || [0, ny - 1].contains(&(point % ny));
        let mut points = vec![0_usize; peaks.len()];
        let mut touches = vec![false; peaks.len()];
        for (point, hill) in hill_of.iter().enumerate() {
            let hill = hills.find(*hill) as usize;
            points[hill] += 1;
            touches[hill] |= at_edge(point);
        }
        let leaves_out = self.edges == MotifEdges::LeaveOut;
        let remaining: Vec<usize> =
            (0..peaks.len()).filter(|hill| points[*hill] > 0 && !(leaves_out && touches[*hill])).collect();
        let count = remaining.len();
        let mean = |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
        let peak = |hill: &usize| peaks[*hill] as usize;
        let heights: Vec<f64> = remaining.iter().take(HIGHEST).map(|hill| self.heights[peak(hill)]).collect();
        let inside = |point: &usize| self.edges == MotifEdges::Periodic || !at_edge(*point);
        let curvatures: Vec<f64> =
            remaining.iter().map(peak).filter(inside).map(|point| self.curvature(point)).collect();
        let [lx, ly] = self.grid.lengths();
        let [dx, dy] = self.grid.spacing();
        let covered: usize = remaining.iter().map(|hill| points[*hill]).sum();
        Motifs {
            count,
            density: count as f64 / (lx * ly),
            curvature: mean(&curvatures),
            five: mean(&heights),
            area: (count > 0).then(|| covered as f64 * dx * dy / count as f64),
        }
    }

    /// Returns −(h_xx + h_yy)/2 by central differences at a point that has neighbours.
    fn curvature(&self, point: usize) -> f64 {
        let ([nx, ny], [dx, dy]) = (self.grid.points(), self.grid.spacing());
        let (i, j) = (point / ny, point % ny);
        let at = |i: usize, j: usize| self.heights[(i % nx) * ny + j % ny];
        let here = at(i, j);
        let x = (at(i + 1, j) - 2.0 * here + at(i + nx - 1, j)) / (dx * dx);
        let y = (at(i, j + 1) - 2.0 * here + at(i, j + ny - 1)) / (dy * dy);
        -0.5 * (x + y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hills_of_a_wave() {
        let grid = Grid::new([40, 30], [4.0, 2.0]).unwrap();
        let tau = std::f64::consts::TAU;
        let heights = Array2::from_shape_fn((40, 30), |(i, j)| {
            1.0 + (tau * 2.0 * i as f64 / 40.0).cos() + (tau * j as f64 / 30.0).cos()
        });
        let found = Features::of(&heights, &grid, 0.05, MotifEdges::Periodic).unwrap().unwrap();
        assert_eq!((found.hills.count, found.dales.count), (2, 2));
        assert!((found.hills.density - 2.0 / 8.0).abs() < 1e-15);
        assert!((found.s10z().unwrap() - 4.0).abs() < 1e-12);
        assert!((found.hills.area.unwrap() - 4.0).abs() < 1e-12);
        let [qx, qy] = [tau * 2.0 / 4.0, tau / 2.0];
        let expected = 0.5 * (qx * qx + qy * qy);
        assert!((found.hills.curvature.unwrap() / expected - 1.0).abs() < 0.01, "{found:?}");
        // Hills of cosines meet at the dales along both axes.
        let lines = Features::with_course_lines(&heights, &grid, 0.05, MotifEdges::Periodic).unwrap().unwrap().1;
        for ((i, j), is_line) in lines.indexed_iter() {
            let near = |at: usize, period: usize| (at % period).abs_diff(period / 2) <= 1;
            assert!(!is_line || near(i, 20) || near(j, 30), "{i} {j}");
        }
        assert!((0..30).all(|j| (8..12).any(|i| lines[[i, j]])), "a line separates both hills");
        // The hill of the middle does not reach the edges along x; all reach those along y.
        let left = Features::of(&heights, &grid, 0.05, MotifEdges::LeaveOut).unwrap().unwrap();
        assert_eq!((left.hills.count, left.hills.five, left.hills.area, left.s10z()), (0, None, None, None));
        assert_eq!(Features::of(&Array2::zeros((40, 30)), &grid, 0.05, MotifEdges::All).unwrap(), None);
        assert!(Features::of(&heights, &grid, f64::NAN, MotifEdges::All).is_err());
        assert!(Features::of(&heights, &grid, 1.1, MotifEdges::All).is_err());
    }

    #[test]
    fn nothing_is_pruned_by_zero_and_all_but_one_by_one() {
        let grid = Grid::square(32, 1.0).unwrap();
        let heights = Array2::from_shape_fn((32, 32), |(i, j)| ((i * 7919 + j * 104_729) % 1009) as f64);
        let count = |wolf: f64| Features::of(&heights, &grid, wolf, MotifEdges::Periodic).unwrap().unwrap();
        let peaks = (0..1024).filter(|point| {
            let at = |i: usize, j: usize| heights[[i % 32, j % 32]];
            let (i, j) = (point / 32, point % 32);
            let higher = |(a, b): (usize, usize)| {
                let other = at(i + a + 31, j + b + 31);
                let first = ((i + a + 31) % 32) * 32 + (j + b + 31) % 32;
                other > at(i, j) || (other == at(i, j) && first < *point)
            };
            !(0..3).flat_map(|a| (0..3).map(move |b| (a, b))).any(|step| step != (1, 1) && higher(step))
        });
        assert_eq!(count(0.0).hills.count, peaks.count());
        let one = count(1.0);
        assert_eq!((one.hills.count, one.dales.count), (1, 1));
        assert!((one.hills.area.unwrap() - 1.0).abs() < 1e-12);
        assert!(count(0.0).hills.count > count(0.1).hills.count && count(0.1).hills.count > 1);
    }
}
