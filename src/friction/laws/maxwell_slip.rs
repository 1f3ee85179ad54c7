//! Maxwell slip: parallel spring-slider elements with constant limits.

use serde::{Deserialize, Serialize};

use crate::friction::event::{Event, Indicators};
use crate::friction::law::{Contact, Drive, FrictionLaw};
use crate::friction::parts::elements::{self, Load, MAX_ELEMENTS, Modes};
use crate::friction::parts::parameters::{force, stiffness, viscous};
use crate::numbers::{Scalar, Varying};
use crate::parameters;
use crate::variables::{Tunable, counted_by};

parameters! {
    /// Maxwell-slip friction of up to ten elements: rate-independent hysteresis with non-local memory, without drift.
    ///
    /// ```text
    /// stick:  F_i = k_i*(x - a_i)        until |F_i| = lambda*W_i under growing load          [N]
    /// slip:   F_i = lambda*W_i*sgn(v)    until v = 0, where a_i = x - F_i/k_i                 [N]
    /// F = sum F_i + sigma2*v                                                                  [N]
    /// ```
    ///
    /// No continuous state: the anchors `a_i` (in m) are a memory, and forces follow the position exactly however often a
    /// cycle is repeated. Sliding force `sum W_i`; no stiction peak.
    ///
    /// # Validity
    /// Positions of about 1 m resolve the forces to `1e-16 m * k_i`. An element whose limit falls below its force slides
    /// along the limit; the anchor is then moved after each solver step.
    ///
    /// # Source
    /// Iwan (1966), ASME J. Applied Mechanics 33(4):893-900.
    MaxwellSlip {
        viscous: Tunable = viscous(30.0);
        count: usize = elements::count(4);
        stiffness: [Tunable; MAX_ELEMENTS] = counted_by("N", stiffness(10, "k", 1e5).text("Stiffness of an element")
            .array([8e5, 4e5, 2e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5, 1e5]));
        limit: [Tunable; MAX_ELEMENTS] = counted_by("N", force(20, "W", 0.0).text("Largest force of an element")
            .array([2.075, 2.075, 2.075, 2.075, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    }
}

/// Deflection of a spring beyond its limit before its element slips: in roundings of the position, and relative to the
/// deflection at the limit.
const RESOLVED: f64 = 4.0;
const BEYOND: f64 = 1e-11;

/// Modes of the elements, and where their springs are anchored while they stick, in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<S> {
    modes: Modes,
    anchors: [S; MAX_ELEMENTS],
}

impl FrictionLaw for MaxwellSlip {
    type Memory<S: Varying> = Memory<S>;

    fn events(&self) -> &'static [Event] {
        &[Event::Stop, Event::BreakAway]
    }

    fn follows(&self) -> &'static [Drive] {
        &[Drive::Force, Drive::Motion]
    }

    fn is_non_stiff(&self) -> bool {
        true
    }

    fn start<S: Varying>(&self, contact: &Contact<S>) -> Memory<S> {
        Memory { modes: Modes::default(), anchors: [contact.position; MAX_ELEMENTS] }
    }

    fn force<S: Scalar>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S::Held>, _rates: &mut [S]) -> S {
        let elements = (0..self.count).map(|element| self.element_force(element, contact, memory));
        elements.fold(contact.velocity * self.viscous, |sum, force| sum + force)
    }

    fn indicators<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &Memory<S>, out: &mut Indicators<S>) {
        memory.modes.indicators(contact.velocity, self.loads(contact, memory), out);
    }

    fn switch<S: Varying>(&self, event: Event, contact: &Contact<S>, _v: &mut S, _z: &mut [S], memory: &mut Memory<S>) {
        if event == Event::Stop {
            for element in 0..self.count {
                if memory.modes.slip(element).is_some() {
                    let force = self.element_force(element, contact, memory);
                    memory.anchors[element] = contact.position - force / self.stiffness[element];
                }
            }
            memory.modes.stick();
        } else {
            let mut modes = memory.modes.clone();
            modes.slip_next(contact.velocity, self.loads(contact, memory));
            memory.modes = modes;
        }
    }

    fn follow<S: Varying>(&self, contact: &Contact<S>, _z: &[S], memory: &mut Memory<S>) -> bool {
        let mut has_changed = false;
        for element in 0..self.count {
            if memory.modes.slip(element).is_some() {
                continue;
            }
            let force = self.spring_force(element, contact, memory).value();
            let limit = contact.level * self.limit[element];
            if limit.value() == 0.0 || (force.abs() > limit.value() && force * contact.velocity.value() <= 0.0) {
                let side = 1.0f64.copysign(force);
                memory.anchors[element] = contact.position - limit * side / self.stiffness[element];
                has_changed = true;
            }
        }
        has_changed
    }
}

impl MaxwellSlip {
    fn element_force<S: Scalar>(&self, element: usize, contact: &Contact<S>, memory: &Memory<S::Held>) -> S {
        let limit = contact.level * self.limit[element];
        match memory.modes.slip(element) {
            _ if limit.value() == 0.0 => S::zero(),
            Some(direction) => limit * direction,
            None => self.spring_force(element, contact, memory).clamp(-limit, limit),
        }
    }

    fn spring_force<S: Scalar>(&self, element: usize, contact: &Contact<S>, memory: &Memory<S::Held>) -> S {
        (contact.position - S::held(memory.anchors[element])) * self.stiffness[element]
    }

    /// The load of an element that sticks; one without any strength has no events.
    ///
    /// It slips once the position resolves that the limit is passed, and holds the limit until then. A carriage that comes to rest
    /// against a stop with springs at their limits changes the sign of its velocity with the rounding of the forces; no element
    /// slips for that.
    fn load<S: Varying>(&self, element: usize, contact: &Contact<S>, memory: &Memory<S>) -> Load<S> {
        let limit = contact.level * self.limit[element];
        if limit.value() == 0.0 {
            return Load { force: S::zero(), limit: S::of(1.0) };
        }
        let resolution = f64::EPSILON * contact.position.value().abs().max(memory.anchors[element].value().abs());
        let rounding = RESOLVED * resolution * self.stiffness[element].value;
        Load { force: self.spring_force(element, contact, memory), limit: limit * (1.0 + BEYOND) + rounding }
    }

    fn loads<'a, S: Varying>(
        &'a self,
        contact: &'a Contact<S>,
        memory: &'a Memory<S>,
    ) -> impl Iterator<Item = Load<S>> + Clone + 'a {
        (0..self.count).map(|element| self.load(element, contact, memory))
    }
}
