use gfmd_relax::{Variables, Visit};

/// Search for the load at which a monotonic excess vanishes, by false position: every load is either too small or too
/// large, and as soon as both are known the next one lies between them. If two tries in a row are on one side, the
/// excess of the other side is halved (Illinois variant), so that no side is kept indefinitely.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadSearch {
    load: f64,
    /// Load that is too small and load that is too large, with their excess.
    bracket: [Option<(f64, f64)>; 2],
    /// Index in `bracket` of the last load tried.
    last: Option<usize>,
}

impl Variables for LoadSearch {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.number(&mut self.load);
        for side in &mut self.bracket {
            let mut known = side.is_some();
            visitor.flag(&mut known);
            let (mut load, mut excess) = side.unwrap_or_default();
            visitor.number(&mut load);
            visitor.number(&mut excess);
            *side = known.then_some((load, excess));
        }
        // 0 for none, else the side from 1.
        let mut last = self.last.map_or(0, |side| side as u64 + 1);
        visitor.count(&mut last);
        self.last = (last.min(2) as usize).checked_sub(1);
    }
}

impl LoadSearch {
    pub(crate) fn from(load: f64) -> Self {
        Self { load, bracket: [None; 2], last: None }
    }

    /// Returns the load to try.
    pub(crate) fn load(&self) -> f64 {
        self.load
    }

    /// Chooses the next load from the excess at the last one. Returns false if there is none: the excess is NaN, or
    /// there is no number between the two known loads.
    pub(crate) fn learn(&mut self, excess: f64) -> bool {
        let side = usize::from(excess > 0.0);
        let again = self.last.replace(side) == Some(side);
        self.bracket[side] = Some((self.load, excess));
        if let ([Some(below), Some(above)], true) = (&mut self.bracket, again) {
            let other = if side == 0 { above } else { below };
            other.1 *= 0.5;
        }
        let between;
        (self.load, between) = match self.bracket {
            [Some(below), Some(above)] => {
                let load = (below.0 * above.1 - above.0 * below.1) / (above.1 - below.1);
                (load, below.0.min(above.0) < load && load < below.0.max(above.0))
            }
            [Some(_), None] => (2.0 * self.load, true),
            [None, _] => (0.5 * self.load, true),
        };
        between && self.load > 0.0 && self.load.is_finite() && !excess.is_nan()
    }
}

#[cfg(test)]
mod tests {
    use super::LoadSearch;

    /// Searches until the excess is small. Returns the load and the number of tries.
    fn search(start: f64, excess: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut search = LoadSearch::from(start);
        for tries in 1..100 {
            let found = excess(search.load());
            if found.abs() < 1e-12 {
                return (search.load(), tries);
            }
            assert!(search.learn(found), "{search:?}");
        }
        panic!("{search:?}");
    }

    #[test]
    fn the_load_is_found_from_either_side() {
        for start in [1e-3, 0.3, 1.0, 500.0] {
            let (load, tries) = search(start, |load: f64| load.powf(0.7) - 2.0);
            assert!((load - 2_f64.powf(1.0 / 0.7)).abs() < 1e-11 && tries < 25, "{start}: {load} after {tries}");
        }
    }

    #[test]
    fn a_search_without_an_end_ends() {
        let runs = |excess: fn(f64) -> f64| {
            let mut search = LoadSearch::from(1.0);
            (0..10_000).take_while(|_| search.learn(excess(search.load()))).count()
        };
        assert_eq!(runs(|_| f64::NAN), 0);
        assert!(runs(|_| -1.0) < 2000 && runs(|_| 1.0) < 2000);
        // At a jump the bracket shrinks until it contains no further number.
        assert!(runs(|load| if load < 1.3 { -1.0 } else { 1.0 }) < 200);
    }
}
