//! Directional and adjoint derivatives, and derivatives of outputs by time.

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Role, Table, Variable};

use super::STRIBECK;
use crate::common::fmi3::{Instance3, Way};
use crate::common::*;

/// Value references of arrays and the number of all their elements.
fn arrays(table: &Table, of: impl Fn(&Variable) -> bool) -> (Vec<u32>, usize) {
    let (lengths, references): (Vec<usize>, Vec<u32>) =
        table.arrays().filter(|(_, first)| of(first)).map(|(length, first)| (length, first.reference)).unzip();
    (references, lengths.iter().sum())
}

/// Numbers of mixed sign and size.
fn seeds(number: usize) -> Vec<f64> {
    (0..number).map(|index| (1.0 + 0.37 * index as f64) * [1.0, -0.5, 2.0][index % 3]).collect()
}

/// Adjoint derivatives times a direction, and directional ones times the seeds of the adjoint: both are `v' J w`. What the
/// terms of the sum amount to is what rounding is relative to.
fn compare(instance: &Instance3, model: &Model, what: &str) {
    let table = model.table();
    let states: Vec<u32> = table.states().collect();
    let is_known = |it: &Variable| {
        matches!(it.kind, Kind::Real(_))
            && (matches!(it.role, Role::Input | Role::Time | Role::Tunable) || states.contains(&it.reference))
    };
    let (unknowns, rows) = arrays(table, |it| it.derivative_of.is_some() || it.role == Role::Output && is_real(it));
    let (knowns, columns) = arrays(table, is_known);
    let (v, w) = (seeds(rows), seeds(columns));
    let (mut forward, mut backward) = (vec![f64::NAN; rows], vec![f64::NAN; columns]);
    assert_eq!(instance.directional(&unknowns, &knowns, &w, &mut forward), OK, "{:?}", instance.messages());
    assert_eq!(instance.adjoint(&unknowns, &knowns, &v, &mut backward), OK, "{:?}", instance.messages());
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (one, other) = (product(&v, &forward), product(&backward, &w));
    let magnitude: f64 = v.iter().zip(&forward).map(|(a, b)| (a * b).abs()).sum::<f64>()
        + backward.iter().zip(&w).map(|(a, b)| (a * b).abs()).sum::<f64>();
    assert!((one - other).abs() <= 1e-13 * magnitude, "{what}: {one} and {other}");
}

#[test]
fn adjoint_derivatives_are_the_transpose_of_directional_ones_for_all_models_and_laws() {
    for model in served() {
        let law = model.table().find("friction.law").map(|entry| entry.variable);
        let laws: Vec<Option<(u32, i64)>> = match law.map(|law| (law.reference, law.kind)) {
            Some((reference, Kind::Enumeration(of))) => {
                of.items.iter().map(|(id, ..)| Some((reference, i64::from(*id)))).collect()
            }
            _ => vec![None],
        };
        for law in laws {
            let instance = Instance3::of(model, Way::Steps);
            if let Some((reference, id)) = law {
                assert_eq!(instance.set_int64(&[reference], &[id]), OK);
            }
            assert_eq!((instance.enter(), instance.exit()), (OK, OK), "{:?}", instance.messages());
            let what = format!("{} {law:?}", model.name);
            compare(&instance, model, &what);
            if let Some(voltage) = model.table().find("valveVoltage").filter(|it| it.variable.role == Role::Input) {
                // Stuck at first, then sliding.
                assert_eq!(instance.set(&[voltage.variable.reference], &[8.0]), OK);
            }
            for step in 0..3 {
                assert_eq!(instance.step(0.1 * f64::from(step), 0.1).0, OK, "{what}: {:?}", instance.messages());
                compare(&instance, model, &what);
            }
        }
    }
}

#[test]
pub fn force_accelerates_the_mass() {
    const NONE: i64 = 1;
    let instance = Instance3::cylinder(Way::Steps, NONE, 5.0);
    let mut slope = [f64::NAN];
    assert_eq!(instance.directional(&[vr("acceleration")], &[vr("externalForce")], &[0.88], &mut slope), OK);
    assert!((slope[0] - 1.0).abs() < 1e-15, "{slope:?}: 0.88 N on 0.88 kg");
}

#[test]
pub fn stuck_and_sliding_carriage_differ_in_what_an_adjoint_tells() {
    let instance = Instance3::cylinder(Way::Steps, STRIBECK, 5.0);
    let force = |instance: &Instance3| {
        let mut sensitivity = [f64::NAN];
        assert_eq!(instance.adjoint(&[vr("acceleration")], &[vr("externalForce")], &[2.0], &mut sensitivity), OK);
        sensitivity[0]
    };
    assert!(instance.sticks());
    assert_eq!(force(&instance), 0.0);
    assert_eq!(instance.set(&[vr("valveVoltage")], &[8.0]), OK);
    assert_eq!(instance.step(0.0, 0.2).0, OK);
    assert!(!instance.sticks());
    assert!((force(&instance) * instance.real("mass.moving") - 2.0).abs() < 1e-12);
}

#[test]
fn wrong_numbers_unknowns_and_seeds_are_refused() {
    const GMS: i64 = 16;
    let instance = Instance3::cylinder(Way::Steps, GMS, 5.5);
    let (rate, force) = (vr("der(friction.elementForce[1])"), vr("friction.elementForce[1]"));
    let mut backward = [f64::NAN; 2];
    assert_eq!(instance.adjoint(&[rate], &[vr("velocity"), force], &[1.0], &mut backward), OK);
    assert!(backward[0] > 0.0, "the elements are springs");
    let before = backward;
    let arrays = vr("friction.gms.k[1]");
    for (unknowns, knowns, seeds) in [
        (vec![rate], vec![force], vec![1.0]),
        (vec![rate], vec![force, force], vec![1.0, 1.0]),
        (vec![rate], vec![rate, force], vec![1.0]),
        (vec![vr("valveVoltage")], vec![force, force], vec![1.0]),
        (vec![rate], vec![force, force], vec![f64::NAN]),
        (vec![rate], vec![arrays], vec![1.0]),
        (vec![arrays], vec![force, force], vec![1.0]),
        (vec![6_000], vec![force, force], vec![1.0]),
    ] {
        assert_eq!(instance.adjoint(&unknowns, &knowns, &seeds, &mut backward), ERROR, "{unknowns:?} {knowns:?}");
    }
    assert_eq!(backward, before);
}

#[test]
pub fn output_derivatives_of_order_1_are_those_of_the_variables() {
    let instance = Instance3::cylinder(Way::Steps, STRIBECK, 8.0);
    assert_eq!(instance.step(0.0, 0.2).0, OK);
    let mut rates = [f64::NAN; 2];
    assert_eq!(instance.output_rates(&[vr("position"), vr("velocity")], &[1, 1], &mut rates), OK);
    assert_eq!(rates, [instance.real("velocity"), instance.real("acceleration")]);
    for order in [0, 2, -1] {
        assert_eq!(instance.output_rates(&[vr("position")], &[order], &mut [0.0]), ERROR);
    }
}
