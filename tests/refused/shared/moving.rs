//! A sound model but for what a file adds: its number of compiled states, its number of indicators, its events.

macro_rules! moving {
    ($states:expr, $indicators:expr $(, $event:expr)*) => {
        use pneumatic_servo::prelude::*;

        parameters! {
            /// None.
            Parameters {}
        }

        states! {
            /// A position.
            State of Parameters {
                Position: 10, |_| 1.0;
            }
        }

        outputs! {
            /// The position and its rate.
            Outputs {
                position = Variable::output(10, "position", units::METRE).depends_on(&[10]).text("Position");
                velocity = Variable::output(11, "velocity", units::METRE_PER_SECOND).derivative_of(10).text("Velocity");
            }
        }

        /// A body that moves at 1 m/s.
        #[derive(Clone)]
        struct Moving(Parameters);

        impl System<0> for Moving {
            type Parameters = Parameters;
            type State = State;
            type Memory<S: Varying> = ();
            type Indicators<S: Varying> = [S; $indicators];

            const EVENTS: &'static [Event] = &[$($event),*];

            fn tables() -> Tables {
                Tables { inputs: Vec::new(), computed: Outputs::<f64>::table(), parameters: Parameters::table() }
            }

            fn new(values: &mut Values) -> Result<Self, ParameterError> {
                Ok(Self(values.read()?))
            }

            fn parameters(&self) -> &Parameters {
                &self.0
            }

            fn start<S: Varying, const N: usize>(&self, _u: &[S; 0]) -> ([S; N], ()) {
                ([S::zero(); N], ())
            }

            fn derivatives<S: Scalar, const N: usize>(&self, _time: S, _x: &[S; N], _u: &[S; 0], _memory: &()) -> [S; N] {
                [S::constant(1.0); N]
            }

            fn indicators<S: Varying, const N: usize>(&self, _time: S, x: &[S; N], _u: &[S; 0], _memory: &()) -> [S; $indicators] {
                [-State::Position.get(x) + 1.0; $indicators]
            }

            fn outputs<S: Scalar, const N: usize>(&self, _time: S, x: &[S; N], _u: &[S; 0], _memory: &(), computed: &mut [S]) {
                Outputs { position: State::Position.get(x), velocity: S::constant(1.0) }.write(computed);
            }
        }

        pub const MODEL: Model = Model::of::<Moving, 0, $states>(
            "Moving",
            "What moves",
            Experiment { stop_time: 1.0, step_size: 0.1, signals: &[], panels: &[] },
        );

        fn main() {
            let _ = MODEL;
        }
    };
}
