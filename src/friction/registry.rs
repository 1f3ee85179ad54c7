//! The laws of this library: one line for each.

use super::laws as builtin;
use super::parts::of_velocity::OfVelocity;
use super::parts::one_bristle::OneBristle;
use super::parts::stick_slip::StickSlip;

/// The catalogue of the laws of this library, with further lines behind them.
#[doc(hidden)]
#[macro_export]
macro_rules! builtin_laws {
    ($($own:tt)*) => {
        $crate::law_items! {
            1 None "none" OfVelocity<builtin::none::NoFriction>, "No friction";
            2 Coulomb "coulomb" StickSlip<builtin::coulomb::Coulomb>, "Constant kinetic friction, true stiction at the same force";
            3 CoulombStiction "coulombStiction" StickSlip<builtin::coulomb_stiction::CoulombStiction>, "Coulomb friction with a higher break-away force";
            4 SmoothCoulomb "smoothCoulomb" OfVelocity<builtin::smooth_coulomb::SmoothCoulomb>, "Coulomb friction smoothed by a hyperbolic tangent (creeps)";
            5 VelocityBased "velocityBased" OfVelocity<builtin::velocity_based::VelocityBased>, "Magic-formula curve through zero with Stribeck peak (creeps)";
            6 StribeckRegularised "stribeckRegularised" OfVelocity<builtin::stribeck_regularised::StribeckRegularised>, "Stribeck curve with a linear part through zero (creeps)";
            7 Stribeck "stribeck" builtin::stribeck_law::Stribeck, "Stribeck curve with true stiction";
            8 Karnopp "karnopp" builtin::karnopp::Karnopp, "Stribeck curve with a zero-velocity band that holds the mass";
            9 Polito "polito" builtin::polito::Polito, "Different Stribeck curves while accelerating and decelerating, true stiction";
            10 Dahl "dahl" OneBristle<builtin::dahl::Dahl>, "Bristle with rate-independent presliding, no stiction peak";
            11 Bristle "bristle" builtin::bristle::Bristle, "Bonds that break and form at random";
            12 ResetIntegrator "resetIntegrator" OneBristle<builtin::reset_integrator::ResetIntegrator>, "Bond that yields at a limit, with stiction peak, without drift";
            13 Armstrong "armstrong" builtin::armstrong::Armstrong, "Spring while sticking, Stribeck friction with dwell time and delay while sliding";
            14 LuGre "lugre" OneBristle<builtin::lugre::LuGre>, "Bristle with presliding, Stribeck effect and frictional lag";
            15 Leuven "leuven" OneBristle<builtin::leuven::Leuven>, "Hysteresis with nested loops and non-local memory, blended into a Stribeck curve";
            16 GMS "gms" builtin::gms::Gms, "Maxwell-slip elements with Stribeck effect, frictional lag and non-local memory";
            17 MaxwellSlip "maxwellSlip" builtin::maxwell_slip::MaxwellSlip, "Spring-slider elements: rate-independent hysteresis without drift";
            18 DNLRX "dnlrx" builtin::dnlrx::Dnlrx, "Sampled Maxwell-slip springs through impulse responses";
            19 BlimanSorine "blimanSorine" builtin::bliman_sorine::BlimanSorine, "Difference of two Dahl elements: stiction peak as a function of the path";
            20 ElastoPlastic "elastoPlastic" OneBristle<builtin::elasto_plastic::ElastoPlastic>, "Bristle with a purely elastic range: presliding without drift, Stribeck effect";
            21 StepRegularised "stepRegularised" OfVelocity<builtin::step_regularised::StepRegularised>, "Static peak and kinetic friction as cubic steps of velocity (creeps)";
            22 SineRegularised "sineRegularised" OfVelocity<builtin::sine_regularised::SineRegularised>, "Static peak and kinetic friction as half sine waves of velocity (creeps)";
            23 StickSlipSpring "stickSlipSpring" builtin::stick_slip_spring::StickSlipSpring, "Spring-damper while sticking, Coulomb friction while sliding";
            24 StickSlipCreep "stickSlipCreep" OneBristle<builtin::stick_slip_creep::StickSlipCreep>, "Bounded stiction displacement at low speed, Coulomb friction at high speed";
            25 Table "table" StickSlip<builtin::table::Table>, "Friction by measured points over speed, for each direction, with true stiction";
            26 RevisedLuGre "revisedLuGre" builtin::revised_lugre::RevisedLuGre, "Bristle on a lubricant film that lags behind the velocity and outlasts a stop";
            $($own)*
        }
    };
}

builtin_laws! {}
