//! The search of a fit: from measured segments to the vector that describes them best.
//!
//! Where measured forces move a mass, the data decide how they are used. Short segments forget the noise of a force; but each begins
//! without the deflection of its bristles, and smoothing wipes out the course of a force at a break-away: both pass into the
//! parameters. Where a force is exact, nothing has to be forgotten: each record is simulated as a whole, of laws with deflections
//! from a start that the balance of forces gives.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use pneumatic_servo::variables::Kind;

use crate::arrays::{mean, rms};
use crate::candidates::named;
use crate::causes::{Cause, Choice, DAMPING_SPEED};
use crate::distributions::student_quantile;
use crate::experiment::{Balance, Given, Inputs, MeasuredSegment, Options};
use crate::guess::started;
use crate::intervals::hidden;
use crate::numerals::significant;
use crate::parameter::Values;
use crate::problem::{FAILED, Interrupted, Simulated, TOLERANCE};
use crate::refused::{NoAnswer, Refused};
use crate::search::{
    AT_NOISE, Effort, FINE, Loss, ROUGH, Solution, Unwatched, Watch, refine, solve, with_likely_sensors,
};
use crate::sensor::Sensor;
use crate::simulation::Workers;
use crate::study::{Source, Study};

/// Units of parameters of laws that deflect.
const PRESLIDING: [&str; 3] = ["N/m", "1/m", "m"];
/// Length in s of segments that no record has.
const WHOLE: f64 = 1e9;
/// Step of the differences of runs, and the factor of the solver's tolerance, where nothing hides a small change.
const STEP: f64 = 1e-5;
const EXACTNESS: f64 = 1e-2;
/// Stretches of time whose residuals are compared, and how sure the better ones have to be.
const BLOCKS: usize = 20;
const SURE: f64 = 0.95;
/// Ratio of what two courses of inputs leave from which on only the better one is searched further.
const LIKE: f64 = 10.0;
/// RMS residual from which on a balance of forces is none.
const UNBALANCED: f64 = 1e9;
/// Courses of inputs between samples.
const INPUTS: [Inputs; 3] = [Inputs::Held, Inputs::Lines, Inputs::Smooth];

/// A search from several starts, which may be made elsewhere.
pub type Solver<'a> = dyn Fn(&Study, usize, &dyn Watch) -> Result<Solution, Interrupted> + 'a;

/// What a search is made with.
pub struct Search<'a> {
    /// What simulates.
    pub workers: &'a dyn Workers,
    /// Records, fitted and predicted ones.
    pub sources: &'a [Source],
    /// Random starts beside that from the data.
    pub starts: usize,
    /// Seed of these.
    pub seed: u64,
    /// Function of the residuals.
    pub loss: Loss,
    /// Searches from several starts, in place of [`solve`] here.
    pub solver: Option<&'a Solver<'a>>,
}

/// How far a search has come.
#[derive(Clone)]
pub struct Reached {
    /// The study, with validation data.
    pub study: Study,
    /// The same without them, whose vector is searched.
    pub fitted: Study,
    /// The end of the search, or the best until it was interrupted.
    pub best: Option<Solution>,
    /// The other form of a law whose form is fixed, where only whole records tell which one is right.
    pub other_form: Option<Cause>,
    /// Parameters that the data hardly tell at the start values.
    pub hidden: Vec<String>,
}

/// Keeps the best vector of the present stage, or of the last one that had any.
struct Best<'a> {
    watch: &'a dyn Watch,
    x: RefCell<Option<Vec<f64>>>,
    left: Cell<f64>,
}

impl Best<'_> {
    fn set(&self, x: &[f64]) {
        self.x.replace(Some(x.to_vec()));
    }
}

impl Watch for Best<'_> {
    fn see(&self, x: &[f64], values: &Values, mean_square: f64) -> Result<(), Interrupted> {
        let is_other = self.x.borrow().as_ref().is_none_or(|best| best.len() != x.len());
        if is_other || mean_square <= self.left.get() {
            self.set(x);
            self.left.set(mean_square.min(self.left.get()));
        }
        self.watch.see(x, values, mean_square)
    }

    fn stage(&self, text: &str) {
        self.left.set(f64::INFINITY);
        self.watch.stage(text);
    }

    fn done(&self, text: &str) {
        self.watch.done(text);
    }

    fn hidden(&self, names: &[String]) {
        self.watch.hidden(names);
    }
}

impl Search<'_> {
    /// Searches from starts that the data tell. `reached` is left at what was found, also by an interrupt.
    ///
    /// # Errors
    /// [`NoAnswer`].
    pub fn run(&self, study: Study, watch: &dyn Watch, reached: &mut Option<Reached>) -> Result<(), NoAnswer> {
        let best = Best { watch, x: RefCell::default(), left: Cell::new(f64::INFINITY) };
        let found = self.found(study, &best, reached);
        if let (Err(NoAnswer::Interrupted), Some(reached)) = (&found, reached) {
            let stopped =
                |x| Solution { x, cost: f64::NAN, converged: false, message: "it was interrupted".to_owned() };
            reached.best = best.x.take().map(stopped);
        }
        found
    }

    fn found(&self, mut study: Study, watch: &Best<'_>, reached: &mut Option<Reached>) -> Result<(), NoAnswer> {
        study.parameters = started(&*study.experiment, &study.segments, &study.parameters);
        let wholes = self.wholes(&study)?;
        let mut other_form = None;
        if let Some(wholes) = &wholes {
            (study, other_form) = self.begun_by_balance(wholes, study, watch)?;
            // Vectors of whole records are none of segments.
            watch.x.take();
        }
        let fitted = study.trained();
        self.check_start(&fitted)?;
        let fitted = fitted.bounded(self.workers)?;
        let hidden = self.hidden(&fitted)?;
        watch.hidden(&hidden);
        let found = Reached { study, fitted, best: None, other_form, hidden };
        let Reached { study, fitted, best, .. } = reached.insert(found);
        watch.stage("first search");
        let mut found = self.solved(fitted, self.starts, watch)?;
        if let Some((raw, trained, better)) = self.unsmoothed(study, fitted, &found, watch)? {
            (*study, *fitted, found) = (raw, trained, better);
        }
        if let Some((other, trained, better)) = self.under_likely_inputs(study, fitted, &found, watch)? {
            (*study, *fitted, found) = (other, trained, better);
        }
        watch.set(&found.x);
        if let Some(wholes) = &wholes
            && study.experiment.given().options.length.is_none()
            && let Some(uncut) = self.beyond_segments(wholes, fitted, &found, watch)?
        {
            *fitted = uncut.trained().bounded(self.workers)?;
            *study = uncut;
            watch.set(&fitted.start());
            found = self.solved(fitted, 0, watch)?;
        }
        let weigh = |simulation: &dyn Simulated| {
            let (likely, found) = with_likely_sensors(fitted.problem(simulation), found, self.loss, watch)?;
            Ok::<_, Interrupted>((likely.sensors, found))
        };
        let (sensors, found) = weigh(&fitted.simulation(self.workers))?;
        fitted.sensors = sensors;
        if fitted.experiment.is_steady() {
            // Of few points the parameters take away a part of the noise.
            let (size, count) = (fitted.size() as f64, fitted.parameters.len() as f64);
            let share = (size / (size - count).max(1.0)).sqrt();
            fitted.sensors.iter_mut().for_each(|sensor| sensor.noise *= share);
        }
        *best = Some(found);
        Ok(())
    }

    fn solved(&self, study: &Study, starts: usize, watch: &dyn Watch) -> Result<Solution, Interrupted> {
        match self.solver {
            Some(solver) => solver(study, starts, watch),
            None => study.with(self.workers, |problem| solve(problem, starts, self.seed, self.loss, watch)),
        }
    }

    fn refined(&self, study: &Study, x: &[f64], effort: Effort, watch: &dyn Watch) -> Result<Solution, Interrupted> {
        study.with(self.workers, |problem| refine(problem, x, self.loss, effort, watch))
    }

    /// Refuses a start that cannot be simulated at all, with the model's own words.
    fn check_start(&self, fitted: &Study) -> Result<(), NoAnswer> {
        let start = fitted.start();
        if fitted.residuals(self.workers, &start)?.iter().any(|residual| residual.abs() != FAILED) {
            return Ok(());
        }
        let refusal = fitted.runs().refusal(&start, TOLERANCE);
        refusal.map_or(Ok(()), |why| Err(Refused(format!("the start values cannot be simulated: {why}")).into()))
    }

    /// Names of the parameters that the data hardly tell at the start values.
    fn hidden(&self, fitted: &Study) -> Result<Vec<String>, Interrupted> {
        let reasons = fitted.with(self.workers, hidden)?;
        let lost = fitted.parameters.iter().zip(reasons).filter(|(_, reason)| reason.is_some());
        Ok(lost.map(|(one, _)| one.name.clone()).collect())
    }

    /// Studies of whole records, one for each course of inputs that may be meant, of a mass under measured forces, if its
    /// position is measured and nobody chose the segments.
    fn wholes(&self, study: &Study) -> Result<Option<Vec<Study>>, Refused> {
        let Given { kind, options, .. } = study.experiment.given();
        let is_pushed = Balance::of(study.experiment.given()).is_some();
        let is_free = options.length.is_none() && options.smoothing != Some(true);
        if !is_pushed || !is_free || !study.experiment.given().has("position") {
            return Ok(None);
        }
        // Pressures are never held.
        let courses = match options.inputs {
            None if kind.name == "force" => INPUTS.map(Some).to_vec(),
            given => vec![given],
        };
        let of_course = |inputs| {
            let options = Options { length: Some(WHOLE), smoothing: Some(false), inputs, ..*options };
            Ok(Study { step: STEP, exactness: EXACTNESS, ..study.recut(options, self.sources)? })
        };
        courses.into_iter().map(of_course).collect::<Result<_, _>>().map(Some)
    }

    /// The study that whole records bear from the balance of forces on, or segments with a better start. Segments of a law without
    /// deflections stay as they are.
    fn begun_by_balance(
        &self,
        wholes: &[Study],
        segments: Study,
        watch: &dyn Watch,
    ) -> Result<(Study, Option<Cause>), NoAnswer> {
        if !remembers(segments.experiment.given()) {
            return Ok((segments, None));
        }
        watch.stage("balance of forces");
        let Some(balanced) = self.balanced(&wholes[0])? else { return Ok((segments, None)) };
        let moved = segments.clone().starting_at(&balanced);
        let is_better = moved.mean_square(self.workers)? < segments.mean_square(self.workers)?;
        let segments = if is_better { moved } else { segments };
        let ends = self.ends(wholes, &balanced, watch)?;
        let best = least(&ends);
        if best.loudness() >= AT_NOISE {
            // Data that whole records of the other form describe are exact enough for whole records of the given one.
            for end in &ends {
                if let Some(form) = self.other_form(end, watch)? {
                    return Ok((end.begun(), Some(form)));
                }
            }
            let moved = segments.clone().starting_at(&best.found.x);
            if best.loudness() >= moved.mean_square(self.workers)? {
                return Ok((segments, None));
            }
        }
        Ok((best.noted(wholes), None))
    }

    /// The study that whole records bear from what segments gave, if it leaves less than these.
    ///
    /// Segments that leave no more than noise are not asked again: where they can, they forget the noise of the force.
    fn beyond_segments(
        &self,
        wholes: &[Study],
        segments: &Study,
        found: &Solution,
        watch: &Best<'_>,
    ) -> Result<Option<Study>, Interrupted> {
        let left = 2.0 * found.cost / segments.size() as f64;
        if left < AT_NOISE {
            return Ok(None);
        }
        let start: Vec<f64> = found.x[..segments.parameters.len()].to_vec();
        let from = |whole: &Study| Study { parameters: segments.parameters.clone(), ..whole.clone() };
        let wholes: Vec<Study> = wholes.iter().map(from).collect();
        let ends = self.ends(&wholes, &start, watch);
        // Until they are taken, the best vector is the one of the segments.
        watch.set(&found.x);
        let ends = ends?;
        let best = least(&ends);
        Ok((best.loudness() < left).then(|| best.noted(&wholes)))
    }

    /// Ends of searches of whole records from a start.
    fn ends(&self, wholes: &[Study], start: &[f64], watch: &dyn Watch) -> Result<Vec<End>, Interrupted> {
        let mut ends: Vec<End> = vec![];
        for whole in wholes {
            watch.stage(&format!("whole records, inputs {}", whole.experiment.given().options.inputs().name()));
            ends.push(self.end(whole.clone().starting_at(start), watch)?);
            // A controller holds its command until the next sample; a measured force varies between two samples.
            if ends.len() == 1 && ends[0].loudness() < AT_NOISE {
                break;
            }
        }
        let quietest = least(&ends).loudness();
        let go_on = |end: End| if end.loudness() < LIKE * quietest { self.further(end, watch) } else { Ok(end) };
        ends.into_iter().map(go_on).collect()
    }

    fn end(&self, whole: Study, watch: &dyn Watch) -> Result<End, Interrupted> {
        let trained = whole.trained().bounded(self.workers)?;
        let found = trained.with(self.workers, |it| refine(it, &it.start(), Loss::Linear, ROUGH, watch))?;
        Ok(End { whole, trained, found })
    }

    /// Searches on, with other scales, as long as it more than halves what is left.
    fn further(&self, mut end: End, watch: &dyn Watch) -> Result<End, Interrupted> {
        let mut before = f64::INFINITY;
        while AT_NOISE <= end.loudness() && end.loudness() < 0.5 * before {
            before = end.loudness();
            let from = &end.found.x;
            end.found = end.trained.with(self.workers, |it| refine(it, from, Loss::Linear, ROUGH, watch))?;
        }
        Ok(end)
    }

    /// The other form of a law whose form is fixed, if whole records of it leave no more than noise. Segments and smoothed forces
    /// hide which form is right.
    fn other_form(&self, end: &End, watch: &dyn Watch) -> Result<Option<Cause>, NoAnswer> {
        let whole = &end.whole;
        let tied = whole.ties.iter().map(|tie| &tie.name);
        let names: Vec<String> = whole.parameters.iter().map(|one| &one.name).chain(tied).cloned().collect();
        let choices = named(&*whole.experiment, &names).choices;
        for Choice { name, fixed, others } in choices.into_iter().filter(|one| one.name == DAMPING_SPEED) {
            for item in others {
                watch.stage(&format!("{name} = {item}"));
                let value = item.parse().expect("a number");
                let changed = whole.under(|given| given.known.extend([(name.clone(), value)]))?;
                let Some(balanced) = self.balanced(&changed)? else { return Ok(None) };
                let left = self.end(changed.starting_at(&balanced), watch)?.loudness();
                if left < AT_NOISE {
                    return Ok(Some(end.cause(Choice { name, fixed, others: vec![item] }, left)));
                }
            }
        }
        Ok(None)
    }

    /// The vector of parameters that best balance the forces along the measured motion.
    fn balanced(&self, whole: &Study) -> Result<Option<Vec<f64>>, Interrupted> {
        let balance = Balance::of(whole.experiment.given()).expect("measured forces move a mass");
        let of = |segment: &MeasuredSegment| balance.segment(&segment.record, &segment.is_validation);
        let mut segments: Vec<MeasuredSegment> = whole.segments.iter().map(of).collect();
        segments.retain(|segment| segment.fitted().next().is_some());
        let study = Study {
            sensors: vec![Sensor { noise: 1.0, step: 0.0, is_coarse: false }],
            fixed: whole.fixed.clone(),
            ties: whole.ties.clone(),
            ..Study::new(Arc::new(balance), segments, whole.parameters.clone())
        };
        let start = study.residuals(self.workers, &study.start())?;
        if start.is_empty() || rms(&start) >= UNBALANCED {
            return Ok(None);
        }
        let study = study.bounded(self.workers)?;
        let found = study.with(self.workers, |it| refine(it, &it.start(), Loss::Linear, ROUGH, &Unwatched))?;
        Ok(Some(found.x))
    }

    /// The study and its end under the course of a measured force that leaves least, if it is another one.
    fn under_likely_inputs(
        &self,
        study: &Study,
        fitted: &Study,
        found: &Solution,
        watch: &dyn Watch,
    ) -> Result<Option<(Study, Study, Solution)>, NoAnswer> {
        let Given { kind, options, .. } = fitted.experiment.given();
        if kind.name != "force" || options.inputs.is_some() {
            return Ok(None);
        }
        let mut best: Option<(Study, Study, Solution)> = None;
        for course in &INPUTS[1..] {
            watch.stage(&format!("inputs {}", course.name()));
            let mut other = fitted.under(|given| given.options.inputs = Some(*course))?;
            let end = self.refined(&other, &found.x, ROUGH, watch)?;
            if end.cost < best.as_ref().map_or(found.cost, |(_, _, best)| best.cost) {
                other.notes.push(note_on(*course));
                let whole = Study { experiment: other.experiment.clone(), notes: other.notes.clone(), ..study.clone() };
                best = Some((whole, other, end));
            }
        }
        Ok(best)
    }

    /// The study and its end with measured forces as they are, if that leaves less than smoothed ones.
    ///
    /// Smoothing wipes out the course of a force that is exact; where its noise breaks a mass away, or nothing tells which is better,
    /// it stays.
    fn unsmoothed(
        &self,
        study: &Study,
        fitted: &Study,
        found: &Solution,
        watch: &dyn Watch,
    ) -> Result<Option<(Study, Study, Solution)>, NoAnswer> {
        let given = fitted.experiment.given();
        if Balance::of(given).is_none() || given.options.smoothing.is_some() {
            return Ok(None);
        }
        watch.stage("forces without smoothing");
        let options = Options { smoothing: Some(false), ..given.options };
        let mut raw = Study { sensors: study.sensors.clone(), ..study.recut(options, self.sources)? };
        raw.notes.push("measured forces are not smoothed: smoothed ones leave more".to_owned());
        let trained = raw.trained().bounded(self.workers)?;
        if trained.start().len() != found.x.len() || trained.size() != fitted.size() {
            return Ok(None);
        }
        let end = self.refined(&trained, &found.x, FINE, watch)?;
        let is_less = self.leaves_less((&trained, &end.x), (fitted, &found.x))?;
        Ok(is_less.then_some((raw, trained, end)))
    }

    /// Whether one study leaves less of the same samples than another, by more than chance.
    ///
    /// The noise of a force makes autocorrelated residuals, of which a few percent less say nothing: the gains of stretches of
    /// time have to agree.
    fn leaves_less(&self, one: (&Study, &[f64]), other: (&Study, &[f64])) -> Result<bool, Interrupted> {
        let blocks = one.0.with(self.workers, |problem| problem.blocks(BLOCKS));
        let [less, more] = [one, other].map(|(study, x)| study.residuals(self.workers, x));
        let mut gains = vec![0.0; blocks.iter().max().map_or(0, |most| most + 1)];
        for ((block, less), more) in blocks.iter().zip(less?).zip(more?) {
            gains[*block] += more * more - less * less;
        }
        let (number, middle) = (gains.len() as f64, mean(&gains));
        let squares: f64 = gains.iter().map(|gain| (gain - middle) * (gain - middle)).sum();
        let deviation = (squares / (number - 1.0) / number).sqrt();
        Ok(middle > student_quantile(SURE, gains.len().saturating_sub(1)) * deviation)
    }
}

/// A study of whole records, its fitted part, and the end of a search from its start.
struct End {
    whole: Study,
    trained: Study,
    found: Solution,
}

impl End {
    /// Mean square of the residuals, in units of the noise.
    fn loudness(&self) -> f64 {
        2.0 * self.found.cost / self.trained.size() as f64
    }

    /// The other form of the law as a cause of what is left.
    fn cause(&self, Choice { name, fixed, mut others }: Choice, after: f64) -> Cause {
        let (item, signal, before) = (others.swap_remove(0), self.whole.experiment.compared()[0], self.loudness());
        let [least, most] = [after, before].map(|left| significant(left.sqrt(), 3));
        let text = format!(
            "{name} is fixed at {fixed}, and {item} describes the data: simulated as a whole, the records leave {most} times the \
             noise of {signal} with the former, and {least} times with the latter"
        );
        Cause {
            name,
            text,
            estimate: None,
            item: Some(item),
            signal: signal.to_owned(),
            share: 1.0 - after / before,
            gain: self.trained.size() as f64 * (before - after),
            alike: vec![],
            is_sensor: false,
        }
    }

    /// The study from the end of the search on.
    fn begun(&self) -> Study {
        self.whole.clone().begun(&self.trained, &self.found.x).starting_at(&self.found.x)
    }

    /// The same, which says how records are simulated.
    fn noted(&self, wholes: &[Study]) -> Study {
        let mut study = self.begun();
        let is_quiet = self.loudness() < AT_NOISE;
        let left = if is_quiet { "nothing but noise is left so" } else { "segments of smoothed forces leave more" };
        study.notes.push(format!("records are simulated as a whole, and forces are not smoothed: {left}"));
        let course = study.experiment.given().options.inputs;
        if let Some(course) = course.filter(|_| course != wholes[0].experiment.given().options.inputs) {
            study.notes.push(note_on(course));
        }
        study
    }
}

/// The quietest of ends, of which there is one.
fn least(ends: &[End]) -> &End {
    fn quieter<'a>(best: &'a End, end: &'a End) -> &'a End {
        if end.loudness() < best.loudness() { end } else { best }
    }
    ends[1..].iter().fold(&ends[0], quieter)
}

/// A note on inputs that are not held.
fn note_on(course: Inputs) -> String {
    let how = if course == Inputs::Lines { "on straight lines" } else { "on a smooth curve" };
    format!("between samples the inputs run {how}: held ones leave more")
}

/// Whether friction of a law depends on deflections before.
fn remembers(given: &Given) -> bool {
    let group = given.law_group();
    let deflects = |variable: &&pneumatic_servo::variables::Variable| {
        let Kind::Real(unit) = variable.kind else { return false };
        variable.name.starts_with(&group) && PRESLIDING.contains(&unit.name) && variable.start != Some(0.0)
    };
    !group.is_empty() && given.table.table().parameters().any(|variable| deflects(&variable))
}
