//! The variable table of the vibro-impact system.

use crate::friction::parts::shared::{SharedForce, SharedForces};
use crate::friction::{FrictionLaw, Law, states};
use crate::system::{Tables, references};
use crate::variables::{Choice, Condition, Fixed, Meaning, ParameterSet, Tunable, Variable, units};
use crate::{enumeration, inputs, outputs, parameters, states};

const BREAK_AWAY: f64 = 6.8;
const COULOMB_RATIO: f64 = 0.5;

/// Every variable of the system.
pub fn tables<L: FrictionLaw>() -> Tables {
    let states = states::table::<L>("friction", references::CONTACT, [&[depends::V2], &[]]);
    Tables {
        inputs: Inputs::table(),
        computed: [states::completed::<L>(Outputs::<f64>::table(), references::CONTACT), states].concat(),
        parameters: [Parameters::table(), friction_table::<L>()].concat(),
    }
}

/// The friction laws, with the exponential Stribeck curve of the source.
fn friction_table<L: FrictionLaw>() -> Vec<Variable> {
    let coulomb = COULOMB_RATIO * BREAK_AWAY;
    let table = SharedForces::table::<L>("friction", references::FRICTION, Law::Stribeck.id(), coulomb);
    let exponential = |variable: Variable| match variable.meaning {
        Some(Meaning::StribeckExponent) => Variable { start: Some(1.0), ..variable },
        _ => variable,
    };
    table.into_iter().map(exponential).collect()
}

inputs! {
    /// The input.
    Inputs {
        external_force = Variable::input(1, "externalForce", units::NEWTON, 0.0).nominal(1.0)
            .text("Force on the body towards +x");
    }
}

/// Magnitudes of lengths and speeds in SI units or, in the dimensionless form, without units.
const LENGTH: fn(&Parameters) -> f64 = |p| if p.is_dimensionless() { 1.0 } else { 1e-3 };
const SPEED: fn(&Parameters) -> f64 = |p| if p.is_dimensionless() { 1.0 } else { 1e-2 };

states! {
    /// The states of the internal mass and of the body.
    State of Parameters, from 0; {
        InternalPosition: 104, LENGTH;
        InternalVelocity: 105, SPEED;
        ..friction;
        Position: 101, LENGTH;
        Velocity: 102, SPEED;
    }
}

/// Inputs and states that the computed variables depend on.
mod depends {
    use super::State;
    use crate::friction::states;
    use crate::system::references;

    pub const TIME: u32 = references::TIME;
    pub const FORCE: u32 = 1;
    pub const X2: u32 = State::Position.reference();
    pub const V2: u32 = State::Velocity.reference();
    pub const X1: u32 = State::InternalPosition.reference();
    pub const V1: u32 = State::InternalVelocity.reference();
    /// Dependencies of spring and damper between the masses.
    pub const SPRING: &[u32] = &[X2, V2, X1, V1];
    /// Dependencies of the force between the masses.
    pub const INTERNAL: &[u32] = &[TIME, X2, V2, X1, V1];

    /// Dependencies of the decision whether a law without states of its own holds the mass.
    pub const LOAD: &[u32] = &[TIME, FORCE, X2, V2, X1, V1];

    /// Dependencies of friction and acceleration of the body.
    pub fn body() -> Vec<u32> {
        [LOAD.to_vec(), states::references(references::CONTACT)].concat()
    }
}

outputs! {
    /// The computed variables.
    Outputs {
        position = Variable::output(depends::X2, "position", units::METRE).nominal(1e-2).shown_in("mm")
            .depends_on(&[depends::X2])
            .text("Position of the body");
        velocity = Variable::output(depends::V2, "velocity", units::METRE_PER_SECOND).nominal(1e-2).shown_in("mm/s").derivative_of(depends::X2)
            .depends_on(&[depends::V2])
            .text("Velocity of the body; exactly 0 while it sticks");
        acceleration = Variable::output(103, "acceleration", units::METRE_PER_SECOND_SQUARED).nominal(1.0).derivative_of(depends::V2)
            .depends_on(&depends::body())
            .text("Acceleration of the body");
        internal_position = Variable::output(depends::X1, "internal.position", units::METRE).nominal(1e-2).shown_in("mm")
            .depends_on(&[depends::X1])
            .text("Position of the internal mass");
        internal_velocity = Variable::output(depends::V1, "internal.velocity", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s").derivative_of(depends::X1)
            .depends_on(&[depends::V1])
            .text("Velocity of the internal mass");
        internal_acceleration = Variable::output(106, "internal.acceleration", units::METRE_PER_SECOND_SQUARED).nominal(10.0).derivative_of(depends::V1)
            .depends_on(depends::INTERNAL)
            .text("Acceleration of the internal mass");
        displacement = Variable::output(107, "displacement", units::METRE).nominal(1e-3).shown_in("mm")
            .depends_on(&[depends::X2, depends::X1])
            .text("Position of the internal mass on the body; from gap on it presses the impact spring");
        displacement_rate = Variable::output(108, "displacementRate", units::METRE_PER_SECOND).nominal(0.1).shown_in("mm/s")
            .depends_on(&[depends::V2, depends::V1])
            .text("Velocity of the internal mass on the body");
        excitation = Variable::output(109, "excitationForce", units::NEWTON).nominal(1.0)
            .depends_on(&[depends::TIME])
            .text("Harmonic force on the internal mass; its reaction acts on the body");
        spring_force = Variable::output(110, "springForce", units::NEWTON).nominal(1.0)
            .depends_on(depends::SPRING)
            .text("Force of spring and damper on the body");
        impact_force = Variable::output(111, "impactForce", units::NEWTON).nominal(10.0)
            .depends_on(&[depends::X2, depends::X1])
            .text("Force of the impact spring on the body");
        friction_force = Variable::output(112, "frictionForce", units::NEWTON).nominal(1.0)
            .depends_on(&depends::body())
            .text("Friction force on the body, positive when it opposes motion towards +x");
        sticking = Variable::flag(113, "sticking")
            .depends_on(depends::LOAD)
            .text("True while a set-valued law, Karnopp's band or the stick mode of a stick-slip law holds the body");
        touching = Variable::flag(114, "touching")
            .depends_on(&[depends::X2, depends::X1])
            .text("True while the internal mass presses the impact spring");
        impacts = Variable::counter(201, "impacts")
            .depends_on(&[]).text("Impacts since initialization");
    }
}

enumeration! {
    /// The meaning of the parameters; ids are never reused.
    Form "VibroImpactForm": "Which parameters describe the system" {
        1 Dimensional: "Masses, springs, gap, force and friction in SI units";
        2 Dimensionless: "The group dimensionless; forces count in F_b, lengths in F_b/k_1, times in sqrt(m_1/k_1)";
    }
}

parameters! {
    /// The parameters of the system; the friction law's and the solver's follow in the table.
    Parameters {
        form: Form = Variable::choice(1001, "form", Form::Dimensional)
            .text("Which parameters describe the system; in the dimensionless form all variables are numbers without the units shown");
        internal_mass: Fixed = described_by(Form::Dimensional, Variable::parameter(1002, "internal.mass", units::KILOGRAM, 1.0)).range(1e-6, 1e4)
            .text("Internal mass m_1");
        body_mass: Fixed = described_by(Form::Dimensional, Variable::parameter(1003, "mass", units::KILOGRAM, 1.336)).range(1e-6, 1e4)
            .text("Mass of the body m_2");
        stiffness: Fixed = described_by(Form::Dimensional, Variable::parameter(1004, "spring.k1", units::NEWTON_PER_METRE, 5200.0)).range(0.0, 1e9)
            .text("Stiffness of the spring between the masses");
        cubic_stiffness: Fixed = described_by(Form::Dimensional, Variable::parameter(1005, "spring.k2", units::NEWTON_PER_CUBIC_METRE, 1.7e9)).range(0.0, 1e18)
            .text("Stiffness of the spring for the cube of its displacement");
        damping: Fixed = described_by(Form::Dimensional, Variable::parameter(1006, "spring.damping", units::NEWTON_SECOND_PER_METRE, 25.0)).range(0.0, 1e6)
            .text("Damping coefficient between the masses");
        impact_stiffness: Fixed = described_by(Form::Dimensional, Variable::parameter(1007, "impact.stiffness", units::NEWTON_PER_METRE, 8.5e4)).range(0.0, 1e12)
            .text("Stiffness k_0 of the impact spring");
        gap: Fixed = described_by(Form::Dimensional, Variable::parameter(1008, "impact.gap", units::METRE, 0.0)).range(-1.0, 1.0).shown_in("mm")
            .text("Displacement at which the internal mass meets the impact spring");
        amplitude: Tunable = described_by(Form::Dimensional, Variable::parameter(1009, "excitation.amplitude", units::NEWTON, 5.372)).range(0.0, 1e6)
            .text("Amplitude A of the harmonic force between the masses");
        frequency: Fixed = described_by(Form::Dimensional, Variable::parameter(1010, "excitation.frequency", units::HERTZ, 15.0)).range(1e-3, 1e5)
            .text("Frequency of the harmonic force");
        break_away: Tunable = described_by(Form::Dimensional, Variable::parameter(1011, "friction.Fs", units::NEWTON, BREAK_AWAY)).range(0.0, 1e6)
            .text("Static friction of the law: force at which the body breaks away");
        coulomb_ratio: Tunable = Variable::parameter(1012, "friction.ratio", units::ONE, COULOMB_RATIO).range(0.0, 1.0)
            .text("Coulomb friction of the law divided by its static friction");
        chi: Tunable = described_by(Form::Dimensionless, Variable::parameter(1021, "dimensionless.chi", units::ONE, 1.0)).range(0.0, 1e6)
            .text("Amplitude of the harmonic force, A/F_b");
        omega: Fixed = described_by(Form::Dimensionless, Variable::parameter(1022, "dimensionless.omega", units::ONE, 1.0)).range(1e-3, 1e3)
            .text("Angular frequency of the harmonic force times sqrt(m_1/k_1)");
        zeta: Fixed = described_by(Form::Dimensionless, Variable::parameter(1023, "dimensionless.zeta", units::ONE, 0.1733)).range(0.0, 1e3)
            .text("Damping ratio, c/(2*sqrt(k_1*m_1))");
        sigma: Fixed = described_by(Form::Dimensionless, Variable::parameter(1024, "dimensionless.sigma", units::ONE, 16.35)).range(0.0, 1e9)
            .text("Stiffness of the impact spring, k_0/k_1");
        beta: Fixed = described_by(Form::Dimensionless, Variable::parameter(1025, "dimensionless.beta", units::ONE, 1.03)).range(0.0, 1e9)
            .text("Cubic stiffness, k_2*F_b^2/k_1^3");
        gamma: Fixed = described_by(Form::Dimensionless, Variable::parameter(1026, "dimensionless.gamma", units::ONE, 0.0)).range(-1e3, 1e3)
            .text("Gap before the impact spring, k_1*G/F_b");
        mass_ratio: Fixed = described_by(Form::Dimensionless, Variable::parameter(1027, "dimensionless.mu", units::ONE, 1.336)).range(1e-6, 1e6)
            .text("Mass of the body divided by the internal mass");
        friction: Tunable = described_by(Form::Dimensionless, Variable::parameter(1028, "dimensionless.fr", units::ONE, 1.0)).range(0.0, 1e6)
            .text("Static friction, F_s/F_b");
        position0: Fixed = Variable::parameter(1031, "position0", units::METRE, 0.0).range(-1e3, 1e3).shown_in("mm")
            .text("Initial position of the body");
        velocity0: Fixed = Variable::parameter(1032, "velocity0", units::METRE_PER_SECOND, 0.0).range(-100.0, 100.0).shown_in("mm/s")
            .text("Initial velocity of the body");
        displacement0: Fixed = Variable::parameter(1033, "displacement0", units::METRE, 0.0).range(-1e3, 1e3).shown_in("mm")
            .text("Initial position of the internal mass on the body");
        displacement_rate0: Fixed = Variable::parameter(1034, "displacementRate0", units::METRE_PER_SECOND, 0.0).range(-100.0, 100.0).shown_in("mm/s")
            .text("Initial velocity of the internal mass on the body");
    }
}

/// A parameter of one form.
fn described_by(form: Form, parameter: Variable) -> Variable {
    parameter.counts_where(Condition::is("form", &[form]))
}

impl Parameters {
    /// Whether the group `dimensionless` describes the system.
    pub fn is_dimensionless(&self) -> bool {
        self.form == Form::Dimensionless
    }

    /// The forces of the friction law.
    pub fn friction_forces(&self) -> SharedForces {
        let (variable, value) = if self.is_dimensionless() {
            ("dimensionless.fr", self.friction)
        } else {
            ("friction.Fs", self.break_away)
        };
        SharedForces {
            statics: SharedForce { variable, value, force: value },
            coulomb: SharedForce {
                variable: "friction.ratio",
                value: self.coulomb_ratio,
                force: self.coulomb_ratio * value,
            },
        }
    }
}
