//! The library as it is linked here, where what it reaches is counted.

use pneumatic_servo_builtin::{FMI2, FMI3};

/// Makes calls of the linked library.
pub fn run(work: impl FnOnce()) {
    calls::given::of(&FMI2, &FMI3, work);
}
