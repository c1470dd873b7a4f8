use gfmd_vector::Share;

/// Visitor of all variables of a search in a fixed order, which either copies or replaces them. One function thus
/// serves to write a checkpoint and to resume from it, bit for bit.
///
/// Several processes visit in the same order. Numbers, counts and [`field`](Self::field) are alike on all of them;
/// [`rows`](Self::rows) belong to one process.
///
/// ```
/// use gfmd_relax::Visit;
///
/// struct Copy { numbers: Vec<f64> }
///
/// impl Visit for Copy {
///     fn number(&mut self, x: &mut f64) { self.numbers.push(*x); }
///     fn count(&mut self, n: &mut u64) { self.numbers.push(*n as f64); }
///     fn field(&mut self, x: &mut [f64]) { self.numbers.extend_from_slice(x); }
/// }
///
/// let mut copy = Copy { numbers: Vec::new() };
/// copy.number(&mut 0.5);
/// copy.flag(&mut true);
/// copy.field(&mut [1.5, 2.5]);
/// assert_eq!(copy.numbers, [0.5, 1.0, 1.5, 2.5]);
/// ```
pub trait Visit {
    /// Visits a real number.
    fn number(&mut self, x: &mut f64);

    /// Visits a natural number.
    fn count(&mut self, n: &mut u64);

    /// Visits an array of constant length, alike on all processes.
    fn field(&mut self, x: &mut [f64]);

    /// Visits the rows of this process of a field divided by `share`. By default, the process is alone.
    fn rows(&mut self, share: &Share, x: &mut [f64]) {
        let _ = share;
        self.field(x);
    }

    /// Visits rows in single precision, as [`rows`](Self::rows).
    fn single_rows(&mut self, share: &Share, x: &mut [f32]) {
        let _ = share;
        self.single(x);
    }

    /// Visits an array in single precision, alike on all processes.
    fn single(&mut self, x: &mut [f32]) {
        for x in x {
            let mut number = f64::from(*x);
            self.number(&mut number);
            *x = number as f32;
        }
    }

    /// Visits several real numbers.
    fn numbers(&mut self, numbers: &mut [&mut f64]) {
        numbers.iter_mut().for_each(|x| self.number(x));
    }

    /// Visits a boolean, as 0 or 1.
    fn flag(&mut self, yes: &mut bool) {
        let mut number = u64::from(*yes);
        self.count(&mut number);
        *yes = number != 0;
    }

    /// Visits a natural number below 2³².
    fn small(&mut self, n: &mut u32) {
        let mut number = u64::from(*n);
        self.count(&mut number);
        *n = number as u32;
    }
}

/// Variables of a checkpoint.
pub trait Variables {
    /// Visits every variable.
    fn visit(&mut self, visitor: &mut dyn Visit);
}
