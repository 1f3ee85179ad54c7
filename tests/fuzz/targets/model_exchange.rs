#![no_main]

mod linked;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| linked::run(|| calls::given::model_exchange(bytes)));
