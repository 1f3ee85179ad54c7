//! Times single calls with criterion: `cargo bench --package benchmark --features calls --bench calls`.

use std::hint::black_box;

use benchmark::case::{self, Case, STEP, inputs, voltage};
use benchmark::host::Host;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::{Const, DimMin, SMatrix, SVector};
use pneumatic_servo::model::{Seeds, Start};
use pneumatic_servo::models::pneumatic_servo_cylinder::PneumaticServoCylinder;
use pneumatic_servo::prelude::{Real, Scalar};
use pneumatic_servo::session::build;
use pneumatic_servo::solver::Inverse;
use pneumatic_servo::system::System;

const TOLERANCE: f64 = 1e-6;

/// A right-hand side, a Jacobian and its linear systems at the initial state, with the carriage sliding.
fn equations(criterion: &mut Criterion) {
    for case in case::all() {
        let inputs = inputs();
        let start =
            Start { time: 0.0, parameters: &case.parameters, inputs: &inputs, tolerance: None, seeds: Seeds::NONE };
        let (system, _) = build::<PneumaticServoCylinder, 3>(&start).expect("legal parameters");
        match system.states() {
            8 => time_equations::<8>(criterion, &case),
            9 => time_equations::<9>(criterion, &case),
            10 => time_equations::<10>(criterion, &case),
            11..=12 => time_equations::<12>(criterion, &case),
            _ => time_equations::<18>(criterion, &case),
        }
    }
}

fn time_equations<const N: usize>(criterion: &mut Criterion, case: &Case)
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    let moving = case.clone().with("velocity0", 0.05);
    let u = [6.0, 0.0, 5e5];
    let start = Start { time: 0.0, parameters: &moving.parameters, inputs: &u, tolerance: None, seeds: Seeds::NONE };
    let (system, _) = build::<PneumaticServoCylinder, 3>(&start).expect("legal parameters");
    let (x, memory) = system.start::<Real, N>(&Real::all(&u));
    criterion.bench_function(&format!("right-hand side/{}", case.name), |bencher| {
        bencher.iter(|| {
            let (time, u) = (Real::of(black_box(0.0)), Real::all(black_box(&u)));
            system.derivatives(time, black_box(&x), &u, black_box(&memory))
        });
    });
    let x = x.map(Real::value);
    let mut jacobian = SMatrix::<f64, N, N>::zeros();
    criterion.bench_function(&format!("Jacobian/{}", case.name), |bencher| {
        bencher.iter(|| {
            let (x, u, memory) = (black_box(&x), black_box(&u), black_box(&memory));
            system.jacobian(black_box(0.0), x, u, memory, &mut jacobian.data.0)
        });
    });
    let derivatives = system.jacobian(0.0, &x, &u, &memory, &mut jacobian.data.0);
    criterion.bench_function(&format!("linear systems, solver/{}", case.name), |bencher| {
        bencher.iter(|| by_inverse(black_box(&jacobian), black_box(derivatives)));
    });
    criterion.bench_function(&format!("linear systems, LU of nalgebra/{}", case.name), |bencher| {
        bencher.iter(|| by_lu(black_box(&jacobian), black_box(derivatives).into()));
    });
}

/// Solutions of linear systems in a step.
const STAGES: usize = 6;
/// Shift of the diagonal by a step of about 1 ms, in 1/s.
const SHIFT: f64 = 4000.0;

fn by_inverse<const N: usize>(jacobian: &SMatrix<f64, N, N>, right: [f64; N]) -> [f64; N] {
    // Known when compiling, as in the solver.
    let groups = const { <PneumaticServoCylinder as System<3>>::GROUPS };
    let inverse = Inverse::new(jacobian, SHIFT, groups, false).expect("no pivot is zero");
    (0..STAGES).fold(right, |solution, _| inverse.times(&solution, groups))
}

fn by_lu<const N: usize>(jacobian: &SMatrix<f64, N, N>, right: SVector<f64, N>) -> SVector<f64, N>
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    let factors = (SMatrix::identity() * SHIFT - jacobian).lu();
    (0..STAGES).fold(right, |solution, _| factors.solve(&solution).expect("no pivot is zero"))
}

/// A communication step of 1 ms with a new input sample.
fn steps(criterion: &mut Criterion) {
    for case in case::all() {
        let mut host = Host::start(&case, TOLERANCE);
        let mut index = 0;
        criterion.bench_function(&format!("fmi2DoStep/{}", case.name), |bencher| {
            bencher.iter(|| {
                host.step(voltage(f64::from(index) * STEP), STEP);
                index += 1;
            });
        });
    }
}

/// A run of 10 s, made of communication steps of 1 ms.
fn runs(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("10 s");
    group.sample_size(10);
    for case in case::compared() {
        group.bench_function(&case.name, |bencher| {
            let run = |mut host: Host| (0..10_000).for_each(|index| host.step(voltage(f64::from(index) * STEP), STEP));
            bencher.iter_batched(|| Host::start(&case, TOLERANCE), run, BatchSize::PerIteration);
        });
    }
}

/// Making an instance ready to step, and saving and restoring its state.
fn instances(criterion: &mut Criterion) {
    for case in case::compared() {
        criterion.bench_function(&format!("instantiate, initialize, free/{}", case.name), |bencher| {
            bencher.iter(|| Host::start(&case, TOLERANCE));
        });
        let mut host = Host::start(&case, TOLERANCE);
        host.step(6.0, STEP);
        criterion.bench_function(&format!("save, restore, free/{}", case.name), |bencher| {
            bencher.iter(|| host.restore(host.save()));
        });
    }
}

criterion_group!(benches, equations, steps, runs, instances);
criterion_main!(benches);
