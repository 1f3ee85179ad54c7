//! A quarter car that brakes on a tyre with lumped LuGre friction.
//!
//! ```text
//! v_r = v - R*w                                            sliding velocity           [m/s]
//! dz/dt = v_r - sigma0*|v_r|/g(v_r)*z                      mean deflection            [m/s]
//! g(v_r) = mu_C + (mu_S - mu_C)*exp(-(v_r/v_S)^2)
//! mu = sigma0*z + sigma1*dz/dt + sigma2*v_r                friction coefficient       [1]
//! dx/dt = v,   m*dv/dt = -mu*F_n,   J*dw/dt = R*mu*F_n - s*T
//! ```
//!
//! `s` is the side to which the wheel turns, so that the brake torque `T >= 0` opposes it. A wheel that comes to a halt
//! locks: its speed is exactly 0 while the tyre does not overcome the brake, `R*|mu|*F_n <= T`, and then it rolls again.

#![forbid(unsafe_code)]

use pneumatic_servo::prelude::*;

pneumatic_servo_fmu::export_fmu!(&[MODEL]);

/// The model: its description in one line, and the default experiment.
pub const MODEL: Model = Model::of::<QuarterCar, 2, 4>(
    "QuarterCar",
    "Quarter car that brakes on a LuGre tyre, with a wheel that locks and rolls again",
    Experiment {
        stop_time: 5.0,
        step_size: 5e-3,
        signals: &[Signal {
            input: "brakeTorque",
            text: "0, 1400 N·m from 0.5 s on, 500 N·m from 2 s on",
            course: Course::Steps(&[(0.0, 0.0), (0.5, 1400.0), (2.0, 500.0)]),
        }],
        panels: &[
            Panel { label: "velocity", curves: &["velocity"] },
            Panel { label: "wheel speed", curves: &["wheelSpeed"] },
            Panel { label: "slip", curves: &["slip"] },
            Panel { label: "friction", curves: &["frictionCoefficient"] },
            Panel { label: "distance", curves: &["distance"] },
        ],
    },
);

inputs! {
    /// The inputs.
    Inputs {
        torque = Variable::input(TORQUE, "brakeTorque", units::NEWTON_METRE, 0.0).at_least(0.0).nominal(100.0).text("Torque of the brake, whichever way the wheel turns");
        load = Variable::input(LOAD, "normalLoad", units::NEWTON, 2943.0).at_least(0.0).nominal(1e3).text("Force between tyre and road");
    }
}

states! {
    /// The states.
    State of Parameters {
        Distance: 10, |_| 1.0;
        Velocity: V, |_| 1.0;
        Wheel: W, |_| 1.0;
        Deflection: Z, |p| p.coulomb.value / p.stiffness.value;
    }
}

// Value references.
const TORQUE: u32 = 1;
const LOAD: u32 = 2;
const V: u32 = 11;
const W: u32 = 12;
const Z: u32 = 13;

outputs! {
    /// The computed variables.
    Outputs {
        distance = Variable::output(10, "distance", units::METRE).nominal(10.0).depends_on(&[10]).text("Distance from where the run begins");
        velocity = Variable::output(V, "velocity", units::METRE_PER_SECOND).nominal(10.0).derivative_of(10).depends_on(&[V]).text("Velocity of the car");
        wheel = Variable::output(W, "wheelSpeed", units::RADIAN_PER_SECOND).nominal(10.0).depends_on(&[W]).text("Speed of the wheel; exactly 0 while it is locked");
        deflection = Variable::output(Z, "deflection", units::METRE).nominal(1e-3).shown_in("mm").depends_on(&[Z]).text("Mean deflection of the bristles of the tyre");
        acceleration = Variable::output(14, "acceleration", units::METRE_PER_SECOND_SQUARED).local().nominal(1.0).derivative_of(V).depends_on(&[V, W, Z, LOAD]).text("Acceleration of the car");
        angular = Variable::output(15, "wheelAcceleration", units::RADIAN_PER_SECOND_SQUARED).local().nominal(10.0).derivative_of(W).depends_on(&[V, W, Z, LOAD, TORQUE]).text("Acceleration of the wheel");
        rate = Variable::output(16, "deflectionRate", units::METRE_PER_SECOND).local().nominal(1.0).derivative_of(Z).depends_on(&[V, W, Z]).text("Rate of the deflection");
        slip = Variable::output(17, "slip", units::ONE).depends_on(&[V, W]).text("Sliding velocity by the larger of the velocities of car and wheel; 1 with a locked wheel, 0 at rest");
        friction = Variable::output(18, "frictionCoefficient", units::ONE).depends_on(&[V, W, Z]).text("Friction force by normal load; positive when it brakes the car");
        locked = Variable::flag(19, "locked").depends_on(&[TORQUE, LOAD, V, W, Z]).text("True while the brake holds the wheel");
    }
}

parameters! {
    /// The parameters.
    Parameters {
        mass: Fixed = Variable::parameter(1001, "mass", units::KILOGRAM, 300.0).range(1.0, 1e12).text("Mass on the wheel");
        inertia: Fixed = Variable::parameter(1002, "wheel.inertia", units::KILOGRAM_SQUARE_METRE, 1.0).range(1e-3, 1e12).text("Moment of inertia of the wheel");
        radius: Fixed = Variable::parameter(1003, "wheel.radius", units::METRE, 0.3).range(0.01, 10.0).text("Rolling radius R");
        stiffness: Fixed = Variable::parameter(1004, "tyre.sigma0", units::PER_METRE, 180.0).range(1.0, 1e6).text("Stiffness sigma0 of the bristles by normal load");
        damping: Fixed = Variable::parameter(1005, "tyre.sigma1", units::SECOND_PER_METRE, 0.8).range(0.0, 1e3).text("Damping sigma1 of the bristles by normal load");
        viscous: Fixed = Variable::parameter(1006, "tyre.sigma2", units::SECOND_PER_METRE, 0.002).range(0.0, 10.0).text("Viscous friction sigma2 by normal load");
        coulomb: Fixed = Variable::parameter(1007, "tyre.muC", units::ONE, 0.8).range(1e-3, 10.0).text("Friction coefficient mu_C of fast sliding");
        statics: Fixed = Variable::parameter(1008, "tyre.muS", units::ONE, 1.2).range(1e-3, 10.0).text("Friction coefficient mu_S of slow sliding");
        stribeck: Fixed = Variable::parameter(1009, "tyre.vS", units::METRE_PER_SECOND, 6.0).range(1e-3, 1e3).text("Stribeck velocity v_S");
        velocity0: Fixed = Variable::parameter(1010, "velocity0", units::METRE_PER_SECOND, 30.0).range(-1e3, 1e3).text("Initial velocity of the car");
        slip0: Fixed = Variable::parameter(1011, "slip0", units::ONE, 0.0).range(0.0, 1.0).text("Initial slip: 0 of a wheel that rolls freely, 1 of one that stands");
    }
}

/// The equations for given parameters.
#[derive(Clone, Debug)]
pub struct QuarterCar(Parameters);

/// Quantities of the tyre: sliding velocity in m/s, rate of the deflection in m/s, friction coefficient.
struct Tyre<S> {
    sliding: S,
    rate: S,
    friction: S,
}

impl QuarterCar {
    /// Its quantities at these states.
    fn tyre<S: Scalar>(&self, x: &[S]) -> Tyre<S> {
        let (p, [v, w, z]) = (&self.0, [State::Velocity, State::Wheel, State::Deflection].map(|state| state.get(x)));
        let sliding = v - w * p.radius;
        let ratio = sliding / p.stribeck;
        let steady = (-ratio * ratio).exp() * (p.statics - p.coulomb) + p.coulomb;
        let rate = sliding - sliding.abs() * z * p.stiffness / steady;
        Tyre { sliding, rate, friction: z * p.stiffness + rate * p.damping + sliding * p.viscous }
    }
}

/// Place of the event with which the wheel comes to a halt.
const LOCKS: usize = 0;

impl System<2> for QuarterCar {
    type Parameters = Parameters;
    type State = State;
    /// The side to which the wheel turns: 1, -1, or 0 while it is locked.
    type Memory<S: Varying> = i32;
    type Indicators<S: Varying> = [S; 2];

    const EVENTS: &'static [Event] = &[
        Event { name: "wheel.locks", text: "The wheel comes to a halt", nominal: 1.0 },
        Event { name: "wheel.rolls", text: "The tyre overcomes the brake", nominal: 100.0 },
    ];

    fn tables() -> Tables {
        Tables { inputs: Inputs::table(), computed: Outputs::<f64>::table(), parameters: Parameters::table() }
    }

    fn new(values: &mut Values) -> Result<Self, ParameterError> {
        let p: Parameters = values.read()?;
        if p.statics.value < p.coulomb.value {
            let reason = format!("it must not be below tyre.muC = {}", p.coulomb.value);
            return Err(ParameterError::new("tyre.muS", p.statics.value, &reason));
        }
        Ok(Self(p))
    }

    fn parameters(&self) -> &Parameters {
        &self.0
    }

    fn start<S: Varying, const N: usize>(&self, _u: &[S; 2]) -> ([S; N], i32) {
        let (mut x, p) = ([S::zero(); N], &self.0);
        let wheel = S::along((1.0 - p.slip0) * p.velocity0 / p.radius);
        State::Velocity.set(&mut x, S::along(p.velocity0));
        State::Wheel.set(&mut x, wheel);
        (x, sign(wheel.value()) as i32)
    }

    fn derivatives<S: Scalar, const N: usize>(&self, _time: S, x: &[S; N], u: &[S; 2], side: &i32) -> [S; N] {
        let (p, tyre, Inputs { torque, load }) = (&self.0, self.tyre(x), Inputs::read(u));
        let mut rates = [S::zero(); N];
        State::Distance.set(&mut rates, State::Velocity.get(x));
        State::Velocity.set(&mut rates, -tyre.friction * load / p.mass);
        State::Deflection.set(&mut rates, tyre.rate);
        if *side != 0 {
            State::Wheel.set(&mut rates, (tyre.friction * load * p.radius - torque * f64::from(*side)) / p.inertia);
        }
        rates
    }

    fn indicators<S: Varying, const N: usize>(&self, _time: S, x: &[S; N], u: &[S; 2], side: &i32) -> [S; 2] {
        let (unused, Inputs { torque, load }) = (S::constant(UNUSED), Inputs::read(u));
        match side {
            0 => [unused, torque - (self.tyre(x).friction * self.0.radius * load).abs()],
            _ => [State::Wheel.get(x) * f64::from(*side), unused],
        }
    }

    fn switch<S: Varying, const N: usize>(&self, event: usize, _time: S, x: &mut [S; N], _u: &[S; 2], side: &mut i32) {
        if event == LOCKS {
            State::Wheel.set(x, S::zero());
            *side = 0;
        } else {
            *side = sign(self.tyre(x).friction.value()) as i32;
        }
    }

    fn outputs<S: Scalar, const N: usize>(&self, time: S, x: &[S; N], u: &[S; 2], side: &i32, computed: &mut [S]) {
        let (tyre, rates) = (self.tyre(x), self.derivatives(time, x, u, side));
        let [velocity, wheel] = [State::Velocity, State::Wheel].map(|state| state.get(x));
        let fastest = velocity.abs().max((wheel * self.0.radius).abs());
        let outputs = Outputs {
            distance: State::Distance.get(x),
            velocity,
            wheel,
            deflection: State::Deflection.get(x),
            acceleration: State::Velocity.get(&rates),
            angular: State::Wheel.get(&rates),
            rate: State::Deflection.get(&rates),
            slip: if fastest.value() > 0.0 { tyre.sliding / fastest } else { S::zero() },
            friction: tyre.friction,
            locked: S::constant(f64::from(u8::from(*side == 0))),
        };
        outputs.write(computed);
    }

    fn fits<S: Varying>(&self, side: &i32) -> bool {
        (-1..=1).contains(side)
    }
}
