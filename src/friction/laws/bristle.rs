//! The bristle law: bonds that break and form at random.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, FrictionLaw};
use crate::friction::parts::list::List;
use crate::friction::parts::parameters::{length, stiffness, viscous};
use crate::numbers::random;
use crate::numbers::{Scalar, Varying, sign};
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
    /// None of the parameters is a force: the load factor `lambda` scales the strength of the bonds, not their stiffness; it
    /// counts as 1e-6 at least, which leaves micronewtons. In sliding a bond breaks every `d/(2*N)`; where that is more than
    /// four times in `window` seconds, the bonds break and form as before but the force is the mean over the path covered in
    /// that time, at the load factor of its beginning. With `window = 0` each break is located, at about two million breaks
    /// per metre with the defaults.
    ///
    /// # Source
    /// Haessig, Friedland (1991), ASME J. Dynamic Systems, Measurement, and Control 113(3):354-362.
    Bristle {
        viscous: Tunable = viscous(30.0);
        count: usize = Variable::count(5, "N", 20).range(1.0, MAX_BRISTLES as f64).text("Number of bristles");
        stiffness: Tunable = stiffness(6, "sigma0", 6.2e4).text("Stiffness of a bristle");
        strength: Tunable = length(7, "deltaS", 1e-5).text("Deflection at which a bond breaks at load factor 1");
        seed: u64 = Variable::count(8, "seed", 1).range(0.0, f64::from(i32::MAX)).text("Seed of the random numbers");
        window: Tunable = Variable::parameter(9, "window", units::SECOND, 1e-4)
            .range(0.0, 1e-2)
            .shown_in("ms")
            .text("Time over which the force is averaged where bonds break faster; 0 locates every break");
    }
}

/// A bond and the generator of the places where it forms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Bond<S> {
    /// Position in m where the bristle is without load.
    anchor: S,
    generator: u64,
}

/// A path on which the force is averaged; the bonds of the memory are those at its start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Window<S> {
    start: S,
    end: S,
    /// Speed in m/s below which single bonds matter again.
    least_speed: S,
    /// Force in N.
    mean: S,
}

/// All bonds, and the window in fast sliding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct Memory<S: Varying> {
    bonds: List<Bond<S>, MAX_BRISTLES>,
    window: Option<Window<S>>,
}

impl FrictionLaw for Bristle {
    type Memory<S: Varying> = Memory<S>;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::Distance]
    }

    fn is_non_stiff(&self) -> bool {
        true
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        let mut seeds = self.seed;
        let bonds = (0..self.count).map(|_| Bond { anchor: contact.position, generator: random::next(&mut seeds) });
        Memory { bonds: List::new(bonds), window: None }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        let dry = match memory.window {
            Some(window) => S::held(window.mean),
            None => {
                let deflections = memory.bonds.iter().map(|bond| contact.position - S::held(bond.anchor));
                deflections.fold(S::zero(), |sum, deflection| sum + deflection) * self.stiffness
            }
        };
        dry + contact.velocity * self.viscous
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
        let Some(Window { start, end, least_speed, .. }) = memory.window else {
            let deflections = memory.bonds.iter().map(|bond| (contact.position - bond.anchor).abs());
            out[Event::Distance] = limit(self.strength(contact)) - deflections.fold(S::zero(), S::max);
            return;
        };
        let direction = sign((end - start).value());
        out[Event::Distance] = (end - contact.position) * direction;
        out[Event::Stop] = contact.velocity * direction - least_speed;
    }

    fn switch<S: Varying>(
        &self,
        _event: Event,
        contact: &Contact<S>,
        _v: &mut S,
        _z: &mut [S],
        memory: &mut Memory<S>,
    ) {
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
fn limit<S: Scalar>(strength: S) -> S {
    strength * (1.0 - 1e-12)
}

impl<S: Scalar> Bond<S> {
    /// Breaks if it is stretched to its limit, until it holds.
    fn renew(&mut self, x: S, strength: S) {
        let side = |stretch: S| 1.0f64.copysign(stretch.value());
        let stretch = x - self.anchor;
        if stretch.value().abs() > 2.0 * strength.value() {
            self.anchor = x - strength * side(stretch);
        }
        while (x - self.anchor).value().abs() >= limit(strength).value() {
            self.anchor += strength * random::uniform(&mut self.generator) * side(x - self.anchor);
        }
    }

    /// Moves the bristle along a path; returns its mean deflection on the way.
    fn travel(&mut self, start: S, end: S, strength: S) -> S {
        /// Bonds forget the past within a few deflections; of a longer path the rest is followed.
        const LONGEST: f64 = 100.0;
        let direction = sign((end - start).value());
        let path = (end - start).abs().min(strength * LONGEST);
        if path.value() == 0.0 {
            return end - self.anchor;
        }
        let mut deflection = (start - self.anchor) * direction;
        let (mut left, mut area) = (path, S::zero());
        while (deflection + left).value() >= limit(strength).value() {
            // A bond that was stronger when it formed may be stretched beyond the present strength.
            let stretch = (strength - deflection).max(S::zero());
            area += stretch * (deflection + stretch * 0.5);
            left -= stretch;
            deflection = strength * (1.0 - random::uniform(&mut self.generator));
        }
        area += left * (deflection + left * 0.5);
        self.anchor = end - (deflection + left) * direction;
        area * direction / path
    }
}

impl Bristle {
    /// Deflection in m at which bonds break under the present load.
    fn strength<S: Scalar>(&self, contact: &Contact<S>) -> S {
        /// Bonds of no strength at all would break without end.
        const LEAST_LEVEL: f64 = 1e-6;
        contact.level.max(S::of(LEAST_LEVEL)) * self.strength
    }

    /// The window that begins here, if the bonds break fast.
    fn window_ahead<S: Scalar>(&self, contact: &Contact<S>, bonds: &[Bond<S>]) -> Option<Window<S>> {
        const FEWEST_BREAKS: f64 = 4.0;
        let (path, strength) = (contact.velocity * self.window, self.strength(contact));
        if path.value().abs() * 2.0 * bonds.len() as f64 <= FEWEST_BREAKS * strength.value() {
            return None;
        }
        let (start, end) = (contact.position, contact.position + path);
        let means = bonds.iter().copied().map(|mut bond| bond.travel(start, end, strength));
        let sum = means.fold(S::zero(), |sum, mean| sum + mean);
        Some(Window { start, end, least_speed: contact.velocity.abs() * 0.5, mean: sum * self.stiffness })
    }
}

#[cfg(test)]
mod tests {
    use super::Bond;
    use crate::numbers::{Real, Scalar};

    /// A load that drops leaves bonds that are stretched to many times what they now hold. They form anew on the side from which
    /// they are pulled, less than one strength away, so that friction does not push.
    #[test]
    fn bond_that_breaks_far_beyond_its_strength_is_still_pulled_the_same_way() {
        const STRENGTH: f64 = 1e-5;
        for generator in 0..100 {
            for stretch in [-1e3, -2.5, 2.5, 1e3] {
                let mut bond = Bond { anchor: Real::of(0.0), generator };
                let x = stretch * STRENGTH;
                bond.renew(Real::of(x), Real::of(STRENGTH));
                let pull = (x - bond.anchor.value) * x.signum();
                assert!((0.0..STRENGTH).contains(&pull), "{stretch} times its strength leaves {pull} m");
            }
        }
    }
}
