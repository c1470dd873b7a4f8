//! Every check of every topic meets its bound: what `cargo xtask verify` prints.

use gfmd_tests::{Reference, TOPICS, ValidationError};

fn holds(topic: usize) {
    let checks = (TOPICS[topic].checks)(&Reference::default()).unwrap();
    assert!(!checks.is_empty());
    let failed: Vec<String> = checks.iter().filter(|check| !check.passes()).map(|check| format!("{check:?}")).collect();
    assert!(failed.is_empty(), "{}:\n{}", TOPICS[topic].title, failed.join("\n"));
}

// One test each, so that they run side by side.
#[test]
fn limits_of_the_stiffness() {
    holds(0);
}

#[test]
fn stiffness_and_compliance() {
    holds(1);
}

#[test]
fn fields_inside_the_body() {
    holds(2);
}

#[test]
fn flat_punches() {
    holds(3);
}

#[test]
fn damping() {
    holds(4);
}

#[test]
fn contacts_with_a_closed_form() {
    holds(5);
}

#[test]
fn contacts_that_other_programs_solved() {
    holds(6);
}

#[test]
fn adhesion_cohesion_friction() {
    holds(7);
}

#[test]
fn no_topic_is_left_out() {
    assert_eq!(TOPICS.len(), 8, "each topic has its test above");
}

#[test]
fn a_missing_file_is_named() {
    let error = (TOPICS[1].checks)(&Reference::new("nowhere")).unwrap_err();
    assert!(matches!(&error, ValidationError::Reference { file, .. } if file.contains("slab_kernel_2d.json")));
}
