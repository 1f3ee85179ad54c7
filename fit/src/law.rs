//! Parameters of friction laws.

use pneumatic_servo::model::Model;
use pneumatic_servo::variables::{Kind, Variable};

use crate::parameter::Values;

/// SI units of the parameters of a law that a fit usually estimates.
const UNITS: [&str; 6] = ["N", "N/m", "N.s/m", "m/s", "1/m", "m"];
/// Ends of the names of parameters with such a unit that it leaves as they are.
const FIXED: [&str; 2] = ["stribeck.FsInf", "revisedLuGre.v0"];
/// Points of each side of the law `Table`.
const POINTS: f64 = 11.0;

/// SI units of stiffnesses and lengths before sliding.
const PRESLIDING: [&str; 3] = ["N/m", "1/m", "m"];
/// Ends of the names of further parameters of presliding and of bristles, which friction of a steady motion is free of.
const TRANSIENT: [&str; 5] = ["lugre.vd", "revisedLuGre.vd", ".sigma1", ".n", "leuven.f1"];

/// Whether friction of a steady motion depends on a parameter of a law that a fit usually estimates.
pub fn acts_on_steady_motion(model: &Model, name: &str) -> bool {
    let is_presliding = |variable: &Variable| match variable.kind {
        Kind::Real(unit) => PRESLIDING.contains(&unit.name),
        _ => false,
    };
    let is_of_bristle = model.table().find(name).is_some_and(|entry| is_presliding(entry.variable));
    !is_of_bristle && !TRANSIENT.iter().any(|end| name.ends_with(end))
}

/// Prefix of the parameters of a law, with its dot; empty for a law without parameters.
pub fn group(model: &Model, law: i32) -> String {
    let table = model.table();
    let of_law = |variable: &&Variable| {
        variable.counts_for.is_some_and(|case| {
            case.item == law && table.case(case).is_some_and(|(choice, _)| choice.name == "friction.law")
        })
    };
    let first = table.parameters().find(of_law).and_then(|variable| variable.name.rsplit_once('.'));
    first.map_or(String::new(), |(group, _)| format!("{group}."))
}

/// Parameters of the viscous friction of a law, which the load factor does not multiply.
pub fn viscous(model: &Model, law: i32) -> Vec<String> {
    let group = group(model, law);
    let names = ["sigma2", "c1", "c2"].map(|kind| format!("{group}{kind}"));
    names.into_iter().filter(|name| model.table().find(name).is_some()).collect()
}

/// Parameters of a law that a fit usually estimates: forces, stiffnesses, dampings, velocities and lengths.
///
/// Of the elements those that there are; of `Table` the forces; of GMS the shares too, which make its levels; of Dahl and Leuven
/// the exponent that says how sharply presliding ends. The rate of GMS, the speed below which a film of lubricant is at rest,
/// and forces and coefficients that are 0 by default, without effect, stay as they are.
pub fn usual(model: &Model, law: i32, known: &Values) -> Vec<String> {
    let (table, group) = (model.table(), group(model, law));
    if group.is_empty() {
        return vec![];
    }
    if let Some((_, laws)) = table.friction_law()
        && laws.items.iter().any(|(id, name, _)| *id == law && *name == "Table")
    {
        // The speeds are where the forces are asked for, and viscous friction is part of these.
        let points = |side: &str| known.get(&format!("{group}{side}.points")).copied().unwrap_or(POINTS) as usize;
        let side = |side: &'static str| (1..=points(side)).map(move |place| format!("{side}.force[{place}]"));
        return ["outwards", "inwards"].into_iter().flat_map(side).map(|name| format!("{group}{name}")).collect();
    }
    let elements = format!("{group}N");
    let number = known.get(&elements).copied().or_else(|| table.find(&elements)?.variable.start).unwrap_or(0.0);
    let is_usual = |variable: &&Variable| {
        let Kind::Real(unit) = variable.kind else { return false };
        let Some(name) = variable.name.strip_prefix(&group) else { return false };
        let element = name.split_once('[').map(|(_, place)| place.trim_end_matches(']').parse().unwrap_or(f64::NAN));
        let has_no_unit = name.starts_with("alpha[") || name == "n";
        let is_off = variable.start == Some(0.0) && (element.is_some() || unit.name == "N");
        (UNITS.contains(&unit.name) || has_no_unit)
            && !FIXED.iter().any(|fixed| variable.name.ends_with(fixed))
            && element.is_none_or(|place| place <= number)
            && !is_off
    };
    let names: Vec<String> = table.parameters().filter(is_usual).map(|variable| variable.name.to_string()).collect();
    // The shares multiply the level, so that one of both stays as it is.
    let (share, level) = (format!("{group}alpha[1]"), format!("{group}Fc"));
    let has_shares = names.contains(&share);
    names.into_iter().filter(|name| !(has_shares && *name == level)).collect()
}
