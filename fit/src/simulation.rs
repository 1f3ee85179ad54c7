//! The simulation of a least-squares problem by runs, which the workers of the caller make.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use crate::causes::{Change, Changeable};
use crate::problem::{Interrupted, Simulated};
use crate::runs::{Point, Runs};

/// Names by which a run has no derivative, and why.
pub type Underivable = BTreeMap<String, String>;

/// A piece of work by its number, which asks now and then, with the share that is done, whether to go on.
pub type Task<'a> = dyn Fn(usize, &dyn Fn(f64) -> bool) + Sync + 'a;

/// What does pieces of work: one after the other, or many side by side.
pub trait Workers {
    /// Does a number of pieces.
    ///
    /// # Errors
    /// [`Interrupted`].
    fn each(&self, count: usize, work: &Task<'_>) -> Result<(), Interrupted>;

    /// Hears of names by which a run has no derivative.
    fn underivable(&self, _names: Underivable) {}
}

/// Runs that workers make.
pub struct Simulation<'a> {
    /// The runs.
    pub runs: Runs<'a>,
    /// The workers.
    pub workers: &'a dyn Workers,
    /// Whether derivatives of runs take the place of runs nearby.
    pub is_exact: bool,
}

impl Simulation<'_> {
    /// Results of pieces of work.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn each<T: Send + Sync>(
        &self,
        count: usize,
        work: impl Fn(usize, &dyn Fn(f64) -> bool) -> T + Sync,
    ) -> Result<Vec<T>, Interrupted> {
        let slots: Vec<OnceLock<T>> = (0..count).map(|_| OnceLock::new()).collect();
        self.workers.each(count, &|place, goes_on| {
            slots[place].get_or_init(|| work(place, goes_on));
        })?;
        Ok(slots.into_iter().map(|slot| slot.into_inner().expect("each piece is done")).collect())
    }

    /// The same of each segment.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn by_segment<T: Send + Sync>(
        &self,
        work: impl Fn(usize, &dyn Fn(f64) -> bool) -> T + Sync,
    ) -> Result<Vec<T>, Interrupted> {
        self.each(self.runs.segments.len(), work)
    }

    /// Differences of vectors at the fitted samples, or at the validation samples.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn stacked(
        &self,
        vectors: &[Vec<f64>],
        tolerance: f64,
        is_validation: bool,
    ) -> Result<Vec<Vec<f64>>, Interrupted> {
        let (runs, number) = (&self.runs, self.runs.segments.len());
        let points: Vec<Point> = vectors.iter().map(|x| runs.point(x)).collect();
        let every = self.each(number * vectors.len(), |piece, goes_on| {
            runs.differences(piece % number, &points[piece / number], tolerance, goes_on)
        })?;
        Ok(every.chunks(number.max(1)).map(|own| runs.stacked(own, is_validation)).collect())
    }
}

impl Simulated for Simulation<'_> {
    fn differences(&self, vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        self.stacked(vectors, tolerance, false)
    }

    #[cfg(feature = "sensitivities")]
    fn near(&self, x: &[f64], vectors: &[Vec<f64>], tolerance: f64) -> Result<Vec<Vec<f64>>, Interrupted> {
        if !self.is_exact || vectors.is_empty() {
            return self.differences(vectors, tolerance);
        }
        let (runs, at) = (&self.runs, self.runs.point(x));
        let points: Vec<Point> = vectors.iter().map(|x| runs.point(x)).collect();
        let every = self.by_segment(|place, goes_on| {
            let mut underivable = Underivable::new();
            (runs.near(place, &at, &points, tolerance, goes_on, &mut underivable), underivable)
        })?;
        every.iter().for_each(|(_, underivable)| self.workers.underivable(underivable.clone()));
        let of_point = |point: usize| {
            let own: Vec<_> = every.iter().map(|(segment, _)| segment[point].clone()).collect();
            runs.stacked(&own, false)
        };
        Ok((0..vectors.len()).map(of_point).collect())
    }
}

impl Changeable for Simulation<'_> {
    fn signals(&self) -> Vec<String> {
        self.runs.experiment.compared().iter().map(|signal| (*signal).to_owned()).collect()
    }

    fn changed<'a>(&'a self, change: Change<'a>) -> Result<Box<dyn Simulated + 'a>, Interrupted> {
        Ok(Box::new(Simulation { runs: self.runs.changed(change), ..*self }))
    }
}
