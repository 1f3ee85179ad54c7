//! A hose between a valve and a chamber, as a chain of volumes and of columns of air that have inertia and friction.

use std::f64::consts::PI;

use super::gas::Gas;
use crate::numbers::{Number, Scalar, Tangent};
use crate::system::LongestSteps;

/// Columns of air in a hose.
pub const COLUMNS: usize = 3;

/// A hose at a constant temperature.
///
/// ```text
/// dp_i/dt  = R*T/V_i*(w_i-1 - w_i),  w_i = sonic(mdot_i + theta*dmdot_i/dt)           volumes 1 to 4
/// dmdot_i/dt = A/l*(p_i - p_i+1) - phi*mu*mdot_i/(2*rho*d^2) - (mdot_i - sonic(mdot_i))/theta   columns 1 to 3
/// phi = max(64, 0.3164*Re^(3/4)),  Re = |mdot_i|*d/(A*mu),  rho = (p_i + p_i+1)/(2*R*T)
/// theta = d/c,  c = sqrt(R*T),  sonic(mdot_i) = clamp(mdot_i, -A*p_i+1/c, A*p_i/c)
/// ```
///
/// Each column has a third of the length, `l = L/3`; the volumes at both ends have a sixth of the hose's, the inner ones a
/// third. `phi` is the friction factor times the Reynolds number: laminar below `Re` = 1187, where it meets
/// the law of Blasius. `w_i` is what passes through column `i`. Its difference from `mdot_i` is what passes by the inertia
/// of the column in `theta`, the time that sound takes across the hose: waves as short as the hose is wide do not run along
/// it, they spread into fittings and chamber and do not come back. It vanishes in steady flow, and damps a wave of angular
/// frequency `w` with the ratio `w*theta/2`: the quarter wave with `pi*d/(4*L)`, 0.3 % for 1 m of 4 mm, and everything in a
/// hose half as long as wide beyond the critical ratio. So a hose that is ever shorter becomes its volume, and no waves are
/// left that a solver would have to follow.
///
/// `sonic` chokes a column: at a constant temperature no gas leaves a volume of the pressure `p` through the hose faster
/// than sound, with more than `A*p/c`. What the column has beyond that it loses within `theta`, as in a shock. So the gas
/// that still flows when a valve closes at once draws the volume behind it down to a part of its pressure, never to 0.
///
/// # Validity
/// A hose much longer than wide, in exchange of heat with its surroundings: however short, it brings the air to their
/// temperature, which changes the flow out of a chamber whose gas is warmer or colder. Waves run at `c`, in air 290 m/s. The
/// lowest frequency of a hose open at one end, `c/(4*L)`, comes out 1.1 % too low, higher ones worse. At constant flow
/// below the speed of sound `p_1^2 - p_4^2 = R*T*phi*mu*L*mdot/(A*d^2)`, exactly as in isothermal flow without the change
/// of velocity along the hose. Losses at the ends are not part of it. Waves are accurate for small changes of pressure. Up to
/// the speed of sound the model chokes at once, air gradually.
///
/// # Source
/// The law of Blasius (1913) for smooth pipes, in the form `0.3164*Re^(-1/4)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hose {
    area: Tangent,
    volume: Tangent,
    /// `A/l` in m.
    per_inertia: Tangent,
    /// `R*T` in J/kg.
    gas: Tangent,
    /// `theta` in s.
    crossing: Tangent,
    /// `A/c` in m s.
    sonic: Tangent,
    /// Reynolds number per mass flow, `d/(A*mu)` in s/kg.
    reynolds: Tangent,
    /// `mu*R*T/d^2` in Pa/s.
    drag: Tangent,
}

impl Hose {
    /// The shortest hose in m: one that is shorter is none.
    pub const SHORTEST: f64 = 1e-4;

    /// A hose of a length and an inner diameter in m, filled with a gas at a temperature in K.
    pub fn new(length: Tangent, diameter: Tangent, filling: &Gas, temperature: Tangent) -> Self {
        let area = PI * diameter * diameter / 4.0;
        let gas = filling.constant * temperature;
        let crossing = diameter / gas.sqrt();
        Self {
            area,
            volume: area * length,
            per_inertia: area * COLUMNS as f64 / length,
            gas,
            crossing,
            sonic: area * crossing / diameter,
            reynolds: diameter / (area * filling.viscosity),
            drag: filling.viscosity * gas / (diameter * diameter),
        }
    }

    /// The longest explicit steps: those that damp the fastest wave, in which neighbours swing against each other, of a rate
    /// `6*c/L`.
    pub(crate) fn longest_steps(&self) -> LongestSteps {
        let rate = 2.0 * COLUMNS as f64 * self.gas.value.sqrt() / self.length();
        LongestSteps::of_swing(rate, rate * rate * self.crossing.value)
    }

    /// The rate in 1/s at which a flow of a slope in kg/(s Pa) fills the volume at an end.
    pub(crate) fn rate_at_end(&self, slope: f64) -> f64 {
        slope * self.gas.value / self.end_volume().value
    }

    /// In m.
    fn length(&self) -> f64 {
        self.volume.value / self.area.value
    }

    /// Volume in m3 at either end.
    pub fn end_volume(&self) -> Tangent {
        self.volume / 6.0
    }

    /// Mass in kg of the gas in the volumes at pressures in Pa; the last one counts for a hose that ends in itself.
    pub fn mass(&self, pressures: [f64; 4], owns_its_end: bool) -> f64 {
        let shares = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, if owns_its_end { 1.0 / 6.0 } else { 0.0 }];
        let sum: f64 = pressures.iter().zip(shares).map(|(pressure, share)| pressure * share).sum();
        sum * self.volume.value / self.gas.value
    }

    /// Mass flows in kg/s through the columns, for the pressures at their ends, the flows of their inertia and the rates of
    /// these in kg/s2.
    pub fn through<S: Scalar>(&self, pressures: [S; 4], columns: [S; COLUMNS], rates: [S; COLUMNS]) -> [S; COLUMNS] {
        std::array::from_fn(|i| self.sonic(columns[i] + rates[i] * self.crossing, [pressures[i], pressures[i + 1]]))
    }

    /// Mass flow in kg/s between two pressures, limited to the speed of sound.
    fn sonic<S: Scalar>(&self, flow: S, [from, to]: [S; 2]) -> S {
        flow.clamp(-to * self.sonic, from * self.sonic)
    }

    /// Rates in Pa/s of the four pressures for mass flows in kg/s into the hose, through the columns, and out of it.
    pub fn pressure_rates<S: Scalar>(&self, inflow: S, through: [S; COLUMNS], outflow: S) -> [S; 4] {
        let [first, second, third] = through;
        let (end, inner) = (6.0 * self.gas / self.volume, 3.0 * self.gas / self.volume);
        [(inflow - first) * end, (first - second) * inner, (second - third) * inner, (third - outflow) * end]
    }

    /// Rates in kg/s2 of the mass flows in the columns for the pressures at their ends.
    pub fn flow_rates<S: Scalar>(&self, pressures: [S; 4], columns: [S; COLUMNS]) -> [S; COLUMNS] {
        std::array::from_fn(|i| {
            let (p, next) = (pressures[i], pressures[i + 1]);
            let excess = columns[i] - self.sonic(columns[i], [p, next]);
            (p - next) * self.per_inertia - self.drag(columns[i]) / (p + next) - excess / self.crossing
        })
    }

    /// Friction in a column times the sum of the pressures at its ends.
    fn drag<S: Scalar>(&self, flow: S) -> S {
        let reynolds = flow.abs() * self.reynolds;
        // Apart from the laminar part, whose power has no slope at 0.
        let factor = if reynolds.value() <= TRANSITION { S::constant(LAMINAR) } else { turbulent(reynolds) };
        factor * flow * self.drag
    }
}

/// Friction factor times Reynolds number of turbulent flow; roots take a quarter of the time of a power.
fn turbulent<S: Scalar>(reynolds: S) -> S {
    let root = reynolds.sqrt();
    root * root.sqrt() * BLASIUS
}

/// Friction factor times Reynolds number of laminar flow.
const LAMINAR: f64 = 64.0;
/// Of turbulent flow, divided by the power 3/4 of the Reynolds number.
const BLASIUS: f64 = 0.3164;
/// Reynolds number `(64/0.3164)^(4/3)` at which both are equal.
const TRANSITION: f64 = 1_187.384_381_946_929;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;

    const DIAMETER: f64 = 4e-3;
    const VISCOSITY: f64 = Gas::AIR.viscosity.value;

    fn of(length: f64, diameter: f64) -> Hose {
        Hose::new(Tangent::still(length), Tangent::still(diameter), &Gas::AIR, Tangent::still(293.15))
    }

    fn hose() -> Hose {
        of(2.0, DIAMETER)
    }

    fn drag(flow: f64) -> f64 {
        hose().drag(Real::of(flow)).value
    }

    fn flow_rates(pressures: [f64; 4], flows: [f64; COLUMNS]) -> [f64; COLUMNS] {
        hose().flow_rates(Real::all(&pressures), Real::all(&flows)).map(Real::value)
    }

    fn through(pressures: [f64; 4], flows: [f64; COLUMNS], rates: [f64; COLUMNS]) -> [f64; COLUMNS] {
        hose().through(Real::all(&pressures), Real::all(&flows), Real::all(&rates)).map(Real::value)
    }

    fn pressure_rates(into: f64, flows: [f64; COLUMNS], out: f64) -> [f64; 4] {
        hose().pressure_rates(Real::of(into), Real::all(&flows), Real::of(out)).map(Real::value)
    }

    #[test]
    fn friction_is_continuous_where_flow_becomes_turbulent() {
        assert!((LAMINAR - BLASIUS * TRANSITION.powf(0.75)).abs() < 1e-11);
        let flow = (TRANSITION * hose().area * VISCOSITY / DIAMETER).value;
        let [below, above] = [1.0 - 1e-12, 1.0 + 1e-12].map(|factor| drag(flow * factor));
        assert!((above / below - 1.0).abs() < 1e-11, "{below} {above}");
        assert_eq!(drag(-flow), -drag(flow));
    }

    /// Hagen and Poiseuille: `32*mu*u*l/d^2` with the velocity `u = mdot/(rho*A)`.
    #[test]
    fn slow_flow_loses_the_pressure_of_hagen_and_poiseuille() {
        let (pressure, flow) = (5e5, 1e-6);
        let Hose { area, per_inertia, gas, .. } = hose();
        let velocity = flow / (pressure / gas.value * area.value);
        let loss = 32.0 * VISCOSITY * velocity * (area / per_inertia).value / DIAMETER.powi(2);
        let [rate, ..] = flow_rates([pressure; 4], [flow; 3]);
        assert!((rate / (-loss * per_inertia.value) - 1.0).abs() < 1e-12, "{rate}");
    }

    /// With the same flow at both ends a hose passes it on, independent of the history of its columns.
    #[test]
    fn steady_flow_passes_through() {
        assert_eq!(through([1e5; 4], [5e-4; 3], [0.0; 3]), [5e-4; 3]);
        assert_eq!(pressure_rates(5e-4, [5e-4; 3], 5e-4), [0.0; 4]);
    }

    /// The flow of a column in either direction is limited to `A*p/c` of its source; an excess decays within `theta`.
    #[test]
    fn no_gas_leaves_a_volume_faster_than_sound() {
        let pressures = [2e4, 3e4, 1e3, 4e5];
        let sonic = |pressure: f64| hose().area.value * pressure / hose().gas.value.sqrt();
        let passed = through(pressures, [1.0, 1.0, -1.0], [0.0; 3]);
        for (flow, expected) in passed.into_iter().zip([sonic(2e4), sonic(3e4), -sonic(4e5)]) {
            assert!((flow / expected - 1.0).abs() < 1e-12, "{flow} kg/s, not {expected} kg/s");
        }
        let flow = 2.0 * sonic(3e4);
        let [rate, ..] = flow_rates([3e4; 4], [flow; 3]);
        let expected = -drag(flow) / 6e4 - sonic(3e4) / hose().crossing.value;
        assert!((rate / expected - 1.0).abs() < 1e-12, "{rate} kg/s2, not {expected} kg/s2");
        assert_eq!(pressure_rates(0.0, through([0.0, 1e5, 1e5, 1e5], [1.0; 3], [0.0; 3]), 0.0)[0], 0.0);
    }

    /// In the fastest wave neighbours move against each other: from such pressures and flows at rest the rates of the flows
    /// change at `(6*c/L)^2`.
    #[test]
    fn explicit_steps_follow_the_fastest_wave() {
        let hose = of(1.0, 4e-3);
        let pressures = Real::all(&[1e5 + 1.0, 1e5 - 1.0, 1e5 + 1.0, 1e5 - 1.0]);
        let columns = hose.flow_rates(pressures, [Real::of(0.0); 3]);
        let volumes = hose.pressure_rates(Real::of(0.0), columns, Real::of(0.0)).map(Real::value);
        let square = -volumes[0];
        assert!(
            volumes.iter().zip([1.0, -1.0, 1.0, -1.0]).all(|(rate, sign)| (rate + sign * square).abs() < 1e-8 * square)
        );
        let (swing, longest) = (square.sqrt(), hose.longest_steps());
        assert!((longest.classical * swing / 2.6 - 1.0).abs() < 1e-12 && (1.4e-3..1.6e-3).contains(&longest.classical));
        let wide = of(1e-3, 0.1).longest_steps();
        assert!(wide.classical < 1e-2 * 2.6 / 1740e3, "it creeps: {wide:?}");
        assert!((hose.rate_at_end(1e-7) * hose.volume.value / 6.0 - 1e-7 * hose.gas.value).abs() < 1e-12);
    }

    /// The difference of the flows is stored in the volumes.
    #[test]
    fn mass_is_conserved() {
        let rates = pressure_rates(5e-4, [3e-4, -1e-4, 2e-4], 1e-4);
        assert!((hose().mass(rates, true) - (5e-4 - 1e-4)).abs() < 1e-15);
        let rates = pressure_rates(5e-4, [3e-4, -1e-4, 2e-4], 2e-4);
        assert!((hose().mass(rates, false) - (5e-4 - 2e-4)).abs() < 1e-15);
    }
}
