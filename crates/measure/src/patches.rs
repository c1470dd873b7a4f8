use ndarray::{Array2, ArrayView2};

use crate::Boundary;

/// Connected patch of points. Neighbours are the four nearest points along x and along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Number of points.
    pub points: u64,
    /// Pairs of neighbours along x with one point in the patch and the other in none, and the same along y. The edge of
    /// a field that does not repeat has no links. The links of all patches add up to the links of
    /// [`contact_area`](crate::contact_area).
    pub links: [u64; 2],
    /// Mean of the indices of the points, within the field; NaN along an axis around which the patch winds.
    pub centre: [f64; 2],
    /// True along x (y) if the patch winds around the cell in that direction or, in a field that does not repeat,
    /// reaches from edge to edge.
    pub percolates: [bool; 2],
}

/// Patches of a set of points on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// Patch number of each point, counted from 1; 0 outside of patches.
    pub labels: Array2<u32>,
    /// Patches in the order of their first points.
    pub patches: Vec<Patch>,
}

impl Patches {
    /// Finds the patches of the points at which the field `belongs` is true.
    pub fn of(belongs: ArrayView2<bool>, boundary: Boundary) -> Self {
        let (nx, ny) = belongs.dim();
        let mut groups = Groups::default();
        let mut labels = inside(belongs, &mut groups);
        if boundary == Boundary::Periodic {
            // An axis with one point has no neighbours along it.
            (0..ny).filter(|_| nx > 1).for_each(|j| groups.join([labels[[nx - 1, j]], labels[[0, j]]], [1, 0]));
            (0..nx).filter(|_| ny > 1).for_each(|i| groups.join([labels[[i, ny - 1]], labels[[i, 0]]], [0, 1]));
        }
        let mut numbers = vec![0; groups.len()];
        let mut shifts = vec![[0; 2]; groups.len()];
        let mut patches = Vec::new();
        for label in 1..groups.len() {
            let (root, shift) = groups.find(label as u32);
            if numbers[root as usize] == 0 {
                let percolates = groups.winds[root as usize];
                patches.push(Patch { points: 0, links: [0; 2], centre: [0.0; 2], percolates });
                numbers[root as usize] = patches.len() as u32;
            }
            (numbers[label], shifts[label]) = (numbers[root as usize], shift);
        }
        labels.indexed_iter_mut().filter(|(_, label)| **label > 0).for_each(|((i, j), label)| {
            let shift = shifts[*label as usize];
            *label = numbers[*label as usize];
            let patch = &mut patches[*label as usize - 1];
            patch.points += 1;
            for (axis, (index, n)) in [(i, nx), (j, ny)].into_iter().enumerate() {
                patch.centre[axis] += index as f64 + f64::from(shift[axis]) * n as f64;
            }
        });
        let mut made = Self { labels, patches };
        made.measure(boundary);
        made
    }

    fn measure(&mut self, boundary: Boundary) {
        let (nx, ny) = self.labels.dim();
        let Self { labels, patches } = self;
        let mut reached = vec![[[false; 2]; 2]; patches.len()];
        for ((i, j), label) in labels.indexed_iter().filter(|(_, label)| **label > 0) {
            let number = *label as usize - 1;
            for (axis, (index, n)) in [(i, nx), (j, ny)].into_iter().enumerate() {
                reached[number][axis][0] |= index == 0;
                reached[number][axis][1] |= index + 1 == n;
                for (step, leaves) in [(n - 1, index == 0), (1, index + 1 == n)] {
                    let mut beside = [i, j];
                    beside[axis] = (index + step) % n;
                    let is_edge = leaves && boundary == Boundary::Free;
                    patches[number].links[axis] += u64::from(!is_edge && labels[beside] == 0);
                }
            }
        }
        for (patch, reached) in patches.iter_mut().zip(reached) {
            for (axis, n) in [nx, ny].into_iter().enumerate() {
                if boundary == Boundary::Free {
                    patch.percolates[axis] = n > 1 && reached[axis] == [true; 2];
                }
                let winds = boundary == Boundary::Periodic && patch.percolates[axis];
                let mean = (patch.centre[axis] / patch.points as f64).rem_euclid(n as f64);
                patch.centre[axis] = if winds { f64::NAN } else { mean };
            }
        }
    }

    /// Returns the largest number of points of a patch; 0 without patches.
    pub fn largest(&self) -> u64 {
        self.patches.iter().map(|patch| patch.points).max().unwrap_or(0)
    }

    /// Returns true along x (y) if any patch percolates in that direction.
    pub fn percolate(&self) -> [bool; 2] {
        [0, 1].map(|axis| self.patches.iter().any(|patch| patch.percolates[axis]))
    }

    /// Returns the sums of `values` over the points of each patch.
    pub fn sums(&self, values: ArrayView2<f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.patches.len() + 1];
        self.labels.iter().zip(values).for_each(|(label, value)| sums[*label as usize] += value);
        sums.split_off(1)
    }
}

/// Labels connected points inside the edges. Points with different labels may belong to one group.
fn inside(belongs: ArrayView2<bool>, groups: &mut Groups) -> Array2<u32> {
    let (nx, ny) = belongs.dim();
    let mut labels = Array2::zeros((nx, ny));
    for i in 0..nx {
        let mut before = 0;
        for j in 0..ny {
            if !belongs[[i, j]] {
                before = 0;
                continue;
            }
            let above = if i > 0 { labels[[i - 1, j]] } else { 0 };
            let label = match (before, above) {
                (0, 0) => groups.add(),
                (0, above) => above,
                (before, 0) => before,
                (before, above) => {
                    if before != above {
                        groups.join([before, above], [0, 0]);
                    }
                    before
                }
            };
            labels[[i, j]] = label;
            before = label;
        }
    }
    labels
}

/// Groups of labels, each with its cell in the periodic plane relative to another label of the group (union-find with
/// distances, Newman and Ziff 2001): a group that meets itself one cell further winds around the cell.
struct Groups {
    parents: Vec<u32>,
    /// Cell of a label minus the cell of its parent.
    shifts: Vec<[i32; 2]>,
    winds: Vec<[bool; 2]>,
    sizes: Vec<u32>,
}

impl Default for Groups {
    /// The label 0 belongs to no patch.
    fn default() -> Self {
        Self { parents: vec![0], shifts: vec![[0; 2]], winds: vec![[false; 2]], sizes: vec![1] }
    }
}

impl Groups {
    fn len(&self) -> usize {
        self.parents.len()
    }

    fn add(&mut self) -> u32 {
        let label = self.parents.len() as u32;
        self.parents.push(label);
        self.shifts.push([0; 2]);
        self.winds.push([false; 2]);
        self.sizes.push(1);
        label
    }

    /// Returns the root of a label, and the cell of the label minus the cell of the root.
    fn find(&mut self, label: u32) -> (u32, [i32; 2]) {
        let (mut root, mut shift) = (label, [0; 2]);
        while self.parents[root as usize] != root {
            shift = plus(shift, self.shifts[root as usize]);
            root = self.parents[root as usize];
        }
        // Every label on the way gets the root as its parent.
        let (mut next, mut left) = (label, shift);
        while self.parents[next as usize] != root && next != root {
            let (parent, part) = (self.parents[next as usize], self.shifts[next as usize]);
            (self.parents[next as usize], self.shifts[next as usize]) = (root, left);
            left = [left[0] - part[0], left[1] - part[1]];
            next = parent;
        }
        (root, shift)
    }

    /// Joins the groups of two neighbours; the second lies `step` cells further than its indices.
    fn join(&mut self, [here, there]: [u32; 2], step: [i32; 2]) {
        if here == 0 || there == 0 {
            return;
        }
        let ((a, of_here), (b, of_there)) = (self.find(here), self.find(there));
        // Cell of root b minus the cell of root a.
        let apart = [0, 1].map(|axis| of_here[axis] + step[axis] - of_there[axis]);
        if a == b {
            [0, 1].into_iter().for_each(|axis| self.winds[a as usize][axis] |= apart[axis] != 0);
            return;
        }
        let (root, other, shift) =
            if self.sizes[a as usize] >= self.sizes[b as usize] { (a, b, apart) } else { (b, a, apart.map(|c| -c)) };
        self.parents[other as usize] = root;
        self.shifts[other as usize] = shift;
        self.sizes[root as usize] += self.sizes[other as usize];
        for axis in [0, 1] {
            let winds = self.winds[other as usize][axis];
            self.winds[root as usize][axis] |= winds;
        }
    }
}

fn plus(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(rows: &[&str]) -> Array2<bool> {
        Array2::from_shape_fn((rows.len(), rows[0].len()), |(i, j)| rows[i].as_bytes()[j] == b'#')
    }

    fn found(rows: &[&str], boundary: Boundary) -> Patches {
        Patches::of(drawn(rows).view(), boundary)
    }

    #[test]
    fn patches_are_joined_across_the_seam_and_only_if_the_field_repeats() {
        let rows = ["#..#", "....", ".#..", "#..."];
        let joined = found(&rows, Boundary::Periodic);
        assert_eq!(joined.patches.iter().map(|patch| patch.points).collect::<Vec<_>>(), [3, 1]);
        assert_eq!(joined.labels[[0, 0]], joined.labels[[0, 3]]);
        // Corners at (0, 0), (0, −1) and (−1, 0).
        assert_eq!(joined.patches[0].centre.map(|c| (c * 3.0).round()), [11.0, 11.0]);
        assert_eq!(joined.patches[0].links, [4, 4]);
        assert_eq!(joined.percolate(), [false; 2]);
        let apart = found(&rows, Boundary::Free);
        assert_eq!(apart.patches.iter().map(|patch| patch.points).collect::<Vec<_>>(), [1; 4]);
        let links: Vec<[u64; 2]> = apart.patches.iter().map(|patch| patch.links).collect();
        assert_eq!(links, [[1, 1], [1, 1], [2, 2], [1, 1]]);
    }

    #[test]
    fn winding_is_told_from_touching_all_edges() {
        let band = ["....", "####", "....", "...."];
        for boundary in [Boundary::Periodic, Boundary::Free] {
            assert_eq!(found(&band, boundary).percolate(), [false, true]);
        }
        // This patch reaches all edges but winds around none.
        let broken = ["#...", "##..", ".###", "...#"];
        assert_eq!(found(&broken, Boundary::Free).percolate(), [true, true]);
        assert_eq!(found(&broken, Boundary::Periodic).percolate(), [false, false]);
        let open = ["..#.", ".##.", ".#..", "...."];
        assert_eq!(found(&open, Boundary::Periodic).percolate(), [false, false]);
        // A step of (1, 1) around the cell winds both ways; two bands that meet only as images do not wind.
        let spiral = ["##...", ".##..", "..##.", "...##", "#...#"];
        assert_eq!(found(&spiral, Boundary::Periodic).percolate(), [true, true]);
        assert_eq!(found(&spiral, Boundary::Periodic).patches.len(), 1);
        let two_around = ["#.#.", "#.#.", "###.", "..#."];
        let patches = found(&two_around, Boundary::Periodic);
        assert_eq!((patches.percolate(), patches.patches.len()), ([true, false], 1));
        assert!(patches.patches[0].centre[0].is_nan() && patches.patches[0].centre[1].is_finite());
    }

    #[test]
    fn full_empty_and_flat_fields() {
        let full = Patches::of(Array2::from_elem((3, 5), true).view(), Boundary::Periodic);
        assert_eq!((full.largest(), full.percolate(), full.patches[0].links), (15, [true; 2], [0; 2]));
        let alone = Patches::of(Array2::from_elem((3, 5), true).view(), Boundary::Free);
        assert_eq!((alone.percolate(), alone.patches[0].links), ([true; 2], [0; 2]));
        let empty = Patches::of(Array2::from_elem((3, 5), false).view(), Boundary::Periodic);
        assert_eq!((empty.largest(), empty.percolate()), (0, [false; 2]));
        let line = found(&["#", "#", ".", "#"], Boundary::Periodic);
        assert_eq!((line.patches.len(), line.percolate(), line.patches[0].links), (1, [false; 2], [2, 0]));
    }

    #[test]
    fn links_and_areas_are_those_of_the_whole_contact() {
        let field = Array2::from_shape_fn((37, 26), |(i, j)| {
            (0.7 * i as f64 + (0.5 * j as f64).cos()).sin() + (1.3 * j as f64).sin() > 0.4
        });
        let pressure = field.mapv(|touches| if touches { 2.0 } else { 0.0 });
        let area = crate::contact_area(pressure.view(), Boundary::Periodic);
        let patches = Patches::of(field.view(), Boundary::Periodic);
        assert_eq!(
            patches.patches.iter().map(|patch| patch.links[0] + patch.links[1]).sum::<u64>(),
            area.boundary_links as u64
        );
        assert_eq!(patches.patches.iter().map(|patch| patch.points).sum::<u64>(), area.nodes as u64);
        for (patch, sum) in patches.patches.iter().zip(patches.sums(pressure.view())) {
            assert_eq!(sum, 2.0 * patch.points as f64);
        }
        // The patches do not change if the field moves around the cell.
        let moved = Array2::from_shape_fn((37, 26), |(i, j)| field[[(i + 5) % 37, (j + 11) % 26]]);
        let moved = Patches::of(moved.view(), Boundary::Periodic);
        let sorted = |patches: &Patches| {
            let mut all: Vec<_> = patches.patches.iter().map(|p| (p.points, p.links, p.percolates)).collect();
            all.sort();
            all
        };
        assert_eq!(sorted(&moved), sorted(&patches));
    }
}
