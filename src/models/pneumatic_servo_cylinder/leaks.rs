//! Air that leaves the chambers where it should not: past the piston seal, and to the surroundings.

use super::options::Options;
use crate::numbers::{Number, Pair, Real, Scalar, Tangent, Tangents};
use crate::pneumatics::gas::GasState;
use crate::pneumatics::orifice::{Flow, Inflow, Orifice, smooth_region};

/// The leaks of a cylinder: a laminar one between the chambers, and an orifice of each chamber to the surroundings, through
/// which a chamber below ambient pressure draws air in.
///
/// ```text
/// mdot_AB  = k*(p_A^2 - p_B^2)
/// mdot_out = orifice(p -> p_atm)   with C and b of the leak
/// ```
#[derive(Clone, Debug)]
pub struct Leaks {
    /// Coefficient in kg/(s Pa2) of the leak past the piston.
    piston: Tangent,
    /// Sonic conductances in m3/(s Pa) of the leaks of the chambers A and B.
    conductances: Tangents,
    orifices: Orifice<Tangents>,
    /// Whether any of these is there.
    pass_outside: bool,
}

impl Leaks {
    /// The leaks, unless there are none.
    pub fn new(piston: Tangent, options: &Options) -> Option<Self> {
        let conductances = [options.leak_a, options.leak_b];
        // One that is tight, and by which a run is differentiated, has a slope.
        let pass_outside = conductances.into_iter().any(Tangent::is_used);
        (piston.is_used() || pass_outside).then(|| Self {
            piston,
            conductances: conductances.into(),
            orifices: Orifice::pair([options.leak_ratio; 2]),
            pass_outside,
        })
    }

    /// Whether the chambers exchange air.
    pub fn pass_piston(&self) -> bool {
        self.piston.is_used()
    }

    /// Leakage into the chambers; usually negative.
    pub fn inflow<S: Scalar>(&self, gas: GasState<Pair<S>>, surroundings: GasState<Pair<S>>) -> Inflow<Pair<S>> {
        let from_outside = || {
            let conductances = Pair::constant(1.0) * self.conductances;
            Inflow::from(self.orifices.flow(conductances, surroundings, gas))
        };
        let past_piston = || Inflow::from(self.past_piston(gas));
        match (self.pass_piston(), self.pass_outside) {
            (true, false) => past_piston(),
            (true, true) => past_piston() + from_outside(),
            (false, _) => from_outside(),
        }
    }

    /// Laminar leakage past the piston seal into the chambers.
    fn past_piston<S: Scalar>(&self, gas: GasState<Pair<S>>) -> Flow<Pair<S>> {
        let (Pair([p_a, p_b]), Pair([t_a, t_b])) = (gas.pressure, gas.temperature);
        let to_b = (p_a * p_a - p_b * p_b) * self.piston;
        // By the pressures, since a leak that is absent has a slope, too.
        let temperature = S::if_at_least(p_a, p_b, t_a, t_b);
        Flow { mass: Pair([-to_b, to_b]), temperature: Pair([temperature; 2]) }
    }

    /// The numbers, from 0 to 3, of the smooth regions of the leaks to surroundings of a pressure in Pa.
    pub fn pieces(&self, pressures: Pair<Real>, ambient: f64) -> Pair<Real> {
        if self.pass_outside { smooth_region(Pair::constant(ambient), pressures) } else { Pair::zero() }
    }
}
