use std::fmt::{self, Debug};

use gfmd_problem::Facts;

use crate::{COLUMNS, Cell};

/// Suffix of columns that hold a grid-converged limit.
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

/// Definition of a column where a predicate holds.
pub type Meaning<F = Facts> = (fn(&F) -> bool, &'static str);

/// Returns the first definition that applies to a problem.
pub(crate) fn meaning<F>(meanings: &[Meaning<F>], facts: &F) -> &'static str {
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
    /// Flash temperature of steady sliding.
    Heat,
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
    /// Two digits and `~`: the grid error is not known.
    Unsure,
}

/// Importance of a column in a table of limited width, from the least to the most important ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Importance {
    /// Cost of the search and its residual.
    Effort,
    /// Number that follows from others or refines one.
    Detail,
    /// Number that most readers look at.
    Usual,
    /// Number by which rows are told apart, or the answer.
    Main,
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
    /// The importance, by which tables that are too wide leave columns out.
    pub importance: Importance,
}

/// A kind of result whose numbers are columns: states of a contact, punches, surfaces.
pub trait Subject: Copy + Debug + 'static {
    /// Features of a problem that decide which columns its results have.
    type Facts: 'static;
    /// Input from which the values are computed.
    type Context<'a>;
    /// All columns, in the order in which they are printed.
    const COLUMNS: &'static [Column<Self>];
    /// Name of the column that tells the rows of a table apart.
    const KEY: &'static str;
}

/// States of a contact at rest, or of a path.
#[derive(Clone, Copy, Debug)]
pub struct State;

impl Subject for State {
    type Facts = Facts;
    type Context<'a> = crate::StateContext<'a>;
    const COLUMNS: &'static [Column] = COLUMNS;
    const KEY: &'static str = "p_star";
}

/// A number of a record: its name, its unit, its definition, and its value.
pub struct Column<S: Subject = State> {
    /// The name in a file.
    pub name: &'static str,
    /// The kind of quantity, such as "stress*length"; "1" without one.
    pub unit: &'static str,
    /// The kind of number.
    pub number: Number,
    /// The definitions, of which the first that applies is the one of a problem.
    pub meanings: &'static [Meaning<S::Facts>],
    /// The place in JSON: keys, and indices of lists, between dots. Empty for a number that is in files only.
    pub json: &'static str,
    /// True if files have the column, too.
    pub in_file: fn(&S::Facts) -> bool,
    /// True if the record of a problem has the column.
    pub present: fn(&S::Facts) -> bool,
    /// The reason why it has no value in a problem, whatever the state; `None` if it may have one.
    pub undefined: fn(&S::Facts) -> Option<&'static str>,
    /// The place in the tables that people read, if it is in one.
    pub head: Option<Head>,
    /// The source of the number.
    pub origin: Origin,
    /// The order, in the distance of the points, of the error of a limit on infinitely fine grids, if it is known.
    pub order: Option<f64>,
    /// The value.
    pub value: for<'a, 'b> fn(&'a S::Context<'b>) -> Cell,
}

impl<S: Subject> Clone for Column<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Subject> Copy for Column<S> {}

impl<S: Subject> fmt::Debug for Column<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Column {} ({})", self.name, self.unit)
    }
}

impl<S: Subject> Column<S> {
    pub(crate) const fn new(
        name: &'static str,
        unit: &'static str,
        meanings: &'static [Meaning<S::Facts>],
        value: fn(&S::Context<'_>) -> Cell,
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

    pub(crate) const fn in_file(self, in_file: fn(&S::Facts) -> bool) -> Self {
        Self { in_file, ..self }
    }

    pub(crate) const fn with(self, present: fn(&S::Facts) -> bool) -> Self {
        Self { present, ..self }
    }

    pub(crate) const fn unless(self, undefined: fn(&S::Facts) -> Option<&'static str>) -> Self {
        Self { undefined, ..self }
    }

    /// In the table of states.
    pub(crate) const fn head(self, word: &'static str, form: Form) -> Self {
        self.on(Table::State, word, form)
    }

    pub(crate) const fn on(self, table: Table, word: &'static str, form: Form) -> Self {
        Self { head: Some(Head { table, word, form, importance: Importance::Usual }), ..self }
    }

    /// Sets the importance in its table.
    const fn ranked(self, importance: Importance) -> Self {
        match self.head {
            Some(head) => Self { head: Some(Head { importance, ..head }), ..self },
            None => self,
        }
    }

    /// In its table a number by which rows are told apart, or the answer.
    pub(crate) const fn main(self) -> Self {
        self.ranked(Importance::Main)
    }

    /// In its table a number that follows from others or refines one.
    pub(crate) const fn detail(self) -> Self {
        self.ranked(Importance::Detail)
    }

    /// In its table the cost of the search.
    pub(crate) const fn effort(self) -> Self {
        self.ranked(Importance::Effort)
    }

    pub(crate) const fn by(self, origin: Origin) -> Self {
        Self { origin, ..self }
    }

    pub(crate) const fn of_order(self, order: Option<f64>) -> Self {
        Self { order, ..self }
    }

    /// Returns the definition in a problem.
    pub fn meaning(&self, facts: &S::Facts) -> &'static str {
        meaning(self.meanings, facts)
    }

    /// Returns the name of the number whose limit on infinitely fine grids the column has.
    pub fn limit_of(&self) -> Option<&'static str> {
        self.name.strip_suffix(LIMIT).filter(|_| self.origin == Origin::Grid)
    }

    /// Returns the cell of a number in a file. A count that is not whole, and a flag other than 0 and 1, stays what it
    /// is, so that a comparison notices it.
    pub fn stored(&self, value: f64) -> Cell {
        match self.number {
            Number::Count if value >= 0.0 && value.fract() == 0.0 => Cell::Count(value as u64),
            Number::Flag if value == 0.0 || value == 1.0 => Cell::Flag(value == 1.0),
            _ => Cell::Real(value),
        }
    }

    /// Computes the cell of a result.
    pub(crate) fn cell(&self, facts: &S::Facts, at: &S::Context<'_>) -> Cell {
        match (self.undefined)(facts) {
            Some(reason) => Cell::undefined(reason),
            None => (self.value)(at),
        }
    }
}
