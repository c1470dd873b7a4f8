use super::*;

fn line() -> Vec<Cell> { Vec::new() }
#[test]
fn nothing() { assert_eq!(fit(&line(), &Settings::default()), Err(FitError::NoCells)); }
