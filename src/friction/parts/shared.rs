//! Friction forces that a model gives to whichever law is chosen.
//!
//! Most laws have a static and a Coulomb friction among their parameters. A model that knows both itself (as friction
//! coefficients times a weight, for example) leaves them out of its table and states them once for all laws.

use crate::friction::FrictionLaw;
use crate::variables::{Kind, Meaning, ParameterError, Tunable, Values, Variable};

/// A friction force and the variable of the model that sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedForce {
    /// Name of the variable.
    pub variable: &'static str,
    /// Its value.
    pub value: Tunable,
    /// The force in N that it means.
    pub force: Tunable,
}

/// Static and Coulomb friction of a contact under any law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedForces {
    /// Force at which sliding starts.
    pub statics: SharedForce,
    /// Force of fast sliding without a viscous part; both of Polito's law.
    pub coulomb: SharedForce,
}

/// Coulomb friction in N that the default parameters of the laws belong to.
const RATED: f64 = 8.3;

impl SharedForces {
    /// The variables of [`FrictionLaw::table_within`] without those that the model sets.
    ///
    /// All other defaults with a force in their unit are scaled to the Coulomb friction `rated` in N, so that every law
    /// keeps its lengths, velocities and times; viscous friction is 0 by default.
    pub fn table<L: FrictionLaw>(group: &str, base: u32, default: i32, rated: f64) -> Vec<Variable> {
        let others = L::table_within(group, base, default).into_iter().filter(|variable| !is_shared(variable));
        let presets = others.map(|variable| {
            let factor = match variable.kind {
                _ if variable.meaning == Some(Meaning::ViscousFriction) => 0.0,
                Kind::Real(unit) if unit.base[0] == 1 => rated / RATED,
                _ => 1.0,
            };
            // An addition of 0 turns -0 into 0.
            let plausible =
                variable.plausible.map(|range| range.map(|bound| if factor > 0.0 { bound * factor } else { bound }));
            Variable { start: variable.start.map(|start| start * factor + 0.0), plausible, ..variable }
        });
        presets.collect()
    }

    /// Builds the chosen law from the next values, in the order of [`table`](Self::table).
    ///
    /// # Errors
    /// [`ParameterError`] when the values of the chosen law do not fit together or to these forces.
    pub fn read<L: FrictionLaw>(&self, values: &mut Values, group: &str) -> Result<L, ParameterError> {
        let table = L::table_within(group, 0, 0);
        let value = |variable| self.force(variable).map_or_else(|| Ok(values.take(1)?[0]), Ok);
        let all = table.iter().map(value).collect::<Result<Vec<_>, _>>()?;
        L::read(&all).map_err(|error| {
            let error = error.within(group);
            let refused = table.iter().find(|variable| variable.name == error.variable);
            self.explain(error, refused.and_then(|variable| variable.meaning))
        })
    }

    /// The force in N of a parameter, if the model sets it.
    fn force(&self, variable: &Variable) -> Option<Tunable> {
        match variable.meaning? {
            Meaning::StaticFriction => Some(self.statics.force),
            Meaning::CoulombFriction => Some(self.coulomb.force),
            Meaning::StaticExcess => Some(self.statics.force - self.coulomb.force),
            _ => None,
        }
    }

    /// An error about a parameter that the model does not show, as one about the variable that sets it.
    fn explain(&self, error: ParameterError, meaning: Option<Meaning>) -> ParameterError {
        let shared = match meaning {
            Some(Meaning::StaticFriction | Meaning::StaticExcess) => self.statics,
            Some(Meaning::CoulombFriction) => self.coulomb,
            _ => return error,
        };
        let reason = format!("for {} = {} N {}", error.variable, error.value, error.reason);
        ParameterError { variable: shared.variable.to_owned(), value: shared.value.value, reason }
    }
}

/// Whether the model sets this parameter.
fn is_shared(variable: &Variable) -> bool {
    matches!(variable.meaning, Some(Meaning::StaticFriction | Meaning::CoulombFriction | Meaning::StaticExcess))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{Contact, Drive, Friction, Indicators, Law, MAX_STATES};
    use crate::numbers::{Real, Scalar};
    use crate::variables::Choice;

    fn forces(statics: f64, coulomb: f64) -> SharedForces {
        let shared = |variable, force| SharedForce { variable, value: force / 10.0, force };
        let [statics, coulomb] = [statics, coulomb].map(Tunable::still);
        SharedForces { statics: shared("muStatic", statics), coulomb: shared("muDynamic", coulomb) }
    }

    /// The defaults, with a law chosen.
    fn values(law: Law) -> Vec<Tunable> {
        let table = SharedForces::table::<Friction>("friction", 0, law.id(), 0.83);
        table.iter().map(|variable| Tunable::still(variable.start.expect("a start value"))).collect()
    }

    fn built(forces: &SharedForces, law: Law) -> Result<Friction, ParameterError> {
        forces.read(&mut Values::new(&values(law)), "friction")
    }

    /// Every law with a steady curve slides at the Coulomb friction, whether that or its scaled defaults give it, with states
    /// of the magnitude that it says.
    #[test]
    fn every_law_slides_at_the_coulomb_friction_of_the_contact() {
        // Sampled springs answer to a motion, and the steady force of the bristles is a mean.
        const MOVED: [Law; 3] = [Law::None, Law::Bristle, Law::DNLRX];
        let laws = crate::friction::LAWS.items.iter().filter_map(|(id, ..)| Law::from_id(f64::from(*id)));
        for law in laws.filter(|law| !MOVED.contains(law)) {
            let friction = built(&forces(1.1, 0.83), law).unwrap();
            let contact =
                Contact { time: 0.0, position: 0.0, velocity: 5.0, applied: 0.0, level: 1.0, drive: Drive::Force };
            let (mut contact, mut z) = (contact.still::<Real>(), [Real::of(0.0); MAX_STATES]);
            let mut memory = friction.start(&contact);
            let states = friction.states();
            let mut force = 0.0f64;
            // Explicit Euler steps of 50 nm resolve the stiffest bristle; 15 mm are far beyond presliding.
            for _ in 0..300_000 {
                let mut rates = [Real::of(0.0); MAX_STATES];
                force = friction.force(&contact, &z[..states], &memory, &mut rates[..states]).value;
                for _ in 0..MAX_STATES {
                    let mut indicators = Indicators::default();
                    friction.indicators(&contact, &z[..states], &memory, &mut indicators);
                    let Some(event) = indicators.due() else { break };
                    let mut velocity = contact.velocity;
                    friction.switch(event, &contact, &mut velocity, &mut z[..states], &mut memory);
                }
                friction.follow(&contact, &z[..states], &mut memory);
                let dt = 1e-8;
                z.iter_mut().zip(rates).for_each(|(z, rate)| *z += rate * dt);
                contact.position += contact.velocity * dt;
                contact.time = contact.time + dt;
            }
            // Velocity-based friction and GMS come down to it slowly: 0.7 % remain.
            assert!(
                (force - 0.83).abs() < 0.01,
                "{law:?} slides with {force} N, not with 0.83 N: do its forces and its viscous friction say what they mean?"
            );
            // The force is shared by up to four elements, and scales allow for 1 N at least.
            let shares = z[..states].iter().enumerate().map(|(state, z)| z.value.abs() / friction.scale_of(state));
            let share = shares.fold(0.0f64, f64::max);
            assert!(states == 0 || (0.15..1.5).contains(&share), "{law:?}: {share} times the magnitude of its states");
        }
    }

    #[test]
    fn shared_forces_are_left_out_of_the_table() {
        let table = SharedForces::table::<Friction>("friction", 0, Law::Stribeck.id(), 0.83);
        assert!(table.iter().all(|variable| !variable.name.ends_with(".Fs") && !variable.name.ends_with(".Fc")));
        let start = |name: &str| table.iter().find(|variable| variable.name == name).and_then(|v| v.start).unwrap();
        assert_eq!(start("friction.stribeck.vs"), 0.01);
        assert_eq!(start("friction.stribeck.sigma2"), 0.0);
        assert!((start("friction.maxwellSlip.W[1]") - 0.2075).abs() < 1e-15);
    }

    #[test]
    fn forces_that_do_not_fit_are_refused_by_the_name_of_the_variable() {
        let error = built(&forces(1.0, 2.0), Law::Stribeck).unwrap_err();
        assert_eq!((error.variable.as_str(), error.value), ("muDynamic", 0.2));
        assert!(error.reason.contains("friction.stribeck.Fc = 2 N"), "{error}");
    }
}
