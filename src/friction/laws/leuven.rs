//! The modified Leuven law: hysteresis with nested loops, blended into the Stribeck curve.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive};
use crate::friction::parts::curve::StribeckCurve;
use crate::friction::parts::fading::{divisor, fading_rate};
use crate::friction::parts::list::List;
use crate::friction::parts::one_bristle::BristleLaw;
use crate::friction::parts::parameters::{damping, force, stiffness, viscous};
use crate::numbers::{Scalar, Varying, sign};
use crate::parameters;
use crate::variables::{ParameterError, Tunable, Variable, units};

parameters! {
    /// Modified Leuven friction: one state, the deflection `z` in m, and the points at which `z` has turned.
    ///
    /// ```text
    /// F     = F_h(z) + sigma1*dz/dt + sigma2*v                                 [N]
    /// dz/dt = v*(1 - sgn(q)*|q|^n),   q = F_h*sgn(v)/s(v), s the Stribeck curve  [m/s]
    /// y(z)  = k1*z + lambda*f1*(1 - exp(-f2*z))   odd in z: the virgin curve   [N]
    /// F_h   = y(z) at first, and F_h(z_r) + 2*y((z - z_r)/2) after z has turned at z_r
    /// ```
    ///
    /// When a branch reaches the turning point before the last (or, from the first one, its mirror image), the loop in
    /// between is closed and forgotten, and the branch that it interrupted goes on. At constant `v != 0`,
    /// `F -> s(v)*sgn(v) + sigma2*v`, unless the hysteresis saturates below `s`.
    ///
    /// # Validity
    /// `F_h` is a function of `z` without drift; `x` still drifts under oscillating loads unless `n` is large, since `z`
    /// follows `x` only in part.
    ///
    /// Passive at a constant load factor. `F_h` is the force of a spring `k1` and of infinitely many springs side by side, of the
    /// stiffness `lambda*f1*f2^2*exp(-f2*b)*db` each, that follow `z` up to a deflection `b` and then slip. With their
    /// deflections `e_b` the stored energy is
    ///
    /// ```text
    /// E = k1*z^2/2 + lambda*f1*f2^2/2*integral(e_b^2*exp(-f2*b) db)                    [J]
    ///   = k1*z^2/2 + lambda*f1/f2*(1 - (1 + f2*|z|)*exp(-f2*|z|))                      on the virgin curve
    /// ```
    ///
    /// A level that grows makes bent springs stiffer: the load, not the motion, then brings the second part of `E`, at most
    /// `lambda*f1/f2`, 1e-5 J with the defaults at level 1.
    ///
    /// Turning points are kept as positions, so that all loops scale with the load factor.
    /// A retreat of `z` slower than 1e-9 m/s plus a millionth of `v` does not count as a reversal: in steady sliding `z` is
    /// at rest only to rounding. The stack holds 128 turning points. When it is full, the loop that differs least from its
    /// neighbours is forgotten; when the one around it closes, the force jumps by the little that it had contributed (less
    /// than 0.1 % of `f1` after a thousand loops in 2 um). Where `s` falls to 0, within the last micronewton, `z` goes to 0 and the hysteresis starts anew.
    ///
    /// # Errors
    /// [`ParameterError`] for `F_c > F_s`.
    ///
    /// # Source
    /// Swevers, Al-Bender, Ganseman, Prajogo (2000), IEEE Trans. Automatic Control 45(4):675-686;
    /// Lampaert, Swevers, Al-Bender (2002), IEEE Trans. Automatic Control 47(4):683-687.
    Leuven {
        curve: StribeckCurve = StribeckCurve::variables();
        viscous: Tunable = viscous(30.0);
        transition: Tunable = Variable::parameter(5, "n", units::ONE, 1.0)
            .range(0.1, 10.0)
            .text("Transition exponent: the larger, the more abruptly presliding turns into sliding");
        stiffness: Tunable = stiffness(6, "k1", 1.483e6).text("Stiffness of the linear part of the hysteresis");
        hysteresis_force: Tunable = force(7, "f1", 5.595).text("Saturation force of the hysteresis");
        steepness: Tunable = Variable::parameter(8, "f2", units::PER_METRE, 5.631e5)
            .range(1e-3, 1e12)
            .text("Inverse length on which the hysteresis saturates");
        damping: Tunable = damping(9, "sigma1", 0.0).text("Bristle damping");
    }
}

/// A place where `z` has turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TurningPoint<S> {
    /// Deflection in m.
    z: S,
    /// Saturating part of the hysteresis force there, as a fraction of `lambda*f1`.
    saturation: S,
}

const CAPACITY: usize = 128;

/// Where `z` goes and where it has turned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
pub struct Memory<S: Varying> {
    /// Direction of `z`, +1 or -1; 0 before it has moved.
    direction: f64,
    /// The last one belongs to the present branch.
    turned: List<TurningPoint<S>, CAPACITY>,
}

impl<S: Varying> Memory<S> {
    /// Deflection at which the present branch closes a loop.
    fn closure(&self) -> Option<S> {
        match &*self.turned {
            [] => None,
            [first] => Some(-first.z),
            [.., before, _] => Some(before.z),
        }
    }

    /// Turns at a point; if there is no room for it, a loop is forgotten.
    fn turn(&mut self, point: TurningPoint<S>) {
        if self.turned.len() == CAPACITY {
            self.forget_slightest_loop();
        }
        self.turned.push(point);
        self.direction = -self.direction;
    }

    /// Forgets the two points without which the branches change least: those that almost repeat their neighbours.
    fn forget_slightest_loop(&mut self) {
        let z = |index: usize| self.turned[index].z.value();
        let change = |first: usize| (z(first) - z(first + 2)).abs() * (z(first - 1) - z(first + 1)).abs();
        let slightest = (1..CAPACITY - 2).min_by(|a, b| change(*a).total_cmp(&change(*b))).unwrap_or(1);
        self.turned.remove(slightest..slightest + 2);
    }

    /// Forgets the innermost loop.
    fn close_loop(&mut self) {
        let len = self.turned.len();
        self.turned.remove(len.saturating_sub(2)..len);
    }
}

impl BristleLaw for Leuven {
    type Memory<S: Varying> = Memory<S>;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::Distance]
    }

    fn follows(&self) -> &'static [Drive] {
        &[Drive::Force, Drive::Motion]
    }

    fn check(&self) -> Result<(), ParameterError> {
        self.curve.check()
    }

    fn is_non_stiff(&self) -> bool {
        self.curve.is_non_stiff()
    }

    fn scale(&self) -> f64 {
        self.curve.static_force.value.max(1.0) / (self.stiffness + self.hysteresis_force * self.steepness).value
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, z: S, memory: &Memory<S::Held>) -> (S, S) {
        let hysteresis = self.hysteresis(z, contact.level, memory);
        let limit = self.limit(contact);
        let rate = self.rate(contact, limit, hysteresis) + fading_rate(z, limit);
        (hysteresis + rate * self.damping + contact.velocity * self.viscous, rate)
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, z: S, memory: &Memory<S>, out: &mut Indicators<S>) {
        const DEAD_BAND: f64 = 1e-9; // m/s
        const RELATIVE_DEAD_BAND: f64 = 1e-6;
        if memory.direction != 0.0 {
            let hysteresis = self.hysteresis(z, contact.level, memory);
            let rate = self.rate(contact, self.limit(contact), hysteresis);
            out[Event::Stop] = rate * memory.direction + (contact.velocity.abs() * RELATIVE_DEAD_BAND + DEAD_BAND);
        }
        if let Some(closure) = memory.closure() {
            out[Event::Distance] = (closure - z) * memory.direction;
        }
    }

    fn switch<S: Varying>(&self, event: Event, _contact: &Contact<S>, z: &mut S, memory: &mut Memory<S>) {
        if event == Event::Stop {
            memory.turn(TurningPoint { z: *z, saturation: self.saturation(*z, memory) });
        } else {
            memory.close_loop();
        }
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, z: S, memory: &mut Memory<S>) -> bool {
        if self.limit(contact).value() <= 0.0 {
            *memory = Memory::default();
            return true;
        }
        if memory.direction == 0.0 {
            memory.direction = sign(z.value());
        }
        false
    }
}

impl Leuven {
    /// The Stribeck curve at the present speed.
    fn limit<S: Scalar>(&self, contact: &Contact<S>) -> S {
        self.curve.at(contact.velocity.abs(), contact.level)
    }

    /// Rate of `z` at a limit, and at a hysteresis force.
    fn rate<S: Scalar>(&self, contact: &Contact<S>, limit: S, hysteresis: S) -> S {
        let v = contact.velocity;
        let q = hysteresis * sign(v.value()) / divisor(limit);
        v * (limit / divisor(limit) - q.abs().pow(self.transition) * sign(q.value()))
    }

    /// The hysteresis force `F_h` in N.
    fn hysteresis<S: Scalar>(&self, z: S, level: S, memory: &Memory<S::Held>) -> S {
        z * self.stiffness + level * self.saturation(z, memory) * self.hysteresis_force
    }

    /// The saturating part of `F_h` on the present branch, as a fraction of `lambda*f1`.
    fn saturation<S: Scalar>(&self, z: S, memory: &Memory<S::Held>) -> S {
        match memory.turned.last() {
            None => self.virgin_saturation(z),
            Some(turn) => self.virgin_saturation((z - S::held(turn.z)) * 0.5) * 2.0 + S::held(turn.saturation),
        }
    }

    /// `1 - exp(-f2*z)`, odd in `z`.
    fn virgin_saturation<S: Scalar>(&self, z: S) -> S {
        let (Tunable { value: steepness, .. }, value) = (self.steepness, z.value());
        let fall = libm::expm1(-steepness * value.abs());
        z.chain_with(-sign(value) * fall, steepness * (1.0 + fall), self.steepness, value * (1.0 + fall))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::Real;
    use crate::variables::ParameterSet;

    const AT_REST: Contact<f64> =
        Contact { time: 0.0, position: 0.0, velocity: 0.0, applied: 0.0, level: 1.0, drive: Drive::Force };

    /// The default law, moved along a path of `z` by its own events.
    struct Path {
        law: Leuven,
        memory: Memory<Real>,
        z: f64,
    }

    impl Path {
        fn new() -> Self {
            let starts = Leuven::table().into_iter().filter_map(|variable| variable.start);
            let defaults: Vec<_> = starts.map(Tunable::still).collect();
            let law = Leuven::read(&defaults).unwrap();
            Self { law, memory: Memory { direction: 1.0, ..Memory::default() }, z: 0.0 }
        }

        /// Moves `z` and returns the hysteresis force there.
        fn to(&mut self, z: f64) -> f64 {
            if (z - self.z) * self.memory.direction < 0.0 {
                self.law.switch(Event::Stop, &AT_REST.still(), &mut Real::of(self.z), &mut self.memory);
            }
            while self.memory.closure().is_some_and(|closure| self.memory.direction * (closure.value - z) < 0.0) {
                self.memory.close_loop();
            }
            self.z = z;
            self.force(z, 1.0)
        }

        fn force(&self, z: f64, level: f64) -> f64 {
            self.law.hysteresis(Real::of(z), Real::of(level), &self.memory).value
        }

        /// Turns back and forth between -2 um and 2 um, a little less far each time; returns the width left.
        fn nest(&mut self, turns: usize) -> f64 {
            let mut width = 2e-6;
            for turn in 0..turns {
                width *= 0.99;
                self.to(if turn % 2 == 0 { width } else { -width });
            }
            width
        }
    }

    /// `y(3 um)`, by hand.
    fn virgin_at_three_micrometres() -> f64 {
        1.483e6 * 3e-6 + 5.595 * (1.0 - (-5.631e5f64 * 3e-6).exp())
    }

    #[test]
    fn loops_nested_sixty_deep_close_exactly() {
        let mut path = Path::new();
        path.nest(120);
        assert_eq!(path.memory.turned.len(), 119);
        assert!((path.to(3e-6) - virgin_at_three_micrometres()).abs() < 1e-14);
        assert_eq!(path.memory.turned.len(), 0);
    }

    /// A thousand turns, each 1 % less wide. What is forgotten is missing when the loops around it close: a jump of less
    /// than 0.1 % of f1, and nothing once all have closed.
    #[test]
    fn full_stack_forgets_the_slightest_loops_only() {
        let mut path = Path::new();
        path.nest(1000);
        assert!(path.memory.turned.len() <= CAPACITY);
        let mut jump = 0.0f64;
        let mut last = path.force(path.z, 1.0);
        let from = path.z;
        for step in 1..=3000 {
            let z = from + f64::from(step) * 1e-9;
            let force = path.to(z);
            // The branches rise by at most 4.64e6 N/m.
            jump = jump.max((force - last).abs() - 4.64e6 * 1e-9);
            last = force;
        }
        assert!(jump < 5e-3, "{jump} N");
        assert!((path.to(3e-6) - virgin_at_three_micrometres()).abs() < 1e-14);
    }

    /// By how much two branches differ is the product of two retreats: of a long one and a hundred times shorter one less
    /// than of two that are five times shorter than the long one, though their sum is more than twice as large.
    #[test]
    fn slightest_loop_is_that_of_the_least_product() {
        let retreat = |index: usize| match index {
            60 => 1e-10,
            59 | 61 => 1e-8,
            _ => 2e-9,
        };
        let mut ends = [3e-6, -3e-6];
        let mut memory: Memory<Real> = Memory { direction: 1.0, ..Memory::default() };
        for index in 0..CAPACITY {
            memory.turned.push(TurningPoint { z: Real::of(ends[index % 2]), saturation: Real::of(0.0) });
            ends[index % 2] -= retreat(index) * sign(ends[index % 2]);
        }
        let before = memory.clone();
        memory.forget_slightest_loop();
        let is_left = |point: &TurningPoint<Real>| memory.turned.contains(point);
        let forgotten: Vec<_> = (0..CAPACITY).filter(|index| !is_left(&before.turned[*index])).collect();
        assert!(matches!(forgotten[..], [60, 61] | [61, 62]), "{forgotten:?}");
    }

    #[test]
    fn saved_stack_is_restored_and_a_longer_one_refused() {
        let mut path = Path::new();
        path.nest(7);
        let bytes = postcard::to_allocvec(&path.memory).unwrap();
        assert_eq!(postcard::from_bytes::<Memory<Real>>(&bytes).unwrap(), path.memory);
        let longer = postcard::to_allocvec(&(1.0, vec![TurningPoint::<Real>::default(); CAPACITY + 1])).unwrap();
        assert!(postcard::from_bytes::<Memory<Real>>(&longer).is_err());
    }

    /// The hysteresis scales with the level as a whole, so that loops close at any level.
    #[test]
    fn loops_close_without_a_jump_after_the_level_has_changed() {
        let mut path = Path::new();
        path.nest(2);
        path.to(1e-6);
        let closure = path.memory.closure().unwrap().value;
        let before = path.force(closure, 0.4);
        path.memory.close_loop();
        assert!((path.force(closure, 0.4) - before).abs() < 1e-14);
    }
}
