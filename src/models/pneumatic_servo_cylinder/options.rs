//! Options of the cylinder beyond the rig: everything here is off by default.
//!
//! Equations of a cylinder that uses some of it are compiled apart (`EXTENDED`), so that nothing of it
//! costs the others an instruction. The diameter of a second rod is a number like others, and costs nobody anything.

use std::f64::consts::TAU;

use super::ends::EndSwitches;
use super::motion::{Guidance, Motion};
use crate::friction::Lubrication;
use crate::numbers::{MonotoneCurve, Pair, STILL, Scalar, Tangent};
use crate::pneumatics::gas::Gas;
use crate::pneumatics::hose::Hose;
use crate::variables::{Condition, Fixed, Notice, ParameterError, Tunable, Variable, counted_by, units};
use crate::{enumeration, parameters};

enumeration! {
    /// The choice of the flow that a one-way flow control throttles; ids are never reused.
    ThrottledFlow "ThrottledFlow": "Flow that the one-way flow controls throttle" {
        1 MeterOut: "Out of the chamber";
        2 MeterIn: "Into the chamber";
    }
}

/// The restrictions of ports that lie between two volumes.
const RESTRICTIONS: [&str; 5] = ["throttleA.C", "throttleB.C", QUICK_EXHAUSTS[0], QUICK_EXHAUSTS[1], "cushion.length"];

const QUICK_EXHAUSTS: [&str; 2] = ["quickExhaustA.C", "quickExhaustB.C"];

/// Parts with laminar flow: the hoses, of which a restricted port has one of its own, and the gap of the piston.
const VISCOUS: [&str; 8] = [
    "hoseA.length",
    "hoseB.length",
    RESTRICTIONS[0],
    RESTRICTIONS[1],
    RESTRICTIONS[2],
    RESTRICTIONS[3],
    RESTRICTIONS[4],
    "piston.leakage",
];

/// Most points of the table of the load factor along the stroke, and their default positions in m, evenly along the default stroke.
const PROFILE_POINTS: usize = 9;
const PROFILE_POSITIONS: [f64; PROFILE_POINTS] = [0.0, 0.0625, 0.125, 0.1875, 0.25, 0.3125, 0.375, 0.4375, 0.5];

parameters! {
    /// The parameters of options, which are off by default.
    Options {
        rod_a: Fixed = Variable::parameter(1201, "cylinder.rodA", units::METRE, 0.0).range(0.0, 1.0).nominal(5e-3).shown_in("mm")
            .text("Diameter of a second rod, through chamber A, smaller than the bore; equal to cylinder.rod: a symmetric cylinder");
        opens_b: bool = Variable::option(1202, "chamberB.open", false)
            .text("Chamber B is open to the surroundings (single-acting): its pressure is ambient, independent of its initial pressure and of the valve, whose port B is plugged");
        spring_stiffness: Fixed = Variable::parameter(1203, "load.stiffness", units::NEWTON_PER_METRE, 0.0).range(0.0, 1e8).plausible(1.0, 1e8).nominal(100.0)
            .text("Stiffness of a spring between carriage and frame: a load, or the return spring of a single-acting cylinder");
        spring_rest: Fixed = Variable::parameter(1204, "load.rest", units::METRE, 0.0).counts_with("load.stiffness").range(-10.0, 10.0).plausible(-2.0, 2.0).nominal(0.1).shown_in("mm")
            .text("Position of the carriage at which the spring is relaxed; outside the stroke for a spring under preload");
        kappa_difference: Fixed = Variable::parameter(1205, "friction.kappaDifference", units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).nominal(1e-6).shown_in("1/bar")
            .text("Increase of the load factor of friction per absolute pressure difference between the chambers");
        waviness: Fixed = Variable::parameter(1206, "friction.position.amplitude", units::ONE, 0.0).range(0.0, 1.0).nominal(0.1)
            .text("Variation of the load factor along the stroke, as a sine: largest deviation as a fraction of the mean");
        wave_length: Fixed = Variable::parameter(1207, "friction.position.period", units::METRE, 0.05).counts_with("friction.position.amplitude").range(1e-6, 10.0).plausible(1e-4, 1.0).shown_in("mm")
            .text("Period of the variation along the stroke; the level at position 0 is the mean, and rises from there");
        hose_length_a: Fixed = hose_length(1210, "A");
        hose_diameter_a: Fixed = hose_diameter(1211, "A");
        hose_length_b: Fixed = hose_length(1212, "B");
        hose_diameter_b: Fixed = hose_diameter(1213, "B");
        throttle_a: Fixed = throttle(1214, "A");
        throttle_b: Fixed = throttle(1215, "B");
        throttle_free: Fixed = Variable::parameter(1216, "throttle.free", units::CUBIC_METRE_PER_SECOND_PASCAL, 1e-8).counts_where(Condition::any_on(&RESTRICTIONS)).range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance of flow controls and cushions the other way, and of a port with a cushion that is open");
        throttle_ratio: Fixed = Variable::parameter(1217, "throttle.b", units::ONE, 0.3).counts_where(Condition::any_on(&RESTRICTIONS)).range(0.0, 0.99)
            .text("Critical pressure ratio of flow controls and cushions");
        throttled_flow: ThrottledFlow = Variable::choice(1218, "throttle.direction", ThrottledFlow::MeterOut).counts_where(Condition::any_on(&["throttleA.C", "throttleB.C"]))
            .text("Flow that the one-way flow controls throttle");
        cushion_length: Fixed = Variable::parameter(1219, "cushion.length", units::METRE, 0.0).range(0.0, 1.0).nominal(0.02).absent_at_zero().shown_in("mm")
            .text("Length of the end cushions at both ends of the stroke, at most the stroke; 0: none. Without a hose a port is a passage of 50 mm with the diameter of its hose");
        cushion_conductance: Fixed = Variable::parameter(1220, "cushion.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 2e-10).counts_with("cushion.length").range(1e-14, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance by which air leaves a chamber through its cushion");
        vessel_volume: Fixed = Variable::parameter(1221, "supply.volume", units::CUBIC_METRE, 0.0).range(0.0, 100.0).plausible(1e-6, 0.5).nominal(1e-3).absent_at_zero().shown_in("cm3")
            .text("Volume of a vessel between the supply and the valve, at the temperature of the supply; 0: none");
        vessel_conductance: Fixed = Variable::parameter(1222, "supply.C", units::CUBIC_METRE_PER_SECOND_PASCAL, 1e-8).counts_with("supply.volume").range(1e-13, 1e-5).shown_in("dm3/(s.bar)")
            .text("Sonic conductance between the supply and the vessel");
        vessel_ratio: Fixed = Variable::parameter(1223, "supply.b", units::ONE, 0.3).counts_with("supply.volume").range(0.0, 0.99)
            .text("Critical pressure ratio between the supply and the vessel");
        leak_a: Tunable = leak(1225, "A");
        leak_b: Tunable = leak(1226, "B");
        leak_ratio: Tunable = Variable::parameter(1227, "leakage.b", units::ONE, 0.3).counts_where(Condition::any_on(&["chamberA.leakage", "chamberB.leakage"])).range(0.0, 0.99)
            .text("Critical pressure ratio of the leaks from the chambers to the surroundings");
        opens_a: bool = Variable::option(1228, "chamberA.open", false)
            .text("Chamber A is open to the surroundings, as chamber B with chamberB.open: a pulling cylinder, which a spring may extend");
        direction_factor: Fixed = Variable::parameter(1229, "friction.direction.factor", units::ONE, 1.0).range(0.01, 100.0)
            .text("Load factor of a carriage that moves outwards, or is pushed outwards at rest, relative to that inwards");
        motion: Motion = Variable::choice(1230, "motion", Motion::Free)
            .text("What moves the carriage: forces, or a multibody tool by imposedPosition and imposedVelocity");
        compliance: Fixed = Variable::parameter(1231, "coupling.compliance", units::METRE_PER_NEWTON, 0.0).range(0.0, 1.0).plausible(1e-12, 1e-2).nominal(1e-6).absent_at_zero().shown_in("um/N")
            .text("Compliance of a spring between the carriage and the imposed motion; 0: the carriage moves as imposed. It needs motion = Imposed");
        coupling_damping: Fixed = Variable::parameter(1232, "coupling.damping", units::NEWTON_SECOND_PER_METRE, 0.0).range(0.0, 1e8).nominal(100.0)
            .text("Damping in parallel with the spring of coupling.compliance, which it needs");
        quick_exhaust_a: Fixed = quick_exhaust(1233, "A");
        quick_exhaust_b: Fixed = quick_exhaust(1234, "B");
        quick_exhaust_ratio: Fixed = Variable::parameter(1235, "quickExhaust.b", units::ONE, 0.3).counts_where(Condition::any_on(&QUICK_EXHAUSTS)).range(0.0, 0.99)
            .text("Critical pressure ratio of the quick exhaust valves");
        quick_exhaust_opening: Fixed = Variable::parameter(1236, "quickExhaust.opening", units::PASCAL, 1e4).counts_where(Condition::any_on(&QUICK_EXHAUSTS)).range(1e3, 1e6).shown_in("bar")
            .text("Pressure by which a chamber must exceed its supply line for a quick exhaust valve to be fully open; it opens in proportion");
        one_way_damping: Fixed = Variable::parameter(1237, "friction.direction.damping", units::NEWTON_SECOND_PER_METRE, 0.0).range(-1e4, 1e4).nominal(10.0).turns_at_zero()
            .text("Viscous friction in one direction alone, added to the law: outwards if positive, inwards with its magnitude if negative");
        kappa_driving: Fixed = kappa_of_role(1238, "friction.kappaDriving", "that drives: A outwards, B inwards");
        kappa_resisting: Fixed = kappa_of_role(1239, "friction.kappaResisting", "that resists: B outwards, A inwards");
        stribeck_by_driving: Fixed = kappa_of_film(1290, "stribeckVelocity.kappaDriving", "Stribeck velocity", "that drives: A outwards, B inwards");
        stribeck_by_resisting: Fixed = kappa_of_film(1291, "stribeckVelocity.kappaResisting", "Stribeck velocity", "that resists: B outwards, A inwards");
        viscous_by_driving: Fixed = kappa_of_film(1292, "viscous.kappaDriving", "viscous friction coefficient", "that drives: A outwards, B inwards");
        viscous_by_resisting: Fixed = kappa_of_film(1293, "viscous.kappaResisting", "viscous friction coefficient", "that resists: B outwards, A inwards");
        guide_coefficient: Fixed = Variable::parameter(1294, "friction.guide.coefficient", units::ONE, 0.0).range(0.0, 10.0).nominal(0.1)
            .text("Coefficient of friction of a guide that is pressed on by the load that it moves; its product with friction.guide.lever must be below 1; 0: none");
        guide_lever: Fixed = Variable::parameter(1295, "friction.guide.lever", units::ONE, 1.0).counts_with("friction.guide.coefficient").range(0.0, 1000.0)
            .text("Normal force of that guide, of all its bearings, over the force that moves the load: 2*e/L of a load at a distance e beside a guide of length L");
        profile_points: usize = Variable::count(1270, "friction.position.points", 0).range(0.0, PROFILE_POINTS as f64)
            .text("Number of points of a table of the load factor along the stroke, which multiplies it beside the sine: worn or dirty parts of a barrel; 0: none, else at least 2");
        profile_positions: [Fixed; PROFILE_POINTS] = counted_by("friction.position.points", Variable::parameter(1271, "friction.position.at", units::METRE, 0.0).range(-10.0, 10.0).plausible(-0.1, 5.0).shown_in("mm")
            .text("Position of the carriage of the point, rising from point to point").array(PROFILE_POSITIONS));
        profile_factors: [Fixed; PROFILE_POINTS] = counted_by("friction.position.points", Variable::parameter(1280, "friction.position.factor", units::ONE, 0.0).range(0.0, 100.0)
            .text("Factor of the load factor there; between the points a smooth curve that turns at points alone, constant beyond them").array([1.0; PROFILE_POINTS]));
        end_switches: EndSwitches = EndSwitches::variables();
        gas_constant: Fixed = Variable::parameter(1260, "gas.R", units::JOULE_PER_KILOGRAM_KELVIN, Gas::AIR.constant.value).range(20.0, 5000.0)
            .text("Specific gas constant, of dry air by default. Sonic conductances and leaks are stated for air, and pass another gas as nozzles and gaps of the same size do");
        heat_ratio: Fixed = Variable::parameter(1261, "gas.gamma", units::ONE, Gas::AIR.heat_ratio.value).range(1.01, 1.7)
            .text("Ratio of the specific heats of the gas, of air by default");
        viscosity: Fixed = Variable::parameter(1262, "gas.viscosity", units::PASCAL_SECOND, Gas::AIR.viscosity.value).counts_where(Condition::any_on(&VISCOUS)).range(1e-6, 1e-3)
            .text("Dynamic viscosity of the gas in hoses and in the leak past the piston, of air at 20 degC by default");
        counts_supply: bool = Variable::option(1224, "consumption.enabled", false)
            .text("Count the gas that is drawn from the supply, for supply.massFlow, supply.consumed and supply.consumedVolume");
    }
}

fn hose_length(reference: u32, chamber: &str) -> Variable {
    Variable::parameter(reference, &format!("hose{chamber}.length"), units::METRE, 0.0).range(0.0, 100.0).nominal(1.0).absent_at_zero().text(
        &format!(
            "Length of the hose between the valve and chamber {chamber}, beyond chamber{chamber}.deadVolume; 0: none, else at least 0.1 mm"
        ),
    )
}

fn hose_diameter(reference: u32, chamber: &str) -> Variable {
    let own = [
        &format!("hose{chamber}.length"),
        &format!("throttle{chamber}.C"),
        &format!("quickExhaust{chamber}.C"),
        "cushion.length",
    ];
    Variable::parameter(reference, &format!("hose{chamber}.diameter"), units::METRE, 4e-3)
        .counts_where(Condition::any_on(&own))
        .range(5e-4, 0.1)
        .shown_in("mm")
        .text(&format!("Inner diameter of the hose to chamber {chamber}"))
}

fn kappa_of_role(reference: u32, name: &str, chamber: &str) -> Variable {
    Variable::parameter(reference, name, units::PER_PASCAL, 0.0).range(-1e-3, 1e-3).nominal(1e-6).shown_in("1/bar").text(&format!(
        "Increase of the load factor of friction per pressure above ambient of the chamber {chamber}; at rest by the direction of the push"
    ))
}

fn kappa_of_film(reference: u32, name: &str, what: &str, chamber: &str) -> Variable {
    let kappa = Variable::parameter(reference, &format!("friction.{name}"), units::PER_PASCAL, 0.0).range(-1e-3, 1e-3);
    kappa.nominal(1e-6).shown_in("1/bar").text(&format!(
        "Increase of the {what}, as a fraction of that of the law, per pressure above ambient of the chamber {chamber}"
    ))
}

fn leak(reference: u32, chamber: &str) -> Variable {
    let leak =
        Variable::parameter(reference, &format!("chamber{chamber}.leakage"), units::CUBIC_METRE_PER_SECOND_PASCAL, 0.0);
    let leak = leak.counts_where(Condition::off(&format!("chamber{chamber}.open")));
    leak.range(0.0, 1e-5)
        .nominal(1e-11)
        .shown_in("dm3/(s.bar)")
        .text(&format!("Sonic conductance of a leak from chamber {chamber} to the surroundings; 0: tight"))
}

fn quick_exhaust(reference: u32, chamber: &str) -> Variable {
    Variable::parameter(reference, &format!("quickExhaust{chamber}.C"), units::CUBIC_METRE_PER_SECOND_PASCAL, 0.0)
        .range(0.0, 1e-5)
        .nominal(1e-8)
        .absent_at_zero()
        .shown_in("dm3/(s.bar)")
        .text(&format!("Sonic conductance from chamber {chamber} to the surroundings of a quick exhaust valve in its port; 0: none. Without a hose it is behind a passage of 50 mm with hose{chamber}.diameter, and lets air in with throttle.free"))
}

fn throttle(reference: u32, chamber: &str) -> Variable {
    Variable::parameter(reference, &format!("throttle{chamber}.C"), units::CUBIC_METRE_PER_SECOND_PASCAL, 0.0)
        .range(0.0, 1e-5)
        .nominal(2e-9)
        .absent_at_zero()
        .shown_in("dm3/(s.bar)")
        .text(&format!("Sonic conductance of a one-way flow control at chamber {chamber}; 0: none. Without a hose it is screwed into the port, behind a passage of 50 mm with hose{chamber}.diameter"))
}

/// What chambers A and B have, of the one that drives and of the one that resists, for a motion or a push towards the side of a number.
fn by_roles<S>([a, b]: [S; 2], towards: f64) -> [S; 2] {
    if towards > 0.0 { [a, b] } else { [b, a] }
}

impl Options {
    /// Whether any equation differs from the plain cylinder's, which has no options.
    pub fn are_used(&self) -> bool {
        let Self { counts_supply, spring_stiffness, kappa_difference, waviness, .. } = *self;
        let [restrictions_a, restrictions_b] = [self.throttle_a, self.throttle_b];
        let hoses = [self.hose_length_a, self.hose_length_b, self.vessel_volume];
        let lines = hoses.into_iter().chain([restrictions_a, restrictions_b, self.cushion_length]);
        let lines = lines.chain(self.quick_exhausts());
        let is_chosen = self.opens().contains(&true) || counts_supply || self.differs_by_direction();
        let is_chosen = is_chosen || self.motion != Motion::Free || self.end_switches.are_used();
        let is_chosen = is_chosen || self.profile_points > 0 || self.lubricating().is_some() || self.guide().is_some();
        is_chosen
            || self.has_another_gas()
            || [spring_stiffness, kappa_difference, waviness, self.one_way_damping]
                .into_iter()
                .chain(lines)
                .any(Tangent::is_used)
    }

    /// Whether the load factor of friction is another outwards than inwards.
    pub fn differs_by_direction(&self) -> bool {
        self.direction().is_some()
    }

    /// The first parameter by which the load factor of friction differs between outwards and inwards, and its value.
    pub fn direction(&self) -> Option<(&'static str, f64)> {
        let factor = self.direction_factor;
        let roles = [("friction.kappaDriving", self.kappa_driving), ("friction.kappaResisting", self.kappa_resisting)];
        let role = roles.into_iter().find(|(_, kappa)| kappa.is_used());
        let factor = (factor != 1.0 || factor.slopes != STILL).then_some(("friction.direction.factor", factor));
        factor.or(role).map(|(name, value)| (name, value.value))
    }

    /// The first parameter by which the pressures change Stribeck velocity or viscous friction, and its value.
    pub fn lubricating(&self) -> Option<(&'static str, f64)> {
        let kappas = [
            ("friction.stribeckVelocity.kappaDriving", self.stribeck_by_driving),
            ("friction.stribeckVelocity.kappaResisting", self.stribeck_by_resisting),
            ("friction.viscous.kappaDriving", self.viscous_by_driving),
            ("friction.viscous.kappaResisting", self.viscous_by_resisting),
        ];
        kappas.into_iter().find(|(_, kappa)| kappa.is_used()).map(|(name, kappa)| (name, kappa.value))
    }

    /// Friction of the guide over the force that moves the load, where there is one.
    pub fn guide(&self) -> Option<Tangent> {
        Some(self.guide_coefficient * self.guide_lever).filter(|ratio| ratio.is_used())
    }

    /// Refuses a guide that jams, and one beside a motion whose force is not known.
    fn check_guide(&self) -> Result<(), ParameterError> {
        let Some(ratio) = self.guide() else { return Ok(()) };
        let refused =
            |reason: &str| Err(ParameterError::new("friction.guide.coefficient", self.guide_coefficient.value, reason));
        if ratio >= 1.0 {
            let reason = format!(
                "with friction.guide.lever = {} the guide jams: it would brake a load by {} of the force that moves it, and no \
                 acceleration is consistent with that; their product must be below 1",
                self.guide_lever.value, ratio.value
            );
            return refused(&reason);
        }
        if self.guidance() == Guidance::Rigid {
            return refused(
                "the force that moves the load is not known where the motion is imposed: set coupling.compliance, too",
            );
        }
        Ok(())
    }

    /// Factor of the load factor over the position in m, where the barrel has a table of it.
    pub fn profile(&self) -> Option<MonotoneCurve> {
        let points = self.profile_positions.into_iter().zip(self.profile_factors).take(self.profile_points);
        (self.profile_points > 0).then(|| MonotoneCurve::through(&points.collect::<Vec<_>>()))
    }

    /// The gas.
    pub fn gas(&self) -> Gas {
        Gas::new(self.gas_constant, self.heat_ratio, self.viscosity)
    }

    /// Whether pressures and flows differ from those in air, or are differentiated by the gas. Hoses and leaks have its viscosity.
    fn has_another_gas(&self) -> bool {
        [self.gas_constant, self.heat_ratio] != [Gas::AIR.constant, Gas::AIR.heat_ratio]
    }

    /// Lengths and inner diameters in m of the hoses.
    pub fn hoses(&self) -> [[Tangent; 2]; 2] {
        [[self.hose_length_a, self.hose_diameter_a], [self.hose_length_b, self.hose_diameter_b]]
    }

    /// Whether each chamber is open to the surroundings.
    pub fn opens(&self) -> [bool; 2] {
        [self.opens_a, self.opens_b]
    }

    /// Sonic conductances in m3/(s Pa) of the flow controls.
    pub fn throttles(&self) -> [Tangent; 2] {
        [self.throttle_a, self.throttle_b]
    }

    /// Sonic conductances in m3/(s Pa) of the quick exhaust valves.
    pub fn quick_exhausts(&self) -> [Tangent; 2] {
        [self.quick_exhaust_a, self.quick_exhaust_b]
    }

    /// A hose, flow control or quick exhaust valve at a chamber that is open to the surroundings.
    pub fn left_out(&self) -> Option<Notice> {
        const NAMES: [[&str; 3]; 2] =
            [["hoseA.length", "throttleA.C", "quickExhaustA.C"], ["hoseB.length", "throttleB.C", "quickExhaustB.C"]];
        let remark = "it is left out, since the chamber is open to the surroundings and its port is plugged";
        (0..2).filter(|side| self.opens()[*side]).find_map(|side| {
            let values = [self.hoses()[side][0], self.throttles()[side], self.quick_exhausts()[side]];
            let place = values.iter().position(|value| *value > 0.0)?;
            Some(Notice { variable: NAMES[side][place], value: values[place].value, remark })
        })
    }

    /// Drive of the carriage.
    pub(super) fn guidance(&self) -> Guidance {
        match self.motion {
            Motion::Free => Guidance::Free,
            Motion::Imposed if self.compliance.value == 0.0 => Guidance::Rigid,
            Motion::Imposed => Guidance::Compliant { stiffness: 1.0 / self.compliance, damping: self.coupling_damping },
        }
    }

    /// Refuses a rod that fills the bore, in m, a cushion or a switch beyond the stroke, in m, and a coupling without its parts.
    pub fn check(&self, bore: f64, stroke: f64) -> Result<(), ParameterError> {
        if self.rod_a >= bore {
            let reason = format!("it must be smaller than cylinder.bore = {bore}");
            return Err(ParameterError::new("cylinder.rodA", self.rod_a.value, &reason));
        }
        if self.cushion_length > stroke {
            let reason = format!("it must not exceed cylinder.stroke = {stroke}");
            return Err(ParameterError::new("cushion.length", self.cushion_length.value, &reason));
        }
        self.check_profile()?;
        self.check_guide()?;
        if self.compliance > 0.0 && self.motion == Motion::Free {
            let reason = "it needs a motion to couple with: set motion = Imposed, too";
            return Err(ParameterError::new("coupling.compliance", self.compliance.value, reason));
        }
        if self.coupling_damping > 0.0 && self.compliance == 0.0 {
            let reason = "it needs a spring beside it: set coupling.compliance, too";
            return Err(ParameterError::new("coupling.damping", self.coupling_damping.value, reason));
        }
        for (side, chamber) in ["A", "B"].into_iter().enumerate() {
            let [length, _] = self.hoses()[side].map(|it| it.value);
            if length > 0.0 && length < Hose::SHORTEST {
                let reason = format!("it must be 0, for no hose, or at least {}", Hose::SHORTEST);
                return Err(ParameterError::new(&format!("hose{chamber}.length"), length, &reason));
            }
        }
        self.end_switches.check(stroke)
    }

    /// Refuses a table along the stroke of one point, and points that do not rise.
    fn check_profile(&self) -> Result<(), ParameterError> {
        if self.profile_points == 1 {
            let reason = "it must be 0, for no table, or at least 2";
            return Err(ParameterError::new("friction.position.points", 1.0, reason));
        }
        let positions = &self.profile_positions[..self.profile_points];
        match (1..positions.len()).find(|place| positions[*place].value <= positions[place - 1].value) {
            None => Ok(()),
            Some(place) => {
                let reason = format!("it must exceed the one before, {}", positions[place - 1].value);
                let name = format!("friction.position.at[{}]", place + 1);
                Err(ParameterError::new(&name, positions[place].value, &reason))
            }
        }
    }

    /// Force of the spring on the carriage towards +x, in N: `-k*(x - rest)`.
    pub fn spring_force<S: Scalar>(&self, position: S) -> S {
        -(position - self.spring_rest) * self.spring_stiffness
    }

    /// Viscous friction in N, at a velocity in m/s, that acts in one direction alone: `d*max(v, 0)`, or `-d*min(v, 0)` if `d < 0`.
    pub fn one_way_friction<S: Scalar>(&self, velocity: S) -> S {
        let (damping, towards) = (self.one_way_damping, velocity.value());
        if damping >= 0.0 && towards > 0.0 {
            velocity * damping
        } else if damping < 0.0 && towards < 0.0 {
            -velocity * damping
        } else {
            S::zero()
        }
    }

    /// Increase of the load factor by the pressure difference.
    pub fn added_level<S: Scalar>(&self, Pair([p_a, p_b]): Pair<S>) -> S {
        (p_a - p_b).abs() * self.kappa_difference
    }

    /// Increase of the load factor by the pressures above ambient of the chamber that drives and of the one that resists, for a
    /// motion or a push towards the side of a number.
    pub fn added_by_roles<S: Scalar>(&self, excess: [S; 2], towards: f64) -> S {
        let [driving, resisting] = by_roles(excess, towards);
        driving * self.kappa_driving + resisting * self.kappa_resisting
    }

    /// Factors on Stribeck velocity and viscous friction by the pressures above ambient, of a motion towards the side of a number.
    pub fn lubrication<S: Scalar>(&self, excess: [S; 2], towards: f64) -> Lubrication<S> {
        let [driving, resisting] = by_roles(excess, towards);
        Lubrication {
            stribeck_velocity: driving * self.stribeck_by_driving + resisting * self.stribeck_by_resisting + 1.0,
            viscous: driving * self.viscous_by_driving + resisting * self.viscous_by_resisting + 1.0,
        }
    }

    /// Friction level towards the side of a number, relative to the level inwards.
    pub fn directed_level(&self, towards: f64) -> Tangent {
        if towards > 0.0 { self.direction_factor } else { Tangent::still(1.0) }
    }

    /// Friction level at a position relative to the mean along the stroke: `1 + a*sin(2*pi*x/period)`.
    pub fn relative_level<S: Scalar>(&self, position: S) -> S {
        (position * (TAU / self.wave_length)).sin() * self.waviness + 1.0
    }
}
