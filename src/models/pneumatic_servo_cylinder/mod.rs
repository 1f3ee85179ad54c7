//! A double-acting pneumatic cylinder with a friction-loaded carriage, fed by a 5/3 proportional valve or, on a second
//! rig, by a pressure regulator with the other chamber plugged.
//!
//! Chamber A (cap side, full bore) pushes the carriage to +x; chamber B is the rod side. The equations come from
//! the modules [`pneumatics`](crate::pneumatics), [`mechanics`](crate::mechanics) and [`friction`](crate::friction);
//! this file joins them:
//!
//! ```text
//! F_app = p_A*A_A - p_B*A_B - p_atm*A_r + F_ext - F_wire - m*g*sin(incline) - k*(x - rest) + F_stop
//! m*dv/dt = F_app - F_f,   dx/dt = v
//! ```
//!
//! `A_r` is the cross-section of the rod, less the cross-section of a second rod through chamber A.

mod cylinder;
mod ends;
mod equations;
mod jacobian;
mod leaks;
mod lines;
mod motion;
mod options;
mod parameters;
mod sensors;
mod states;
mod system;
mod variables;

use crate::friction::{Friction, FrictionLaw};
use crate::model::{Course, Experiment, Functions, Model, Panel, Signal};
use crate::pneumatics::actuator::{Actuating, Actuator};

#[doc(hidden)]
pub use self::cylinder::{Memory, PneumaticServoCylinder};
#[doc(hidden)]
pub use self::states::{PRESSURE_A, PRESSURE_B};

/// The most states of a run.
#[cfg(feature = "sensitivities")]
pub(super) const MOST_STATES: usize = states::MOST;

/// The model as the library offers it.
pub const MODEL: Model = model::<Friction, Actuator>();

/// The model with the laws and the actuators of catalogues.
pub const fn model<L: FrictionLaw, A: Actuating>() -> Model {
    Model {
        name: "PneumaticServoCylinder",
        description: "Friction-loaded pneumatic servo cylinder with 5/3 proportional valve",
        functions: Functions::of::<PneumaticServoCylinder<L, A>, 3>(
            states::MOST,
            cylinder::start::<L, A, _>,
            cylinder::start::<L, A, _>,
        ),
        experiment: Experiment {
            stop_time: 3.0,
            step_size: 1e-3,
            signals: &[Signal {
                input: "valveVoltage",
                text: "5 V + 2 V sin(2π t/s)",
                course: Course::Sine { mean: 5.0, amplitude: 2.0, frequency: 1.0, delay: 0.0 },
            }],
            panels: &[
                Panel { label: "valve voltage", curves: &["valveVoltage"] },
                Panel { label: "position", curves: &["position"] },
                Panel { label: "velocity", curves: &["velocity"] },
                Panel { label: "pressure", curves: &["chamberB.pressure", "chamberA.pressure"] },
                Panel { label: "friction force", curves: &["frictionForce"] },
            ],
        },
    }
}

#[cfg(test)]
mod tests {
    use super::states::State;
    use super::*;
    use crate::model::{Seeds, Start};
    use crate::models::checks;
    use crate::numbers::{Real, Scalar};
    use crate::session::build;
    use crate::system::System;
    use crate::variables::Variable;

    /// Messages call an event of a contact as a host calls its indicator, without the group.
    #[test]
    fn events_are_named_as_their_indicators() {
        checks::events_are_named::<PneumaticServoCylinder, 3>(|_, last| last);
    }

    /// With all lines, each of their states is integrated; with a lag, a sensor's.
    #[test]
    fn states_are_as_many_as_a_run_integrates() {
        let lines = ["hoseA.length", "hoseB.length", "throttleA.C", "throttleB.C", "supply.volume"];
        let lags = ["sensor.position.lag", "sensor.pressureA.lag", "sensor.pressureB.lag", "sensor.force.lag"];
        let all = [lines.as_slice(), &lags].concat();
        for (law, options) in
            [1.0, 12.0, 16.0].into_iter().flat_map(|law| [&[][..], &lines, &lags, &all].map(|it| (law, it)))
        {
            let value = |variable: &Variable| match variable.name.as_str() {
                "friction.law" => law,
                name if options.contains(&name) => {
                    if name.ends_with(".C") {
                        1e-9
                    } else {
                        1e-3
                    }
                }
                _ => variable.start.expect("a start value"),
            };
            let parameters: Vec<f64> = MODEL.table().parameters().map(value).collect();
            let start = Start {
                time: 0.0,
                parameters: &parameters,
                inputs: &[5.0, 0.0, 6e5, 0.25, 0.0, 5.0, 5.0, 0.0, 0.0, 0.0, 0.0],
                tolerance: None,
                seeds: Seeds::NONE,
            };
            let run = (MODEL.functions.start)(&start).expect("legal");
            let integrated = (0..MODEL.table().states().count()).filter(|state| run.state_index(*state).is_some());
            let (equations, _) =
                build::<PneumaticServoCylinder<Friction, Actuator, true>, { super::states::ALL }>(&start)
                    .expect("legal");
            assert_eq!(equations.states(), integrated.count(), "law {law}, {options:?}");
        }
    }

    #[test]
    fn laws_cost_what_they_ask_for() {
        checks::laws_cost_what_they_ask_for::<PneumaticServoCylinder, 3>([false; 2]);
    }

    /// Another voltage changes the rates of the spool alone, so that no others are evaluated anew; other inputs change more.
    #[test]
    fn rates_are_refreshed_where_the_voltage_alone_has_changed() {
        let parameters: Vec<f64> = MODEL.table().parameters().filter_map(|it| it.start).collect();
        let inputs = [6.0, 1.0, 6e5];
        let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
        let (equations, _) = build::<PneumaticServoCylinder, 3>(&start).expect("the defaults fit");
        let before = inputs.map(Real::of);
        let (x, memory) = equations.start::<Real, { State::OTHERS }>(&before);
        for (inputs, is_refreshed) in
            [([6.5, 1.0, 6e5], true), (inputs, true), ([6.5, 1.5, 6e5], false), ([6.0, 1.0, 5e5], false)]
        {
            let (inputs, time) = (inputs.map(Real::of), Real::of(0.0));
            let (mut rates, mut memory) =
                (equations.derivatives_besides_closed_form(time, &x, &before, &memory), memory.clone());
            let unchanged = rates;
            equations.follow(time, &x, &inputs, &mut memory);
            assert_eq!(
                equations.update_derivatives(&x, [&before, &inputs], &memory, &mut rates),
                is_refreshed,
                "{inputs:?}"
            );
            let expected = if is_refreshed { equations.derivatives(time, &x, &inputs, &memory) } else { unchanged };
            assert_eq!(rates.map(|it| it.value.to_bits()), expected.map(|it| it.value.to_bits()), "{inputs:?}");
            assert_eq!(System::indicators_hold(&equations, [&before, &inputs]), is_refreshed, "{inputs:?}");
        }
    }
}
