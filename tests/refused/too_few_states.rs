//! the model has more states than the library is to be compiled for

#[macro_use]
#[path = "shared/moving.rs"]
mod shared;

moving!(0, 0);
