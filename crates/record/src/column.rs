use gfmd_problem::Facts;

use crate::{At, Cell};

/// The end of the name of a column that has the limit of another on fine grids.
pub(crate) const LIMIT: &str = "_limit";

/// The source of a number: what determines it, and so how well a second computation repeats it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The fields of the state.
    Fields,
    /// The fields, as what rounding and the solver leave: small beside 1.
    Residual,
    /// The fields, as an estimate of what they would be on a finer grid, or of its error.
    Grid,
    /// The way to the state: iterations, increments, energy lost.
    Way,
    /// The clock.
    Clock,
}

/// The kind of number of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// A real number.
    Real,
    /// A count.
    Count,
    /// A flag, 1 or 0 in a file.
    Flag,
}

/// The meaning of a column where a predicate holds.
pub type Meaning = (fn(&Facts) -> bool, &'static str);

/// The first meaning that applies to a problem.
pub(crate) fn meaning(meanings: &[Meaning], facts: &Facts) -> &'static str {
    meanings.iter().find(|(applies, _)| applies(facts)).map_or("", |(_, meaning)| meaning)
}

/// The tables in which people read a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Load, approach, area, gap, cost.
    State,
    /// Energies of a step of a path.
    Energy,
    /// The lower face of a slab between two surfaces.
    LowerFace,
    /// Patches and conductance.
    Patches,
    /// Flow through the gap.
    Flow,
}

/// The way in which a table shows a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Five significant digits, as a power of ten.
    Size,
    /// The same, in a column that is left out if all its numbers are zero.
    SizeUnlessZero,
    /// Two significant digits, as a power of ten.
    Rough,
    /// Six decimals.
    Share,
    /// Four decimals.
    Ratio,
    /// A whole number, or one with a decimal.
    Whole,
    /// Yes or no.
    Flag,
}

/// The place of a column in the tables that people read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// The table.
    pub table: Table,
    /// The word above the numbers.
    pub word: &'static str,
    /// The digits.
    pub form: Form,
}

/// A number of a record: its name, its unit, its definition, and its value.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// The name in a file.
    pub name: &'static str,
    /// The kind of quantity, such as "stress*length"; "1" without one.
    pub unit: &'static str,
    /// The kind of number.
    pub number: Number,
    /// The definitions, of which the first that applies is the one of a problem.
    pub meanings: &'static [Meaning],
    /// The place in JSON: keys, and indices of lists, between dots. Empty for a number that is in files only.
    pub json: &'static str,
    /// True if files have the column, too.
    pub in_file: fn(&Facts) -> bool,
    /// True if the record of a problem has the column.
    pub present: fn(&Facts) -> bool,
    /// The reason why it has no value in a problem, whatever the state; `None` if it may have one.
    pub undefined: fn(&Facts) -> Option<&'static str>,
    /// The place in the tables that people read, if it is in one.
    pub head: Option<Head>,
    /// The source of the number.
    pub origin: Origin,
    /// The order, in the distance of the points, of the error of a limit on infinitely fine grids, if it is known.
    pub order: Option<f64>,
    /// The value.
    pub value: fn(&At) -> Cell,
}

impl Column {
    pub(crate) const fn new(
        name: &'static str,
        unit: &'static str,
        meanings: &'static [Meaning],
        value: fn(&At) -> Cell,
    ) -> Self {
        Self {
            name,
            unit,
            number: Number::Real,
            meanings,
            json: name,
            in_file: |_| true,
            present: |_| true,
            undefined: |_| None,
            head: None,
            origin: Origin::Fields,
            order: None,
            value,
        }
    }

    pub(crate) const fn count(self) -> Self {
        Self { number: Number::Count, ..self }
    }

    pub(crate) const fn flag(self) -> Self {
        Self { number: Number::Flag, ..self }
    }

    pub(crate) const fn at(self, json: &'static str) -> Self {
        Self { json, ..self }
    }

    pub(crate) const fn in_file(self, in_file: fn(&Facts) -> bool) -> Self {
        Self { in_file, ..self }
    }

    pub(crate) const fn with(self, present: fn(&Facts) -> bool) -> Self {
        Self { present, ..self }
    }

    pub(crate) const fn unless(self, undefined: fn(&Facts) -> Option<&'static str>) -> Self {
        Self { undefined, ..self }
    }

    /// In the table of states.
    pub(crate) const fn head(self, word: &'static str, form: Form) -> Self {
        self.on(Table::State, word, form)
    }

    pub(crate) const fn on(self, table: Table, word: &'static str, form: Form) -> Self {
        Self { head: Some(Head { table, word, form }), ..self }
    }

    pub(crate) const fn by(self, origin: Origin) -> Self {
        Self { origin, ..self }
    }

    pub(crate) const fn of_order(self, order: Option<f64>) -> Self {
        Self { order, ..self }
    }

    /// The definition in a problem.
    pub fn meaning(&self, facts: &Facts) -> &'static str {
        meaning(self.meanings, facts)
    }

    /// The name of the number of which the column has the limit on infinitely fine grids.
    pub fn limit_of(&self) -> Option<&'static str> {
        self.name.strip_suffix(LIMIT).filter(|_| self.origin == Origin::Grid)
    }

    /// The cell of a number in a file.
    pub fn stored(&self, value: f64) -> Cell {
        match self.number {
            Number::Count if value >= 0.0 => Cell::Count(value as u64),
            Number::Flag if !value.is_nan() => Cell::Flag(value != 0.0),
            _ => Cell::Real(value),
        }
    }

    /// The cell of a state.
    pub(crate) fn cell(&self, at: &At) -> Cell {
        match (self.undefined)(at.facts) {
            Some(reason) => Cell::undefined(reason),
            None => (self.value)(at),
        }
    }
}
