//! `cargo run --features package --example package` makes the sources in C.

pneumatic_servo_packaging::package_loop!(own_loop::CYLINDER);
