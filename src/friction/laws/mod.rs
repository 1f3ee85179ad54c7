//! The laws, one file each.

pub mod armstrong;
pub mod bliman_sorine;
pub mod bristle;
pub mod coulomb;
pub mod coulomb_stiction;
pub mod dahl;
pub mod dnlrx;
pub mod elasto_plastic;
pub mod gms;
pub mod karnopp;
pub mod leuven;
pub mod lugre;
pub mod maxwell_slip;
pub mod none;
pub mod polito;
pub mod reset_integrator;
pub mod revised_lugre;
pub mod sine_regularised;
pub mod smooth_coulomb;
pub mod step_regularised;
pub mod stick_slip_creep;
pub mod stick_slip_spring;
pub mod stribeck_law;
pub mod stribeck_regularised;
pub mod table;
pub mod velocity_based;
