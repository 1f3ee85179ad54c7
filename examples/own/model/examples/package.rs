//! Packs the FMU of the quarter car: `cargo run --features package --example package`.

pneumatic_servo_packaging::package_fmus!(quarter_car::LIBRARY);
