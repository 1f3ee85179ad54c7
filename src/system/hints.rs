//! Hints for the solver, as data.

use super::LongestSteps;

/// Facts about the equations in the present mode that a solver may use. They change results by rounding and the tolerance
/// only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    /// The longest steps of explicit methods where accuracy, and not stability, bounds them: a non-stiff mode. It may be wrong for
    /// some parameters; steps then cost more, but are as accurate. Worth a factor of two to four: an explicit step of the cylinder
    /// takes 4,300 instructions, an implicit one with its Jacobian 8,100.
    pub explicit: Option<LongestSteps>,
    /// Whether something changes faster now than the error estimate of the explicit method can tell, such as a flow through a
    /// valve that opens within a step. The difference from the midpoint rule then counts, too.
    pub is_fast: bool,
    /// Whether states are coupled as in a chain: most of them not at all. Matrices are then inverted as a whole, where zeros are
    /// skipped, in place of by [`GROUPS`](super::System::GROUPS), and explicit steps are cheaper beside implicit ones.
    pub is_chain: bool,
}
