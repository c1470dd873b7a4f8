//! The checks of the topics; `cargo xtask verify`, with its tests, runs all of them.

use std::collections::BTreeSet;

use gfmd_tests::{Reference, TOPICS, ValidationError};

#[test]
fn each_topic_has_its_own_name() {
    assert_eq!(TOPICS.iter().map(|topic| topic.name).collect::<BTreeSet<_>>().len(), TOPICS.len());
}

#[test]
fn a_missing_file_is_named() {
    let kernels = TOPICS.iter().find(|topic| topic.name == "kernels").unwrap();
    let error = (kernels.checks)(&Reference::new("nowhere")).unwrap_err();
    assert!(matches!(&error, ValidationError::Reference { file, .. } if file.contains("slab_kernel_2d.json")));
}
