//! Shared by the validation tests: where the reference data lie and how they are read.
