//! The shared library of the built-in FMUs: every model of [`pneumatic_servo`].

pneumatic_servo_fmu::export_fmu!(pneumatic_servo::models::ALL);
