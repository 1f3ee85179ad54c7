//! Names of the roles of the table, in the schema of either version of the standard.

/// Declares the causality and the variability that a variable must have, with the names of a schema.
macro_rules! in_schema {
    ($($schema:ident)::+) => {
        fn causality(variable: &Variable) -> $($schema)::+::Causality {
            use $($schema)::+::Causality;
            match variable.role {
                Role::Time => Causality::Independent,
                Role::Input => Causality::Input,
                Role::Fixed | Role::Tunable => Causality::Parameter,
                Role::Output => Causality::Output,
                Role::Local => Causality::Local,
            }
        }

        fn variability(variable: &Variable) -> $($schema)::+::Variability {
            use $($schema)::+::Variability;
            match (variable.role, variable.kind) {
                (Role::Fixed, _) => Variability::Fixed,
                (Role::Tunable, _) => Variability::Tunable,
                (_, Kind::Real(_)) => Variability::Continuous,
                _ => Variability::Discrete,
            }
        }
    };
}

pub(crate) use in_schema;
