//! The bristle law: bonds that break and form at random.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::list::List;
use crate::friction::parts::parameters::{length, stiffness, viscous};
use crate::numbers::random;
use crate::numbers::{Scalar, sign};
use crate::parameters;
use crate::variables::{Tunable, Variable, units};

/// The largest number of bristles.
const MAX_BRISTLES: usize = 100;

parameters! {
    /// Bristle friction: `N` bonds that break when stretched by `d = lambda*deltaS` and form anew at a random place.
    ///
    /// ```text
    /// F   = sum sigma0*(x - b_i) + sigma2*v                             [N]
    /// b_i = x(0) at first, and b_i + sgn(x - b_i)*d*U when |x - b_i| = d   [m], U uniform in (0, 1]
    /// ```
    ///
    /// Mean sliding force `2/3*N*sigma0*d`; the first break-away takes `N*sigma0*d`, since all bonds are then stretched
    /// alike. Each bristle draws from a generator of its own, so that at constant load where bonds break and form depends on
    /// the path alone, and the same `seed` gives the same sequence.
    ///
    /// # Validity
    /// None of the parameters is a force: the load level `lambda` scales the strength of the bonds, not their stiffness; it
    /// counts as 1e-6 at least, which leaves micronewtons. In sliding a bond breaks every `d/(2*N)`; where that is more than
    /// four times in `window` seconds, the bonds break and form as before but the force is the mean over the path covered in
    /// that time, at the load level of its beginning. With `window = 0` each break is located, at about two million breaks
    /// per metre with the defaults.
    ///
    /// # Source
    /// Haessig, Friedland (1991), ASME J. Dynamic Systems, Measurement, and Control 113(3):354-362.
    Bristle {
        viscous: Tunable = viscous(30.0);
        count: usize = Variable::count(5, "N", 20).range(1.0, MAX_BRISTLES as f64).text("Number of bristles");
        stiffness: Tunable = stiffness(6, "sigma0", 6.2e4).text("Stiffness of a bristle");
        strength: Tunable = length(7, "deltaS", 1e-5).text("Deflection at which a bond breaks at load level 1");
        seed: u64 = Variable::count(8, "seed", 1).range(0.0, f64::from(i32::MAX)).text("Seed of the random numbers");
        window: Tunable = Variable::parameter(9, "window", units::SECOND, 1e-4)
            .range(0.0, 1e-2)
            .shown_in("ms")
            .text("Time over which the force is averaged where bonds break faster; 0 locates every break");
    }
}

/// A bond and the generator of the places where it forms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Bond {
    /// Position in m where the bristle is without load.
    anchor: f64,
    generator: u64,
}

/// A path on which the force is averaged; the bonds of the memory are those at its start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Window {
    start: f64,
    end: f64,
    /// Speed in m/s below which single bonds matter again.
    least_speed: f64,
    /// Force in N.
    mean: f64,
}

/// All bonds, and the window in fast sliding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    bonds: List<Bond, MAX_BRISTLES>,
    window: Option<Window>,
}

impl FrictionLaw for Bristle {
    type Memory = Memory;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::Distance]
    }

    fn is_gentle(&self) -> bool {
        true
    }

    fn start(&self, contact: &Contact<f64>) -> Memory {
        let mut seeds = self.seed;
        let bonds = (0..self.count).map(|_| Bond { anchor: contact.position, generator: random::next(&mut seeds) });
        Memory { bonds: List::new(bonds), window: None }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory, _rates: &mut [S]) -> S {
        let dry = match memory.window {
            Some(window) => S::constant(window.mean),
            None => {
                let deflections = memory.bonds.iter().map(|bond| contact.position - bond.anchor);
                deflections.fold(S::zero(), |sum, deflection| sum + deflection) * self.stiffness
            }
        };
        dry + contact.velocity * self.viscous
    }

    fn indicators(&self, contact: &Contact<f64>, _z: &[f64], memory: &Memory, out: &mut Indicators) {
        let Some(Window { start, end, least_speed, .. }) = memory.window else {
            let deflections = memory.bonds.iter().map(|bond| (contact.position - bond.anchor).abs());
            out[Event::Distance] = limit(self.strength(contact)) - deflections.fold(0.0, f64::max);
            return;
        };
        let direction = sign(end - start);
        out[Event::Distance] = direction * (end - contact.position);
        out[Event::Stop] = direction * contact.velocity - least_speed;
    }

    fn switch(&self, _event: Event, contact: &Contact<f64>, _v: &mut f64, _z: &mut [f64], memory: &mut Memory) {
        let (x, strength) = (contact.position, self.strength(contact));
        if let Some(window) = memory.window {
            for bond in memory.bonds.iter_mut() {
                bond.travel(window.start, x, strength);
            }
        }
        for bond in memory.bonds.iter_mut() {
            bond.renew(x, strength);
        }
        memory.window = self.window_ahead(contact, &memory.bonds);
    }
}

/// Deflection at which a bond of a strength in m counts as broken: the strength but for rounding.
fn limit(strength: f64) -> f64 {
    strength * (1.0 - 1e-12)
}

impl Bond {
    /// Breaks if it is stretched to its limit, until it holds.
    fn renew(&mut self, x: f64, strength: f64) {
        let stretch = x - self.anchor;
        if stretch.abs() > 2.0 * strength {
            self.anchor = x - strength.copysign(stretch);
        }
        while (x - self.anchor).abs() >= limit(strength) {
            self.anchor += (strength * random::uniform(&mut self.generator)).copysign(x - self.anchor);
        }
    }

    /// Moves the bristle along a path; returns its mean deflection on the way.
    fn travel(&mut self, start: f64, end: f64, strength: f64) -> f64 {
        /// Bonds forget the past within a few deflections; of a longer path the rest is followed.
        const LONGEST: f64 = 100.0;
        let direction = sign(end - start);
        let path = (end - start).abs().min(LONGEST * strength);
        if path == 0.0 {
            return end - self.anchor;
        }
        let mut deflection = direction * (start - self.anchor);
        let (mut left, mut area) = (path, 0.0);
        while deflection + left >= limit(strength) {
            // A bond that was stronger when it formed may be stretched beyond the present strength.
            let stretch = (strength - deflection).max(0.0);
            area += stretch * (deflection + 0.5 * stretch);
            left -= stretch;
            deflection = strength * (1.0 - random::uniform(&mut self.generator));
        }
        area += left * (deflection + 0.5 * left);
        self.anchor = end - direction * (deflection + left);
        direction * area / path
    }
}

impl Bristle {
    /// Deflection in m at which bonds break under the present load.
    fn strength(&self, contact: &Contact<f64>) -> f64 {
        /// Bonds of no strength at all would break without end.
        const LEAST_LEVEL: f64 = 1e-6;
        contact.level.max(LEAST_LEVEL) * self.strength.value
    }

    /// The window that begins here, if the bonds break fast.
    fn window_ahead(&self, contact: &Contact<f64>, bonds: &[Bond]) -> Option<Window> {
        const FEWEST_BREAKS: f64 = 4.0;
        let (path, strength) = (contact.velocity * self.window.value, self.strength(contact));
        if path.abs() * 2.0 * bonds.len() as f64 <= FEWEST_BREAKS * strength {
            return None;
        }
        let (start, end) = (contact.position, contact.position + path);
        let sum: f64 = bonds.iter().copied().map(|mut bond| bond.travel(start, end, strength)).sum();
        Some(Window { start, end, least_speed: 0.5 * contact.velocity.abs(), mean: sum * self.stiffness.value })
    }
}

#[cfg(test)]
mod tests {
    use super::Bond;

    /// A load that drops leaves bonds that are stretched to many times what they now hold. They form anew on the side from which
    /// they are pulled, less than one strength away, so that friction does not push.
    #[test]
    fn bond_that_breaks_far_beyond_its_strength_is_still_pulled_the_same_way() {
        const STRENGTH: f64 = 1e-5;
        for generator in 0..100 {
            for stretch in [-1e3, -2.5, 2.5, 1e3] {
                let mut bond = Bond { anchor: 0.0, generator };
                let x = stretch * STRENGTH;
                bond.renew(x, STRENGTH);
                let pull = (x - bond.anchor) * x.signum();
                assert!((0.0..STRENGTH).contains(&pull), "{stretch} times its strength leaves {pull} m");
            }
        }
    }
}
