//! Ideal gases, and dry air among them.

use crate::numbers::{Number, Pair, Scalar, Tangent};
use crate::variables::Tunable;

/// Density in kg/m3 of air at the reference conditions of ISO 6358 and ISO 8778.
pub const REFERENCE_DENSITY: f64 = 1.185;

/// Temperature in K of the reference conditions.
pub const REFERENCE_TEMPERATURE: f64 = 293.15;

/// Pressure in Pa below which solvers outside are led back: no run of a cylinder comes near it, nor does air stay a gas.
pub const THINNEST: f64 = 1.0;

/// Temperature in K of the same kind.
pub const COLDEST: f64 = 1.0;

/// An ideal gas of constant specific heats.
///
/// Sonic conductances are measured with air, as data sheets state them, and stand for an area. Choked isentropic flow through
/// a throat of an effective area `A_e` gives the mass flow of another gas:
///
/// ```text
/// mdot = A_e*p1*Psi(gamma)/sqrt(R*T1),   Psi(gamma)^2 = gamma*(2/(gamma + 1))^((gamma + 1)/(gamma - 1))
///      = C*p1*rho_c*sqrt(T0/T1),         rho_c = rho0*Psi(gamma)/Psi(gamma_air)*sqrt(R_air/R)
/// ```
///
/// A laminar gap lets `1/(mu*R)` pass in proportion. Critical pressure ratios are properties of an orifice and its gas; an
/// ideal nozzle has `(2/(gamma + 1))^(gamma/(gamma - 1))`, 0.528 for air and 0.487 for helium.
///
/// # Source
/// Choked flow of an ideal gas: A. H. Shapiro, The Dynamics and Thermodynamics of Compressible Fluid Flow, 1953.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas {
    /// Specific gas constant in J/(kg K).
    pub constant: Tangent,
    /// Ratio of the specific heats.
    pub heat_ratio: Tangent,
    /// Dynamic viscosity in Pa s.
    pub viscosity: Tangent,
    /// `rho_c` in kg/m3, which turns sonic conductance times pressure into the choked mass flow at the reference temperature.
    pub choked_density: Tangent,
    /// `rho_c^2*T0` in kg2 K/m6.
    choked: Tangent,
}

impl Gas {
    /// Dry air, of the viscosity at 20 degrees Celsius: Bird, Stewart, Lightfoot, Transport Phenomena, table 1.1-2.
    pub const AIR: Self = Self {
        constant: Tangent::still(287.05),
        heat_ratio: Tangent::still(1.4),
        viscosity: Tangent::still(1.813e-5),
        choked_density: Tangent::still(REFERENCE_DENSITY),
        choked: Tangent::still(REFERENCE_DENSITY * REFERENCE_DENSITY * REFERENCE_TEMPERATURE),
    };

    /// A gas of a specific gas constant in J/(kg K), a ratio of the specific heats above 1, and a dynamic viscosity in Pa s.
    pub fn new(constant: Tangent, heat_ratio: Tangent, viscosity: Tangent) -> Self {
        /// `Psi^2`.
        fn flow_factor(heat_ratio: Tangent) -> Tangent {
            heat_ratio * (2.0 / (heat_ratio + 1.0)).pow((heat_ratio + 1.0) / (heat_ratio - 1.0))
        }
        let relative = flow_factor(heat_ratio) / flow_factor(Self::AIR.heat_ratio) * (Self::AIR.constant / constant);
        let choked_density = REFERENCE_DENSITY * relative.sqrt();
        let choked = choked_density * choked_density * REFERENCE_TEMPERATURE;
        Self { constant, heat_ratio, viscosity, choked_density, choked }
    }

    /// Density in kg/m3 at the reference conditions of ISO 8778.
    pub fn reference_density(&self) -> Tangent {
        REFERENCE_DENSITY * (Self::AIR.constant / self.constant)
    }

    /// Laminar mass flow through a gap, relative to air at the same pressures and temperature.
    pub fn laminar_flow(&self) -> Tangent {
        (Self::AIR.viscosity * Self::AIR.constant) / (self.viscosity * self.constant)
    }

    /// Its state at an absolute pressure in Pa and a temperature in K.
    #[inline(always)]
    pub fn at<N: Number>(&self, pressure: N, temperature: N) -> GasState<N> {
        // rho_c*sqrt(T0/T)
        let sonic_density = (N::tuned(self.choked) / temperature).sqrt();
        GasState { pressure, temperature, sonic_density }
    }
}

/// Pressure and temperature of a gas.
#[derive(Clone, Copy, Debug)]
pub struct GasState<N> {
    /// Absolute pressure in Pa.
    pub pressure: N,
    /// Temperature in K.
    pub temperature: N,
    /// Density in kg/m3 that turns sonic conductance times pressure into the choked mass flow of this gas.
    pub sonic_density: N,
}

impl<N: Number> GasState<N> {
    /// The same in other numbers.
    #[inline(always)]
    pub fn map<M>(self, rule: impl Fn(N) -> M) -> GasState<M> {
        let Self { pressure, temperature, sonic_density } = self;
        GasState { pressure: rule(pressure), temperature: rule(temperature), sonic_density: rule(sonic_density) }
    }
}

impl<S: Scalar> GasState<Pair<S>> {
    /// One of two gases side by side.
    pub fn side(self, side: usize) -> GasState<S> {
        self.map(|Pair(both)| both[side])
    }
}

/// A reservoir of constant temperature and given pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reservoir {
    temperature: Tunable,
    sonic_density: Tunable,
}

impl Reservoir {
    /// A reservoir of a gas at a temperature in K.
    pub fn new(gas: &Gas, temperature: Tunable) -> Self {
        let GasState { sonic_density, .. } = gas.at(Tunable::zero(), temperature);
        Self { temperature, sonic_density }
    }

    /// Its gas at an absolute pressure in Pa.
    pub fn at<N: Number>(&self, pressure: N) -> GasState<N> {
        let [temperature, sonic_density] = [self.temperature, self.sonic_density].map(N::tuned);
        GasState { pressure, temperature, sonic_density }
    }
}
