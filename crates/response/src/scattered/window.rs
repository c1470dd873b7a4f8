use std::ops::Range;

/// Neighbouring rows of a periodic field of `all` rows; the last row is followed by the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    start: usize,
    length: usize,
    all: usize,
}

impl Window {
    /// Creates the window of `rows` and of some rows before and behind them; all rows in order if these are no fewer.
    /// No rows have none around them.
    pub(super) fn around(rows: &Range<usize>, [before, behind]: [usize; 2], all: usize) -> Self {
        let length = before + rows.len() + behind;
        if rows.is_empty() {
            Self { start: 0, length: 0, all }
        } else if length >= all {
            Self { start: 0, length: all, all }
        } else {
            Self { start: (rows.start + all - before) % all, length, all }
        }
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.length
    }

    /// Returns true for all rows.
    pub(super) fn is_whole(&self) -> bool {
        self.length == self.all
    }

    /// Returns the row at this place in the window.
    pub(super) fn row(&self, place: usize) -> usize {
        (self.start + place) % self.all
    }

    /// Returns the place of a row in the window.
    pub(super) fn place(&self, row: usize) -> usize {
        (row + self.all - self.start) % self.all
    }

    /// Returns the rows up to the last one of the field, and those that follow from its first one on.
    pub(super) fn pieces(&self) -> [Range<usize>; 2] {
        let Range { start, end } = self.range();
        [start..end.min(self.all), 0..end.saturating_sub(self.all)]
    }

    /// Returns the rows, counted on past the last one.
    pub(super) fn range(&self) -> Range<usize> {
        self.start..self.start + self.length
    }
}
