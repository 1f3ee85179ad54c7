//! Packs the FMU of the observer.

pneumatic_servo_packaging::package_fmus!(pneumatic_servo_observer::LIBRARY);
