//! The shared library of `FrictionObserver.fmu`, apart from that of the other FMUs: it alone has derivatives along runs.

pneumatic_servo_fmu::export_fmu!(&[pneumatic_servo::models::friction_observer::MODEL]);
