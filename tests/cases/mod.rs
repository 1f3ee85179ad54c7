//! Models under every law and on rigs that differ in which variables have an effect.

#![allow(dead_code, reason = "each test uses a part of it")]

use pneumatic_servo::co_simulation::Simulation;
use pneumatic_servo::model::{Model, Seeds, Setup, Start};
use pneumatic_servo::variables::{Kind, ParameterError, Variable};

/// Values chosen or changed together.
pub type Changes = Vec<(&'static str, f64)>;

/// Rigs that differ in which variables have an effect.
pub fn rigs(model: &Model) -> Vec<Changes> {
    match model.name {
        "PneumaticServoCylinder" => {
            let leaking = |first: (&'static str, f64)| {
                vec![first, ("piston.leakage", 1e-13), ("friction.kappaA", 1e-6), ("friction.kappaB", 1e-6)]
            };
            vec![
                leaking(("chamberA.pressure0", 6e5)),
                leaking(("chamberB.pressure0", 6e5)),
                leaking(("actuation", 2.0)),
                vec![("thermal.model", 2.0), ("valve.characteristic", 2.0)],
                vec![("thermal.model", 3.0), ("balance.enabled", 1.0)],
                vec![
                    ("chamberB.open", 1.0),
                    ("load.stiffness", 100.0),
                    ("friction.position.amplitude", 0.3),
                    ("friction.kappaDifference", 1e-6),
                    ("sensor.force.lag", 0.01),
                ],
                vec![("hoseA.length", 1.0), ("hoseB.length", 1.0), ("supply.volume", 1e-4), ("supply.C", 1e-9)],
                // In the range where the cushions of both ends close, air flowing out of both chambers.
                vec![
                    ("hoseA.length", 1.0),
                    ("hoseB.length", 1.0),
                    ("throttleA.C", 2e-9),
                    ("throttleB.C", 2e-9),
                    ("cushion.length", 0.26),
                    ("chamberA.pressure0", 6e5),
                    ("chamberB.pressure0", 6e5),
                ],
                vec![("actuation", 2.0), ("hoseA.length", 1.0), ("supply.volume", 1e-4)],
                vec![("supply.volume", 1e-4), ("chamberA.pressure0", 6e5), ("chamberB.pressure0", 6e5)],
                // Pressed against an end stop.
                vec![("position0", 0.0), ("wireForce", 1e3)],
                vec![("motion", 2.0), ("friction.kappaA", 1e-6), ("friction.kappaB", 1e-6)],
            ]
        }
        "FrictionBench" => vec![
            vec![("bench.drive", 1.0), ("spring.damping", 3.0)],
            vec![("bench.drive", 2.0)],
            vec![("bench.drive", 3.0), ("appliedForce", 20.0)],
            vec![("bench.drive", 4.0)],
        ],
        "VibroImpact" => vec![vec![], vec![("form", 2.0)], vec![("velocity0", 0.1)]],
        // Buffers pressed or ropes taut; each trolley once held by its friction while the others move.
        "Festoon" => {
            let held = ["friction.level[1]", "friction.level[2]", "friction.level[3]"];
            let spacings = [0.15, 1.05];
            let rig = |held: &'static str, spacing| vec![("spacing0", spacing), ("load.angle0", 0.3), (held, 10.0)];
            held.into_iter().flat_map(|held| spacings.map(|spacing| rig(held, spacing))).collect()
        }
        _ => vec![vec![]],
    }
}

/// Rigs whose particulars have nothing to do with the law, which is the default one.
fn rigs_of_one_law(model: &Model) -> Vec<Changes> {
    if model.name != "PneumaticServoCylinder" {
        return Vec::new();
    }
    vec![
        vec![("actuation", 3.0), ("switching.centre", 2.0)],
        vec![("actuation", 3.0), ("switching.centre", 2.0), ("hoseA.length", 1.0), ("hoseB.length", 1.0)],
        vec![("actuation", 3.0), ("chamberA.pressure0", 6e5), ("supply.volume", 1e-4), ("hoseA.length", 1.0)],
        vec![("sensor.position.lag", 0.01), ("sensor.pressureA.lag", 0.01), ("sensor.pressureB.lag", 0.01)],
        vec![
            ("consumption.enabled", 1.0),
            ("hoseA.length", 1.0),
            ("hoseB.length", 1.0),
            ("chamberA.leakage", 1e-10),
            ("chamberB.leakage", 2e-11),
        ],
        // Chamber pressures above the supply's, so that air flows back into it.
        vec![("consumption.enabled", 1.0), ("chamberA.pressure0", 8e5), ("chamberB.pressure0", 8e5)],
        vec![("consumption.enabled", 1.0), ("actuation", 2.0), ("chamberA.leakage", 1e-9)],
        vec![("consumption.enabled", 1.0), ("actuation", 3.0), ("supply.volume", 1e-4), ("chamberB.leakage", 1e-9)],
        vec![("consumption.enabled", 1.0), ("actuation", 3.0)],
        vec![("consumption.enabled", 1.0), ("actuation", 4.0), ("valveVoltageA", 7.0), ("valveVoltageB", 6.0)],
        vec![("consumption.enabled", 1.0), ("actuation", 5.0), ("hoseA.length", 1.0), ("supply.volume", 1e-4)],
        vec![("actuation", 5.0), ("valveVoltageA", 6.0)],
        // Valves and regulators of both chambers open, with and without lines.
        vec![
            ("consumption.enabled", 1.0),
            ("actuation", 5.0),
            ("valveVoltageA", 6.0),
            ("valveVoltageB", 7.0),
            ("chamberA.leakage", 1e-9),
            ("chamberB.leakage", 1e-9),
        ],
        vec![
            ("actuation", 4.0),
            ("hoseA.length", 1.0),
            ("hoseB.length", 1.0),
            ("supply.volume", 1e-4),
            ("valveVoltageA", 7.0),
            ("valveVoltageB", 6.0),
        ],
        vec![("actuation", 5.0), ("hoseA.length", 1.0), ("hoseB.length", 1.0), ("valveVoltageB", 7.0)],
        vec![("chamberA.open", 1.0), ("load.stiffness", 100.0), ("friction.direction.factor", 1.3)],
        vec![
            ("motion", 2.0),
            ("coupling.compliance", 1e-5),
            ("coupling.damping", 50.0),
            ("friction.direction.factor", 1.3),
            ("friction.position.amplitude", 0.3),
        ],
        vec![
            ("motion", 2.0),
            ("coupling.compliance", 1e-5),
            ("coupling.damping", 50.0),
            ("imposedVelocity", 0.1),
            ("sensor.force.lag", 0.01),
        ],
        // Led against an end stop, in a cylinder with much space behind.
        vec![
            ("motion", 2.0),
            ("imposedPosition", -1e-3),
            ("chamberA.open", 1.0),
            ("chamberB.open", 1.0),
            ("chamberA.deadVolume", 1e-3),
            ("chamberB.deadVolume", 1e-3),
        ],
    ]
}

/// A model under all its laws on all its rigs, law by law, and on the rigs of one law; GMS with all its elements.
pub fn cases(model: &Model) -> Vec<Changes> {
    let table = model.table();
    let laws: Vec<i32> = match table.find("friction.law").map(|entry| entry.variable.kind) {
        Some(Kind::Enumeration(of)) => of.items.iter().map(|(id, ..)| *id).collect(),
        _ => return rigs(model),
    };
    const SHARES: [&str; 6] = [
        "friction.gms.alpha[5]",
        "friction.gms.alpha[6]",
        "friction.gms.alpha[7]",
        "friction.gms.alpha[8]",
        "friction.gms.alpha[9]",
        "friction.gms.alpha[10]",
    ];
    let elements = SHARES.map(|share| (share, 0.1)).into_iter().chain([("friction.gms.N", 10.0)]);
    let of_law = |law: i32| {
        let elements = elements.clone();
        rigs(model).into_iter().map(move |rig| {
            let law = [("friction.law", f64::from(law))];
            rig.into_iter().chain(law).chain(elements.clone()).collect()
        })
    };
    laws.into_iter().flat_map(of_law).chain(rigs_of_one_law(model)).collect()
}

/// A model with changes, ready to start.
pub fn setup(model: &'static Model, changes: &Changes) -> Setup {
    changes.iter().fold(Setup::new(model), |setup, (name, value)| {
        setup.set(name, *value).unwrap_or_else(|error| panic!("{} {changes:?}: {error}", model.name))
    })
}

/// A model started with changes, with its parameters and inputs.
pub fn start(model: &Model, changes: &Changes) -> Started {
    try_start(model, changes).unwrap_or_else(|error| panic!("{} {changes:?}: {error}", model.name))
}

/// A simulation, its parameters and its inputs.
pub type Started = (Box<dyn Simulation>, Vec<f64>, Vec<f64>);

/// The same, or why the model refuses to start.
pub fn try_start(model: &Model, changes: &Changes) -> Result<Started, ParameterError> {
    let table = model.table();
    let start = |variable: &Variable| match changes.iter().find(|(name, _)| *name == variable.name) {
        Some((_, value)) => *value,
        None => variable.start.expect("a start value"),
    };
    let parameters: Vec<f64> = table.parameters().map(start).collect();
    let inputs: Vec<f64> = table.inputs().map(start).collect();
    let start = Start { time: 0.0, parameters: &parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
    Ok(((model.functions.start)(&start)?, parameters, inputs))
}
