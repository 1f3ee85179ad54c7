//! How slopes begin.

use super::equations::At;
use super::{Along, Companion, Differentiable, Driven, Equations, NoDerivative, Slopes, Way};
use crate::system::Indicator;
use crate::variables::{Role, Table};

/// A run that slopes are to be carried along.
#[derive(Clone, Copy)]
pub struct Begin<'a> {
    /// The run.
    pub run: &'a dyn Differentiable,
    /// The variables of its model.
    pub table: &'static Table,
    /// The event indicators of its model.
    pub indicators: &'a [Indicator],
    /// All parameters, in the order of the table.
    pub parameters: &'a [f64],
    /// The inputs and their slopes.
    pub inputs: [&'a [f64]; 2],
    /// The inputs with which the run started, if parameters and inputs are to begin with what they do to the start.
    pub first_inputs: Option<&'a [f64]>,
    /// The inputs that the run has followed so far.
    pub followed: &'a [f64],
}

/// A companion of a run from here on, in directions.
///
/// # Errors
/// The direction along which there are no slopes.
pub fn begin(begin: Begin, directions: &[Along]) -> Result<Companion, Along> {
    let refused = directions.first().copied().unwrap_or(Along::State(0));
    let equations = begin.run.equations().ok_or(refused)?;
    let spare = begin.run.equations().ok_or(refused)?;
    let (time, x, tolerance) = begin.run.place().ok_or(refused)?;
    let still = Slopes::new(vec![0.0; x.len()], vec![0.0; equations.memory().count()]);
    let has_begun = |first: &&[f64]| time != 0.0 || equations.start(first) != (x.clone(), equations.memory());
    let first_inputs = begin.first_inputs.filter(|first| !has_begun(first));
    let count = begin.inputs[0].len();
    let mut ways = Vec::with_capacity(directions.len());
    for along in directions {
        let mut slopes = still.clone();
        let way = match *along {
            Along::Input(place) if place < count => {
                let way = Way::of_input(place, count);
                if let Some(first) = first_inputs {
                    slopes = way.slopes_of_start(equations.as_ref(), first);
                }
                way
            }
            Along::Input(_) => return Err(*along),
            Along::State(state) => {
                let index = begin.run.state_index(state).ok_or(*along)?;
                slopes.states[index] = 1.0;
                slopes = Slopes::new(slopes.states, slopes.memory);
                slopes.lost = at_a_limit(equations.as_ref(), At { time, x: &x, u: begin.followed }, index);
                Way::still(count)
            }
            Along::Memory(number) => {
                *slopes.memory.get_mut(number).ok_or(*along)? = 1.0;
                Way::still(count)
            }
            Along::Parameter(place) => {
                let way = of_parameter(&begin, place).ok_or(*along)?;
                if let Some(first) = first_inputs {
                    slopes = way.slopes_of_start(equations.as_ref(), first);
                }
                way
            }
        };
        ways.push((way, slopes));
    }
    let nominals = begin.indicators.iter().map(|indicator| indicator.nominal).collect();
    let inputs = Driven { since: time, values: begin.followed.to_vec(), slopes: vec![0.0; count] };
    let names = begin.table.inputs().map(|input| input.name.as_str()).collect();
    let mut companion = Companion::new([equations, spare], (time, x, inputs), tolerance, (nominals, names), ways);
    companion.set_inputs(begin.inputs[0], begin.inputs[1]);
    Ok(companion)
}

/// Why there is no derivative by a state: the mode is exactly at its limit, to one side of which it ends.
fn at_a_limit(equations: &dyn Equations, at: At, state: usize) -> Option<NoDerivative> {
    /// Share of its scale by which the state is moved.
    const SHARE: f64 = 1e-9;
    let here = equations.indicators(at);
    let sides = [SHARE, -SHARE].map(|share| {
        let mut x = at.x.to_vec();
        x[state] += share * equations.scales()[state];
        equations.indicators(At { x: &x, ..at })
    });
    let ends = |event: &usize| here[*event] == 0.0 && sides.iter().any(|side| side[*event] < 0.0);
    let event = (0..here.len()).find(ends)?;
    let reason = "the modes differ from one side of it to the other".to_owned();
    Some(NoDerivative { time: at.time, event: equations.event_name(event).to_owned(), reason })
}

/// The direction of a parameter, if there are equations beside the present ones.
fn of_parameter(begin: &Begin, place: usize) -> Option<Way> {
    let variable = begin.table.parameters().nth(place)?;
    let value = begin.parameters[place];
    let bounds = [variable.min.unwrap_or(f64::NEG_INFINITY), variable.max.unwrap_or(f64::INFINITY)];
    let typical = variable.nominal.or(variable.start).filter(|typical| *typical != 0.0);
    // A parameter that is 0 as a rule has the magnitude of its range, if that is small: a leakage.
    let typical = typical.unwrap_or((bounds[1] - bounds[0]).min(1.0));
    let magnitude = if value == 0.0 { typical } else { value }.abs();
    let (equations, parameters) = (begin.run.equations()?, begin.parameters.to_vec());
    let beside = move |offset: f64| {
        let mut parameters = parameters.clone();
        parameters[place] += offset;
        equations.under(&parameters, &[])
    };
    let way = Way::of_parameter(Box::new(beside), [value, magnitude], bounds, begin.inputs[0].len())?;
    // Rates and computed variables know how they change with tunable parameters.
    let varied = (variable.role == Role::Tunable).then(|| {
        let mut slopes = vec![0.0; begin.parameters.len()];
        slopes[place] = 1.0;
        begin.run.equations()?.under(begin.parameters, &slopes)
    });
    Some(way.with_varied(varied.flatten()))
}
