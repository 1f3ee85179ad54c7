//! The shared library of `FrictionObserver.fmu`, a library of its own: of all FMUs, only this one needs derivatives along runs.

pneumatic_servo_fmu::export_fmu!(&[pneumatic_servo::models::friction_observer::MODEL]);
