//! Bounded nonlinear least squares from many starts.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints, DenseMatrix, Jacobian,
    PointState, Residual, RobustLeastSquares, Solver, State, TrustRegionReflective,
};
use nalgebra::DMatrix;
use pneumatic_servo::numbers::random;

use crate::arrays::mean;
use crate::jacobian::jacobian;
use crate::matrix::triangle;
use crate::number::{Number, numbers, plain};
use crate::parameter::Values;
use crate::problem::{Interrupted, Problem, TOLERANCE};

/// Best starts that are refined.
pub const REFINED: usize = 3;
/// Spread of starts without bounds about the first: a factor of five, or this number of magnitudes.
const SPREAD: f64 = 1.6;
/// Mean square of residuals, in units of the noise, at which no other start can lead to anything better.
pub const AT_NOISE: f64 = 1.5;
/// Relative difference of costs below which two solutions are taken for the same.
const SAME: f64 = 1e-3;
/// Vectors in a row that end a rough search, if they have gained less than a share of the cost together.
const LOOKED: usize = 8;
const GAINED: f64 = 0.02;
/// Vectors that are tried at most.
const MOST: usize = 80;
const SETTLED: &str = "the cost no longer changes";
/// Scaled gradient at which a search ends.
const FLAT: f64 = 1e-10;
/// A start of a smaller part of the magnitudes of its places has no length.
const SHORT: f64 = 1e-3;
/// Starts that are simulated at once.
const CHUNK: usize = 32;
/// Alternations between the fits of sensors and parameters, and the relative change of the noise that no longer matters.
const ROUNDS: usize = 4;
const SAME_NOISE: f64 = 0.03;

/// Accuracy of a search's descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Relative change of the cost at which it ends.
    pub cost: f64,
    /// Relative change of the vector at which it ends.
    pub step: f64,
    /// Relative tolerance of the solver.
    pub tolerance: f64,
    /// Whether derivatives are central differences, which take twice as many runs.
    pub is_central: bool,
    /// Whether it ends as well where several vectors in a row have gained little, as along a valley of a model that does not
    /// describe the data.
    pub gives_up: bool,
}

/// For a search that another one continues.
pub const ROUGH: Effort = Effort { cost: 1e-4, step: 1e-5, tolerance: 1e-5, is_central: false, gives_up: true };
/// For the last one.
pub const FINE: Effort = Effort { cost: 1e-6, step: 1e-8, tolerance: TOLERANCE, is_central: true, gives_up: false };

/// Function of the residuals whose sum is made least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Squares.
    Linear,
    /// Smooth absolute values.
    SoftL1,
    /// Squares of small residuals, magnitudes of large ones.
    Huber,
    /// Logarithms of large residuals.
    Cauchy,
}

impl std::str::FromStr for Loss {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "linear" => Ok(Self::Linear),
            "soft_l1" => Ok(Self::SoftL1),
            "huber" => Ok(Self::Huber),
            "cauchy" => Ok(Self::Cauchy),
            _ => Err(format!("loss = {name} is refused: it must be linear, soft_l1, huber or cauchy")),
        }
    }
}

/// The end of a refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Its vector.
    pub x: Vec<f64>,
    /// Half the sum of the squares, or of the losses.
    pub cost: f64,
    /// Whether the search has come to its end.
    pub converged: bool,
    /// Why it has ended.
    pub message: String,
}

impl Solution {
    fn new(x: Vec<f64>, cost: f64, converged: bool, message: &str) -> Self {
        Self { x, cost, converged, message: message.to_owned() }
    }
}

/// An observer of searches.
pub trait Watch {
    /// Takes notice of a vector, the values that it stands for, and the mean square of its residuals in units of the noise.
    ///
    /// # Errors
    /// [`Interrupted`], to end the search.
    fn see(&self, _x: &[f64], _values: &Values, _mean_square: f64) -> Result<(), Interrupted> {
        Ok(())
    }

    /// Takes notice of a stage that begins, whose misfits are not to be compared with those before.
    fn stage(&self, _text: &str) {}

    /// Takes notice of how far a stage has come.
    fn done(&self, _text: &str) {}

    /// Takes notice, before the first search, of parameters that the data hardly tell at the start values.
    fn hidden(&self, _names: &[String]) {}
}

/// Nobody.
pub struct Unwatched;

impl Watch for Unwatched {}

/// Why an evaluation ends a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    Interrupted,
    TooMany,
    Settled,
    Still,
    Stalled,
}

impl From<Interrupted> for Stop {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

impl Stop {
    fn message(self) -> String {
        match self {
            Self::Interrupted => "it was interrupted".to_owned(),
            Self::TooMany => format!("{MOST} parameter vectors were evaluated"),
            Self::Settled => SETTLED.to_owned(),
            Self::Still => "the vector no longer changes".to_owned(),
            Self::Stalled => format!("{LOOKED} steps in a row have gained little"),
        }
    }
}

/// A vector with its residuals: of the data, then of the priors.
struct Evaluated {
    y: Vec<f64>,
    differences: Vec<f64>,
    residuals: Vec<f64>,
}

/// A vector, and the Jacobian of the residuals there.
type Slopes = (Vec<f64>, Rc<DMatrix<f64>>);

/// Residuals and their Jacobian as the search sees them: by vectors that are scaled so that all columns of the first Jacobian
/// have the same length, and, for sums of squares, rotated for each vector so that few rows are left.
struct Objective<'a> {
    problem: &'a Problem<'a>,
    effort: Effort,
    watch: &'a dyn Watch,
    is_short: bool,
    scale: Vec<f64>,
    /// The scaled start, and the start itself, which scaling and back may move by a rounding error, out of what a law allows.
    begin: (Vec<f64>, Vec<f64>),
    low: Vec<Number>,
    high: Vec<Number>,
    last: RefCell<Option<Rc<Evaluated>>>,
    /// The last Jacobian of the residuals, unscaled, and its vector.
    slopes: RefCell<Option<Slopes>>,
    /// The best costs after each vector.
    costs: RefCell<Vec<f64>>,
    best: RefCell<Vec<f64>>,
    /// Vectors since the last Jacobian, and between it and the one before.
    tried: Cell<usize>,
    attempts: Cell<usize>,
    /// The cost at the last Jacobian.
    from: Cell<f64>,
    /// Whether vectors are steps: the solver may first move a start off its bounds, by less than what ends a search.
    is_begun: Cell<bool>,
}

impl<'a> Objective<'a> {
    fn new(
        problem: &'a Problem<'a>,
        start: &[f64],
        loss: Loss,
        effort: Effort,
        watch: &'a dyn Watch,
    ) -> Result<Self, Stop> {
        let (low, high) = problem.bounds();
        let x: Vec<f64> = inside(start, &low, &high);
        let mut objective = Self {
            problem,
            effort,
            watch,
            is_short: loss == Loss::Linear,
            scale: vec![1.0; x.len()],
            begin: (x.clone(), x.clone()),
            low: vec![],
            high: vec![],
            last: RefCell::default(),
            slopes: RefCell::default(),
            costs: RefCell::default(),
            best: RefCell::default(),
            tried: Cell::new(0),
            attempts: Cell::new(0),
            from: Cell::new(f64::INFINITY),
            is_begun: Cell::new(false),
        };
        let first = objective.at(&x)?;
        let slopes = objective.slopes_at(&first)?;
        let norms: Vec<f64> = slopes.column_iter().map(|column| column.norm()).collect();
        objective.scale = norms.iter().map(|norm| if *norm > 0.0 { *norm } else { 1.0 }).collect();
        let scaled = |values: &[f64]| values.iter().zip(&objective.scale).map(|(value, scale)| value * scale).collect();
        let (y, low, high): (Vec<f64>, Vec<f64>, Vec<f64>) = (scaled(&x), scaled(&low), scaled(&high));
        (objective.low, objective.high) = (numbers(&low), numbers(&high));
        let Evaluated { differences, residuals, .. } = &*first;
        let again = Evaluated { y: y.clone(), differences: differences.clone(), residuals: residuals.clone() };
        objective.last.replace(Some(Rc::new(again)));
        objective.begin = (y.clone(), x);
        objective.slopes.replace(Some((y, slopes)));
        Ok(objective)
    }

    fn outer(&self, y: &[f64]) -> Vec<f64> {
        let (scaled, start) = &self.begin;
        if y == scaled {
            return start.clone();
        }
        y.iter().zip(&self.scale).map(|(value, scale)| value / scale).collect()
    }

    /// Simulates a vector, unless it was the last one.
    fn at(&self, y: &[f64]) -> Result<Rc<Evaluated>, Stop> {
        if let Some(last) = self.last.borrow().as_ref().filter(|last| last.y == y) {
            return Ok(Rc::clone(last));
        }
        if self.costs.borrow().len() >= MOST {
            return Err(Stop::TooMany);
        }
        let x = self.outer(y);
        let mut runs = self.problem.simulated.differences(std::slice::from_ref(&x), self.effort.tolerance)?;
        let differences = runs.swap_remove(0);
        let mut residuals = self.problem.residuals(&differences);
        let squares: Vec<f64> = residuals.iter().map(|value| value * value).collect();
        self.watch.see(&x, &self.problem.values(&x), mean(&squares))?;
        residuals.extend(self.problem.prior(&x));
        self.tried.set(self.tried.get() + 1);
        let found = Rc::new(Evaluated { y: y.to_vec(), differences, residuals });
        self.last.replace(Some(Rc::clone(&found)));
        if self.is_short {
            self.follow(&x, 0.5 * squared(&found.residuals))?;
        } else {
            self.costs.borrow_mut().push(0.0);
        }
        self.moves(y)?;
        Ok(found)
    }

    /// Keeps the best vector.
    fn follow(&self, x: &[f64], cost: f64) -> Result<(), Stop> {
        let mut costs = self.costs.borrow_mut();
        let least = costs.last().copied().unwrap_or(f64::INFINITY);
        if cost < least || costs.is_empty() {
            self.best.replace(x.to_vec());
        }
        costs.push(cost.min(least));
        // A step that was shortened may gain little though a longer one would not.
        let gained = self.from.get() - cost;
        if self.is_begun.get() && self.tried.get() == 1 && gained >= 0.0 && gained < self.effort.cost * self.from.get()
        {
            return Err(Stop::Settled);
        }
        let is_stalled = costs.len() > LOOKED && cost.min(least) > (1.0 - GAINED) * costs[costs.len() - 1 - LOOKED];
        if self.effort.gives_up && is_stalled { Err(Stop::Stalled) } else { Ok(()) }
    }

    /// The best vector and its cost, or others if these are as good.
    fn best_or(&self, y: &[f64], cost: f64) -> (Vec<f64>, f64) {
        let least = self.costs.borrow().last().copied().unwrap_or(cost);
        if self.is_short && least < cost { (self.best.borrow().clone(), least) } else { (self.outer(y), cost) }
    }

    /// Ends the search where a trial is next to the vector that it begins at.
    fn moves(&self, y: &[f64]) -> Result<(), Stop> {
        let slopes = self.slopes.borrow();
        let Some((from, _)) = slopes.as_ref() else { return Ok(()) };
        let (trial, from) = (self.outer(y), self.outer(from));
        let step: Vec<f64> = trial.iter().zip(&from).map(|(trial, from)| trial - from).collect();
        let least = self.effort.step * (self.effort.step + squared(&from).sqrt());
        if self.tried.get() > 1 && squared(&step).sqrt() < least { Err(Stop::Still) } else { Ok(()) }
    }

    /// Jacobian of the residuals at a vector, unscaled, with the priors.
    fn slopes_at(&self, at: &Evaluated) -> Result<Rc<DMatrix<f64>>, Stop> {
        if let Some((_, slopes)) = self.slopes.borrow().as_ref().filter(|(y, _)| *y == at.y) {
            return Ok(Rc::clone(slopes));
        }
        let Effort { tolerance, is_central, .. } = self.effort;
        let of_data = jacobian(self.problem, &self.outer(&at.y), &at.differences, tolerance, is_central)?;
        let (rows, count) = of_data.shape();
        let mut slopes = of_data.resize_vertically(rows + count, 0.0);
        for (place, slope) in self.problem.prior_slopes().into_iter().enumerate() {
            slopes[(rows + place, place)] = slope;
        }
        let slopes = Rc::new(slopes);
        self.slopes.replace(Some((at.y.clone(), Rc::clone(&slopes))));
        self.attempts.set(self.tried.replace(0));
        self.from.set(0.5 * squared(&at.residuals));
        Ok(slopes)
    }
}

impl Constraints for Objective<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<Number>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.low), Some(&self.high)))
    }
}

impl Residual for Objective<'_> {
    type Param = Vec<Number>;
    type Output = Vec<Number>;
    type Error = Stop;

    fn residual(&self, y: &Vec<Number>) -> Result<Vec<Number>, Stop> {
        let found = self.at(&plain(y))?;
        if !self.is_short {
            return Ok(numbers(&found.residuals));
        }
        let mut short = vec![0.0; y.len() + 1];
        short[0] = squared(&found.residuals).sqrt();
        Ok(numbers(&short))
    }
}

impl Jacobian for Objective<'_> {
    type Jacobian = DenseMatrix<Number>;

    fn jacobian(&self, y: &Vec<Number>) -> Result<DenseMatrix<Number>, Stop> {
        let at = self.at(&plain(y))?;
        let mut slopes = (*self.slopes_at(&at)?).clone();
        for (mut column, scale) in slopes.column_iter_mut().zip(&self.scale) {
            column /= *scale;
        }
        if self.is_short {
            let whole = triangle(&slopes.insert_column(0, 0.0).tap_column(0, &at.residuals));
            let sign = 1f64.copysign(whole[(0, 0)]);
            slopes = whole.columns(1, y.len()) * sign;
        }
        // Row by row, where nalgebra goes by columns.
        Ok(DenseMatrix::from_row_slice(slopes.nrows(), slopes.ncols(), &numbers(slopes.transpose().as_slice())))
    }
}

/// Fills a column of a matrix.
trait TapColumn {
    fn tap_column(self, place: usize, values: &[f64]) -> Self;
}

impl TapColumn for DMatrix<f64> {
    fn tap_column(mut self, place: usize, values: &[f64]) -> Self {
        self.column_mut(place).copy_from_slice(values);
        self
    }
}

fn squared(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// A vector strictly within bounds.
fn inside(x: &[f64], low: &[f64], high: &[f64]) -> Vec<f64> {
    let one = |((x, low), high): ((&f64, &f64), &f64)| {
        let margin = 1e-9 * (1.0 + x.abs());
        x.max(low + margin).min(high - margin)
    };
    x.iter().zip(low).zip(high).map(one).collect()
}

/// Descends from a start.
///
/// # Errors
/// [`Interrupted`], if the simulation or the observer says so.
pub fn refine(
    problem: &Problem<'_>,
    start: &[f64],
    loss: Loss,
    effort: Effort,
    watch: &dyn Watch,
) -> Result<Solution, Interrupted> {
    let objective = match Objective::new(problem, start, loss, effort, watch) {
        Ok(objective) => objective,
        Err(_) => return Err(Interrupted),
    };
    match loss {
        Loss::Linear => descend(objective, |problem| problem),
        Loss::SoftL1 => robust(objective, basin::SoftL1Loss),
        Loss::Huber => robust(objective, basin::HuberLoss),
        Loss::Cauchy => robust(objective, basin::CauchyLoss),
    }
}

fn robust<L: basin::LossFunction<Number>>(objective: Objective<'_>, loss: L) -> Result<Solution, Interrupted> {
    descend(RobustLeastSquares::new(objective, loss), RobustLeastSquares::inner)
}

fn descend<'a, P>(problem: P, objective: impl Fn(&P) -> &Objective<'a>) -> Result<Solution, Interrupted>
where
    TrustRegionReflective<Number>: Solver<P, PointState<Vec<Number>, Number>, Error = ConstraintSolveError<Stop>>,
{
    let mut problem = basin::Problem::new(problem);
    let own = objective(problem.inner());
    let begin = own.last.borrow().as_ref().map(|last| last.y.clone()).unwrap_or_default();
    let effort = own.effort;
    // The first step is as long as the start, which next to 0 is no length.
    let unit = squared(&own.scale).sqrt();
    let radius = (squared(&begin).sqrt() < SHORT * unit).then_some(Number(unit));
    let solver = TrustRegionReflective::new().with_absolute_scaled_gradient_tolerance(Number(FLAT));
    let mut solver = solver.with_initial_radius(radius);
    let mut state = solver.init(&mut problem, PointState::new(numbers(&begin))).map_err(|_| Interrupted)?;
    objective(problem.inner()).is_begun.set(true);
    loop {
        let (y, before) = (plain(state.param()), state.cost().0);
        let own = |problem: &basin::Problem<P>, y: &[f64]| objective(problem.inner()).outer(y);
        if solver.check_convergence(&problem, &state).is_some() {
            return Ok(Solution::new(own(&problem, &y), before, true, "the gradient vanishes"));
        }
        match solver.next_iter(&mut problem, state) {
            Ok(step) => {
                let termination;
                (state, _, termination) = step.into_parts();
                let cost = state.cost().0;
                let end = |message| Ok(Solution::new(own(&problem, &plain(state.param())), cost, true, message));
                if termination.is_some() {
                    return end("no step lowers the cost any more");
                }
                if objective(problem.inner()).attempts.get() <= 1 && before - cost < effort.cost * before {
                    return end(SETTLED);
                }
            }
            Err(ConstraintSolveError::Evaluation(Stop::Interrupted)) => return Err(Interrupted),
            Err(ConstraintSolveError::Evaluation(stop)) => {
                let (x, cost) = objective(problem.inner()).best_or(&y, before);
                return Ok(Solution::new(x, cost, matches!(stop, Stop::Still | Stop::Settled), &stop.message()));
            }
            Err(other) => unreachable!("bounds are checked where they are given: {other:?}"),
        }
    }
}

/// The best solution of several starts: the first start is refined; unless its residual is no more than noise, random ones are
/// simulated and the best of them refined, until one leaves no more than noise or two have come to the same end.
///
/// # Errors
/// [`Interrupted`].
pub fn solve(
    problem: &Problem<'_>,
    starts: usize,
    seed: u64,
    loss: Loss,
    watch: &dyn Watch,
) -> Result<Solution, Interrupted> {
    let mut solutions = vec![refine(problem, &problem.start(), loss, ROUGH, watch)?];
    if starts > 0 && !is_enough(problem, &solutions) {
        let candidates = scattered(problem, starts, seed);
        let mut costs = Vec::new();
        for chunk in candidates.chunks(CHUNK) {
            costs.extend(self::costs(problem, chunk)?);
            watch.done(&format!("start {} of {starts}", costs.len()));
        }
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by(|one, other| costs[*one].total_cmp(&costs[*other]));
        for index in order.into_iter().take(REFINED - 1) {
            watch.done("search from another start");
            solutions.push(refine(problem, &candidates[index], loss, ROUGH, watch)?);
            if is_enough(problem, &solutions) {
                break;
            }
        }
    }
    solutions.sort_by(|one, other| one.cost.total_cmp(&other.cost).then(other.converged.cmp(&one.converged)));
    Ok(solutions.swap_remove(0))
}

/// Whether the last solution leaves no more than noise, or the two best are the same.
fn is_enough(problem: &Problem<'_>, solutions: &[Solution]) -> bool {
    let mut costs: Vec<f64> = solutions.iter().map(|solution| solution.cost).collect();
    if 2.0 * costs[costs.len() - 1] < AT_NOISE * problem.size() as f64 {
        return true;
    }
    costs.sort_by(f64::total_cmp);
    costs.len() > 1 && costs[1] <= (1.0 + SAME) * costs[0]
}

/// Sums of the squares of the residuals of vectors.
///
/// # Errors
/// [`Interrupted`].
pub fn costs(problem: &Problem<'_>, vectors: &[Vec<f64>]) -> Result<Vec<f64>, Interrupted> {
    let runs = problem.simulated.differences(vectors, ROUGH.tolerance)?;
    Ok(runs.iter().map(|differences| squared(&problem.residuals(differences))).collect())
}

/// Starts that fill the bounds, or the neighbourhood of the first start, evenly: each parameter has one in each part of its
/// range (a Latin hypercube: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21, 1979).
pub fn scattered(problem: &Problem<'_>, number: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut state = seed;
    let first = problem.start();
    let (low, high) = problem.bounds();
    let mut found = vec![first.clone(); number];
    for place in 0..problem.parameters.len() {
        let least = low[place].max(first[place] - SPREAD);
        let most = high[place].min(first[place] + SPREAD);
        let mut order: Vec<usize> = (0..number).collect();
        for index in (1..number).rev() {
            order.swap(index, (random::next(&mut state) % (index as u64 + 1)) as usize);
        }
        for (x, part) in found.iter_mut().zip(order) {
            let share = (part as f64 + 1.0 - random::uniform(&mut state)) / number as f64;
            x[place] = least + share * (most - least);
        }
    }
    found
}

/// Weighs the signals by their residuals and fits anew, until both agree: a signal that the model misses must not drown the
/// others, and a converter is only known once the rest is. The last search is a fine one.
///
/// # Errors
/// [`Interrupted`].
pub fn with_likely_sensors<'a>(
    mut problem: Problem<'a>,
    mut best: Solution,
    loss: Loss,
    watch: &dyn Watch,
) -> Result<(Problem<'a>, Solution), Interrupted> {
    for _ in 0..ROUNDS {
        let runs = problem.simulated.differences(std::slice::from_ref(&best.x), TOLERANCE)?;
        let likely = problem.likely_sensors(&runs[0]);
        let change = |(after, before): (&crate::sensor::Sensor, &crate::sensor::Sensor)| {
            libm::log(after.noise / before.noise).abs()
        };
        let most = likely.iter().zip(&problem.sensors).map(change).fold(0.0, f64::max);
        problem.sensors = likely;
        if most < SAME_NOISE {
            break;
        }
        watch.stage("sensors");
        best = refine(&problem, &best.x, loss, ROUGH, watch)?;
    }
    watch.stage("last refinement");
    let best = refine(&problem, &best.x, loss, FINE, watch)?;
    Ok((problem, best))
}
