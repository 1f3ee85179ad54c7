//! Friction by measured points.

use crate::friction::parts::parameters::viscous;
use crate::friction::parts::stick_slip::SetValued;
use crate::numbers::{MonotoneCurve, Number, Scalar};
use crate::variables::{ParameterError, ParameterSet, Tunable, Variable, counted_by, units};

/// Points that each direction may have.
const POINTS: usize = 11;

/// Points of the Stribeck curve with the defaults of the law [`Stribeck`](super::stribeck_law::Stribeck). No two forces beside each
/// other are equal: a curve has no derivative by such a force, since it turns at one of the points or at the other.
const SPEEDS: [f64; POINTS] = [0.0, 0.002, 0.004, 0.006, 0.008, 0.01, 0.0125, 0.015, 0.0175, 0.02, 0.025];
const FORCES: [f64; POINTS] = [11.0, 10.894, 10.601, 10.184, 9.724, 9.293, 8.866, 8.585, 8.426, 8.349, 8.305];

mod declared {
    use super::*;
    use crate::parameters;

    parameters! {
        /// The points of both directions as parameters.
        Points {
            viscous: Tunable = viscous(30.0);
            outwards_points: usize = points(10, "outwards", "+x");
            outwards_speeds: [Tunable; POINTS] = speeds(11, "outwards", "+x");
            outwards_forces: [Tunable; POINTS] = forces(22, "outwards", "+x");
            inwards_points: usize = points(40, "inwards", "-x");
            inwards_speeds: [Tunable; POINTS] = speeds(41, "inwards", "-x");
            inwards_forces: [Tunable; POINTS] = forces(52, "inwards", "-x");
        }
    }
}

fn points(reference: u32, side: &str, way: &str) -> Variable {
    Variable::count(reference, &format!("{side}.points"), POINTS as i32)
        .range(2.0, POINTS as f64)
        .text(&format!("Number of points of the table of friction over speed towards {way}"))
}

fn speeds(reference: u32, side: &str, way: &str) -> [Variable; POINTS] {
    let speeds = Variable::parameter(reference, &format!("{side}.speed"), units::METRE_PER_SECOND, 0.0)
        .range(0.0, 1e6)
        .plausible(1e-7, 1.5)
        .shown_in("mm/s")
        .text(&format!("Speed towards {way}, rising from point to point"))
        .array(SPEEDS);
    counted_by(&format!("{side}.points"), speeds)
}

fn forces(reference: u32, side: &str, way: &str) -> [Variable; POINTS] {
    let forces = Variable::parameter(reference, &format!("{side}.force"), units::NEWTON, 0.0)
        .range(0.0, 1e6)
        .text(&format!("Friction force at that speed towards {way}; the first is the force that breaks away"))
        .array(FORCES);
    counted_by(&format!("{side}.points"), forces)
}

/// Friction by measured points for each direction, set-valued at rest.
///
/// ```text
/// stuck:    v = 0, F = F_applied          while |F_applied| <= lambda*f(0) of the side that it pushes to
/// sliding:  F = lambda*f(|v|)*sgn(v) + sigma2*v   [N], f of the side of v
/// ```
///
/// `f` is a smooth curve through the points that turns at points alone. Below the first speed it is the force there; beyond the last
/// it goes on with the slope that it has there, if it rises. With `sigma2` = 0 the points are all of the friction.
///
/// # Errors
/// [`ParameterError`] for speeds that do not rise.
///
/// # Source
/// Interpolation: Fritsch, Butland (1984), SIAM J. Scientific and Statistical Computing 5(2):300-304.
#[derive(Clone, Debug)]
pub struct Table {
    viscous: Tunable,
    /// Towards +x and towards -x.
    sides: Box<[Side; 2]>,
}

/// Friction over speed in one direction.
#[derive(Clone, Debug)]
struct Side {
    curve: MonotoneCurve,
    break_away: Tunable,
    /// Speed in m/s of the last point, and slope in N.s/m beyond it.
    last: Tunable,
    beyond: Tunable,
    /// Largest magnitude in N.s/m of the slope between two points.
    steepest: f64,
}

/// Slope in N.s/m from which on a curve makes the equations stiff: a line through zero rather than the flank of a Stribeck curve.
const STEEP: f64 = 1e4;

impl ParameterSet for Table {
    const LEN: usize = declared::Points::LEN;

    fn table() -> Vec<Variable> {
        declared::Points::table()
    }

    fn read(values: &[Tunable]) -> Result<Self, ParameterError> {
        let p = declared::Points::read(values)?;
        let outwards = Side::through("outwards", p.outwards_points, &p.outwards_speeds, &p.outwards_forces)?;
        let inwards = Side::through("inwards", p.inwards_points, &p.inwards_speeds, &p.inwards_forces)?;
        Ok(Self { viscous: p.viscous, sides: Box::new([outwards, inwards]) })
    }
}

impl Side {
    fn through(name: &str, count: usize, speeds: &[Tunable], forces: &[Tunable]) -> Result<Self, ParameterError> {
        // A count beyond its range is refused by the table of parameters.
        let count = count.clamp(2, POINTS);
        let (speeds, forces) = (&speeds[..count], &forces[..count]);
        if let Some(place) = (1..count).find(|place| speeds[*place].value <= speeds[place - 1].value) {
            let reason = format!("it must exceed the one before, {}", speeds[place - 1].value);
            return Err(ParameterError::new(&format!("{name}.speed[{}]", place + 1), speeds[place].value, &reason));
        }
        let points: Vec<_> = speeds.iter().copied().zip(forces.iter().copied()).collect();
        let chord = |pair: &[(Tunable, Tunable)]| ((pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).value.abs();
        let curve = MonotoneCurve::through(&points);
        Ok(Self {
            break_away: forces[0],
            last: speeds[count - 1],
            beyond: curve.end_slope().max(Tunable::zero()),
            steepest: points.windows(2).map(chord).fold(0.0, f64::max),
            curve,
        })
    }

    /// Friction in N at a speed.
    fn at<S: Scalar>(&self, speed: S) -> S {
        let on_curve = self.curve.at(speed);
        if speed.value() > self.last.value { on_curve + (speed - self.last) * self.beyond } else { on_curve }
    }
}

impl Table {
    fn side(&self, direction: f64) -> &Side {
        &self.sides[usize::from(direction < 0.0)]
    }
}

impl SetValued for Table {
    fn is_non_stiff(&self) -> bool {
        self.sides.iter().all(|side| side.steepest < STEEP)
    }

    fn break_away<S: Scalar>(&self, direction: f64, level: S) -> S {
        level * self.side(direction).break_away
    }

    fn kinetic<S: Scalar>(&self, velocity: S, direction: f64, level: S) -> S {
        level * self.side(direction).at(velocity * direction) * direction + velocity * self.viscous
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::law::{Contact, Drive, FrictionLaw};
    use crate::friction::parts::stick_slip::StickSlip;
    use crate::numbers::Real;

    /// Two points outwards, of 9 N at rest and 5 N at 0.1 m/s; three inwards, that rise at last.
    fn law<L: ParameterSet>(viscous: f64) -> L {
        let mut values: Vec<Tunable> =
            L::table().iter().map(|it| Tunable::still(it.start.expect("a default"))).collect();
        let mut set = |name: &str, value: f64| {
            let place = L::table().iter().position(|it| it.name == name).expect("a parameter");
            values[place] = Tunable::still(value);
        };
        set("sigma2", viscous);
        for (side, points) in
            [("outwards", &[(0.0, 9.0), (0.1, 5.0)][..]), ("inwards", &[(0.01, 6.0), (0.1, 6.0), (0.2, 9.0)])]
        {
            set(&format!("{side}.points"), points.len() as f64);
            for (place, (speed, force)) in points.iter().enumerate() {
                set(&format!("{side}.speed[{}]", place + 1), *speed);
                set(&format!("{side}.force[{}]", place + 1), *force);
            }
        }
        L::read(&values).unwrap()
    }

    fn sliding(law: &Table, velocity: f64, level: f64) -> f64 {
        law.kinetic(Real::of(velocity), velocity.signum(), Real::of(level)).value
    }

    /// Two points make a line; beyond the last one a curve that falls is constant, and one that rises goes on.
    #[test]
    fn each_direction_has_its_points() {
        let law = law(0.0);
        for (velocity, expected) in [
            (0.0, 9.0),
            (0.025, 8.0),
            (0.1, 5.0),
            (3.0, 5.0),
            (-0.005, -6.0),
            (-0.05, -6.0),
            (-0.1, -6.0),
            (-0.2, -9.0),
        ] {
            let found = sliding(&law, velocity, 1.0);
            assert!((found - expected).abs() < 1e-12, "{found} N at {velocity} m/s, not {expected}");
        }
        let slope = law.sides[1].curve.end_slope().value;
        assert!(slope > 30.0 && (sliding(&law, -0.3, 1.0) + 9.0 + 0.1 * slope).abs() < 1e-12);
    }

    /// The load factor multiplies the points; viscous friction is added.
    #[test]
    fn points_scale_with_the_load_level() {
        assert!((sliding(&law(20.0), 0.025, 2.0) - (2.0 * 8.0 + 0.5)).abs() < 1e-12);
    }

    #[test]
    fn each_side_breaks_away_at_its_first_force() {
        let law: StickSlip<Table> = law(0.0);
        for (applied, holds) in [(8.9, true), (9.1, false), (-5.9, true), (-6.1, false)] {
            let (time, position, velocity, level, drive) = (0.0, 0.0, 0.0, 1.0, Drive::Force);
            let contact = Contact { time, position, velocity, applied, level, drive }.still::<Real>();
            assert_eq!(StickSlip::<Table>::is_sticking::<Real>(&law.start(&contact)), holds, "{applied} N");
        }
    }

    #[test]
    fn speeds_that_do_not_rise_are_refused_by_name_and_value() {
        let mut values: Vec<Tunable> =
            Table::table().iter().map(|it| Tunable::still(it.start.expect("a default"))).collect();
        let place = Table::table().iter().position(|it| it.name == "inwards.speed[3]").expect("a parameter");
        values[place] = Tunable::still(0.001);
        let error = Table::read(&values).unwrap_err();
        assert_eq!((error.variable.as_str(), error.value), ("inwards.speed[3]", 0.001));
    }
}
